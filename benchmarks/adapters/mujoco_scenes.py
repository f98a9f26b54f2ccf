"""Scenes of boxes and spheres in MuJoCo: its softness of contact, with the elliptic cone.

Its documentation (Modeling, "Solver parameters") says how it is tuned: ``solref``, the time constant of contacts [s],
0.02 by default and at least two steps, for softness; ``noslip``, iterations after the solver, for creep.
"""

import mujoco
import numpy as np

from nonsmooth.scenes.elements import Kind
from nonsmooth.scenes.inertia import inertia_of
from nonsmooth.scenes.shapes import Box

LARGE = 200  # chosen: bodies from which on conjugate gradients are faster than Newton's method
HEAD = """<mujoco><option timestep="{dt}" gravity="{gravity}" cone="elliptic" solver="{solver}"
noslip_iterations="{noslip}"/><default><geom solref="{solref} 1"/></default>
<size memory="2G"/><worldbody>{bodies}</worldbody></mujoco>"""
BODY = '<body pos="{place}" quat="{turn}"><freejoint/><geom type="{kind}" size="{size}" mass="{mass}" {law}/></body>'
PLANE = '<geom type="plane" size="0 0 1" pos="{place}" zaxis="{normal}" {law}/>'


def words(numbers):
    return " ".join(map(repr, np.asarray(numbers, dtype=float).ravel().tolist()))


def element(body):
    """The text of a body."""
    shape, law = body.shape, f'condim="3" friction="{body.material.mu} 0 0"'
    if body.kind is Kind.FIXED:
        return PLANE.format(place=words(shape.offset * shape.normal), normal=words(shape.normal), law=law)
    kind, size = ("box", np.array(shape.lengths) / 2) if isinstance(shape, Box) else ("sphere", [shape.radius])
    return BODY.format(
        place=words(body.position),
        turn=words(body.turn),
        kind=kind,
        size=words(size),
        law=law,
        mass=inertia_of(body, 3).mass,
    )


class Motion:
    """A scene in motion."""

    def __init__(self, scene, dt, noslip=0, solref=0.02):
        solver = "CG" if len(scene.bodies) > LARGE else "Newton"
        xml = HEAD.format(dt=dt, gravity=words(scene.gravity), solver=solver, noslip=noslip, solref=solref,
                          bodies="".join(map(element, scene.bodies)))  # fmt: skip
        self.model = mujoco.MjModel.from_xml_string(xml)
        self.data = mujoco.MjData(self.model)

    def step(self, count):
        mujoco.mj_step(self.model, self.data, nstep=count)

    def places(self):
        q = self.data.qpos.reshape(-1, 7)
        return q[:, :3].copy(), q[:, 3:].copy()
