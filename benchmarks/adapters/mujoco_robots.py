"""Models of files moved by MuJoCo, without contacts, limits, equalities and media, by its Runge-Kutta method.

A URDF is read without shapes, and with a root that stands still, as MuJoCo does.
"""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from pathlib import Path

import mujoco
import numpy as np

DT = 1e-4  # s
SHARE = 0.2  # of the largest control that a motor has, in turn forward and back
HINGES = (int(mujoco.mjtJoint.mjJNT_HINGE), int(mujoco.mjtJoint.mjJNT_SLIDE))


def model_of(path: Path) -> mujoco.MjModel:
    """The model of a file, in which nothing touches."""
    if path.suffix == ".urdf":
        root = ElementTree.parse(path).getroot()
        for link in root.findall("link"):
            for shape in (*link.findall("visual"), *link.findall("collision")):
                link.remove(shape)
        model = mujoco.MjModel.from_xml_string(ElementTree.tostring(root, encoding="unicode"))
    else:
        model = mujoco.MjModel.from_xml_path(str(path))
    for flag in ("CONTACT", "LIMIT", "EQUALITY"):
        model.opt.disableflags |= int(getattr(mujoco.mjtDisableBit, f"mjDSBL_{flag}"))
    model.opt.density = model.opt.viscosity = 0.0
    model.dof_frictionloss[:] = 0.0
    model.opt.integrator, model.opt.timestep = mujoco.mjtIntegrator.mjINT_RK4, DT
    return model


def controls(path: Path) -> np.ndarray:
    """Controls that drive a model, an actuator each."""
    high = mujoco.MjModel.from_xml_path(str(path)).actuator_ctrlrange[:, 1]
    return SHARE * high * (-1.0) ** np.arange(1, len(high) + 1)


def places(path: Path, t_end: float, control: np.ndarray | None = None) -> dict[str, np.ndarray]:
    """Where the centres of mass are at an end, from a start within the limits; bodies that are welded have one."""
    model = model_of(path)
    data = mujoco.MjData(model)
    for k in range(model.njnt):
        if model.jnt_type[k] in HINGES and model.jnt_limited[k]:
            at = model.jnt_qposadr[k]
            data.qpos[at] = np.clip(data.qpos[at], *model.jnt_range[k])
    if control is not None:
        data.ctrl[:] = control
    for _ in range(round(t_end / DT)):
        mujoco.mj_step(model, data)
    mujoco.mj_forward(model, data)
    found = {}
    for root in range(1, model.nbody):
        held = np.flatnonzero(model.body_weldid == root)
        if len(held):
            name = mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_BODY, root) or f"body {root}"
            found[name] = np.average(data.xipos[held], axis=0, weights=model.body_mass[held])
    return found
