"""``integrator="auto"`` and ``Auto(rtol)``: which integrator a system and a start get, and the reason in words.

The rules, in this order:

1. no contacts: EventDriven, which is of order 5 there and takes stiff forces;
2. few contacts that are decided at once: EventDriven;
3. up to 100 unilateral contacts without friction: Adaptive, whose every contact problem has one solution, found in a
   few pivots from the one before;
4. else, if a tolerance is asked for: Adaptive;
5. else MoreauJean, with the model's own ``dt``, where it has one, else a ten-thousandth of the span.

With q' = B u or friction in two directions rule 2 goes by the number of contacts, and rule 3 is left out.

Where EventDriven meets more contacts at once than it can enumerate, or events without time between them, the whole run
is taken again by Adaptive with its tolerances, or, of more than 12 contacts and where no tolerance is asked for, by
MoreauJean.

The modes of contacts that touch and that G couples are enumerated at an event: with friction 7 contacts take 0.1 s, 9
take 2 s. So what counts is not how many contacts a system has but how many are decided at once: the largest island of
the start. A wheel of eight spokes touches with one or two of them. Feet of one body are coupled, but no more than its
coordinates are independent, and the modes of the others follow (implied.py). A contact problem of a stack with friction
takes 10 ms, of which an impact needs a hundred with Adaptive, and one with MoreauJean.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from nonsmooth.checks.arrays import as_number
from nonsmooth.contact.islands import find_islands
from nonsmooth.errors import InvalidInput, Status
from nonsmooth.integrators.adaptive.options import Adaptive
from nonsmooth.integrators.contract import Choice, Integrator
from nonsmooth.integrators.event_driven.options import SMALLEST_RTOL, EventDriven, refused_in_space
from nonsmooth.integrators.moreau_jean.options import MoreauJean
from nonsmooth.jit import interpreted
from nonsmooth.mechanics.situation import largest_closed_gap
from nonsmooth.mechanics.start import own_time
from nonsmooth.mechanics.system import GAP, MASS, NORMAL, TANGENT, UNILATERAL, System, evaluate
from nonsmooth.runs.times import as_span

MOST_CONTACTS, MOST_WITH_FRICTION = 12, 6  # chosen: that are decided at once
MOST_WITHOUT_FRICTION = 100  # chosen: contacts of a system without friction that are decided at once
# chosen: relative tolerances, where none is given: of located events, and of many contacts
LOCATED_EVENTS_RTOL, MANY_CONTACTS_RTOL = 1e-8, 1e-6
PER_ATOL = 100  # chosen: rtol over atol [1/SI units]
STEPS_OF_SPAN = 10_000  # chosen: in the span, of a model without a step of its own
GIVEN_UP = (Status.CHATTERING, Status.NOT_SOLVED)  # code: of runs that another integrator can go through
# code: the same in space, where steps pass coupled slides that lose their force too
GIVEN_UP_IN_SPACE = (*GIVEN_UP, Status.NO_SOLUTION, Status.STEP_VANISHED)


@dataclass(frozen=True)
class Auto(Choice):
    """The integrator that fits a system and its start, within a tolerance.

    Parameters
    ----------
    rtol : float, optional
        Relative tolerance; the absolute one is a hundredth of it in SI units. With it only integrators that keep a
        tolerance are chosen; without it, as with ``"auto"``, 1e-8 where events are located, 1e-6 for many contacts
        without friction, and MoreauJean for many with friction.

    Raises
    ------
    InvalidInput
        Unless 2.2e-14 <= rtol < 1.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> from nonsmooth.catalogue import BouncingBall
    >>> ball = BouncingBall(e=0.8)
    >>> sol = ns.simulate(ball, (0, 1), *ball.state(height=1.0), integrator=ns.Auto(rtol=1e-6))
    >>> sol.about["integrator"], sol.about["chosen"]
    ('EventDriven(rtol=1e-06, atol=1e-08)', 'every event of 1 contact can be located')
    """

    rtol: float | None = None

    def __post_init__(self) -> None:
        if self.rtol is not None and not SMALLEST_RTOL <= as_number("rtol", self.rtol) < 1.0:
            raise InvalidInput(f"rtol must lie in [{SMALLEST_RTOL:.1e}, 1), above the rounding; got {self.rtol:g}")

    def choose(
        self, model: Any, system: System, t_span: tuple[float, float], q: np.ndarray, u: np.ndarray
    ) -> tuple[Any, str]:
        """The integrator for a system that starts at q, u, and why."""
        t_0, _ = as_span(t_span)
        n_c, n_friction = system.n_c, int(system.kinds[:, 1].astype(bool).sum())
        fine = LOCATED_EVENTS_RTOL if self.rtol is None else self.rtol
        stepper = stepper_of(model, t_span)
        whose = f"a part in {STEPS_OF_SPAN} of the span" if own_time(model, "dt") is None else "the model's own"
        located = EventDriven(fine, fine / PER_ATOL)
        if n_c == 0:
            return located, "there are no contacts, and smooth motion is integrated with order 5"
        contacts = "1 contact" if n_c == 1 else f"{n_c} contacts"
        if system.is_spatial and (n_c > MOST_CONTACTS or any(refused_in_space(system))):
            if self.rtol is not None:
                return Adaptive(fine, fine / PER_ATOL), "it keeps the tolerance asked for, in space by plain steps"
            step_of_none = MoreauJean(1.0)  # of a span without length no step is taken
            return stepper or step_of_none, f"it takes motion and friction in space; dt is {whose}"
        if system.is_spatial:
            return located, f"every event of {contacts} can be located"
        if n_c <= MOST_CONTACTS and n_friction <= MOST_WITH_FRICTION:
            return located, f"every event of {contacts} can be located"
        if n_c <= MOST_WITHOUT_FRICTION and n_friction == 0 and (system.kinds[:, 0] == UNILATERAL).all():
            coarse = MANY_CONTACTS_RTOL if self.rtol is None else self.rtol
            return (
                Adaptive(coarse, coarse / PER_ATOL),
                f"{contacts} are too many to locate their events, but without friction few enough to refine",
            )
        several, with_friction = decided_at_once(system, t_0, q, u)
        if several <= MOST_CONTACTS and with_friction <= MOST_WITH_FRICTION:
            return (
                located,
                f"of {contacts} at most {several} are decided at once at the start, whose events can be located",
            )
        many = f"{contacts}, {n_friction} with friction, have too many combinations of modes"
        if self.rtol is not None:
            return Adaptive(fine, fine / PER_ATOL), f"{many}; it keeps the tolerance asked for"
        if stepper is None:
            return located, "the span has no length"
        return stepper, f"{many}; dt is {whose}"

    def instead(
        self, chosen: Integrator, status: Status, model: Any, system: System, t_span: tuple[float, float]
    ) -> Integrator | None:
        """Where EventDriven could not go on, what steps through any number of contacts and events; else None."""
        if not isinstance(chosen, EventDriven) or status not in (GIVEN_UP_IN_SPACE if system.is_spatial else GIVEN_UP):
            return None
        goes_by_steps = self.rtol is None and (system.is_spatial or system.n_c > MOST_CONTACTS)
        stepper = stepper_of(model, t_span) if goes_by_steps else None
        return Adaptive(chosen.rtol, chosen.atol) if stepper is None else stepper


def stepper_of(model: Any, t_span: tuple[float, float]) -> MoreauJean | None:
    """Moreau–Jean with the model's own step, or a part of the span; None where that has no length."""
    own, (t_0, t_1) = own_time(model, "dt"), as_span(t_span)
    dt = own if own is not None else (t_1 - t_0) / STEPS_OF_SPAN
    return MoreauJean(dt) if dt > 0.0 else None


def decided_at_once(system: System, t: float, q: np.ndarray, u: np.ndarray) -> tuple[int, int]:
    """The contacts of the largest island among those that touch at a state, and how many have friction.

    Not more than their rows are independent: the modes of the others follow. None where a function of the system cannot
    be evaluated, or the mass matrix inverted: the run refuses that in its own words.
    """
    try:
        gaps, M, W_N = (evaluate(system, which, t, q, u) for which in (GAP, MASS, NORMAL))
        W_F = evaluate(system, TANGENT, t, q, u)[:, 0] if system.d else np.zeros_like(W_N)
        touching = np.flatnonzero((gaps <= largest_closed_gap(q)) | (system.kinds[:, 0] != UNILATERAL))
        W = np.stack((W_N[touching], W_F[touching]), axis=1).reshape(-1, system.n_u)
        G = W @ np.linalg.solve(M, W.T)
    except (InvalidInput, np.linalg.LinAlgError):
        return 0, 0
    island = np.zeros(len(touching), np.int64)
    count = interpreted(find_islands)(len(touching), 2 * np.arange(len(touching) + 1), G, island)
    several, with_friction = 0, 0
    for k in range(count):
        members = np.flatnonzero(island == k)
        rank = int(np.linalg.matrix_rank(W.reshape(-1, 2, system.n_u)[members].reshape(-1, system.n_u)))
        frictional = int((system.kinds[touching[members], 1] > 0).sum())
        several = max(several, min(len(members), rank))
        with_friction = max(with_friction, min(frictional, rank))
    return several, with_friction
