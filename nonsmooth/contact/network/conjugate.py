"""Sweeps of Gauss-Seidel as gradients of a nonsmooth, nonlinear method of conjugate gradients.

    g_k = sweep(P_k) - P_k,   beta = |g_k|^2 / |g_(k-1)|^2   (Fletcher, Reeves),
    P_(k+1) = sweep(P_k) + beta p_k,   p_(k+1) = g_k + beta p_k;   restarted with p_(k+1) = g_k where beta > 1

Velocities are linear in impulses, so theirs go along. A plain sweep at the end brings the impulses back into the cones.

Source: Silcowitz-Hansen, Niebe and Erleben, A nonsmooth nonlinear conjugate gradient method for interactive contact
force problems, Visual Computer 26 (2010) 893-901.
"""

from __future__ import annotations

from typing import Annotated as Array

from nonsmooth.contact.network.gauss_seidel import relax
from nonsmooth.jit import kernel
from nonsmooth.jit.blocks import Block, Floats


class Conjugate(Block):
    """The memory of the method: impulses and velocities before a sweep, and the direction of both."""

    P: Array[Floats, "m", "d"]
    v: Array[Floats, "n_b", "n"]
    along_P: Array[Floats, "m", "d"]
    along_v: Array[Floats, "n_b", "n"]


@kernel
def conjugate_sweeps(network, memory, k, most, tol, d, n):
    """Sweep island k from its velocities until |g| <= tol |P|, ``most`` times at most; how often."""
    islands = network.islands
    begin, end = islands.contact_start[k], islands.contact_start[k + 1]
    before = 0.0
    for count in range(most):
        keep(network, memory, k, d, n)
        change, size = 0.0, 0.0
        for at in range(begin, end):
            moved, is_now = relax(network, islands.contacts[at], 1.0, d, n)
            change += moved
            size += is_now
        if change <= tol * tol * size or count == most - 1:
            return count + 1
        go_along(network, memory, k, change / before if before > change else 0.0, d, n)
        before = change
    return most


@kernel
def keep(network, memory, k, d, n):
    """Keep impulses and velocities of island k."""
    islands = network.islands
    for at in range(islands.contact_start[k], islands.contact_start[k + 1]):
        c = islands.contacts[at]
        for a in range(d):
            memory.P[c, a] = network.P[c, a]
    for at in range(islands.body_start[k], islands.body_start[k + 1]):
        body = islands.bodies[at]
        for x in range(n):
            memory.v[body, x] = network.v[body, x]


@kernel
def go_along(network, memory, k, beta, d, n):
    """Add beta times the direction, and turn it; beta = 0 begins anew."""
    islands = network.islands
    for at in range(islands.contact_start[k], islands.contact_start[k + 1]):
        turn(network.P, memory.P, memory.along_P, islands.contacts[at], beta, d)
    for at in range(islands.body_start[k], islands.body_start[k + 1]):
        turn(network.v, memory.v, memory.along_v, islands.bodies[at], beta, n)


@kernel
def turn(now, before, along, row, beta, size):
    """along <- now - before + beta along of one row, and now <- now + beta (along as it was)."""
    for x in range(size):
        gradient = now[row, x] - before[row, x]
        share = beta * along[row, x] if beta > 0.0 else 0.0  # what is left of another problem may be anything
        now[row, x] += share
        along[row, x] = gradient + share
