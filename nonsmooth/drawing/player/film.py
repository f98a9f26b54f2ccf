"""What the player shows, whatever it was made from: bodies with poses, contacts, events and curves by frames.

A result class becomes watchable by one function that makes a `Film` of it and two entries in `views.py`: "film", that
function, and "view", ``drawing.player.page.show``. Lengths in m, angles in rad, times in s, impulses in N s.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum

import numpy as np

from nonsmooth.errors import InvalidInput


class ShapeKind(StrEnum):
    """What a body is drawn as, in its own frame."""

    DISC = "disc"  # points (1, 2): its centre; radius
    POLYGON = "polygon"  # points (k, 2): its corners, in order
    POLYLINE = "polyline"  # points (k, d)
    BENDING = "bending polyline"  # points (n_t, k, d): a spring; filled where it is closed
    CAPSULE = "capsule"  # points (2, d): the ends of its axis; radius
    BOX = "box"  # points (1, 3): half its edges
    SPHERE = "sphere"  # points (1, 3): its centre; radius
    FACETS = "facets"  # points (3 n, 3): corners of n triangles, counterclockwise from outside
    HALF_PLANE = "half-plane"  # y <= 0 of its frame; points (0, 2)
    HALF_SPACE = "half-space"  # z <= 0 of its frame; points (0, 3)


PLANAR = {ShapeKind.DISC, ShapeKind.POLYGON, ShapeKind.HALF_PLANE}
SPATIAL = {ShapeKind.BOX, ShapeKind.FACETS, ShapeKind.SPHERE, ShapeKind.HALF_SPACE}


class MarkKind(StrEnum):
    """What an event is marked as on the time line."""

    IMPACT = "impact"
    MODE_CHANGE = "mode change"
    INCONSISTENT = "inconsistent"
    INDETERMINATE = "indeterminate"
    USER = "user event"


@dataclass(frozen=True)
class Shape:
    """One convex piece, or one line, of a body."""

    kind: ShapeKind
    points: np.ndarray
    radius: float = 0.0
    place: np.ndarray | None = None  # of its frame in that of the body: (x, y, angle) or (x, y, z, q_0 ... q_3)
    shade: np.ndarray | None = None  # (n,) of facets: 1 is drawn light, -1 dark


@dataclass(frozen=True)
class Body:
    """A name, what is drawn, whether it belongs to the surroundings, which never move, or moves as it is told; what
    it is made of, in words."""

    name: str
    shapes: tuple[Shape, ...]
    is_fixed: bool = False
    is_guided: bool = False
    material: str = ""


@dataclass(frozen=True)
class Contacts:
    """The contacts of all frames, one after the other: those of frame k are start[k] : start[k + 1].

    Attributes
    ----------
    start : (n_t + 1,)
    number : (n,) which contact of the system it is, or of which pair of bodies
    point, normal : (n, d) where it acts, and the unit normal of the force upon the body it acts on [m, -]
    mode : (n,) ContactMode, and slip : (n,) sign of sliding, 0 in space and where it is not told
    P_N : (n,) and P_F : (n, d) impulses since the frame before, or of the last step; friction as a vector [N s]
    mu : (n,) coefficient of the cone; 0 draws none
    """

    start: np.ndarray
    number: np.ndarray
    point: np.ndarray
    normal: np.ndarray
    mode: np.ndarray
    slip: np.ndarray
    P_N: np.ndarray
    P_F: np.ndarray
    mu: np.ndarray


@dataclass(frozen=True)
class Mark:
    """An event: when, the first frame that shows what came of it, what it is in words; of a paradox what was chosen."""

    t: float
    frame: int
    kind: MarkKind
    text: str
    choice: str = ""


@dataclass(frozen=True)
class Curve:
    """A quantity over the frames; the curves of a group share a figure and a unit."""

    group: str
    name: str
    unit: str
    values: np.ndarray  # (n_t,)
    scale: float = 0.0  # of the quantity: what varies by less than a millionth of it is drawn as constant
    colour: str = ""  # that of the quantity in every figure; else the next of the cycle
    dashes: tuple[float, ...] = ()  # and gaps, in widths of the line


@dataclass(frozen=True)
class Film:
    """A motion that the player shows.

    Attributes
    ----------
    title : str
    times : (n_t,) of the frames, never falling: two of one instant are before and after an impact
    bodies : tuple of n_b Body
    position : (n_t, n_b, d) of the frames of the bodies; d = 2 is a planar film, d = 3 a spatial one
    turn : (n_t, n_b) angles, or in space (n_t, n_b, 4) unit quaternions, the real part first
    contacts : Contacts
    contact_names : tuple of str, by the numbers of contacts; none: they are called by their numbers
    is_of_last_step : whether impulses are those of the last step of each frame; else forces are made of them
    marks : tuple of Mark, in order of time
    curves : tuple of Curve
    about : what else is known of the run, in words by name
    detail : what of the run the film leaves out, one sentence
    """

    title: str
    times: np.ndarray
    bodies: tuple[Body, ...]
    position: np.ndarray
    turn: np.ndarray
    contacts: Contacts
    contact_names: tuple[str, ...] = ()
    is_of_last_step: bool = False
    marks: tuple[Mark, ...] = ()
    curves: tuple[Curve, ...] = ()
    about: Mapping[str, str] = field(default_factory=dict)
    detail: str = ""

    def __post_init__(self) -> None:
        n_t, n_b = len(self.times), len(self.bodies)
        d = self.position.shape[-1]
        if d not in (2, 3) or self.position.shape != (n_t, n_b, d) or not n_t:
            raise InvalidInput(
                f"position must be (n_t, n_b, d) = ({n_t}, {n_b}, 2 or 3) with n_t > 0; got {self.position.shape}"
            )
        turns = (n_t, n_b) if d == 2 else (n_t, n_b, 4)
        if self.turn.shape != turns:
            raise InvalidInput(f"turn must have the shape {turns} of a film in {d} dimensions; got {self.turn.shape}")
        for kind in {shape.kind for body in self.bodies for shape in body.shapes} & (SPATIAL if d == 2 else PLANAR):
            raise InvalidInput(f"a {kind} is no shape of a film in {d} dimensions")
        if self.contacts.start.shape != (n_t + 1,) or self.contacts.start[-1] != len(self.contacts.number):
            raise InvalidInput(f"start must count the contacts of {n_t} frames, from 0 to {len(self.contacts.number)}")
        if any(curve.values.shape != (n_t,) for curve in self.curves):
            raise InvalidInput(f"each curve must have a value for each of the {n_t} frames")

    @property
    def is_planar(self) -> bool:
        """Whether it is drawn in the plane."""
        return self.position.shape[-1] == 2


def no_contacts(n_t: int, d: int) -> Contacts:
    """Of a film without contacts."""
    vector, scalar = np.zeros((0, d)), np.zeros(0)
    return Contacts(np.zeros(n_t + 1, int), scalar, vector, vector, scalar, scalar, scalar, vector, scalar)
