"""A case of ``python -m benchmarks stress``, and the figures of one run of it: what was measured, and what it may be.

    momentum   |M (u_1 - u_0) - h t - W^T sum P| over the same with the sizes of all terms, norms in the metric M^-1
    ledger     |T_k - T_0 - works| over largest T + sum of the sizes of the works + work of h in a free fall of time t

with the kinetic energy T of each record k and the duration t. The bounds that hold for every case are derived in
`bounds`.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from nonsmooth.contact.planar.problem import ACCEPTED_RESIDUAL
from nonsmooth.errors import NonsmoothError
from nonsmooth.integrators.adaptive.options import Adaptive
from nonsmooth.integrators.event_driven.options import EventDriven
from nonsmooth.integrators.moreau_jean.options import MoreauJean
from nonsmooth.integrators.moreau_jean.step import VELOCITY_ROUNDINGS
from nonsmooth.integrators.penalty.options import Penalty
from nonsmooth.mechanics.model_system import as_system
from nonsmooth.mechanics.system import BILATERAL, FORCE, GAP_RATE, MASS, NORMAL, TANGENT, UNILATERAL, System, evaluate
from nonsmooth.results.solution import Solution
from nonsmooth.runs.simulate import simulate_whole

EPS = float(np.finfo(float).eps)
LONGEST = 300.0  # s of wall time of one run: no run takes a tenth of it, also where a machine is busy
UNKNOWN = (math.nan, math.nan, math.nan, math.nan, math.nan)
WORKS = ("force", "friction", "normal", "surface", "projection")


class Method(NamedTuple):
    """An integrator, and how far the case's invariant may be off with it."""

    integrator: Any
    bound: float


class Case(NamedTuple):
    """A motion, its invariant, and the integrators that must keep it."""

    name: str
    system: Any
    state: tuple[Any, Any]  # q0, u0
    t_end: float
    invariant: Callable[[Solution], float]  # the relative error of what is known of the motion
    methods: list[Method]
    every: int = 1
    selection: str = "compliant-limit"


class Outcome(NamedTuple):
    """One run: each figure with its bound (nan: the case has no such figure)."""

    case: str
    method: str
    steps: int
    penetration: float  # [m]
    residual: float
    ledger: float
    momentum: float
    error: float  # of the case's invariant
    bounds: tuple[float, float, float, float, float]  # of these five, in this order
    failure: str  # why the run ended early; empty if it reached its end

    @property
    def figures(self) -> tuple[float, float, float, float, float]:
        return self.penetration, self.residual, self.ledger, self.momentum, self.error

    @property
    def holds(self) -> bool:
        """Whether the end was reached and no figure is beyond its bound; nan passes only where it is the bound."""
        pairs = zip(self.figures, self.bounds, strict=True)
        return not self.failure and all(math.isnan(bound) or figure <= bound for figure, bound in pairs)


def run(case: Case, method: Method) -> Outcome:
    """Run a case by one method."""
    system, name = as_system(case.system), name_of(method.integrator)
    try:
        solution = simulate_whole(
            system, (0.0, case.t_end), *case.state, integrator=method.integrator, selection=case.selection,
            on_failure="return", max_wall_time=LONGEST, every=1 if method.integrator.chooses_steps else case.every,
        )  # fmt: skip
    except NonsmoothError as refusal:
        return Outcome(case.name, name, 0, *UNKNOWN, UNKNOWN, str(refusal).split(";")[0])
    if not len(solution.t):
        return Outcome(case.name, name, 0, *UNKNOWN, UNKNOWN, f"{solution.status.name} at the start")
    figures = (
        penetration(solution),
        math.nan if method.integrator.chooses_steps else solution.stats.worst_residual,
        ledger_error(system, solution),
        momentum_error(system, solution),
        case.invariant(solution) if solution.success else math.nan,
    )
    failure = "" if solution.success else f"{solution.status.name} at {solution.t[-1]:.3g} s"
    limits = bounds(system, method, solution)
    if math.isnan(figures[3]):
        limits = (*limits[:3], math.nan, limits[4])
    return Outcome(case.name, name, solution.stats.steps, *figures, limits, failure)


def name_of(integrator: Any) -> str:
    """An integrator as the tables name it."""
    if isinstance(integrator, MoreauJean):
        options = (f", theta = {integrator.theta:g}" if integrator.theta != 0.5 else "") + (
            ", projected" if integrator.projection else ""
        )
        return f"Moreau–Jean {integrator.dt:.0e}{options}"
    if isinstance(integrator, Penalty):
        return f"Penalty k = {integrator.stiffness:.0e}"
    return f"{type(integrator).__name__} {integrator.rtol:.0e}"


def bounds(system: System, method: Method, solution: Solution) -> tuple[float, float, float, float, float]:
    """What the figures may be, whatever the case.

    * Penetration. A time step looks at the gaps at its mid-point, one step after it looked last, and what rounding and
      the accepted residual leave of closed velocities adds up over the run. Events that are located, or that steps are
      refined to, are early or late by the tolerance. A compliant contact is as deep as its spring stops the fastest
      motion and carries ten times the greatest load at rest (contacts may carry what stands on others).
    * Residual: what the solvers accept.
    * Ledger and momentum. Each step sums n + r terms for each coordinate, each rounded, and what cancels to ROUNDING
      is set to zero; an adaptive step is off by its tolerance.
    """
    integrator, steps = method.integrator, max(1, solution.stats.steps)
    terms = system.n_u + system.n_c * (1 + system.d)
    speed, span = fastest(system, solution), float(solution.t[-1] - solution.t[0])
    lengths = np.abs(solution.q).max() + np.abs(solution.g_N[0][solution.g_N[0] < 1e5]).max(initial=0.0)
    if isinstance(integrator, MoreauJean):
        sum_of = steps * (terms * EPS + VELOCITY_ROUNDINGS)
        free = np.abs(free_acceleration(system, solution)).max(initial=0.0)
        closed_drift = ACCEPTED_RESIDUAL * (speed + free * integrator.dt) * span
        depth = integrator.dt * speed + closed_drift + EPS * steps * lengths
        return depth, ACCEPTED_RESIDUAL, sum_of, sum_of, method.bound
    if isinstance(integrator, EventDriven | Adaptive):
        sum_of = steps * integrator.rtol
        return 10 * (integrator.atol + integrator.rtol * lengths), math.nan, sum_of, sum_of, method.bound
    sum_of = steps * integrator.rtol
    stiffness = stiffest_response(system, solution)
    depth = speed * math.sqrt(stiffness / integrator.stiffness) + 10 * load(system, solution) / integrator.stiffness
    return depth, math.nan, sum_of, sum_of, method.bound


def fastest(system: System, solution: Solution) -> float:
    """The largest normal velocity of a contact, its floor included, in up to a thousand records [m/s]."""
    rows = np.abs(evaluate(system, NORMAL, 0.0, solution.q[0], solution.u[0]))
    floors = [
        np.abs(evaluate(system, GAP_RATE, solution.t[k], solution.q[k], solution.u[k])).max(initial=0.0)
        for k in range(0, len(solution.t), max(1, len(solution.t) // 1000))
    ]
    return float((rows @ np.abs(solution.u).max(axis=0)).max(initial=0.0)) + max(floors)


def free_acceleration(system: System, solution: Solution) -> np.ndarray:
    """M^-1 h at the start."""
    M = evaluate(system, MASS, 0.0, solution.q[0], solution.u[0])
    return np.linalg.solve(M, evaluate(system, FORCE, 0.0, solution.q[0], solution.u[0]))


def stiffest_response(system: System, solution: Solution) -> float:
    """The largest effective mass 1/G_NN of a contact [kg], times the number of contacts that may share a motion."""
    q, u = solution.q[0], solution.u[0]
    M, W = evaluate(system, MASS, 0.0, q, u), evaluate(system, NORMAL, 0.0, q, u)
    taken = system.kinds[:, 0] == UNILATERAL
    return float(np.abs(M).sum()) * max(1, int(taken.sum())) if W[taken].size else 0.0


def load(system: System, solution: Solution) -> float:
    """The sum of the sizes of the smooth forces [N]."""
    return float(np.abs(evaluate(system, FORCE, 0.0, solution.q[0], solution.u[0])).sum())


def penetration(solution: Solution) -> float:
    """The deepest gap, of the records and of the mid-points of steps [m]."""
    assert solution.system is not None
    unilateral = solution.system.kinds[:, 0] == UNILATERAL
    bilateral = solution.system.kinds[:, 0] == BILATERAL
    deepest = max(0.0, float(-solution.g_N[:, unilateral].min(initial=0.0)), solution.stats.worst_penetration)
    return max(deepest, float(np.abs(solution.g_N[:, bilateral]).max(initial=0.0)))


def ledger_error(system: System, solution: Solution) -> float:
    """How far the kinetic energy is from the works that were booked, at the worst record."""
    ledger = solution.ledger
    works = np.column_stack([ledger[name] for name in WORKS[:4]])
    error = np.abs(ledger["kinetic"] - ledger["kinetic"][0] - works.sum(axis=1)).max()
    span = solution.t[-1] - solution.t[0]
    fall = 0.5 * load(system, solution) * np.abs(free_acceleration(system, solution)).max(initial=0.0) * span**2
    scale = ledger["kinetic"].max() + np.abs(works).sum(axis=1).max() + fall
    return float(error / scale) if scale > 0 else 0.0


def momentum_error(system: System, solution: Solution) -> float:
    """How far the momentum is from the impulses of all forces; nan unless M, h and the rows are constant."""
    varies = any(system.reads(which, name) for which in (MASS, NORMAL, TANGENT, FORCE) for name in ("t", "q"))
    if varies or system.reads(FORCE, "u"):
        return math.nan
    q, u_0, u_1 = solution.q[0], solution.u[0], solution.u[-1]
    M, h = evaluate(system, MASS, 0.0, q, u_0), evaluate(system, FORCE, 0.0, q, u_0)
    rows = [(evaluate(system, NORMAL, 0.0, q, u_0), solution.P_N)]
    if system.d:
        rows.append((evaluate(system, TANGENT, 0.0, q, u_0)[:, 0], solution.P_F[:, :, 0]))
    span = solution.t[-1] - solution.t[0]
    balance = M @ (u_1 - u_0) - h * span
    size = np.abs(M) @ (np.abs(u_0) + np.abs(u_1)) + np.abs(h) * span
    for W, P in rows:
        balance = balance - W.T @ P.sum(axis=0)
        size = size + np.abs(W).T @ np.abs(P).sum(axis=0)
    return float(math.sqrt((balance @ np.linalg.solve(M, balance)) / (size @ np.linalg.solve(M, size))))
