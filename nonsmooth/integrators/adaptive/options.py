"""Error-controlled Moreau–Jean: plain steps extrapolated in smooth motion, and refined to the tolerance at events.

    T_j = T + c_2 (H/j)^2 + c_3 (H/j)^3 + ...,    the value after H with j plain steps

No event function and no root: an event is a step whose modes differ from those before it, and is resolved by smaller
steps. So whatever the plain step decides is integrated with an error estimate: several impacts at once, accumulations,
paradoxes. The step is in adaptive/step.py. Theory and limits: docs/theory/adaptive.md.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from nonsmooth.checks.arrays import as_number, as_positive
from nonsmooth.contact.planar.enumerate import enumerate_modes
from nonsmooth.contact.planar.ladder import pivot, solve_planar
from nonsmooth.contact.planar.newton import solve_by_newton
from nonsmooth.contact.planar.redundant import enumerate_redundant
from nonsmooth.errors import InvalidInput
from nonsmooth.integrators.adaptive.events import find_event
from nonsmooth.integrators.adaptive.held import held_step
from nonsmooth.integrators.adaptive.loop import run
from nonsmooth.integrators.adaptive.polynomial import highest_coefficients, slope_weights
from nonsmooth.integrators.adaptive.scales import BAND, hold_modes
from nonsmooth.integrators.adaptive.state import FIRST_STEP, N_ROWS, Extrapolation, extrapolation_weights
from nonsmooth.integrators.adaptive.step import try_step
from nonsmooth.integrators.adaptive.substep import substep
from nonsmooth.integrators.adaptive.switch import decide
from nonsmooth.integrators.adaptive.through import step_through
from nonsmooth.integrators.moreau_jean.contact import solve
from nonsmooth.integrators.moreau_jean.options import needs_newton
from nonsmooth.integrators.moreau_jean.paradox import end_slide
from nonsmooth.integrators.radau.method import SMALLEST_RTOL
from nonsmooth.integrators.rigid.rates import rigid_events
from nonsmooth.integrators.rigid.redundant import share_load
from nonsmooth.jit import Kernel, load_all
from nonsmooth.jit.blocks import new
from nonsmooth.mechanics.sys import Sys, fill_sys
from nonsmooth.mechanics.system import GIVEN_FORCE, System


@dataclass(frozen=True)
class Adaptive:
    """Moreau–Jean time stepping with error control.

    Parameters
    ----------
    rtol, atol : float
        Tolerances of the error of a step: relative to the largest value that a coordinate or velocity has had, and
        absolute in SI units. A contact is closed where its gap is within what these make of it, and so is one whose
        next bounce would be. At an impact the positions are held to the tolerance; the velocities jump, at a time
        that is as uncertain as that makes it.

    Raises
    ------
    InvalidInput
        Unless 2.2e-14 <= rtol < 1 and atol > 0.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> from models import WallPendulum
    >>> pendulum = WallPendulum()
    >>> sol = ns.simulate(pendulum, (0, 5), *pendulum.state(th=1.0), integrator=ns.Adaptive(rtol=1e-6))
    >>> sol.success
    True
    """

    rtol: float = 1e-8
    atol: float = 1e-10

    def __post_init__(self) -> None:
        as_positive("atol", self.atol)
        if not SMALLEST_RTOL <= as_number("rtol", self.rtol) < 1.0:
            raise InvalidInput(f"rtol must lie in [{SMALLEST_RTOL:.1e}, 1), above the rounding; got {self.rtol:g}")

    chooses_steps = True
    has_rigid_contacts = True
    extrapolates = True
    is_compiled = True
    callbacks: ClassVar[tuple[Kernel, ...]] = ()

    @property
    def loop(self) -> Kernel:
        """The loop over the steps."""
        return run

    def load(self, system: System) -> None:
        """Compile what the loop may reach for this system."""
        entry_points = [try_step, held_step, hold_modes, find_event, decide, step_through, substep, solve, rigid_events]
        if system.n_c > 1:
            entry_points.append(share_load)
        if system.n_c > 1:
            entry_points += [solve_planar, enumerate_modes, enumerate_redundant, pivot]
        if needs_newton(system):
            entry_points.append(solve_by_newton)
        if system.d > 0 and (system.kinds[:, 0] != GIVEN_FORCE).any():
            entry_points.append(end_slide)
        load_all(entry_points)

    def scratch(self, system: System, sys: Sys, t: float, t_end: float, q: np.ndarray, u: np.ndarray) -> Extrapolation:
        """The arrays of a run from t to t_end."""
        arrays = new(Extrapolation, n=system.n_u, n_c=system.n_c, d=system.d, n_p=len(system.p))
        contacts = arrays.contacts
        contacts.facts.has, contacts.facts.n_u = sys.has, sys.n
        contacts.numbers.atol, contacts.numbers.rtol = self.atol, BAND * self.rtol
        contacts.kinds[:], contacts.laws[:], contacts.sign[:] = system.kinds, system.laws, 1
        fill_sys(arrays.system, system, sys.model, sys.has)
        arrays.step.planar.can_decide_redundant = int(system.n_c > 1)
        arrays.step.planar.has_newton = needs_newton(system)
        clock = arrays.clock
        clock.now, clock.step, clock.rtol, clock.atol = t, FIRST_STEP * (t_end - t), self.rtol, self.atol
        clock.cut, clock.looked = np.inf, t
        arrays.counters.target = best_row(self.rtol)
        arrays.weights[:] = extrapolation_weights()
        arrays.slope_shares[:], arrays.highest[:] = slope_weights(), highest_coefficients()
        return arrays

    def begin(self, scratch: Extrapolation, mode: np.ndarray, slip: np.ndarray, selection: int) -> None:
        """Set the modes at the start (n_c,) and the selection rule."""
        contacts = scratch.contacts
        contacts.mode[:], contacts.slip[:] = mode, slip
        contacts.facts.selection = selection


def best_row(rtol: float) -> int:
    """The row at which smooth steps are to converge: of least work for the length, as measured."""
    return int(np.clip(round(2.0 - 0.5 * np.log10(rtol)), 3, N_ROWS - 1))
