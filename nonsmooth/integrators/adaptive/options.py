"""Error-controlled Moreau–Jean: plain steps with held modes, extrapolated, between located events.

    T_j = T + c_2 (H/j)^2 + c_3 (H/j)^3 + ...,    the value after H with j plain steps

Where a mode ends is found by event functions on the motion of the step (adaptive/events.py), which is taken again to
end there. What follows, several impacts at once, accumulations and paradoxes among it, a plain step without held modes
decides (adaptive/switch.py). The step is in adaptive/step.py. Theory and limits: docs/theory/adaptive.md.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from nonsmooth.checks.arrays import as_number, as_positive
from nonsmooth.contact.planar.enumerate import enumerate_modes
from nonsmooth.contact.planar.impacts import kernels_of_shock
from nonsmooth.contact.planar.ladder import solve_planar
from nonsmooth.contact.planar.lemke import pivot
from nonsmooth.contact.planar.newton import solve_by_newton
from nonsmooth.contact.planar.redundant import enumerate_redundant
from nonsmooth.errors import InvalidInput
from nonsmooth.integrators.adaptive.events import find_event
from nonsmooth.integrators.adaptive.held import held_step
from nonsmooth.integrators.adaptive.loop import BUDGET_TRIES, run
from nonsmooth.integrators.adaptive.polynomial import STEP_PIECES, highest_coefficients, slope_weights
from nonsmooth.integrators.adaptive.scales import BAND
from nonsmooth.integrators.adaptive.state import N_ROWS, VELOCITY_DEGREE, Extrapolation, extrapolation_weights
from nonsmooth.integrators.adaptive.step import try_step
from nonsmooth.integrators.adaptive.substep import substep
from nonsmooth.integrators.adaptive.switch import EVENTS_AT_INSTANT, decide_modes
from nonsmooth.integrators.contract import Handles, Integrator, Schedule, Suspect
from nonsmooth.integrators.moreau_jean.contact import solve
from nonsmooth.integrators.moreau_jean.options import needs_newton
from nonsmooth.integrators.moreau_jean.paradox import end_slide
from nonsmooth.integrators.radau.method import SMALLEST_RTOL
from nonsmooth.integrators.records import State
from nonsmooth.integrators.rigid.hold import hold_constraints
from nonsmooth.integrators.rigid.rates import rigid_events, rigid_forces
from nonsmooth.integrators.rigid.series import find_landing
from nonsmooth.jit import Kernel
from nonsmooth.jit.blocks import new
from nonsmooth.mechanics.acceleration_problem import acceleration_problem_apart
from nonsmooth.mechanics.contact_problem import model_facts
from nonsmooth.mechanics.laws import LAW_C, LAW_IMPACT
from nonsmooth.mechanics.sys import Sys
from nonsmooth.mechanics.system import GIVEN_FORCE, System


@dataclass(frozen=True)
class Adaptive(Integrator):
    """Moreau–Jean time stepping with error control.

    Parameters
    ----------
    rtol, atol : float
        Tolerances of the error of a step: relative to the largest value that a coordinate or velocity has had, and
        absolute in SI units. A contact is closed where its gap is within what these make of it, and so is one whose
        next bounce would be. At an impact the positions are held to the tolerance; the velocities jump, at a time
        that is as uncertain as that makes it. In space each step is taken whole and as two halves (in_space.py).

    Raises
    ------
    InvalidInput
        Unless 2.2e-14 <= rtol < 1 and atol > 0.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> from nonsmooth.catalogue import WallPendulum
    >>> pendulum = WallPendulum()
    >>> sol = ns.simulate(pendulum, (0, 5), *pendulum.state(th=1.0), integrator=ns.Adaptive(rtol=1e-6))
    >>> sol.success
    True
    """

    rtol: float = 1e-8
    atol: float = 1e-10

    def __post_init__(self) -> None:
        object.__setattr__(self, "atol", as_positive("atol", self.atol))
        object.__setattr__(self, "rtol", as_number("rtol", self.rtol))
        if not SMALLEST_RTOL <= self.rtol < 1.0:
            raise InvalidInput(f"rtol must lie in [{SMALLEST_RTOL:.1e}, 1), above the rounding; got {self.rtol:g}")

    pieces = STEP_PIECES
    degree = VELOCITY_DEGREE
    events_at_once = EVENTS_AT_INSTANT
    budget = f"the budget of a run that gets nowhere, {BUDGET_TRIES} tries (larger tolerances may get past this point),"

    @property
    def loop(self) -> Kernel:
        """The loop over the steps."""
        return run

    def entry_points(self, system: System) -> list[Kernel]:
        """What the loop may reach for this system, itself first."""
        entry_points = [self.loop, try_step, held_step, find_event, decide_modes, substep]
        entry_points += [solve, rigid_events, rigid_forces, hold_constraints]
        if system.n_c > 1:
            entry_points += [solve_planar, enumerate_modes, enumerate_redundant, pivot, find_landing]
            entry_points += kernels_of_shock(system)
        if needs_newton(system):
            entry_points.append(solve_by_newton)
        if system.d > 0 and (system.kinds[:, 0] != GIVEN_FORCE).any():
            entry_points += [end_slide, acceleration_problem_apart]
        return entry_points

    def memory(self, system: System, selection: int) -> Extrapolation:
        """The arrays of a run, with the tolerances."""
        arrays = new(Extrapolation, **system.sizes, n_p=len(system.p))
        contacts = arrays.contacts
        contacts.facts.selection = selection
        contacts.numbers.atol, contacts.numbers.rtol = self.atol, BAND * self.rtol
        arrays.system.kinds[:] = system.kinds
        own = arrays.system
        own.has, own.n, own.n_q, own.n_c = model_facts(system), system.n_u, system.n_q, system.n_c
        arrays.step.planar.can_decide_redundant = int(system.n_c > 1)
        arrays.step.planar.has_newton = needs_newton(system)
        arrays.clock.rtol, arrays.clock.atol = self.rtol, self.atol
        arrays.counters.target = best_row(self.rtol)
        arrays.weights[:] = extrapolation_weights()
        arrays.slope_shares[:], arrays.highest[:] = slope_weights(), highest_coefficients()
        return arrays

    def set_handles(self, sys: Sys, handles: Handles, memory: Extrapolation) -> None:
        """The model, for the system with the laws of a substep."""
        memory.system.model = sys.model
        memory.system.laws[:, LAW_C:LAW_IMPACT] = sys.laws[:, LAW_C:LAW_IMPACT]  # addresses of a law of the user's

    def suspects(self, schedule: Schedule, state: State, memory: Extrapolation) -> list[Suspect]:
        """Beginning, middle and end of the step, and the end of the shortest one."""
        t, q, u = float(state.now), state.q, state.u
        dt, least, trial = float(memory.clock.step), float(memory.clock.least), memory.trial
        parts = (0.0, 0.5 * dt, dt, least)
        return [*(Suspect(t + part, q + part * u, u) for part in parts), Suspect(t + dt, trial.q, trial.u)]


def best_row(rtol: float) -> int:
    """The row at which smooth steps are to converge: of least work for the length, as measured."""
    return int(np.clip(round(2.0 - 0.5 * np.log10(rtol)), 3, N_ROWS - 1))
