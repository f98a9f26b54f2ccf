"""Compliant (penalty) contact, resolved in time: the limit process whose end is rigid contact.

    M u' = h + W_N^T la_N + W_F^T la_F,    la_N = k d + c d',    d = -g_N

The contact's own motion, of period 2 pi/sqrt(k G_NN), is integrated with error control, and every change of mode is
located: lift-off, landing, slip reversal, the ends of sticking. The laws are in penalty/law.py, the rates of each
mode in penalty/rates.py, the method in radau/method.py. Theory and limits: docs/penalty.md.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from nonsmooth.checks.arrays import as_name, as_non_negative, as_number, as_positive
from nonsmooth.errors import InvalidInput, shown
from nonsmooth.integrators.penalty.law import EXPONENTS, LAWS, NormalLaw, Regularised, TangentialSpring
from nonsmooth.integrators.penalty.loop import Scratch, accept_step, change_modes, fill_header
from nonsmooth.integrators.penalty.rates import OMEGA, contact_rates
from nonsmooth.integrators.penalty.switching import begin_contacts, contact_events
from nonsmooth.integrators.radau.events import locate_event
from nonsmooth.integrators.radau.located import LocatesEvents
from nonsmooth.integrators.radau.method import SMALLEST_RTOL, radau_shorten, radau_step
from nonsmooth.integrators.radau.stages import newton
from nonsmooth.integrators.records import State
from nonsmooth.jit import Kernel
from nonsmooth.jit.blocks import new
from nonsmooth.mechanics.system import BILATERAL, FORCE, GAP, GIVEN_FORCE, MASS, NORMAL, System, evaluate
from nonsmooth.numerics.rounding import EPS, NOTHING, rounding_of_sum

# chosen: a start is a slip of the pen where a contact is indented by more than both: this part of the largest
# coordinate, and so many times what the smooth forces press it in at rest.
DEEPEST, STATIC_DEPTHS = 1e-2, 10.0
TIME_RESOLUTION = 100.0  # chosen: tolerances that the contact may move by within the rounding of the time
GAP_ROUNDINGS = 16  # chosen: of the largest coordinate: a gap at the start below it is what rounding left of zero


@dataclass(frozen=True)
class Penalty(LocatesEvents):
    """Compliant contact, integrated adaptively with located events.

    Parameters
    ----------
    stiffness : float
        k of every contact [N/m]; [N/m^1.5] for Hunt-Crossley.
    damping : float, optional
        c [N s/m]; [N s/m^2.5] for Hunt-Crossley. Zero when both forms are left out.
    damping_ratio : float, optional
        zeta, with c = 2 zeta sqrt(k m).
    mass : float, optional
        m in that formula [kg]; 1/G_NN where the contact closes when left out.
    law : {"clipped", "kelvin-voigt", "hunt-crossley"}
        Of unilateral contacts; bilateral ones are Kelvin-Voigt.
    friction : "coulomb", Regularised or TangentialSpring
        Coulomb's law with true sticking, or a smooth function of the sliding velocity. In a scene what sticks hangs on
        a spring: "coulomb" is ``TangentialSpring()`` there, and a system takes no other spring.
    rtol, atol : float
        Tolerances of the error of a step: relative, and absolute in SI units of coordinates and velocities; gaps are
        held to atol sqrt(m/k), which has the energy of a velocity error atol, and normal velocities to atol sqrt(k m)/c
        where that is less, which makes no more force: so the tolerances follow the stiffness and the damping.

    Raises
    ------
    InvalidInput
        For k <= 0, negative damping, both forms of damping, tolerances below what doubles resolve.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> from nonsmooth.catalogue import SpragSlip
    >>> rod = SpragSlip()
    >>> sol = ns.simulate(rod, (0, 0.4), *rod.state(th=0.78, thdot=1.0),
    ...                   integrator=ns.Penalty(stiffness=1e6, damping=1e6))
    >>> round(float(sol.q[-1, 1]), 5)
    0.96523
    """

    stiffness: float
    damping: float | None = None
    damping_ratio: float | None = None
    mass: float | None = None
    law: str = "clipped"
    friction: str | Regularised = "coulomb"
    rtol: float = 1e-8
    atol: float = 1e-10

    def __post_init__(self) -> None:
        as_positive("stiffness", self.stiffness, "N/m")
        if self.damping is not None and self.damping_ratio is not None:
            raise InvalidInput("give either damping or damping_ratio; got both")
        if self.damping is not None:
            as_non_negative("damping", self.damping, "N s/m")
        if self.damping_ratio is not None:
            as_non_negative("damping_ratio", self.damping_ratio)
        if self.mass is not None:
            as_positive("mass", self.mass, "kg")
            if self.damping_ratio is None:
                raise InvalidInput("mass belongs to damping_ratio, c = 2 zeta sqrt(k m); give damping_ratio too")
        as_name("contact law", self.law, LAWS)
        if self.law == "hunt-crossley" and self.damping_ratio is not None:
            raise InvalidInput("hunt-crossley has no damping ratio: its damping grows with the depth; give damping")
        is_coulomb = isinstance(self.friction, str) and self.friction == "coulomb"
        if not is_coulomb and not isinstance(self.friction, Regularised | TangentialSpring):
            raise InvalidInput(
                f"friction must be 'coulomb' or Regularised(v_s); got {shown(self.friction)}; of a scene it may be "
                "TangentialSpring(ratio) too"
            )
        as_positive("atol", self.atol)
        if not SMALLEST_RTOL <= as_number("rtol", self.rtol) < 1.0:
            raise InvalidInput(f"rtol must lie in [{SMALLEST_RTOL:.1e}, 1), above the rounding; got {self.rtol:g}")

    is_rigid = False
    is_spatial = True
    is_prepared = True
    callbacks = (contact_rates, contact_events, change_modes, accept_step, fill_header)

    def entry_points(self, system: System) -> list[Kernel]:
        """What the loop may reach."""
        return [*self.callbacks, begin_contacts, self.loop, radau_step, radau_shorten, newton, locate_event]

    def memory(self, system: System, selection: int) -> Scratch:
        """The arrays of a run, with the laws and tolerances."""
        if isinstance(self.friction, TangentialSpring):
            raise InvalidInput("a System sticks without a spring; leave out friction=TangentialSpring(...)")
        arrays = new(Scratch, **system.sizes)
        facts, numbers = arrays.contacts.facts, arrays.contacts.numbers
        is_regularised = isinstance(self.friction, Regularised)
        facts.law, facts.is_regularised = LAWS[self.law], is_regularised
        v_s = self.friction.v_s if isinstance(self.friction, Regularised) else 0.0
        numbers.v_s, numbers.rtol, numbers.atol = v_s, self.rtol, self.atol
        numbers.zeta = self.damping_ratio if self.damping_ratio is not None and self.mass is None else -1.0
        arrays.ode.clock.rtol = self.rtol
        return arrays

    def prepare(self, system: System, t_end: float, state: State, memory: Scratch) -> None:
        """Stiffness, damping and frequency of each contact, by the masses at the start, and the state there."""
        t, q, u, n_q, n_c = float(state.now), state.q, state.u, system.n_q, system.n_c
        first = n_q + system.n_u
        contacts, ode = memory.contacts, memory.ode
        contacts.constants[:] = self.constants(system, t, q, u)
        self.check_resolution(contacts.constants[:, OMEGA], max(abs(t), abs(t_end)))
        gaps = self.gaps(system, t, q, u, contacts.constants)
        ode.x[:n_q], ode.x[n_q:first] = q, u
        ode.x[first : first + n_c] = contacts.constants[:, OMEGA] * gaps
        ode.atol[: first + n_c] = self.atol
        ode.atol[first + n_c :] = self.atol * self.velocity_parts(contacts.constants)
        ode.clock.now = t

    def velocity_parts(self, constants: np.ndarray) -> np.ndarray:
        """(n_c,) How much finer than atol the normal velocities are held: an error of theirs makes as much force in
        the damper as one of the gap, atol sqrt(m/k), in the spring. At most 1: sqrt(k m)/c = 1/(2 zeta)."""
        k, c, omega = constants.T
        if LAWS[self.law] == NormalLaw.HUNT_CROSSLEY:
            return np.ones(len(k))  # its damper has no force at zero indentation
        return np.minimum(1.0, k / np.maximum(omega * c, k * np.finfo(float).tiny))

    def constants(self, system: System, t: float, q: np.ndarray, u: np.ndarray) -> np.ndarray:
        """(n_c, 3) k, c and the frequency omega of each contact at the start."""
        table = np.zeros((system.n_c, 3))
        k, exponent = self.stiffness, EXPONENTS[LAWS[self.law]]
        M, W_N = system.evaluate(MASS, t, q, u), evaluate(system, NORMAL, t, q, u)
        fastest = max(np.abs(u).max(initial=0.0), self.atol / self.rtol)
        for i in range(system.n_c):
            if system.kinds[i, 0] == GIVEN_FORCE:
                table[i] = k, 0.0, 1.0
                continue
            G_NN = float(W_N[i] @ np.linalg.solve(M, W_N[i]))
            if not G_NN > 0.0:
                raise InvalidInput(
                    f"the normal row of {system.described.contacts[i]} is zero at the start; check normal(t, q, p, W_N)"
                )
            n = 1.0 if system.kinds[i, 0] == BILATERAL else exponent
            omega = (k * G_NN) ** (1 / (n + 1)) * fastest ** ((n - 1) / (n + 1))
            c = self.damping or 0.0
            if self.damping_ratio is not None:
                c = 2 * self.damping_ratio * math.sqrt(k * (self.mass or 1 / G_NN))
            table[i] = k, c, omega
        return table

    def check_resolution(self, omegas: np.ndarray, t: float) -> None:
        """Refuse a contact that moves by more than its tolerance while the time t [s] changes by its rounding.

        Raises
        ------
        InvalidInput
        """
        omega = omegas.max(initial=0.0)
        if omega * EPS * t > TIME_RESOLUTION * self.rtol:
            raise InvalidInput(
                f"stiffness = {self.stiffness:g} N/m makes a contact of the frequency {omega:.3g} 1/s; at t = {t:g} s, "
                f"known to {EPS * t:.1e} s, rtol = {self.rtol:g} cannot be met in double precision: take a smaller "
                f"stiffness, or rtol >= {omega * EPS * t / TIME_RESOLUTION:.1g}"
            )

    def gaps(self, system: System, t: float, q: np.ndarray, u: np.ndarray, constants: np.ndarray) -> np.ndarray:
        """The gaps at the start (n_c,), zero where rounding left less than a few units of the coordinates.

        Raises
        ------
        InvalidInput
            Where a contact is indented by more than a hundredth of the largest coordinate, and by more than ten times
            its depth at rest.
        """
        gaps = evaluate(system, GAP, t, q, u)
        length = np.abs(q).max(initial=0.0)
        free = np.linalg.solve(system.evaluate(MASS, t, q, u), system.evaluate(FORCE, t, q, u))
        W_N = evaluate(system, NORMAL, t, q, u)
        for i in range(system.n_c):
            depth = abs(gaps[i]) if system.kinds[i, 0] == BILATERAL else -gaps[i]
            if depth <= DEEPEST * length + NOTHING:
                continue
            omega = constants[i, OMEGA]
            deepest = max(DEEPEST * length, STATIC_DEPTHS * abs(W_N[i] @ free) / omega**2)
            if depth > deepest:
                raise InvalidInput(
                    f"{system.described.contacts[i]} is indented by {depth:g} m at the start; at most {deepest:g} m is "
                    f"allowed ({DEEPEST:g} of the largest coordinate, or {STATIC_DEPTHS:g} times the depth at rest); "
                    "move the start, or use simulate(..., project=True)"
                )
        gaps[np.abs(gaps) <= rounding_of_sum(GAP_ROUNDINGS, length)] = 0.0
        return gaps
