"""Event-driven integration of rigid contacts: high order between events, every event located.

    M u' = h + W_N^T la_N + W_F^T la_F,    the forces from the modes of the contacts

Between two events the modes are fixed and the motion is smooth: Radau IIA of order 5 (radau/method.py) integrates it
within a tolerance, through stiff springs as well. At an event (event_driven/switching.py) come impacts, new modes, and
where sliding has no force an impact without collision. Theory and limits: docs/theory/event_driven.md.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from nonsmooth.checks.arrays import as_number, as_positive
from nonsmooth.contact.planar.enumerate import enumerate_modes
from nonsmooth.contact.planar.forces import MAX_MODES
from nonsmooth.contact.planar.impacts import kernels_of_shock
from nonsmooth.contact.planar.ladder import solve_planar
from nonsmooth.contact.planar.lemke import pivot
from nonsmooth.contact.planar.redundant import enumerate_redundant
from nonsmooth.errors import InvalidInput, Status
from nonsmooth.integrators.event_driven.impact import solve_impact
from nonsmooth.integrators.event_driven.loop import Scratch, accept_step, change_modes, fill_header
from nonsmooth.integrators.event_driven.switching import find_modes, switch_modes
from nonsmooth.integrators.event_driven.touch import find_touching
from nonsmooth.integrators.radau.events import locate_event
from nonsmooth.integrators.radau.located import LocatesEvents
from nonsmooth.integrators.radau.method import SMALLEST_RTOL, radau_shorten, radau_step
from nonsmooth.integrators.radau.stages import newton
from nonsmooth.integrators.records import State
from nonsmooth.integrators.rigid.hold import hold_constraints
from nonsmooth.integrators.rigid.rates import rigid_events, rigid_forces, rigid_rates
from nonsmooth.integrators.rigid.series import find_landing
from nonsmooth.jit import Kernel
from nonsmooth.jit.blocks import new
from nonsmooth.mechanics.acceleration_problem import acceleration_problem_apart
from nonsmooth.mechanics.laws import LAW_E_F
from nonsmooth.mechanics.system import UNILATERAL, System


@dataclass(frozen=True)
class EventDriven(LocatesEvents):
    """Rigid contact, integrated with high order between located events.

    Parameters
    ----------
    rtol, atol : float
        Tolerances of the error of a step: relative, and absolute in SI units of coordinates and velocities. A contact
        whose next bounce is lower than atol [m] is closed.

    Raises
    ------
    InvalidInput
        Unless 2.2e-14 <= rtol < 1 and atol > 0.

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

    def __post_init__(self) -> None:
        object.__setattr__(self, "atol", as_positive("atol", self.atol))
        object.__setattr__(self, "rtol", as_number("rtol", self.rtol))
        if not SMALLEST_RTOL <= self.rtol < 1.0:
            raise InvalidInput(f"rtol must lie in [{SMALLEST_RTOL:.1e}, 1), above the rounding; got {self.rtol:g}")

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
        arrays = new(Scratch, **system.sizes)
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
        if status != Status.NOT_SOLVED:
            return ""
        return (
            f"{int(memory.touch.is_touching.sum())} contacts touch at once, at t = {state.now:.9g} s, and EventDriven "
            f"tries at most {MAX_MODES} modes, as many as 8 or 9 contacts with friction have at rest: time stepping "
            "goes on through that, as Adaptive or MoreauJean(dt)"
        )


def refused_in_space(system: System) -> Iterator[str]:
    """What of a system with q' = B u or friction in two directions is not followed from event to event."""
    for contact, (kind, directions) in zip(system.contacts, system.kinds, strict=True):
        if kind != UNILATERAL or directions == 1:
            yield f"unilateral contacts with friction in two directions or none, and no {contact}"
    if (system.laws[:, LAW_E_F] != 0).any():
        yield "no tangential restitution, e_F = 0"
