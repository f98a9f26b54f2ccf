"""Motions by SciPy's solve_ivp with events written by hand: what a user writes who has no contact library.

Each function integrates one scene from the state of its Problem to its end with a relative tolerance, DOP853, dense
output, and a new call after each event. It returns (positions at the times, seconds, evaluations, steps).
"""

import math
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
    function.direction = -1.0
    return function


def bouncing(problem, rtol, rates, gap, e, is_over):
    """One coordinate that bounces; ``is_over`` tells that the rest of the bounces is below the tolerance."""
    pieces = Pieces(problem, rtol)
    t_0, q0, u0 = problem.start
    t, y = t_0, np.array([q0[0], u0[0]])
    while t < pieces.t_end:
        t, y, hit = pieces.add(rates, t, y, [falling(lambda t, y: gap(y[0]))])
        if hit is None:
            break
        y = np.array([y[0], -e * y[1]])
        if is_over(y[1]):
            pieces.rest(t, y[0])
            break
    return pieces.result()


def ball(problem, p, rtol):
    def is_over(v):
        return v * v / (2 * p.g) < rtol / 100

    return bouncing(problem, rtol, lambda t, y: [y[1], -p.g], lambda q: q, p.e, is_over)


def pendulum(problem, p, rtol):
    rates = lambda t, y: [y[1], -p.g / p.l * math.sin(y[0])]
    return bouncing(problem, rtol, rates, lambda q: p.l * (math.sin(q) - math.sin(p.th_w)), p.e, lambda v: False)


def block(problem, p, rtol):
    pieces = Pieces(problem, rtol)
    t_0, q0, u0 = problem.start
    rates = lambda t, y: [y[2], 0.0, -p.mu * p.g, 0.0]
    t, y, _ = pieces.add(rates, t_0, [*q0, *u0], [falling(lambda t, y: y[2])])
    pieces.rest(t, y[:2])
    return pieces.result()


def belt(problem, p, rtol):
    pieces = Pieces(problem, rtol)
    t_0, q0, u0 = problem.start
    t, y = t_0, np.array([q0[0], u0[0]])

    def slides_back(t, y):
        v = p.vb - y[1]
        return [y[1], (p.N * (p.m0 - p.m1 * v + p.m3 * v**3) - p.k * y[0] - p.c * y[1]) / p.m]

    while t < pieces.t_end:
        t, y, caught = pieces.add(slides_back, t, y, [falling(lambda t, y: p.vb - y[1])])
        if caught is None:
            break
        y = np.array([y[0], p.vb])
        t, y, _ = pieces.add(lambda t, y: [p.vb, 0.0], t, y, [lambda t, y: p.k * y[0] + p.c * p.vb - p.m0 * p.N])
        y = np.array([y[0], p.vb * (1 - 1e-12)])
    return pieces.result()


def rod(problem, p, rtol):
    s, pieces = p.l / 2, Pieces(problem, rtol)
    t_0, q0, u0 = problem.start

    def contact(y):
        th, w = y[2], y[5]
        rows = np.array([[0.0, 1.0, -s * math.cos(th)], [1.0, 0.0, s * math.sin(th)]])
        free = np.array([-p.g, 0.0]) + s * w * w * np.array([math.sin(th), math.cos(th)])
        return rows, rows / [p.m, p.m, p.I], free

    def stuck(y):
        rows, X, free = contact(y)
        return np.linalg.solve(X @ rows.T, -free)

    def sliding(sign):
        def force(y):
            rows, X, free = contact(y)
            direction = np.array([1.0, -sign * p.mu])
            return direction * -free[0] / (X @ rows.T @ direction)[0]

        return force

    def rates(force):
        return lambda t, y: np.concatenate([y[3:], [0.0, -p.g, 0.0] + contact(y)[1].T @ force(y)])

    def friction_left(t, y):
        force = stuck(y)
        return p.mu * force[0] - abs(force[1])

    slip = falling(lambda t, y: y[3] + s * math.sin(y[2]) * y[5])
    t, y, stopped = pieces.add(rates(sliding(1.0)), t_0, [*q0, *u0], [slip])
    if stopped is not None:
        t, y, let_go = pieces.add(rates(stuck), t, y, [falling(friction_left)])
        if let_go is not None:
            pieces.add(rates(sliding(-math.copysign(1.0, stuck(y)[1]))), t, y)
    return pieces.result()


SCENES = {
    "ball through Zeno": ball,
    "sliding block": block,
    "rod, slip and stick": rod,
    "belt, stick-slip": belt,
    "pendulum against a wall": pendulum,
}
