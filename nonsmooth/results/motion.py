"""The motion between the records: coordinates and velocities at any time of a run.

    u(t_k + theta h_k) = u_k + sum_j B_kj theta^j,    q = q_k + h_k (theta u_k + sum_j B_kj theta^(j+1)/(j+1))

Within a step the velocities are a polynomial and the coordinates its integral, so that q' = u everywhere. Where a
system says q' = B u the coordinates have a polynomial of their own, q = q_k + sum_j Q_kj theta^j, straight from one
record to the next where the integrator offers no other.
Between two steps the velocities may jump: the value at that time is the one after it, or, if asked for, before it.
Which polynomial an integrator offers: integrators/radau/polynomial.py (EventDriven, Penalty), adaptive/polynomial.py
(Adaptive), and `between_records` of a step of Moreau–Jean.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from nonsmooth.checks.arrays import as_floats
from nonsmooth.errors import InvalidInput, shown
from nonsmooth.integrators.records import EVENT_KIND, EVENT_T, INCONSISTENT
from nonsmooth.mechanics.system import ContactMode
from nonsmooth.views import Worded, view

RECORDS_DEGREE = 2  # chosen: of the velocities between the records of a time stepping
# chosen: units in the last place of the later end: a time that a sum or a product made is not outside for that
TIME_ROUNDINGS = 4
Side = Literal["left", "right"]


class StateAt(NamedTuple):
    """The state at a time (n_q,), (n_u,), or at times (m,), (m, n_q), (m, n_u)."""

    q: np.ndarray
    u: np.ndarray

    def __repr__(self) -> str:
        return view(Worded, "repr")(self)

    def _repr_html_(self) -> str:
        return view(Worded, "html")(self)


@dataclass(frozen=True, eq=False, repr=False)
class Motion(Worded):
    """A motion in m steps of n coordinates.

    Attributes
    ----------
    t, h : (m,) beginnings and lengths of the steps [s]
    q, u : (m, n) at the beginnings
    B : (m, degree, n) coefficients of the velocities
    Q : (m, degree, n_q) coefficients of the coordinates where q' = B u, or None
    start, end : (time [s], q (n,), u (n,))
        The state before an impact at the start, and after one at the end.
    """

    t: np.ndarray
    h: np.ndarray
    q: np.ndarray
    u: np.ndarray
    B: np.ndarray
    start: tuple[float, np.ndarray, np.ndarray]
    end: tuple[float, np.ndarray, np.ndarray]
    Q: np.ndarray | None = None

    def __call__(self, t: ArrayLike, side: Side = "right") -> StateAt:
        """The state at t [s]; where the velocities jump, the one after (``side="right"``) or before it.

        Raises
        ------
        InvalidInput
            For a time outside the motion, or another side.
        """
        if not isinstance(side, str) or side not in ("left", "right"):
            raise InvalidInput(f"side must be 'left' or 'right'; got {shown(side)}")
        times = as_floats("t", t)
        moments = times.reshape(-1)
        slack = TIME_ROUNDINGS * np.spacing(max(abs(self.start[0]), abs(self.end[0])))
        outside = ~((moments >= self.start[0] - slack) & (moments <= self.end[0] + slack))
        moments = np.where(outside, moments, np.clip(moments, self.start[0], self.end[0]))
        if times.ndim > 1 or outside.any():
            got = f"{moments[outside][0]:g}" if outside.any() else f"an array of shape {times.shape}"
            raise InvalidInput(f"t must be a time within [{self.start[0]:g}, {self.end[0]:g}], or a vector of such "
                               f"times; got {got}")  # fmt: skip
        k = np.searchsorted(self.t, moments, side) - 1
        q, u = self.within(k, moments)
        for place, is_there in ((self.start, k < 0), (self.end, (moments == self.end[0]) & (side == "right"))):
            q[is_there], u[is_there] = place[1:]
        return StateAt(q, u) if times.ndim else StateAt(q[0], u[0])

    def within(self, k: np.ndarray, t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """q and u (m, n) at the times t (m,) of the steps k (m,)."""
        if not len(self.t):
            return np.tile(self.end[1], (len(t), 1)), np.tile(self.end[2], (len(t), 1))
        theta = np.clip((t - self.t[k]) / self.h[k], 0.0, 1.0)[:, None]
        u, area = np.zeros((len(t), self.u.shape[1])), np.zeros((len(t), self.u.shape[1]))
        for j in range(self.B.shape[1], 0, -1):
            u = theta * (self.B[k, j - 1] + u)
            area = self.B[k, j - 1] / (j + 1) + theta * area
        if self.Q is None:
            return self.q[k] + theta * self.h[k][:, None] * (self.u[k] + theta * area), self.u[k] + u
        q = np.zeros((len(t), self.q.shape[1]))
        for j in range(self.Q.shape[1], 0, -1):
            q = theta * (self.Q[k, j - 1] + q)
        return self.q[k] + q, self.u[k] + u

    def after(self, earlier: Motion) -> Motion:
        """This motion behind an earlier one."""
        return join_motions([earlier.steps, self.steps], earlier.start, self.end)

    def last_step(self) -> Motion:
        """The last step alone."""
        t, h, q, u, B, *Q = (column[-1:] for column in self.steps)
        return Motion(t, h, q, u, B, self.start, self.end, *Q)

    @property
    def steps(self) -> tuple[np.ndarray, ...]:
        """The columns of the steps: t, h, q, u, B, and Q where there is one."""
        return self.t, self.h, self.q, self.u, self.B, *(() if self.Q is None else (self.Q,))


def join_motions(
    blocks: Sequence[tuple[np.ndarray, ...]], start: tuple, end: tuple, is_straight: bool = False
) -> Motion:
    """The motion of one block of steps (t, h, q, u, B) after the other, to the largest of their degrees;
    ``is_straight``: q' is not u, and the coordinates go straight through each step."""
    t, h, q, u, polynomials, *Q = zip(*blocks, strict=True)
    degree = max(B.shape[1] for B in polynomials)
    padded = [np.pad(B, ((0, 0), (0, degree - B.shape[1]), (0, 0))) for B in polynomials]
    t, h, q, u, B, *Q = (np.concatenate(column) for column in (t, h, q, u, padded, *Q))
    if is_straight and not Q:
        Q = [(np.vstack((q[1:], end[1])) - q)[:, None]]
    return Motion(t, h, q, u, B, start, end, *Q)


def of_records(
    theta: float, is_straight: bool, t: np.ndarray, q: np.ndarray, u: np.ndarray, mode: np.ndarray, events: np.ndarray
) -> Motion:
    """The motion between the records of a time stepping, whose events are the rows ``events``: a step in which a
    contact lands, or sliding had no force, has a jump. ``is_straight``: q' is not u."""
    lands = ((mode[:-1] == ContactMode.OPEN) & (mode[1:] != ContactMode.OPEN)).any(axis=1)
    seizes = np.isin(t[:-1], events[events[:, EVENT_KIND] == INCONSISTENT, EVENT_T])
    return between_records(t, q, u, lands & ~seizes, seizes, theta, is_straight)


def between_records(
    t: np.ndarray, q: np.ndarray, u: np.ndarray, jumps: np.ndarray, seizes: np.ndarray, theta: float,
    is_straight: bool = False,
) -> Motion:  # fmt: skip
    """The motion between the records of a time stepping whose every step was recorded.

    The velocities of a smooth step are the parabola between u_0 and u_1 whose mean is (q_1 - q_0)/dt: for theta = 1/2 a
    straight line. In a step with an impact they are u_0 until (1 - theta) dt and u_1 after it, as q_1 of the step is
    computed; theta = 1 leaves no time before it, and the impact is spread over the step. An impact without collision is
    taken before its step, which begins with the velocities u_+ = ((q_1 - q_0)/dt - theta u_1)/(1 - theta).

    Parameters
    ----------
    t, q, u : (m + 1,), (m + 1, n), (m + 1, n)
        The records.
    jumps, seizes : (m,) bool
        Which steps have an impact, and which an impact without collision before them.
    theta : float
        Weight of the new velocity in the position.
    is_straight : bool
        Whether the coordinates go straight between two records, and velocities are no rates of theirs.
    """
    split = t[:-1] + (1.0 - theta) * np.diff(t)
    jumps = jumps & (split > t[:-1]) & (split < t[1:])
    q_split = q[:-1] + (1.0 - theta) * (np.diff(q, axis=0) if is_straight else np.diff(t)[:, None] * u[:-1])
    where = np.flatnonzero(jumps) + 1  # nodes within the steps go in before their ends
    node_t, node_q = np.insert(t, where, split[jumps]), np.insert(q, where, q_split[jumps], axis=0)
    start_u = u.copy()
    if theta < 1.0 and not is_straight:
        mean = np.diff(q, axis=0) / np.diff(t)[:, None]
        start_u[:-1][seizes] = ((mean - theta * u[1:]) / (1.0 - theta))[seizes]
    begin_u, end_u = np.insert(start_u, where, u[1:][jumps], axis=0), np.insert(u, where, u[:-1][jumps], axis=0)
    h = np.diff(node_t)
    change = end_u[1:] - begin_u[:-1]
    moved = np.diff(node_q, axis=0)
    mean = 0.5 * change if is_straight else moved / h[:, None] - begin_u[:-1]
    B = np.zeros((len(h), RECORDS_DEGREE, u.shape[1]))
    B[:, 0], B[:, 1] = 6.0 * mean - 2.0 * change, 3.0 * change - 6.0 * mean
    ends = (t[0], q[0], u[0]), (t[-1], q[-1], u[-1])
    return Motion(node_t[:-1], h, node_q[:-1], begin_u[:-1], B, *ends, moved[:, None] if is_straight else None)
