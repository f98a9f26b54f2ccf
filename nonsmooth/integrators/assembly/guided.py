"""Guided bodies in a step: what they carry is where they are, to second order.

The places that a function tells for t_0, the middle of the step and t_1 lie on a parabola,

    v_mid = (q_1 - q_0)/dt,    v_0, v_1 = v_mid -+ h,    h = (q_1 - 2 q_mid + q_0) 2/dt

Contacts are looked for where bodies have gone on by ``shift`` from t_0. What touches a body that turns with Omega
goes on with its own velocity: at t the point beneath it is farther from the centre of the guided body by
(t v_b - shift_b) - (t v_g - shift_g), and has another velocity by

    turn = Omega x ((t v_b - shift_b) - (t v_g - shift_g))

The velocities of a step stand for t = dt/2 (1 + lead), lead = 2 - 2 theta: for its end where places move by the mean of
two velocities, for its middle where they move by the new one. With the velocity of the middle and theta = 1/2 a box
on a table that turns goes out by r Omega^2 dt/2 a second, and the friction that holds it does work.

A contact that is open, or is met with a speed, closes by the way of the guided body, so its normal has v_mid. A
velocity that a guided body gains in a step but not in the one before is a jump, and no acceleration: h is at most
GAIN_GROWTH times that of the step before, or g dt (world.py), or a kick would throw what it meets by up to 2.5 times
its speed.
Equations: docs/theory/scenes.md, (5).
"""

from __future__ import annotations

from nonsmooth.jit import kernel


@kernel
def lead_guide(bodies, b):
    """The velocities of guided body b at the beginning of the step, and where those of the step stand."""
    for x in range(bodies.gain.shape[1]):
        bodies.v_0[b, x] -= bodies.gain[b, x]
        bodies.v_free[b, x] += bodies.lead * bodies.gain[b, x]


@kernel
def has_guide(bodies, network, c):
    """Whether a contact is with a body that impulses do not move."""
    return bodies.motion.moves[network.i[c]] == 0 or bodies.motion.moves[network.j[c]] == 0


@kernel
def aim_of(bodies, dt):
    """When the velocities of a step are those of guided bodies, from its beginning [s]."""
    return 0.5 * dt * (1.0 + bodies.lead)


@kernel
def turn_of_guides(bodies, network, c, row, t):
    """What guided bodies add to gamma of a row by turning, from where its contact was found to time t of the step."""
    i, j, moves, total = network.i[c], network.j[c], bodies.motion.moves, 0.0
    if moves[i] == 0:
        total -= turn_of_guide(bodies, i, j, network.J_j, c, row, t)
    if moves[j] == 0:
        total += turn_of_guide(bodies, j, i, network.J_j, c, row, t)
    return total


@kernel
def turn_of_guide(bodies, g, b, axes, c, row, t):
    """The same of guided body g, which body b touches, along an axis of the contact."""
    v = bodies.v_0
    w_0, w_1 = way_beyond(bodies, g, b, 0, t), way_beyond(bodies, g, b, 1, t)
    if v.shape[1] == 3:
        return v[g, 2] * (axes[c, row, 1] * w_0 - axes[c, row, 0] * w_1)
    w_2 = way_beyond(bodies, g, b, 2, t)
    o_0, o_1, o_2 = v[g, 3], v[g, 4], v[g, 5]
    u_0, u_1, u_2 = o_1 * w_2 - o_2 * w_1, o_2 * w_0 - o_0 * w_2, o_0 * w_1 - o_1 * w_0
    return axes[c, row, 0] * u_0 + axes[c, row, 1] * u_1 + axes[c, row, 2] * u_2


@kernel
def way_beyond(bodies, g, b, k, t):
    """What body b goes farther than g until t along axis k, from where their contact was found."""
    v, shift = bodies.v_0, bodies.shift
    return (t * v[b, k] - shift[b, k]) - (t * v[g, k] - shift[g, k])


@kernel
def ask_of_guides(bodies, found, network, c, d, dt):
    """What a contact of a guided body asks beside its rows."""
    i, j, aim = network.i[c], network.j[c], aim_of(bodies, dt)
    for row in range(d):
        network.turn[c, row] = 0.0
    if not has_guide(bodies, network, c):
        return
    for row in range(d):
        network.turn[c, row] = turn_of_guides(bodies, network, c, row, aim)
    if network.soft[c] == 0.0 and is_met(bodies, found, network, c, d, dt):
        network.turn[c, 0] = 0.0
        for x in range(bodies.gain.shape[1]):
            of_guides = network.J_i[c, 0, x] * bodies.gain[i, x] + network.J_j[c, 0, x] * bodies.gain[j, x]
            network.turn[c, 0] -= bodies.lead * of_guides
    for row in range(d):
        network.b[c, row] += network.turn[c, row]


@kernel
def is_met(bodies, found, network, c, d, dt):
    """Whether contact c is open, or its bodies approach, by more than guided bodies change in half a step."""
    gamma, change = turn_of_guides(bodies, network, c, 0, 0.0), change_of_guides(bodies, network, c, d)
    for x in range(bodies.v_0.shape[1]):
        gamma += network.J_i[c, 0, x] * bodies.v_0[network.i[c], x] + network.J_j[c, 0, x] * bodies.v_0[network.j[c], x]
    return found.gap[c] > dt * change or gamma < -change


@kernel
def change_of_guides(bodies, network, c, d):
    """By how much guided bodies change the velocity of a contact in half a step, at most [m/s]."""
    i, j, total = network.i[c], network.j[c], 0.0
    for row in range(d):
        change = abs(network.turn[c, row])
        for x in range(bodies.gain.shape[1]):
            change += abs(network.J_i[c, row, x] * bodies.gain[i, x]) + abs(network.J_j[c, row, x] * bodies.gain[j, x])
        total += change
    return total
