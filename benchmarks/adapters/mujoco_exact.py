"""Scenes of exact friction in MuJoCo, tuned as its documentation says.

Modeling, "Solver parameters" and "Contact": the elliptic cone and Newton's method, the time constant of contacts at its
least, two steps; ``impratio`` 10 for friction that is harder than the normal force. A guided body is one of 1e6 kg
without weight, whose place and velocity are set before every step.
"""

import mujoco
import numpy as np

from nonsmooth.scenes.elements import Kind
from nonsmooth.scenes.inertia import inertia_of
from nonsmooth.scenes.shapes import Box, HalfSpace, Polyhedron

HEAVY = 1e6  # kg, chosen
HEAD = """<mujoco><compiler inertiafromgeom="auto"/><option timestep="{dt}" gravity="{gravity}" cone="elliptic"
solver="Newton" impratio="10"/><default><geom solref="{solref} 1" condim="3"/></default><size memory="2G"/>
<asset>{meshes}</asset><worldbody>{bodies}</worldbody></mujoco>"""


def words(numbers):
    return " ".join(map(repr, np.asarray(numbers, dtype=float).ravel().tolist()))


def geom(body):
    """The text of its shape."""
    shape, law = body.shape, f'friction="{body.material.mu} 0 0"'
    if isinstance(shape, HalfSpace):
        return f'<geom type="plane" size="0 0 1" pos="{words(shape.offset * shape.normal)}" {law}/>'
    mass = {Kind.DYNAMIC: lambda: inertia_of(body, 3).mass, Kind.KINEMATIC: lambda: HEAVY}.get(body.kind)
    law += "" if mass is None else f' mass="{mass()}"'
    if isinstance(shape, Polyhedron):
        return f'<geom type="mesh" mesh="mesh{body.index}" {law}/>'
    if isinstance(shape, Box):
        return f'<geom type="box" size="{words(np.array(shape.lengths) / 2)}" {law}/>'
    return f'<geom type="sphere" size="{shape.radius}" {law}/>'


def element(body):
    """The text of a body."""
    if body.kind is Kind.FIXED:
        return geom(body)
    weight = 'gravcomp="1"' if body.kind is Kind.KINEMATIC else ""
    at = body.motion(0.0) if body.motion else body.position
    own = inertial(body) if body.centre is not None else ""
    return f'<body pos="{words(at)}" quat="{words(body.turn)}" {weight}><freejoint/>{own}{geom(body)}</body>'


def inertial(body):
    """The text of an inertia of its own."""
    inertia = np.atleast_2d(body.inertia)
    entries = inertia[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]]
    return f'<inertial pos="{words(body.centre)}" mass="{body.mass}" fullinertia="{words(entries)}"/>'


def mesh(body):
    return f'<mesh name="mesh{body.index}" vertex="{words(body.shape.vertices)}"/>'


def turned(turn, x):
    """A vector that is given in the axes of a body, in the world."""
    out = np.zeros(3)
    mujoco.mju_rotVecQuat(out, np.asarray(x, dtype=float), np.asarray(turn, dtype=float))
    return out


def turned_back(turn, x):
    """A vector in the axes of a body."""
    back = np.zeros(4)
    mujoco.mju_negQuat(back, np.asarray(turn, dtype=float))
    return turned(back, x)


class Motion:
    """A scene in motion."""

    def __init__(self, scene, dt):
        self.dt, self.scene = dt, scene
        free = [body for body in scene.bodies if body.kind is not Kind.FIXED]
        meshes = "".join(mesh(body) for body in scene.bodies if isinstance(body.shape, Polyhedron))
        xml = HEAD.format(dt=dt, gravity=words(scene.gravity), solref=2 * dt, meshes=meshes,
                          bodies="".join(map(element, scene.bodies)))  # fmt: skip
        self.model = mujoco.MjModel.from_xml_string(xml)
        self.data = mujoco.MjData(self.model)
        for k, body in enumerate(free):
            arm = np.zeros(3) if body.centre is None else turned(body.turn, body.centre)
            self.data.qvel[6 * k : 6 * k + 3] = body.velocity - np.cross(body.spin, arm)  # of the origin
            self.data.qvel[6 * k + 3 : 6 * k + 6] = turned_back(body.turn, body.spin)
        mujoco.mj_forward(self.model, self.data)
        self.moving = np.array([k + 1 for k, body in enumerate(free) if body.kind is Kind.DYNAMIC])
        self.guided = [(k, body) for k, body in enumerate(free) if body.kind is Kind.KINEMATIC]

    def step(self, t):
        for k, body in self.guided:
            place = np.array(body.motion(t)) if body.motion else body.position + t * body.velocity
            speed = (np.array(body.motion(t + self.dt)) - place) / self.dt if body.motion else body.velocity
            turn, spin = np.zeros(4), np.asarray(body.spin, dtype=float)
            rate = np.linalg.norm(spin)
            mujoco.mju_axisAngle2Quat(turn, spin / rate if rate else np.array([0.0, 0.0, 1.0]), rate * t)
            self.data.qpos[7 * k : 7 * k + 7] = [*place, *turn]
            self.data.qvel[6 * k : 6 * k + 6] = [*speed, *turned_back(turn, spin)]
        mujoco.mj_step(self.model, self.data)

    def centres(self):
        """Of mass, of the bodies that move (n, 3) [m]."""
        return self.data.xipos[self.moving].copy()

    def is_unstable(self):
        """Whether it gave up a step, and began again from the start."""
        return bool(self.data.warning[mujoco.mjtWarning.mjWARN_BADQACC].number)

    def contacts(self):
        return self.data.ncon

    def depth(self):
        """The deepest contact that it found [m]."""
        return max(0.0, -self.data.contact.dist.min(initial=0.0)) if self.data.ncon else 0.0
