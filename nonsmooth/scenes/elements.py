"""What a scene holds: bodies, the points that they share, springs between them, forces on them.

`Scene` makes them, checked; each is a description, which no run changes.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from enum import IntEnum
from typing import Any

import numpy as np

from nonsmooth.checks.arrays import as_non_negative, as_number, as_positive
from nonsmooth.errors import InvalidInput, shown
from nonsmooth.scenes.joint_friction import JointFriction
from nonsmooth.scenes.joint_kinds import coordinate_rows
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
    centre : (2,) or (3,) or None
        Of mass, in the shape's frame [m]; None: of the shape. It has an inertia about it.
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
    centre: np.ndarray | None = None
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
    limits : dict of str to (float, float)
        Of the "angle" [rad] and the "travel" [m] from the start, where there are some; of a rope of its "distance".
    motors : list of Motor
    friction : PinFriction or GuideFriction, or None
        Of a hinge, of a ball joint in space; of a slider.
    springs : list of JointSpring
    e : float
        Coefficient of restitution of the limits [-].
    at_b : (2,) or (3,), or None
        Of a rope or a distance: where it is on the second body at the start [m].
    length : float or None
        Of a rope or a distance [m].
    """

    name: str
    index: int
    a: Body
    b: Body
    at: np.ndarray
    kind: str
    axes: np.ndarray
    axes_b: np.ndarray
    limits: dict[str, tuple[float, float]] = field(default_factory=dict)
    motors: list[Motor] = field(default_factory=list)
    friction: JointFriction | None = None
    springs: list[JointSpring] = field(default_factory=list)
    e: float = 0.0
    at_b: np.ndarray | None = None
    length: float | None = None

    @property
    def is_tie(self) -> bool:
        """Whether it is a rope or a distance, whose bodies touch one another."""
        return self.length is not None

    def motor(self, *, torque: Any = None, force: Any = None, speed: Any = None, limit: float | None = None) -> Motor:
        """Put a motor on the angle or the travel of the joint.

        Parameters
        ----------
        torque, force : float or callable, optional
            What it gives about the axis [N m] or along it [N], to the second body, and the opposite to the first; the
            same at all times, or f(t, bodies) as of `Scene.force`.
        speed : float or callable, optional
            The rate that it holds as well as its limit lets it [rad/s], [m/s]; the same at all times, or f(t, bodies),
            which is asked once a step, for its end, with the bodies as they are at its beginning.
        limit : float, optional
            The largest torque [N m] or force [N] of a motor with a speed. Below it the speed is held exactly, also of
            0, a brake; beyond it the limit is what it gives.

        Returns
        -------
        Motor

        Raises
        ------
        InvalidInput
            Of a joint without one coordinate along its axis, of other than one of torque, force and speed, and for a
            speed without a limit.

        Examples
        --------
        >>> import nonsmooth as ns
        >>> scene = ns.Scene(gravity=(0, 0))
        >>> frame = scene.fixed(ns.Disc(0.1), name="frame")
        >>> wheel = scene.body(ns.Disc(0.2), mass=1.0, inertia=0.5, name="wheel")
        >>> scene.hinge("frame", "wheel", at=(0, 0)).motor(speed=3.0, limit=2.0)
        Motor(speed=3.0, limit=2.0)
        >>> spin = ns.simulate(scene, (0, 1), integrator=ns.MoreauJean(dt=0.01))["wheel"].spin
        >>> spin[[50, 100]].round(9).tolist()  # 4 rad/s^2 up to 3 rad/s
        [2.0, 3.0]
        """
        motor = as_motor(self, torque, force, speed, limit)
        self.motors.append(motor)
        return motor

    def spring(
        self, *, stiffness: float = 0.0, damping: float = 0.0, rest: float = 0.0, inertia: float = 0.0,
        along: str | None = None,
    ) -> JointSpring:  # fmt: skip
        """Put a spring, a damper and the inertia of a rotor on the angle or the travel s of the joint.

        The second body feels -k (s - s_r) - c ds/dt - a d^2s/dt^2, and the first one the opposite. It is implicit in
        the step, as `Scene.spring` is.

        Parameters
        ----------
        stiffness, damping : float
            k [N m/rad] and c [N m s/rad], of a travel [N/m] and [N s/m].
        rest : float
            s_r, the coordinate without a force, from the start [rad], [m].
        inertia : float
            a [kg m^2], [kg]: what a motor behind gears of ratio n adds, n^2 times the inertia of its rotor. It resists
            the acceleration of the coordinate alone; what the rotor weighs is part of the first body.
        along : {"angle", "travel"}, optional
            Of a joint that has both.

        Returns
        -------
        JointSpring

        Raises
        ------
        InvalidInput
            Of a joint without such a coordinate, for numbers that are negative, and where all are 0.

        Examples
        --------
        >>> import nonsmooth as ns
        >>> scene = ns.Scene(gravity=(0, 0))
        >>> frame = scene.fixed(ns.Disc(0.1), name="frame")
        >>> wheel = scene.body(ns.Disc(0.2), mass=1.0, inertia=0.5, name="wheel")
        >>> scene.hinge("frame", "wheel", at=(0, 0), name="hub").spring(stiffness=2.0, rest=0.1, inertia=0.5)
        JointSpring(stiffness=2, damping=0, rest=0.1, inertia=0.5)
        >>> angle = ns.simulate(scene, (0, 2), integrator=ns.MoreauJean(dt=1e-3)).joint("hub").angle[-1]
        >>> abs(angle - 0.1 * (1 - np.cos(2 * 2**0.5))) < 1e-6
        np.True_
        """
        spring = as_joint_spring(self, stiffness, damping, rest, inertia, along)
        self.springs.append(spring)
        return spring

    @property
    def axis(self) -> np.ndarray:
        """The axis of the joint at the start, a unit vector in the axes of the world."""
        return self.axes[0]

    def __repr__(self) -> str:
        return f"{self.kind.capitalize()}({self.name!r}, {self.a.name!r}, {self.b.name!r})"


@dataclass(frozen=True, eq=False)
class Motor:
    """What drives a joint along its axis; `Joint.motor` makes it.

    Attributes
    ----------
    along : str
        "angle" or "travel".
    load : float or callable, or None
        Torque [N m] or force [N].
    speed : float or callable, or None
        [rad/s], [m/s].
    limit : float
        Of one with a speed [N m], [N].
    """

    along: str
    load: float | Callable[..., Any] | None
    speed: float | Callable[..., Any] | None
    limit: float

    @property
    def is_asked(self) -> bool:
        """Whether it is a function."""
        return callable(self.load) or callable(self.speed)

    def __repr__(self) -> str:
        if self.speed is not None:
            return f"Motor(speed={getattr(self.speed, '__name__', self.speed)}, limit={self.limit})"
        what = "torque" if self.along == "angle" else "force"
        return f"Motor({what}={getattr(self.load, '__name__', self.load)})"


@dataclass(frozen=True)
class JointSpring:
    """A spring, a damper and the inertia of a rotor on the coordinate of a joint; `Joint.spring` makes it.

    Attributes
    ----------
    along : str
        "angle" or "travel".
    stiffness, damping, inertia : float
        [N m/rad], [N m s/rad], [kg m^2]; of a travel [N/m], [N s/m], [kg].
    rest : float
        From the start [rad], [m].
    """

    along: str
    stiffness: float
    damping: float
    rest: float
    inertia: float

    def __repr__(self) -> str:
        numbers = (f"{name}={getattr(self, name):g}" for name in ("stiffness", "damping", "rest", "inertia"))
        return f"JointSpring({', '.join(numbers)})"


def along_axis(joint: Joint) -> list[str]:
    """The coordinates that a joint leaves free along its axis."""
    return [along for along in coordinate_rows(joint.kind, len(joint.at)) if along != "distance"]


def as_joint_spring(
    joint: Joint, stiffness: Any, damping: Any, rest: Any, inertia: Any, along: str | None
) -> JointSpring:
    """A spring of a joint, checked."""
    name, free = f"the spring of {joint.name}", along_axis(joint)
    wanted = free[0] if along is None and len(free) == 1 else along
    if wanted not in free:
        has = " and ".join(free) or "no angle or travel"
        raise InvalidInput(f"{name} has along={shown(along)}, and a {joint.kind} joint has {has} along its axis")
    k, c, a = (as_non_negative(f"{what} of {name}", value)
               for what, value in (("stiffness", stiffness), ("damping", damping), ("inertia", inertia)))  # fmt: skip
    if k == c == a == 0.0:
        raise InvalidInput(f"{name} needs stiffness=, damping= or inertia=; got none")
    return JointSpring(wanted, k, c, as_number(f"rest of {name}", rest), a)


def as_motor(joint: Joint, torque: Any, force: Any, speed: Any, limit: Any) -> Motor:
    """A motor of a joint, checked."""
    name, free = f"the motor of {joint.name}", along_axis(joint)
    given = {"torque": torque, "force": force, "speed": speed}
    asked = [what for what, value in given.items() if value is not None]
    if len(asked) != 1:
        raise InvalidInput(f"{name} needs one of torque=, force= and speed=; got {', '.join(asked) or 'none'}")
    wanted = {"torque": "angle", "force": "travel"}.get(asked[0], free[-1] if free else "angle")
    if wanted not in free or (asked[0] == "speed" and len(free) > 1):
        has = " and ".join(free) or "no angle or travel"
        raise InvalidInput(f"{name} has {asked[0]}=, and a {joint.kind} joint has {has} along its axis")
    value = given[asked[0]]
    if not callable(value):
        value = as_number(f"{asked[0]} of {name}", value)
    if asked[0] != "speed":
        if limit is not None:
            raise InvalidInput(f"{name} has {asked[0]}= and limit=; a limit is one of a motor with speed=")
        return Motor(wanted, value, None, 0.0)
    if limit is None:
        raise InvalidInput(f"{name} needs limit=, the largest it may give; a kinematic body moves whatever it takes")
    return Motor(wanted, None, value, as_positive(f"limit of {name}", limit))


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
