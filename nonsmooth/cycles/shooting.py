"""Periodic motions through a sequence of events, and their stability.

Unknown are the state x_i at the beginning and the duration T_i of every phase of the period; they satisfy

    r_i(phi_i(T_i, x_i)) = x_{i+1},    e_i(phi_i(T_i, x_i)) = 0,    x_{m+1} = x_1

with phi_i the flow of the phase's mode, e_i the margin that vanishes at its end and r_i the jump there (mostly none,
r(x) = x). Newton's method with the exact derivatives of the flows solves them (multiple shooting); a motion without
events has one phase and a plane across it in place of e. A small change of x_1 returns as

    S_m Phi_m ... S_1 Phi_1,    S_i = R_i + (f_{i+1} - R_i f_i) grad e_i^T/(grad e_i . f_i),    R_i = dr_i/dx

whose eigenvalues are the Floquet multipliers: one is 1, each stick gives a zero. Under an excitation the time is the
last component of x, and x_{m+1} = x_1 + (0, a multiple of its period). Where the system can be shifted along some
directions without changing (drift.py), the motion closes but for such a shift: the last equation is asked for across
these directions only, x_1 does not move along them, and each gives one more multiplier 1. Sources: Stoer and Bulirsch,
*Introduction to Numerical Analysis* (2002), section 7.3.5; Leine and Nijmeijer, *Dynamics and Bifurcations of
Non-Smooth Mechanical Systems* (2004), chapter 7 (saltation matrices).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from nonsmooth.cycles.cycle import CyclePhase, LimitCycle
from nonsmooth.cycles.drift import Drift, find_drift
from nonsmooth.cycles.flow_map import FLOW_RTOL, flow_curve, flow_map
from nonsmooth.cycles.jump import Jump, apply_jump
from nonsmooth.cycles.mode_flow import ContactState, Margin, ModeFlow, mode_flow
from nonsmooth.cycles.mode_sequence import ContactLost
from nonsmooth.cycles.phase import PhaseGuess
from nonsmooth.errors import InvalidInput
from nonsmooth.mechanics.system import ContactMode, System
from nonsmooth.numerics.complex_step import jacobian
from nonsmooth.numerics.rounding import EPS

SHOOTING_NEWTON_STEPS = 20  # chosen: Newton steps before a guess is given up
SHOOTING_PATIENCE = 6  # chosen: Newton steps in which their size must halve at least
# chosen: tolerances of the integration while scales are looked for, and far from the cycle
COARSE_RTOL, ROUGH_RTOL = 1e-4, 1e-7
NEARLY = 1e-3  # chosen: of the states' scale: smaller corrections deserve the full tolerance
MARGIN_SAMPLES = 48  # chosen: of a phase, at which its margins are looked at
CURVE = 4  # chosen: times as many points of its curve are kept
BROKEN_MARGIN = 1e-7  # chosen: of a margin's largest value: so far below zero it may fall by rounding at an event
COLLAPSED = 1e-3  # chosen: of the guess's extent: a smaller cycle is an equilibrium, which solves the same equations
CLOSING_TOLERANCES = 1e3  # chosen: tolerances of the integration, and roundings of a state, that a residual may have
STRETCHED = 10  # chosen: times the period of the guess: a longer one is a Newton iteration gone astray
AT_REST = "the guess leads back to a state of rest, not to a cycle; give a nearer one"


class AtRest(InvalidInput):
    """The phases have shrunk to a state of rest."""


class OtherSequence(InvalidInput):
    """The phases close, but an event comes before that which should end one."""


class Link(NamedTuple):
    """A phase as the Newton iteration sees it."""

    flow: ModeFlow
    ends_by: Margin | None
    jump: Jump | None

    def after(self, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The state r(y) after the event that ends the phase in y, and R = dr/dy."""
        if self.jump is None:
            return y, np.eye(y.size)
        return jacobian(lambda z: apply_jump(self.jump, self.flow, z), y)  # type: ignore[arg-type]


class Shooting:
    """The boundary value problem of a cycle with a given sequence of modes.

    With ``scale`` given, the guess counts as near: the full accuracy ``rtol`` is used from the first step on.
    ``forcing`` is the period of the excitation [s]; the states of the guess then end with their time, and so they do
    where a drive goes on. With ``drifts`` the cycle may close but for a shift that changes nothing.
    """

    def __init__(
        self,
        system: System,
        guess: Sequence[PhaseGuess],
        scale: np.ndarray | None = None,
        rtol: float = FLOW_RTOL,
        forcing: float | None = None,
        drifts: bool = False,
    ) -> None:
        self.system, self.rtol, self.forcing = system, rtol, forcing
        self.drift = find_drift(system, places_of(guess, system.n_q), forcing is not None) if drifts else None
        self.guess = from_zero(guess, self.drift, system.n_q)
        following = [*self.guess[1:], self.guess[0]]
        is_smooth = len(self.guess) == 1 and self.guess[0].jump is None
        self.links = [
            Link(
                mode_flow(system, a.states),
                None if is_smooth else ending(a.states, b.states, a.jump, system.described.contacts),
                a.jump,
            )
            for a, b in zip(self.guess, following, strict=True)
        ]
        self.x = np.array([phase.x for phase in self.guess])
        self.T = np.array([phase.duration for phase in self.guess])
        self.wrap = np.zeros(self.x.shape[1])  # x_{m+1} - x_1
        if forcing is not None:
            self.wrap[-1] = forcing * max(1, round(self.T.sum() / forcing))
        self.is_near = scale is not None
        self.scale = self._scale() if scale is None else scale
        if not (self.scale > 0).all():
            raise AtRest(AT_REST)
        self.across = self._across()
        first = self.across @ (self.links[0].flow.rate(self.x[0]).real / self.scale)
        self.section = first / np.linalg.norm(first) / self.scale, self.x[0].copy()  # for a motion without events

    def _scale(self) -> np.ndarray:
        """Extents of the coordinates, without what drifts, and of the velocities over the guess."""
        states = [self.x]
        for link, x, T in zip(self.links, self.x, self.T, strict=True):
            curve = flow_curve(link.flow, x, T, np.maximum(np.abs(x), 1e-3), rtol=COARSE_RTOL)
            states.append(curve(np.linspace(0, T, MARGIN_SAMPLES)).T)
        x, n = np.concatenate(states), self.system.n_q
        extent = np.ptp(x, axis=0)
        if self.drift is not None:
            extent[:n] = self.drift.extents(x[:, 2 * n] if x.shape[1] > 2 * n else np.zeros(len(x)), x[:, :n])
        for part in (slice(0, n), slice(n, 2 * n)):
            extent[part] = np.maximum(extent[part], 1e-3 * extent[part].max())
        extent[2 * n :] = self.T.sum() if self.forcing is None else self.wrap[2 * n :]
        return extent

    def _across(self) -> np.ndarray:
        """(d, d) projection of a state over its scale on what drifts not: shifted until its pivots are zero, as in
        `Drift.rest`, so that a coordinate closes relative to the drive that it follows. ``along`` (k, d) picks the
        pivots, ``shifts`` (k, d) have a pivot of 1 each."""
        n, d = self.system.n_q, self.x.shape[1]
        k = 0 if self.drift is None else len(self.drift)
        self.along, self.shifts = np.zeros((k, d)), np.zeros((k, d))
        if self.drift is not None and k:
            columns = [*range(n), *range(2 * n, d)]  # of q, and of t where it is part of the state
            directions = self.drift.directions[:, : len(columns)]
            pivots = [columns[pivot] for pivot in self.drift.pivots]
            self.along[range(k), pivots] = 1.0
            self.shifts[:, columns] = directions / self.scale[columns]
            self.shifts *= self.scale[pivots][:, None]
        return np.eye(d) - self.shifts.T @ self.along

    def solve(self, checked: bool = True) -> LimitCycle:
        """Newton's method; then, if ``checked``, whether the modes last as long as they should."""
        rtol = self.rtol if self.is_near else ROUGH_RTOL
        sizes: list[float] = []
        while len(sizes) < SHOOTING_NEWTON_STEPS and (
            len(sizes) <= SHOOTING_PATIENCE or sizes[-1] < 0.5 * sizes[-1 - SHOOTING_PATIENCE]
        ):
            residual, J = self.linearised(rtol)
            step = -np.linalg.lstsq(J, residual, rcond=1e-13)[0]
            self._move(step)
            self._require_cycle()
            size = np.abs(step).max()
            sizes.append(float(size))
            if rtol == self.rtol and (size**2 <= rtol or np.abs(residual).max() <= 10 * rtol):
                break  # Newton's method leaves size^2; near grazing the residual vanishes while steps stay large
            rtol = self.rtol if size <= NEARLY else ROUGH_RTOL
        else:
            raise InvalidInput(
                f"the cycle does not close: after {len(sizes)} Newton steps the phases still miss one another by "
                f"{np.abs(residual).max():.2g} of the motion's extent; simulate for longer, or give a nearer guess"
            )
        return self.cycle(checked)

    def _move(self, step: np.ndarray) -> None:
        m, d = self.x.shape
        change = step.reshape(m, d + 1)
        shrink = min(1.0, *(1 / max(-2 * c, c, 1.0) for c in change[:, d]))  # no T_i halves, or doubles, in one step
        self.x = self.x + shrink * change[:, :d] * self.scale
        self.T = self.T * (1 + shrink * change[:, d])

    def _require_cycle(self) -> None:
        """Raise when the iteration has come to an equilibrium, whose period is any, or to a period without end."""
        guessed = sum(phase.duration for phase in self.guess)
        moves = np.abs(self.across @ (self.links[0].flow.rate(self.x[0]).real * guessed / self.scale)).max()
        if self.links[0].ends_by is None and moves <= COLLAPSED:
            raise AtRest(AT_REST)
        if not self.T.sum() <= STRETCHED * guessed:
            raise InvalidInput(
                f"the cycle does not close: its period grew from {guessed:.6g} to {self.T.sum():.6g} s; simulate for "
                "longer, or give a nearer guess"
            )

    def linearised(self, rtol: float) -> tuple[np.ndarray, np.ndarray]:
        """Residuals and their derivative by (x_i/scale, T_i relative), phase after phase."""
        m, d = self.x.shape
        residuals: list[Any] = []
        rows: list[np.ndarray] = []
        self.ends = [
            flow_map(link.flow, x, T, self.scale, rtol) for link, x, T in zip(self.links, self.x, self.T, strict=True)
        ]
        for i, link in enumerate(self.links):
            y, Phi = self.ends[i]
            f = link.flow.rate(y).real
            after, R = link.after(y)
            here, following = slice(i * (d + 1), (i + 1) * (d + 1)), (i + 1) % m
            by_phase = np.column_stack([Phi * self.scale, f * self.T[i]])
            row = np.zeros((d, m * (d + 1)))
            row[:, here] = R @ by_phase / self.scale[:, None]
            row[:, following * (d + 1) : following * (d + 1) + d] -= np.eye(d)
            is_last = i == m - 1
            residuals.append(self._missed(i, after))
            rows.append(self.across @ row if is_last else row)
            value, gradient, size = self._end(link, y)
            row = np.zeros((1, m * (d + 1)))
            if link.ends_by is None:
                row[0, :d] = gradient * self.scale
            else:
                row[0, here] = gradient @ by_phase
            residuals.append([value / size])
            rows.append(row / size)
            held, by_state = self._held(link.flow, self.x[i])
            row = np.zeros((held.size, m * (d + 1)))
            row[:, i * (d + 1) : i * (d + 1) + d] = by_state
            residuals.append(held)
            rows.append(row)
        row = np.zeros((len(self.along), m * (d + 1)))
        row[:, :d] = self.along  # the cycle may be shifted as a whole: it begins where the guess does
        residuals.append(self.along @ ((self.x[0] - self.guess[0].x) / self.scale))
        rows.append(row)
        return np.concatenate(residuals), np.concatenate(rows)

    def _missed(self, i: int, after: np.ndarray) -> np.ndarray:
        """By how much phase i misses the next one, over the scale; of the last phase across the drift."""
        missed = (after - self._next(i)) / self.scale
        return self.across @ missed if i == len(self.x) - 1 else missed

    def _next(self, i: int) -> np.ndarray:
        """The state in which the phase after phase i begins, (d,)."""
        return self.x[i + 1] if i + 1 < len(self.x) else self.x[0] + self.wrap

    def _end(self, link: Link, y: np.ndarray) -> tuple[float, np.ndarray, float]:
        """The margin that ends a phase, its gradient and its size; for a single phase, the plane across it."""
        if link.ends_by is None:
            normal, origin = self.section
            return float(normal @ (self.x[0] - origin)), normal, 1.0
        gradient = margin_gradient(link.flow, link.ends_by, y)
        value = link.flow.margins(y)[link.ends_by].real
        return float(value), gradient, float(np.abs(gradient * self.scale).max()) or 1.0

    def _held(self, flow: ModeFlow, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """What the mode holds at zero, each divided by its size, with its derivative by x/scale."""
        if not (flow.n_a or flow.stuck):
            return np.zeros(0), np.zeros((0, x.size))
        value, J = jacobian(flow.holds, x)
        size = np.abs(J * self.scale).max(axis=1)
        return value / size, J * self.scale / size[:, None]

    def found(self) -> list[PhaseGuess]:
        """The phases as they are now."""
        return [
            phase._replace(x=x.copy(), duration=float(T))
            for phase, x, T in zip(self.guess, self.x, self.T, strict=True)
        ]

    def cycle(self, checked: bool = True) -> LimitCycle:
        """The cycle of the phases that `linearised` has integrated last."""
        begins = np.concatenate([[0.0], np.cumsum(self.T)])
        n = self.system.n_q
        times, states, phases, residual = [], [], [], 0.0
        for i, link in enumerate(self.links):
            curve = flow_curve(link.flow, self.x[i], self.T[i], self.scale, self.rtol)
            s = np.linspace(0, self.T[i], CURVE * MARGIN_SAMPLES + 1)
            path = curve(s).T
            if checked:
                self._check(i, s[::CURVE], path[::CURVE])
            after = link.after(path[-1])[0]
            residual = max(residual, float(np.abs(self._missed(i, after)).max()))
            times.append(begins[i] + s)
            states.append(path)
            states_i, x_i = self.guess[i].states, self.x[i].copy()
            phases.append(CyclePhase(states_i, float(begins[i]), float(self.T[i]), x_i, link.ends_by, link.jump))
        x = np.concatenate(states)
        if (np.ptp(x / self.scale @ self.across.T, axis=0)[: 2 * n] <= COLLAPSED).all():
            raise AtRest(AT_REST)
        self._require_closed(residual, x[:, n : 2 * n])
        missed = (after - self._next(len(self.x) - 1)) / self.scale
        gone = (self.shifts.T @ (self.along @ missed))[:n] * self.scale[:n]
        multipliers, shift = self._multipliers()
        return LimitCycle(
            self.system,
            tuple(phases),
            np.concatenate(times),
            x[:, :n],
            x[:, n : 2 * n],
            multipliers,
            shift,
            residual,
            self.scale,
            self.forcing,
            gone,
            self.drift is not None and len(self.drift) > 0,
        )

    def _require_closed(self, residual: float, u: np.ndarray) -> None:
        """Raise unless the phases close to rounding, and the velocities vary by more than is left."""
        rounding = EPS * float((np.abs(self.x) / self.scale).max())
        if residual > CLOSING_TOLERANCES * max(self.rtol, rounding):
            raise InvalidInput(
                f"the cycle does not close: its phases miss one another by {residual:.2g} of the motion's extent, more "
                "than rounding; simulate for longer, or give a nearer guess"
            )
        if (np.ptp(u, axis=0) <= max(residual, CLOSING_TOLERANCES * EPS) * np.abs(u).max()).all():
            raise AtRest(AT_REST)

    def _check(self, i: int, s: np.ndarray, path: np.ndarray) -> None:
        """Raise when a margin falls below zero within a phase: another event would have come first."""
        link = self.links[i]
        margins = [link.flow.margins(x) for x in path]
        for key in margins[0]:
            values = np.array([margin[key].real for margin in margins])
            low = int(values.argmin())
            contact, kind = key
            is_lost = kind == "normal" and contact not in link.flow.constrained and values[low] <= 0  # N is cut at zero
            if is_lost or values[low] < -BROKEN_MARGIN * np.abs(values).max():
                what = {
                    "slip": "would reverse its sliding", "normal": "would lose its normal force", "gap": "would strike",
                }  # fmt: skip
                raise (ContactLost if is_lost else OtherSequence)(
                    f"the cycle does not close: {s[low]:.6g} s after the beginning of phase {i} "
                    f"{link.flow.system.described.contacts[contact]} "
                    f"{what.get(kind, 'would begin to slide')}; its sequence of modes is another one here"
                )

    def _multipliers(self) -> tuple[np.ndarray, float]:
        """Floquet multipliers without the trivial ones, and how far these are from 1."""
        m, d = self.x.shape
        total = np.eye(d)
        for i, link in enumerate(self.links):
            y, Phi = self.ends[i]
            total = Phi @ total
            if link.ends_by is not None:
                state, R = link.after(y)
                before, after = link.flow.rate(y).real, self.links[(i + 1) % m].flow.rate(state).real
                gradient = margin_gradient(link.flow, link.ends_by, y)
                total = R @ total + np.outer(after - R @ before, gradient @ total) / (gradient @ before)
        tangent = self._tangent()
        reduced = np.linalg.lstsq(tangent, total @ tangent, rcond=None)[0]
        values = np.linalg.eigvals(reduced)
        trivial = np.argsort(np.abs(values - 1), kind="stable")[: 1 + len(self.along)]  # in time, and along each drift
        others = np.delete(values, trivial)
        return others[np.argsort(-np.abs(others), kind="stable")], float(np.abs(values[trivial] - 1).max())

    def _tangent(self) -> np.ndarray:
        """Directions that the constraints leave at the beginning of the cycle, (2 n, 2 n_r)."""
        flow, d = self.links[0].flow, self.x.shape[1]
        if not flow.n_a:
            return np.diag(self.scale)
        J = jacobian(flow.holds, self.x[0])[1][: 2 * flow.n_a] * self.scale
        return self.scale[:, None] * np.linalg.svd(J)[2][2 * flow.n_a : d].T


def places_of(guess: Sequence[PhaseGuess], n: int) -> list[tuple[float, np.ndarray, np.ndarray]]:
    """t, q and u at the beginning of the phases."""
    return [(float(x[2 * n]) if x.size > 2 * n else 0.0, x[:n], x[n : 2 * n]) for _, x, _, _ in guess]


def from_zero(guess: Sequence[PhaseGuess], drift: Drift | None, n: int) -> list[PhaseGuess]:
    """The same phases, shifted to where what drifts is zero at their beginning: a drive to where it was at t = 0."""
    if not drift:
        return list(guess)
    x = guess[0].x
    z = np.append(x[:n], x[2 * n :] if x.size > 2 * n else 0.0)
    shift = z[list(drift.pivots)] @ drift.directions
    whole = np.concatenate([shift[:n], np.zeros(n), shift[n:][: x.size - 2 * n]])
    return [phase._replace(x=phase.x - whole) for phase in guess]


def ending(
    states: tuple[ContactState, ...],
    following: tuple[ContactState, ...],
    jump: Jump | None = None,
    names: Sequence[str] | None = None,
) -> Margin:
    """Which margin vanishes between two phases; ``names`` are those of the contacts, numbers when left out.

    Raises
    ------
    InvalidInput
        When several contacts change at once, or one closes without an impact.
    """
    changed = [i for i, (a, b) in enumerate(zip(states, following, strict=True)) if a != b]
    names = names or [f"contact {i}" for i in range(len(states))]
    if jump is not None:
        causes = jump.closing or tuple(blow.contact for blow in jump.blows)
        if len(causes) != 1:
            raise InvalidInput(
                f"{', '.join(names[i] for i in causes)} strike at once; a cycle needs its events one by one"
            )
        return causes[0], "gap" if jump.closing else "normal"
    if len(changed) != 1:
        raise InvalidInput(
            f"{', '.join(names[i] for i in changed)} change their modes at once; a smaller time step may part them"
        )
    (i,) = changed
    a, b = states[i], following[i]
    if a.mode == ContactMode.OPEN:
        raise InvalidInput(
            f"{names[i]} opens or closes on the way without an impact: its given normal force vanishes, or fixed time "
            "steps have blurred the event; simulate with ns.EventDriven"
        )
    if b.mode == ContactMode.OPEN:
        return i, "normal"
    if a.mode == ContactMode.STICK:
        return i, "friction +" if b.slip > 0 else "friction -"
    if b.mode == ContactMode.STICK or a.slip != b.slip:
        return i, "slip"
    return i, "normal"


def margin_gradient(flow: ModeFlow, key: Margin, x: np.ndarray) -> np.ndarray:
    """Gradient of a margin by the state, (2 n,)."""
    return jacobian(lambda z: np.array([flow.margins(z)[key]]), x)[1][0]
