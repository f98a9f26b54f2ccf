"""A model as MuJoCo compiles it, at its start, with what of it a scene does not have."""

from __future__ import annotations

from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from nonsmooth.errors import InvalidInput, MissingExtra


class Surface(NamedTuple):
    """Friction of a geom, its condim and its priority."""

    mu: float
    spinning: float  # [m]
    rolling: float  # [m]
    condim: int
    priority: int


class Read(NamedTuple):
    """A model as MuJoCo has it, at its start, and what of it is not understood."""

    lib: Any
    model: Any
    data: Any
    ctrl: dict[str, float]
    missed: dict[str, list[str]]  # what is not understood: of whom
    surfaces: dict[str, Surface]  # of materials, by name

    def miss(self, what: str, who: str) -> None:
        """Note what is not understood."""
        of = self.missed.setdefault(what, [])
        if who not in of:
            of.append(who)

    def name(self, kind: str, k: int) -> str:
        """The name of an element, or its kind and number."""
        code = getattr(self.lib.mjtObj, f"mjOBJ_{kind.upper()}")
        return self.lib.mj_id2name(self.model, code, k) or f"{kind} {k}"

    def is_off(self, flag: str) -> bool:
        """Whether an option of the model leaves something out."""
        return bool(self.model.opt.disableflags & int(getattr(self.lib.mjtDisableBit, f"mjDSBL_{flag}")))


def compiled(path: Path) -> tuple[Any, Any, list[str]]:
    """MuJoCo, the model that it makes of a file, and what it warns of, which it would write to a log in this folder.

    Raises
    ------
    MissingExtra
        Without mujoco.
    InvalidInput
        For a file that MuJoCo refuses, in its words.
    """
    try:
        import mujoco
    except ImportError:
        raise MissingExtra('.xml files of MuJoCo need mujoco; pip install "nonsmooth[mjcf]" brings it') from None
    said: list[str] = []
    before = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(said.append)
    try:
        return mujoco, mujoco.MjModel.from_xml_path(str(path)), said
    except (ValueError, mujoco.FatalError) as error:
        raise InvalidInput(f"{path} is no MJCF that MuJoCo compiles: {error}") from error
    finally:
        mujoco.set_mju_user_warning(before)


def controls(lib: Any, model: Any) -> dict[str, int]:
    """The actuators, by name; one without a name has that of its joint."""
    found: dict[str, int] = {}
    for k in range(len(model.actuator_trntype)):
        of = lib.mjtObj.mjOBJ_JOINT if is_of_joint(lib, model, k) else lib.mjtObj.mjOBJ_TENDON
        name = lib.mj_id2name(model, lib.mjtObj.mjOBJ_ACTUATOR, k) or lib.mj_id2name(
            model, of, model.actuator_trnid[k, 0]
        )
        found[name if name and name not in found else f"actuator {k}"] = k
    return found


def is_of_joint(lib: Any, model: Any, k: int) -> bool:
    """Whether an actuator acts on a joint."""
    return model.actuator_trntype[k] in (int(lib.mjtTrn.mjTRN_JOINT), int(lib.mjtTrn.mjTRN_JOINTINPARENT))


def is_scalar(read: Read, k: int) -> bool:
    """Whether joint k is a hinge or a slide."""
    return read.model.jnt_type[k] in (int(read.lib.mjtJoint.mjJNT_HINGE), int(read.lib.mjtJoint.mjJNT_SLIDE))


def unit(quaternion: np.ndarray) -> np.ndarray:
    """Of length 1."""
    return np.array(quaternion) / np.linalg.norm(quaternion)
