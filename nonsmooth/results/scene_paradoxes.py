"""Where rigid contact left open what a step of a scene does: the rows that a run keeps, as objects."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from nonsmooth.integrators.records import EVENT_I, EVENT_J, PARADOX_WIDTH
from nonsmooth.results.events import ParadoxEvent, event_of

WITHOUT_SIGN = {"slide +": "slide", "slide -": "slide"}  # in space, where a slide has a direction


@dataclass(frozen=True)
class SceneParadox(ParadoxEvent):
    """A step of a scene in which two bodies had no force to slide with (INCONSISTENT: an impact without collision), or
    the first step of an episode in which several motions fit (INDETERMINATE); as of a System, with the bodies.

    ``contact`` is the number of the contact in its step, the first of those of the two bodies; P_N and P_F are those of
    all of them. Slips and P_F have the signs of ``scene.system()``: positive where body j slides along its normal, out
    of body i, turned by -90 degrees. In space signs are 0, and P_F and gamma_F are sizes.

    Attributes
    ----------
    i, j : str
        Names of the bodies.
    """

    i: str
    j: str


def no_rows() -> np.ndarray:
    """Those of a run without any."""
    return np.zeros((0, PARADOX_WIDTH))


def paradox_of(row: np.ndarray, names: list[str], dim: int) -> SceneParadox:
    """A row as an object."""
    event = event_of(row)
    assert isinstance(event, ParadoxEvent)
    if dim == 3:
        event = replace(event, alternatives=tuple(WITHOUT_SIGN.get(name, name) for name in event.alternatives))
    return SceneParadox(**vars(event), i=names[int(row[EVENT_I])], j=names[int(row[EVENT_J])])
