"""The film of a scene: parts of shapes, poses of centres of mass, contacts with the impulses of their last step.

Only records are shown, none between two. A frame at which nothing has been stepped yet, the first, has no contacts.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from nonsmooth.drawing.facets import has_facets, quarters_of, triangles_of
from nonsmooth.drawing.joint_axes import lines_on
from nonsmooth.drawing.planar_bodies import rounded
from nonsmooth.drawing.player.film import Body, Contacts, Curve, Film, Shape, ShapeKind
from nonsmooth.drawing.player.solution_film import RECORDS_SHOWN, ledger_curves
from nonsmooth.drawing.plots import nearest_records
from nonsmooth.mechanics.system import ContactMode
from nonsmooth.results.recorded import CONTACTS
from nonsmooth.results.scene_contacts import SceneContacts
from nonsmooth.results.spring_forces import end_of
from nonsmooth.results.summary import worst_place
from nonsmooth.scenes import scene as scenes
from nonsmooth.scenes.elements import Joint
from nonsmooth.scenes.materials import Material
from nonsmooth.scenes.parts import Part, parts_of
from nonsmooth.scenes.places import ORIGIN, compose, place_of, rotate
from nonsmooth.scenes.shape_rows import BOX, CAPSULE, HALF_PLANE, SPHERE
from nonsmooth.scenes.shapes import PLANAR

if TYPE_CHECKING:
    from nonsmooth.results.scene_solution import SceneSolution

POSES_SHOWN = 500_000  # chosen: of all bodies in all frames, 1000 bodies over 500 frames: what a browser plays fluently
AXIS_REACH = 0.5  # chosen: of how far a moving body of the middle size reaches, that an axis does to either side
FEWEST = 60  # chosen: frames, however many bodies there are


def film_of_scene(solution: SceneSolution) -> Film:
    """The film of a run of a scene.

    Parameters
    ----------
    solution : SceneSolution

    Returns
    -------
    Film

    Raises
    ------
    InvalidInput
        When the solution was loaded without its scene.
    """
    bodies = tuple(body_of(body, solution.centres[body.index], solution.dim) for body in solution.bodies)
    bodies = with_lines(bodies, solution)
    records = records_shown(solution)
    found = contacts_at(solution, records)
    start = starts(solution, records)
    number, names = numbered(found, start)
    spans = spans_of(solution, records)
    contacts = contacts_of(found, start, number, spans)
    if solution.joints and CONTACTS in solution.recorded:
        contacts = with_joints(contacts, solution, records, spans, len(names))
        names = (*names, *solution.joint_names)
    return Film(
        title=title_of(solution),
        times=solution.t[records],
        bodies=bodies,
        position=solution.position[records],
        turn=solution.turn[records],
        contacts=contacts,
        contact_names=names,
        is_of_last_step=solution.stats.springs is None,
        curves=tuple(curves_of(solution, records, found, start)),
        about=about_of(solution),
        detail=detail_of(solution, records),
    )


def about_of(solution: SceneSolution) -> dict[str, str]:
    """How the run ended, its worst residual with the contact that it is of, and what was run."""
    stats = solution.stats
    what_was_run = {name: str(value) for name, value in solution.about.items() if name != "scene"}
    if stats.springs is not None:
        return {"outcome": solution.message, **what_was_run}
    missed = f"; {stats.missed} of {stats.steps} steps above tol = {stats.tol:g}" if stats.missed else ""
    residual = f"{stats.worst_residual:.2g}{worst_place(stats)}{missed}"
    return {"outcome": solution.message, "worst residual": residual, **what_was_run}


def title_of(solution: SceneSolution) -> str:
    """The name of the scene and its bodies."""
    return str(solution.about.get("scene", "")).removeprefix("Scene(").removesuffix(")")


def records_shown(solution: SceneSolution) -> np.ndarray:
    """The first record and those nearest to equally spaced instants: the fewer, the more bodies there are."""
    n = max(FEWEST, min(RECORDS_SHOWN, POSES_SHOWN // len(solution.names)))
    return np.unique(np.append(nearest_records(solution.t, n), 0))


def detail_of(solution: SceneSolution, records: np.ndarray) -> str:
    """What is left out."""
    n = len(solution.t)
    said = "every record is a frame" if len(records) == n else f"{len(records)} of {n} records are frames"
    if solution.stats.springs is not None:
        return f"{said}; forces are those at each frame"
    return f"{said}; impulses are those of the last step before each frame"


# --- bodies


def body_of(body: scenes.Body, centre: np.ndarray, dim: int) -> Body:
    """A body as it is drawn, in axes through its centre of mass."""
    frame = place_of(-centre, ORIGIN[dim][dim:])
    drawn = planar_shape if dim == PLANAR else spatial_shape
    shapes = tuple(drawn(part._replace(place=compose(frame, part.place))) for part in parts_of(body.shape, dim))
    is_fixed, is_guided = body.kind == scenes.Kind.FIXED, body.kind == scenes.Kind.KINEMATIC
    return Body(body.name, shapes, is_fixed, is_guided, words_of_material(body.material))


def with_lines(bodies: tuple[Body, ...], solution: SceneSolution) -> tuple[Body, ...]:
    """The bodies with axes and limits of the joints, as lines that go with them."""
    if not solution.joints:
        return bodies
    lines = lines_of_joints(bodies, solution.bodies, solution.joints, solution.centres)
    return tuple(
        replace(body, shapes=(*body.shapes, *(Shape(ShapeKind.POLYLINE, line) for line in own)))
        for body, own in zip(bodies, lines, strict=True)
    )


def lines_of_joints(
    drawn: Sequence[Body], bodies: Sequence[scenes.Body], joints: Sequence[Joint], centres: np.ndarray
) -> list[list[np.ndarray]]:
    """Axes and limits of the joints that go with each body, about its centre of mass; half as long as a usual body
    reaches."""
    pairs = zip(drawn, bodies, strict=True)
    reach = [reach_of(shapes) for shapes, body in pairs if body.kind is scenes.Kind.DYNAMIC]
    size, dim = AXIS_REACH * float(np.median(reach)) if reach else 0.0, centres.shape[1]
    return [[line - centres[body.index] for line in lines_on(body, joints, dim, size)] for body in bodies]


def reach_of(body: Body) -> float:
    """How far its shapes reach from its centre [m]."""
    return max(
        shape.radius
        + float(np.linalg.norm(shape.points, axis=1).max(initial=0.0))
        + (0.0 if shape.place is None else float(np.linalg.norm(shape.place[: shape.points.shape[1]])))
        for shape in body.shapes
    )


def words_of_material(material: Material) -> str:
    """Its name, or by which numbers it is told from others."""
    mu = f"{material.mu:g}" if isinstance(material.mu, float) else str(material.mu)
    return material.name or f"μ = {mu}, e = {material.e:g}"


def planar_shape(part: Part) -> Shape:
    """A half-plane, or the hull of its vertices made rounder."""
    at = part.place
    if part.kind == HALF_PLANE:
        return Shape(ShapeKind.HALF_PLANE, np.zeros((0, 2)), place=at)
    vertices = at[:2] + rotate(at[2], part.vertices)
    if len(vertices) == 1:
        return Shape(ShapeKind.DISC, vertices, part.radius)
    if len(vertices) == 2:
        return Shape(ShapeKind.CAPSULE if part.radius else ShapeKind.POLYLINE, vertices, part.radius)
    return Shape(ShapeKind.POLYGON, rounded(part, ORIGIN[2]))


def spatial_shape(part: Part) -> Shape:
    """A sphere, a capsule, a box, a half-space, or what is drawn by its facets."""
    at = part.place
    if has_facets(part):
        triangles = triangles_of(part)
        points = at[:3] + rotate(at[3:], triangles.reshape(-1, 3))
        return Shape(ShapeKind.FACETS, points, shade=quarters_of(part, triangles))
    if part.kind == SPHERE:
        return Shape(ShapeKind.SPHERE, at[None, :3], part.radius)
    if part.kind == CAPSULE:
        ends = np.outer([-1.0, 1.0], [0.0, 0.0, part.size[2]])
        return Shape(ShapeKind.CAPSULE, at[:3] + rotate(at[3:], ends), part.radius)
    if part.kind == BOX:
        return Shape(ShapeKind.BOX, np.array([part.size]), place=at)
    return Shape(ShapeKind.HALF_SPACE, np.zeros((0, 3)), place=at)


# --- contacts


def starts(solution: SceneSolution, records: np.ndarray) -> np.ndarray:
    """Where the contacts of each frame start (n_t + 1,), and their number."""
    return np.append(0, np.cumsum(np.diff(solution.all_contacts.offsets)[records]))


def contacts_at(solution: SceneSolution, records: np.ndarray) -> SceneContacts:
    """The contacts of the records, one behind the other."""
    every = solution.all_contacts
    is_shown = np.zeros(len(solution.t), bool)
    is_shown[records] = True
    rows = np.repeat(is_shown, np.diff(every.offsets))
    return every.at(rows, float(solution.t[-1]), solution.names)


def numbered(found: SceneContacts, start: np.ndarray) -> tuple[np.ndarray, tuple[str, ...]]:
    """Numbers of the contacts (n,), and their names: two bodies, and which of their contacts in a frame it is."""
    keys = np.stack([found.i, found.j, ranks(found, start)], axis=1)
    different, number = np.unique(keys, axis=0, return_inverse=True)
    has_more = {(i, j) for i, j, rank in different.tolist() if rank}
    names = [
        f"{found.names[i]} / {found.names[j]}" + (f" ({rank + 1})" if (i, j) in has_more else "")
        for i, j, rank in different.tolist()
    ]
    return number.reshape(-1), tuple(names)


def ranks(found: SceneContacts, start: np.ndarray) -> np.ndarray:
    """Of each contact how many of the same two bodies come before it in its frame."""
    frame = np.repeat(np.arange(len(start) - 1), np.diff(start))
    order = np.lexsort((found.j, found.i, frame))  # keeps the order within two bodies
    keys = np.stack([frame, found.i, found.j], axis=1)[order]
    is_first = np.ones(len(order), bool)
    is_first[1:] = (keys[1:] != keys[:-1]).any(axis=1)
    place = np.arange(len(order))
    rank = np.empty(len(order), int)
    rank[order] = place - np.maximum.accumulate(np.where(is_first, place, 0))
    return rank


def spans_of(solution: SceneSolution, records: np.ndarray) -> np.ndarray:
    """By what the columns P of each frame are multiplied to be impulses: 1, or of forces the time since the frame
    before, of which the player makes the forces again."""
    if solution.stats.springs is None:
        return np.ones(len(records))
    return np.diff(solution.t[records], prepend=solution.t[0])


def contacts_of(found: SceneContacts, start: np.ndarray, number: np.ndarray, spans: np.ndarray) -> Contacts:
    """The contacts of all frames, open ones too."""
    span = np.repeat(spans, np.diff(start))
    return Contacts(
        start=start,
        number=number,
        point=found.point,
        normal=found.normal,
        mode=found.mode,
        slip=np.zeros(len(found)),
        P_N=span * found.P_N,
        P_F=span[:, None] * (found.P - found.P_N[:, None] * found.normal),
        mu=found.mu,
    )


def with_joints(
    contacts: Contacts, solution: SceneSolution, records: np.ndarray, spans: np.ndarray, first: int
) -> Contacts:
    """The contacts with the joints behind those of each frame: what they give to their second bodies, as forces along
    no surface; their numbers go on from ``first``."""
    joints = solution.joints
    ends = [end_of(solution, joint.b, joint.at_b if joint.is_tie else joint.at)[0][records] for joint in joints]
    point, P = np.stack(ends, axis=1), spans[:, None, None] * solution.joint_impulses[records]
    n_t, n_j, d = P.shape
    size = np.linalg.norm(P, axis=2)
    normal = np.divide(P, size[..., None], out=np.tile(np.eye(d)[0], (n_t, n_j, 1)), where=size[..., None] > 0.0)
    is_slack = (size == 0.0) & np.array([joint.kind == "rope" for joint in joints])
    rows = n_t * n_j
    added = Contacts(
        start=n_j * np.arange(n_t + 1), number=np.tile(first + np.arange(n_j), n_t), point=point.reshape(rows, d),
        normal=normal.reshape(rows, d), mode=np.where(is_slack, ContactMode.OPEN, ContactMode.LOCKED).reshape(rows),
        slip=np.zeros(rows), P_N=size.reshape(rows), P_F=np.zeros((rows, d)), mu=np.zeros(rows),
    )  # fmt: skip
    frame = np.concatenate([np.repeat(np.arange(n_t), np.diff(part.start)) for part in (contacts, added)])
    order = np.argsort(frame, kind="stable")
    columns = {
        name: np.concatenate((getattr(contacts, name), getattr(added, name)))[order]
        for name in ("number", "point", "normal", "mode", "slip", "P_N", "P_F", "mu")
    }
    return Contacts(start=contacts.start + added.start, **columns)


# --- curves


def curves_of(solution: SceneSolution, records: np.ndarray, found: SceneContacts, start: np.ndarray) -> list[Curve]:
    """Energies and works since the start, numbers of contacts, and the worst figures since the frame before."""
    loaded = np.diff(np.append(0, np.cumsum(found.P_N > 0))[start])
    residual = worst_since(solution.residual, records)
    tiny = np.finfo(float).tiny
    exponent = np.log10(residual, out=np.full_like(residual, np.nan), where=residual > tiny)
    return [
        *ledger_curves({name: column[records] for name, column in solution.ledger.items()}),
        Curve("contacts", "candidates", "", np.diff(start)),
        Curve("contacts", "with an impulse", "", loaded),
        Curve("residual", "log10, worst since the frame before", "", exponent),
        Curve("penetration", "the deepest since the frame before", "m", worst_since(solution.penetration, records)),
    ]


def worst_since(values: np.ndarray, records: np.ndarray) -> np.ndarray:
    """The largest of the records after the frame before, up to its own."""
    return np.maximum.reduceat(values, np.append(0, records[:-1] + 1))
