"""Pairs of shapes whose boxes overlap: a grid for every size, in a hash table.

A shape of width w (the longest side of its box) is entered by the centre of its box in the grid of level l,

    cell_l = w_max 2^-l,    w <= cell_l < 2 w,

so that two shapes overlap only where their cells on the coarser one of their levels are neighbours. A shape asks the
3^d cells about its own on every coarser level that is in use, and half of them on its own. A shape of a body that is
still asks only where one that is not still is coarser; those look for still ones in the other half of the cells too.
Cells share a table of at least 2 n buckets; entries are sorted by bucket, and a row of cells along x is a row of
buckets. What is still and outside the box of all that is not is left out. Pairs come out in the order of (i, j) by two
counting sorts, whatever the order in the grid. All is linear in shapes + pairs.

Source: Ericson, *Real-Time Collision Detection*, section 7.2.2 (hierarchical hash grids); Eitz and Lixu, "Hierarchical
spatial hashing for real-time collision detection", SMI 2007.
"""

from __future__ import annotations

import math
from typing import Annotated as Array

from nonsmooth.jit import kernel
from nonsmooth.jit.blocks import Block, Floats, Ints
from nonsmooth.scenes.detection import NOT_FINITE

NO_BOX = -1  # code: the level of a shape that is unbounded
OUT_OF_REACH = -2  # code: the level of a shape that is still and outside the box of all that are not
GRID_LEVELS = 48  # chosen: sizes of one scene differ by up to 2^48; what is smaller still stands in the finest grid
CELL_WRAP = 2**28 - 1  # chosen: cells of a row and rows are told apart modulo this + 1, since a row's code has 62 bits
FARTHEST_CELL = 2.0**52  # derived: cells from the origin beyond which a place is not known to a cell
# derived: 1/g, 1/g^2, 1/g^3 with g^4 = g + 1, in units of 2^-34: multiples of them lie evenly modulo 1. Source:
# Roberts, "The unreasonable effectiveness of quasirandom sequences", 2018
ROW_STRIDES = (14073276619, 11528441379, 9443782300)  # of y, z and level
ROW_PART = 2**34 - 1  # derived: what is modulo 1 in these units


class Grid(Block, n_t="1 << (2 * n_s + 2).bit_length()"):
    """Boxes of the shapes, and the pairs that overlap; n_p is the room for these."""

    lo: Array[Floats, "n_s", "d"]  # [m] the box: of the shape, the margin and what it may move in a step
    hi: Array[Floats, "n_s", "d"]
    normal: Array[Floats, "n_s", "d"]  # of the border of an unbounded shape
    border: Array[Floats, "n_s"]  # [m] n . p of what is on its border, as much wider as the boxes are
    approach: Array[Floats, "n_s"]  # [m] the farthest that a point of its core moves in a step
    level: Array[Ints, "n_s"]  # or NO_BOX, OUT_OF_REACH
    row: Array[Ints, "n_s"]  # level and cells across x, as one number
    bucket: Array[Ints, "n_s"]
    start: Array[Ints, "n_t + 1"]
    order: Array[Ints, "n_s"]  # bounded shapes by bucket; their rows and boxes beside each other are read in one go
    row_at: Array[Ints, "n_s"]
    lo_at: Array[Floats, "n_s", "d"]
    hi_at: Array[Floats, "n_s", "d"]
    near: Array[Ints, "n_s + 1"]  # those whose boxes overlap that of one shape
    population: Array[Ints, GRID_LEVELS]  # of the levels
    active: Array[Ints, GRID_LEVELS]  # of these, shapes that are not still
    reach_lo: Array[Floats, "d"]  # [m] the box of all that is not still
    reach_hi: Array[Floats, "d"]
    n_still: int  # bounded shapes that are
    widest: float  # [m] the longest side of a box
    n_pairs: int  # found, which may be more than there is room for
    i: Array[Ints, "n_p"]  # i < j, in this order
    j: Array[Ints, "n_p"]
    i_at: Array[Ints, "n_p"]  # while they are sorted
    j_at: Array[Ints, "n_p"]
    places: Array[Ints, "n_s + 1"]


@kernel
def find_pairs(shapes, motion, grid):
    """List the pairs whose boxes overlap; returns how many, or NOT_FINITE."""
    n = enter(shapes, motion, grid)
    if n < 0:
        return NOT_FINITE
    grid.n_pairs = 0
    for p in range(n):
        neighbours(shapes, motion, grid, p)
    for s in range(grid.level.shape[0]):
        if grid.level[s] == NO_BOX:
            against_all(shapes, motion, grid, s)
    if grid.n_pairs <= grid.i.shape[0]:
        sort_pairs(grid)
    return grid.n_pairs


@kernel
def enter(shapes, motion, grid):
    """Sort the bounded shapes by the bucket of their cell; returns how many, or NOT_FINITE."""
    n_s, depth = grid.lo.shape
    start, population, widest = grid.start, grid.population, 0.0
    leave_out_far(shapes, motion, grid)
    for s in range(n_s):
        if grid.level[s] >= 0:
            widest = max(widest, width_of(grid, s))
    grid.widest = widest
    for b in range(start.shape[0]):
        start[b] = 0
    for k in range(GRID_LEVELS):
        population[k] = grid.active[k] = 0
    n = n_still = 0
    for s in range(n_s):
        if grid.level[s] < 0:
            continue
        level = level_of(width_of(grid, s), widest)
        cell = cell_of(level, widest)
        for a in range(depth):
            if not abs(grid.lo[s, a] + grid.hi[s, a]) < FARTHEST_CELL * cell:
                return NOT_FINITE
        cx, cy, cz = cells_of(grid, s, cell)
        b = bucket_of(grid, level, cx, cy, cz)
        grid.level[s], grid.row[s], grid.bucket[s] = level, row_code(level, cy, cz), b
        population[level] += 1
        start[b] += 1
        n += 1
        if motion.still[shapes.body[s]] == 1:
            n_still += 1
        else:
            grid.active[level] += 1
    grid.n_still = n_still
    fill_buckets(grid)
    return n


@kernel
def leave_out_far(shapes, motion, grid):
    """Mark the shapes that are still and outside the box of all that are not."""
    n_s, depth = grid.lo.shape
    lo, hi = grid.reach_lo, grid.reach_hi
    for a in range(depth):
        lo[a], hi[a] = math.inf, -math.inf
    n_still = 0
    for s in range(n_s):
        if motion.still[shapes.body[s]] == 1:
            n_still += 1
        elif grid.level[s] == NO_BOX:
            return
        else:
            for a in range(depth):
                lo[a], hi[a] = min(lo[a], grid.lo[s, a]), max(hi[a], grid.hi[s, a])
    for s in range(n_s if n_still > 0 else 0):
        if motion.still[shapes.body[s]] == 1 and grid.level[s] != NO_BOX:
            for a in range(depth):
                if grid.lo[s, a] > hi[a] or grid.hi[s, a] < lo[a]:
                    grid.level[s] = OUT_OF_REACH


@kernel
def width_of(grid, s):
    """The longest side of a box."""
    width = grid.hi[s, 0] - grid.lo[s, 0]
    for a in range(1, grid.lo.shape[1]):
        width = max(width, grid.hi[s, a] - grid.lo[s, a])
    return width


@kernel
def level_of(width, widest):
    """The finest level whose cells are no narrower."""
    if width * 2.0 ** (GRID_LEVELS - 1) <= widest:
        return GRID_LEVELS - 1
    return math.frexp(widest / width)[1] - 1


@kernel
def cell_of(level, widest):
    """The width of its cells; 1 where nothing has a width."""
    return math.ldexp(widest, -level) if widest > 0.0 else 1.0


@kernel
def cells_of(grid, s, cell):
    """The cell (x, y, z) in which the centre of a box is; z = 0 in the plane."""
    cx = int(math.floor(0.5 * (grid.lo[s, 0] + grid.hi[s, 0]) / cell))
    cy = int(math.floor(0.5 * (grid.lo[s, 1] + grid.hi[s, 1]) / cell))
    cz = 0
    if grid.lo.shape[1] == 3:
        cz = int(math.floor(0.5 * (grid.lo[s, 2] + grid.hi[s, 2]) / cell))
    return cx, cy, cz


@kernel
def row_code(level, cy, cz):
    """One number of a row of cells along x."""
    return (level << 56) | ((cy & CELL_WRAP) << 28) | (cz & CELL_WRAP)


@kernel
def bucket_of(grid, level, cx, cy, cz):
    """The bucket of a cell; neighbours along x are neighbours in the table."""
    size = grid.start.shape[0] - 1
    part = (ROW_STRIDES[0] * (cy & CELL_WRAP) + ROW_STRIDES[1] * (cz & CELL_WRAP) + ROW_STRIDES[2] * level) & ROW_PART
    return (cx + (part * size >> 34)) & (size - 1)


@kernel
def fill_buckets(grid):
    """From the population of each bucket to its first place, start[b], and the shapes in it."""
    start, order, bucket, end = grid.start, grid.order, grid.bucket, 0
    for b in range(start.shape[0]):
        end += start[b]
        start[b] = end
    for s in range(bucket.shape[0] - 1, -1, -1):
        if grid.level[s] >= 0:
            start[bucket[s]] -= 1
            p = start[bucket[s]]
            order[p], grid.row_at[p] = s, grid.row[s]
            for a in range(grid.lo.shape[1]):
                grid.lo_at[p, a], grid.hi_at[p, a] = grid.lo[s, a], grid.hi[s, a]


@kernel
def neighbours(shapes, motion, grid, p):
    """The pairs of shape order[p] with those behind it on its own level, and with all on coarser ones; of a shape that
    is still, with those alone that are not."""
    s, n = grid.order[p], 0
    own, top = grid.level[s], 1 if grid.lo.shape[1] == 3 else 0
    is_still = motion.still[shapes.body[s]] == 1
    for level in range(own if is_still else own + 1):
        if grid.population[level] == 0 or (is_still and grid.active[level] == 0):
            continue
        cx, cy, cz = cells_of(grid, s, cell_of(level, grid.widest))
        if level == own:
            b = bucket_of(grid, level, cx, cy, cz)
            row = row_code(level, cy, cz)
            n = compare(grid, p, row, p + 1, grid.start[b + 1], n)
            b = bucket_of(grid, level, cx + 1, cy, cz)
            n = compare(grid, p, row, grid.start[b], grid.start[b + 1], n)
        for z in range(0 if level == own else -top, top + 1):
            for y in range(1 if level == own and z == 0 else -1, 2):
                n = compare_row(grid, p, level, cx, cy + y, cz + z, n)
    for k in range(n):
        add_pair(shapes, motion, grid, s, grid.near[k])
    if grid.n_still > 0 and not is_still:
        still_neighbours(shapes, motion, grid, p)


@kernel
def still_neighbours(shapes, motion, grid, p):
    """The pairs of shape order[p] with those before it on its own level that are still: these did not ask."""
    s, n = grid.order[p], 0
    level, top = grid.level[s], 1 if grid.lo.shape[1] == 3 else 0
    cx, cy, cz = cells_of(grid, s, cell_of(level, grid.widest))
    row = row_code(level, cy, cz)
    n = compare(grid, p, row, grid.start[bucket_of(grid, level, cx, cy, cz)], p, n)
    b = bucket_of(grid, level, cx - 1, cy, cz)
    n = compare(grid, p, row, grid.start[b], grid.start[b + 1], n)
    for z in range(-top, 1):
        for y in range(-1, 0 if z == 0 else 2):
            n = compare_row(grid, p, level, cx, cy + y, cz + z, n)
    for k in range(n):
        if motion.still[shapes.body[grid.near[k]]] == 1:
            add_pair(shapes, motion, grid, s, grid.near[k])


@kernel
def compare_row(grid, p, level, cx, cy, cz, n):
    """``compare`` with those in three cells of a row, which are in a row in the table but at its end."""
    row, b = row_code(level, cy, cz), bucket_of(grid, level, cx, cy, cz)
    if 0 < b < grid.start.shape[0] - 2:
        return compare(grid, p, row, grid.start[b - 1], grid.start[b + 2], n)
    for x in range(-1, 2):
        b = bucket_of(grid, level, cx + x, cy, cz)
        n = compare(grid, p, row, grid.start[b], grid.start[b + 1], n)
    return n


@kernel
def compare(grid, p, row, begin, end, n):
    """List those of order[begin], ..., order[end - 1] that are of the row and whose boxes overlap that of order[p],
    behind the first n in ``near``; the new n. No branch is taken: most would be guessed wrong."""
    lo, hi, row_at = grid.lo_at, grid.hi_at, grid.row_at
    for t in range(begin, end):
        meets = (row_at[t] == row) & (lo[p, 0] <= hi[t, 0]) & (lo[t, 0] <= hi[p, 0])
        meets = meets & (lo[p, 1] <= hi[t, 1]) & (lo[t, 1] <= hi[p, 1])
        if lo.shape[1] == 3:
            meets = meets & (lo[p, 2] <= hi[t, 2]) & (lo[t, 2] <= hi[p, 2])
        grid.near[n] = grid.order[t]
        n += 1 if meets else 0
    return n


@kernel
def against_all(shapes, motion, grid, s):
    """The pairs of an unbounded shape with the bounded ones whose boxes reach over its border."""
    is_still = motion.still[shapes.body[s]] == 1
    for t in range(grid.level.shape[0]):
        if grid.level[t] < 0 or (is_still and motion.still[shapes.body[t]] == 1):
            continue
        if lowest(grid, s, t) <= grid.border[s]:
            add_pair(shapes, motion, grid, s, t)


@kernel
def lowest(grid, s, t):
    """The least n . p of the points of box t."""
    total = 0.0
    for a in range(grid.lo.shape[1]):
        total += min(grid.normal[s, a] * grid.lo[t, a], grid.normal[s, a] * grid.hi[t, a])
    return total


@kernel
def add_pair(shapes, motion, grid, s, t):
    """Write a pair down, unless its bodies are one, or cannot move, or are still, or do not collide."""
    a, b = shapes.body[s], shapes.body[t]
    if a == b or motion.moves[a] + motion.moves[b] == 0 or motion.still[a] + motion.still[b] == 2:
        return
    if is_apart(shapes.apart, a, b):
        return
    n = grid.n_pairs
    if n < grid.i.shape[0]:
        grid.i[n], grid.j[n] = min(s, t), max(s, t)
    grid.n_pairs = n + 1


@kernel
def is_apart(apart, a, b):
    """Whether the codes of pairs that do not collide, ascending, have this one; by bisection."""
    code, low, high = min(a, b) << 32 | max(a, b), 0, apart.shape[0]
    while low < high:
        middle = (low + high) // 2
        if apart[middle] < code:
            low = middle + 1
        else:
            high = middle
    return low < apart.shape[0] and apart[low] == code


@kernel
def sort_pairs(grid):
    """Put the pairs in the order of (i, j): by j, and then by i with those of one i left in their order."""
    counting_sort(grid.n_pairs, grid.j, grid.i, grid.places, grid.j_at, grid.i_at)
    counting_sort(grid.n_pairs, grid.i_at, grid.j_at, grid.places, grid.i, grid.j)


@kernel
def counting_sort(n, values, others, places, sorted_values, sorted_others):
    """Sort n values, each with another number beside it; those that are equal stay in their order."""
    for v in range(places.shape[0]):
        places[v] = 0
    for k in range(n):
        places[values[k] + 1] += 1
    for v in range(1, places.shape[0]):
        places[v] += places[v - 1]
    for k in range(n):
        place = places[values[k]]
        sorted_values[place], sorted_others[place] = values[k], others[k]
        places[values[k]] = place + 1
