"""The fronts of an island: which bodies are eliminated together, and which dense matrix takes what they leave.

Columns of the factors (``ordering``) form a tree: the parent of a column is the first body that it reaches. In
postorder a subtree is a range, and a front is a chain of it: columns that follow one another, each the parent of the
last, and reach the same bodies but for themselves. A front eliminates its *pivots*, and leaves a matrix of its *rows*,
which is added to that of its parent. Fronts are merged with their parents where that adds few zeros: dense matrices of
some ten bodies take a third of the time of single ones.

Source: Liu, The multifrontal method for sparse matrix solution: theory and practice, SIAM Rev. 34 (1992) 82-109.
"""

from __future__ import annotations

from typing import Annotated as Array

from nonsmooth.contact.network.al_newton import is_laid_out
from nonsmooth.contact.network.lagrangian import Direct
from nonsmooth.contact.network.problem import Network
from nonsmooth.jit import kernel
from nonsmooth.jit.blocks import Block, Ints, view

FEW_PIVOTS, SOME_PIVOTS = 2, 8  # chosen: bodies that a front eliminates
ZEROS_OF_FEW, ZEROS_OF_SOME, ZEROS_OF_MANY = 0.5, 0.25, 0.06  # chosen: share of zeros that a front of so many may have


class Tree(Block):
    """The fronts of one island; places are those of the postorder, from 0 on."""

    count: int  # of fronts
    size: int  # numbers that their factors take, for each square of the velocities of a body
    stack: int  # numbers that what they leave takes at most at once, the same
    largest: int  # bodies of the largest front
    place: Array[Ints, "n_b"]  # of a body; -1 where it is in no front
    body: Array[Ints, "n_b"]
    first: Array[Ints, "n_b + 1"]  # front s eliminates the places first[s] to first[s + 1]
    children: Array[Ints, "n_b"]  # of a front
    row_start: Array[Ints, "n_b + 1"]  # and leaves row[row_start[s] : row_start[s + 1]]
    row: Array[Ints, "fill"]
    contact_start: Array[Ints, "n_b + 1"]  # of a place
    contact: Array[Ints, "m"]  # whose body that is eliminated first is there, in the order of the island
    # meanwhile, by columns
    heaviest: Array[Ints, "n_b"]  # child of the longest column, which comes last
    head: Array[Ints, "n_b"]
    next: Array[Ints, "n_b"]
    number: Array[Ints, "n_b"]  # in postorder
    column: Array[Ints, "n_b"]  # the same the other way round
    # and by fronts
    zeros: Array[Ints, "n_b"]
    left: Array[Ints, "n_b"]  # whose rows are still on the stack
    parent: Array[Ints, "n_b"]


@kernel("boolean(int64, int64, int64, int64)")
def grow_tree(network_at, direct_at, tree_at, k):
    """Lay out the fronts of island k; False where there is no room for its columns."""
    network, direct, tree = view(network_at, Network), view(direct_at, Direct), view(tree_at, Tree)
    islands, columns = network.islands, direct.factor.columns
    if not is_laid_out(network, direct, direct.desk, k):
        return False
    begin, end = islands.body_start[k], islands.body_start[k + 1]
    link_children(tree, columns, begin, end)
    number_columns(tree, columns, begin, end)
    merge_columns(tree, columns, begin, end)
    for body in range(tree.place.shape[0]):
        tree.place[body] = -1
    for q in range(end - begin):
        tree.body[q] = columns.body[tree.column[q]]
        tree.place[tree.body[q]] = q
    write_rows(tree, columns, begin)
    hand_out_contacts(network, tree, k, end - begin)
    measure(tree)
    return True


@kernel
def parent_of(columns, place):
    """The column that a column reaches first; -1 of a root."""
    return columns.row[columns.first[place]] if columns.first[place] < columns.last[place] else -1


@kernel
def link_children(tree, columns, begin, end):
    """Lists of the children of each column, the heaviest one at their end."""
    for place in range(begin, end):
        tree.heaviest[place] = tree.head[place] = tree.next[place] = -1
    for place in range(begin, end):
        parent = parent_of(columns, place)
        if parent >= 0:
            other = tree.heaviest[parent]
            size = columns.last[place] - columns.first[place]
            if other < 0 or size >= columns.last[other] - columns.first[other]:
                tree.heaviest[parent] = place
    for place in range(begin, end):
        tree.head[place] = tree.heaviest[place]
    for place in range(end - 1, begin - 1, -1):
        parent = parent_of(columns, place)
        if parent >= 0 and tree.heaviest[parent] != place:
            tree.next[place] = tree.head[parent]
            tree.head[parent] = place


@kernel
def number_columns(tree, columns, begin, end):
    """The postorder."""
    count = 0
    for root in range(begin, end):
        if parent_of(columns, root) >= 0:
            continue
        place = root
        while place >= 0:
            while tree.head[place] >= 0:
                child = tree.head[place]
                tree.head[place] = tree.next[child]
                place = child
            tree.number[place] = count
            tree.column[count] = place
            count += 1
            place = parent_of(columns, place) if place != root else -1


@kernel
def merge_columns(tree, columns, begin, end):
    """Chains of columns become fronts, with few zeros; their rows are counted."""
    count = 0
    for q in range(end - begin):
        place = tree.column[q]
        first, rows, zeros = q, columns.last[place] - columns.first[place], 0
        while count > 0:
            before = tree.first[count - 1]
            parent = parent_of(columns, tree.column[first - 1])
            if parent < 0 or tree.number[parent] > q:
                break
            merged = tree.zeros[count - 1] + zeros + (first - before) * (q + 1 - first + rows - tree.left[count - 1])
            if not is_worth_merging(q + 1 - before, rows, merged):
                break
            first, zeros = before, merged
            count -= 1
        tree.first[count], tree.left[count], tree.zeros[count] = first, rows, zeros
        count += 1
    tree.count = count
    tree.first[count] = end - begin


@kernel
def is_worth_merging(pivots, rows, zeros):
    """Whether a front may have so many blocks of zeros below its diagonal."""
    share = ZEROS_OF_FEW if pivots <= FEW_PIVOTS else ZEROS_OF_SOME if pivots <= SOME_PIVOTS else ZEROS_OF_MANY
    return zeros <= share * (0.5 * pivots * (pivots + 1) + pivots * rows)


@kernel
def write_rows(tree, columns, begin):
    """The rows of each front: those of its last column, ascending; and its children."""
    top = 0
    for s in range(tree.count):
        tree.children[s] = 0
        for q in range(tree.first[s], tree.first[s + 1]):
            tree.heaviest[q] = s  # the front of a place
    for s in range(tree.count):
        tree.row_start[s] = top
        place = tree.column[tree.first[s + 1] - 1]
        for entry in range(columns.first[place], columns.last[place]):
            value, at = tree.number[columns.row[entry]], top
            while at > tree.row_start[s] and tree.row[at - 1] > value:
                tree.row[at] = tree.row[at - 1]
                at -= 1
            tree.row[at] = value
            top += 1
        if top > tree.row_start[s]:
            tree.children[tree.heaviest[tree.row[tree.row_start[s]]]] += 1
    tree.row_start[tree.count] = top


@kernel
def hand_out_contacts(network, tree, k, bodies):
    """The contacts of island k go to the place of that of their bodies which is eliminated first."""
    islands, start = network.islands, tree.contact_start
    for q in range(bodies + 1):
        start[q] = 0
    for at in range(islands.contact_start[k], islands.contact_start[k + 1]):
        start[earlier_place(network, tree, islands.contacts[at]) + 1] += 1
    for q in range(bodies):
        start[q + 1] += start[q]
    for at in range(islands.contact_start[k + 1] - 1, islands.contact_start[k] - 1, -1):
        q = earlier_place(network, tree, islands.contacts[at]) + 1
        start[q] -= 1
        tree.contact[start[q]] = at - islands.contact_start[k]
    for q in range(bodies):
        start[q] = start[q + 1]
    start[bodies] = islands.contact_start[k + 1] - islands.contact_start[k]


@kernel
def earlier_place(network, tree, c):
    """The place of the body of contact c that is eliminated first."""
    i, j = tree.place[network.i[c]], tree.place[network.j[c]]
    return max(i, j) if min(i, j) < 0 else min(i, j)


@kernel
def measure(tree):
    """How much room the fronts take."""
    words, top, stack, largest, depth = 0, 0, 0, 0, 0
    for s in range(tree.count):
        pivots, rows = tree.first[s + 1] - tree.first[s], tree.row_start[s + 1] - tree.row_start[s]
        words += pivots * (pivots + 2 * rows)
        largest = max(largest, pivots + rows)
        for _ in range(tree.children[s]):
            depth -= 1
            top -= tree.left[depth]
        tree.left[depth] = rows * rows
        top += rows * rows
        depth += 1
        stack = max(stack, top)
    tree.size, tree.stack, tree.largest = words, stack, largest
