"""MJCF, the models of MuJoCo, as scenes: read as MuJoCo compiles them, and made of what a scene has.

    bodies that are welded to one another     one body, with the mass, the centre and the inertia of all
    hinge, slide, ball, free                  `hinge`, `slider`, `joint`, none; several of a body: links.py
    range, stiffness, damping, armature       limits, and `Joint.spring`
    frictionloss                              a brake, `motor(speed=0, limit=)`
    actuators without a state                 of a fixed gain and a bias that is affine in the joint: torque and spring
    geoms                                     primitives, meshes by their convex hulls, planes as half-spaces
    contype, conaffinity, exclude, parents    `Scene.ignored`
    friction, condim, priority                `Scene.pair`: the larger coefficients of two, as condim says
    connect, weld                             `joint`, `fix`

What MuJoCo has beyond that is listed by name, also what a later version of it may add: any number of a model that
differs from that of a plain one and is not read here. The start is qpos0, moved into the limits.
Source: MuJoCo, *XML Reference* and *Computation*, https://mujoco.readthedocs.io.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from nonsmooth.errors import InvalidInput, nearest
from nonsmooth.scenes.elements import Body
from nonsmooth.scenes.mass_properties import Mass
from nonsmooth.scenes.places import place_of
from nonsmooth.scenes.robots.geoms import Touching, geom_place, give_pairs, material_of, shape_of_geom
from nonsmooth.scenes.robots.links import WORLD, Coordinate, Link, add_links
from nonsmooth.scenes.robots.mujoco_model import Read, compiled, controls, is_of_joint, is_scalar, unit
from nonsmooth.scenes.robots.unread import note_rest
from nonsmooth.scenes.scene import Scene
from nonsmooth.scenes.shapes import Sphere

ALL_OF_A_LIMIT = 1e-9  # chosen: part of a range by which a start may miss it, which is none
OPEN_EQUALITY = 1e-6  # chosen: by which an equality may be open at the start [m], [rad]: digits of a file


def values_of_mjcf(path: Path) -> dict[str, float]:
    """The controls of a file, by the names of its actuators."""
    lib, model, _ = compiled(path)
    return dict.fromkeys(controls(lib, model), 0.0)


def load_mjcf(path: Path, values: Mapping[str, float]) -> tuple[Scene, list[str]]:
    """The scene of an MJCF file, with controls of its actuators, and what of the file is not understood.

    Raises
    ------
    MissingExtra
        Without mujoco.
    InvalidInput
        For a file that MuJoCo refuses, a control that is none or out of its range, and a link without a mass.
    """
    lib, model, said = compiled(path)
    data, names = lib.MjData(model), controls(lib, model)
    for name in values:
        if name not in names:
            raise InvalidInput(f"{path} has no actuator {name}; {nearest(name, [*names])}")
    read = Read(lib, model, data, {name: float(values.get(name, 0.0)) for name in names}, {}, {})
    require_ranges(read, names)
    move_into_limits(read)
    lib.mj_forward(model, data)
    gravity = np.zeros(3) if read.is_off("GRAVITY") else model.opt.gravity
    title = bytes(model.names).split(b"\0")[0].decode() or path.stem
    scene = Scene(gravity=gravity, name=title, dt=float(model.opt.timestep))
    scene.built_from = dict(read.ctrl)
    links, geoms, roots = links_of(read, names)
    touching = Touching(read)
    bodies = add_links(scene, links, lambda i, j: touching.touch(geoms[i], geoms[j], (links[i].name, links[j].name)))
    give_pairs(scene, read)
    lift(scene, read, roots, bodies)
    hold(scene, read, roots, bodies)
    note_rest(read)
    for warning in said:
        read.miss(f"MuJoCo warns: {warning}", "")
    return scene, [f"{what}: {', '.join(of)}" if of != [""] else what for what, of in read.missed.items()]


def require_ranges(read: Read, names: dict[str, int]) -> None:
    """Raise `InvalidInput` for a control that is no number, or out of the range of its actuator."""
    for name, k in names.items():
        low, high = read.model.actuator_ctrlrange[k] if read.model.actuator_ctrllimited[k] else (-math.inf, math.inf)
        if not low <= read.ctrl[name] <= high and read.ctrl[name] != 0.0:
            raise InvalidInput(f"control {name} must lie between {low:g} and {high:g}; got {read.ctrl[name]:g}")


def move_into_limits(read: Read) -> None:
    """Move the start, qpos0, into the limits of hinges and slides."""
    model, data = read.model, read.data
    for k in range(model.njnt):
        if is_scalar(read, k) and model.jnt_limited[k] and not read.is_off("LIMIT") and not read.is_off("CONSTRAINT"):
            at, (low, high) = model.jnt_qposadr[k], model.jnt_range[k]
            inside = min(max(data.qpos[at], low), high)
            if abs(inside - data.qpos[at]) > ALL_OF_A_LIMIT * (high - low):
                read.miss("a start outside of its limits, which is moved to the nearer one", read.name("joint", k))
            data.qpos[at] = inside


def links_of(read: Read, names: dict[str, int]) -> tuple[list[Link], list[list[int]], dict[int, int]]:
    """The links of a model, their geoms, and the link of each root of bodies that are welded to one another."""
    model, data = read.model, read.data
    links: list[Link] = []
    geoms: list[list[int]] = []
    roots: dict[int, int] = {}
    touching = Touching(read)
    for k in np.flatnonzero(model.body_weldid[model.geom_bodyid] == 0).tolist():
        if (shape := shape_of_geom(read, k)) is not None:
            links.append(Link(read.name("geom", k), geom_place(read, k), shapes=[(shape, geom_place(read, k, shape))],
                              material=material_of(read, [k])))  # fmt: skip
            links[-1].place = links[-1].shapes[0][1]
            geoms.append([k])
    for root in range(1, model.nbody):
        if model.body_weldid[root] != root:
            continue
        parent = int(model.body_weldid[model.body_parentid[root]])
        link = Link(
            read.name("body", root), place_of(data.xpos[root], unit(data.xquat[root])), roots.get(parent, WORLD)
        )
        link.masses = [mass_of_body(read, b) for b in np.flatnonzero(model.body_weldid == root).tolist()]
        own = np.flatnonzero(model.body_weldid[model.geom_bodyid] == root).tolist()
        own = [g for g in own if touching.is_any(g)] or own
        found = {g: shape for g in own if (shape := shape_of_geom(read, g)) is not None}
        link.shapes = [(shape, geom_place(read, g, shape)) for g, shape in found.items()]
        link.material = material_of(read, own)
        for j in range(model.body_jntadr[root], model.body_jntadr[root] + model.body_jntnum[root]):
            add_coordinate(read, link, j, names)
        roots[root] = len(links)
        links.append(link)
        geoms.append(own)
    return links, geoms, roots


def mass_of_body(read: Read, b: int) -> Mass:
    """The mass of a body in the axes of the world."""
    R = read.data.ximat[b].reshape(3, 3)
    return Mass(
        float(read.model.body_mass[b]), read.data.xipos[b].copy(), R @ np.diag(read.model.body_inertia[b]) @ R.T
    )


def add_coordinate(read: Read, link: Link, j: int, names: dict[str, int]) -> None:
    """The coordinate of a joint of a link; a free one has none."""
    model, data, kinds = read.model, read.data, read.lib.mjtJoint
    kind, name, v = model.jnt_type[j], read.name("joint", j), model.jnt_dofadr[j]
    one = Coordinate(name, "joint", data.xanchor[j].copy(), unit(data.xaxis[j]))
    if not is_scalar(read, j):
        dofs = slice(v, v + (6 if kind == int(kinds.mjJNT_FREE) else 3))
        acts = (model.dof_damping[dofs], model.dof_armature[dofs], model.dof_frictionloss[dofs], model.jnt_stiffness[j])
        if any(np.any(part) for part in acts) or model.jnt_limited[j]:
            read.miss("limits, stiffness, damping, armature or frictionloss of a ball or free joint", name)
        link.is_free = kind == int(kinds.mjJNT_FREE)
        if not link.is_free:
            link.coordinates.append(one)
        return
    one.kind = "hinge" if kind == int(kinds.mjJNT_HINGE) else "slider"
    start = data.qpos[model.jnt_qposadr[j]]
    if model.jnt_limited[j] and not read.is_off("LIMIT") and not read.is_off("CONSTRAINT"):
        low, high = model.jnt_range[j] - start
        one.limits = (min(float(low), 0.0), max(float(high), 0.0))
    spring = {
        "stiffness": 0.0 if read.is_off("SPRING") else float(model.jnt_stiffness[j]),
        "damping": 0.0 if read.is_off("DAMPER") else float(model.dof_damping[v]),
        "inertia": float(model.dof_armature[v]),
    }
    if any(spring.values()):
        one.springs.append({**spring, "rest": float(model.qpos_spring[model.jnt_qposadr[j]] - start)})
    if not read.is_off("FRICTIONLOSS") and not read.is_off("CONSTRAINT"):
        one.friction = float(model.dof_frictionloss[v])
    for name, k in names.items():
        if is_of_joint(read.lib, model, k) and model.actuator_trnid[k, 0] == j and not read.is_off("ACTUATION"):
            add_actuator(read, one, k, name, float(start))
    link.coordinates.append(one)


def add_actuator(read: Read, one: Coordinate, k: int, name: str, start: float) -> None:
    """What an actuator does: gear (gain ctrl + b_0 + b_1 l + b_2 dl/dt) with the length l = gear q."""
    model, lib, gear = read.model, read.lib, float(read.model.actuator_gear[k, 0])
    is_known = (
        model.actuator_dyntype[k] == int(lib.mjtDyn.mjDYN_NONE)
        and model.actuator_gaintype[k] == int(lib.mjtGain.mjGAIN_FIXED)
        and model.actuator_biastype[k] in (int(lib.mjtBias.mjBIAS_NONE), int(lib.mjtBias.mjBIAS_AFFINE))
    )
    b_0, b_1, b_2 = model.actuator_biasprm[k, :3]
    if model.actuator_biastype[k] == int(lib.mjtBias.mjBIAS_NONE):
        b_0 = b_1 = b_2 = 0.0
    if not is_known or b_1 > 0.0 or b_2 > 0.0:
        read.miss("an actuator with a state, or of a gain or a bias that is not affine", name)
        return
    asked = float(model.actuator_gainprm[k, 0]) * read.ctrl[name] + b_0
    if model.actuator_forcelimited[k]:
        if b_1 or b_2:
            read.miss("the largest force of an actuator that acts on the joint's place or rate", name)
        else:
            asked = float(np.clip(asked, *model.actuator_forcerange[k]))
    if b_1 or b_2:
        one.springs.append({
            "stiffness": float(-b_1 * gear**2), "damping": float(-b_2 * gear**2),
            "rest": float(asked / (-b_1 * gear) - start) if b_1 else 0.0,
        })  # fmt: skip
    if not b_1:
        one.load += float(gear * asked)


def lift(scene: Scene, read: Read, roots: dict[int, int], bodies: list[Body]) -> None:
    """The part of gravity that is compensated."""
    model = read.model
    for b in np.flatnonzero(model.body_gravcomp):
        root = int(model.body_weldid[b])
        if root in roots and scene.gravity.any():  # type: ignore[union-attr]
            lifted = -model.body_gravcomp[b] * model.body_mass[b] * np.asarray(scene.gravity)
            scene.force(bodies[roots[root]], lifted, at=read.data.xipos[b].copy())


def hold(scene: Scene, read: Read, roots: dict[int, int], bodies: list[Body]) -> None:
    """Equalities of bodies: what shares a point, or is held as one."""
    model, data, kinds = read.model, read.data, read.lib.mjtEq
    for k in range(0 if read.is_off("EQUALITY") or read.is_off("CONSTRAINT") else model.neq):
        name, kind = read.name("equality", k), model.eq_type[k]
        is_weld = kind == int(kinds.mjEQ_WELD)
        if not model.eq_active0[k]:
            continue
        if not (is_weld or kind == int(kinds.mjEQ_CONNECT)) or model.eq_objtype[k] != int(read.lib.mjtObj.mjOBJ_BODY):
            read.miss("an equality of joints, tendons or sites", name)
            continue
        ends = [int(model.eq_obj1id[k]), int(model.eq_obj2id[k])]
        # a connect has its point in the first body; a weld of bodies that are not as it asks is held as they start
        at = data.xpos[ends[0]] + data.xmat[ends[0]].reshape(3, 3) @ model.eq_data[k, :3]
        owners = [roots.get(int(model.body_weldid[end])) for end in ends]
        held = [body_or_world(scene, bodies, owner) for owner in owners]
        if owners[0] == owners[1]:
            continue
        joint = scene.fix(*held, at=data.xpos[ends[1]].copy(), name=name) if is_weld else None
        joint = joint or scene.joint(*held, at=at, name=name)
        read.miss("bodies of an equality, which do not touch one another", name)
        rows = (data.efc_type == int(read.lib.mjtConstraint.mjCNSTR_EQUALITY)) & (data.efc_id == k)
        if np.abs(data.efc_pos[rows]).max(initial=0.0) > OPEN_EQUALITY:
            read.miss("an equality that the start does not fulfil, which is held as it starts", name)


def body_or_world(scene: Scene, bodies: list[Body], owner: int | None) -> Body:
    """A body, or what stands for the world."""
    if owner is not None:
        return bodies[owner]
    known = next((body for body in scene.bodies if body.name == "world"), None)
    if known is None:
        known = scene.fixed(Sphere(1e-3), name="world")
        scene.ignored += [(known, body) for body in bodies if body.kind == 0]
    return known
