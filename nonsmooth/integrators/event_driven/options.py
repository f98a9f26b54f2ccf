"""Event-driven integration of rigid contacts: high order between events, every event located.

    M u' = h + W_N^T la_N + W_F^T la_F,    the forces from the modes of the contacts

Between two events the modes are fixed and the motion is smooth: Radau IIA of order 5 (radau/method.py) integrates it
within a tolerance, through stiff springs as well. At an event (event_driven/switching.py) come impacts, new modes, and
where sliding has no force an impact without collision. Theory and limits: docs/theory/event_driven.md.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from nonsmooth.checks.arrays import as_number, as_positive
from nonsmooth.contact.planar.enumerate import enumerate_modes
from nonsmooth.contact.planar.forces import MAX_MODES
from nonsmooth.contact.planar.impacts import kernels_of_shock
from nonsmooth.contact.planar.ladder import solve_planar
from nonsmooth.contact.planar.lemke import pivot
from nonsmooth.contact.planar.redundant import enumerate_redundant
from nonsmooth.errors import InvalidInput, Status, shown
from nonsmooth.integrators.adaptive.options import Adaptive
from nonsmooth.integrators.event_driven.impact import solve_impact
from nonsmooth.integrators.event_driven.loop import Scratch, accept_step, change_modes, fill_header
from nonsmooth.integrators.event_driven.switching import find_modes, switch_modes
from nonsmooth.integrators.event_driven.touch import find_touching
from nonsmooth.integrators.moreau_jean.options import MoreauJean
from nonsmooth.integrators.radau.events import locate_event
from nonsmooth.integrators.radau.located import AT_RESUMPTION, LocatesEvents
from nonsmooth.integrators.radau.method import SMALLEST_RTOL, radau_shorten, radau_step
from nonsmooth.integrators.radau.stages import newton
from nonsmooth.integrators.records import N_WORKS, State
from nonsmooth.integrators.rigid.hold import hold_constraints
from nonsmooth.integrators.rigid.rates import rigid_events, rigid_forces, rigid_rates
from nonsmooth.integrators.rigid.series import find_landing
from nonsmooth.jit import Kernel
from nonsmooth.jit.blocks import new
from nonsmooth.mechanics.acceleration_problem import acceleration_problem_apart
from nonsmooth.mechanics.system import System


@dataclass(frozen=True)
class EventDriven(LocatesEvents):
    """Rigid contact, integrated with high order between located events.

    Parameters
    ----------
    rtol, atol : float
        Tolerances of the error of a step: relative, and absolute in SI units of coordinates and velocities. A contact
        whose next bounce is lower than atol [m] is closed.
    hand_over : Adaptive or MoreauJean, optional
        Takes over for a stretch where the events of several contacts are too dense: more than 100 within one step of
        MoreauJean, or 1e-4 of the span for Adaptive, or without any time between them, or more contacts at once than
        can be enumerated. A stretch is 50 times that long, and at most 1000 steps of Adaptive. The error is that of
        the other integrator there. Without it such a run goes on as long as it can, or fails.

    Raises
    ------
    InvalidInput
        Unless 2.2e-14 <= rtol < 1 and atol > 0, and hand_over is one of the two with rigid contacts.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> from nonsmooth.catalogue import BouncingBall
    >>> ball = BouncingBall(e=0.8)
    >>> sol = ns.simulate(ball, (0, 5), *ball.state(height=1.0), integrator=ns.EventDriven(rtol=1e-9))
    >>> round(sol.events[-1].t, 6), round(ball.t_inf(height=1.0), 6), float(sol.q[-1, 0])
    (4.063713, 4.063713, 0.0)
    """

    rtol: float = 1e-8
    atol: float = 1e-10
    hand_over: Adaptive | MoreauJean | None = None

    def __post_init__(self) -> None:
        as_positive("atol", self.atol)
        if not SMALLEST_RTOL <= as_number("rtol", self.rtol) < 1.0:
            raise InvalidInput(f"rtol must lie in [{SMALLEST_RTOL:.1e}, 1), above the rounding; got {self.rtol:g}")
        stepper = self.hand_over
        if isinstance(stepper, Adaptive) or stepper is None:
            return
        if not isinstance(stepper, MoreauJean) or stepper.compliance is not None:
            raise InvalidInput(
                "hand_over must be an Adaptive(rtol, atol), or a MoreauJean(dt) with rigid contacts; "
                f"got {shown(stepper)}"
            )

    callbacks = (rigid_rates, rigid_events, change_modes, accept_step, fill_header)

    def entry_points(self, system: System) -> list[Kernel]:
        """What the loop may reach for this system, itself first."""
        entry_points = [self.loop, *self.callbacks, rigid_forces, hold_constraints]
        entry_points += [radau_step, radau_shorten, newton, locate_event]
        if system.n_c > 0:
            entry_points += [find_modes, solve_impact, switch_modes, find_touching, enumerate_modes]
            entry_points.append(acceleration_problem_apart)
        if system.n_c > 1:
            entry_points += [enumerate_redundant, solve_planar, pivot, find_landing, *kernels_of_shock(system)]
        return entry_points

    def memory(self, system: System, selection: int) -> Scratch:
        """The arrays of a run, with the tolerances."""
        arrays = new(Scratch, n=system.n_u, n_c=system.n_c, d=system.d)
        contacts, ode = arrays.contacts, arrays.ode
        facts, numbers = contacts.facts, contacts.numbers
        facts.selection, facts.follows_margin = selection, 1
        numbers.atol, numbers.rtol = self.atol, self.rtol
        decides = int(system.n_c > 1)
        arrays.forces.planar.can_decide_redundant = arrays.touch.planar.can_decide_redundant = decides
        ode.atol[:], ode.clock.rtol = self.atol, self.rtol
        return arrays

    def reason(self, status: Status, state: State, memory: Scratch) -> str:
        """Of a contact problem with too many modes."""
        if status != Status.NOT_SOLVED or self.hand_over is not None:
            return ""
        return (
            f"{int(memory.touch.is_touching.sum())} contacts touch at once, at t = {state.now:.9g} s, and EventDriven "
            f"tries at most {MAX_MODES} modes, as many as 8 or 9 contacts with friction have at rest: time stepping "
            "goes on through that, as Adaptive or MoreauJean(dt), or EventDriven(hand_over=Adaptive()) for this "
            "stretch alone"
        )

    def resume(self, state: State, memory: Scratch) -> None:
        """Go on from the header, which another integrator has moved: its modes are decided anew."""
        contacts, ode = memory.contacts, memory.ode
        P = memory.written.copy()
        P[:, : state.P_sum.shape[1]] += state.P_sum
        ode.x[:] = np.concatenate((state.q, state.u, state.g_N, *P.T, state.ledger[:N_WORKS]))
        ode.clock.now = state.now
        contacts.mode[:], contacts.slip[:] = state.mode, state.slip
        contacts.sign[:] = np.where(state.P[:, 0] < 0.0, -1, 1)
        memory.waiting, memory.stalls = AT_RESUMPTION, 0
