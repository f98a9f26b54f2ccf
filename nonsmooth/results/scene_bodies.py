"""Bodies and joints of a run of a scene, by name."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from nonsmooth.errors import InvalidInput, nearest, shown
from nonsmooth.views import Worded, view


class BodyState(NamedTuple):
    """A body at one time, as a function of ``events=`` is given it."""

    position: np.ndarray  # (2|3,) of the centre of mass [m]
    turn: float | np.ndarray  # angle [rad], or (4,) unit quaternion (w, x, y, z)
    velocity: np.ndarray  # (2|3,) [m/s]
    spin: float | np.ndarray  # [rad/s], or (3,) in the axes of the world


class BodyMotion(NamedTuple):
    """The motion of one body."""

    t: np.ndarray  # (n_t,) [s]
    position: np.ndarray  # (n_t, 2|3) of the centre of mass [m]
    turn: np.ndarray  # (n_t,) angle [rad], or (n_t, 4) unit quaternion (w, x, y, z)
    velocity: np.ndarray  # (n_t, 2|3) [m/s]
    spin: np.ndarray  # (n_t,) or (n_t, 3), in the axes of the world [rad/s]

    def __repr__(self) -> str:
        return view(Worded, "repr")(self)

    def _repr_html_(self) -> str:
        return view(Worded, "html")(self)


class JointImpulses(NamedTuple):
    """The impulses that held two bodies together."""

    t: np.ndarray  # (n_t,) [s]
    P: np.ndarray  # (n_t, 2|3) of the last step before each record, on the second body, in the axes of the world [N s]

    def __repr__(self) -> str:
        return view(Worded, "repr")(self)

    def _repr_html_(self) -> str:
        return view(Worded, "html")(self)


def index_of(name: Any, names: list[str]) -> int:
    """The place of a body among all, or `InvalidInput` with the name that is nearest."""
    if name not in names:
        raise InvalidInput(f"there is no body {shown(name)}; {nearest(name, names)}")
    return names.index(name)
