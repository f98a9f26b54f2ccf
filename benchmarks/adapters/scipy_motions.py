"""Motions by SciPy's solve_ivp with events written by hand: what a user writes who has no contact library.

Each function integrates one scene from the state of its Problem to its end with a relative tolerance, mode by mode
(scipy_pieces). It returns (positions at the times, seconds, evaluations, steps).
"""

import math

import numpy as np

from .scipy_contacts import Contacts, move
from .scipy_pieces import Pieces, falling


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


def rocking_block(problem, p, rtol):
    """The block turns about one corner, then about the other, with Housner's ratio of the rates; e = 0."""
    pieces = Pieces(problem, rtol)
    t, q0, u0 = problem.start
    a, b = p.width / 2, p.height / 2
    ratio = 1 - 1.5 * a * a / (a * a + b * b)
    y, corner = np.array([*q0, u0[2]]), -math.copysign(a, q0[2])
    while t < pieces.t_end and abs(y[3]) > rtol / 100 or y[2] != 0:

        def rates(t, y, corner=corner):
            s, c, w = math.sin(y[2]), math.cos(y[2]), y[3]
            arm = corner * c + b * s  # from the centre to the corner
            return [(corner * s - b * c) * w, -arm * w, w, 0.75 * p.g * arm / (a * a + b * b)]

        t, y, landed = pieces.add(rates, t, y, [falling(lambda t, y, corner=corner: -corner * y[2])])
        if landed is None:
            return pieces.result()
        corner, y = -corner, np.array([y[0], b, 0.0, ratio * y[3]])
    pieces.rest(t, y[:3])
    return pieces.result()


def sprag_slip(problem, p, rtol):
    """One coordinate, y = l sin th; a slide has the signs of v_t = vb - l th' sin th and of the normal force N."""
    pieces = Pieces(problem, rtol)
    t, q0, u0 = problem.start
    m, I, l, vb = p.m, p.I, p.l, p.vb

    def v_t(y):
        return vb - l * y[2] * math.sin(y[1])

    def load(y):
        """Lambda: N = Lambda/M."""
        th, w = y[1:]
        s, c = math.sin(th), math.cos(th)
        inertia = m * l * l * c * c + I
        rest = I * p.ky * l * s - p.kth * m * l * c * (th - p.th0) + inertia * p.R
        return rest - m * I * l * w * w * s + (I * p.cy - p.cth * m) * l * w * c

    def inertia(y, mu_s):
        c = math.cos(y[1])
        return I + m * l * l * c * c * (1 - mu_s * math.tan(y[1]))

    def sliding(mu_s):
        def rates(t, y):
            th, w = y[1:]
            s, c = math.sin(th), math.cos(th)
            xi = 1 - mu_s * s / c
            torque = (p.cth + p.cy * l * l * c * c * xi) * w - m * l * l * s * c * xi * w * w
            torque += p.ky * l * l * s * c * xi + p.kth * (th - p.th0) - l * p.R * mu_s * s
            return [l * c * w, w, -torque / inertia(y, mu_s)]

        return rates

    def stuck(t, y):
        s, c = math.sin(y[1]), math.cos(y[1])
        w = vb / (l * s)
        return [l * c * w, w, -w * w * c / s]

    def stuck_forces(y):
        th, w = y[1:]
        s, c = math.sin(th), math.cos(th)
        w_rate = -w * w * c / s
        N = m * l * (c * w_rate - s * w * w) + p.cy * l * c * w + p.ky * l * s + p.R
        return N, (I * w_rate + p.cth * w + p.kth * (th - p.th0) - (p.R - N) * l * c) / (l * s)

    def friction_left(t, y):
        N, friction = stuck_forces(y)
        return p.mu * abs(N) - abs(friction)

    def consistent(y, signs):
        """Of two slides the one with M > 0; without any the tip is seized."""
        mu_s = p.mu * signs[0] * signs[1]
        return inertia(y, mu_s) > 0 and signs[1] * load(y) > 0

    def seized(y):
        return np.array([y[0], y[1], vb / (l * math.sin(y[1]))])

    y, signs = np.array([*q0, u0[1]]), None
    forward = math.copysign(1.0, v_t(y))
    signs = next((pair for pair in ((forward, 1.0), (forward, -1.0)) if consistent(y, pair)), None)
    y = y if signs else seized(y)
    while t < pieces.t_end:
        if signs is None:
            t, y, _ = pieces.add(stuck, t, y, [falling(friction_left)])
            N, friction = stuck_forces(y)
            signs = math.copysign(1.0, friction), math.copysign(1.0, N)
            continue
        v, n = signs
        ends = [falling(lambda t, y, n=n: n * load(y)), falling(lambda t, y, v=v: v * v_t(y))]
        t, y, end = pieces.add(sliding(p.mu * v * n), t, y, ends)
        if end == 0:  # the force changes its sign, if a slide goes on
            signs = (v, -n) if inertia(y, -p.mu * v * n) > 0 else None
            y = y if signs else seized(y)
        elif end == 1:
            y = seized(y)
            signs = None if friction_left(t, y) > 0 else (-v, n)
    return pieces.result()


def woodpecker(problem, p, rtol):
    """Beak, lower and upper edge; it starts on the lower edge, sliding down."""
    lever = np.array([1.0, p.lM, p.lG])
    mass = p.mS * np.outer(lever, lever) + np.diag([p.mM, p.JM, p.JS])
    normal = np.array([[0.0, 0.0, -p.hS], [0.0, p.hM, 0.0], [0.0, -p.hM, 0.0]])
    tangent = np.array([[1.0, p.lM, p.lG - p.lS], [1.0, p.rM, 0.0], [1.0, p.rM, 0.0]])
    play = np.array([p.lM + p.lG - p.lS - p.r0, p.rM - p.r0, p.rM - p.r0])

    def force(q, u):
        spring = p.cphi * (q[2] - q[1])
        return -p.g * (p.mS * lever + [p.mM, 0.0, 0.0]) + [0.0, spring, -spring]

    toy = Contacts(lambda q: mass, force, lambda q: play + normal @ q, lambda q: (normal, tangent), p.mu,
                   (p.e1, p.e2, p.e3))  # fmt: skip
    return move(problem, rtol, toy, {1: -1.0})


def slider_crank(problem, p, rtol):
    """The corners of the slider are at l1 e^(i th1) + l2 e^(i th2) + corner e^(i th3), complex numbers."""
    j = np.array([1.0, 1.0, -1.0, -1.0])
    corners = np.array([-p.a, p.a, -p.a, p.a]) + 1j * p.b * j
    crank, rod = p.l1 * (p.m1 / 2 + p.m2 + p.m3), p.l2 * (p.m2 / 2 + p.m3)

    def mass(q):
        both = p.l1 * rod * np.cos(q[0] - q[1])
        M = np.diag([p.J1 + p.l1**2 * (p.m1 / 4 + p.m2 + p.m3), p.J2 + p.l2**2 * (p.m2 / 4 + p.m3), p.J3])
        M[0, 1] = M[1, 0] = both
        return M

    def force(q, u):
        twist = p.l1 * rod * np.sin(q[0] - q[1])
        return np.array([
            -twist * u[1] ** 2 - p.g * crank * np.cos(q[0]), twist * u[0] ** 2 - p.g * rod * np.cos(q[1]), 0.0
        ])  # fmt: skip

    def gaps(q):
        height = p.l1 * np.sin(q[0]) + p.l2 * np.sin(q[1]) + corners.real * np.sin(q[2]) + corners.imag * np.cos(q[2])
        return p.b + p.c - j * height

    def rows(q):
        s, c = np.sin(q), np.cos(q)
        up = [np.full(4, p.l1 * c[0]), np.full(4, p.l2 * c[1]), corners.real * c[2] - corners.imag * s[2]]
        along = [np.full(4, -p.l1 * s[0]), np.full(4, -p.l2 * s[1]), -corners.real * s[2] - corners.imag * c[2]]
        return -j[:, None] * np.array(up).T, np.array(along).T

    return move(problem, rtol, Contacts(mass, force, gaps, rows, p.mu, 4 * (p.e,)))


SCENES = {
    "ball through Zeno": ball,
    "sliding block": block,
    "rod, slip and stick": rod,
    "belt, stick-slip": belt,
    "rocking block": rocking_block,
    "pendulum against a wall": pendulum,
    "sprag-slip, limit cycle": sprag_slip,
    "sprag-slip, seizures": sprag_slip,
    "slider-crank": slider_crank,
    "woodpecker": woodpecker,
}
