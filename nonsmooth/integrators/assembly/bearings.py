"""Which machines may have no motion, or several, by the friction of their joints: what bearings add to one another.

A bearing is where a joint with friction touches: a pin in one point, a guide in its two ends (joint_friction.py). The
friction of joint k is an impulse -s_k l_k sum_q rho_q along its coordinate, s_k the sign of its sliding, q its
bearings; the joints of the machine answer with P_j = -G_jj^+ (gamma_j + G_jk P_k), of which bearing p has B_p P_j:

    rho_p = |b_p + sum_q A_pq rho_q|,    b_p = -B_p G_jj^+ gamma_j,    A_pq = s_k l_k B_p G_jj^+ G_jk

The loads are one, whatever else pulls, where the spectral radius of L = (|A_pq|) is below 1: where the pivots of I - L
are positive. Newton's method finds it, and the friction of the step begins with it: a fixed point of loads and friction
(stages.py) takes as long as that radius is near 1. Only where it is not below they are all looked for (``seized.py``).
B_p stands in rows above those of the joints, so that eliminating these leaves A and b.

Not asked are machines with a ball that has friction, with springs, motors, a contact or a limit that touches, a joint
with friction that does not slide, more than MOST_BEARINGS bearings or MOST_HELD blocks of rows of joints.
Source: contact/bearing_loads.py.
"""

from __future__ import annotations

from math import sqrt
from typing import Annotated as Array

from nonsmooth.contact.network.joint import JOINT_LIMIT, PIN, is_contact, is_joint
from nonsmooth.contact.network.problem import Network
from nonsmooth.integrators.assembly.bodies import Bodies
from nonsmooth.integrators.assembly.doubtful import MOST_HELD, SAID_TWICE, free_velocity, response, touches
from nonsmooth.integrators.assembly.drive_rows import (
    Drives,
    borne_of_row,
    drive_of,
    first_blocks,
    is_ball_drive,
    number_of_bearings,
)
from nonsmooth.integrators.assembly.joints import joint_of
from nonsmooth.integrators.assembly.wandering import row_velocity
from nonsmooth.jit import in_dimensions, kernel
from nonsmooth.jit.blocks import Block, Floats, Ints, view
from nonsmooth.numerics.dense import lu, lu_solve
from nonsmooth.scenes.detection import FIRST_DRIVE, FIRST_SPRING, Found

MOST_BEARINGS = 6  # chosen: three guides, or six pins: 2^6 roots are looked for in 40 ms
MOST_NEWTON = 30  # chosen: of bearings: three to six are enough but where one comes to bear next to nothing
FOUND = 1e-13  # chosen: of the largest load
RATE_THAT_COUNTS = 1e-9  # chosen: of the velocities that a rate is the difference of, above which a joint slides


class Bearings(Block, most=MOST_BEARINGS, held=MOST_HELD):
    """Those of one machine, and what they are found in."""

    drives: int  # joints with friction
    drive: Array[Ints, "most"]  # their row blocks in the network
    rate: Array[Floats, "most"]  # of their sliding, before the step [m/s]
    sign: Array[Floats, "most"]
    joints: int  # blocks of rows of joints
    joint: Array[Ints, "held"]
    count: int  # bearings
    of: Array[Ints, "most"]  # the joint with friction of a bearing
    # rows: three a bearing, one a joint with friction, d a block of a joint; columns: the last two and, last, gamma
    Q: Array[Floats, "4 * most + 3 * held", "most + 3 * held + 1"]
    left: Array[Floats, "most", "most"]  # I - L, or the derivative of Newton's method
    load: Array[Floats, "most"]  # rho [N s]
    off: Array[Floats, "most"]  # rho - |b + A rho|
    step: Array[Floats, "most"]
    order: Array[Ints, "most"]


@in_dimensions("int64(int64, int64, int64, int64, int64, int64, float64)")
def find_doubtful_machine(bodies_at, found_at, network_at, drives_at, bearings_at, first, dt, d):
    """The first island from ``first`` on whose loads may be none, or several, with its A and b in Q; -1: none is. The
    friction of those before it begins with their loads."""
    bodies, found, network = view(bodies_at, Bodies), view(found_at, Found), view(network_at, Network)
    drives, bearings = view(drives_at, Drives), view(bearings_at, Bearings)
    first_blocks(drives, found, network)
    for k in range(first, network.islands.count):
        if list_machine(bodies, found, network, drives, (k, bearings), d):
            write_machine(bodies, found, network, drives, bearings, d)
            eliminate_machine(network, bearings, d)
            if not is_one(drives, found, bearings):
                return k
            if find_load(drives, found, bearings):
                begin_with(drives, found, network, bearings, dt)
    return -1


@kernel
def list_machine(bodies, found, network, drives, at, d):
    """List the joints of island k and their bearings; whether they are asked for their loads."""
    k, bearings = at
    n, islands = 3 * (d - 1), network.islands
    bearings.drives = bearings.joints = bearings.count = 0
    for place in range(islands.contact_start[k], islands.contact_start[k + 1]):
        c = islands.contacts[place]
        key = found.key[c]
        if is_joint(network, c) and network.sprung[c] == 0:
            if bearings.joints == bearings.joint.shape[0]:
                return False
            bearings.joint[bearings.joints] = c
            bearings.joints += 1
        elif network.sprung[c] == PIN and FIRST_DRIVE <= key < FIRST_SPRING:
            of = drive_of(drives, key)
            more = number_of_bearings(drives, of)
            if is_ball_drive(drives, of) or bearings.count + more > bearings.of.shape[0]:
                return False
            rate, size = row_velocity(network, c, 1, bodies.v_0)
            if not abs(rate) > RATE_THAT_COUNTS * size:
                return False
            for p in range(bearings.count, bearings.count + more):
                bearings.of[p] = bearings.drives
            bearings.drive[bearings.drives], bearings.rate[bearings.drives] = c, rate
            bearings.sign[bearings.drives] = 1.0 if rate > 0.0 else -1.0
            bearings.drives += 1
            bearings.count += more
        elif not (is_contact(network, c) or network.sprung[c] == JOINT_LIMIT) or touches(found, network, c, 0.0, n):
            return False
    return bearings.drives > 0 and bearings.joints > 0


@kernel
def write_machine(bodies, found, network, drives, bearings, d):
    """B, the answers of the joints to one another and to friction, and the free velocities."""
    Q, n, n_k = bearings.Q, 3 * (d - 1), bearings.drives
    last, above = Q.shape[1] - 1, 3 * bearings.count
    rows = above + n_k + d * bearings.joints
    for r in range(rows):
        for s in range(n_k + d * bearings.joints):
            Q[r, s] = 0.0
        Q[r, last] = 0.0
    for e in range(n_k + d * bearings.joints):
        c, a = row_of(bearings, e, d)
        Q[above + e, last] = free_velocity(network, c, a, n)
        for f in range(n_k + d * bearings.joints):
            Q[above + e, f] = response(network, (c, a), row_of(bearings, f, d), n)
    for f in range(d * bearings.joints):
        c, a = row_of(bearings, n_k + f, d)
        Q[above + n_k + f, n_k + f] += network.soft[c]
        for p in range(bearings.count):
            k = drive_of(drives, found.key[bearings.drive[bearings.of[p]]])
            if joint_of(found.key[c]) == drives.of[k]:
                end = 0 if p == 0 or bearings.of[p - 1] != bearings.of[p] else 1
                R = borne_of_row(drives, bodies.motion.x, k, network, (c, a, end))
                Q[3 * p, n_k + f], Q[3 * p + 1, n_k + f], Q[3 * p + 2, n_k + f] = R


@kernel
def row_of(bearings, e, d):
    """The row block of the network and its row of column e."""
    if e < bearings.drives:
        return bearings.drive[e], 1
    return bearings.joint[(e - bearings.drives) // d], (e - bearings.drives) % d


@kernel
def eliminate_machine(network, bearings, d):
    """Eliminate the rows of the joints: -B G^+ is what is left above them, and G of the friction with them held."""
    Q, n_k = bearings.Q, bearings.drives
    last, above, held = Q.shape[1] - 1, 3 * bearings.count, d * bearings.joints
    for p in range(n_k, n_k + held):
        c, a = row_of(bearings, p, d)
        pivot = Q[above + p, p]
        if not pivot > SAID_TWICE * network.W[c, a, a]:
            continue
        for r in range(above + n_k + held):
            if (r < above + n_k or r > above + p) and Q[r, p] != 0.0:
                factor = Q[r, p] / pivot
                for s in range(n_k):
                    Q[r, s] -= factor * Q[above + p, s]
                for s in range(p + 1, n_k + held):
                    Q[r, s] -= factor * Q[above + p, s]
                Q[r, last] -= factor * Q[above + p, last]


@kernel
def is_one(drives, found, bearings):
    """Whether the pivots of I - L are positive."""
    left, n, Q = bearings.left, bearings.count, bearings.Q
    for q in range(n):
        e = bearings.of[q]
        arm = drives.arm[drive_of(drives, found.key[bearings.drive[e]])]
        for p in range(n):
            size = sqrt(Q[3 * p, e] ** 2 + Q[3 * p + 1, e] ** 2 + Q[3 * p + 2, e] ** 2)
            left[p, q] = (1.0 if p == q else 0.0) - arm * size
    for p in range(n):
        if left[p, p] <= 0.0:
            return False
        for r in range(p + 1, n):
            factor = left[r, p] / left[p, p]
            for s in range(p + 1, n):
                left[r, s] -= factor * left[p, s]
    return True


@kernel
def find_load(drives, found, bearings):
    """Find the only loads; whether Newton's method did."""
    n, load, off, Q = bearings.count, bearings.load, bearings.off, bearings.Q
    last = Q.shape[1] - 1
    for p in range(n):
        load[p] = 0.0
    for _ in range(MOST_NEWTON):
        worst, largest = 0.0, 0.0
        for p in range(n):
            square = 0.0
            for q in range(n):
                bearings.left[p, q] = 0.0
            for a in range(3):
                R = Q[3 * p + a, last]
                for q in range(n):
                    R += of_load(drives, found, bearings, (p, a, q)) * load[q]
                square += R * R
                for q in range(n):
                    bearings.left[p, q] -= R * of_load(drives, found, bearings, (p, a, q))
            size = sqrt(square)
            for q in range(n):
                bearings.left[p, q] = (1.0 if p == q else 0.0) + (bearings.left[p, q] / size if size > 0.0 else 0.0)
            off[p] = load[p] - size
            worst, largest = max(worst, abs(off[p])), max(largest, size)
        if worst <= FOUND * largest:
            return True
        if not lu(n, bearings.left, bearings.order):
            return False
        lu_solve(n, bearings.left, bearings.order, off, bearings.step)
        for p in range(n):
            load[p] = max(load[p] - bearings.step[p], 0.0)
    return False


@kernel
def of_load(drives, found, bearings, at):
    """A_pq along axis a, (p, a, q)."""
    p, a, q = at
    e = bearings.of[q]
    return -bearings.sign[e] * drives.arm[drive_of(drives, found.key[bearings.drive[e]])] * bearings.Q[3 * p + a, e]


@kernel
def begin_with(drives, found, network, bearings, dt):
    """Let the friction of the first problem of the step be that of the loads, where its joints slide on with it."""
    n_k, above, Q, step = bearings.drives, 3 * bearings.count, bearings.Q, bearings.step
    for e in range(n_k):
        step[e] = 0.0
    for p in range(bearings.count):
        e = bearings.of[p]
        step[e] += drives.arm[drive_of(drives, found.key[bearings.drive[e]])] * bearings.load[p]
    for e in range(n_k):
        rate = Q[above + e, Q.shape[1] - 1]
        for f in range(n_k):
            rate -= Q[above + e, f] * bearings.sign[f] * step[f]
        if not bearings.sign[e] * rate > 0.0:
            return
    for e in range(n_k):
        begin_joint(drives, found, network, bearings.drive[e], (bearings.sign[e], step[e], dt))


@kernel
def begin_joint(drives, found, network, c, at):
    """Let the friction of row block c be at most so much, against the sign of its sliding [N s]."""
    sign, friction, dt = at
    drives.high[drive_of(drives, found.key[c])] = friction / dt
    network.b[c, 0] = -network.soft[c] * friction
    network.P[c, 0], network.P[c, 1] = friction, -sign * friction
