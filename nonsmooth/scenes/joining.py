"""How joints get into a scene: what a user types, checked; what each kind holds stands in joint_kinds.py."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from nonsmooth.checks.arrays import as_floats, as_fraction, as_instance, as_positive, as_vector
from nonsmooth.errors import InvalidInput, shown
from nonsmooth.scenes.elements import Body, Joint, Kind
from nonsmooth.scenes.joint_friction import GuideFriction, PinFriction
from nonsmooth.scenes.joint_kinds import is_known
from nonsmooth.scenes.ranges import require_within
from nonsmooth.scenes.shapes import PLANAR, is_unit

SLACK = 1e-12  # chosen: of the length of a rope, that its ends may be farther apart: a rounding
SKEW = 1e-9  # chosen: cosine of two axes that are at right angles
FRICTIONS: dict[str, tuple[type, str]] = {  # of a hinge or a ball, and of a slider: what it must be
    "hinge": (PinFriction, "ns.PinFriction(mu=0.2, radius=0.01)"),
    "slider": (GuideFriction, "ns.GuideFriction(mu=0.2, length=0.1)"),
}


class Joining:
    """The joints of a `Scene`, which has the rest."""

    dim: int
    joints: list[Joint]

    def joint(
        self, a: Body | str, b: Body | str, *, at: ArrayLike, friction: PinFriction | None = None,
        name: str | None = None,
    ) -> Joint:  # fmt: skip
        """Let two bodies share a point: in the plane a pin about which they turn, in space a ball joint.

        The impulse that holds them together has any direction and does no work. Contacts between the two bodies are
        left out.

        Parameters
        ----------
        a, b : Body or str
            Bodies of this scene, or their names; one of them may be fixed or kinematic.
        at : (2,) or (3,)
            The point at the start, in the axes of the world [m]; it may lie outside of both shapes.
        friction : PinFriction, optional
            Of a ball joint, in space: against turns across what it bears. In the plane it is one of a `hinge`.
        name : str, optional
            "joint 2" for the third if left out.

        Returns
        -------
        Joint

        Raises
        ------
        InvalidInput
            For a body that is not there, a joint of a body with itself or of two that no impulse moves, a name that is
            taken, and a point that is none.

        Examples
        --------
        >>> import nonsmooth as ns
        >>> scene = ns.Scene(gravity=(0, -9.81))
        >>> hook = scene.fixed(ns.Disc(0.01), name="hook")
        >>> rod = scene.body(ns.Box(0.02, 1.0), mass=1.0, position=(0, -0.5), name="rod")
        >>> scene.joint("hook", "rod", at=(0, 0), name="pin")
        Joint('pin', 'hook', 'rod')
        """
        if friction is not None and self.dim == PLANAR:
            raise InvalidInput("friction of a joint in the plane is that of a pin; take scene.hinge(..., friction=...)")
        return self._join("joint", a, b, at, name, friction=friction)

    def hinge(
        self, a: Body | str, b: Body | str, *, at: ArrayLike, axis: ArrayLike | None = None,
        limits: ArrayLike | None = None, e: float = 0.0, friction: PinFriction | None = None, name: str | None = None,
    ) -> Joint:  # fmt: skip
        """Let two bodies turn against one another about an axis alone.

        Parameters
        ----------
        a, b, name
            As of `joint`.
        at : (2,) or (3,)
            A point of the axis at the start [m]; ``sol.joint(name)`` has the torque about it.
        axis : (3,)
            Its direction at the start, of any length, in space; it goes with both bodies. In the plane there is none.
        limits : (float, float), optional
            The least and the largest angle of b against a from the start [rad]; one of them may be infinite.
        e : float
            Newton's coefficient of restitution of the limits, 0 to 1 [-].
        friction : PinFriction, optional
            In proportion to what the pin bears across its axis.

        Returns
        -------
        Joint

        Raises
        ------
        InvalidInput
            As of `joint`, for an axis of length 0, or that is missing, and for limits between which the start is not.

        Examples
        --------
        >>> import nonsmooth as ns
        >>> scene = ns.Scene(gravity=(0, 0, -9.81))
        >>> post = scene.fixed(ns.Box(0.1, 0.1, 2.0), position=(-0.05, 0, 0), name="post")
        >>> leaf = scene.body(ns.Box(0.8, 0.04, 2.0), mass=20.0, position=(0.4, 0, 0), spin=(0, 0, 1.0),
        ...                   velocity=(0, 0.4, 0), name="leaf")
        >>> scene.hinge("post", "leaf", at=(0, 0, 0), axis=(0, 0, 1), name="door")
        Hinge('door', 'post', 'leaf')
        >>> sol = ns.simulate(scene, (0, 1), integrator=ns.MoreauJean(dt=1e-3))
        >>> round(float(sol["leaf"].spin[-1, 2]), 6)
        1.0
        """
        return self._join("hinge", a, b, at, name, axis, limits={"angle": limits}, friction=friction, e=e)

    def slider(
        self, a: Body | str, b: Body | str, *, axis: ArrayLike, at: ArrayLike | None = None,
        limits: ArrayLike | None = None, e: float = 0.0, friction: GuideFriction | None = None, name: str | None = None,
    ) -> Joint:  # fmt: skip
        """Let two bodies slide against one another along an axis, without a turn.

        Parameters
        ----------
        a, b, name
            As of `joint`.
        axis : (2,) or (3,)
            Its direction at the start, of any length; it goes with the first body.
        at : (2,) or (3,), optional
            The point of the second body at the start at which the joint acts [m]; its position, if left out.
        limits : (float, float), optional
            The least and the largest travel of b along the axis from the start [m]; one of them may be infinite.
        e : float
            Newton's coefficient of restitution of the limits, 0 to 1 [-].
        friction : GuideFriction, optional
            In proportion to what the guide bears.

        Returns
        -------
        Joint

        Raises
        ------
        InvalidInput
            As of `hinge`.
        """
        return self._join("slider", a, b, at, name, axis, limits={"travel": limits}, friction=friction, e=e)

    def fix(self, a: Body | str, b: Body | str, *, at: ArrayLike | None = None, name: str | None = None) -> Joint:
        """Hold two bodies together as one; ``sol.joint(name)`` has the force and the torque that it takes.

        Parameters and errors are those of `slider`.
        """
        return self._join("fix", a, b, at, name)

    def cylindrical(
        self, a: Body | str, b: Body | str, *, at: ArrayLike, axis: ArrayLike, limits: ArrayLike | None = None,
        angle_limits: ArrayLike | None = None, e: float = 0.0, name: str | None = None,
    ) -> Joint:  # fmt: skip
        """Let two bodies turn about an axis and slide along it, in space.

        Parameters and errors are those of `hinge`; ``limits`` are those of the travel [m], ``angle_limits`` [rad], and
        ``e`` is of both.
        """
        limited = {"angle": angle_limits, "travel": limits}
        return self._join("cylindrical", a, b, at, name, axis, limits=limited, e=e)

    def universal(
        self, a: Body | str, b: Body | str, *, at: ArrayLike, axis: ArrayLike, axis_b: ArrayLike,
        name: str | None = None,
    ) -> Joint:  # fmt: skip
        """Let two bodies share a point and turn about two axes at right angles, as those of a Cardan joint, in space.

        Parameters
        ----------
        a, b, at, name
            As of `joint`.
        axis, axis_b : (3,)
            The axis that goes with the first body and that of the second, at the start.

        Returns
        -------
        Joint

        Raises
        ------
        InvalidInput
            As of `hinge`, and for axes that are not at right angles.
        """
        return self._join("universal", a, b, at, name, axis, axis_b)

    def planar(
        self, a: Body | str, b: Body | str, *, axis: ArrayLike, at: ArrayLike | None = None, name: str | None = None
    ) -> Joint:
        """Let a point of the second body move in a plane of the first one, and turn about its normal, in space.

        Parameters
        ----------
        a, b, at, name
            As of `slider`.
        axis : (3,)
            The normal of the plane at the start; it goes with both bodies.

        Returns
        -------
        Joint

        Raises
        ------
        InvalidInput
            As of `hinge`.
        """
        return self._join("planar", a, b, at, name, axis)

    def slot(
        self, a: Body | str, b: Body | str, *, at: ArrayLike, axis: ArrayLike, limits: ArrayLike | None = None,
        e: float = 0.0, name: str | None = None,
    ) -> Joint:  # fmt: skip
        """Let a point of the second body slide along an axis of the first one: a pin in a slot.

        Parameters and errors are those of `slider`; the bodies turn freely.
        """
        return self._join("slot", a, b, at, name, axis, limits={"travel": limits}, e=e)

    def distance(
        self, a: Body | str, b: Body | str, *, at_a: ArrayLike | None = None, at_b: ArrayLike | None = None,
        name: str | None = None,
    ) -> Joint:  # fmt: skip
        """Hold two points of two bodies at the distance that they have at the start, as a rod without mass on two ball
        joints does; the bodies still touch.

        Parameters
        ----------
        a, b, name
            As of `joint`.
        at_a, at_b : (2,) or (3,), optional
            The points at the start, in the axes of the world [m]; the positions of the bodies, if left out.

        Returns
        -------
        Joint

        Raises
        ------
        InvalidInput
            As of `joint`, and for two points at one place.
        """
        return self._tie("distance", a, b, at_a, at_b, None, 0.0, name)

    def rope(
        self, a: Body | str, b: Body | str, *, at_a: ArrayLike | None = None, at_b: ArrayLike | None = None,
        length: float | None = None, e: float = 0.0, name: str | None = None,
    ) -> Joint:  # fmt: skip
        """Tie two points of two bodies by a rope without mass: they are never farther apart than its length.

        It pulls and never pushes, and its impulse is that of a contact on the way that is left; the bodies still touch.

        Parameters
        ----------
        a, b, name
            As of `joint`.
        at_a, at_b : (2,) or (3,), optional
            Its ends at the start, in the axes of the world [m]; the positions of the bodies, if left out.
        length : float, optional
            [m]; the distance of its ends at the start, taut, if left out.
        e : float
            Newton's coefficient of restitution of the rope as it becomes taut, 0 to 1 [-].

        Returns
        -------
        Joint

        Raises
        ------
        InvalidInput
            As of `joint`, and for ends that are farther apart than the length.

        Examples
        --------
        >>> import nonsmooth as ns
        >>> scene = ns.Scene(gravity=(0, -10.0))
        >>> hook = scene.fixed(ns.Disc(0.01), name="hook")
        >>> bob = scene.body(ns.Disc(0.05), mass=1.0, position=(0, -0.2), name="bob")
        >>> scene.rope("hook", "bob", length=1.0, e=0.5, name="rope")
        Rope('rope', 'hook', 'bob')
        >>> sol = ns.simulate(scene, (0, 2), integrator=ns.MoreauJean(dt=1e-3))
        >>> round(float(sol["bob"].position[:, 1].min()), 9)
        -1.0
        """
        return self._tie("rope", a, b, at_a, at_b, length, e, name)

    def _tie(self, kind: str, a: Any, b: Any, at_a: Any, at_b: Any, length: Any, e: Any, name: Any) -> Joint:
        """A rope or a distance, checked."""
        name, first, second = self._pair(kind, a, b, name)
        ends = [
            body.position.copy() if at is None else require_within(what, as_vector(what, at, self.dim), "m")
            for body, at, what in ((first, at_a, f"at_a of {name}"), (second, at_b, f"at_b of {name}"))
        ]
        apart = float(np.linalg.norm(ends[1] - ends[0]))
        length = as_positive(f"length of {name}", apart if length is None else length, "m")
        if apart > length * (1.0 + SLACK):
            raise InvalidInput(f"the ends of {name} are {apart:g} m apart, and it is {length:g} m long")
        limits = {"distance": (-math.inf, length)} if kind == "rope" else {}
        axes, e = np.eye(self.dim), as_fraction(f"e of {name}", e)
        joint = Joint(
            name, len(self.joints), first, second, ends[0], kind, axes, axes, limits, e=e, at_b=ends[1], length=length
        )
        self.joints.append(joint)
        return joint

    def _pair(self, kind: str, a: Any, b: Any, name: Any) -> tuple[str, Body, Body]:
        """The name of a joint and its bodies, checked."""
        name = f"joint {len(self.joints)}" if name is None else name
        if not isinstance(name, str) or not name:
            raise InvalidInput(f"the name of a joint must be a text; got {shown(name)}")
        if any(joint.name == name for joint in self.joints):
            raise InvalidInput(f"there is a joint {name!r} already; names of joints must differ")
        if not is_known(kind, self.dim):
            raise InvalidInput(f"{name} is a {kind} joint, which is one of space; the scene lies in the plane")
        first, second = (self._own(name, body) for body in (a, b))
        if first is second:
            raise InvalidInput(f"{name} joins {first.name} to itself; a joint is one of two bodies")
        if Kind.DYNAMIC not in (first.kind, second.kind):
            raise InvalidInput(
                f"{name} joins {first.name} and {second.name}, and no impulse moves either; one of them must be "
                "dynamic, as scene.body makes it"
            )
        return name, first, second

    def _join(
        self, kind: str, a: Any, b: Any, at: Any, name: Any, axis: Any = None, axis_b: Any = None,
        limits: dict[str, Any] | None = None, friction: Any = None, e: Any = 0.0,
    ) -> Joint:  # fmt: skip
        """A joint of a kind, checked."""
        name, first, second = self._pair(kind, a, b, name)
        place = second.position.copy() if at is None else as_vector(f"at of {name}", at, self.dim)
        axes = axes_b = self._axes(name, kind, axis)
        if kind == "universal":
            axes, axes_b = crossed_frames(name, axes[0], as_direction(f"axis_b of {name}", axis_b, self.dim))
        place = require_within(f"at of {name}", place, "m")
        if friction is not None:
            as_instance(f"friction of {name}", friction, *FRICTIONS.get(kind, FRICTIONS["hinge"]))
        asked = {along: pair for along, pair in (limits or {}).items() if pair is not None}
        given = {along: as_limits(f"limits of {name}", pair) for along, pair in asked.items()}
        if as_fraction(f"e of {name}", e) > 0.0 and not given:
            raise InvalidInput(f"e of {name} is that of its limits, and it has none; give limits=")
        joint = Joint(
            name, len(self.joints), first, second, place, kind, axes, axes_b, given, [], friction, e=as_fraction("e", e)
        )
        self.joints.append(joint)
        return joint

    def _axes(self, name: str, kind: str, axis: Any) -> np.ndarray:
        """The frame of a joint; of one without an axis that of the world."""
        if kind in ("joint", "fix"):
            return np.eye(self.dim)
        if kind == "hinge" and self.dim == PLANAR:
            if axis is not None:
                raise InvalidInput(f"{name} turns in the plane, about no other axis; leave out axis=")
            return np.eye(self.dim)
        return frame_of(as_direction(f"axis of {name}", axis, self.dim))

    def _own(self, name: str, body: Any, does: str = "joins") -> Body:
        raise NotImplementedError


def as_direction(name: str, value: Any, dim: int) -> np.ndarray:
    """A unit vector; one that is given stays as it is, to the last bit."""
    if value is None:
        raise InvalidInput(f"{name} is missing; give {dim} numbers, as {(0.0,) * (dim - 1) + (1.0,)}")
    vector = as_vector(name, value, dim)
    size = np.abs(vector).max()
    if size == 0.0:
        raise InvalidInput(f"{name} must have a length; got {shown(value)}")
    return vector if is_unit(vector) else vector / size / np.linalg.norm(vector / size)


def as_limits(name: str, value: Any) -> tuple[float, float]:
    """A least and a largest coordinate, with 0, that of the start, between them."""
    pair = as_floats(name, value)
    if pair.shape != (2,) or np.isnan(pair).any():
        raise InvalidInput(f"{name} must be two numbers, the least and the largest; got {shown(value)}")
    low, high = pair.tolist()
    if not low <= 0.0 <= high or low == high:
        raise InvalidInput(f"{name} must have the start, 0, between them; got {low:g} and {high:g}")
    return low, high


def frame_of(axis: np.ndarray) -> np.ndarray:
    """A right-handed frame, an axis a row, whose first one this is."""
    if len(axis) == PLANAR:
        return np.array([axis, [-axis[1], axis[0]]])
    across = np.eye(3)[np.argmin(np.abs(axis))]
    f = np.cross(axis, across)
    f /= math.sqrt(f @ f)
    return np.array([axis, f, np.cross(axis, f)])


def crossed_frames(name: str, axis: np.ndarray, axis_b: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The frames of a joint with two axes."""
    if abs(axis @ axis_b) > SKEW:
        angle = math.degrees(math.acos(min(1.0, abs(axis @ axis_b))))
        raise InvalidInput(f"the axes of {name} must be at right angles; they are at {angle:.6g} degrees")
    second = axis_b - (axis @ axis_b) * axis
    second /= math.sqrt(second @ second)
    third = np.cross(axis, second)
    return np.array([axis, second, third]), np.array([second, third, axis])
