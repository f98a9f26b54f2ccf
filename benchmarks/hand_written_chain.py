"""A planar chain of equal links by hand, as the measure of its derived functions: q_i are absolute angles from below.

    M_ij = w_ij cos(q_i - q_j),    h_i = -sum_j w_ij sin(q_i - q_j) u_j^2 - b_i sin q_i
    w_ij = m a^2 (n - max(i, j) - 1/2),  w_ii = m a^2 (n - i - 3/4) + I,  b_i = m g a (n - i - 1/2)

Contact 0: the tip at the wall; contact 1: joint n//2 + 1 over the ground. Twice: with loops, for any n, and for five
links with the sine and cosine of each angle computed once and the sums over the links shared.
"""

from __future__ import annotations

import math


def mass(t, q, p, M):
    n = q.shape[0]
    for i in range(n):
        M[i, i] = p.m * p.a * p.a * (n - i - 0.75) + p.I
        for j in range(i + 1, n):
            M[i, j] = p.m * p.a * p.a * (n - j - 0.5) * math.cos(q[i] - q[j])
            M[j, i] = M[i, j]


def force(t, q, u, p, h):
    n = q.shape[0]
    for i in range(n):
        h[i] -= p.m * p.g * p.a * (n - i - 0.5) * math.sin(q[i])
        for j in range(i + 1, n):
            pull = p.m * p.a * p.a * (n - j - 0.5) * math.sin(q[i] - q[j])
            h[i] -= pull * u[j] * u[j]
            h[j] += pull * u[i] * u[i]


def normal(t, q, p, W_N):
    n = q.shape[0]
    for i in range(n):
        W_N[0, i] = -p.a * math.cos(q[i])
    for i in range(n // 2 + 1):
        W_N[1, i] = p.a * math.sin(q[i])


def tangent(t, q, p, W_F):
    n = q.shape[0]
    for i in range(n):
        W_F[0, 0, i] = p.a * math.sin(q[i])
    for i in range(n // 2 + 1):
        W_F[1, 0, i] = p.a * math.cos(q[i])


def row_rates(t, q, u, p, r):
    n = q.shape[0]
    for i in range(n):
        s, c = p.a * math.sin(q[i]) * u[i] * u[i], p.a * math.cos(q[i]) * u[i] * u[i]
        r[0, 0] += s
        r[0, 1] += c
        if i <= n // 2:
            r[1, 0] += c
            r[1, 1] -= s


def mass_of_five(t, q, p, M):
    s0, s1, s2, s3, s4 = math.sin(q[0]), math.sin(q[1]), math.sin(q[2]), math.sin(q[3]), math.sin(q[4])
    c0, c1, c2, c3, c4 = math.cos(q[0]), math.cos(q[1]), math.cos(q[2]), math.cos(q[3]), math.cos(q[4])
    w = p.m * p.a * p.a
    for i in range(5):
        M[i, i] = w * (4.25 - i) + p.I
    M[0, 1] = M[1, 0] = 3.5 * w * (c0 * c1 + s0 * s1)
    M[0, 2] = M[2, 0] = 2.5 * w * (c0 * c2 + s0 * s2)
    M[0, 3] = M[3, 0] = 1.5 * w * (c0 * c3 + s0 * s3)
    M[0, 4] = M[4, 0] = 0.5 * w * (c0 * c4 + s0 * s4)
    M[1, 2] = M[2, 1] = 2.5 * w * (c1 * c2 + s1 * s2)
    M[1, 3] = M[3, 1] = 1.5 * w * (c1 * c3 + s1 * s3)
    M[1, 4] = M[4, 1] = 0.5 * w * (c1 * c4 + s1 * s4)
    M[2, 3] = M[3, 2] = 1.5 * w * (c2 * c3 + s2 * s3)
    M[2, 4] = M[4, 2] = 0.5 * w * (c2 * c4 + s2 * s4)
    M[3, 4] = M[4, 3] = 0.5 * w * (c3 * c4 + s3 * s4)


def force_of_five(t, q, u, p, h):
    s0, s1, s2, s3, s4 = math.sin(q[0]), math.sin(q[1]), math.sin(q[2]), math.sin(q[3]), math.sin(q[4])
    c0, c1, c2, c3, c4 = math.cos(q[0]), math.cos(q[1]), math.cos(q[2]), math.cos(q[3]), math.cos(q[4])
    w, b = p.m * p.a * p.a, p.m * p.a * p.g
    v0, v1, v2, v3, v4 = w * u[0] * u[0], w * u[1] * u[1], w * u[2] * u[2], w * u[3] * u[3], w * u[4] * u[4]
    x4, y4 = 0.5 * s4 * v4, 0.5 * c4 * v4
    x3, y3 = x4 + 1.5 * s3 * v3, y4 + 1.5 * c3 * v3
    x2, y2 = x3 + 2.5 * s2 * v2, y3 + 2.5 * c2 * v2
    x1, y1 = x2 + 3.5 * s1 * v1, y2 + 3.5 * c1 * v1
    sx, sy = s0 * v0, c0 * v0
    h[0] = -s0 * (y1 + 4.5 * b) + c0 * x1
    h[1] = -s1 * (y2 + 3.5 * (b + sy)) + c1 * (x2 + 3.5 * sx)
    sx, sy = sx + s1 * v1, sy + c1 * v1
    h[2] = -s2 * (y3 + 2.5 * (b + sy)) + c2 * (x3 + 2.5 * sx)
    sx, sy = sx + s2 * v2, sy + c2 * v2
    h[3] = -s3 * (y4 + 1.5 * (b + sy)) + c3 * (x4 + 1.5 * sx)
    sx, sy = sx + s3 * v3, sy + c3 * v3
    h[4] = -s4 * 0.5 * (b + sy) + c4 * 0.5 * sx


WITH_LOOPS = {"mass": mass, "force": force, "normal": normal, "tangent": tangent, "row_rates": row_rates}
OF_FIVE = WITH_LOOPS | {"mass": mass_of_five, "force": force_of_five}
