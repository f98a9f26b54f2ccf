"""Smooth pieces of a motion by SciPy's solve_ivp, one after the other, with events written by hand.

DOP853 with dense output, a new call after each event, and what all of them cost.
"""

import time

import numpy as np
from scipy.integrate import solve_ivp


class Pieces:
    """Smooth pieces in a row, and what they cost."""

    def __init__(self, problem, rtol):
        self.times, self.rtol, self.n_q = problem.times, max(rtol, 3e-14), problem.system.n_q
        self.t_end, self.q = problem.times[-1], np.zeros((len(problem.times), problem.system.n_q))
        self.evaluations, self.steps, self.start = 0, 0, time.perf_counter()

    def add(self, rates, t, y, events=()):
        """Integrate to the first event or the end: (time, state, number of the event or None)."""
        for event in events:
            event.terminal = True
        piece = solve_ivp(
            rates, (t, self.t_end), y, method="DOP853", rtol=self.rtol, atol=self.rtol / 100, events=events or None,
            dense_output=True,
        )  # fmt: skip
        self.evaluations += piece.nfev
        self.steps += len(piece.t) - 1
        t_1 = piece.t[-1]
        inside = (self.times > t) & (self.times <= t_1)
        if inside.any():
            self.q[inside] = piece.sol(self.times[inside])[: self.n_q].T
        which = next((k for k, found in enumerate(piece.t_events or []) if len(found)), None)
        return t_1, piece.y[:, -1], which

    def rest(self, t, q):
        """Stay where it is from t on."""
        self.q[self.times > t] = q

    def result(self):
        return self.q, time.perf_counter() - self.start, self.evaluations, self.steps


def falling(function):
    """An event that is a fall through zero."""
    function.direction = -1.0
    return function
