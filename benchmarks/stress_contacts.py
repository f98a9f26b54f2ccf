"""Cases with many, redundant or nearly dependent contacts, whose motion is known in closed form.

Each bound is what the method promises for the invariant, relative to the motion of the case:

* time steps: a velocity that is constant or falls linearly is integrated exactly, and the step in which a block stops
  is wrong by a part of dt^2 mu g; with theta = 1 half a step of the velocity at the start is missing. Velocities within
  ACCEPTED, and within the rounding EPS m_max/m_min of impulses that the lightest block shares with the heaviest, return
  to zero in every step, and move a block by as much times dt;
* located events, and steps with error control: the tolerance rtol for every step, with the same rounding;
* compliant contact: the depth of the load, which a start from zero depth doubles, and mu times as far the friction that
  is missing until then.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from benchmarks.stress_figures import EPS, Case, Method
from benchmarks.stress_scenes import Tower, box_in_corner, box_on, groove, stack, tower
from nonsmooth.contact.planar.problem import ACCEPTED_RESIDUAL
from nonsmooth.integrators.adaptive.options import Adaptive
from nonsmooth.integrators.event_driven.options import EventDriven
from nonsmooth.integrators.moreau_jean.options import MoreauJean
from nonsmooth.integrators.penalty.options import Penalty
from nonsmooth.results.solution import Solution

G, MU, DT = 9.81, 0.3, 1e-3  # gravity [m/s^2], friction of the boxes, step [s]
REST = 0.1  # duration of a case at rest [s]
FALL = 0.5 * G * REST**2  # of a free body in that time [m]
RATIOS = (1.0, 1e3, 1e6, 1e-6)  # mass of the highest block over that of the lowest
RTOL = 1e-8
MOST_AT_REST = 8  # frictional contacts at rest that `EventDriven` enumerates
MOST_COMPLIANT = 20  # contacts: the Jacobian of `Penalty` is dense
SHALLOW = 1e-5  # depth of a compliant contact under all the weight [m]


def cases(is_full: bool) -> Iterator[Case]:
    """All cases of this file, or the small ones."""
    heights = (2, 10, 50) if is_full else (2, 10)
    for n in heights:
        for ratio in RATIOS:
            yield tower_at_rest(n, ratio)
            yield struck_tower(n, ratio)
    for n in heights:
        for ratio in RATIOS:
            yield stack_at_rest(n, ratio)
    for n in (2, 3, 4, 8) if is_full else (2, 3, 4):
        yield sliding_box(n)
    for copies in (2, 4) if is_full else (2,):
        yield duplicated(copies)
    for angle in (1e-2, 1e-5, 1e-8, 1e-11) if is_full else (1e-2, 1e-5):
        yield flat_groove(angle)
        yield steep_groove(angle)
    for mu in (0.1, 1.0, 10.0, 1e3) if is_full else (0.1, 1.0, 1e3):
        for push in (0.0, 1e4):
            yield corner(mu, push)
    for mu in (1.0, 10.0, 1e3):
        yield stopped_by_friction(mu)


def methods(n_closed: int, way: float, rounding: float, weight: float, v: float = 0.0, mu: float = MU) -> list[Method]:
    """The integrators for a motion along ``way`` [m] that begins with the speed v [m/s], with the bounds of the top."""
    step = ACCEPTED_RESIDUAL + EPS * rounding + (mu * G * DT**2 / way if v > 0 else 0.0)
    compliant = Penalty(weight / SHALLOW, damping_ratio=1.0, rtol=RTOL)
    controlled = 100 * RTOL + EPS * rounding
    rigid = [
        Method(MoreauJean(DT), step),
        Method(MoreauJean(DT, theta=1.0), step + 0.5 * DT * v / way),
        Method(MoreauJean(DT, projection=True), step),
        Method(Adaptive(RTOL), controlled),
    ]
    if n_closed <= MOST_AT_REST:
        rigid.append(Method(EventDriven(RTOL), controlled))
    if n_closed <= MOST_COMPLIANT and mu <= 10:  # else it slides farther while it settles than it should at all
        rigid.append(Method(compliant, (2 + mu) * SHALLOW / way + 100 * RTOL))
    return rigid


def at_rest(solution: Solution) -> float:
    """The largest displacement over that of a free fall as long as the run."""
    return float(np.abs(solution.q - solution.q[0]).max() / FALL)


def masses(n: int, ratio: float) -> tuple[float, float, float]:
    """Ratio of neighbours, all the weight [N], and the mass of all over the least."""
    step = ratio ** (1 / (n - 1))
    m = step ** np.arange(n)
    return step, G * m.sum(), m.sum() / m.min()


def tower_at_rest(n: int, ratio: float) -> Case:
    step, weight, spread = masses(n, ratio)
    system = tower(n, Tower(ratio=step))
    return Case(f"tower of {n}, masses 1 to {ratio:.0e}, at rest", system, (np.zeros(2 * n), np.zeros(2 * n)), REST,
                at_rest, methods(n, FALL / n, spread, weight))  # fmt: skip


def struck_tower(n: int, ratio: float) -> Case:
    """The highest block is struck, v = 1 m/s: it stops after v^2/(2 mu g), the others stay where they are."""
    step, weight, spread = masses(n, ratio)
    system = tower(n, Tower(ratio=step, mu=MU))
    way, u0 = 1 / (2 * MU * G), np.zeros(2 * n)
    u0[-2] = 1.0

    def invariant(solution: Solution) -> float:
        error = np.abs(solution.q[-1])
        error[-2] = abs(solution.q[-1, -2] - way)
        return float(error.max() / way)

    return Case(f"tower of {n}, masses 1 to {ratio:.0e}, top struck", system, (np.zeros(2 * n), u0), 0.4,
                invariant, methods(n, way / n, spread, weight, 1.0))  # fmt: skip


def stack_at_rest(n: int, ratio: float) -> Case:
    step, weight, spread = masses(n, ratio)
    system = stack(n, Tower(ratio=step))
    return Case(f"stack of {n}, masses 1 to {ratio:.0e}, at rest", system, (np.zeros(3 * n), np.zeros(3 * n)), REST,
                at_rest, methods(2 * n, FALL / n, spread, weight))  # fmt: skip


def sliding_case(name: str, points: np.ndarray, mu: float = MU, height: float = 0.1) -> Case:
    way = 1 / (2 * mu * G)

    def invariant(solution: Solution) -> float:
        off = np.abs(solution.q[-1] - [way, 0.0, 0.0, 0.0])
        return float(off.max() / way)

    system = box_on(points, mu=mu, height=height, name=name)
    return Case(name, system, (np.zeros(4), np.array([1.0, 0, 0, 0])), max(0.02, 1.2 / (mu * G)), invariant,
                methods(len(points), way, len(points), G, 1.0, mu))  # fmt: skip


def sliding_box(n: int) -> Case:
    """A box slides on n supports and stops after v^2/(2 mu g), whatever the split of its weight."""
    return sliding_case(f"box slides on {n} supports", np.linspace(-0.1, 0.1, n))


def duplicated(copies: int) -> Case:
    """The same, each of two supports counted several times."""
    return sliding_case(f"box slides on 2 supports, each {copies} times", np.repeat([-0.1, 0.1], copies))


def stopped_by_friction(mu: float) -> Case:
    """A plate slides on two supports in the plane of its mass centre, so that it cannot tip."""
    return sliding_case(f"plate stops, mu = {mu:g}", np.array([-0.1, 0.1]), mu, height=0.0)


def gaps_closed(solution: Solution) -> float:
    """The largest gap or depth of the two planes over a free fall."""
    return float(np.abs(solution.g_N[:, :2]).max() / FALL)


def flat_groove(angle: float) -> Case:
    """Two planes that are nearly one: the motion along them is nearly undetermined, that across them is not."""
    return Case(f"groove, normals {2 * angle:.0e} rad apart", groove(angle), (np.zeros(4), np.zeros(4)), REST,
                gaps_closed, methods(2, FALL, 1.0, G))  # fmt: skip


def steep_groove(angle: float) -> Case:
    """Planes that are nearly vertical: forces of m g/(2 sin angle) on both sides, too great for a compliant contact."""
    return Case(f"wedge, normals {2 * angle:.0e} rad from opposite", groove(np.pi / 2 - angle),
                (np.zeros(4), np.zeros(4)), REST, gaps_closed, methods(2, FALL, 1 / angle, G)[:-1])  # fmt: skip


def corner(mu: float, push: float) -> Case:
    """A box pressed into a corner by its weight and a push [N] stays there."""
    return Case(f"box in a corner, mu = {mu:g}, push {push:g} N", box_in_corner(mu, push), (np.zeros(4), np.zeros(4)),
                REST, at_rest, methods(4, FALL, 4.0, G + push))  # fmt: skip
