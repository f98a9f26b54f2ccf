"""Bodies and joints of a run of a scene, by name."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np

from nonsmooth.errors import InvalidInput
from nonsmooth.results.recorded import index_of
from nonsmooth.scenes.elements import Kind
from nonsmooth.scenes.scene import Scene
from nonsmooth.views import Worded, view


class BodyState(NamedTuple):
    """A body at one time, as a function of ``events=`` is given it."""

    position: np.ndarray  # (2|3,) of the centre of mass [m]
    turn: float | np.ndarray  # angle [rad], or (4,) unit quaternion (w, x, y, z)
    velocity: np.ndarray  # (2|3,) [m/s]
    spin: float | np.ndarray  # [rad/s], or (3,) in the axes of the world


class SceneState(Mapping[str, BodyState]):
    """The bodies of a scene at one instant, or at several, by name.

    Attributes
    ----------
    t : float or (m,)
        [s]
    names : list of str
        Of the bodies, in the order of the arrays.
    scene : Scene or None
    position, turn, velocity, spin : arrays (n_b, ...)
        As those of one record of a `SceneSolution`.
    """

    def __init__(
        self, t: Any, names: list[str], scene: Scene | None, position: np.ndarray, turn: np.ndarray,
        velocity: np.ndarray, spin: np.ndarray,
    ) -> None:  # fmt: skip
        self.t, self.names, self.scene = t, names, scene
        self.position, self.turn, self.velocity, self.spin = position, turn, velocity, spin

    def __getitem__(self, name: str) -> BodyState:
        b, axis = index_of(name, self.names), self.position.ndim - 2  # that of the bodies
        position, turn, velocity, spin = (
            np.take(part, b, axis) for part in (self.position, self.turn, self.velocity, self.spin)
        )
        if np.ndim(turn) == 0:
            return BodyState(position, float(turn), velocity, float(spin))
        return BodyState(position, turn, velocity, spin)

    def __contains__(self, name: object) -> bool:
        return name in self.names

    def __iter__(self) -> Iterator[str]:
        return iter(self.names)

    def __len__(self) -> int:
        return len(self.names)

    def __repr__(self) -> str:
        return f"SceneState(t = {self.t} s, {len(self)} bodies)"

    def state(self) -> tuple[np.ndarray, np.ndarray]:
        """q and u of the system of the scene, see `Scene.state`.

        Raises
        ------
        InvalidInput
            Of a run that was loaded without its scene.
        """
        if self.scene is None:
            raise InvalidInput("a loaded run does not know which bodies move by forces; give its scene to load")
        moves = [k for k, name in enumerate(self.names) if self.scene[name].kind is Kind.DYNAMIC]
        if self.position.shape[-1] != 2:
            return self.position[moves].ravel(), self.velocity[moves].ravel()
        q, u = ((self.position, self.turn), (self.velocity, self.spin))
        return tuple(np.column_stack((a[moves], b[moves])).ravel() for a, b in (q, u))  # type: ignore[return-value]


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


class JointMotion(NamedTuple):
    """What a joint did, and how its bodies moved along its axis; None of what it does not have, or was not loaded."""

    t: np.ndarray  # (n_t,) [s]
    P: np.ndarray  # (n_t, 2|3) of the last step before each record, on the second body, in the axes of the world [N s]
    L: np.ndarray  # (n_t,) or (n_t, 3) and its angular impulse about the point of the joint [N m s]
    angle: np.ndarray | None = None  # (n_t,) of the second body against the first from the start [rad]
    angle_rate: np.ndarray | None = None  # (n_t,) [rad/s]
    travel: np.ndarray | None = None  # (n_t,) of the second body along the axis from the start [m]
    travel_rate: np.ndarray | None = None  # (n_t,) [m/s]
    distance: np.ndarray | None = None  # (n_t,) of the ends of a rope or a distance [m]
    distance_rate: np.ndarray | None = None  # (n_t,) [m/s]
    at_limit: np.ndarray | None = None  # (n_t,) -1 at the least, 1 at the largest that its limits let, else 0

    def __repr__(self) -> str:
        return view(Worded, "repr")(self)

    def _repr_html_(self) -> str:
        return view(Worded, "html")(self)


class SpringForces(NamedTuple):
    """A spring with its damper, at the records."""

    t: np.ndarray  # (n_t,) [s]
    length: np.ndarray  # (n_t,) [m]; of a torsion spring its angle [rad]
    force: np.ndarray  # (n_t,) positive where it pulls [N]; of a torsion spring its torque on the first body [N m]

    def __repr__(self) -> str:
        return view(Worded, "repr")(self)

    def _repr_html_(self) -> str:
        return view(Worded, "html")(self)
