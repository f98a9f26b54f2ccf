"""Spatial bodies in a step: free rotation, the rows of their contacts, and their places afterwards.

A free body turns by the implicit mid-point rule on the rotation group, with L the angular momentum in the world, Pi in
the body, I the principal moments and cay the Cayley map, a rotation by 2 atan(dt |omega|/2):

    omega = I^-1 (Pi_0 + Pi_1)/2,    Pi_1 = cay(-dt omega) Pi_0,    R_1 = R_0 cay(dt omega)

so that L = R Pi is kept to rounding, and so is the energy Pi.I^-1 Pi/2, however long the step. A body turns freely to
where its contacts are looked for, in the middle of the step or at its beginning (bodies.py); there impulses change its
momenta, and from there it turns freely to the end of the step: they do the work P.J (v_0 + v_1)/2 and no other.

The mid-point rule is the quadratic equation I omega + dt/2 omega x I omega = Pi_0, solved by Newton's method; its
iteration as a fixed point contracts by dt |omega|/2 times the ratio of the moments, and a rod of 1 : 30 diverges from
0.1 rad a step on. Where Newton's method finds no solution, in some steps of more than a radian, the body turns about L
by the part of omega along it, which keeps both too. Source: Austin, Krishnaprasad and Wang, *J. Comput. Phys.* 107
(1993) 105-117.
Equations: docs/theory/scenes.md, (4).
"""

from __future__ import annotations

from math import sqrt

from nonsmooth.contact.network.problem import Network
from nonsmooth.integrators.assembly.beside import shift_body
from nonsmooth.integrators.assembly.bodies import Bodies
from nonsmooth.integrators.assembly.guided import lead_guide
from nonsmooth.jit import kernel
from nonsmooth.jit.blocks import view
from nonsmooth.numerics.rounding import rounded_sum

MOST_ROTATION_STEPS = 40  # measured: of the mid-point of a free rotation: two to four, up to 23 in steps of many turns
STEP_HALVINGS = 12  # chosen: of one of these
ROTATION_ROUNDINGS = 64  # chosen: of the terms of its equation: what it leaves less of is solved


@kernel
def cross(a_0, a_1, a_2, b_0, b_1, b_2):
    """a x b."""
    return a_1 * b_2 - a_2 * b_1, a_2 * b_0 - a_0 * b_2, a_0 * b_1 - a_1 * b_0


@kernel
def turn_by(x, b, v_0, v_1, v_2):
    """A vector of body b's axes in those of the world, v + 2 r x (r x v + w v) with the quaternion (w, r) of x[b]."""
    w, r_0, r_1, r_2 = x[b, 3], x[b, 4], x[b, 5], x[b, 6]
    c_0, c_1, c_2 = cross(r_0, r_1, r_2, v_0, v_1, v_2)
    d_0, d_1, d_2 = cross(r_0, r_1, r_2, c_0 + w * v_0, c_1 + w * v_1, c_2 + w * v_2)
    return v_0 + 2.0 * d_0, v_1 + 2.0 * d_1, v_2 + 2.0 * d_2


@kernel
def turn_back(x, b, v_0, v_1, v_2):
    """A vector of the world in the axes of body b."""
    w, r_0, r_1, r_2 = x[b, 3], x[b, 4], x[b, 5], x[b, 6]
    c_0, c_1, c_2 = cross(r_0, r_1, r_2, v_0, v_1, v_2)
    d_0, d_1, d_2 = cross(r_0, r_1, r_2, c_0 - w * v_0, c_1 - w * v_1, c_2 - w * v_2)
    return v_0 + 2.0 * d_0, v_1 + 2.0 * d_1, v_2 + 2.0 * d_2


@kernel
def cayley_of(h_0, h_1, h_2, v_0, v_1, v_2):
    """cay(2 h) v, the rotation whose quaternion is (1, h)/sqrt(1 + h.h): v + 2 h x (v + h x v)/(1 + h.h)."""
    c_0, c_1, c_2 = cross(h_0, h_1, h_2, v_0, v_1, v_2)
    d_0, d_1, d_2 = cross(h_0, h_1, h_2, v_0 + c_0, v_1 + c_1, v_2 + c_2)
    factor = 2.0 / (1.0 + h_0 * h_0 + h_1 * h_1 + h_2 * h_2)
    return v_0 + factor * d_0, v_1 + factor * d_1, v_2 + factor * d_2


@kernel
def imbalance_of_rotation(I, P, o, h):
    """f = I omega + h omega x I omega - P, and |f|^2 in the metric of I^-1."""
    c_0, c_1, c_2 = cross(o[0], o[1], o[2], I[0] * o[0], I[1] * o[1], I[2] * o[2])
    f_0, f_1, f_2 = I[0] * o[0] + h * c_0 - P[0], I[1] * o[1] + h * c_1 - P[1], I[2] * o[2] + h * c_2 - P[2]
    return (f_0, f_1, f_2), f_0 * f_0 / I[0] + f_1 * f_1 / I[1] + f_2 * f_2 / I[2]


@kernel
def newton_step_of_rotation(I, o, f, h):
    """-(df/domega)^-1 f by minors, and 0 where it has none."""
    a, b, c = h * (I[2] - I[1]), h * (I[0] - I[2]), h * (I[1] - I[0])
    J_01, J_02, J_10, J_12, J_20, J_21 = a * o[2], a * o[1], b * o[2], b * o[0], c * o[1], c * o[0]
    A_00, A_01, A_02 = I[1] * I[2] - J_12 * J_21, J_12 * J_20 - J_10 * I[2], J_10 * J_21 - I[1] * J_20
    A_10, A_11, A_12 = J_02 * J_21 - J_01 * I[2], I[0] * I[2] - J_02 * J_20, J_01 * J_20 - I[0] * J_21
    A_20, A_21, A_22 = J_01 * J_12 - J_02 * I[1], J_02 * J_10 - I[0] * J_12, I[0] * I[1] - J_01 * J_10
    determinant = I[0] * A_00 + J_01 * A_01 + J_02 * A_02
    scale = -1.0 / determinant if determinant != 0.0 else 0.0
    s_0 = scale * (A_00 * f[0] + A_10 * f[1] + A_20 * f[2])
    s_1 = scale * (A_01 * f[0] + A_11 * f[1] + A_21 * f[2])
    return s_0, s_1, scale * (A_02 * f[0] + A_12 * f[1] + A_22 * f[2])


@kernel
def middle_of_rotation(I, start, h):
    """omega in the middle of a free step of length 2 h in the axes of the body, from that at its beginning."""
    P, o = (I[0] * start[0], I[1] * start[1], I[2] * start[2]), start
    size_P = abs(P[0]) + abs(P[1]) + abs(P[2])
    f, size = imbalance_of_rotation(I, P, o, h)
    for _ in range(MOST_ROTATION_STEPS):
        s, length, is_less = newton_step_of_rotation(I, o, f, h), 1.0, False
        wide = size_P * (1.0 + h * (abs(o[0]) + abs(o[1]) + abs(o[2])))
        is_solved = abs(f[0]) + abs(f[1]) + abs(f[2]) <= rounded_sum(ROTATION_ROUNDINGS, wide)
        for _ in range(1 if is_solved else STEP_HALVINGS):
            after = (o[0] + length * s[0], o[1] + length * s[1], o[2] + length * s[2])
            f_after, size_after = imbalance_of_rotation(I, P, after, h)
            if size_after < size:
                o, f, size, is_less = after, f_after, size_after, True
                break
            length *= 0.5
        if not is_less:
            if is_solved:
                return o
            break
    along = (start[0] * P[0] + start[1] * P[1] + start[2] * P[2]) / (P[0] * P[0] + P[1] * P[1] + P[2] * P[2])
    return along * P[0], along * P[1], along * P[2]


@kernel
def rotate_freely(bodies, b, o_0, o_1, o_2, dt):
    """omega at the middle and at the end of a free step of body b from its place, in the axes of the world."""
    I_0, I_1, I_2 = bodies.moments[b, 0], bodies.moments[b, 1], bodies.moments[b, 2]
    if (I_0 == I_1 and I_1 == I_2) or (o_0 == 0.0 and o_1 == 0.0 and o_2 == 0.0):
        return o_0, o_1, o_2, o_0, o_1, o_2
    x = bodies.motion.x
    o_0, o_1, o_2 = turn_back(x, b, o_0, o_1, o_2)
    P_0, P_1, P_2 = I_0 * o_0, I_1 * o_1, I_2 * o_2
    o_0, o_1, o_2 = middle_of_rotation((I_0, I_1, I_2), (o_0, o_1, o_2), 0.5 * dt)
    E_0, E_1, E_2 = cayley_of(-0.5 * dt * o_0, -0.5 * dt * o_1, -0.5 * dt * o_2, P_0, P_1, P_2)
    # E/I is the velocity at the end in the axes of the body there, which cay(dt omega) turns to those of the beginning
    e_0, e_1, e_2 = cayley_of(0.5 * dt * o_0, 0.5 * dt * o_1, 0.5 * dt * o_2, E_0 / I_0, E_1 / I_1, E_2 / I_2)
    o_0, o_1, o_2 = turn_by(x, b, o_0, o_1, o_2)
    e_0, e_1, e_2 = turn_by(x, b, e_0, e_1, e_2)
    return o_0, o_1, o_2, e_0, e_1, e_2


@kernel
def predict_spatial_body(bodies, b, dt):
    """The free motion of body b in a step, put where its contacts are looked for; one that is still stays where it is,
    whatever pulls."""
    v, v_0, v_free, v_mid, g = bodies.motion.v, bodies.v_0, bodies.v_free, bodies.v_mid, bodies.gravity
    is_free = bodies.motion.moves[b] == 1 and bodies.motion.still[b] == 0
    for k in range(7):
        bodies.x_0[b, k] = bodies.motion.x[b, k]
    for k in range(6):
        v_0[b, k] = v[b, k]
        gain = dt * (g[k] + bodies.load[b, k] / bodies.mass[b]) if k < 3 and is_free else 0.0
        v_free[b, k] = v[b, k] + gain
        v_mid[b, k] = v[b, k] + 0.5 * gain
    if bodies.motion.moves[b] == 0:
        lead_guide(bodies, b)
    shift_body(bodies, b, dt)
    if is_free and bodies.keeps[b] == 1:
        m_0, m_1, m_2, e_0, e_1, e_2 = rotate_freely(bodies, b, v[b, 3], v[b, 4], v[b, 5], 0.5 * dt)
        v_mid[b, 3], v_mid[b, 4], v_mid[b, 5] = m_0, m_1, m_2
        v_free[b, 3], v_free[b, 4], v_free[b, 5] = e_0, e_1, e_2
        v_0[b, 3], v_0[b, 4], v_0[b, 5] = e_0, e_1, e_2  # of the same energy: impulses are booked from here
        shift = bodies.shift
        shift[b, 3], shift[b, 4], shift[b, 5] = 0.5 * dt * m_0, 0.5 * dt * m_1, 0.5 * dt * m_2
    move_spatial(bodies, b, 1.0, bodies.shift)
    if is_free:
        kick_spin(bodies, b, dt)


@kernel
def kick_of(bodies, b, dt):
    """I^-1 dt torque of body b at its present place."""
    load, x = bodies.load, bodies.motion.x
    p_0, p_1, p_2 = turn_back(x, b, dt * load[b, 3], dt * load[b, 4], dt * load[b, 5])
    return turn_by(x, b, p_0 / bodies.moments[b, 0], p_1 / bodies.moments[b, 1], p_2 / bodies.moments[b, 2])


@kernel
def kick_spin(bodies, b, dt):
    """Add what the applied torque gives to the free motion of body b, where its contacts are looked for."""
    kick = bodies.kick
    kick[b, 0], kick[b, 1], kick[b, 2] = kick_of(bodies, b, dt)
    for k in range(3):
        bodies.v_free[b, 3 + k] += kick[b, k]


@kernel
def move_freely(bodies, b, v, dt, lands):
    """Move a free body by its translation, and turn it on from where its contacts were looked for; v[b] is its velocity
    there."""
    move, shift = bodies.v_move, bodies.shift
    move_spatial_by(
        bodies, b, (dt * move[b, 0], dt * move[b, 1], dt * move[b, 2]), (shift[b, 3], shift[b, 4], shift[b, 5])
    )
    free, is_kept = bodies.v_free, bodies.keeps[b] == 1
    is_struck = v[b, 3] != free[b, 3] or v[b, 4] != free[b, 4] or v[b, 5] != free[b, 5]
    if is_struck and is_kept == lands:
        turn_at_once(bodies, b, v, dt, 1.0 if lands else 0.5)
        return
    rest, early = (0.5 * dt, 0.0) if is_kept else (dt, 0.5)  # of a torque on what turns freely: half acts at the end
    k_0, k_1, k_2 = early * bodies.kick[b, 0], early * bodies.kick[b, 1], early * bodies.kick[b, 2]
    m_0, m_1, m_2, e_0, e_1, e_2 = rotate_freely(bodies, b, v[b, 3] - k_0, v[b, 4] - k_1, v[b, 5] - k_2, rest)
    move_spatial_by(bodies, b, (0.0, 0.0, 0.0), (rest * m_0, rest * m_1, rest * m_2))
    k_0, k_1, k_2 = kick_of(bodies, b, early * dt)
    move[b, 3] = (shift[b, 3] + rest * m_0) / dt
    move[b, 4] = (shift[b, 4] + rest * m_1) / dt
    move[b, 5] = (shift[b, 5] + rest * m_2) / dt
    bodies.spin[b, 0], bodies.spin[b, 1], bodies.spin[b, 2] = e_0 + k_0, e_1 + k_1, e_2 + k_2


@kernel
def turn_at_once(bodies, b, v, dt, weight):
    """Turn a body through the whole step as its centre goes, by the velocity after the impulses or by the mean.

    That is so in the steps in which it begins to be held, or no longer is; its angular momentum is kept.
    """
    x, move, free = bodies.motion.x, bodies.v_move, bodies.v_free
    I_0, I_1, I_2 = bodies.moments[b, 0], bodies.moments[b, 1], bodies.moments[b, 2]
    p_0, p_1, p_2 = turn_back(x, b, v[b, 3], v[b, 4], v[b, 5])
    L_0, L_1, L_2 = turn_by(x, b, I_0 * p_0, I_1 * p_1, I_2 * p_2)
    for k in range(3, 7):
        x[b, k] = bodies.x_0[b, k]
    for k in range(3, 6):
        move[b, k] = weight * v[b, k] + (1.0 - weight) * (free[b, k] - bodies.kick[b, k - 3])
    move_spatial_by(bodies, b, (0.0, 0.0, 0.0), (dt * move[b, 3], dt * move[b, 4], dt * move[b, 5]))
    p_0, p_1, p_2 = turn_back(x, b, L_0, L_1, L_2)
    bodies.spin[b, 0], bodies.spin[b, 1], bodies.spin[b, 2] = turn_by(x, b, p_0 / I_0, p_1 / I_1, p_2 / I_2)


@kernel
def take_spins(bodies, v):
    """Let the spins of free bodies in v be those at the end of the step."""
    for b in range(bodies.mass.shape[0]):
        if bodies.motion.moves[b] == 1 and bodies.motion.still[b] == 0:
            v[b, 3], v[b, 4], v[b, 5] = bodies.spin[b, 0], bodies.spin[b, 1], bodies.spin[b, 2]


@kernel
def write_inertia(bodies, b, network):
    """M and M^-1 of body b: its principal moments, turned to the axes of the world."""
    I_0, I_1, I_2 = bodies.moments[b, 0], bodies.moments[b, 1], bodies.moments[b, 2]
    M, M_inv, x = network.M, network.M_inv, bodies.motion.x
    for column in range(3):
        e_0, e_1, e_2 = 1.0 if column == 0 else 0.0, 1.0 if column == 1 else 0.0, 1.0 if column == 2 else 0.0
        p_0, p_1, p_2 = turn_back(x, b, e_0, e_1, e_2)
        a_0, a_1, a_2 = turn_by(x, b, I_0 * p_0, I_1 * p_1, I_2 * p_2)
        c_0, c_1, c_2 = turn_by(x, b, p_0 / I_0, p_1 / I_1, p_2 / I_2)
        M[b, 3, 3 + column], M[b, 4, 3 + column], M[b, 5, 3 + column] = a_0, a_1, a_2
        M_inv[b, 3, 3 + column], M_inv[b, 4, 3 + column], M_inv[b, 5, 3 + column] = c_0, c_1, c_2


@kernel("void(int64, int64)")
def turn_inertia(bodies_at, network_at):
    """M and M^-1 of all bodies whose moments differ, at their present places."""
    bodies, network = view(bodies_at, Bodies), view(network_at, Network)
    for b in range(bodies.mass.shape[0]):
        I_0, I_1, I_2 = bodies.moments[b, 0], bodies.moments[b, 1], bodies.moments[b, 2]
        is_free = bodies.motion.moves[b] == 1 and bodies.motion.still[b] == 0
        if is_free and not (I_0 == I_1 and I_1 == I_2):
            write_inertia(bodies, b, network)


@kernel
def tangent(n_0, n_1, n_2):
    """A unit vector at right angles to n, which a small turn of n moves little (but where |n_0| passes 0.6)."""
    if abs(n_0) < 0.6:
        t_0, t_1, t_2 = 1.0 - n_0 * n_0, -n_0 * n_1, -n_0 * n_2
    else:
        t_0, t_1, t_2 = -n_1 * n_0, 1.0 - n_1 * n_1, -n_1 * n_2
    scale = 1.0 / sqrt(t_0 * t_0 + t_1 * t_1 + t_2 * t_2)
    return scale * t_0, scale * t_1, scale * t_2


@kernel
def write_row(bodies, b, sign, point, axis, J, c, row):
    """One row of J of a contact: sign (axis, arm x axis)."""
    x = bodies.motion.x
    m_0, m_1, m_2 = cross(point[0] - x[b, 0], point[1] - x[b, 1], point[2] - x[b, 2], axis[0], axis[1], axis[2])
    J[c, row, 0], J[c, row, 1], J[c, row, 2] = sign * axis[0], sign * axis[1], sign * axis[2]
    J[c, row, 3], J[c, row, 4], J[c, row, 5] = sign * m_0, sign * m_1, sign * m_2


@kernel
def write_rows_spatial(bodies, found, c, network):
    """J_i, J_j (3, 6) of contact c, and b_T from the moving surfaces."""
    i, j = network.i[c], network.j[c]
    n = (found.normal[c, 0], found.normal[c, 1], found.normal[c, 2])
    point = (found.point[c, 0], found.point[c, 1], found.point[c, 2])
    t = tangent(n[0], n[1], n[2])
    s = cross(n[0], n[1], n[2], t[0], t[1], t[2])
    write_row(bodies, i, -1.0, point, n, network.J_i, c, 0)
    write_row(bodies, j, 1.0, point, n, network.J_j, c, 0)
    write_row(bodies, i, -1.0, point, t, network.J_i, c, 1)
    write_row(bodies, j, 1.0, point, t, network.J_j, c, 1)
    write_row(bodies, i, -1.0, point, s, network.J_i, c, 2)
    write_row(bodies, j, 1.0, point, s, network.J_j, c, 2)
    a_0, a_1, a_2 = turn_by(bodies.motion.x, i, bodies.surface[i, 0], bodies.surface[i, 1], bodies.surface[i, 2])
    b_0, b_1, b_2 = turn_by(bodies.motion.x, j, bodies.surface[j, 0], bodies.surface[j, 1], bodies.surface[j, 2])
    w_0, w_1, w_2 = b_0 - a_0, b_1 - a_1, b_2 - a_2
    network.b[c, 1] = w_0 * t[0] + w_1 * t[1] + w_2 * t[2]
    network.b[c, 2] = w_0 * s[0] + w_1 * s[1] + w_2 * s[2]


@kernel
def move_spatial(bodies, b, dt, v):
    """Move body b by dt v and turn it by cay(dt omega), v (n_b, 6); the quaternion is made a unit one again."""
    move_spatial_by(bodies, b, (dt * v[b, 0], dt * v[b, 1], dt * v[b, 2]), (dt * v[b, 3], dt * v[b, 4], dt * v[b, 5]))


@kernel
def move_spatial_by(bodies, b, way, turn):
    """Move body b by a way and turn it by cay(turn)."""
    x = bodies.motion.x
    for k in range(3):
        x[b, k] += way[k]
    h_0, h_1, h_2 = 0.5 * turn[0], 0.5 * turn[1], 0.5 * turn[2]
    if h_0 == 0.0 and h_1 == 0.0 and h_2 == 0.0:
        return
    w, r_0, r_1, r_2 = x[b, 3], x[b, 4], x[b, 5], x[b, 6]
    c_0, c_1, c_2 = cross(h_0, h_1, h_2, r_0, r_1, r_2)
    q = w - (h_0 * r_0 + h_1 * r_1 + h_2 * r_2)
    r_0, r_1, r_2 = r_0 + w * h_0 + c_0, r_1 + w * h_1 + c_1, r_2 + w * h_2 + c_2
    scale = 1.0 / sqrt(q * q + r_0 * r_0 + r_1 * r_1 + r_2 * r_2)
    x[b, 3], x[b, 4], x[b, 5], x[b, 6] = scale * q, scale * r_0, scale * r_1, scale * r_2
