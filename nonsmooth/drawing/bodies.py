"""Bodies of a scene in a picture: where they are in a record, how far they reach in the run, and their colours."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from nonsmooth.scenes.elements import Body, Kind
from nonsmooth.scenes.places import ORIGIN, compose, place_of

if TYPE_CHECKING:
    from nonsmooth.results.scene_solution import SceneSolution

FILL = {Kind.DYNAMIC: "#9ecae1", Kind.FIXED: "#d9d9d9", Kind.KINEMATIC: "#fdd0a2"}
EDGE = "#08306b"
CIRCLE_PIECES = 24  # chosen: pieces of a circle
RECORDS_SEEN = 20  # chosen: records of a run, in which it is looked how far bodies reach


def places(solution: SceneSolution, record: int) -> list[np.ndarray]:
    """Where the frame of each shape is in a record."""
    dim = solution.dim
    found = []
    for body in solution.bodies:
        centre, turn = solution.position[record, body.index], solution.turn[record, body.index]
        place = place_of(centre, turn)
        offset = solution.centres[body.index]
        found.append(compose(place, place_of(-offset, ORIGIN[dim][dim:])))
    return found


def reached(
    solution: SceneSolution, reach: Callable[[Body, np.ndarray], list[tuple[np.ndarray, np.ndarray]]], margin: float
) -> tuple[np.ndarray, np.ndarray]:
    """The corners of the picture of all that bodies reach in the run, and a margin in parts of its size.

    ``reach`` gives lower and upper corners of what is seen of a body in a place.
    """
    lows, highs = [], []
    for record in np.unique(np.linspace(0, len(solution.t) - 1, RECORDS_SEEN).astype(int)):
        for body, place in zip(solution.bodies, places(solution, int(record)), strict=True):
            for low, high in reach(body, place):
                lows.append(low)
                highs.append(high)
    low, high = np.min(lows, axis=0), np.max(highs, axis=0)
    beside = margin * float((high - low).max() or 1.0)
    return low - beside, high + beside


def polygon(outline: np.ndarray, **style: Any) -> Any:
    """An outline (k, 2) as what axes take."""
    from matplotlib.patches import Polygon

    return Polygon(outline, **style)
