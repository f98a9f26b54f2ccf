"""Contacts with friction in two directions as blocks of three rows (N, T1, T2), for the solvers of contact/blocks.

What a contact does not have is a row of its own that no other row is coupled to: a contact without friction has two,
one of planar friction has one, where P = 0 and gamma = 0 solve it; under a given normal impulse it has the row N with
G_NN P_N = G_NN P_N,given. A contact of the system that is not closed has nothing else.
"""

from __future__ import annotations

from typing import Annotated as Array

from nonsmooth.contact.spatial.all_solutions import OneContact
from nonsmooth.jit import kernel
from nonsmooth.jit.blocks import Block, Floats, Ints
from nonsmooth.mechanics.system import GIVEN_FORCE

ROWS = 3  # derived: of a block


class Spatial(Block, m="3 * n"):
    """The problem of n contacts; place k is that of closed contact k."""

    G: Array[Floats, "n * n", ROWS, ROWS]  # blocks of compressed rows
    columns: Array[Ints, "n * n"]
    starts: Array[Ints, "n + 1"]
    row: Array[Ints, "n", ROWS]  # of the contact problem; -1: none
    size: Array[Floats, "n"]  # G of the rows that it does not have
    c: Array[Floats, "m"]
    offset: Array[Floats, "m"]  # that friction is asked with beside c: it opposes offset + gamma_T
    mu: Array[Floats, "n"]
    state: Array[Ints, "n"]  # of the search: how the direction of friction is taken (solve.py)
    rho: Array[Floats, "n"]
    P: Array[Floats, "m"]
    gamma: Array[Floats, "m"]
    scaled: Array[Floats, 1, ROWS, ROWS]  # scratch of one contact
    answers: OneContact
    jacobian: Array[Floats, 2, "n", ROWS, ROWS]  # scratch of Newton's method
    vectors: Array[Floats, 4, "m"]
    matrix: Array[Floats, "m", "m"]
    order: Array[Ints, "m"]


@kernel
def fill_blocks(n_k, work, spatial):
    """Rows and blocks of the n_k closed contacts of a problem; blocks of zeros are left out."""
    n, place = spatial.mu.shape[0], 0
    for k in range(n_k):
        first, last, d = work.start[k], work.start[k + 1], work.kinds[k, 1]
        has_normal = work.kinds[k, 0] != GIVEN_FORCE
        spatial.row[k, 0] = first if has_normal else -1
        for a in range(1, ROWS):
            spatial.row[k, a] = last - d + a - 1 if a <= d else -1
        spatial.size[k] = work.G[first, first] if work.G[first, first] > 0.0 else 1.0
    for k in range(n):
        spatial.starts[k] = place
        for m in range(n_k if k < n_k else 0):
            if fill_block(k, m, place, work, spatial) or k == m:
                spatial.columns[place] = m
                place += 1
        if k >= n_k:
            for a in range(ROWS):
                for b in range(ROWS):
                    spatial.G[place, a, b] = 1.0 if a == b else 0.0
            spatial.columns[place] = k
            place += 1
    spatial.starts[n] = place


@kernel
def fill_block(k, m, place, work, spatial):
    """Block (k, m) of G, to a place; whether it has an entry."""
    has_entry = False
    for a in range(ROWS):
        for b in range(ROWS):
            row, column = spatial.row[k, a], spatial.row[m, b]
            value = work.G[row, column] if row >= 0 and column >= 0 else 0.0
            if k == m and a == b and row < 0:
                value = spatial.size[k]
            spatial.G[place, a, b] = value
            has_entry = has_entry or value != 0.0
    return has_entry


@kernel
def fill_free_velocities(n_k, work, spatial):
    """c of the blocks, with the offsets of friction; no impulses and mu = 0 where no contact is closed."""
    for k in range(spatial.mu.shape[0]):
        for a in range(ROWS):
            i = ROWS * k + a
            spatial.c[i] = 0.0
            if k < n_k and spatial.row[k, a] >= 0:
                spatial.c[i] = work.c[spatial.row[k, a]] + spatial.offset[i]
            elif k < n_k and a == 0:
                spatial.c[i] = -spatial.size[k] * work.normal_impulse[k]
        if k >= n_k:
            spatial.mu[k] = 0.0


@kernel
def begin_from(n_k, work, spatial):
    """The impulses of the step before as the first guess, and no offsets."""
    for k in range(spatial.mu.shape[0]):
        d = work.kinds[k, 1] if k < n_k else 0
        for a in range(ROWS):
            i = ROWS * k + a
            spatial.offset[i] = 0.0
            spatial.P[i] = work.previous_P[k, a] if k < n_k and a <= d else 0.0


@kernel
def take_impulses(n_k, work, spatial):
    """The impulses of the rows that the contact problem has."""
    for k in range(n_k):
        for a in range(ROWS):
            if spatial.row[k, a] >= 0:
                work.P[spatial.row[k, a]] = spatial.P[ROWS * k + a]
