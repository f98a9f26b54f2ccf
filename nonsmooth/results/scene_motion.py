"""The motion of the bodies of a scene between two records, one step apart.

    x(s) cubic in s = (t - t_0)/h with x(0), x(1), h v(0), h v(1) of the records    (Hermite)

In space a turn is that of the first record and then a rotation phi(s), of the same form, whose rate is J(phi)^-1 omega.
A body that is struck within the step is moved on evenly from the one place to the other, as a step with an impact moves
it: its velocity jumps where the step begins and where it ends, and nothing is smoothed. At a record it is that of the
record. Source: Hairer, Nørsett, Wanner, *Solving Ordinary Differential Equations I* (1993), II.6.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from nonsmooth.scenes.places import conjugate, times, turn_by

SMALL_ANGLE = 1e-4  # chosen: rad, below which series replace quotients of sines: their next terms are below rounding


@dataclass(frozen=True, eq=False)
class SceneMotion:
    """Records of all bodies, one step apart.

    Attributes
    ----------
    t : (m + 1,)
        [s]
    position, velocity : (m + 1, n_b, 2|3)
    turn : (m + 1, n_b) or (m + 1, n_b, 4)
    spin : (m + 1, n_b) or (m + 1, n_b, 3)
    struck : (m, n_b) bool
        Which bodies an impact reaches in a step.
    """

    t: np.ndarray
    position: np.ndarray
    turn: np.ndarray
    velocity: np.ndarray
    spin: np.ndarray
    struck: np.ndarray

    def __call__(self, t: np.ndarray) -> tuple[np.ndarray, ...]:
        """Position, turn, velocity and spin (m', n_b, ...) at times (m',) within the records."""
        k = np.clip(np.searchsorted(self.t, t) - 1, 0, len(self.t) - 2)
        h = (self.t[k + 1] - self.t[k])[:, None, None]
        s, struck = (t - self.t[k])[:, None, None] / h, self.struck[k][..., None]
        position, velocity = within(s, h, *_ends(self.position, k), *_ends(self.velocity, k), struck)
        if self.turn.ndim == 2:
            ends = _ends(self.turn[..., None], k), _ends(self.spin[..., None], k)
            turn, spin = (part[..., 0] for part in within(s, h, *ends[0], *ends[1], struck))
        else:
            first, last = _ends(self.turn, k)
            phi = vector_of(times(last, conjugate(first)))
            rates = self.spin[k], rate_of(phi, self.spin[k + 1])
            angle, rate = within(s, h, np.zeros_like(phi), phi, *rates, struck)
            turn, spin = times(turn_by(angle), first), spin_of(angle, rate)
        found = position, turn, velocity, spin
        records = self.position, self.turn, self.velocity, self.spin
        for at in (k, k + 1):  # at a record its own digits
            is_record = t == self.t[at]
            for column, own in zip(found, records, strict=True):
                column[is_record] = own[at[is_record]]
        return found


def _ends(column: np.ndarray, k: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    return column[k], column[k + 1]


def within(
    s: np.ndarray, h: np.ndarray, q_0: np.ndarray, q_1: np.ndarray, u_0: np.ndarray, u_1: np.ndarray,
    struck: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:  # fmt: skip
    """q and u at parts s of steps h between two ends: the cubic, or of what is struck the straight line."""
    q, u = hermite(s, h, q_0, q_1, u_0, u_1)
    way = q_1 - q_0
    return np.where(struck, q_0 + s * way, q), np.where(struck, way / h, u)


def hermite(
    s: np.ndarray, h: np.ndarray, q_0: np.ndarray, q_1: np.ndarray, u_0: np.ndarray, u_1: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:  # fmt: skip
    """The cubic between two ends, and its rate: u is the parabola from u_0 to u_1 whose mean is (q_1 - q_0)/h."""
    mean, change = (q_1 - q_0) / h - u_0, u_1 - u_0
    b_1, b_2 = 6.0 * mean - 2.0 * change, 3.0 * change - 6.0 * mean
    return q_0 + s * h * (u_0 + s * (b_1 / 2.0 + s * (b_2 / 3.0))), u_0 + s * (b_1 + s * b_2)


def vector_of(turn: np.ndarray) -> np.ndarray:
    """The rotation vector (..., 3) of unit quaternions (..., 4), the shorter way round."""
    turn = np.where(turn[..., :1] < 0.0, -turn, turn)
    size = np.linalg.norm(turn[..., 1:], axis=-1, keepdims=True)
    angle = 2.0 * np.arctan2(size, turn[..., :1])
    return turn[..., 1:] * np.divide(angle, size, out=np.full_like(size, 2.0), where=size > 0.0)


def spin_of(phi: np.ndarray, rate: np.ndarray) -> np.ndarray:
    """omega = J(phi) phi', in the axes of the world."""
    a, b = _quotients(phi)
    across = np.cross(phi, rate)
    return rate + a * across + b * np.cross(phi, across)


def rate_of(phi: np.ndarray, spin: np.ndarray) -> np.ndarray:
    """phi' = J(phi)^-1 omega = omega - phi x omega/2 + c phi x (phi x omega), c = (1 - (x/2) cot(x/2))/x^2."""
    x = np.linalg.norm(phi, axis=-1, keepdims=True)
    is_small = x < SMALL_ANGLE
    half = np.where(is_small, 1.0, 0.5 * x)
    c = np.where(is_small, 1.0 / 12.0, (1.0 - half / np.tan(half)) / (4.0 * half * half))
    across = np.cross(phi, spin)
    return spin - 0.5 * across + c * np.cross(phi, across)


def _quotients(phi: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(1 - cos x)/x^2 and (x - sin x)/x^3 of x = |phi|."""
    x = np.linalg.norm(phi, axis=-1, keepdims=True)
    is_small = x < SMALL_ANGLE
    y = np.where(is_small, 1.0, x)
    return np.where(is_small, 0.5, (1.0 - np.cos(y)) / y**2), np.where(is_small, 1.0 / 6.0, (y - np.sin(y)) / y**3)


def struck_bodies(before: np.ndarray, after: np.ndarray, joined: np.ndarray, moves: np.ndarray) -> np.ndarray:
    """Which bodies (n_b,) bool an impact reaches in a step: those of loaded pairs (n, 2) that carried nothing in the
    step before, and what is loaded or joined with them; what forces do not move hands nothing on."""
    n_b = len(moves)
    landed = after[~np.isin(after[:, 0] * n_b + after[:, 1], before[:, 0] * n_b + before[:, 1])]
    struck, count = np.zeros(n_b, bool), -1
    struck[landed] = True
    struck &= moves
    links = np.concatenate((after, joined))
    while count < (count := int(struck.sum())):
        for i, j in (links[:, 0], links[:, 1]), (links[:, 1], links[:, 0]):
            struck[j[struck[i]]] = True
        struck &= moves
    return struck
