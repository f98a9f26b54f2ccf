"""Which islands may have no solution, or several: a necessary condition that costs less than a contact.

A contact that slides along t gives its normal velocity p P_N, p = G_NN - mu G_NT.t; what touches in an island of few
contacts has one solution whatever its load where all principal minors of

    A = G_NN - G_NT diag(mu t)

are positive, so that it is a P-matrix. One that does not slide fast enough to go on through the step may turn either
way, or stick: then its two rows stand among the minors. That is the condition of coherent orientation, for the modes
that are possible from here. So an island is *doubtful* where a minor is negative, and only then is it asked how many
solutions there are (``paradox.py``). The minors are the pivots of a walk through the modes, each contact eliminated in
turn; pivots that vanish are those of contacts which add no motion, and their branches are left out.

Joints are eliminated first: G and the free velocities are those of contacts whose bodies are held by them,

    G <- G - G_j G_jj^-1 G_j^T,    gamma <- gamma - G_j G_jj^-1 gamma_j

pivot by pivot; a row that others say already has none. A weld thus makes one body of two.

In space the direction of a slide is one of many: islands of which a touching contact does not slide fast enough are not
asked. Neither are islands with compliant contacts, springs, motors, friction in joints or limits that are reached,
those of a contact that joints hold fast along its normal, of more than MOST_HELD blocks of rows of joints, of more than
FEW_TOUCHING contacts that touch, and of more than FEW_TURNING where one may stop.

Source: Lötstedt, *ZAMM* 61 (1981) 605; Robinson, *Math. Oper. Res.* 17 (1992) 691 (coherent orientation).
Equations: docs/theory/scenes.md, (9).
"""

from __future__ import annotations

from math import sqrt
from typing import Annotated as Array

from nonsmooth.contact.network.joint import is_contact, is_joint, is_powered
from nonsmooth.contact.network.problem import Network
from nonsmooth.contact.planar.reduction import SAME_ROW
from nonsmooth.integrators.assembly.bodies import Bodies
from nonsmooth.jit import in_dimensions, kernel
from nonsmooth.jit.blocks import Block, Floats, Ints, view
from nonsmooth.scenes.detection import Found

FEW_TOUCHING = 4  # chosen: contacts of an island that touch: as those of a box on a face in space
# measured: of these where one may stop: three take 0.6 us, four 1.8 us, a third of the step of two boxes on a belt
FEW_TURNING = 3
MOST_HELD = 12  # chosen: blocks of rows of joints: twelve pins in the plane, six hinges in space
SAID_TWICE = 1e-10  # chosen: part of a row's own diagonal that others leave of it where they say the same
LEAST_MINOR = 1e-9  # chosen: part of the diagonal of G below which a pivot is called zero: far above rounding
SURE_SLIDE = 2.0  # chosen: times what a step may change of a sliding velocity, beyond which it goes on
LEFT_OPEN, SLID_PLUS, SLID_MINUS, HELD_FAST = range(4)  # code: modes of the walk
LAST_MODE = HELD_FAST  # code: of them


class Doubts(Block, few=FEW_TOUCHING, held=MOST_HELD):
    """Islands that are doubtful, and what they are found in: rows (N, T) of a contact, N alone where it only slides."""

    count: int
    slides: int  # 1 where all that touch slide for sure: their normal rows are all there is to the walk
    near: float  # gap that counts as none where a run begins [m]
    island: Array[Ints, "n_b"]
    contact: Array[Ints, "few"]  # that touch
    way: Array[Ints, "few"]  # the sign of sliding; 0: either, or none
    t: Array[Floats, "few", 2]  # the direction of sliding along the tangents
    mode: Array[Ints, "few"]
    like: Array[Ints, "few"]  # the first contact with the same tangential row: closed, they slide or stick alike
    images: Array[Floats, "few", 2, 6]  # M^-1 J^T of an impulse, on either body
    G: Array[Floats, "2 * few", "2 * few"]
    joints: int  # blocks of rows of joints, which are eliminated
    joint: Array[Ints, "held"]
    # of d rows of the contacts that touch, and behind them those of the joints: G and, last, the free velocities
    Q: Array[Floats, "3 * (few + held)", "3 * (few + held) + 1"]
    S: Array[Floats, "few", "2 * few", "2 * few"]  # what is left of it, one a level


@in_dimensions("int64(int64, int64, int64, int64, int64)")
def find_doubtful(bodies_at, found_at, network_at, doubts_at, is_start, d):
    """List the doubtful islands of a step whose rows are prepared; returns how many they are."""
    bodies, found, network = view(bodies_at, Bodies), view(found_at, Found), view(network_at, Network)
    doubts = view(doubts_at, Doubts)
    n, near = 3 * (d - 1), doubts.near if is_start == 1 else 0.0
    doubts.count = 0
    for k in range(network.islands.count):
        touching = list_touching(found, network, k, near, doubts, d)
        if touching > 0 and doubts.joints > 0:
            eliminate_joints(network, touching, doubts, d, n)
            touching = 0 if is_held_fast(network, touching, doubts, d) else touching
        if touching > 0 and find_ways(bodies, network, touching, doubts, d, n):
            if is_doubtful(network, touching, doubts, d, n):
                doubts.island[doubts.count] = k
                doubts.count += 1
    return doubts.count


@kernel
def is_doubtful(network, touching, doubts, d, n):
    """Whether a minor of the contacts that touch is negative."""
    if touching == 1:
        return is_one_doubtful(network, doubts)
    doubts.slides = 1 if do_all_slide(touching, doubts) else 0
    if doubts.slides == 0 and touching > FEW_TURNING:
        return False
    if doubts.joints > 0:
        take_held(network, touching, doubts, d)
    elif doubts.slides == 1:
        write_slides(network, touching, doubts, d, n)
    else:
        write_matrix(network, touching, doubts, n)
    return has_negative_minor(network, touching, doubts)


@kernel
def list_touching(found, network, k, near, doubts, d):
    """List the contacts of island k that touch. Returns how many, or 0 where the island is not looked at, or friction
    cannot matter."""
    n = 3 * (d - 1)
    islands, count, is_rough, may_matter = network.islands, 0, False, False
    doubts.joints = 0
    for at in range(islands.contact_start[k], islands.contact_start[k + 1]):
        c = islands.contacts[at]
        if is_joint(network, c):
            if doubts.joints == doubts.joint.shape[0]:
                return 0
            doubts.joint[doubts.joints] = c
            doubts.joints += 1
            continue
        if network.soft[c] > 0.0 or is_powered(network, c):
            return 0
        if not touches(found, network, c, near, n):
            continue
        if not is_contact(network, c):
            return 0
        if count == doubts.contact.shape[0]:
            return 0
        doubts.contact[count] = c
        count += 1
        friction = network.mu[c] * abs(network.W[c, 0, 1])
        if d == 3:
            friction += network.mu[c] * abs(network.W[c, 0, 2])
        is_rough = is_rough or network.mu[c] > 0.0
        may_matter = may_matter or friction >= network.W[c, 0, 0]
    return count if may_matter or ((count > 1 or doubts.joints > 0) and is_rough) else 0


@kernel
def eliminate_joints(network, touching, doubts, d, n):
    """Q of the contacts that touch, with their bodies held by the joints of the island."""
    Q, rows, blocks = doubts.Q, d * touching, touching + doubts.joints
    last = Q.shape[1] - 1
    for e in range(blocks):
        c = block_at(doubts, e, touching)
        for a in range(d):
            Q[d * e + a, last] = free_velocity(network, c, a, n)
            for f in range(blocks):
                for b in range(d):
                    Q[d * e + a, d * f + b] = response(network, (c, a), (block_at(doubts, f, touching), b), n)
        if e >= touching:
            for a in range(d):
                Q[d * e + a, d * e + a] += network.soft[c]
    for p in range(rows, d * blocks):
        if not Q[p, p] > SAID_TWICE * network.W[block_at(doubts, p // d, touching), p % d, p % d]:
            continue
        for r in range(d * blocks):
            if r < rows or r > p:
                factor = Q[r, p] / Q[p, p]
                for s in range(d * blocks):
                    if s < rows or s > p:
                        Q[r, s] -= factor * Q[p, s]
                Q[r, last] -= factor * Q[p, last]


@kernel
def is_held_fast(network, touching, doubts, d):
    """Whether a contact that touches cannot move along its normal, since joints hold its bodies."""
    for e in range(touching):
        if not doubts.Q[d * e, d * e] > LEAST_MINOR * network.W[doubts.contact[e], 0, 0]:
            return True
    return False


@kernel
def block_at(doubts, e, touching):
    """The row of the network of block e: of contacts that touch, and behind them joints."""
    return doubts.contact[e] if e < touching else doubts.joint[e - touching]


@kernel
def free_velocity(network, c, a, n):
    """gamma of row a of c at the free velocities."""
    gamma = network.b[c, a]
    for x in range(n):
        of_i, of_j = network.v_free[network.i[c], x], network.v_free[network.j[c], x]
        gamma += network.J_i[c, a, x] * of_i + network.J_j[c, a, x] * of_j
    return gamma


@kernel
def response(network, of, to, n):
    """What an impulse of row ``to`` does to the velocity of row ``of``, by the bodies that they share [1/kg]."""
    (c, a), (f, b) = of, to
    parent, total = network.islands.parent, 0.0
    for side in range(2):
        body = network.i[f] if side == 0 else network.j[f]
        if parent[body] < 0:
            continue
        Y = network.Y_i if side == 0 else network.Y_j
        for x in range(n):
            if network.i[c] == body:
                total += network.J_i[c, a, x] * Y[f, b, x]
            if network.j[c] == body:
                total += network.J_j[c, a, x] * Y[f, b, x]
    return total


@kernel
def own(network, doubts, e, a, b):
    """The entry of G of rows a and b of touching contact e, by the bodies as the joints hold them."""
    if doubts.joints > 0:
        d = network.W.shape[1]
        return doubts.Q[d * e + a, d * e + b]
    return network.W[doubts.contact[e], a, b]


@kernel
def take_held(network, touching, doubts, d):
    """A, or G of planar contacts, of Q."""
    Q, G = doubts.Q, doubts.G
    for f in range(touching):
        friction = -network.mu[doubts.contact[f]] * doubts.way[f]
        for e in range(touching):
            if doubts.slides == 1:
                G[2 * e, 2 * f] = Q[d * e, d * f] + friction * doubts.t[f, 0] * Q[d * e, d * f + 1]
                if d == 3:
                    G[2 * e, 2 * f] += friction * doubts.t[f, 1] * Q[d * e, d * f + 2]
                continue
            for a in range(2):
                for b in range(2):
                    G[2 * e + a, 2 * f + b] = Q[d * e + a, d * f + b]
    if doubts.slides == 0:
        note_alike(touching, doubts)


@kernel
def touches(found, network, c, near, n):
    """Whether contact c is closed, was pressed in the step before or would close in this one."""
    return is_closed(found, network, c, near) or network.P[c, 0] > 0.0 or free_velocity(network, c, 0, n) < 0.0


@kernel
def is_closed(found, network, c, near):
    """Whether contact c has no gap."""
    return network.b[c, 0] <= 0.0 or found.gap[c] <= near


@kernel
def find_ways(bodies, network, touching, doubts, d, n):
    """How the contacts that touch slide; False where one of space does not slide for sure."""
    for e in range(touching):
        c = doubts.contact[e]
        i, j = network.i[c], network.j[c]
        speed_0, speed_1 = network.b[c, 1], network.b[c, 2] if d == 3 else 0.0
        change_0, change_1, normal = 0.0, 0.0, network.b[c, 0]
        for x in range(n):
            of_i, of_j = bodies.v_0[i, x], bodies.v_0[j, x]
            to_i, to_j = network.v_free[i, x], network.v_free[j, x]
            normal += network.J_i[c, 0, x] * to_i + network.J_j[c, 0, x] * to_j
            speed_0 += network.J_i[c, 1, x] * of_i + network.J_j[c, 1, x] * of_j
            change_0 += network.J_i[c, 1, x] * (to_i - of_i) + network.J_j[c, 1, x] * (to_j - of_j)
            if d == 3:
                speed_1 += network.J_i[c, 2, x] * of_i + network.J_j[c, 2, x] * of_j
                change_1 += network.J_i[c, 2, x] * (to_i - of_i) + network.J_j[c, 2, x] * (to_j - of_j)
        if doubts.joints > 0:
            last = doubts.Q.shape[1] - 1
            normal, change_0 = doubts.Q[d * e, last], doubts.Q[d * e + 1, last] - speed_0
            change_1 = doubts.Q[d * e + 2, last] - speed_1 if d == 3 else 0.0
        speed = sqrt(speed_0 * speed_0 + speed_1 * speed_1)
        P_N = max(network.P[c, 0], abs(normal) / own(network, doubts, e, 0, 0))
        W = max(own(network, doubts, e, 1, 1), own(network, doubts, e, 2, 2) if d == 3 else 0.0)
        change = abs(change_0) + abs(change_1) + (network.mu[c] * W + abs(own(network, doubts, e, 0, 1))) * P_N
        doubts.way[e], doubts.t[e, 0], doubts.t[e, 1] = 0, 1.0, 0.0
        if speed > SURE_SLIDE * change:
            doubts.way[e] = 1 if d == 3 or speed_0 > 0.0 else -1
            if d == 3:
                doubts.t[e, 0], doubts.t[e, 1] = speed_0 / speed, speed_1 / speed
        elif d == 3:
            return False
    return True


@kernel
def is_one_doubtful(network, doubts):
    """Whether p <= 0 for the only contact, in a direction in which it may slide."""
    mu, way, W_NN = network.mu[doubts.contact[0]], doubts.way[0], own(network, doubts, 0, 0, 0)
    friction = mu * own(network, doubts, 0, 0, 1) * doubts.t[0, 0]
    if network.W.shape[1] == 3:
        friction += mu * own(network, doubts, 0, 0, 2) * doubts.t[0, 1]
    return (way >= 0 and friction >= W_NN) or (way <= 0 and -friction >= W_NN)


@kernel
def do_all_slide(touching, doubts):
    """Whether all that touch slide for sure; in space they do, or are not asked."""
    for e in range(touching):
        if doubts.way[e] == 0:
            return False
    return True


@kernel
def write_slides(network, touching, doubts, d, n):
    """A, in the normal rows of G."""
    images = doubts.images
    for f in range(touching):
        c = doubts.contact[f]
        friction = -network.mu[c] * doubts.way[f]
        along, across = friction * doubts.t[f, 0], friction * doubts.t[f, 1]
        for x in range(n):
            images[f, 0, x] = network.Y_i[c, 0, x] + along * network.Y_i[c, 1, x]
            images[f, 1, x] = network.Y_j[c, 0, x] + along * network.Y_j[c, 1, x]
            if d == 3:
                images[f, 0, x] += across * network.Y_i[c, 2, x]
                images[f, 1, x] += across * network.Y_j[c, 2, x]
    for e in range(touching):
        for f in range(touching):
            doubts.G[2 * e, 2 * f] = acts_on(network, 0, (e, f), doubts, n)


@kernel
def write_matrix(network, touching, doubts, n):
    """G of planar contacts, rows N and T."""
    for row in range(2 * touching):
        c = doubts.contact[row // 2]
        for column in range(2 * touching):
            doubts.G[row, column] = response(network, (c, row % 2), (doubts.contact[column // 2], column % 2), n)
    note_alike(touching, doubts)


@kernel
def note_alike(touching, doubts):
    """Note which contacts have the same tangential row."""
    for f in range(touching):
        doubts.like[f] = f
        for e in range(f - 1, -1, -1):
            if has_same_slide(2 * e + 1, 2 * f + 1, doubts.G):
                doubts.like[f] = e


@kernel
def has_same_slide(a, b, G):
    """Whether two tangential rows are the same, |J_a - J_b|^2 = 0 in the metric of the masses."""
    return G[a, a] + G[b, b] - G[a, b] - G[b, a] <= SAME_ROW * (G[a, a] + G[b, b])


@kernel
def acts_on(network, row, places, doubts, n):
    """What an impulse of contact f, whose images are given, does to a row of contact e by the bodies they share."""
    e, f = places
    c, other, parent, images = doubts.contact[e], doubts.contact[f], network.islands.parent, doubts.images
    i, j, total = network.i[c], network.j[c], 0.0
    for side in range(2):
        body = network.i[other] if side == 0 else network.j[other]
        if parent[body] < 0:
            continue
        if i == body:
            for x in range(n):
                total += network.J_i[c, row, x] * images[f, side, x]
        if j == body:
            for x in range(n):
                total += network.J_j[c, row, x] * images[f, side, x]
    return total


@kernel
def is_possible(level, mode, doubts):
    """Whether a contact may have a mode of the walk in the step: one that slides goes on, or opens; those that slide
    alike do."""
    way = doubts.way[level]
    if mode == LEFT_OPEN:
        return True
    for e in range(level if doubts.slides == 0 else 0):
        if doubts.like[e] == doubts.like[level] and doubts.mode[e] != LEFT_OPEN and doubts.mode[e] != mode:
            return False
    return way == 0 or (mode == SLID_PLUS and way > 0) or (mode == SLID_MINUS and way < 0)


@kernel
def has_negative_minor(network, touching, doubts):
    """Whether a pivot of the walk is negative."""
    S, G, level = doubts.S, doubts.G, 0
    for a in range(0, 2 * touching, 1 + doubts.slides):
        for b in range(0, 2 * touching, 1 + doubts.slides):
            S[0, a, b] = G[a, b]
    doubts.mode[0] = LEFT_OPEN - 1
    while level >= 0:
        doubts.mode[level] += 1
        mode = doubts.mode[level]
        if mode > LAST_MODE:
            level -= 1
        elif is_possible(level, mode, doubts):
            pivot = pivot_of(network, level, mode, doubts)
            if pivot < -LEAST_MINOR:
                return True
            if pivot > LEAST_MINOR and level < touching - 1:
                reduce_rows(network, level, 2 * touching, doubts)
                level += 1
                doubts.mode[level] = LEFT_OPEN - 1
    return False


@kernel
def pivot_of(network, level, mode, doubts):
    """The pivot of a contact in a mode, relative to the diagonal of G. Where sticking is what others do already its
    normal row is left."""
    a, G = 2 * level, doubts.G
    S_NN, S_NT = doubts.S[level, a, a], doubts.S[level, a, a + 1]
    S_TN, S_TT = doubts.S[level, a + 1, a], doubts.S[level, a + 1, a + 1]
    if mode == LEFT_OPEN:
        return 1.0
    if doubts.slides == 1:
        return S_NN / network.W[doubts.contact[level], 0, 0]
    mu = network.mu[doubts.contact[level]]
    if mode == SLID_PLUS:
        return (S_NN - mu * S_NT) / G[a, a]
    if mode == SLID_MINUS:
        return (S_NN + mu * S_NT) / G[a, a]
    if is_held_by_others(level, doubts):
        return S_NN / G[a, a]
    return (S_NN * S_TT - S_NT * S_TN) / (G[a, a] * G[a + 1, a + 1])


@kernel
def is_held_by_others(level, doubts):
    """Whether a contact whose normal velocity is zero does not slide, since those before it do not."""
    a, G, S, m = 2 * level, doubts.G, doubts.S, level
    S_NN, S_NT, S_TN, S_TT = S[m, a, a], S[m, a, a + 1], S[m, a + 1, a], S[m, a + 1, a + 1]
    left = max(abs(S_NN) / G[a, a], abs(S_TT) / G[a + 1, a + 1])
    return abs(S_NN * S_TT - S_NT * S_TN) <= LEAST_MINOR * left * G[a, a] * G[a + 1, a + 1]


@kernel
def reduce_rows(network, level, rows, doubts):
    """What the rows of the contacts after this one are once it has its mode."""
    S, a, mode = doubts.S, 2 * level, doubts.mode[level]
    if doubts.slides == 1:
        eliminate_slide(level, rows, 0.0 if mode == LEFT_OPEN else -1.0 / S[level, a, a], doubts)
        return
    mu = network.mu[doubts.contact[level]]
    is_held = mode == HELD_FAST and is_held_by_others(level, doubts)
    factor = 0.0 if is_held else -mu if mode == SLID_PLUS else mu
    S_NN, S_NT, S_TN, S_TT = S[level, a, a], S[level, a, a + 1], S[level, a + 1, a], S[level, a + 1, a + 1]
    p, determinant = S_NN + factor * S_NT, S_NN * S_TT - S_NT * S_TN
    for m in range(a + 2, rows):
        N, T = S[level, a, m], S[level, a + 1, m]
        P_N, P_T = 0.0, 0.0
        if mode == HELD_FAST and not is_held:
            P_N, P_T = (S_NT * T - S_TT * N) / determinant, (S_TN * N - S_NN * T) / determinant
        elif mode != LEFT_OPEN:
            P_N = -N / p
            P_T = factor * P_N
        for k in range(a + 2, rows):
            S[level + 1, k, m] = S[level, k, m] + S[level, k, a] * P_N + S[level, k, a + 1] * P_T


@kernel
def eliminate_slide(level, rows, factor, doubts):
    """The same where all slide, or open: of the normal rows alone."""
    S, a = doubts.S, 2 * level
    for m in range(a + 2, rows, 2):
        P_N = factor * S[level, a, m]
        for k in range(a + 2, rows, 2):
            S[level + 1, k, m] = S[level, k, m] + S[level, k, a] * P_N
