"""How near a cycle comes to another sequence of modes, and to paradoxes: least values over a period.

A contact that slides with the sign s grazes where s gamma_F falls to zero. It has one solution at acceleration level
while

    p = G_NN - s mu n G_NF > 0        for n = 1, and of a bilateral contact for n = -1 too

With p < 0 there are two or none, according to the sign of b: see docs/theory/painleve.md. The least p/G_NN over a
period falls through zero where the cycle enters such a region. Of several contacts each is judged alone.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np

from nonsmooth.cycles.cycle import CyclePhase, LimitCycle
from nonsmooth.cycles.flow_map import flow_curve
from nonsmooth.cycles.mode_flow import ModeFlow, mode_flow, mu_of
from nonsmooth.mechanics.system import BILATERAL, MASS, NORMAL, ContactMode
from nonsmooth.paradox.classify import classify

MARGIN_PIECES = 48  # chosen: of a phase, between which a margin has one minimum at most
XATOL = 1e-12  # chosen: s, of a minimum's time

Least = tuple[float, np.ndarray]  # a value, and the state where it is taken


def least_slip(cycle: LimitCycle) -> float:
    """Least sliding velocity s gamma_F [m/s] of a cycle that never stops sliding, negative beyond its mode's limit."""
    least = np.inf
    for phase in cycle.phases:
        flow = mode_flow(cycle.system, phase.states)
        for i in _sliding(flow, phase):
            least = min(least, _least(cycle, phase, flow, partial(slip_of, flow, i))[0])
    return least


def least_p(cycle: LimitCycle) -> Least:
    """The least p/G_NN of the contacts that slide along a cycle, inf where none does, and the state there."""
    found: Least = (np.inf, cycle.phases[0].x)
    for phase in cycle.phases:
        flow = mode_flow(cycle.system, phase.states)
        for i in _sliding(flow, phase):
            if i in flow.constrained:
                found = min(found, _least(cycle, phase, flow, partial(p_of, flow, i)), key=lambda pair: pair[0])
    return found


def slip_of(flow: ModeFlow, i: int, x: np.ndarray) -> float:
    """s gamma_F of a contact that slides [m/s]."""
    return float(flow.margins(x)[i, "slip"].real)


def p_of(flow: ModeFlow, i: int, x: np.ndarray) -> float:
    """p/G_NN of a contact that slides, the lesser one of a bilateral contact."""
    q, u, t = flow.parts(x)
    N, T = flow.call(NORMAL, q, u, t)[i], flow.along(q, u, t)[0][i]
    by_N = np.linalg.solve(flow.call(MASS, q, u, t), N)
    G_NN, G_NF = (N @ by_N).real, (T @ by_N).real
    s = flow.sliding[i]
    mu = mu_of(flow.system.laws, i, s * flow.row_velocities(q, u, t)[i, 1]).real
    signs = (1, -1) if flow.system.kinds[i, 0] == BILATERAL else (1,)
    return min(float(1 - s * mu * n * G_NF / G_NN) for n in signs)


def paradox_at(cycle: LimitCycle, x: np.ndarray) -> str:
    """What `classify` says of a state of a cycle."""
    n = cycle.system.n_u
    found = classify(cycle.system, float(x[2 * n]) if x.size > 2 * n else 0.0, x[:n], x[n : 2 * n])
    return f"{found.kind.name.lower()}, {found.n_solutions} solutions"


def _sliding(flow: ModeFlow, phase: CyclePhase) -> list[int]:
    """The contacts that slide with friction in a phase."""
    return [i for i in flow.closed if phase.states[i].mode == ContactMode.SLIDE and flow.system.kinds[i, 1]]


def _least(cycle: LimitCycle, phase: CyclePhase, flow: ModeFlow, function: Callable[[np.ndarray], float]) -> Least:
    """The least value of a function of the state in a phase."""
    from scipy.optimize import minimize_scalar

    curve = flow_curve(flow, phase.x, phase.duration, cycle.scale, pieces=MARGIN_PIECES)
    s = np.linspace(0, phase.duration, MARGIN_PIECES + 1)
    values = [function(x) for x in curve(s).T]
    k = int(np.argmin(values))
    least, at = values[k], s[k]
    pieces = {max(k - 1, 0), min(k, MARGIN_PIECES - 1)}
    if k in (0, MARGIN_PIECES):  # of a cycle with one phase the end is the beginning
        pieces |= {0, MARGIN_PIECES - 1}
    for j in sorted(pieces):
        best = minimize_scalar(lambda time: function(curve(time)), bounds=(s[j], s[j + 1]), method="bounded",
                               options={"xatol": XATOL})  # fmt: skip
        if best.fun < least:
            least, at = float(best.fun), best.x
    return float(least), curve(at)
