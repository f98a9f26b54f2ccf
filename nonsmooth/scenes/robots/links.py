"""Links of a robot as bodies of a scene: what the readers of MJCF and URDF share.

A link hangs on its parent by coordinates, one behind the other: hinges, slides, a ball. One coordinate is one joint;
two slides and a turn in one plane that nothing drives are a `planar` joint; of others each but the last has a body
behind it, a carrier of a hundred thousandth of the mass and the inertia of the link, which touches nothing: that part
of its weight does not take the turns behind it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from itertools import combinations

import numpy as np

from nonsmooth.errors import InvalidInput
from nonsmooth.scenes.elements import Body, Joint, Kind
from nonsmooth.scenes.joining import SKEW
from nonsmooth.scenes.mass_properties import Mass, combined, rotation
from nonsmooth.scenes.materials import Material
from nonsmooth.scenes.places import ORIGIN, compose, inverse
from nonsmooth.scenes.scene import Scene
from nonsmooth.scenes.shapes import Compound, Shape, Sphere

CARRIER_PART = 1e-5  # measured: of the mass of a link, that of a carrier: with 1e-6 a humanoid that falls misses 1e-8
MARK = 0.2  # chosen: radius of what stands for a carrier or the world, of that of a ball like its link: it is drawn
SMALLEST_MARK = 1e-3  # chosen: radius of what stands for a link without a shape [m]
WORLD = -1  # code: in the place of a link


@dataclass
class Coordinate:
    """One way in which a link moves against its parent: of a hinge, a slider, or a ball ("joint")."""

    name: str
    kind: str
    at: np.ndarray  # where it is at the start, in the world [m]
    axis: np.ndarray
    limits: tuple[float, float] = (-math.inf, math.inf)  # from the start
    springs: list[dict[str, float]] = field(default_factory=list)  # arguments of `Joint.spring`
    friction: float = 0.0  # [N m], [N]
    load: float = 0.0  # what a motor gives

    @property
    def is_bare(self) -> bool:
        """Whether nothing acts along it."""
        return not (self.springs or self.friction or self.load or np.isfinite(self.limits).any())


@dataclass
class Link:
    """A rigid part of a robot, or, without coordinates and on the world, what stands still."""

    name: str
    place: np.ndarray  # of its frame in the world
    parent: int = WORLD  # the place of another one in the list, which is before it
    shapes: list[tuple[Shape, np.ndarray]] = field(default_factory=list)  # with their places in the world
    material: Material | None = None
    masses: list[Mass] = field(default_factory=list)  # about their centroids, in the axes of the world
    coordinates: list[Coordinate] = field(default_factory=list)
    is_free: bool = False

    @property
    def is_fixed(self) -> bool:
        """Whether it stands still."""
        return self.parent == WORLD and not self.coordinates and not self.is_free


def add_links(scene: Scene, links: Sequence[Link], touches: Callable[[int, int], bool]) -> list[Body]:
    """Add links to a scene, with their joints; the bodies of the links.

    Raises
    ------
    InvalidInput
        For a link that moves without a mass, with the cure.
    """
    bodies: list[Body] = []
    carriers: list[Body] = []
    is_held = any(link.coordinates and link.parent == WORLD for link in links)
    world = scene.fixed(Sphere(mark_of(links)), name=unused("world", scene)) if is_held else None
    for link in links:
        if link.is_fixed:
            shape, place = link.shapes[0]
            bodies.append(scene.fixed(shape, position=place[:3], turn=place[3:], material=link.material,
                                      name=unused(link.name, scene)))  # fmt: skip
            continue
        above, chain = world if link.parent == WORLD else bodies[link.parent], chain_of(link)
        whole = mass_of_link(link)
        for coordinate in chain[:-1]:
            name = unused(f"{link.name} on {coordinate.name}", scene)
            carriers.append(add_body(scene, link, scaled(whole, CARRIER_PART), name, Sphere(MARK * size_of(whole))))
            join(scene, above, carriers[-1], coordinate)
            above = carriers[-1]
        left = scaled(whole, 1.0 - CARRIER_PART * max(0, len(chain) - 1))
        bodies.append(add_body(scene, link, left, unused(link.name, scene), shape_of(link, whole)))
        if chain:
            join(scene, above, bodies[-1], chain[-1])
    marks = [*carriers, *([] if world is None else [world])]
    apart = [(bodies[i], bodies[j]) for i, j in combinations(range(len(links)), 2) if not touches(i, j)]
    apart += [(mark, body) for k, mark in enumerate(marks) for body in (*bodies, *marks[:k])]
    joined = scene.apart()
    scene.ignored += [
        pair for pair in apart
        if Kind.DYNAMIC in (pair[0].kind, pair[1].kind) and frozenset(pair) not in joined
    ]  # fmt: skip
    return bodies


def chain_of(link: Link) -> list[Coordinate]:
    """The coordinates of a link as joints: two bare slides and a turn about their normal are one, in a plane."""
    slides = [one for one in link.coordinates if one.kind == "slider"]
    hinges = [one for one in link.coordinates if one.kind == "hinge"]
    if len(link.coordinates) != 3 or len(slides) != 2 or len(hinges) != 1:
        return link.coordinates
    (turn,), is_level = hinges, max(abs(hinges[0].axis @ slide.axis) for slide in slides) <= SKEW
    is_plane = np.linalg.norm(np.cross(slides[0].axis, slides[1].axis)) > SKEW
    is_free = all(slide.is_bare for slide in slides) and not np.isfinite(turn.limits).any()
    if not (is_level and is_plane and is_free):
        return link.coordinates
    return [Coordinate(turn.name, "planar", turn.at, turn.axis, springs=turn.springs, friction=turn.friction,
                       load=turn.load)]  # fmt: skip


def mass_of_link(link: Link) -> Mass:
    """All of its masses together."""
    heavy = [part for part in link.masses if part.mass > 0.0]
    if not heavy:
        raise InvalidInput(
            f"link {link.name} moves and has no mass; give it one, or hold it to its parent without a joint"
        )
    return combined(heavy)


def scaled(mass: Mass, part: float) -> Mass:
    """A part of a mass, spread as it is."""
    return Mass(part * mass.mass, mass.centroid, part * mass.inertia)


def add_body(scene: Scene, link: Link, mass: Mass, name: str, shape: Shape) -> Body:
    """A body in the frame of a link, with a part of its mass."""
    R = rotation(link.place[3:])
    inertia = R.T @ mass.inertia @ R
    return scene.body(
        shape, position=link.place[:3], turn=link.place[3:], mass=mass.mass, material=link.material, name=name,
        centre=R.T @ (mass.centroid - link.place[:3]), inertia=0.5 * (inertia + inertia.T),
    )  # fmt: skip


def shape_of(link: Link, whole: Mass) -> Shape:
    """Its shapes as one, in its frame; without any, a ball as large as its mass is spread."""
    if not link.shapes:
        return Sphere(size_of(whole))
    back = inverse(link.place)
    own = [(shape, compose(back, place)) for shape, place in link.shapes]
    if len(own) == 1 and np.array_equal(own[0][1], ORIGIN[3]):
        return own[0][0]
    return Compound(*((shape, at[:3], at[3:] / np.linalg.norm(at[3:])) for shape, at in own))


def size_of(whole: Mass) -> float:
    """The radius of a ball of this mass and the mean of its moments [m]."""
    return max(SMALLEST_MARK, math.sqrt(2.5 * float(np.trace(whole.inertia)) / (3.0 * whole.mass)))


def mark_of(links: Sequence[Link]) -> float:
    """The radius of what stands for the world: that of the smallest link."""
    return MARK * min(size_of(mass_of_link(link)) for link in links if not link.is_fixed)


def join(scene: Scene, above: Body | None, body: Body, coordinate: Coordinate) -> Joint:
    """The joint of a coordinate, with what acts along it."""
    assert above is not None
    name = unused_joint(coordinate.name, scene)
    if coordinate.kind == "joint":
        return scene.joint(above, body, at=coordinate.at, name=name)
    limits = coordinate.limits if np.isfinite(coordinate.limits).any() else None
    limited = {} if coordinate.kind == "planar" else {"limits": limits}
    add = getattr(scene, coordinate.kind)
    joint: Joint = add(above, body, at=coordinate.at, axis=coordinate.axis, name=name, **limited)
    for spring in coordinate.springs:
        joint.spring(**spring)  # type: ignore[arg-type]
    if coordinate.friction > 0.0:
        joint.motor(speed=0.0, limit=coordinate.friction)
    if coordinate.load != 0.0:
        joint.motor(**{"force" if coordinate.kind == "slider" else "torque": coordinate.load})
    return joint


def unused(name: str, scene: Scene) -> str:
    """A name of a body that the scene does not have."""
    return first_unused(name, {body.name for body in scene.bodies})


def unused_joint(name: str, scene: Scene) -> str:
    """A name of a joint that the scene does not have."""
    return first_unused(name, {joint.name for joint in scene.joints})


def first_unused(name: str, taken: set[str]) -> str:
    """The name itself, or with a number."""
    return next(one for one in (name, *(f"{name} {k}" for k in range(2, len(taken) + 3))) if one not in taken)
