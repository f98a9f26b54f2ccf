"""Chains of links in MuJoCo: as a tree of ball joints, which have no error, or as free bodies whose points it ties.

Its documentation (Modeling, "Equality") has ``connect``, a soft constraint of time constant ``solref`` [s], 0.02 by
default and at least two steps. A tree has the angles of its joints as coordinates.
"""

import mujoco
import numpy as np

from benchmarks.adapters.mujoco_scenes import words
from nonsmooth.scenes.elements import Kind
from nonsmooth.scenes.inertia import inertia_of

HEAD = """<mujoco><option timestep="{dt}" gravity="{gravity}" integrator="{integrator}"/><size memory="1G"/>
<worldbody>{bodies}</worldbody><equality>{ties}</equality></mujoco>"""
INERTIA = '<inertial pos="0 0 0" mass="{mass}" diaginertia="{moments}"/>'


def inertial(body):
    inertia = inertia_of(body, 3)  # along x, its principal axes are its own
    return INERTIA.format(mass=inertia.mass, moments=words(inertia.moments))


class Motion:
    """A chain in motion: its bodies and joints in order, along x at the start."""

    def __init__(self, scene, dt, is_tree=True, solref=0.02, integrator="implicitfast"):
        moving = [body for body in scene.bodies if body.kind is Kind.DYNAMIC]
        text, ties, before = "", "", np.zeros(3)
        for k, (body, joint) in enumerate(zip(moving, scene.joints, strict=True)):
            at = joint.at - body.position
            if is_tree:
                place, free = body.position - before, f'<joint type="ball" pos="{words(at)}"/>'
                before = body.position
            else:
                place, free = body.position, "<freejoint/>"
                other = f'body2="b{k - 1}"' if k else ""
                ties += f'<connect body1="b{k}" {other} anchor="{words(at)}" solref="{solref} 1"/>'
            text += f'<body name="b{k}" pos="{words(place)}">{free}{inertial(body)}{"" if is_tree else "</body>"}'
        text += "</body>" * len(moving) * is_tree
        xml = HEAD.format(dt=dt, gravity=words(scene.gravity), integrator=integrator, bodies=text, ties=ties)
        self.model = mujoco.MjModel.from_xml_string(xml)
        self.data = mujoco.MjData(self.model)

    def step(self, count):
        mujoco.mj_step(self.model, self.data, nstep=count)

    def places(self):
        mujoco.mj_kinematics(self.model, self.data)
        return self.data.xipos[1:].copy(), self.data.xquat[1:].copy()
