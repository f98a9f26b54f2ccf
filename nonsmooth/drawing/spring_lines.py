"""Springs and ropes of a scene in its pictures: coils and lines from end to end; torsion springs are not drawn."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from nonsmooth.results.spring_forces import end_of

if TYPE_CHECKING:
    from nonsmooth.results.scene_solution import SceneSolution

COILS, COIL_WIDTH = 8, 0.08  # chosen: zigzags of a spring, and how wide they are, of its length at the start


def spring_lines(solution: SceneSolution, record: int) -> list[np.ndarray]:
    """The two ends (2, d) of each spring at a record; none of a run that was loaded without its scene."""
    springs = () if solution.scene is None else solution.scene.springs
    ends = [((spring.a, spring.at_a), (spring.b, spring.at_b)) for spring in springs if not spring.is_torsion]
    return [np.array([end_of(solution, body, at)[0][record] for body, at in pair]) for pair in ends]


def rope_lines(solution: SceneSolution, record: int) -> list[np.ndarray]:
    """The two ends (2, d) of each rope, and of each distance that is held, at a record."""
    ties = [joint for joint in solution.joints if joint.is_tie]
    ends = [((joint.a, joint.at), (joint.b, joint.at_b)) for joint in ties]
    return [np.array([end_of(solution, body, at)[0][record] for body, at in pair]) for pair in ends]


def coil(ends: np.ndarray, width: float) -> np.ndarray:
    """A zigzag (k, 2) of a width [m] from end to end, straight at both."""
    along = ends[1] - ends[0]
    across = np.array([-along[1], along[0]]) / max(float(np.linalg.norm(along)), np.finfo(float).tiny)
    s = np.concatenate(([0.0], np.linspace(0.15, 0.85, 2 * COILS + 1), [1.0]))
    aside = np.zeros(len(s))
    aside[2:-2:2], aside[3:-2:2] = 0.5, -0.5
    return ends[0] + s[:, None] * along + (width * aside)[:, None] * across
