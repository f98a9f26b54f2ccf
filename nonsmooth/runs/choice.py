"""``integrator="auto"``: which integrator a system gets, and the reason in words.

The rules, in this order:

1. no contacts: EventDriven, which is of order 5 there and takes stiff forces;
2. few contacts, at most 6 with friction and 12 in all: EventDriven, which hands stretches of dense events to Adaptive;
3. up to 100 unilateral contacts without friction: Adaptive, whose every contact problem has one solution, found in a
   few pivots from the one before;
4. else MoreauJean, with the model's own ``dt``, where it has one, else a ten-thousandth of the span.

The modes of contacts that touch are enumerated at an event: with friction 7 contacts take 0.1 s, 9 take 2 s. A contact
problem of a stack with friction takes 10 ms, of which an impact needs a hundred with Adaptive, and one with MoreauJean.
"""

from __future__ import annotations

from typing import Any

from nonsmooth.integrators.adaptive import Adaptive
from nonsmooth.integrators.event_driven import EventDriven
from nonsmooth.integrators.moreau_jean import MoreauJean
from nonsmooth.runs.times import as_span
from nonsmooth.system import UNILATERAL, System

MOST_CONTACTS, MOST_WITH_FRICTION = 12, 6
MOST_WITHOUT_FRICTION = 100
FINE = Adaptive()  # for stretches of an event-driven run, with the same tolerances
COARSE = Adaptive(rtol=1e-6, atol=1e-8)  # for many contacts
STEPS = 10_000  # in the span, of a model without a step of its own


def choose(model: Any, system: System, t_span: tuple[float, float]) -> tuple[Any, str]:
    """The integrator for a system, and why."""
    t_0, t_1 = as_span(t_span)
    n_c, n_friction = system.n_c, int(system.kinds[:, 1].astype(bool).sum())
    if n_c == 0:
        return EventDriven(), "there are no contacts, and smooth motion is integrated with order 5"
    if n_c <= MOST_CONTACTS and n_friction <= MOST_WITH_FRICTION:
        contacts = "1 contact" if n_c == 1 else f"{n_c} contacts"
        return EventDriven(hand_over=FINE), f"every event of {contacts} can be located"
    if n_c <= MOST_WITHOUT_FRICTION and n_friction == 0 and (system.kinds[:, 0] == UNILATERAL).all():
        return COARSE, f"{n_c} contacts are too many to locate their events, but without friction few enough to refine"
    own = getattr(model, "dt", None)
    dt = own if own is not None else (t_1 - t_0) / STEPS
    if not dt > 0.0:
        return EventDriven(hand_over=FINE), "the span has no length"
    whose = "the model's own" if own is not None else f"a part in {STEPS} of the span"
    return (
        MoreauJean(dt),
        f"{n_c} contacts, {n_friction} with friction, have too many combinations of modes; dt is {whose}",
    )
