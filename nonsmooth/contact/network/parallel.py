"""Islands solved by several threads, to the bits of one.

An island is solved by itself (``islands``). All that its solvers write is by its contacts, its bodies or its number,
but for what lies on a `Desk`, of which each thread has its own, with a part of the room for columns of factors. To the
velocity of a body that cannot move they add 0. So it does not matter which thread takes an island, nor when, nor where
its columns stand. Islands whose factors may be left out for a while, by what became of those of others, are all of the
first part, in their order.

Kernels hold no lock of the interpreter: threads of Python that call them run at once.
"""

from __future__ import annotations

import functools
import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor, wait

import numpy as np

from nonsmooth.contact.network.islands import Islands
from nonsmooth.contact.network.lagrangian import Desk
from nonsmooth.contact.network.problem import Network
from nonsmooth.contact.network.solve import EXACT_BODIES, Solver, solve_network
from nonsmooth.jit.blocks import new

PARTS_A_THREAD = 8  # chosen: of a problem, a thread: each costs some 5 us, and the last ones are waited for
AT_THE_BEGINNING, FROM_THE_FIRST = 0, 1  # defined: of ``going_on``: before the problem, and from its first island on
# measured: factors of the problem before, by dimension, some 2 ms, of which a hand-over of 0.1 ms is little
WORTH_SHARING = {2: 500, 3: 100}
NO_PART = -1  # defined: of ``part``: no island has this owner


class Desks:
    """The desks of some threads, that of a solver and others beside it, and the parts of a problem that are left.

    There are more parts than threads: whoever is done with one takes the next, and a thread that gets no processor
    keeps nobody waiting.
    """

    def __init__(self, threads: int) -> None:
        self.threads = threads
        self.others: list[Desk] = []
        self.sizes: dict[str, int] = {}
        self.is_shared = False

    def begin(self, network: Network, solver: Solver, factors: int) -> None:
        """Begin a problem after one that took so many factors, and share its islands where that is worth it."""
        sizes = {"m": len(network.i), "n_b": len(network.v), "d": network.b.shape[1], "n": network.v.shape[1]}
        if sizes != self.sizes:
            self.sizes, self.others = sizes, [new(Desk, **sizes) for _ in range(self.threads - 1)]
        for desk in self.others:
            desk.graph.top = 0
        own = solver.direct.desk
        own.part, own.going_on = NO_PART, AT_THE_BEGINNING
        solve_network(network.address, solver.address, own.address, network.b.shape[1])
        self.is_shared = factors >= WORTH_SHARING[network.b.shape[1]]
        self.left = [(part, FROM_THE_FIRST) for part in range(PARTS_A_THREAD * self.threads if self.is_shared else 1)]
        if self.is_shared:
            share_islands(network.islands, len(self.left))

    def solve(self, network: Network, solver: Solver) -> int:
        """Solve the islands; 0, or how many blocks of factors are wanted before it is called again."""
        own, fill = solver.direct.desk, len(solver.direct.factor.columns.row)
        desks = [own, *self.others] if self.is_shared else [own]
        edges = np.linspace(max(int(desk.graph.top) for desk in desks), fill, len(desks) + 1).astype(int).tolist()
        queue, unfinished, d = iter(self.left), [], network.b.shape[1]

        def work(desk: Desk) -> None:
            for part, going_on in queue:  # a list iterator hands each to one thread
                desk.part, desk.going_on = part, going_on
                if solve_network(network.address, solver.address, desk.address, d) > 0:
                    unfinished.append((part, int(desk.going_on)))
                    return

        for desk, begin, end in zip(desks, edges, edges[1:], strict=False):
            desk.graph.top, desk.graph.end = begin, end
        at_once([functools.partial(work, desk) for desk in desks])
        self.left = [*unfinished, *queue]
        own.part, own.going_on = 0, AT_THE_BEGINNING
        own.graph.top, own.graph.end = max(int(desk.graph.top) for desk in desks), fill
        return 2 * fill if self.left else 0


def share_islands(islands: Islands, parts: int) -> None:
    """Say which part each island belongs to, such that contacts are shared evenly where large ones leave it."""
    count = int(islands.count)
    contacts = np.diff(islands.contact_start[: count + 1])
    is_small = np.diff(islands.body_start[: count + 1]) <= EXACT_BODIES
    total, small = int(contacts.sum()), contacts[is_small]
    large = total - int(small.sum())
    rest = (total - max(large, total / parts)) / (parts - 1)  # of contacts, for each of the others
    middle = np.cumsum(small) - 0.5 * small - max(0.0, total / parts - large)
    islands.owner[:count] = 0
    islands.owner[np.flatnonzero(is_small)] = np.clip(np.floor(middle / max(rest, 1.0)) + 1, 0, parts - 1).astype(int)


def at_once(works: list[Callable[[], None]]) -> None:
    """Do the first of some works here and the others in threads; those that have not begun when it is done are left."""
    others = [_pool(len(works)).submit(work) for work in works[1:]]
    try:
        works[0]()
    finally:
        begun = [other for other in others if not other.cancel()]
        wait(begun)
    for other in begun:
        other.result()


@functools.cache
def _pool(works: int) -> ThreadPoolExecutor:
    """Threads for all works but one, kept to the end of the process."""
    return ThreadPoolExecutor(max(1, works - 1), thread_name_prefix="nonsmooth islands")


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_pool.cache_clear)  # a child has none of the threads
