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
    islands, before = network.islands, 0.0
    keep(islands, memory, k, network.P, 0, d, network.v, n)
    for count in range(most):
        change, size = 0.0, 0.0
        for at in range(islands.contact_start[k], islands.contact_start[k + 1]):
            moved, is_now = relax(network, islands.contacts[at], d, n)
            change += moved
            size += is_now
        if change <= tol * tol * size or count == most - 1:
            return count + 1
        go_along(islands, memory, k, share_of_direction(change, before), network.P, network.v, (0, d, n))
        before = change
    return most


@kernel
def share_of_direction(change, before):
    """beta of |g|^2 and of that before; 0 begins anew."""
    return change / before if before > change else 0.0


@kernel
def keep(islands, memory, k, P, first, d, v, n):
    """Keep impulses and velocities of island k; those of a contact are d numbers of its row, from the first one on."""
    for at in range(islands.contact_start[k], islands.contact_start[k + 1]):
        c = islands.contacts[at]
        for a in range(d):
            memory.P[c, a] = P[c, first + a]
    for at in range(islands.body_start[k], islands.body_start[k + 1]):
        body = islands.bodies[at]
        for x in range(n):
            memory.v[body, x] = v[body, x]


@kernel
def go_along(islands, memory, k, beta, P, v, sizes):
    """Add beta times the direction, and turn it; impulses and velocities, and sizes (first, d, n), as in ``keep``."""
    first, d, n = sizes
    for at in range(islands.contact_start[k], islands.contact_start[k + 1]):
        turn(P, first, memory.P, memory.along_P, islands.contacts[at], beta, d)
    for at in range(islands.body_start[k], islands.body_start[k + 1]):
        turn(v, 0, memory.v, memory.along_v, islands.bodies[at], beta, n)


@kernel
def turn(now, first, before, along, row, beta, size):
    """along <- now - before + beta along of one row, now <- now + beta (along as it was), and before <- now."""
    for x in range(size):
        value, share = now[row, first + x], 0.0
        if beta > 0.0:  # else what is there may be of another problem
            share = beta * along[row, x]
        along[row, x] = value - before[row, x] + share
        now[row, first + x] = before[row, x] = value + share
