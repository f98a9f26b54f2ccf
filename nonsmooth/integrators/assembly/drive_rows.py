"""What acts along the angle or the travel s that a joint leaves free: limits, motors that hold a speed, and springs.

    limit    0 <= P _|_ s - s_lo + dt gamma >= 0, or the same of s_hi - s;    gamma = J_mid v_1 + b,  b as of joints
    motor    |P| <= M dt,   P = M dt sign(f - gamma) where the speed is not f: a contact that sticks or slides
    spring   P/dt = f - k (s - s_r + theta dt gamma) - c gamma - a (gamma_1 - gamma_0)/dt,
             gamma = (1 - theta) gamma_0 + theta gamma_1

A limit is a contact without friction whose gap is the way to it; it lands and rebounds as contacts do. A rope is the
upper limit of the distance of two points. Only the
nearer of both is a row: where nothing presses, two that are opposite are solved by any pair of large impulses. A rope
that is slack by more than bodies are looked for (``margin_of``) is no row. A motor
is friction with a given normal force: its normal row has J = 0, R and b such that P_N = -b/R = M dt, and mu = 1; its
tangent is the row of the coordinate, its belt runs with the speed f at the end of the step. So what no motor can hold
turns it back by M, and what it can is held exactly.

A spring with a damper, and the inertia a of a rotor that turns along through gears, is the row of a soft joint,

    gamma_1 + R P + b = 0,   1/R = dt theta B + a,   b = R (dt (k (s - s_r) - f + (1 - theta) B gamma_0) - a gamma_0)

with B = theta k dt + c: it is implicit as springs between points are (spring_rows.py), and a is exact. f is that of a
motor on the same joint: most of it may go to the rotor, and bodies feel what is left. gamma_0 of the rotor is gamma_1
of the step before, whose row was another one: so no momentum of it is lost from step to step, which would be dt^2.

The friction of a joint is a brake whose M is what the joint bears asks for (joint_friction.py): the problem is solved
again until that is the one which it leads to, as friction laws are (stages.py). That of a ball has two tangents, the
turns across what it bears. What a guide bears depends on its friction, where its body has its centre of mass aside: the
limit goes to where the secant through the last two solutions says. Where friction makes more load than it needs, a
machine that moves may have no motion, or several: those are found before (seized.py).

Angles count as ways at the lever of the joint (joint_rows.py). In space an angle is known but for full turns, which are
counted from step to step. Rows of drives stand between contacts and springs. In an impact motors and springs give no
impulse, and a rotor is struck along with its joint: P = -a (gamma_plus - gamma_minus).
Source: for the motor, Glocker, *Set-Valued Force Laws* (2001), section 5 (force laws of sgn-type).
"""

from __future__ import annotations

from math import isnan, pi, sqrt
from typing import Annotated as Array

from nonsmooth.contact.network.joint import JOINED, JOINT_LIMIT, MOTOR, PIN, SPRUNG
from nonsmooth.contact.network.problem import Network
from nonsmooth.integrators.assembly.bodies import Bodies
from nonsmooth.integrators.assembly.contacts import Contacts
from nonsmooth.integrators.assembly.joint_rows import (
    axis_at,
    offset_of,
    row_at,
    turn_of_side,
    write_side,
    write_turns_across,
)
from nonsmooth.integrators.assembly.spatial import cross
from nonsmooth.integrators.assembly.wandering import row_velocity
from nonsmooth.jit import kernel
from nonsmooth.jit.blocks import Block, Floats, Ints, new, view
from nonsmooth.scenes.detection import (
    FEATURE_BITS,
    FIRST_DRIVE,
    FIRST_JOINT,
    FIRST_SPRING,
    LAST_FEATURE,
    NO_SHAPE,
    Found,
)
from nonsmooth.scenes.joint_kinds import DISTANCE, E_AXIS, OFFSET, TURN, UNUSED

STOPS, SPEED, RUBS, SPRINGS = range(4)  # code: laws of a drive
LOWER, UPPER = range(2)  # code: which limit is nearer
ENDS_OF_STOPS = 2  # defined: of a coordinate
NO_GAP = 1e30  # code: the gap of the row of a motor [m], which no contact has
AT_LIMIT = 1e-12  # chosen: of the lever: a limit that is nearer is reached
STEEPEST_LOAD = 0.9  # chosen: slope of load by limit up to which the secant is trusted


class Drives(Block):
    """n_k drives of n_n joints; their coordinate is row 0 of a block of rows, as those of ``Joints`` are."""

    count: int
    slack: int  # ropes that are no rows of this step
    is_slack: Array[Ints, "n_k"]
    of: Array[Ints, "n_k"]  # the joint of a drive
    begin: Array[Ints, "n_n"]  # and the first drive of a joint
    law: Array[Ints, "n_k"]
    low: Array[Floats, "n_k"]  # s_lo, or s_r of a spring [m]
    high: Array[Floats, "n_k"]  # s_hi [m], or M over the lever [N]
    e: Array[Floats, "n_k"]  # restitution of a limit
    arm: Array[Floats, "n_k"]  # of the circle of friction of a pin, over the lever; mu of a guide
    guide: Array[Floats, "n_k"]  # length of a guide [m]
    across: Array[Floats, "n_k", "3"]  # direction of what a ball bears
    tried: Array[Floats, "n_k"]  # the limit of the solution before, of a guide [N]
    led_to: Array[Floats, "n_k"]  # and what that led to [N]
    spring: Array[Floats, "n_k", "3"]  # k, c and a over the square of the lever [N/m], [N s/m], [kg]
    load: Array[Floats, "n_k"]  # f of a motor behind a spring, over the lever [N]
    rate: Array[Floats, "n_k"]  # gamma_1 of the step before, NaN where there is none [m/s]
    pull: Array[Floats, "n_k"]  # of a step: b/R, but for what rows turn by [N s]
    pin: Array[Ints, "n_n"]  # of a step: the first row block of each joint that is awake
    speed: Array[Floats, "n_k"]  # f at the end of the step, times the lever [m/s]
    last: Array[Floats, "n_k"]  # s of the step before [m]
    shape_i: Array[Ints, "n_k"]
    shape_j: Array[Ints, "n_k"]
    i: Array[Ints, "n_k"]
    j: Array[Ints, "n_k"]
    arm_i: Array[Floats, "n_k", "d"]
    arm_j: Array[Floats, "n_k", "d"]
    u: Array[Ints, "n_k", "1"]
    w: Array[Ints, "n_k", "1"]
    axes_i: Array[Floats, "n_k", "d", "d"]
    axes_j: Array[Floats, "n_k", "d", "d"]
    lever: Array[Floats, "n_k"]
    angle: Array[Floats, "n_k"]
    length: Array[Floats, "n_k"]  # of which a distance is counted: 0 [m]


def no_drives(dim: int) -> Drives:
    """The block of a scene without drives."""
    return new(Drives, n_k=0, n_n=0, d=dim)


@kernel
def drive_of(drives, key):
    """The drive of a key."""
    return drives.begin[(key >> FEATURE_BITS) & NO_SHAPE] + (key & LAST_FEATURE) // ENDS_OF_STOPS


@kernel
def key_of_drive(drives, x, k):
    """Of drive k, with which limit is the nearer one at places x."""
    end, of = LOWER, drives.of[k]
    if drives.law[k] == STOPS:
        s = coordinate_of(drives, x, k)
        end = UPPER if drives.high[k] - s < s - drives.low[k] else LOWER
    return FIRST_DRIVE | (of << FEATURE_BITS) | (ENDS_OF_STOPS * (k - drives.begin[of]) + end)


@kernel
def add_drives(drives, motion, found, margin, n):
    """Write the drives of bodies that are not both still behind the first n contacts; the new n."""
    drives.slack = 0
    for k in range(drives.count):
        i, j = drives.i[k], drives.j[k]
        drives.is_slack[k] = 0
        if drives.w[k, 0] == DISTANCE and drives.high[k] - coordinate_of(drives, motion.x, k) > margin:
            drives.is_slack[k] = 1
            drives.slack += 1
            continue
        if motion.still[i] == 1 and motion.still[j] == 1:
            continue
        found.shape_i[n], found.shape_j[n] = drives.shape_i[k], drives.shape_j[k]
        found.key[n], found.gap[n] = key_of_drive(drives, motion.x, k), 0.0
        _, p = offset_of(drives, motion.x, k)
        for a in range(found.normal.shape[1]):
            found.normal[n, a], found.point[n, a] = 1.0 if a == 0 else 0.0, p[a]
        n += 1
    return n


@kernel("void(int64, int64, int64, int64, int64, int64, float64)")
def write_drives(drives_at, bodies_at, found_at, contacts_at, network_at, is_impact, dt):
    """Make drives of their rows, which were written as contacts; those of an impact are at the places after it."""
    drives, bodies, found = view(drives_at, Drives), view(bodies_at, Bodies), view(found_at, Found)
    contacts, network = view(contacts_at, Contacts), view(network_at, Network)
    for c in range(network.n_c):
        if FIRST_DRIVE <= found.key[c] < FIRST_SPRING:
            k, asked = drive_of(drives, found.key[c]), network.b[c, 0]
            sign = -1.0 if found.key[c] % ENDS_OF_STOPS == UPPER else 1.0
            write_coordinate(drives, bodies.motion.x, k, c, network, sign)
            contacts.e[c] = drives.e[k]
            if drives.law[k] == SPRINGS:
                write_spring(drives, bodies, k, c, network, 0.0 if is_impact == 1 else dt)
                found.gap[c] = NO_GAP
                for row in range(network.b.shape[1]):
                    contacts.drift[c, row] = 0.0
            elif drives.law[k] != STOPS:
                write_motor(drives, bodies, k, c, network, 0.0 if is_impact == 1 else dt)
                found.gap[c] = NO_GAP
            elif is_impact == 1:
                network.b[c, 0] = asked
            else:
                write_limit(drives, bodies, found, k, c, network, (sign, dt))


@kernel
def write_coordinate(drives, x, k, c, network, sign):
    """The row of the coordinate of drive k: the normal of a limit or a spring, the tangent of a motor; other rows are
    unused."""
    n, to = network.v.shape[1], 1 if drives.law[k] == SPEED or drives.law[k] == RUBS else 0
    for row in range(network.b.shape[1]):
        network.b[c, row] = network.turn[c, row] = 0.0
        for y in range(n):
            network.J_i[c, row, y] = network.J_j[c, row, y] = 0.0
    if is_ball_drive(drives, k):
        write_turns_across(network, c, drives.across[k], drives.lever[k])
        return
    for b in (drives.i[k], drives.j[k]):
        J = network.J_i if b == drives.i[k] else network.J_j
        write_side(drives, x, k, 0, b, J, c, to)
        for y in range(n):
            J[c, to, y] *= sign if b == drives.j[k] else -sign


@kernel
def turn_of_drive(drives, bodies, k):
    """What the rate of the coordinate gains from the beginning of the step to where its row is written."""
    return turn_of_side(drives, bodies, k, 0, drives.j[k]) - turn_of_side(drives, bodies, k, 0, drives.i[k])


@kernel
def coordinate_of(drives, x, k):
    """The coordinate of drive k at places x [m], full turns since the start with it."""
    _, s = row_at(drives, x, k, 0)
    if drives.w[k, 0] == TURN:
        around = 2.0 * pi * drives.lever[k]
        s += around * round((drives.last[k] - s) / around)
    return s


@kernel
def write_limit(drives, bodies, found, k, c, network, step):
    """The gap of a limit at the beginning of the step, and what it asks for; step is the sign of its row, and dt."""
    s, (sign, dt) = coordinate_of(drives, bodies.x_0, k), step
    drives.last[k] = s
    gap = s - drives.low[k] if sign > 0.0 else drives.high[k] - s
    found.gap[c] = 0.0 if abs(gap) <= AT_LIMIT * drives.lever[k] else gap
    network.mu[c], network.soft[c], network.sprung[c] = 0.0, 0.0, JOINT_LIMIT
    network.turn[c, 0] = sign * turn_of_drive(drives, bodies, k)
    network.b[c, 0] = network.turn[c, 0] + (gap / dt if found.gap[c] > 0.0 else 0.0)


@kernel
def write_motor(drives, bodies, k, c, network, dt):
    """The force of a motor over a step, 0 of an impact, as a given normal force, and the speed that it holds."""
    R = 0.0
    for b in (drives.i[k], drives.j[k]):
        R += 1.0 / bodies.mass[b] if bodies.motion.moves[b] == 1 else 0.0
    network.mu[c], network.soft[c], network.sprung[c] = 1.0, R, PIN if drives.law[k] == RUBS else MOTOR
    if dt == 0.0:
        network.b[c, 0] = NO_GAP
        return
    network.b[c, 0] = -R * drives.high[k] * dt
    if not is_ball_drive(drives, k):
        network.turn[c, 1] = turn_of_drive(drives, bodies, k)
        network.b[c, 1] = network.turn[c, 1] - drives.speed[k]


@kernel
def write_spring(drives, bodies, k, c, network, dt):
    """R and b of the spring, the damper and the rotor of a joint over a step; dt is 0 of an impact."""
    stiffness, damping, rotor = drives.spring[k, 0], drives.spring[k, 1], drives.spring[k, 2]
    network.mu[c], network.soft[c], network.sprung[c] = JOINED, NO_GAP, SPRUNG
    if dt > 0.0:
        s, turn = coordinate_of(drives, bodies.x_0, k), turn_of_drive(drives, bodies, k)
        drives.last[k] = s
        rate, _ = row_velocity(network, c, 0, bodies.v_0)
        rate -= turn
        theta = 1.0 - 0.5 * bodies.lead
        B = theta * stiffness * dt + damping
        R = 1.0 / (dt * theta * B + rotor)
        before = rate if isnan(drives.rate[k]) else drives.rate[k]
        pull = dt * (stiffness * (s - drives.low[k]) - drives.load[k]) + dt * (1.0 - theta) * B * rate
        drives.pull[k] = pull - rotor * before
        network.soft[c], network.b[c, 0] = R, turn + R * drives.pull[k]
    elif rotor > 0.0:
        rate, _ = row_velocity(network, c, 0, network.v_free)
        network.soft[c], network.b[c, 0], drives.pull[k] = 1.0 / rotor, -rate, -rotor * drives.rate[k]


@kernel
def keep_rate(drives, k, c, network):
    """The rate of a spring's coordinate after a solved problem, gamma_1 = -R P - R pull."""
    if drives.law[k] == SPRINGS and network.soft[c] < NO_GAP:
        drives.rate[k] = -network.soft[c] * (network.P[c, 0] + drives.pull[k])


@kernel
def is_ball_drive(drives, k):
    """Whether drive k is the friction of a ball."""
    return drives.w[k, 0] == UNUSED


@kernel("int64(int64, int64, int64, int64, float64, float64, int64)")
def rub_joints(drives_at, bodies_at, found_at, network_at, dt, tol, sweeps):
    """Take the friction of joints at what they bear in a solution; whether that of one changed by more than a part. A
    joint that sticks within both limits is solved, however much it bears: friction may leave open what holds it."""
    drives, bodies = view(drives_at, Drives), view(bodies_at, Bodies)
    found, network = view(found_at, Found), view(network_at, Network)
    has_changed = 0
    first_blocks(drives, found, network)
    for c in range(network.n_c):
        key = found.key[c]
        if FIRST_DRIVE <= key < FIRST_SPRING and network.sprung[c] == PIN:
            k = drive_of(drives, key)
            if drives.w[k, 0] == OFFSET:
                load = drives.arm[k] * borne(drives, bodies.motion.x, k, network) / dt
                force = limit_to_try(drives, k, load, sweeps)
            elif is_ball_drive(drives, k):
                has_changed |= turn_ball(drives, k, c, network, tol)
                load = force = drives.arm[k] * size_of(network.P[drives.pin[drives.of[k]]]) / dt
            else:
                load = force = drives.arm[k] * borne(drives, bodies.motion.x, k, network) / dt
            if size_of(network.P[c, 1:]) < (1.0 - tol) * min(load, drives.high[k]) * dt:
                continue
            if abs(load - drives.high[k]) > tol * max(load, drives.high[k]):
                has_changed = 1
            drives.high[k] = force
            network.b[c, 0] = -network.soft[c] * force * dt
    return has_changed


@kernel
def first_blocks(drives, found, network):
    """Note the first row block of each joint."""
    for c in range(network.n_c - 1, -1, -1):
        if found.key[c] >= FIRST_JOINT:
            drives.pin[(found.key[c] >> FEATURE_BITS) & NO_SHAPE] = c


@kernel
def size_of(P):
    """|P|."""
    square = 0.0
    for a in range(P.shape[0]):
        square += P[a] * P[a]
    return sqrt(square)


@kernel
def number_of_bearings(drives, k):
    """In how many points the joint of drive k touches: a pin in one, a guide with a length in its two ends."""
    return 2 if drives.w[k, 0] == OFFSET and drives.guide[k] > 0.0 else 1


@kernel
def borne(drives, x, k, network):
    """The sum of the sizes of the impulses in the bearings of drive k."""
    begin, d, total = drives.pin[drives.of[k]], network.b.shape[1], 0.0
    blocks = d - 1 if drives.w[k, 0] == OFFSET else 1
    for end in range(number_of_bearings(drives, k)):
        R_0, R_1, R_2 = 0.0, 0.0, 0.0
        for c in range(begin, begin + blocks):
            for row in range(d):
                of_0, of_1, of_2 = borne_of_row(drives, x, k, network, (c, row, end))
                R_0 += of_0 * network.P[c, row]
                R_1 += of_1 * network.P[c, row]
                R_2 += of_2 * network.P[c, row]
        total += sqrt(R_0 * R_0 + R_1 * R_1 + R_2 * R_2)
    return total


@kernel
def borne_of_row(drives, x, k, network, at):
    """What an end of the joint of drive k bears of a unit impulse of a row (c, row, end) of that joint: of a pin what
    is across its axis, of a guide R/2 -+ M x e/h, a turn without R and a way without M. Rows of a point are those of
    the world."""
    c, row, end = at
    J, d, h = network.J_j, network.b.shape[1], drives.guide[k]
    R_0, R_1, R_2 = J[c, row, 0], J[c, row, 1], J[c, row, 2] if d == 3 else 0.0
    e = axis_at(x, drives.i[k], drives.axes_i, k, E_AXIS)
    if drives.w[k, 0] != OFFSET:
        if c != drives.pin[drives.of[k]]:
            return 0.0, 0.0, 0.0
        along = e[0] * R_0 + e[1] * R_1 + e[2] * R_2 if d == 3 else 0.0
        return R_0 - along * e[0], R_1 - along * e[1], R_2 - along * e[2]
    if h == 0.0:
        return R_0, R_1, R_2
    if R_0 != 0.0 or R_1 != 0.0 or R_2 != 0.0:
        return 0.5 * R_0, 0.5 * R_1, 0.5 * R_2
    if d == 2:
        m = cross(0.0, 0.0, J[c, row, 2], e[0], e[1], e[2])
    else:
        m = cross(J[c, row, 3], J[c, row, 4], J[c, row, 5], e[0], e[1], e[2])
    side = -1.0 / h if end == 0 else 1.0 / h
    return side * m[0], side * m[1], side * m[2]


@kernel
def turn_ball(drives, k, c, network, tol):
    """Let the rows of the ball of drive k be across what it bears; whether they turned by more than a part."""
    P = network.P[drives.pin[drives.of[k]]]
    size, way = size_of(P), 0.0
    if size == 0.0:
        return 0
    for a in range(3):
        way += abs(P[a] / size - drives.across[k, a])
        drives.across[k, a] = P[a] / size
    write_turns_across(network, c, drives.across[k], drives.lever[k])
    return 1 if way > tol else 0


@kernel
def limit_to_try(drives, k, load, sweeps):
    """The limit of a guide in the next solution, by the load of this one: where the secant through both meets it."""
    limit, slope = drives.high[k], 0.0
    if sweeps > 0 and limit != drives.tried[k]:
        slope = (load - drives.led_to[k]) / (limit - drives.tried[k])
    drives.tried[k], drives.led_to[k] = limit, load
    return max(limit + (load - limit) / (1.0 - min(slope, STEEPEST_LOAD)), 0.0) if slope != 0.0 else load
