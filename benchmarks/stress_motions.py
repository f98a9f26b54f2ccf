"""Long, fast, slow, stiff and scaled motions, whose invariants are known: cascades of impacts, steps from 1e-7 to 1 s,
ten million steps, restitution 1, contacts that open and close in every step, stiff springs, all rules of
selection.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from benchmarks.core_scenes import row_of_blocks
from benchmarks.stress_figures import EPS, Case, Method
from benchmarks.stress_scenes import box_on
from nonsmooth.catalogue.entries import load
from nonsmooth.integrators.adaptive.options import Adaptive
from nonsmooth.integrators.event_driven.options import EventDriven
from nonsmooth.integrators.moreau_jean.options import MoreauJean
from nonsmooth.integrators.moreau_jean.step import VELOCITY_ROUNDINGS
from nonsmooth.mechanics.system import Contact, System
from nonsmooth.results.solution import Solution
from nonsmooth.runs.asked import SELECTIONS

G = 9.81  # gravity [m/s^2]
STEPS_FROM_REST = 10**6  # of the block that sticks on an incline
LONG = 10**7  # steps of a long run


def cases(is_full: bool) -> Iterator[Case]:
    """All cases of this file, or the small ones."""
    yield ball_at_rest_after_bounces()
    for n in (10, 30, 100) if is_full else (10,):
        yield cascade(n)
    for dt in (1e-7, 1e-6, 1e-4, 1e-2, 1.0):
        yield stopping_block(dt)
    yield stuck_on_incline(STEPS_FROM_REST if is_full else STEPS_FROM_REST // 10)
    for steps in (10**5, LONG) if is_full else (10**5,):
        yield bouncing_forever(steps)
        yield belt_for_long(steps)
    yield beads_forever(100 if is_full else 20)
    yield opening_and_closing()
    for k in (1e6, 1e9, 1e12):
        yield stiff_spring(k)
    for selection in SELECTIONS:
        for model, state in PARADOXES:
            yield paradox(model, state, selection)


def controlled(bound: float) -> list[Method]:
    """The integrators with error control."""
    return [Method(EventDriven(1e-8), bound), Method(Adaptive(1e-8), bound)]


def ball_at_rest_after_bounces() -> Case:
    """Infinitely many bounces end at t_inf; then the ball lies. A time step is late by dt at every bounce that it sees,
    the sum of which is the geometric series of the velocities lost, (1 + e)/(1 - e) v dt; it lies within dt v."""
    ball = load("bouncing-ball")(e=0.8)
    v = math.sqrt(2 * G)
    return Case("ball, e = 0.8, through its accumulation", ball, ball.state(height=1.0), 10.0,
                lambda s: float(abs(s.q[-1, 0]) + abs(s.u[-1, 0])),
                [Method(MoreauJean(1e-3), v * 1e-3), *controlled(1e-10)])  # fmt: skip


def cascade(n: int) -> Case:
    """Beads that strike one another and a wall. Located events: the closed form, with the rounding of each impact. Time
    steps: what the beads have in common, the momentum, is exact; the law takes energy away and never gives any."""
    chain = load("bead-chain")(n=n, e=0.9)
    t_end = 1.2e-3 * n  # the first impact on the wall comes at about n gap/v
    _, u_exact = chain.exact(t_end)

    def energy_gain(s: Solution) -> float:
        return float(np.diff(s.ledger["kinetic"]).max() / s.ledger["kinetic"][0])

    def error(s: Solution) -> float:
        return float(np.abs(s.u[-1] - u_exact).max()) if s.stats.lcp_solved == 0 else energy_gain(s)

    impacts = n * n
    return Case(f"cascade of {n} beads", chain, chain.state(), t_end, error,
                [Method(MoreauJean(1e-5), n * VELOCITY_ROUNDINGS), *controlled(1e-8 * impacts)])  # fmt: skip


def stopping_block(dt: float) -> Case:
    """A plate slides and stops after v^2/(2 mu g): wrong by the step in which it stops, at most v dt."""
    mu, steps = 0.3, 1000
    v = min(1.0, 0.5 * mu * G * steps * dt)
    way = v * v / (2 * mu * G)
    plate = box_on([-0.1, 0.1], mu=mu, height=0.0, name="plate")
    bound = min(mu * G * dt * dt, v * dt) / way + steps * EPS
    return Case(f"plate stops, dt = {dt:.0e} s", plate, (np.zeros(4), np.array([v, 0, 0, 0])), steps * dt,
                lambda s: float(abs(s.q[-1, 0] - way) / way), [Method(MoreauJean(dt), bound)])  # fmt: skip


def stuck_on_incline(steps: int) -> Case:
    """True sticking: not one unit in the last place in a million steps."""
    block = load("inclined-block")()
    return Case(f"block sticks on an incline, {steps:.0e} steps", block, block.state(slip=0.0), steps * 1e-3,
                lambda s: float(np.abs(s.q[-1] - s.q[0]).max()), [Method(MoreauJean(1e-3), 0.0)],
                every=steps // 100)  # fmt: skip


def bouncing_forever(steps: int) -> Case:
    """e = 1: T + V is kept. A step of constant force keeps it exactly, and so does the impact, which turns the velocity
    and stays where it is; each step rounds T and V once."""
    ball = load("bouncing-ball")(e=1.0)
    return Case(f"ball, e = 1, {steps:.0e} steps", ball, ball.state(height=1.0), steps * 1e-3, energy_drift,
                [Method(MoreauJean(1e-3), 4 * EPS * steps)], every=max(1, steps // 1000))  # fmt: skip


def energy_drift(solution: Solution) -> float:
    """The largest gain or loss of T + V over the energy at the start."""
    total = solution.ledger["kinetic"] + solution.ledger["potential"]
    return float(np.abs(total - total[0]).max() / abs(total[0]))


def belt_for_long(steps: int) -> Case:
    """Stick–slip on a belt: a cycle neither grows nor dies, its amplitude in the last tenth is that of the second one.
    Where the steps lie within a cycle changes the amplitude, which is about vb times a second, by vb dt."""
    belt = load("belt-oscillator")()
    dt = 1e-3

    def change(s: Solution) -> float:
        tenth = len(s.t) // 10
        first, last = (np.abs(part).max() for part in (s.q[tenth : 2 * tenth], s.q[-tenth:]))
        return float(abs(last - first) / first)

    return Case(f"stick–slip on a belt, {steps:.0e} steps", belt, belt.state(), steps * dt, change,
                [Method(MoreauJean(dt), 2 * dt)], every=max(1, steps // 100_000))  # fmt: skip


def beads_forever(n: int) -> Case:
    """e = 1: beads exchange velocities and never gain or lose energy; an impact of several rounds its n velocities."""
    chain = load("bead-chain")(n=n, e=1.0)
    steps = 10_000

    def change(s: Solution) -> float:
        kinetic = s.ledger["kinetic"]
        return float(np.abs(kinetic - kinetic[0]).max() / kinetic[0])

    return Case(f"{n} beads, e = 1", chain, chain.state(), steps * 1e-4, change,
                [Method(MoreauJean(1e-4), steps * n * EPS)], every=10)  # fmt: skip


class Shaken(NamedTuple):
    m: float = 1.0  # mass [kg]
    depth: float = 1e-3  # amplitude of the floor [m]
    omega: float = math.pi / 1e-3  # its angular frequency: half a period in a step [1/s]
    g: float = 9.81  # gravity [m/s^2]


def opening_and_closing() -> Case:
    """A mass on a floor that comes and goes in every step: open, closed, open; momentum and ledger stay exact."""

    def mass(t, q, p, M):
        M[0, 0] = p.m

    def force(t, q, u, p, h):
        h[0] = -p.m * p.g

    def gap(t, q, p, g_N):
        g_N[0] = q[0] - p.depth * math.sin(p.omega * t)

    def normal(t, q, p, W_N):
        W_N[0, 0] = 1.0

    def gap_rate(t, q, p, w_N):
        w_N[0] = -p.depth * p.omega * math.cos(p.omega * t)

    system = System(n_q=1, mass=mass, force=force, gap=gap, normal=normal, gap_rate=gap_rate, contacts=[Contact()],
                    parameters=Shaken(), name="shaken floor")  # fmt: skip

    def error(s: Solution) -> float:
        fall = -G * s.t[-1]
        return float(abs(s.u[-1, 0] - fall - s.P_N.sum()) / (abs(fall) + np.abs(s.P_N).sum()))

    return Case("floor that comes and goes in every step", system, (np.array([1e-3]), np.zeros(1)), 10.0, error,
                [Method(MoreauJean(1e-3), 10_000 * EPS)])  # fmt: skip


def stiff_spring(k: float) -> Case:
    """Two masses with a spring slide on a floor: as one they stop after v^2/(2 mu g). A step is implicit in the spring
    and keeps the mean exact; rounding leaves EPS k/(m/dt^2) of the velocities to the spring."""
    system = row_of_blocks(2, k, is_stiff=True)
    dt, mu = 1e-3, 0.3
    way = 1 / (2 * mu * G)

    def error(s: Solution) -> float:
        return float(max(abs(s.q[-1, 0] - way), abs(s.q[-1, 2] - way), abs(s.u[-1]).max() * dt) / way)

    start = np.zeros(4), np.array([1.0, 0, 1.0, 0])
    return Case(f"two masses, spring of {k:.0e} N/m, stop", system, start, 0.5, error,
                [Method(MoreauJean(dt), mu * G * dt**2 / way + EPS * k * dt**2),
                 *controlled(1e-6 + EPS * k * dt**2)])  # fmt: skip


PARADOXES: tuple[tuple[str, dict[str, float]], ...] = (
    ("painleve-rod", {"th": 1.0, "thdot": 4.0, "slip": -1.0}),  # three solutions
    ("sprag-slip", {"th": 0.8, "thdot": 0.0}),
    ("bilateral-rod", {}),
)
# what `Adaptive` does not claim: a seizure whose impact it meets again and again with ever shorter steps
SEIZES = ("sprag-slip", "impact")


def paradox(name: str, state: dict[str, float], selection: str) -> Case:
    """Through paradoxes by every rule: the run ends, friction and impacts take energy, a gain is that of a surface."""
    model = load(name)()
    model = replace(model, mu=2.0) if name == "painleve-rod" else model
    methods, t_end = controlled(1e-7), 0.2
    if (name, selection) == SEIZES:
        methods = methods[:1]

    def gain(s: Solution) -> float:
        given = np.diff(s.ledger["friction"] + s.ledger["normal"])
        scale = s.ledger["kinetic"].max() + np.abs(s.ledger["friction"]).max()
        return float(max(0.0, given.max(initial=0.0)) / scale)

    return Case(f"{name}, rule {selection}", model, model.state(**state), t_end, gain,
                [Method(MoreauJean(1e-4), 1e-4), *methods], selection=selection)  # fmt: skip
