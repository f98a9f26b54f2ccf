"""The shapes of bodies, in the plane and in space [m].

A bounded shape is given in a frame of its own: the body's ``position`` is where the origin of this frame is put. The
centre of mass, about which the body turns, need not lie there: an arch stone may be a polygon in the coordinates of the
drawing, put at (0, 0).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from nonsmooth.checks.arrays import as_floats, as_listed, as_number, as_vector
from nonsmooth.errors import InvalidInput, shown
from nonsmooth.numerics.rounding import EPS
from nonsmooth.scenes.convex_hull import convex_hull
from nonsmooth.scenes.ranges import FARTHEST_PLACE, as_length, require_within

PLANAR, SPATIAL = 2, 3  # defined: coordinates of a point
# chosen: relative to the extent of a polygon: turns and edges below it are taken for roundings of straight lines
STRAIGHT = 1e-9
FLATTEST = (
    1e-6  # chosen: thickness of a set of points, of its largest width, below which it has no faces worth the name
)
MOST_PARTS_NAMED = 8  # chosen: parts of a Compound that its text names
UNIT = 1e-6  # chosen: by which the length of a quaternion, or a full turn, may miss what it should be
OF_UNIT_LENGTH = 8 * EPS  # derived: what products, a root and a quotient leave of the square of a unit vector


class Shape:
    """What a body looks like to others.

    Attributes
    ----------
    dim : tuple of int
        2 for the plane, 3 for space, or both.
    is_bounded : bool
        Half-planes and half-spaces are not.
    has_mass : bool
        What is not bounded has none, nor has a segment, or what is made of one: it is fixed or moves as it is told.
    """

    dim: ClassVar[tuple[int, ...]]
    is_bounded: ClassVar[bool] = True
    has_mass: ClassVar[bool] = True


@dataclass(frozen=True)
class Disc(Shape):
    """A disc about the origin.

    Parameters
    ----------
    radius : float
        [m]
    """

    dim = (PLANAR,)
    radius: float

    def __post_init__(self) -> None:
        _set_positive(self, "radius")


@dataclass(frozen=True)
class Sphere(Shape):
    """A ball about the origin.

    Parameters
    ----------
    radius : float
        [m]
    """

    dim = (SPATIAL,)
    radius: float

    def __post_init__(self) -> None:
        _set_positive(self, "radius")


@dataclass(frozen=True, init=False)
class Box(Shape):
    """A rectangle or a cuboid about the origin, its edges along the axes.

    Parameters
    ----------
    *lengths : float
        Of the edges, two in the plane and three in space [m].

    Examples
    --------
    >>> import nonsmooth as ns
    >>> ns.Box(0.2, 0.1).lengths
    (0.2, 0.1)
    """

    lengths: tuple[float, ...]

    def __init__(self, *lengths: float) -> None:
        if len(lengths) == 1 and isinstance(lengths[0], Sequence | np.ndarray):
            lengths = tuple(lengths[0])
        if len(lengths) not in (PLANAR, SPATIAL):
            raise InvalidInput(f"Box takes two lengths in the plane or three in space [m]; got {len(lengths)}")
        names = (f"lengths[{k}]" for k in range(len(lengths)))
        checked = tuple(as_length(name, length) for name, length in zip(names, lengths, strict=True))
        object.__setattr__(self, "lengths", checked)

    @property
    def dim(self) -> tuple[int, ...]:  # type: ignore[override]
        """Of the plane or of space, by the number of lengths."""
        return (len(self.lengths),)

    def __repr__(self) -> str:
        return f"Box({', '.join(f'{length:g}' for length in self.lengths)})"


@dataclass(frozen=True)
class Capsule(Shape):
    """All points within a radius of a straight piece along the x-axis whose middle is the origin.

    Parameters
    ----------
    length : float
        Of the straight piece [m].
    radius : float
        [m]
    """

    dim = (PLANAR, SPATIAL)
    length: float
    radius: float

    def __post_init__(self) -> None:
        _set_positive(self, "length")
        _set_positive(self, "radius")


@dataclass(frozen=True, init=False, eq=False)
class Polygon(Shape):
    """A convex polygon, in any frame.

    Parameters
    ----------
    vertices : array_like (k, 2)
        In either sense of turning [m].
    radius : float
        By which it is rounded: all points within this distance of the polygon [m].

    Raises
    ------
    InvalidInput
        For fewer than three vertices, and a polygon that is not convex: ``Compound`` is made of several.
    """

    dim = (PLANAR,)
    vertices: np.ndarray
    radius: float

    def __init__(self, vertices: Any, radius: float = 0.0) -> None:
        object.__setattr__(self, "vertices", as_convex(vertices))
        object.__setattr__(self, "radius", require_within("radius", as_number("radius", radius, "m"), "m"))
        if self.radius < 0:
            raise InvalidInput(f"radius must not be negative; got {self.radius:g} m")

    def __repr__(self) -> str:
        return f"Polygon({len(self.vertices)} vertices)"


@dataclass(frozen=True)
class Cylinder(Shape):
    """A cylinder about the x-axis, with flat ends; its middle is the origin.

    Parameters
    ----------
    radius : float
        [m]
    length : float
        [m]
    """

    dim = (SPATIAL,)
    radius: float
    length: float

    def __post_init__(self) -> None:
        _set_positive(self, "radius")
        _set_positive(self, "length")


@dataclass(frozen=True)
class Ellipsoid(Shape):
    """An ellipsoid about the origin: (x/a)^2 + (y/b)^2 + (z/c)^2 <= 1.

    Parameters
    ----------
    a, b, c : float
        Half axes [m].
    """

    dim = (SPATIAL,)
    a: float
    b: float
    c: float

    def __post_init__(self) -> None:
        for name in ("a", "b", "c"):
            _set_positive(self, name)


@dataclass(frozen=True, init=False, eq=False)
class Polyhedron(Shape):
    """The convex hull of points, in any frame.

    Parameters
    ----------
    points : array_like (k, 3)
        Those that are no corners of the hull are left out [m].

    Attributes
    ----------
    vertices : (n, 3)
        The corners of the hull [m].
    faces : tuple of tuple of int
        Their corners, counterclockwise from outside.

    Raises
    ------
    InvalidInput
        For points that lie in a plane, and a hull of more than 200 corners.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> ns.Polyhedron([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)])
    Polyhedron(4 corners, 4 faces)
    """

    dim = (SPATIAL,)
    vertices: np.ndarray
    faces: tuple[tuple[int, ...], ...]

    def __init__(self, points: Any) -> None:
        vertices, faces = convex_hull(as_points(points))
        object.__setattr__(self, "vertices", vertices)
        object.__setattr__(self, "faces", faces)

    def __repr__(self) -> str:
        return f"Polyhedron({len(self.vertices)} corners, {len(self.faces)} faces)"


def polyhedron_of(vertices: np.ndarray, faces: tuple[tuple[int, ...], ...]) -> Polyhedron:
    """The polyhedron of corners and faces that are known to be those of a convex hull."""
    solid = object.__new__(Polyhedron)
    object.__setattr__(solid, "vertices", vertices)
    object.__setattr__(solid, "faces", faces)
    return solid


@dataclass(frozen=True, init=False, eq=False)
class Segment(Shape):
    """A straight wall without thickness, from a to b; fixed or moved as it is told, it has no mass.

    Parameters
    ----------
    a, b : array_like (2,)
        Its ends [m].
    """

    dim = (PLANAR,)
    has_mass = False
    a: np.ndarray
    b: np.ndarray

    def __init__(self, a: Any, b: Any) -> None:
        object.__setattr__(self, "a", require_within("a", as_vector("a", a, PLANAR), "m"))
        object.__setattr__(self, "b", require_within("b", as_vector("b", b, PLANAR), "m"))
        if not np.linalg.norm(self.b - self.a) > 0:
            raise InvalidInput(f"the ends of a Segment must differ; both are {shown(tuple(self.a.tolist()))}")

    def __repr__(self) -> str:
        return f"Segment({tuple(self.a.tolist())}, {tuple(self.b.tolist())})"


@dataclass(frozen=True, init=False, eq=False)
class _Half(Shape):
    is_bounded = has_mass = False
    normal: np.ndarray
    offset: float

    def __init__(self, normal: Any, offset: float = 0.0) -> None:
        vector = as_vector("normal", normal, self.dim[0])
        largest = float(np.abs(vector).max())
        if not largest > 0:
            raise InvalidInput("normal must not be zero; it points out of the ground")
        if not 1.0 / FARTHEST_PLACE <= largest <= FARTHEST_PLACE:  # its square is no number
            vector = vector / largest
        object.__setattr__(self, "normal", vector / np.linalg.norm(vector))
        object.__setattr__(self, "offset", require_within("offset", as_number("offset", offset, "m"), "m"))

    def __repr__(self) -> str:
        return f"{type(self).__name__}({tuple(self.normal.tolist())}, {self.offset:g})"


class HalfPlane(_Half):
    """Ground: all points x with normal . x <= offset.

    Parameters
    ----------
    normal : array_like (2,)
        Out of the ground; its length does not matter.
    offset : float
        [m]
    """

    dim = (PLANAR,)


class HalfSpace(_Half):
    """Ground: all points x with normal . x <= offset.

    Parameters
    ----------
    normal : array_like (3,)
        Out of the ground; its length does not matter.
    offset : float
        [m]
    """

    dim = (SPATIAL,)


@dataclass(frozen=True, init=False, eq=False)
class Compound(Shape):
    """Several shapes as one.

    Parameters
    ----------
    *parts : (shape, position) or (shape, position, turn)
        Shapes and where the origins of their frames are put [m]; turned by an angle [rad] in the plane and by a unit
        quaternion (w, x, y, z) in space. Where parts overlap, their masses add.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> dumbbell = ns.Compound((ns.Sphere(0.1), (-0.2, 0, 0)), (ns.Sphere(0.1), (0.2, 0, 0)))
    >>> dumbbell.dim
    (3,)
    """

    parts: tuple[tuple[Shape, np.ndarray, Any], ...]

    def __init__(self, *parts: Any) -> None:
        if not parts:
            raise InvalidInput("a Compound needs at least one (shape, position)")
        object.__setattr__(self, "parts", tuple(_as_part(k, part) for k, part in enumerate(parts)))
        if len(self.dim) > 1:
            raise InvalidInput("the parts of a Compound must all be planar, or all spatial")

    @property
    def dim(self) -> tuple[int, ...]:  # type: ignore[override]
        """Where all of its parts are put."""
        return tuple({len(position) for _, position, _ in self.parts})

    @property
    def has_mass(self) -> bool:  # type: ignore[override]
        """Whether all of its parts have."""
        return all(shape.has_mass for shape, _, _ in self.parts)

    def __repr__(self) -> str:
        if len(self.parts) > MOST_PARTS_NAMED:
            return f"Compound({len(self.parts)} parts)"
        return f"Compound({', '.join(repr(shape) for shape, _, _ in self.parts)})"


def _as_part(k: int, part: Any) -> tuple[Shape, np.ndarray, Any]:
    entries = as_listed(f"part {k} of a Compound", part, "a tuple (shape, position) or (shape, position, turn)")
    if len(entries) not in (2, 3) or not isinstance(entries[0], Shape):
        raise InvalidInput(f"part {k} of a Compound must be (shape, position) or (shape, position, turn)")
    shape = entries[0]
    if not shape.is_bounded or isinstance(shape, Compound):
        raise InvalidInput(f"part {k} of a Compound must be a bounded shape, and no Compound; got {shape!r}")
    position = require_within(f"position of part {k}", as_vector(f"position of part {k}", entries[1]), "m")
    if len(position) not in shape.dim:
        raise InvalidInput(f"position of part {k} must have {shape.dim[0]} entries; got {len(position)}")
    turn = entries[2] if len(entries) == 3 else None
    return shape, position, as_turn(f"turn of part {k}", turn, len(position))


def as_turn(name: str, value: Any, dim: int) -> Any:
    """An angle [rad] of the plane, or a unit quaternion (w, x, y, z) of space; None: not turned."""
    if dim == PLANAR:
        return 0.0 if value is None else as_number(name, value, "rad")
    if value is None:
        return np.array([1.0, 0.0, 0.0, 0.0])
    quaternion = as_vector(name, value, 4)
    length = float(np.linalg.norm(quaternion))
    if abs(length - 1.0) > UNIT:
        raise InvalidInput(f"{name} must be a unit quaternion (w, x, y, z); its length is {length:.6g}, divide by it")
    return quaternion if is_unit(quaternion) else quaternion / length


def as_spin(name: str, value: Any, dim: int) -> Any:
    """An angular velocity of the plane or of space [rad/s]; None: none."""
    if dim == PLANAR:
        return 0.0 if value is None else require_within(name, as_number(name, value, "rad/s"), "rad/s")
    return np.zeros(3) if value is None else require_within(name, as_vector(name, value, 3), "rad/s")


def is_unit(vector: np.ndarray) -> bool:
    """Whether a vector has the length 1 but for roundings; it stays as it is then, to the last bit."""
    return abs(float(vector @ vector) - 1.0) <= OF_UNIT_LENGTH


def as_convex(value: Any) -> np.ndarray:
    """The corners (k, 2) of a convex polygon, counterclockwise, or `InvalidInput`."""
    vertices = as_floats("vertices", value)
    if vertices.ndim != 2 or vertices.shape[1] != PLANAR or len(vertices) < 3:
        raise InvalidInput(f"vertices must be a (k, 2) array with k >= 3; got shape {vertices.shape}")
    if not np.isfinite(vertices).all():
        raise InvalidInput("vertices must be finite")
    require_within("vertices", vertices, "m")
    size = float(np.ptp(vertices, axis=0).max())
    edges = np.roll(vertices, -1, axis=0) - vertices
    turns = _cross(np.roll(edges, 1, axis=0), edges)
    if turns.sum() < 0:
        vertices = vertices[::-1].copy()
        edges = np.roll(vertices, -1, axis=0) - vertices
        turns = _cross(np.roll(edges, 1, axis=0), edges)
    if (np.linalg.norm(edges, axis=1) <= STRAIGHT * size).any():
        raise InvalidInput("two neighbouring vertices of a polygon are the same point; leave one out")
    angles = np.arctan2(turns, (np.roll(edges, 1, axis=0) * edges).sum(axis=1))
    if (turns <= STRAIGHT * size**2).any() or abs(angles.sum() - 2 * np.pi) > UNIT:
        raise InvalidInput("a Polygon must be convex with no vertex on a straight edge; make others of parts: Compound")
    return np.ascontiguousarray(vertices)


def as_points(value: Any) -> np.ndarray:
    """Points (k, 3) that do not lie in a plane, or `InvalidInput`."""
    points = as_floats("points", value)
    if points.ndim != 2 or points.shape[1] != SPATIAL or len(points) < 4:
        raise InvalidInput(f"points must be a (k, 3) array with k >= 4; got shape {points.shape}")
    if not np.isfinite(points).all():
        raise InvalidInput("points must be finite")
    require_within("points", points, "m")
    widths = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
    if not widths[2] > FLATTEST * widths[0]:
        raise InvalidInput("the points of a Polyhedron lie in a plane; give it a thickness")
    return points


def _cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]


def _set_positive(shape: Any, name: str) -> None:
    object.__setattr__(shape, name, as_length(name, getattr(shape, name)))
