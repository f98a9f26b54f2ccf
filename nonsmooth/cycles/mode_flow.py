"""The smooth flow between two events: each contact open, sticking, or sliding in a known direction.

    [ M   -R^T  -W_s^T ] [ u'   ]   [ h - sum mu N s W_F^T ]       R = W_N - mu n s W_F   of contacts with a gap
    [ W_N   0     0    ] [ la_N ] = [ -(W_N' u + w_N')     ]       W_s = W_F              of contacts that stick
    [ W_s   0     0    ] [ la_F ]   [ -(W_s' u + w_s')     ]

with the signs s of sliding, in space its direction, and n of the normal force as in ``sliding_mode``. A mode lasts
while its margins are positive: the sliding velocity s gamma_F, the normal force n la_N, and for a contact that sticks
mu_s n la_N -+ la_F. An open unilateral contact has its gap for a margin. All of it runs with complex numbers, so that
the flow and its margins can be differentiated exactly. The state is x = (q, u); where model functions read the time it
is (q, u, t), t' = 1. Source: Glocker, *Set-Valued Force Laws* (2001), chapter 5.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from nonsmooth.equilibria.sliding_mode import SlidingMode, mu_of
from nonsmooth.errors import InvalidInput
from nonsmooth.mechanics.acceleration_problem import ROW_RATE_INCREMENT
from nonsmooth.mechanics.laws import static_coefficient
from nonsmooth.mechanics.system import (
    FORCE,
    GAP,
    GAP_RATE,
    MASS,
    NORMAL,
    NORMAL_FORCE,
    ROW_RATES,
    UNILATERAL,
    ContactMode,
)
from nonsmooth.numerics.complex_step import complexified

Margin = tuple[int, str]  # contact, kind: see ``ModeFlow.margins``
mu_static = complexified(static_coefficient)


class ContactState(NamedTuple):
    """What one contact does during a phase."""

    mode: ContactMode
    slip: int  # s, the sign of gamma_F; 0 unless it slides
    normal: int  # n, the sign of la_N; 1 unless the contact is bilateral


class Instant(NamedTuple):
    """The flow at a state: everything complex where the state is."""

    acceleration: np.ndarray  # (n,)
    la_N: np.ndarray  # (n_c,) la_N, or the given normal force
    la_F: np.ndarray  # (n_c,)
    gamma_F: np.ndarray  # (n_c,)


@dataclass(frozen=True, eq=False)
class ModeFlow(SlidingMode):
    """A system whose closed contacts slide in given directions, but for those that stick.

    Parameters
    ----------
    stuck : tuple of int
        The contacts that stick; they are among ``closed``.
    """

    stuck: tuple[int, ...] = ()

    @cached_property
    def inverse_mass(self) -> np.ndarray | None:
        """M^-1 where the mass is constant."""
        return np.linalg.inv(self.constants[MASS]) if MASS in self.constants else None

    def instant(self, x: np.ndarray) -> Instant:
        """Accelerations and forces at a state."""
        system = self.system
        q, u, t = self.parts(x)
        h = self.call(FORCE, q, u, t)
        pressing = self.call(NORMAL_FORCE, q, u, t).copy()
        W_N = self.call(NORMAL, q, u, t) if self.constrained else h[:0]
        W_F, gamma_F = h[:0], pressing * 0
        if system.d:
            W_F, gamma_F = self.along(q, u, t)
        slopes = pressing * 0  # la_F/la_N of the contacts that slide
        forces, rows, rates = [], [], []
        row_rates = self.row_rates(q, u, t) if self.constrained or self.stuck else None
        for i, s, normal, is_constrained, slides in self.contacts:
            if slides:
                slopes[i] = -mu_of(system.laws, i, s * gamma_F[i]) * normal * s
            if is_constrained:
                forces.append(W_N[i] + slopes[i] * W_F[i] if slides else W_N[i])
                rows.append(W_N[i])
                rates.append(row_rates[i, 0])  # type: ignore[index]
            elif slides:
                h = h + slopes[i] * pressing[i] * W_F[i]
        for i in self.stuck:
            forces.append(W_F[i])
            rows.append(W_F[i])
            rates.append(row_rates[i, 1])  # type: ignore[index]
        if forces:
            a, la = _constrained(self.call(MASS, q, u, t), h, forces, rows, rates)
            pressing[self.constrained] = la[: self.n_a]
        else:
            a, la = self.accelerated(q, u, t, h), h[:0]
        la_F = slopes * pressing
        if self.stuck:
            la_F[list(self.stuck)] = la[self.n_a :]
        return Instant(a, pressing, la_F, gamma_F)

    @cached_property
    def open(self) -> list[int]:
        """The unilateral contacts that are open."""
        kinds = self.system.kinds[:, 0]
        return [i for i in range(self.system.n_c) if kinds[i] == UNILATERAL and i not in self.closed]

    @cached_property
    def contacts(self) -> list[tuple[int, float, float, bool, bool]]:
        """Of each closed contact: its number, s, n, whether it has a gap, and whether it slides with friction."""
        return [
            (i, self.sliding[i], self.normal[i], i in self.constrained,
             i not in self.stuck and bool(self.system.kinds[i, 1]))
            for i in self.closed
        ]  # fmt: skip

    def parts(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray, Any]:
        """q, u and t of a state."""
        n = self.system.n_u
        return x[:n], x[n : 2 * n], x[2 * n] if x.size > 2 * n else self.t

    def accelerated(self, q: np.ndarray, u: np.ndarray, t: Any, h: np.ndarray) -> np.ndarray:
        """M^-1 h."""
        return np.linalg.solve(self.call(MASS, q, u, t), h) if self.inverse_mass is None else self.inverse_mass @ h

    def rate(self, x: np.ndarray) -> np.ndarray:
        """x' = (u, u'), or (u, u', 1)."""
        n, rate = self.system.n_u, np.ones(x.size, complex)
        rate[:n], rate[n : 2 * n] = x[n : 2 * n], self.instant(x).acceleration
        return rate

    def row_rates(self, q: np.ndarray, u: np.ndarray, t: Any) -> np.ndarray:
        """W' u + w' (n_c, 1 + d), from the model or by a fourth-order difference along the motion; of friction the
        first row, which is asked for where it has one."""
        if ROW_RATES in self.system.functions:
            return self.call(ROW_RATES, q, u, t)
        e = ROW_RATE_INCREMENT / max(float(np.abs(u).max()), 1.0)
        ahead = [self.row_velocities(q + k * e * u, u, t + k * e) for k in (-2, -1, 1, 2)]
        return (ahead[0] - 8 * ahead[1] + 8 * ahead[2] - ahead[3]) / (12 * e)

    def row_velocities(self, q: np.ndarray, u: np.ndarray, t: Any) -> np.ndarray:
        """gamma_N and gamma_F (n_c, 2), or gamma_N alone without friction."""
        gamma_N = self.call(NORMAL, q, u, t) @ u + self.call(GAP_RATE, q, u, t)
        if not self.system.d:
            return gamma_N[:, None]
        return np.stack([gamma_N, self.along(q, u, t)[1]], axis=1)

    def margins(self, x: np.ndarray) -> dict[Margin, complex]:
        """What must stay positive while the mode lasts, by contact and kind.

        "gap": g_N of an open contact; "slip": s gamma_F; "normal": n la_N; "friction +", "friction -": mu_s n la_N +
        la_F and - la_F of a contact that sticks: the first vanishes where it begins to slide with s = +1.
        """
        now, found = self.instant(x), {}
        if self.open:
            q, _, t = self.parts(x)
            g_N = self.call(GAP, q, q, t)
            found.update({(i, "gap"): g_N[i] for i in self.open})
        for i in self.closed:
            pressing = self.normal[i] * now.la_N[i]
            if i in self.stuck:
                reach = mu_static(self.system.laws, i) * (pressing if pressing.real > 0 else -pressing)
                found[i, "friction +"] = reach + now.la_F[i]
                found[i, "friction -"] = reach - now.la_F[i]
                if self.system.kinds[i, 0] == UNILATERAL:
                    found[i, "normal"] = now.la_N[i]
                continue
            if self.system.kinds[i, 1]:
                found[i, "slip"] = self.sliding[i] * now.gamma_F[i]
            found[i, "normal"] = pressing
        return found

    def holds(self, x: np.ndarray) -> np.ndarray:
        """What the mode keeps at zero: g_N and gamma_N of the constraints, gamma_F of the contacts that stick."""
        q, u, t = self.parts(x)
        gamma = self.row_velocities(q, u, t)
        stuck = gamma[list(self.stuck), 1] if self.stuck else np.zeros(0)
        return np.concatenate([self.gaps(q, t), gamma[self.constrained, 0], stuck])


def mode_flow(system, states: tuple[ContactState, ...], t: float = 0.0) -> ModeFlow:  # type: ignore[no-untyped-def]
    """The flow in which each contact does what its state says."""
    closed = tuple(i for i, state in enumerate(states) if state.mode != ContactMode.OPEN)
    stuck = tuple(i for i in closed if states[i].mode == ContactMode.STICK)
    in_space = system.kinds[:, 1] == 2
    for i in stuck:
        if in_space[i]:
            raise InvalidInput(
                f"{system.described.contacts[i]} sticks; with friction in two directions cycles are computed that "
                "slide or fly all the time: where a slide stops, its direction has no derivative"
            )
    sliding = np.where(in_space, 1.0, [float(state.slip) for state in states])
    normal = np.array([float(state.normal) for state in states])
    return ModeFlow(system, closed, sliding, normal, t, stuck)


def _constrained(M, h, forces, rows, rates):  # type: ignore[no-untyped-def]
    """a and la of M a = h + forces^T la, rows a = -rates."""
    n, k = h.size, len(rows)
    A = np.zeros((n + k, n + k), complex)
    A[:n, :n] = M
    A[:n, n:] = -np.array(forces).T
    A[n:, :n] = rows
    x = np.linalg.solve(A, np.concatenate([h, -np.array(rates)]))
    return x[:n], x[n:]
