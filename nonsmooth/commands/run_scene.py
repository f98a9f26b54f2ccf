"""``nonsmooth run`` for a scene of bodies: its options, the run, and what a script wants to know of it."""

from __future__ import annotations

import argparse
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from nonsmooth.commands.outputs import event_as_json
from nonsmooth.errors import InvalidInput
from nonsmooth.results.failures import StepFailure

if TYPE_CHECKING:
    from nonsmooth.results.scene_bodies import BodyMotion
    from nonsmooth.results.scene_solution import SceneSolution

UNITS = {
    "t": "s", "position": "m", "turn": "rad in the plane, a unit quaternion in space", "velocity": "m/s",
    "spin": "rad/s", "gap": "m", "ledger": "J",
}  # fmt: skip
# options of `nonsmooth run` that a scene does not take, with the value of one that is left out
OF_SYSTEMS: dict[str, Any] = {
    "state": [], "q0": None, "u0": None, "selection": "compliant-limit", "projection": None, "dump_failure": None,
}  # fmt: skip


def require_scene_options(arguments: argparse.Namespace) -> None:
    """Raise `InvalidInput` for an option that only a model with a system takes."""
    for name, left_out in OF_SYSTEMS.items():
        if getattr(arguments, name) != left_out:
            option = name.replace("_", "-")
            raise InvalidInput(f"--{option} is no option for {arguments.model}, a scene of bodies; leave it out")


def require_kinds(arguments: argparse.Namespace) -> None:
    """Raise `InvalidInput` for a --record of what no scene records, and for a figure of what is then not there."""
    from nonsmooth.results.recorded import BODIES, LEDGER, kinds_of_scene

    kinds = kinds_of_scene(arguments.record)
    shown = [name for name in ("plot", "picture", "animate", "view") if getattr(arguments, name)]
    if BODIES not in kinds and shown:
        raise InvalidInput(
            f"--{shown[0]} draws bodies, which --record leaves out; add bodies, or leave --{shown[0]} out"
        )
    if not {BODIES, LEDGER} <= set(kinds) and not arguments.plot:
        arguments.no_plot = True  # the figure that is drawn unasked has nothing to show


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
            checkpoint_every=arguments.checkpoint_every, view=arguments.live, record=arguments.record,
            threads=arguments.threads,
        )  # type: ignore[return-value]  # fmt: skip
    except StepFailure as failure:
        return failure.solution  # type: ignore[return-value]


def scene_as_json(solution: SceneSolution) -> dict[str, Any]:
    """What a script wants to know of the run of a scene, as far as it was recorded."""
    from nonsmooth.results.recorded import BODIES, CONTACTS, LEDGER

    kept = solution.recorded
    return {
        "status": solution.status.name,
        "message": solution.message,
        "t": float(solution.t[-1]),
        **({"bodies": {name: body_as_json(solution[name], -1) for name in solution.names}} if BODIES in kept else {}),
        **({"contacts": contacts_as_json(solution)} if CONTACTS in kept else {}),
        "units": UNITS | {"P": "N" if solution.stats.springs else "N s"},
        "stats": asdict(solution.stats),
        "paradoxes": [event_as_json(event) for event in solution.paradoxes],
        **({"ledger": {name: float(column[-1]) for name, column in solution.ledger.items()}} if LEDGER in kept else {}),
        "about": solution.about,
    }


def body_as_json(motion: BodyMotion, records: Any) -> dict[str, Any]:
    """A body at some records."""
    return {key: column[records].tolist() for key, column in motion._asdict().items() if key != "t"}


def contacts_as_json(solution: SceneSolution) -> list[dict[str, Any]]:
    """The contacts of the last record: which bodies, where, how far apart, and what passes."""
    from nonsmooth.mechanics.system import ContactMode

    found = solution.contacts()
    return [
        {
            "bodies": [solution.names[i], solution.names[j]], "point": found.point[k].tolist(),
            "normal": found.normal[k].tolist(), "gap": float(found.gap[k]), "P": found.P[k].tolist(),
            "mode": ContactMode(int(found.mode[k])).name,
        }
        for k, (i, j) in enumerate(zip(found.i.tolist(), found.j.tolist(), strict=True))
    ]  # fmt: skip


def scene_records(solution: SceneSolution) -> dict[str, Any]:
    """Every record of every body, of a run that is recorded at times that were asked for."""
    from nonsmooth.results.recorded import BODIES

    if BODIES not in solution.recorded:
        return {"t": solution.t.tolist()}
    bodies = {name: body_as_json(solution[name], slice(None)) for name in solution.names}
    return {"t": solution.t.tolist(), "bodies": bodies}
