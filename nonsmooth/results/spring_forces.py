"""Springs of a run of a scene: their lengths and forces at the records, and where their ends are.

    F = k (l - l_0) + c dl/dt,    dl/dt = e . (v_b + w_b x r_b - v_a - w_a x r_a)

positive where it pulls, with e along the spring; of a torsion spring with the angle in place of the length.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from nonsmooth.errors import InvalidInput, nearest, shown
from nonsmooth.results.scene_bodies import BodyMotion, SpringForces
from nonsmooth.scenes.elements import Body, Spring
from nonsmooth.scenes.places import ORIGIN, compose, inverse, place_of, rotate

if TYPE_CHECKING:
    from nonsmooth.results.scene_solution import SceneSolution

End = tuple[Body, np.ndarray | None]


def forces_of_spring(solution: SceneSolution, name: str) -> SpringForces:
    """Length and force of a spring, by name.

    Raises
    ------
    InvalidInput
        For a spring that is not there, and of a run that was loaded without its scene.
    """
    if solution.scene is None:
        raise InvalidInput("a loaded run does not know its springs; give its scene to load")
    springs = {spring.name: spring for spring in solution.scene.springs}
    if name not in springs:
        raise InvalidInput(f"there is no spring {shown(name)}; {nearest(name, springs)}")
    spring = springs[name]
    length, rate = angle_of(solution, spring) if spring.is_torsion else length_of(solution, spring)
    rest = length_at_start(solution, spring) if spring.length is None else spring.length
    return SpringForces(solution.t, length, spring.stiffness * (length - rest) + spring.damping * rate)


def angle_of(solution: SceneSolution, spring: Spring) -> tuple[np.ndarray, np.ndarray]:
    """The angle of a torsion spring and its rate."""
    a, b = solution[spring.a.name], solution[spring.b.name]
    return b.turn - a.turn, b.spin - a.spin


def length_of(solution: SceneSolution, spring: Spring) -> tuple[np.ndarray, np.ndarray]:
    """The length of a spring and its rate."""
    return length_between(solution, (spring.a, spring.at_a), (spring.b, spring.at_b))


def length_between(solution: SceneSolution, one: End, other: End) -> tuple[np.ndarray, np.ndarray]:
    """The distance of two points, each a body and where it was at the start, and its rate."""
    (first, v_first), (second, v_second) = end_of(solution, *one), end_of(solution, *other)
    line, speed = second - first, v_second - v_first
    length = np.linalg.norm(line, axis=1)
    return length, np.einsum("tk,tk->t", line, speed) / np.where(length > 0.0, length, 1.0)


def length_at_start(solution: SceneSolution, spring: Spring) -> float:
    """The length of a spring where a run begins, of a torsion spring the angle."""
    first, second = (start_of(solution, body) for body in (spring.a, spring.b))
    if spring.is_torsion:
        return float(second[-1] - first[-1])
    d = solution.dim
    ends = [place[:d] if at is None else at for place, at in ((first, spring.at_a), (second, spring.at_b))]
    return float(np.linalg.norm(ends[1] - ends[0]))


def start_of(solution: SceneSolution, body: Body) -> np.ndarray:
    """The centre of mass of a body and its turn as the scene has them, before ``project`` moves what overlaps; of one
    that moves as a function says those of the first record, which is the start."""
    if body.motion is not None:
        return place_of(solution.position[0, body.index], solution.turn[0, body.index])
    no_turn = ORIGIN[solution.dim][solution.dim :]
    return compose(place_of(body.position, body.turn), place_of(solution.centres[body.index], no_turn))


def end_of(solution: SceneSolution, body: Body, at: np.ndarray | None) -> tuple[np.ndarray, np.ndarray]:
    """Where the end of a spring is, and its velocity, (n_t, d) each; ``at`` is where it was at the start."""
    motion = solution[body.name]
    if at is None:
        return motion.position, motion.velocity
    d = len(at)
    arm = compose(inverse(start_of(solution, body)), place_of(at, ORIGIN[d][d:]))[:d]
    arms = np.array([rotate(turn, arm) for turn in motion.turn])
    return motion.position + arms, motion.velocity + turning(motion, arms)


def turning(motion: BodyMotion, arms: np.ndarray) -> np.ndarray:
    """omega x r of arms (n_t, d)."""
    if arms.shape[1] == 2:
        return motion.spin[:, None] * np.stack((-arms[:, 1], arms[:, 0]), axis=1)
    return np.cross(motion.spin, arms)
