"""A network solved to an error in velocities, in rounds of sweeps and factors, whatever its size.

    some sweeps, then in round k:
        interior points from the k-th distance (``from_inside``), of three
        2^k SWEEPS_OF_ROUND_0 conjugate sweeps of each island  ->  factors (``al_newton``) from where they end

Each part begins with the best impulses so far. Sweeps find the modes of most contacts, factors the digits; where
factors begin too far away they lead nowhere, and more sweeps come before the next ones. The error is that of
``solve_contact``, measured anew from the impulses after every part of a round.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from nonsmooth.contact.blocks.natural_map import natural_map_entry
from nonsmooth.contact.network.al_newton import NO_ROOM, begin_direct, solve_by_al_newton
from nonsmooth.contact.network.from_inside import STARTS, Start, from_inside
from nonsmooth.contact.network.problem import Network, judge_network, prepare_network
from nonsmooth.contact.network.solve import Solver, solve_network
from nonsmooth.jit.blocks import new

# measured: a wall of 9500 contacts is solved by the first factors, a packing of 525 spherical ones after seven rounds
SWEEPS_OF_ROUND_0 = 1000
WORK_OF_ROUND = 20_000_000  # measured: contacts times sweeps of a round: a second
LEAST_SWEEPS = 100  # chosen: of a round, however many contacts there are
MOST_ROUNDS = 20  # chosen
ROUND_FACTORS = 200  # measured: of an island in a round; a wall of 9500 contacts takes 170
FACTORED_RESIDUAL = 1e-12  # chosen: what factors aim at: one more of them is cheap where the modes are found
INSIDE_RESIDUAL = 1e-10  # chosen: what interior points aim at
FIRST_FILL = 40  # measured: blocks of factors a body: 500 spheres take 33, 3400 discs 17
MOST_FILL = {2: 400_000, 3: 40_000}  # measured: blocks of factors; one of as many takes some 0.2 s
ROUND_GAIN = 0.9  # chosen: a round that leaves more of the error is one in vain
ROUNDS_IN_VAIN = 2  # measured: after so many in a row the next ones gain nothing either


class RoundsEnd(NamedTuple):
    """The best impulses (n,), their velocities (n,), both errors, and what was done."""

    P: np.ndarray
    gamma: np.ndarray
    error: float
    error_rho_1: float
    sweeps: int
    factors: int


class Rounds:
    """A prepared network, the memory of its solvers, and the best impulses so far."""

    def __init__(self, network: Network) -> None:
        self.network, self.d, self.sweeps, self.factors = network, network.b.shape[1], 0, 0
        self.solver = self._solver(FIRST_FILL * len(network.v))
        self.may_factorise = True
        is_movable = network.rho > 0.0
        self.rho = np.where(is_movable, 1.0 / np.where(is_movable, network.rho, 1.0), 1.0)  # mean diagonal of G_ii
        self.weight = np.ones(len(network.mu))
        start, network.P[:] = network.P.copy(), 0.0
        self.measured_error(self.rho)
        norm = float(np.linalg.norm(network.gamma))
        self.weight /= norm if norm > 0.0 else 1.0
        self.best, self.least, network.P[:] = start, math.inf, start
        self.keep_better()

    def is_over(self, tol: float, until: float) -> bool:
        """Whether the best impulses are within tol, or the time is up."""
        return self.least <= tol or time.monotonic() >= until

    def measured_error(self, rho: np.ndarray) -> float:
        """The error of the impulses, relative to the norm of c, from their own velocities."""
        network = self.network
        judge_network(network.address, self.d)
        P, gamma = network.P.ravel(), network.gamma.ravel()
        error = natural_map_entry(network.mu, rho, self.weight, P, gamma, self.d)
        return error if math.isfinite(error) else math.inf

    def keep_better(self) -> None:
        """Remember the impulses where they are better, and go back to the best ones where not."""
        error = self.measured_error(self.rho)
        if error < self.least:
            self.best, self.least = self.network.P.copy(), error
        self.network.P[:] = self.best

    def sweep(self, most: int, tol: float) -> None:
        """Sweep each island ``most`` times, or until its residual is within tol; go on from the best impulses."""
        network, solver, islands = self.network, self.solver, self.network.islands
        prepare_network(network.address, self.d)
        solver.tol, solver.most_sweeps, solver.most_factors = tol, most, 0
        solve_network(network.address, solver.address, solver.direct.desk.address, self.d)
        self.sweeps += int(islands.sweeps[: islands.count].sum())
        self.keep_better()

    def factorise(self) -> None:
        """The direct rung for each island."""

        def solve(k: int) -> bool:
            direct = self.solver.direct.address
            end = solve_by_al_newton(self.network.address, direct, k, FACTORED_RESIDUAL, ROUND_FACTORS, self.d)
            return end != NO_ROOM

        self._each_island(solve)

    def go_inside(self, start: Start) -> None:
        """Interior points, from a distance and with a shift, for each island that the best impulses do not solve."""
        network = self.network
        judge_network(network.address, self.d)

        def solve(k: int) -> bool:
            if network.islands.residual[k] <= INSIDE_RESIDUAL:
                return True
            return from_inside(network, self.solver.direct, k, INSIDE_RESIDUAL, FACTORED_RESIDUAL, (start,))

        self._each_island(solve)

    def _each_island(self, solve: Callable[[int], bool]) -> None:
        """Let a method with factors solve each island, in more room if it is wanted and not too much."""
        network, before = self.network, self.solver.direct.desk.factors
        begin_direct(network.address, self.solver.direct.address)
        for k in range(network.islands.count):
            while not solve(k):
                wanted = self.solver.direct.desk.graph.wanted
                if wanted > MOST_FILL[self.d]:
                    self.may_factorise = False
                    return
                self.factors += int(self.solver.direct.desk.factors - before)
                self.solver, before = self._solver(wanted), 0
                begin_direct(network.address, self.solver.direct.address)
        self.factors += int(self.solver.direct.desk.factors - before)
        self.keep_better()

    def _solver(self, fill: int) -> Solver:
        d, n = self.d, self.network.v.shape[1]
        return new(Solver, d=d, n=n, m=len(self.network.i), n_b=len(self.network.v), fill=fill)

    def end(self) -> RoundsEnd:
        """The best impulses, judged once more."""
        error_rho_1 = self.measured_error(np.ones(len(self.rho)))
        error = self.measured_error(self.rho)
        P, gamma = self.network.P.ravel().copy(), self.network.gamma.ravel().copy()
        return RoundsEnd(P, gamma, error, error_rho_1, self.sweeps, self.factors)


def solve_in_rounds(network: Network, tol: float, until: float = math.inf) -> Rounds:
    """Solve a prepared network until its error is within tol, nothing is gained, or ``until`` (`time.monotonic`) [s].

    The clock is looked at between the parts of a round.
    """
    rounds, in_vain = Rounds(network), 0
    largest = max(LEAST_SWEEPS, WORK_OF_ROUND // max(network.n_c, 1))
    if not rounds.is_over(tol, until):
        rounds.sweep(LEAST_SWEEPS, tol)
    for count in range(MOST_ROUNDS):
        before = rounds.least
        if count < len(STARTS) and rounds.may_factorise and not rounds.is_over(tol, until):
            rounds.go_inside(STARTS[count])
        if not rounds.is_over(tol, until):
            rounds.sweep(min(SWEEPS_OF_ROUND_0 << count, largest), tol)
        if rounds.may_factorise and not rounds.is_over(tol, until):
            rounds.factorise()
        in_vain = 0 if rounds.least < ROUND_GAIN * before else in_vain + 1
        if rounds.is_over(tol, until) or in_vain == ROUNDS_IN_VAIN:
            break
    return rounds
