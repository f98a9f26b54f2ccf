"""Moreau–Jean time stepping: velocities and impulses, one contact problem a step.

    q_mid = q_0 + dt/2 u_0
    Mhat (u_1 - u_0) = dt h(q_mid, u_0) + W^T P,    (gamma_1 + e gamma_0, P) in the laws of contact and friction
    q_1 = q_0 + dt ((1 - theta) u_0 + theta u_1)

Only contacts whose gap at the mid-point is closed take part. Given normal forces that read the velocities are taken at
(u_0 + u_1)/2, by a second solution of the contact problem. With theta = 1/2 the step is of second order in smooth
motion and of first order across impacts. Sources: Moreau (1988); Jean, *Comput. Methods Appl. Mech. Engrg.* 177 (1999)
235; the feedback of the gap and the passage through paradoxes: docs/theory/moreau_jean.md, (1) to (6).
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import ClassVar

from nonsmooth.checks.arrays import as_flag, as_instance, as_number, as_positive
from nonsmooth.contact.planar.enumerate import enumerate_modes
from nonsmooth.contact.planar.impacts import kernels_of_shock
from nonsmooth.contact.planar.ladder import exceeds_enumeration, solve_planar
from nonsmooth.contact.planar.lemke import pivot
from nonsmooth.contact.planar.newton import solve_by_newton
from nonsmooth.contact.planar.redundant import enumerate_redundant
from nonsmooth.contact.spatial.solve import solve_spatial
from nonsmooth.errors import InvalidInput, shown
from nonsmooth.integrators.contract import Schedule, Suspect
from nonsmooth.integrators.fixed_step import FixedStep
from nonsmooth.integrators.moreau_jean.compliance import Compliance
from nonsmooth.integrators.moreau_jean.contact import Options, Scratch, solve
from nonsmooth.integrators.moreau_jean.contact_solver import ContactSolver
from nonsmooth.integrators.moreau_jean.paradox import end_slide
from nonsmooth.integrators.moreau_jean.projection import project
from nonsmooth.integrators.moreau_jean.step import step
from nonsmooth.integrators.records import State
from nonsmooth.jit import Kernel, load_all
from nonsmooth.jit.blocks import new
from nonsmooth.mechanics.acceleration_problem import acceleration_problem_apart
from nonsmooth.mechanics.impact_in_space import collide_in_space
from nonsmooth.mechanics.system import GIVEN_FORCE, System


@dataclass(frozen=True)
class MoreauJean(FixedStep):
    """Time stepping with a fixed step.

    Parameters
    ----------
    dt : float
        Step [s].
    theta : float
        Weight of the new velocity in the position, and of the implicit part of the force: 1/2 (second order) to 1.
    projection : bool
        Move the positions back to g_N = 0 after each step where contacts hold (closed contacts drift otherwise by
        O(dt); bilateral ones do not need it, their gap is fed back).
    compliance : Compliance, optional
        A spring and damper at every contact, implicit in the step, in place of e_N; needs theta = 1.
    contacts : ContactSolver
        How the contact problems of a scene of bodies are solved, and to which residual; a system needs none.
    specialise : bool or "auto"
        Whether the loop is compiled once more for the system alone, which takes some 10 s, once on a machine, and makes
        steps 1.5 to 3 times as fast; "auto": where the steps of the run, or of the sweep, pay for it. The results are
        the same to the last bit.

    Raises
    ------
    InvalidInput
        Unless dt > 0 and 1/2 <= theta <= 1, and theta = 1 with a compliance.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> ns.MoreauJean(dt=1e-3)
    MoreauJean(dt=0.001, theta=0.5, projection=False, compliance=None)
    """

    dt: float
    theta: float = 0.5
    projection: bool = False
    compliance: Compliance | None = None
    contacts: ContactSolver = field(default_factory=ContactSolver, repr=False)
    specialise: bool | str = field(default="auto", repr=False)
    is_spatial: ClassVar[bool] = True
    inlined: ClassVar[tuple[Kernel, ...]] = (solve,)
    constants: ClassVar[tuple[type, ...]] = (Options,)

    def __post_init__(self) -> None:
        object.__setattr__(self, "dt", as_positive("dt", self.dt, "s"))
        theta = as_number("theta", self.theta)
        if not 0.5 <= theta <= 1.0:
            raise InvalidInput(f"theta must lie in [0.5, 1]; got {theta:g}")
        as_flag("projection", self.projection)
        is_auto = isinstance(self.specialise, str) and self.specialise == "auto"
        if not is_auto and not isinstance(self.specialise, bool):
            raise InvalidInput(f'specialise must be True, False or "auto"; got {shown(self.specialise)}')
        as_instance("contacts", self.contacts, ContactSolver, "a ContactSolver(tol=..., sweeps=..., interior=...)")
        if self.compliance is not None:
            self._check_compliance(theta)

    def _check_compliance(self, theta: float) -> None:
        if not isinstance(self.compliance, Compliance):
            raise InvalidInput(f"compliance must be a Compliance(stiffness, damping); got {shown(self.compliance)}")
        if theta != 1.0:
            raise InvalidInput(f"a compliance needs theta = 1, with less a stiff contact rings; got theta = {theta:g}")
        if self.projection:
            raise InvalidInput("give either compliance or projection: a compliant contact has an indentation to keep")

    @property
    def step(self) -> Kernel:
        """One step."""
        return step

    def memory(self, system: System, selection: int) -> Scratch:
        """The arrays that a step works in, with its options."""
        if self.contacts != ContactSolver():
            raise InvalidInput("contacts= of MoreauJean is for scenes of bodies; leave it out for a System")
        arrays = new(Scratch, **system.sizes)
        self.fill(arrays, system, selection)
        return arrays

    def fill(self, arrays: Scratch, system: System, selection: int) -> None:
        """Write the options into arrays of a step."""
        options = arrays.options
        options.theta, options.selection, options.projection = self.theta, selection, self.projection
        if self.compliance is not None:
            options.stiffness, options.damping = self.compliance.stiffness, self.compliance.damping
        if system.d < 2:
            arrays.planar.has_newton = needs_newton(system)
            arrays.planar.may_wait = 1

    def entry_points(self, system: System) -> list[Kernel]:
        """What the loop may reach for this system, itself first."""
        entry_points = [self.loop, step, solve]
        if system.d > 1:
            entry_points += [solve_spatial, acceleration_problem_apart, collide_in_space]
        elif system.n_c > 1:
            entry_points += [solve_planar, enumerate_modes, pivot, *kernels_of_shock(system)]
        if needs_newton(system):
            entry_points.append(solve_by_newton)
        if system.d == 1 and (system.kinds[:, 0] != GIVEN_FORCE).any():
            entry_points += [end_slide, acceleration_problem_apart]
        if self.projection:
            entry_points.append(project)
        return entry_points

    def load_for_retry(self, system: System, memory: Scratch, is_compiled: bool) -> bool:
        """Get ready what decides a contact problem that was not solved; False if there is nothing more to try."""
        planar, is_many = memory.planar, exceeds_enumeration(system)
        if system.n_c < 2 or system.d > 1 or planar.can_decide_redundant == 1:
            return False
        if is_compiled:
            load_all([enumerate_redundant, solve_by_newton] if is_many else [enumerate_redundant])
        planar.can_decide_redundant, planar.has_newton = 1, is_many
        return True

    def suspects(self, schedule: Schedule, state: State, memory: Scratch) -> list[Suspect]:
        """Beginning, mid-point and end of the step."""
        t, q, u, B = float(state.now), state.q, state.u, memory.work.B
        rate = B @ u if B.size else u
        interval = min(int(state.counters.interval), len(schedule.dt) - 1)
        dt = float(schedule.dt[interval]) if interval >= 0 else 0.0
        return [Suspect(t + part * dt, q + part * dt * rate, u) for part in (0.0, 0.5, 1.0)]

    def step_problem(self, system: System, selection: int) -> Scratch:
        """A fresh block that will hold the contact problem of the next step, and of no other."""
        memory = self.memory(system, selection)
        memory.work.closed[:] = -1
        return memory


def needs_newton(system: System) -> bool:
    """Whether a step of the system may be left to Newton's method: many contacts, and not all without friction."""
    return system.d == 1 and exceeds_enumeration(system)
