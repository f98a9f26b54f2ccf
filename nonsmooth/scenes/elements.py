"""What a scene holds: bodies, the points that they share, springs between them, forces on them.

`Scene` makes them, checked; each is a description, which no run changes.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import IntEnum
from typing import Any

import numpy as np

from nonsmooth.scenes.materials import Material
from nonsmooth.scenes.shapes import Shape


class Kind(IntEnum):
    """How a body moves."""

    DYNAMIC = 0
    FIXED = 1
    KINEMATIC = 2


@dataclass(frozen=True, eq=False)
class Body:
    """A body of a scene; `Scene.body`, `Scene.fixed` and `Scene.kinematic` make them.

    Attributes
    ----------
    name : str
    index : int
        Its place in the arrays of a solution.
    kind : Kind
    shape : Shape
    material : Material
    position : (2,) or (3,)
        Of the origin of the shape's frame [m].
    turn : float or (4,)
        Angle [rad], or unit quaternion (w, x, y, z).
    velocity : (2,) or (3,)
        Of the centre of mass [m/s]; of a body that is fixed or kinematic, of the origin.
    spin : float or (3,)
        Angular velocity, in the axes of the world [rad/s].
    mass, density : float or None
        [kg], [kg/m^3] (in the plane [kg/m^2]); one of them, for a dynamic body.
    inertia : float or (3, 3) or None
        About the centre of mass, in the shape's axes [kg m^2]; None: of the shape, its mass spread evenly.
    surface_velocity : (2,) or (3,) or None
        Of the surface in the body's axes [m/s]: a belt that runs over it.
    motion : callable or None
        Of a kinematic body: t -> position, or (position, turn).
    """

    name: str
    index: int
    kind: Kind
    shape: Shape
    material: Material
    position: np.ndarray
    turn: Any
    velocity: np.ndarray
    spin: Any
    mass: float | None = None
    density: float | None = None
    inertia: Any = None
    surface_velocity: np.ndarray | None = None
    motion: Callable[[float], Any] | None = None

    def __repr__(self) -> str:
        return f"Body({self.name!r}, {self.kind.name.lower()}, {self.shape!r})"


@dataclass(frozen=True, eq=False)
class Joint:
    """What holds two bodies together; `Scene.joint`, `Scene.hinge`, `Scene.slider` and their like make it.

    Attributes
    ----------
    name : str
    index : int
        Its place in the arrays of a solution.
    a, b : Body
    at : (2,) or (3,)
        Where it is at the start [m].
    kind : str
        Of joint_kinds.py: "joint" shares a point.
    axes : (2, 2) or (3, 3)
        Its frame on the first body at the start, in the axes of the world, an axis a row; the first one is its own.
    axes_b : (2, 2) or (3, 3)
        That on the second body, the same but of a universal joint.
    """

    name: str
    index: int
    a: Body
    b: Body
    at: np.ndarray
    kind: str
    axes: np.ndarray
    axes_b: np.ndarray

    @property
    def axis(self) -> np.ndarray:
        """The axis of the joint at the start, a unit vector in the axes of the world."""
        return self.axes[0]

    def __repr__(self) -> str:
        return f"{self.kind.capitalize()}({self.name!r}, {self.a.name!r}, {self.b.name!r})"


@dataclass(frozen=True, eq=False)
class Spring:
    """A spring with a damper between two bodies; `Scene.spring` and `Scene.torsion_spring` make it.

    Attributes
    ----------
    name : str
    a, b : Body
    at_a, at_b : (2,) or (3,) array, or None
        Where its ends are at the start [m]; None: at the centres of mass.
    stiffness, damping : float
        [N/m], [N s/m]; of a torsion spring [N m/rad], [N m s/rad].
    length : float or None
        Without a force [m], of a torsion spring the angle of b against a [rad]; None: that at the start.
    is_torsion : bool
    """

    name: str
    a: Body
    b: Body
    at_a: np.ndarray | None
    at_b: np.ndarray | None
    stiffness: float
    damping: float
    length: float | None
    is_torsion: bool = False

    def __repr__(self) -> str:
        return f"Spring({self.name!r}, {self.a.name!r}, {self.b.name!r}, {self.stiffness:g}, {self.damping:g})"


@dataclass(frozen=True, eq=False)
class Force:
    """What is applied to a body; `Scene.force` makes it.

    Attributes
    ----------
    body : Body
    value : (2,) or (3,) array, or callable
        Force in the axes of the world [N], or a function f(t, bodies) of the force, or of (force, torque).
    at : (2,) or (3,) array, or None
        The point of the body at which it acts, where that is at the start [m]; None: the centre of mass.
    """

    body: Body
    value: np.ndarray | Callable[..., Any]
    at: np.ndarray | None

    def __repr__(self) -> str:
        return f"Force({self.body.name!r}, {getattr(self.value, '__name__', self.value)})"
