"""A `GlobalContactProblem`, solved on the graph of its bodies where it has bodies, else with M eliminated."""

from __future__ import annotations

import math
import time
from typing import Any

from nonsmooth.checks.arrays import as_positive, as_tolerance, as_vector
from nonsmooth.contact.blocks.result import ContactResult, ContactStatus
from nonsmooth.contact.blocks.solve import solve_contact
from nonsmooth.contact.network.given import network_of
from nonsmooth.contact.network.problem import Network
from nonsmooth.contact.network.rounds import solve_in_rounds

LOCAL_CONTACTS = 1000  # chosen: G of more is handed to `solve_contact` by who wants to wait for minutes


def solve_global(problem: Any, tol: float, max_time: float | None) -> ContactResult:
    """`GlobalContactProblem.solve`."""
    tol = as_tolerance("tol", tol)
    until = math.inf
    if max_time is not None:
        until = time.monotonic() + as_positive("max_time", max_time, "s")
    network = None if has_constraints(problem) else network_of_problem(problem)
    if network is None:
        return solve_locally(problem, tol, max_time, None)
    found = solve_in_the_network(network, tol, until)
    left = until - time.monotonic()
    if found.success or found.status is ContactStatus.BUDGET_SPENT or network.n_c > LOCAL_CONTACTS or not left > 0.0:
        return found
    return better(solve_locally(problem, tol, left if math.isfinite(left) else None, found), found)


def has_constraints(problem: Any) -> bool:
    """Whether it has bilateral constraints."""
    return problem.G is not None and problem.G.shape[1] > 0


def network_of_problem(problem: Any) -> Network | None:
    """Its network, from which the impulses stored with it are left out; None where it is not one of bodies."""
    f, w, mu = (as_vector(name, getattr(problem, name)) for name in ("f", "w", "mu"))
    return network_of(problem.M, problem.H, f, w, mu)


def solve_in_the_network(network: Network, tol: float, until: float) -> ContactResult:
    """What rounds of interior points, sweeps and factors lead to."""
    rounds = solve_in_rounds(network, tol, until)
    end = rounds.end()
    if end.error <= tol:
        status = ContactStatus.SOLVED
    else:
        status = ContactStatus.BUDGET_SPENT if time.monotonic() >= until else ContactStatus.STALLED
    done = f"error {end.error:.1e} after {end.sweeps} sweeps and {end.factors} factors of {len(network.v) - 1} bodies"
    message = f"{status.name.lower().replace('_', ' ')}; network: {done}"
    iterations = end.sweeps + end.factors
    return ContactResult(end.P, end.gamma, status, end.error, end.error_rho_1, iterations, "network", message)


def solve_locally(problem: Any, tol: float, max_time: float | None,
                  found: ContactResult | None) -> ContactResult:  # fmt: skip
    """With M eliminated, from what was found."""
    local = problem.local()
    guess = None if found is None else found.P
    return solve_contact(local.G, local.c, local.mu, local.dim, tol=tol, guess=guess, max_time=max_time)


def better(last: ContactResult, first: ContactResult) -> ContactResult:
    """The result of the lesser error, with what was done for both."""
    result = last if last.error <= first.error else first
    message = f"{last.message}; before, {first.message}"
    status = last.status if last.success else max(last.status, first.status)
    return ContactResult(
        result.P, result.gamma, status, result.error, result.error_rho_1, first.iterations + last.iterations,
        result.solver, message,
    )  # fmt: skip
