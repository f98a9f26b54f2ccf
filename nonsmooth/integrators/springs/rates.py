"""Rates of a scene with compliant contacts: the contacts at hand, their forces, and what these do to the bodies.

    m v' = m g + f + sum la,    I omega' = sum r x la - omega x I omega,    q' = omega q/2,    xi' = gamma_T

Contacts are found anew at every stage. One that has no spring yet gets one, unstretched; one whose features changed
goes on with the spring of its pair that is nearest, as impulses do in assembly/contacts.py. In space an elongation
turns with the normal, by the least turn that carries the old one to the new one, and with the mean spin of both bodies
about it.
"""

from __future__ import annotations

import math

from nonsmooth.contact.network.problem import Network, relative_velocity
from nonsmooth.integrators.assembly.bodies import Bodies
from nonsmooth.integrators.assembly.contacts import Surfaces, find_sources, write_law
from nonsmooth.integrators.assembly.drive_rows import Drives
from nonsmooth.integrators.assembly.friction import law_of
from nonsmooth.integrators.assembly.joints import Joints, leave_out_ignored
from nonsmooth.integrators.assembly.of_body import write_rows
from nonsmooth.integrators.assembly.spatial import cross, turn_inertia
from nonsmooth.integrators.assembly.spring_rows import Springs as Coils
from nonsmooth.integrators.records import FORCE_WORK, FRICTION_WORK, NORMAL_WORK, SURFACE_WORK
from nonsmooth.integrators.springs.blocks import DAMPING_WORK, N_COLUMNS, Stages
from nonsmooth.integrators.springs.exchange import begin_exchanges, insert_exchange, write_exchange
from nonsmooth.integrators.springs.held import hold_bodies
from nonsmooth.integrators.springs.law import Law, Springs, damping_of, elastic_energy, friction, spring_and_damper
from nonsmooth.integrators.springs.table import STAGES, stage_sum
from nonsmooth.jit import kernel
from nonsmooth.jit.blocks import address, view
from nonsmooth.mechanics.laws import friction_coefficient, is_no_friction
from nonsmooth.scenes.detection import Found
from nonsmooth.scenes.find_contacts import find_contacts
from nonsmooth.scenes.shape_rows import Shapes

# code: as a number of contacts: where there is no room, and, less c, where contact c has no coefficient of friction
NO_ROOM_FOR_SPRINGS, FIRST_WITHOUT_LAW = -(2**61), -(2**60)


@kernel
def find(places, d):
    """The closed contacts at the present places."""
    n = find_contacts(places.shapes, places.motion, 0.0, 0.0, places.found, places.scratch, d)
    if 0 < n <= view(places.found, Found).gap.shape[0] and view(places.joints, Joints).apart > 0:
        n = leave_out_ignored(places.joints, places.shapes, places.found, n)
    return n


@kernel
def write_rates(places, s, h, d):
    """The rates of stage s at the present state; the number of contacts, or why there is none (detection's code)."""
    bodies, network, found = view(places.bodies, Bodies), view(places.network, Network), view(places.found, Found)
    law, springs, stages = view(places.law, Law), view(places.springs, Springs), view(places.rates, Stages)
    n = 3 * (d - 1)
    n_c = find(places, d)
    if n_c < 0 or n_c > found.gap.shape[0]:
        return n_c
    network.n_c = n_c
    if not hang_springs(found, n_c, springs, d):
        return NO_ROOM_FOR_SPRINGS
    if d == 3:
        turn_inertia(places.bodies, places.network)
    begin_forces(bodies, network, stages, s, d, n)
    for at in range(springs.n_before):
        for k in range(d):
            springs.rate[s, at, k] = 0.0
    if springs.is_asked == 1:
        begin_exchanges(springs, s, 0, springs.n_before)
    shapes, surfaces = view(places.shapes, Shapes), view(places.surfaces, Surfaces)
    for c in range(n_c):
        write_law(shapes, surfaces, found, c, network)
        write_rows(bodies, found, c, network, d)
        if surfaces.has_laws == 1 and not take_law(shapes, surfaces, found, c, network, d):
            return FIRST_WITHOUT_LAW - c
        push((bodies, found, network, law, springs, stages), c, s, h, d, n)
    if is_held(places):
        hold_bodies(address(places), s)
    write_motion(bodies, network, stages, s, d, n)
    return n_c


@kernel
def hang_springs(found, n_c, springs, d):
    """A spring for each contact; False where there is no room for one."""
    find_sources(found, n_c, springs)
    is_new = False
    for c in range(n_c):
        if springs.source[c] < 0:
            if springs.n_before == springs.key_before.shape[0]:
                return False
            insert(found, c, springs, d)
            is_new = True
    if is_new:
        find_sources(found, n_c, springs)
    return True


@kernel
def insert(found, c, springs, d):
    """An unstretched spring for contact c, in the order of the keys."""
    at = springs.n_before
    while at > 0 and springs.key_before[at - 1] > found.key[c]:
        springs.key_before[at] = springs.key_before[at - 1]
        springs.excess[at] = springs.excess[at - 1]
        for k in range(d):
            springs.point_before[at, k] = springs.point_before[at - 1, k]
            springs.normal_before[at, k] = springs.normal_before[at - 1, k]
            springs.xi[at, k] = springs.xi[at - 1, k]
            for s in range(STAGES):
                springs.rate[s, at, k] = springs.rate[s, at - 1, k]
        at -= 1
    springs.key_before[at] = found.key[c]
    springs.excess[at] = 0.0
    for k in range(d):
        springs.point_before[at, k], springs.normal_before[at, k] = found.point[c, k], found.normal[c, k]
        springs.xi[at, k] = 0.0
        for s in range(STAGES):
            springs.rate[s, at, k] = 0.0
    if springs.is_asked == 1:
        insert_exchange(springs, at)
    springs.n_before += 1


@kernel
def begin_forces(bodies, network, stages, s, d, n):
    """Weights, and their work; the velocities are those of the contacts too."""
    for column in range(N_COLUMNS):
        stages.work[s, 0, column] = 0.0
    for b in range(bodies.mass.shape[0]):
        for x in range(n):
            stages.force[b, x] = 0.0
            network.v[b, x] = bodies.motion.v[b, x]
        if bodies.motion.moves[b] == 1:
            for x in range(n):
                weight = bodies.mass[b] * bodies.gravity[x] if x < d else 0.0
                stages.force[b, x] = weight + bodies.load[b, x]
                stages.work[s, 0, FORCE_WORK] += stages.force[b, x] * bodies.motion.v[b, x]


@kernel
def take_law(shapes, surfaces, found, c, network, d):
    """mu of contact c at the velocity with which it slides; whether its law gives one."""
    _, gamma_1, gamma_2 = relative_velocity(network, c, d, 3 * (d - 1))
    mu = friction_coefficient(surfaces.laws, law_of(shapes, surfaces, found, c), math.hypot(gamma_1, gamma_2))
    network.mu[c] = mu
    return not is_no_friction(mu)


@kernel
def is_held(places):
    """Whether there is anything besides contacts."""
    joints, coils, drives = view(places.joints, Joints), view(places.coils, Coils), view(places.drives, Drives)
    return joints.count + coils.count + drives.count > 0


@kernel
def turn_least(a, b, v):
    """v turned as the least turn carries the unit vector a to b: v + w x v + w x (w x v)/(1 + a.b), w = a x b."""
    a_0, a_1, a_2 = a
    b_0, b_1, b_2 = b
    v_0, v_1, v_2 = v
    w_0, w_1, w_2 = cross(a_0, a_1, a_2, b_0, b_1, b_2)
    c_0, c_1, c_2 = cross(w_0, w_1, w_2, v_0, v_1, v_2)
    e_0, e_1, e_2 = cross(w_0, w_1, w_2, c_0, c_1, c_2)
    scale = 1.0 / max(1e-3, 1.0 + a_0 * b_0 + a_1 * b_1 + a_2 * b_2)
    return v_0 + c_0 + scale * e_0, v_1 + c_1 + scale * e_1, v_2 + c_2 + scale * e_2


@kernel
def stretch_of(network, found, springs, c, s, h, d):
    """The elongation of contact c at stage s, along its two tangents."""
    at = springs.source[c]
    if d == 2:
        springs.stretch[c, 0] = springs.xi[at, 0] + h * stage_sum(springs.rate, s, at, 0)
        return springs.stretch[c, 0], 0.0
    x_0 = springs.xi[at, 0] + h * stage_sum(springs.rate, s, at, 0)
    x_1 = springs.xi[at, 1] + h * stage_sum(springs.rate, s, at, 1)
    x_2 = springs.xi[at, 2] + h * stage_sum(springs.rate, s, at, 2)
    a, b = springs.normal_before, found.normal
    x_0, x_1, x_2 = turn_least((a[at, 0], a[at, 1], a[at, 2]), (b[c, 0], b[c, 1], b[c, 2]), (x_0, x_1, x_2))
    springs.stretch[c, 0], springs.stretch[c, 1], springs.stretch[c, 2] = x_0, x_1, x_2
    t = network.J_j
    return (
        t[c, 1, 0] * x_0 + t[c, 1, 1] * x_1 + t[c, 1, 2] * x_2,
        t[c, 2, 0] * x_0 + t[c, 2, 1] * x_1 + t[c, 2, 2] * x_2,
    )


@kernel
def write_spring_rate(bodies, network, found, springs, c, s, gamma_1, gamma_2):
    """xi' of a spatial contact: gamma_T, and the turn with the mean spin of the bodies about the normal."""
    at, i, j = springs.source[c], network.i[c], network.j[c]
    v, t, a, b, x = bodies.motion.v, network.J_j, springs.normal_before, found.normal, springs.stretch
    spin = 0.0
    for k in range(3):
        spin += 0.5 * b[c, k] * (v[i, 3 + k] + v[j, 3 + k])
    x_0, x_1, x_2 = cross(b[c, 0], b[c, 1], b[c, 2], x[c, 0], x[c, 1], x[c, 2])
    x_0 = spin * x_0 + gamma_1 * t[c, 1, 0] + gamma_2 * t[c, 2, 0]
    x_1 = spin * x_1 + gamma_1 * t[c, 1, 1] + gamma_2 * t[c, 2, 1]
    x_2 = spin * x_2 + gamma_1 * t[c, 1, 2] + gamma_2 * t[c, 2, 2]
    x_0, x_1, x_2 = turn_least((b[c, 0], b[c, 1], b[c, 2]), (a[at, 0], a[at, 1], a[at, 2]), (x_0, x_1, x_2))
    springs.rate[s, at, 0], springs.rate[s, at, 1], springs.rate[s, at, 2] = x_0, x_1, x_2


@kernel
def compliance_of(network, c, n):
    """G_NN of contact c: J_N M^-1 J_N^T [1/kg]."""
    total = 0.0
    for x in range(n):
        for y in range(n):
            total += network.J_i[c, 0, x] * network.M_inv[network.i[c], x, y] * network.J_i[c, 0, y]
            total += network.J_j[c, 0, x] * network.M_inv[network.j[c], x, y] * network.J_j[c, 0, y]
    return total


@kernel
def push(blocks, c, s, h, d, n):
    """The force of contact c on its bodies, its works, and the rate of its spring."""
    bodies, found, network, law, springs, stages = blocks
    gamma_N, gamma_1, gamma_2 = relative_velocity(network, c, d, n)
    depth = -found.gap[c]
    damping = damping_of(law, compliance_of(network, c, n) if law.zeta >= 0.0 else 0.0)
    la_N, elastic = spring_and_damper(law, damping, depth, -gamma_N)
    limit = network.mu[c] * abs(la_N)
    xi_1, xi_2 = stretch_of(network, found, springs, c, s, h, d)
    la_1, la_2, slides = friction(law, damping, limit, xi_1, xi_2, gamma_1, gamma_2)
    network.P[c, 0], network.P[c, 1] = la_N, la_1
    network.gamma[c, 0], network.gamma[c, 1] = gamma_N, gamma_1
    if d == 3:
        network.P[c, 2], network.gamma[c, 2] = la_2, gamma_2
        write_spring_rate(bodies, network, found, springs, c, s, gamma_1, gamma_2)
    else:
        springs.rate[s, springs.source[c], 0] = gamma_1
    note_excess(law, springs, springs.source[c], limit, xi_1, xi_2)
    work, given = stages.work, given_power(bodies, network, c, d, n)
    work[s, 0, NORMAL_WORK] += la_N * gamma_N
    work[s, 0, FRICTION_WORK] += la_1 * gamma_1 + la_2 * gamma_2
    work[s, 0, SURFACE_WORK] -= given
    if springs.is_asked == 1:
        write_exchange(network, springs, s, springs.source[c], c, d, given)
    work[s, 0, DAMPING_WORK] += (la_N - elastic) * gamma_N
    if not slides:
        c_T = math.sqrt(law.ratio) * damping
        work[s, 0, DAMPING_WORK] -= c_T * (gamma_1 * gamma_1 + gamma_2 * gamma_2)
    for row in range(d):
        for x in range(n):
            stages.force[network.i[c], x] += network.J_i[c, row, x] * network.P[c, row]
            stages.force[network.j[c], x] += network.J_j[c, row, x] * network.P[c, row]


@kernel
def note_excess(law, springs, at, limit, xi_1, xi_2):
    """How far a spring was stretched beyond its slider in the step, at most."""
    if law.is_regularised == 0:
        over = math.sqrt(xi_1 * xi_1 + xi_2 * xi_2) - limit / (law.ratio * law.k)
        springs.excess[at] = max(springs.excess[at], over)


@kernel
def given_power(bodies, network, c, d, n):
    """What bodies that no force moves, and running surfaces, take from the force of contact c [W]."""
    moves, v, i, j = bodies.motion.moves, bodies.motion.v, network.i[c], network.j[c]
    total = 0.0
    for row in range(d):
        given = network.b[c, row] if row > 0 else 0.0
        for x in range(n):
            given += network.J_i[c, row, x] * v[i, x] if moves[i] == 0 else 0.0
            given += network.J_j[c, row, x] * v[j, x] if moves[j] == 0 else 0.0
        total += network.P[c, row] * given
    return total


@kernel
def write_motion(bodies, network, stages, s, d, n):
    """x' and v' of all bodies."""
    for b in range(bodies.mass.shape[0]):
        if d == 3:
            write_turning(bodies, network, stages, s, b)
        for x in range(3):
            stages.x[s, b, x] = bodies.motion.v[b, x]
        for x in range(n):
            total = 0.0
            if bodies.motion.moves[b] == 1:
                for y in range(n):
                    total += network.M_inv[b, x, y] * stages.force[b, y]
            stages.v[s, b, x] = total


@kernel
def write_turning(bodies, network, stages, s, b):
    """q' = omega q/2 of a spatial body, and its gyroscopic moment -omega x I omega."""
    v, q, M = bodies.motion.v, bodies.motion.x, network.M
    o_0, o_1, o_2 = v[b, 3], v[b, 4], v[b, 5]
    w, r_0, r_1, r_2 = q[b, 3], q[b, 4], q[b, 5], q[b, 6]
    c_0, c_1, c_2 = cross(o_0, o_1, o_2, r_0, r_1, r_2)
    stages.x[s, b, 3] = -0.5 * (o_0 * r_0 + o_1 * r_1 + o_2 * r_2)
    stages.x[s, b, 4] = 0.5 * (w * o_0 + c_0)
    stages.x[s, b, 5] = 0.5 * (w * o_1 + c_1)
    stages.x[s, b, 6] = 0.5 * (w * o_2 + c_2)
    L_0 = M[b, 3, 3] * o_0 + M[b, 3, 4] * o_1 + M[b, 3, 5] * o_2
    L_1 = M[b, 4, 3] * o_0 + M[b, 4, 4] * o_1 + M[b, 4, 5] * o_2
    L_2 = M[b, 5, 3] * o_0 + M[b, 5, 4] * o_1 + M[b, 5, 5] * o_2
    g_0, g_1, g_2 = cross(o_0, o_1, o_2, L_0, L_1, L_2)
    stages.force[b, 3] -= g_0
    stages.force[b, 4] -= g_1
    stages.force[b, 5] -= g_2


@kernel
def held_energy(law, found, network, springs):
    """What the springs of the next step hold [J]."""
    total = 0.0
    for c in range(network.n_c):
        total += elastic_energy(law, -found.gap[c])
        if law.is_regularised == 0:
            for k in range(springs.next_xi.shape[1]):
                total += 0.5 * law.ratio * law.k * springs.next_xi[c, k] * springs.next_xi[c, k]
    return total
