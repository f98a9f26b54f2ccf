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
    rest = length[0] if spring.length is None else spring.length
    return SpringForces(solution.t, length, spring.stiffness * (length - rest) + spring.damping * rate)


def angle_of(solution: SceneSolution, spring: Spring) -> tuple[np.ndarray, np.ndarray]:
    """The angle of a torsion spring and its rate."""
    a, b = solution[spring.a.name], solution[spring.b.name]
    return b.turn - a.turn, b.spin - a.spin


def length_of(solution: SceneSolution, spring: Spring) -> tuple[np.ndarray, np.ndarray]:
    """The length of a spring and its rate."""
    first, v_first = end_of(solution, spring.a, spring.at_a)
    second, v_second = end_of(solution, spring.b, spring.at_b)
    line, speed = second - first, v_second - v_first
    length = np.linalg.norm(line, axis=1)
    return length, np.einsum("tk,tk->t", line, speed) / np.where(length > 0.0, length, 1.0)


def end_of(solution: SceneSolution, body: Body, at: np.ndarray | None) -> tuple[np.ndarray, np.ndarray]:
    """Where the end of a spring is, and its velocity, (n_t, d) each; ``at`` is where it was at the start."""
    motion = solution[body.name]
    if at is None:
        return motion.position, motion.velocity
    d = len(at)
    arm = compose(inverse(place_of(motion.position[0], motion.turn[0])), place_of(at, ORIGIN[d][d:]))[:d]
    arms = np.array([rotate(turn, arm) for turn in motion.turn])
    return motion.position + arms, motion.velocity + turning(motion, arms)


def turning(motion: BodyMotion, arms: np.ndarray) -> np.ndarray:
    """omega x r of arms (n_t, d)."""
    if arms.shape[1] == 2:
        return motion.spin[:, None] * np.stack((-arms[:, 1], arms[:, 0]), axis=1)
    return np.cross(motion.spin, arms)
