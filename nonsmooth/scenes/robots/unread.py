"""What a model of MuJoCo has that a scene does not, by name.

A number of a model that is not read, and differs from that of a plain one, is listed: also what a later version of
MuJoCo adds.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from nonsmooth.scenes.robots.mujoco_model import Read, controls, is_of_joint

PLAIN = """<mujoco><worldbody><body><joint name="j"/><geom size="1"/></body></worldbody>
<actuator><motor joint="j"/></actuator></mujoco>"""
# columns of a model that are read here, that follow from others, or that are for the eye
READ = {
    "jnt": "type qposadr dofadr bodyid actuatorid group limited range axis pos stiffness user",
    "dof": "bodyid jntid parentid treeid Madr simplenum invweight0 M0 length damping armature frictionloss",
    "geom": "type contype conaffinity condim bodyid dataid group priority size aabb rbound pos quat sameframe "
            "friction matid rgba user castshadow plugin fluid",
    "body": "parentid rootid weldid mocapid jntnum jntadr dofnum dofadr treeid geomnum geomadr simple sameframe pos "
            "quat ipos iquat mass subtreemass inertia invweight0 gravcomp user contype conaffinity bvhadr bvhnum "
            "margin plugin",
    "actuator": "trntype dyntype gaintype biastype trnid group ctrllimited ctrlrange forcelimited forcerange gainprm "
                "biasprm gear acc0 length0 lengthrange user ctrladr ctrlnum outadr outnum actadr actnum plugin",
}  # fmt: skip
SOFT = ("solref", "solimp", "solmix", "margin", "gap")  # of contacts and limits that give way: here they are rigid
# what a model may have any number of, that a scene has no place for
UNREAD = {"tendon": "ntendon", "sensor": "nsensor", "key": "nkey", "flex": "nflex", "skin": "nskin",
          "plugin": "nplugin"}  # fmt: skip


def note_rest(read: Read) -> None:
    """Note what a model has beyond what is read."""
    model, lib = read.model, read.lib
    plain = lib.MjModel.from_xml_string(PLAIN)
    for what in differing(read, plain):
        read.miss(*what)
    for kind, count in UNREAD.items():
        for k in range(getattr(model, count, 0)):
            read.miss(f"{kind}s", read.name(kind, k))
    for b in np.flatnonzero(model.body_mocapid >= 0).tolist():
        read.miss("mocap bodies, which stand still", read.name("body", b))
    for k in range(model.npair):
        read.miss("what a pair of geoms has of its own, its friction among it", read.name("pair", k))
    for name, k in controls(lib, model).items():
        if not is_of_joint(lib, model, k):
            read.miss("an actuator that does not act on a joint", name)
    if model.opt.density > 0.0 or model.opt.viscosity > 0.0:
        read.miss("drag and lift of a medium, by density and viscosity", "option")
    if read.is_off("FILTERPARENT"):
        read.miss("contacts of bodies that a joint holds", "option")
    if model.opt.enableflags & int(lib.mjtEnableBit.mjENBL_OVERRIDE):
        read.miss("parameters of contacts that are overridden", "option")
    if model.ngeom or model.njnt:
        read.miss("solref, solimp, margin: contacts, limits and equalities are rigid, and do not rebound", "")


def differing(read: Read, plain: Any) -> Iterator[tuple[str, str]]:
    """The columns of a model that differ from those of a plain one and are not read, and of whom."""
    for kind, known in READ.items():
        for column in vars_of(read.model, kind):
            short = column.removeprefix(f"{kind}_")
            if short in known.split() or short.startswith(SOFT):
                continue
            values, usual = getattr(read.model, column), getattr(plain, column)
            if len(usual) == 0 or len(values) == 0 or np.shape(values)[1:] != np.shape(usual)[1:]:
                continue
            for k in np.flatnonzero((np.asarray(values) != usual[-1]).reshape(len(values), -1).any(axis=1)):
                owner = (
                    ("joint", int(read.model.dof_jntid[k])) if kind == "dof" else (kind.replace("jnt", "joint"), int(k))
                )
                yield f"{short} of {owner[0]}s", read.name(*owner)


def vars_of(model: Any, kind: str) -> list[str]:
    """The columns of a kind of elements."""
    return [name for name in dir(model) if name.startswith(f"{kind}_")]
