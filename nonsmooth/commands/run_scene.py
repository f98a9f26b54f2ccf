"""``nonsmooth run`` for a scene of bodies: its options, the run, and what a script wants to know of it."""

from __future__ import annotations

import argparse
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from nonsmooth.errors import InvalidInput
from nonsmooth.results.failures import StepFailure

if TYPE_CHECKING:
    from nonsmooth.results.scene_solution import SceneSolution

# options of `nonsmooth run` that a scene does not take, with the value of one that is left out
OF_SYSTEMS: dict[str, Any] = {
    "state": [], "q0": None, "u0": None, "selection": "compliant-limit", "projection": None, "dump_failure": None,
}  # fmt: skip


def require_scene_options(arguments: argparse.Namespace) -> None:
    """Raise `InvalidInput` for an option that only a model with a system takes."""
    if arguments.integrator not in ("moreau-jean", "penalty"):
        raise InvalidInput(
            f"{arguments.model} is a scene, which --integrator moreau-jean or penalty integrates, and no other yet"
        )
    for name, left_out in OF_SYSTEMS.items():
        if getattr(arguments, name) != left_out:
            option = name.replace("_", "-")
            raise InvalidInput(f"--{option} is no option for {arguments.model}, a scene of bodies; leave it out")


def simulate_scene(
    model: Any, integrator: Any, t_end: float, arguments: argparse.Namespace, progress: bool
) -> SceneSolution:
    """The run with the options of the command line; a failure comes back as a partial solution."""
    from nonsmooth.runs.simulate import simulate

    try:
        return simulate(
            model, (0.0, t_end), integrator=integrator, every=arguments.every, t_eval=arguments.t_eval,
            project=arguments.project, max_steps=arguments.max_steps, max_wall_time=arguments.max_wall_time,
            progress=progress, checkpoint=arguments.checkpoint, resume=arguments.resume,
            checkpoint_every=arguments.checkpoint_every, view=arguments.live,
        )  # type: ignore[return-value]  # fmt: skip
    except StepFailure as failure:
        return failure.solution  # type: ignore[return-value]


def scene_as_json(solution: SceneSolution) -> dict[str, Any]:
    """What a script wants to know of the run of a scene."""
    return {
        "status": solution.status.name,
        "message": solution.message,
        "t": float(solution.t[-1]),
        "bodies": {name: body_as_json(solution, name) for name in solution.names},
        "stats": asdict(solution.stats),
        "ledger": {name: float(column[-1]) for name, column in solution.ledger.items()},
        "about": solution.about,
    }


def body_as_json(solution: SceneSolution, name: str) -> dict[str, Any]:
    """The last state of a body."""
    motion = solution[name]
    return {key: getattr(motion, key)[-1].tolist() for key in ("position", "turn", "velocity", "spin")}
