"""What each pair of bodies on springs exchanges in a step, for runs that ask (assembly/pairs.py).

    P = h sum_s b_s F_s,   works = h sum_s b_s (la_N gamma_N, la_T gamma_T, -la . what the sides are given)

b_s are the weights of the step (table.py): so what bodies are given is what their velocities changed by, and the works
are those of the ledger.
"""

from __future__ import annotations

from nonsmooth.integrators.assembly.contacts import shape_of_key
from nonsmooth.integrators.assembly.pairs import CONTACT, PAIR_WORKS, Pairs, row_in_step, settle
from nonsmooth.integrators.springs.law import Springs
from nonsmooth.integrators.springs.table import LAST_STAGE, stage_sum
from nonsmooth.jit import kernel, rare_kernel
from nonsmooth.jit.blocks import view
from nonsmooth.scenes.shape_rows import Shapes

N_POWERS = len(PAIR_WORKS)  # derived: columns of an exchange behind the force


@rare_kernel
def begin_exchanges(springs, s, first, end):
    """Some springs do nothing at a stage, so far."""
    for at in range(first, end):
        for k in range(springs.exchange.shape[2]):
            springs.exchange[s, at, k] = 0.0


@rare_kernel
def insert_exchange(springs, at):
    """A new spring takes the place of another one, which goes to the next place."""
    for s in range(springs.exchange.shape[0]):
        for k in range(springs.exchange.shape[2]):
            for to in range(springs.n_before, at, -1):
                springs.exchange[s, to, k] = springs.exchange[s, to - 1, k]
            springs.exchange[s, at, k] = 0.0


@rare_kernel
def write_exchange(network, springs, s, at, c, d, given):
    """What contact c does at stage s by a spring: the force on body j in the axes of the world, and the powers of its
    normal force, of friction, and of its guided sides, which take ``given`` [W]."""
    exchange, friction = springs.exchange, 0.0
    for k in range(d):
        exchange[s, at, k] = 0.0
        for a in range(d):
            exchange[s, at, k] += network.J_j[c, a, k] * network.P[c, a]
    for row in range(1, d):
        friction += network.P[c, row] * network.gamma[c, row]
    exchange[s, at, d] = network.P[c, 0] * network.gamma[c, 0]
    exchange[s, at, d + 1], exchange[s, at, d + 2] = friction, -given


@kernel
def acts(springs, at):
    """Whether a spring pushed in the step."""
    for s in range(LAST_STAGE):
        for k in range(springs.xi.shape[1]):
            if springs.exchange[s, at, k] != 0.0:
                return True
    return False


@kernel("void(int64, int64, int64, float64)")
def book_exchanges(shapes_at, springs_at, pairs_at, h):
    """Book a step of length h, before its springs become those of the next one."""
    shapes, springs, pairs = view(shapes_at, Shapes), view(springs_at, Springs), view(pairs_at, Pairs)
    settle(pairs)
    pairs.step += 1
    pairs.is_open = 1
    for at in range(springs.n_before):
        if acts(springs, at):
            key = springs.key_before[at]
            row = row_in_step(pairs, shapes.body[shape_of_key(key, 0)], shapes.body[shape_of_key(key, 1)], CONTACT)
            for k in range(springs.exchange.shape[2]):
                pairs.now[row, k] += h * stage_sum(springs.exchange, LAST_STAGE, at, k)
