"""URDF, descriptions of robots, as scenes: read by yourdfpy, the meshes by trimesh.

    links held by fixed joints         one body, with the mass, the centre and the inertia of all
    revolute, continuous, prismatic    `hinge`, `slider`, with limits; damping by `Joint.spring`, friction as a brake
    planar, floating                   `planar`, none
    collision                          primitives, and the convex hulls of meshes

A URDF has no gravity (here 9.81 m/s^2 down), no ground, and does not say whether its root stands still: one that is
called world or has no mass does, others move freely; fixed_base = 1 fixes them. Links of a robot often overlap where
it starts, and which of them touch is not in the file: none of one another, unless self_collision = 1. The start has all
coordinates 0, or at the nearer limit.
Source: https://wiki.ros.org/urdf/XML.
"""

from __future__ import annotations

import math
import xml.etree.ElementTree as ElementTree
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from nonsmooth.errors import InvalidInput, MissingExtra, nearest, said_by
from nonsmooth.scenes.convex_hull import MOST_CORNERS, hull_points
from nonsmooth.scenes.mass_properties import Mass
from nonsmooth.scenes.parts import ALONG_X
from nonsmooth.scenes.places import conjugate, place_of, quaternion_of, times
from nonsmooth.scenes.robots.links import WORLD, Coordinate, Link, add_links
from nonsmooth.scenes.scene import Scene
from nonsmooth.scenes.shapes import Box, Cylinder, Polyhedron, Shape, Sphere

GRAVITY = (0.0, 0.0, -9.81)  # chosen: [m/s^2]
OPTIONS = ("fixed_base", "self_collision")
MOVING = {"revolute": "hinge", "continuous": "hinge", "prismatic": "slider"}
# elements that are read here or are for the eye, by the element that they stand in
READ = {
    "robot": {"link", "joint", "material"},
    "link": {"inertial", "visual", "collision"},
    "joint": {"origin", "parent", "child", "axis", "limit", "dynamics"},
    "geometry": {"box", "cylinder", "sphere", "mesh"},
}


@dataclass
class Robot:
    """A URDF as yourdfpy has it, and what of it is not understood."""

    path: Path
    links: dict[str, Any]
    joints: list[Any]  # from the roots outward
    missed: dict[str, list[str]] = field(default_factory=dict)

    def miss(self, what: str, who: str) -> None:
        """Note what is not understood."""
        of = self.missed.setdefault(what, [])
        if who not in of:
            of.append(who)


def parsed(path: Path) -> Robot:
    """A URDF as yourdfpy has it.

    Raises
    ------
    MissingExtra
        Without yourdfpy.
    InvalidInput
        For what is no URDF, and for links that are no tree.
    """
    try:
        from yourdfpy import URDF
    except ImportError:
        raise MissingExtra('.urdf files need yourdfpy; pip install "nonsmooth[urdf]" brings it') from None
    try:
        robot = URDF.load(str(path), build_scene_graph=False, load_meshes=False).robot
    except Exception as error:  # whatever yourdfpy meets in the file
        raise InvalidInput(f"{path} is no URDF that yourdfpy reads: {said_by(error)}") from error
    links = {link.name: link for link in robot.links}
    return Robot(path, links, outward(path, links, robot.joints))


def outward(path: Path, links: dict[str, Any], joints: list[Any]) -> list[Any]:
    """The joints of a tree from its roots outward."""
    children = [joint.child for joint in joints]
    for joint in joints:
        for name in (joint.parent, joint.child):
            if name not in links:
                raise InvalidInput(
                    f"{path}: joint {joint.name} joins {name}, which is no link; {nearest(name, [*links])}"
                )
        if children.count(joint.child) > 1:
            raise InvalidInput(
                f"{path}: link {joint.child} has two parents; a URDF is a tree, hold loops by scene.joint"
            )
    known, found = {name for name in links if name not in children}, list[Any]()
    while ready := [joint for joint in joints if joint.parent in known and joint not in found]:
        found += ready
        known |= {joint.child for joint in ready}
    if len(found) < len(joints):
        raise InvalidInput(
            f"{path}: link {next(n for n in children if n not in known)} hangs on itself; a URDF is a tree"
        )
    return found


def values_of_urdf(path: Path) -> dict[str, float]:
    """The options, and the torques and forces of the joints that move along an axis."""
    return dict.fromkeys(OPTIONS, 0.0) | {joint.name: 0.0 for joint in parsed(path).joints if joint.type in MOVING}


def load_urdf(path: Path, values: Mapping[str, float]) -> tuple[Scene, list[str]]:
    """The scene of a URDF file, with torques [N m] and forces [N] on its joints, and what of it is not understood.

    Raises
    ------
    MissingExtra
        Without yourdfpy, or trimesh where there are meshes.
    InvalidInput
        For what is no URDF, a value that is none or beyond the effort of its joint, and a link without a mass.
    """
    robot = parsed(path)
    known = [*OPTIONS, *(joint.name for joint in robot.joints if joint.type in MOVING)]
    for name in values:
        if name not in known:
            raise InvalidInput(f"{path} has no joint {name} that moves along an axis; {nearest(name, known)}")
    note_rest(robot)
    scene = Scene(gravity=GRAVITY, name=path.stem)
    scene.built_from = dict.fromkeys(known, 0.0) | {name: float(value) for name, value in values.items()}
    links = links_of(robot, scene.built_from)
    touches = scene.built_from["self_collision"] != 0.0
    add_links(scene, links, lambda i, j: touches)
    if not touches and len(links) > 1:
        robot.miss("contacts of links with one another (self_collision=1 has them)", "")
    return scene, [f"{what}: {', '.join(of)}" if of != [""] else what for what, of in robot.missed.items()]


def links_of(robot: Robot, values: Mapping[str, float]) -> list[Link]:
    """The links, those that fixed joints hold together as one; of what stands still each shape by itself."""
    frames: dict[str, np.ndarray] = {}  # (4, 4), of the links in the world
    owners: dict[str, int] = {}  # the place in the list, or WORLD
    links: list[Link] = []
    children = {joint.child for joint in robot.joints}
    for name in [name for name in robot.links if name not in children]:
        frames[name], owners[name] = np.eye(4), WORLD
        if not (values["fixed_base"] or name == "world" or not weighs(robot, name)):
            owners[name] = len(links)
            links.append(Link(name, place_from(frames[name]), is_free=True))
    for joint in robot.joints:
        coordinate, frames[joint.child] = coordinate_of(robot, joint, frames[joint.parent], values)
        owners[joint.child] = owners[joint.parent] if joint.type == "fixed" else len(links)
        if joint.type != "fixed":
            links.append(Link(joint.child, place_from(frames[joint.child]), owners[joint.parent]))
            links[-1].coordinates = [] if coordinate is None else [coordinate]
            links[-1].is_free = coordinate is None
    for name, link in robot.links.items():
        shapes = shapes_of(robot, link, frames[name])
        if owners[name] == WORLD:
            links += [Link(name, at, shapes=[(shape, at)]) for shape, at in shapes]
            continue
        links[owners[name]].shapes += shapes
        if link.inertial is not None:
            links[owners[name]].masses.append(mass_of(link.inertial, frames[name]))
    return links


def weighs(robot: Robot, root: str) -> bool:
    """Whether a root has a mass, with what fixed joints hold to it."""
    held = {root}
    for joint in robot.joints:
        if joint.type == "fixed" and joint.parent in held:
            held.add(joint.child)
    inertials = [robot.links[name].inertial for name in held]
    return any(inertial is not None and (inertial.mass or 0.0) > 0.0 for inertial in inertials)


def place_from(matrix: np.ndarray) -> np.ndarray:
    """A place from a matrix (4, 4)."""
    return place_of(matrix[:3, 3], quaternion_of(matrix[:3, :3]))


def mass_of(inertial: Any, frame: np.ndarray) -> Mass:
    """The mass of a link in the axes of the world."""
    at = frame if inertial.origin is None else frame @ inertial.origin
    tensor = np.zeros((3, 3)) if inertial.inertia is None else inertial.inertia
    return Mass(float(inertial.mass or 0.0), at[:3, 3].copy(), at[:3, :3] @ tensor @ at[:3, :3].T)


def coordinate_of(
    robot: Robot, joint: Any, frame: np.ndarray, values: Mapping[str, float]
) -> tuple[Coordinate | None, np.ndarray]:
    """The coordinate of a joint, and the frame of its child at the start."""
    at = frame if joint.origin is None else frame @ joint.origin
    if joint.type in ("fixed", "floating"):
        return None, at
    axis = joint.axis / np.linalg.norm(joint.axis)
    one = Coordinate(joint.name, MOVING.get(joint.type, "planar"), at[:3, 3].copy(), at[:3, :3] @ axis)
    if joint.type == "planar":
        return one, at
    if joint.type not in MOVING:
        raise InvalidInput(f"{robot.path}: joint {joint.name} is of no known type; got {joint.type}")
    start = limit_coordinate(robot, joint, one)
    dynamics = joint.dynamics
    damping, friction = (float(getattr(dynamics, what, None) or 0.0) for what in ("damping", "friction"))
    if damping:
        one.springs.append({"damping": damping})
    one.friction, one.load = friction, values[joint.name]
    effort = joint.limit.effort if joint.limit is not None else None
    if one.load and effort is not None and abs(one.load) > effort:
        raise InvalidInput(f"{joint.name} must lie between {-effort:g} and {effort:g}, its effort; got {one.load:g}")
    moved = np.eye(4)
    if one.kind == "slider":
        moved[:3, 3] = start * axis
    else:
        moved[:3, :3] = turn_about(axis, start)
    return one, at @ moved


def limit_coordinate(robot: Robot, joint: Any, one: Coordinate) -> float:
    """Limit a coordinate; where it starts."""
    limit = joint.limit
    if limit is not None and limit.velocity:
        robot.miss("the largest speeds of joints", joint.name)
    if joint.type == "continuous":
        return 0.0
    if limit is None or limit.lower is None or limit.upper is None or limit.lower == limit.upper:
        robot.miss("joints without a lower and an upper limit that differ, which have none", joint.name)
        return 0.0
    start = min(max(0.0, limit.lower), limit.upper)
    if start != 0.0:
        robot.miss("a start outside of its limits, which is moved to the nearer one", joint.name)
    one.limits = (limit.lower - start, limit.upper - start)
    return float(start)


def turn_about(axis: np.ndarray, angle: float) -> np.ndarray:
    """The rotation (3, 3) about an axis."""
    c, s = math.cos(angle), math.sin(angle)
    skew = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    return np.eye(3) + s * skew + (1.0 - c) * (skew @ skew)


def shapes_of(robot: Robot, link: Any, frame: np.ndarray) -> list[tuple[Shape, np.ndarray]]:
    """What others touch of a link, with its places in the world."""
    found = []
    for collision in link.collisions:
        at = place_from(frame if collision.origin is None else frame @ collision.origin)
        shape = shape_of(robot, link.name, collision.geometry)
        if isinstance(shape, Cylinder):
            at = place_of(at[:3], times(at[3:], conjugate(ALONG_X)))
        if shape is not None:
            found.append((shape, at))
    return found


def shape_of(robot: Robot, name: str, geometry: Any) -> Shape | None:
    """The shape of a geometry; none of one that is left out."""
    if geometry.sphere is not None:
        return Sphere(geometry.sphere.radius)
    if geometry.box is not None:
        return Box(*geometry.box.size)
    if geometry.cylinder is not None:
        return Cylinder(geometry.cylinder.radius, geometry.cylinder.length)
    if geometry.mesh is None:
        return None  # its element is listed by its name
    try:
        points = points_of(robot, geometry.mesh)
        corners, out = hull_points(points, MOST_CORNERS)
        hull = Polyhedron(corners)
    except MissingExtra:
        raise
    except Exception as error:  # whatever trimesh and Qhull say of a file
        robot.miss("meshes that cannot be read, which are left out", f"{name} ({said_by(error)})")
        return None
    robot.miss("meshes, of which the convex hulls are taken", name)
    if out > 0.0:
        robot.miss(f"corners of hulls beyond {MOST_CORNERS}, which stand out", f"{name} by {out:.1e} m")
    return hull


def points_of(robot: Robot, mesh: Any) -> np.ndarray:
    """The corners (k, 3) of a mesh."""
    try:
        import trimesh
    except ImportError:
        raise MissingExtra('meshes of .urdf files need trimesh; pip install "nonsmooth[urdf]" brings it') from None
    loaded: Any = trimesh.load(mesh_file(robot.path, mesh.filename), force="mesh")
    return np.asarray(loaded.vertices, dtype=float) * (1.0 if mesh.scale is None else np.asarray(mesh.scale))


def mesh_file(path: Path, name: str) -> Path:
    """The file of a mesh: next to the URDF, or of package://, in a folder above it.

    Raises
    ------
    FileNotFoundError
        Where there is none.
    """
    plain = name.removeprefix("file://")
    tail = Path(plain.removeprefix("package://"))
    places = [path.parent / plain]
    for above in path.resolve().parents:
        places += [above / tail, above.joinpath(*tail.parts[1:])]
    found = next((place for place in places if place.is_file()), None)
    if found is None:
        raise FileNotFoundError(f"there is no file {name}")
    return found


def note_rest(robot: Robot) -> None:
    """Note the elements of a file that are not read, by what they stand in."""
    for parent in ElementTree.parse(robot.path).iter():
        if parent.tag in READ:
            for child in parent:
                if child.tag not in READ[parent.tag]:
                    who = parent.get("name") if parent.tag != "robot" else child.get("name") or child.get("reference")
                    robot.miss(f"elements <{child.tag}>", who or f"of <{parent.tag}>")
