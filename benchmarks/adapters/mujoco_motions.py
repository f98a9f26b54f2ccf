"""Motions by MuJoCo: planar joints, elliptic cone, its default contact softness; a plane has no restitution there.

Each function returns (positions at the times, seconds of the loop, evaluations, steps); the model is built apart.
"""

import time

import mujoco
import numpy as np

HEAD = """<mujoco><option timestep="{dt}" gravity="0 0 -{g}" cone="elliptic" integrator="implicitfast"/>
<worldbody><geom type="plane" size="10 10 1" friction="{mu} 0 0" condim="3"/>
<body><joint type="slide" axis="1 0 0"/><joint type="slide" axis="0 0 1"/>{hinge}
<inertial pos="0 0 0" mass="{m}" diaginertia="1 {I} 1"/>{geom}</body></worldbody></mujoco>"""
HINGE = '<joint type="hinge" axis="0 -1 0"/>'
POINT = 1e-3  # m, radius of the sphere that is a point of contact


def run(problem, xml, place):
    """Step to the end; ``place`` turns joint positions into coordinates and back at the start."""
    model = mujoco.MjModel.from_xml_string(xml)
    data = mujoco.MjData(model)
    _, q0, u0 = problem.start
    data.qpos[:], data.qvel[:] = q0 + place, u0
    steps = max(1, round(problem.times[-1] / model.opt.timestep))
    marks = np.round(problem.times / model.opt.timestep).astype(int)
    q = np.zeros((len(marks), len(q0)))
    start, done = time.perf_counter(), 0
    for k, mark in enumerate(marks):
        mujoco.mj_step(model, data, nstep=int(mark - done))
        done = mark
        q[k] = data.qpos - place
    return q, time.perf_counter() - start, steps, steps


def block(problem, p, dt):
    geom = f'<geom type="sphere" size="{POINT}" friction="{p.mu} 0 0" condim="3"/>'
    xml = HEAD.format(dt=dt, g=p.g, mu=p.mu, m=p.m, I=1.0, hinge="", geom=geom)
    return run(problem, xml, np.array([0.0, POINT]))


def rod(problem, p, dt):
    """The tip is a small sphere; the plane is lowered by its radius."""
    geom = f'<geom type="sphere" size="{POINT}" pos="-{p.l / 2} 0 0" friction="{p.mu} 0 0" condim="3"/>'
    xml = HEAD.format(dt=dt, g=p.g, mu=p.mu, m=p.m, I=p.I, hinge=HINGE, geom=geom)
    return run(problem, xml, np.array([0.0, POINT, 0.0]))


def rocking_block(problem, p, dt):
    m, a, b = p.m, p.width / 2, p.height / 2
    geom = f'<geom type="box" size="{a} 0.1 {b}" friction="{p.mu} 0 0" condim="3"/>'
    inertia = m * (p.width**2 + p.height**2) / 12
    xml = HEAD.format(dt=dt, g=p.g, mu=p.mu, m=m, I=inertia, hinge=HINGE, geom=geom)
    return run(problem, xml, np.zeros(3))


SCENES = {"sliding block": block, "rod, slip and stick": rod, "rocking block": rocking_block}
