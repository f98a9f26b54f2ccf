"""Random planar systems under all integrators: they agree, or an event says why not.

With constant M, h and rows every mode has constant forces, and a time step is exact as long as no mode changes in it.
What is left of a change, in the kinetic metric |x|_M = sqrt(x.M x), is a jump of the velocity that comes up to one step
early or late, and a jump of the acceleration that acts up to one step too long:

    |q - q_exact|_M <= L dt sum over the changes of (|du|_M + |a|_M t_end)

Without friction the motion does not expand distances in this metric (Moreau 1977: L = 1 for e = 0); impacts with
friction and restitution expand them, and change the next moments. L = EXPANSION allows for this. For compliant contact
the time that the contact takes to come to rest, SETTLING/omega, stands in place of dt; with error control LATE, which
is a hundred tolerances at 1 m/s. A sum over no change is 0: then rounding or the tolerance is left.

Reasons to differ, each read from the runs: a paradox (an event of INCONSISTENT or INDETERMINATE); an impact that gains
energy by Newton's law, which expands distances without limit, and may end in infinitely many impacts of growing speed
in a finite time; impacts at one instant within the step (the law of several impacts at once is not that of one after
the other); for compliant contact any impact at all (its law of impact is another).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from benchmarks.stress_scenes import plane_contacts
from nonsmooth.errors import Status
from nonsmooth.integrators.adaptive.options import Adaptive
from nonsmooth.integrators.event_driven.options import EventDriven
from nonsmooth.integrators.moreau_jean.options import MoreauJean
from nonsmooth.integrators.penalty.options import Penalty
from nonsmooth.mechanics.system import NORMAL, System, evaluate
from nonsmooth.results.events import EventKind
from nonsmooth.results.solution import Solution
from nonsmooth.runs.asked import SELECTIONS
from nonsmooth.runs.simulate import simulate_whole

T_END = 0.3  # s
DT, RTOL, STIFFNESS, ZETA = 1e-4, 1e-9, 1e10, 1.0
SETTLING = 10.0  # times 1/omega, of a contact with critical damping: exp(-10) of its motion is left
EXPANSION = 1.0
CONTROLLED = Adaptive(rtol=1e-7, atol=1e-9)
LATE = 100 * CONTROLLED.rtol  # s
EVENTS = EventDriven(rtol=RTOL, atol=1e-2 * RTOL)
LONGEST = 60.0  # s of wall time: a run takes milliseconds, seconds where a machine is busy


class Sample(NamedTuple):
    """A random system at a state."""

    system: System
    q0: np.ndarray
    u0: np.ndarray
    M: np.ndarray
    selection: str


class Verdict(NamedTuple):
    """How far a method is from located events, what that may be, and why it may differ more (empty: no reason)."""

    seed: int
    method: str
    error: float
    bound: float
    reason: str

    @property
    def agrees(self) -> bool:
        return self.error <= self.bound


def sample(seed: int) -> Sample:
    """Two to four coordinates, one to four contacts, half of them closed; mu to 1.5, in half of all e to 0.9."""
    rng = np.random.default_rng(seed)
    n, c = int(rng.integers(2, 5)), int(rng.integers(1, 5))
    axes = np.linalg.qr(rng.normal(size=(n, n)))[0]
    M = axes @ np.diag(np.exp(rng.uniform(-1.5, 1.5, n))) @ axes.T
    M = 0.5 * (M + M.T)
    W_N, W_F = rng.normal(size=(c, n)), rng.normal(size=(c, n))
    is_closed = (rng.random(c) < 0.5) & (np.arange(c) < n - 1)
    g_0 = np.where(is_closed, 0.0, rng.uniform(0.02, 0.3, c))
    u0 = rng.normal(size=n)
    closed = W_N[is_closed]
    if len(closed):
        u0 -= np.linalg.pinv(closed) @ (closed @ u0)
    h = 5.0 * rng.normal(size=n) - W_N.T @ rng.uniform(0.0, 10.0, c)
    mu, e = rng.uniform(0.0, 1.5, c), rng.uniform(0.0, 0.9) * (rng.random() < 0.5)
    system = plane_contacts(M, h, W_N, W_F, g_0=g_0, mu=mu, e=e, name=f"random system {seed}")
    rest = np.zeros(4 - n)
    M = np.asarray(system.parameters[:16]).reshape(4, 4)
    return Sample(system, np.zeros(4), np.concatenate((u0, rest)), M, list(SELECTIONS)[seed % 3])


def compare(seed: int) -> list[Verdict]:
    """Three methods against located events; compliant contact with the rule of selection of its stiff limit."""
    s = sample(seed)
    exact = run(s, EVENTS)
    steps, controlled = run(s, MoreauJean(DT)), run(s, CONTROLLED)
    compliant = run(s, Penalty(STIFFNESS, damping_ratio=ZETA, rtol=1e-8))
    limit = exact if s.selection == "compliant-limit" else run(s._replace(selection="compliant-limit"), EVENTS)
    return [
        judge(seed, s, exact, steps, DT),
        judge(seed, s, exact, controlled, LATE),
        judge(seed, s, limit, compliant, SETTLING / slowest(s)),
    ]


def slowest(s: Sample) -> float:
    """The least frequency of a compliant contact [1/s]."""
    W_N = evaluate(s.system, NORMAL, 0.0, s.q0, s.u0)
    effective = np.einsum("ci,ci->c", W_N, np.linalg.solve(s.M, W_N.T).T)
    return float(np.sqrt(STIFFNESS * effective.min()))


def run(s: Sample, integrator: object) -> Solution:
    return simulate_whole(
        s.system, (0, T_END), s.q0, s.u0, integrator=integrator, selection=s.selection, on_failure="return",
        max_wall_time=LONGEST,
    )  # fmt: skip


def judge(seed: int, s: Sample, exact: Solution, other: Solution, dt: float) -> Verdict:
    """Compare the ends of two runs."""
    name = str(other.about["integrator"]).split("(")[0]
    if not (exact.success and other.success):
        failed = exact if not exact.success else other
        reason = "no solution" if failed.status == Status.NO_SOLUTION else ""
        if gains_energy(exact):
            reason = "energy gain"
        return Verdict(seed, name, math.inf, 0.0, reason or f"failure: {failed.status.name}")
    error = size(s.M, other.q[-1] - exact.q[-1])
    return Verdict(seed, name, error, bound(s, exact, dt), reason_to_differ(exact, other, dt, name))


def size(M: np.ndarray, x: np.ndarray) -> float:
    """|x|_M."""
    return float(math.sqrt(max(0.0, x @ M @ x)))


def bound(s: Sample, exact: Solution, dt: float) -> float:
    """The bound of the top: the jumps of the velocity, and at every event a jump of the acceleration."""
    jumps = sum(size(s.M, du) for du in np.diff(exact.u, axis=0)[np.diff(exact.t) == 0.0])
    W = np.asarray(s.system.parameters[16:20])
    strongest = max((size(s.M, a) for a in accelerations(exact)), default=0.0) + size(np.linalg.inv(s.M), W)
    events = len(exact.events) + 1
    return EXPANSION * dt * (jumps + events * strongest * T_END) + RTOL


def accelerations(solution: Solution) -> np.ndarray:
    """Mean accelerations between the records."""
    dt = np.diff(solution.t)
    is_long = dt > 1e-9
    return np.diff(solution.u, axis=0)[is_long] / dt[is_long, None]


def reason_to_differ(exact: Solution, other: Solution, dt: float, name: str) -> str:
    """Why two runs may differ by more than the bound."""
    if exact.paradoxes or other.paradoxes:
        return "paradox"
    if gains_energy(exact):
        return "energy gain"
    impacts = [event for event in exact.events if event.kind == EventKind.IMPACT]
    if name == "Penalty" and impacts:
        return "law of impact"
    for first, second in zip(impacts, impacts[1:], strict=False):
        if first.contact != second.contact and second.t - first.t <= 2 * dt:
            return "impacts at one instant"
    return ""


def gains_energy(exact: Solution) -> bool:
    """Whether an impact by Newton's law gave the bodies more than a thousandth of the energy they had."""
    works = exact.ledger["normal"] + exact.ledger["friction"]
    is_impact = np.diff(exact.t) == 0.0
    return bool((np.diff(works)[is_impact] > 1e-3 * exact.ledger["kinetic"][:-1][is_impact]).any())
