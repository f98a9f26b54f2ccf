"""``integrator="auto"``: which integrator a system gets, and the reason in words.

The rules, in this order:

1. no contacts: EventDriven, which is of order 5 there and takes stiff forces;
2. few contacts, at most 6 with friction and 12 in all: EventDriven;
3. else MoreauJean, whose cost of a step grows with the contacts, not with their combinations.

The modes of contacts that touch are enumerated at an event: with friction 7 contacts take 0.1 s, 9 take 2 s. MoreauJean
steps with the model's own ``dt``, where it has one, else with a ten-thousandth of the span; so does the time stepping
that EventDriven hands stretches of dense events to.
"""

from __future__ import annotations

from typing import Any

from nonsmooth.integrators.event_driven import EventDriven
from nonsmooth.integrators.moreau_jean import MoreauJean
from nonsmooth.runs.times import as_span
from nonsmooth.system import System

MOST_CONTACTS, MOST_WITH_FRICTION = 12, 6
STEPS = 10_000  # in the span, of a model without a step of its own


def choose(model: Any, system: System, t_span: tuple[float, float]) -> tuple[Any, str]:
    """The integrator for a system, and why."""
    t_0, t_1 = as_span(t_span)
    own = getattr(model, "dt", None)
    dt = own if own is not None else (t_1 - t_0) / STEPS
    stepper = MoreauJean(dt) if dt > 0.0 else None
    n_c, n_friction = system.n_c, int(system.kinds[:, 1].astype(bool).sum())
    if n_c == 0:
        return EventDriven(), "there are no contacts, and smooth motion is integrated with order 5"
    if stepper is None or (n_c <= MOST_CONTACTS and n_friction <= MOST_WITH_FRICTION):
        contacts = "1 contact" if n_c == 1 else f"{n_c} contacts"
        return EventDriven(hand_over=stepper), f"every event of {contacts} can be located"
    whose = "the model's own" if own is not None else f"a part in {STEPS} of the span"
    return stepper, f"{n_c} contacts, {n_friction} with friction, have too many combinations of modes; dt is {whose}"
