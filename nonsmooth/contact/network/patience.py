"""How long a method is left out where it was in vain: some times as long each time, until it pays.

    in vain      spent <- spent + cost;    from its credit on   wait <- min(max(least, growth wait + 1), longest),
                                                                left <- wait,  spent <- 0
    it pays      wait <- 0,  left <- 0,  spent <- 0
    a problem    left <- max(0, left - 1)

Costs are factors. A method that is asked for in one problem is known by what became of it in those before. Where half
of the wait is kept when a method pays, 300 discs and 300 spheres miss 1e-8 in 15 % more of the steps.
"""

from __future__ import annotations

from typing import Annotated as Array

from nonsmooth.jit import kernel
from nonsmooth.jit.blocks import Block, Ints

# code: the methods: factors of an island of some bodies, and of many; sweeps beyond the budget; factors to bring to
# rounding what is at rest; interior points; their starts but the first
FACTORS, MANY_FACTORS, LONG_SWEEPS, AT_REST, INTERIOR, OTHER_STARTS = range(6)
# measured: while the last penetrations are taken back 150 boxes take three factors a step, in 50 steps, and 400 in 100
# to 200: of 13 heaps of 400 seven rest within 4 s with 200, twelve with 600, half a second sooner; 2000 help no more.
# The first one beyond them is in vain
CREDIT = (0, 0, 0, 601, 0, 0)
ABSENCE_GROWTH = (2, 4, 2, 1, 2, 2)  # chosen: factors of many bodies are dear; what comes to rest does so at last
# chosen: problems: two seconds at 2 ms; what comes to rest is solved by sweeps meanwhile. Sweeps and interior points
# cost less than what they leave
LONGEST_ABSENCE = (1023, 1023, 31, 1023, 31, 31)


class Patience(Block):
    """Of each method."""

    left: Array[Ints, "6"]  # problems for which it is left out
    wait: Array[Ints, "6"]  # how many these were the last time
    spent: Array[Ints, "6"]  # costs in vain since it was left out or paid


@kernel
def begin_problem(patience):
    """One problem less for which the methods are left out."""
    for method in range(patience.left.shape[0]):
        patience.left[method] = max(0, patience.left[method] - 1)


@kernel
def note_outcome(patience, method, has_paid, cost, least):
    """Leave a method out for a while where it was in vain, for ``least`` problems or more."""
    patience.left[method] = 0
    if has_paid:
        patience.wait[method] = patience.spent[method] = 0
        return
    patience.spent[method] += cost
    if patience.spent[method] >= CREDIT[method]:
        longer = max(least, ABSENCE_GROWTH[method] * patience.wait[method] + 1)
        patience.wait[method] = patience.left[method] = min(longer, LONGEST_ABSENCE[method])
        patience.spent[method] = 0


@kernel
def copy_patience(source, to):
    """Copy what one problem leaves to the next ones."""
    for method in range(to.left.shape[0]):
        to.left[method], to.wait[method] = source.left[method], source.wait[method]
        to.spent[method] = source.spent[method]
