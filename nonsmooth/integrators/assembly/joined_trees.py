"""Islands that joints alone hold, as trees of bodies: solved at once, in a time linear in their length.

    M_b dv_b = J_b^T dP,    J_b dv_b + J_p dv_p + gamma = 0         from the impulses at hand, for every joint

From the leaves on body b, whose joints are eliminated but the one to body p, is eliminated with that one:

    S = J_b A_b^-1 J_b^T,    beta = gamma + J_b A_b^-1 f_b,    A_b = M_b at a leaf,  f_b = 0
    A_p <- A_p + J_p^T S^-1 J_p,     f_p <- f_p - J_p^T S^-1 beta

and back from the root dP = -S^-1 (J_p dv_p + beta), dv_b = A_b^-1 (f_b + J_b^T dP). At most one joint of a tree is to
what no impulse moves. An island with a loop, a contact, a spring or a drive is left to the ladder of contacts.
Source: Baraff, *SIGGRAPH 1996*, 137 (linear-time dynamics with Lagrange multipliers).
"""

from __future__ import annotations

from typing import Annotated as Array

from nonsmooth.contact.network.al_newton import copy_impulses, judge_island
from nonsmooth.contact.network.joint import is_joint
from nonsmooth.contact.network.problem import Network
from nonsmooth.contact.network.solve import BY_FACTORS, ROUNDED
from nonsmooth.jit import in_dimensions, kernel
from nonsmooth.jit.blocks import Block, Floats, Ints, view
from nonsmooth.numerics.dense import cholesky, cholesky_solve

MOST_CORRECTIONS = 3  # chosen: one, and refinements of its roundings
LEAST_PIVOT = 1e-12  # chosen: of the diagonal, below which rows of a joint say one thing twice
NOT_YET, FACTORISED, NO_TREE = range(3)  # code: whether the factors of an island are there
WITHOUT_JOINT = -1  # code: in the place of a joint: a body without one, the root of what flies freely


class Tree(Block):
    """The order of elimination of an island, and the factors of its bodies and joints."""

    is_ready: Array[Ints, "n_b"]  # of an island
    order: Array[Ints, "n_b"]  # its bodies, leaves first
    by: Array[Ints, "n_b"]  # of a body: the first block of the joint that it is eliminated with
    degree: Array[Ints, "n_b"]  # joints of a body that are left
    mixed: Array[Ints, "n_b"]  # their first blocks, by exclusive or: that of the last one
    blocks: Array[Ints, "m"]  # of rows that a joint has, at the first of them
    before: Array[Floats, "m", "d"]  # the impulses at the start
    A: Array[Floats, "n_b", "n", "n"]  # L, with 1/D on its diagonal (numerics/dense.py)
    S: Array[Floats, "n_b", "6", "6"]
    beta: Array[Floats, "n_b", "6"]
    rate: Array[Floats, "n_b", "6"]
    f: Array[Floats, "n_b", "n"]
    dv: Array[Floats, "n_b", "n"]


@in_dimensions("void(int64, int64, float64, int64)")
def solve_trees(network_at, tree_at, tol, is_new, d):
    """Solve the islands that are trees of joints, but those whose impulses do; what is not met is left as it was. The
    factors are those of the problem before with the same rows, unless it is a new one."""
    network, tree = view(network_at, Network), view(tree_at, Tree)
    network.tol = tol
    for k in range(network.islands.count):
        if is_new == 1:
            tree.is_ready[k] = NO_TREE if has_others(network, k) else NOT_YET
        if network.islands.is_met[k] == 0 and tree.is_ready[k] != NO_TREE:
            solve_tree(network, tree, k, tol, d, 3 * (d - 1))


@kernel
def has_others(network, k):
    """Whether island k has other rows than those of rigid joints."""
    islands = network.islands
    for at in range(islands.contact_start[k], islands.contact_start[k + 1]):
        c = islands.contacts[at]
        if not is_joint(network, c) or network.soft[c] > 0.0:
            return True
    return False


@kernel
def is_tree(network, tree, k):
    """Whether island k is one; then its bodies are in order."""
    islands = network.islands
    for at in range(islands.body_start[k], islands.body_start[k + 1]):
        tree.degree[islands.bodies[at]] = tree.mixed[islands.bodies[at]] = 0
    at, end = islands.contact_start[k], islands.contact_start[k + 1]
    while at < end:
        c, at = islands.contacts[at], at + 1
        tree.blocks[c] = 1
        if at < end and network.i[c + 1] == network.i[c] and network.j[c + 1] == network.j[c]:
            tree.blocks[c], at = 2, at + 1
        for body in (network.i[c], network.j[c]):
            if islands.of[body] == k:
                tree.degree[body] += 1
                tree.mixed[body] ^= c
    return put_in_order(network, tree, k)


@kernel
def put_in_order(network, tree, k):
    """The leaves of island k, what they leave as leaves, and so on; False where bodies are left, those of loops."""
    islands = network.islands
    done = count = islands.body_start[k]
    for at in range(islands.body_start[k], islands.body_start[k + 1]):
        body = islands.bodies[at]
        if tree.degree[body] == 1:
            tree.order[count], count = body, count + 1
    while done < count:
        body, done = tree.order[done], done + 1
        if tree.degree[body] == 0:  # the last one, of what flies freely
            tree.by[body] = WITHOUT_JOINT
            continue
        c = tree.by[body] = tree.mixed[body]
        tree.degree[body] = 0
        other = other_of(network, c, body)
        if islands.of[other] == k:
            tree.degree[other] -= 1
            tree.mixed[other] ^= c
            if tree.degree[other] == 1:
                tree.order[count], count = other, count + 1
    return count == islands.body_start[k + 1]


@kernel
def solve_tree(network, tree, k, tol, d, n):
    """Solve island k from its impulses, to rounding."""
    islands = network.islands
    start = judge_island(network, k, d, n)
    islands.residual[k] = start
    if start <= ROUNDED:
        islands.is_met[k] = 1
        return
    if tree.is_ready[k] == NOT_YET:
        tree.is_ready[k] = (
            FACTORISED if is_tree(network, tree, k) and factorise_tree(network, tree, k, d, n) else NO_TREE
        )
    if tree.is_ready[k] == NO_TREE:
        return
    best = start
    for _ in range(MOST_CORRECTIONS):
        copy_impulses(islands, k, network.P, tree.before, d)
        add_change(network, tree, k, d, n)
        error = judge_island(network, k, d, n)
        if not error < best:
            copy_impulses(islands, k, tree.before, network.P, d)
            error = judge_island(network, k, d, n)
        is_done = error <= ROUNDED or not error < best
        best = error
        if is_done:
            break
    islands.residual[k] = best
    islands.rung[k] = BY_FACTORS
    islands.factors[k] += 1
    if best <= tol:
        islands.is_met[k] = 1


@kernel
def other_of(network, c, body):
    """The other body of block c."""
    return network.j[c] if network.i[c] == body else network.i[c]


@kernel
def factorise_tree(network, tree, k, d, n):
    """A and S of all bodies; False where rows say what others say."""
    begin, end = network.islands.body_start[k], network.islands.body_start[k + 1]
    for at in range(begin, end):
        body = tree.order[at]
        for x in range(n):
            for y in range(n):
                tree.A[body, x, y] = network.M[body, x, y]
    for at in range(begin, end):
        body = tree.order[at]
        if not cholesky(n, n - 1, tree.A[body], tree.A[body]):
            return False
        c = tree.by[body]
        if c == WITHOUT_JOINT:
            continue
        rows = d * tree.blocks[c]
        J = network.J_i if network.i[c] == body else network.J_j
        for row in range(rows):  # S = J A^-1 J^T, with dv as the room for A^-1 J^T
            for x in range(n):
                tree.dv[body, x] = J[c + row // d, row % d, x]
            cholesky_solve(n, n - 1, tree.A[body], tree.dv[body])
            for other in range(rows):
                total = 0.0
                for x in range(n):
                    total += J[c + other // d, other % d, x] * tree.dv[body, x]
                tree.S[body, row, other] = total
        if not factorise_rows(tree.S[body], tree.beta[body], rows):
            return False
        add_to_parent(network, tree, k, body, c, rows, d, n)
    return True


@kernel
def factorise_rows(S, diagonal, rows):
    """The factor of S, with 1 for a row that a block does not use; False where rows say one thing twice."""
    for row in range(rows):
        if S[row, row] == 0.0:
            S[row, row] = 1.0
        diagonal[row] = S[row, row]
    if not cholesky(rows, rows - 1, S, S):
        return False
    for row in range(rows):
        if S[row, row] * LEAST_PIVOT * diagonal[row] >= 1.0:  # S holds the inverse of the pivot
            return False
    return True


@kernel
def add_to_parent(network, tree, k, body, c, rows, d, n):
    """A_p <- A_p + J_p^T S^-1 J_p."""
    parent = other_of(network, c, body)
    if network.islands.of[parent] != k:
        return
    J = network.J_i if network.i[c] == parent else network.J_j
    for x in range(n):
        for row in range(rows):
            tree.beta[body, row] = J[c + row // d, row % d, x]
        cholesky_solve(rows, rows - 1, tree.S[body], tree.beta[body])
        for y in range(n):
            total = 0.0
            for row in range(rows):
                total += J[c + row // d, row % d, y] * tree.beta[body, row]
            tree.A[parent, x, y] += total


@kernel
def add_change(network, tree, k, d, n):
    """P <- P + dP, from the velocities at hand."""
    begin, end = network.islands.body_start[k], network.islands.body_start[k + 1]
    for at in range(begin, end):
        for x in range(n):
            tree.f[tree.order[at], x] = 0.0
    for at in range(begin, end):
        gather(network, tree, tree.order[at], d, n)
    for at in range(end - 1, begin - 1, -1):
        scatter(network, tree, tree.order[at], d, n)


@kernel
def gather(network, tree, body, d, n):
    """beta of a body, and what it adds to f of its parent."""
    c = tree.by[body]
    if c == WITHOUT_JOINT:
        return
    for x in range(n):
        tree.dv[body, x] = tree.f[body, x]
    cholesky_solve(n, n - 1, tree.A[body], tree.dv[body])
    rows, parent = d * tree.blocks[c], other_of(network, c, body)
    J = network.J_i if network.i[c] == body else network.J_j
    for row in range(rows):
        block, a = c + row // d, row % d
        gamma = network.b[block, a]
        for x in range(n):
            gamma += network.J_i[block, a, x] * network.v[network.i[c], x]
            gamma += network.J_j[block, a, x] * network.v[network.j[c], x]
            gamma += J[block, a, x] * tree.dv[body, x]
        tree.beta[body, row] = gamma
    cholesky_solve(rows, rows - 1, tree.S[body], tree.beta[body])
    of_parent = network.J_i if network.i[c] == parent else network.J_j
    for row in range(rows):
        for x in range(n):
            tree.f[parent, x] -= of_parent[c + row // d, row % d, x] * tree.beta[body, row]


@kernel
def scatter(network, tree, body, d, n):
    """dP of the joint of a body, whose parent has dv, and its dv."""
    c = tree.by[body]
    if c != WITHOUT_JOINT:
        rows, parent = d * tree.blocks[c], other_of(network, c, body)
        J = network.J_i if network.i[c] == body else network.J_j
        of_parent = network.J_i if network.i[c] == parent else network.J_j
        is_moved = network.islands.of[parent] >= 0
        for row in range(rows):
            tree.rate[body, row] = 0.0
            for x in range(n):
                tree.rate[body, row] += of_parent[c + row // d, row % d, x] * tree.dv[parent, x] if is_moved else 0.0
        cholesky_solve(rows, rows - 1, tree.S[body], tree.rate[body])
        for row in range(rows):
            impulse = -tree.beta[body, row] - tree.rate[body, row]
            network.P[c + row // d, row % d] += impulse
            for x in range(n):
                tree.f[body, x] += J[c + row // d, row % d, x] * impulse
    for x in range(n):
        tree.dv[body, x] = tree.f[body, x]
    cholesky_solve(n, n - 1, tree.A[body], tree.dv[body])
