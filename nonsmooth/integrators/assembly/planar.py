"""Planar bodies in a step: their free motion, the rows of their contacts, and their places afterwards.

v_free = v_0 + dt (g + M^-1 h),    J_j = +(n, arm_j x n),  J_i = -(n, arm_i x n),  the same with t = (-n_y, n_x)
"""

from __future__ import annotations

from math import cos, sin

from nonsmooth.integrators.assembly.beside import shift_body
from nonsmooth.integrators.assembly.guided import lead_guide
from nonsmooth.jit import kernel


@kernel
def predict_planar_body(bodies, b, dt):
    """The free motion of body b in a step, put where its contacts are looked for; one that is still stays where it is,
    whatever pulls."""
    v, v_0, v_free, v_mid, g = bodies.motion.v, bodies.v_0, bodies.v_free, bodies.v_mid, bodies.gravity
    is_free, load = bodies.motion.moves[b] == 1 and bodies.motion.still[b] == 0, bodies.load
    for k in range(3):
        bodies.x_0[b, k] = bodies.motion.x[b, k]
    for k in range(3):
        v_0[b, k] = v[b, k]
        gain = 0.0
        if is_free:
            gain = dt * (g[k] + load[b, k] / bodies.mass[b] if k < 2 else load[b, k] / bodies.moments[b, 0])
        v_free[b, k] = v[b, k] + gain
        v_mid[b, k] = v[b, k] + 0.5 * gain
    if bodies.motion.moves[b] == 0:
        lead_guide(bodies, b)
    shift_body(bodies, b, dt)
    move_planar(bodies, b, 1.0, bodies.shift)


@kernel
def surface_speed(bodies, b, t_x, t_y):
    """Of the surface of body b along a direction of the world."""
    angle = bodies.motion.x[b, 2]
    c, s = cos(angle), sin(angle)
    s_x, s_y = bodies.surface[b, 0], bodies.surface[b, 1]
    return (c * s_x - s * s_y) * t_x + (s * s_x + c * s_y) * t_y


@kernel
def write_rows_planar(bodies, found, c, network):
    """J_i, J_j (2, 3) of contact c, and b_T from the moving surfaces."""
    i, j = network.i[c], network.j[c]
    n_x, n_y = found.normal[c, 0], found.normal[c, 1]
    for part in range(2):
        b = j if part == 1 else i
        J = network.J_j if part == 1 else network.J_i
        sign = 1.0 if part == 1 else -1.0
        arm_x, arm_y = found.point[c, 0] - bodies.motion.x[b, 0], found.point[c, 1] - bodies.motion.x[b, 1]
        J[c, 0, 0], J[c, 0, 1], J[c, 0, 2] = sign * n_x, sign * n_y, sign * (arm_x * n_y - arm_y * n_x)
        J[c, 1, 0], J[c, 1, 1], J[c, 1, 2] = -sign * n_y, sign * n_x, sign * (arm_x * n_x + arm_y * n_y)
    network.b[c, 1] = surface_speed(bodies, j, -n_y, n_x) - surface_speed(bodies, i, -n_y, n_x)


@kernel
def move_planar(bodies, b, dt, v):
    """Move body b by dt v, v (n_b, 3)."""
    for k in range(3):
        bodies.motion.x[b, k] += dt * v[b, k]
