"""What the bits of a run depend on: two runs with equal facts take the same steps."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from typing import Any

import numpy as np

from nonsmooth import __version__
from nonsmooth.errors import InvalidInput
from nonsmooth.integrators.assembly.world import World
from nonsmooth.integrators.contract import Integrator
from nonsmooth.integrators.moreau_jean.options import MoreauJean
from nonsmooth.jit import Kernel, identity
from nonsmooth.jit.content import CURE
from nonsmooth.jit.fingerprint import Unidentified
from nonsmooth.mechanics.system import FUNCTION_NAMES, System
from nonsmooth.results.checkpoint import HASHED


def facts_of_run(
    system: System, integrator: Any, t_span: tuple[float, float], every: int, t_eval: Any, q0: np.ndarray,
    u0: np.ndarray, selection: int, project: bool, recorded: tuple[str, ...], is_compiled: bool,
) -> dict[str, Any]:  # fmt: skip
    """The facts by name, as JSON can hold them.

    The content of a function stands for the function (jit/content.py).

    Raises
    ------
    InvalidInput
        Where a function reads what cannot be told from something else.
    """
    functions = {name: system.given(which) for name, which in FUNCTION_NAMES.items() if which in system.functions}
    kernels = integrator.kernels
    return {
        "version": __version__,
        "code of": {
            **{name: _hash(_content(function)) for name, function in functions.items()},
            **{f"the friction law of contact {i}": _hash(_content(law.function)) for i, law in system.own_laws.items()},
            "the integrator": _hash(b"".join(kernel.call_identity() for kernel in kernels)),
        },
        "system": system.name or system.mass.__name__,
        "parameter": dict(system.numbers),
        "contacts": system.kinds.tolist(),
        "laws": system.law_numbers.tolist(),
        "integrator": repr(integrator),
        "options of the integrator": HASHED + _hash(_content(integrator)),
        "t_span": [float(t) for t in t_span],
        "every": int(every),
        "t_eval": None if t_eval is None else _hash(np.asarray(t_eval, dtype=np.float64).tobytes()),
        "records_start": t_eval is None or bool(np.ravel(t_eval)[0] <= t_span[0]),
        "q0": q0.tolist(),
        "u0": u0.tolist(),
        "selection": int(selection),
        "project": bool(project),
        "record": list(recorded),
        "is_compiled": is_compiled,
    }


def facts_of_scene_run(
    world: World, kernels: Sequence[Kernel], integrator: Integrator, t_span: tuple[float, float], every: int,
    t_eval: Any, kinds: tuple[str, ...], project: bool, selection: int,
) -> dict[str, Any]:  # fmt: skip
    """The facts of a run of a scene; what has many numbers, the scene itself among it, is told by its hash."""
    bodies, d = world.bodies, world.dim
    inert = b"".join(column.tobytes() for column in (bodies.mass, bodies.moments, bodies.surface))
    motions = b"".join(body.name.encode() + _content(body.motion) for body in world.guided)
    forces = b"".join(force.body.name.encode() + _content((force.value, force.at)) for force in world.scene.forces)
    driven = [(joint, motor) for joint in world.scene.joints for motor in joint.motors]
    motors = b"".join(joint.name.encode() + _content((motor.load, motor.speed)) for joint, motor in driven)
    return {
        "version": __version__,
        "scene": repr(world.scene),
        "integrator": repr(integrator),
        **({"contacts": repr(integrator.contacts)} if isinstance(integrator, MoreauJean) else {}),
        "options of the integrator": HASHED + _hash(_content(integrator)),
        "code of": {
            "the integrator": _hash(b"".join(kernel.call_identity() for kernel in kernels)),
            "the motions of guided bodies": _hash(motions),
            **({"the applied forces": _hash(forces)} if forces else {}),
            **({"the motors": _hash(motors)} if motors else {}),
        },
        "list of bodies": HASHED + _hash("\n".join(body.name for body in world.scene.bodies).encode()),
        "start": HASHED + _hash(bodies.motion.words.tobytes()),
        "gravity": bodies.gravity[:d].tolist(),
        "geometry": HASHED + _hash(world.shapes.words.tobytes()),
        **({"springs": HASHED + _hash(world.springs.words.tobytes())} if world.scene.springs else {}),
        **(
            {"joints": HASHED + _hash(world.joints.words.tobytes())} if world.scene.joints or world.joints.apart else {}
        ),
        **({"limits and motors": HASHED + _hash(world.drives.words.tobytes())} if world.drives.count else {}),
        "table of materials": HASHED + _hash(world.surfaces.words.tobytes()),
        "mass or surface of a body": HASHED + _hash(inert),
        "t_span": [float(t) for t in t_span],
        "every": int(every),
        "t_eval": None if t_eval is None else _hash(np.asarray(t_eval, dtype=np.float64).tobytes()),
        "record": list(kinds),
        "project": project,
        "selection": int(selection),
    }


def _content(value: Any) -> bytes:
    try:
        return identity(value)
    except Unidentified as reason:
        raise InvalidInput(f"a checkpoint cannot tell this run from others: {reason}. {CURE}") from None


def _hash(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()[:16]
