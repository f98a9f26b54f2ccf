"""What a run of a system or of a scene found, as JSON: its last record, all of them where times were asked for."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from nonsmooth.commands.outputs import event_as_json
from nonsmooth.results.recorded import BODIES, CONTACTS, EVENTS, LEDGER

if TYPE_CHECKING:
    from nonsmooth.results.scene_bodies import BodyMotion
    from nonsmooth.results.scene_solution import SceneSolution
    from nonsmooth.results.solution import Solution

AT_THE_END = ("t", "q", "u", "g_N", "mode")  # chosen: columns of a system whose last row is printed
UNITS_OF_SCENE = {
    "t": "s", "position": "m", "turn": "rad in the plane, a unit quaternion in space", "velocity": "m/s",
    "spin": "rad/s", "gap": "m", "ledger": "J",
}  # fmt: skip


def as_json(solution: Solution | SceneSolution, has_records: bool) -> dict[str, Any]:
    """What a script wants to know of a run, as far as it was recorded; ``has_records``: with every record."""
    from nonsmooth.results.scene_solution import SceneSolution

    of_scene = isinstance(solution, SceneSolution)
    own: Callable[[Any], dict[str, Any]] = of_bodies if of_scene else of_system
    told = {"status": solution.status.name, "message": solution.message, **own(solution)}
    if of_scene or EVENTS in solution.recorded:
        told["paradoxes"] = [event_as_json(event) for event in solution.paradoxes]
    told["about"] = solution.about
    if has_records:
        records: Callable[[Any], dict[str, Any]] = records_of_bodies if of_scene else records_of_system
        told["records"] = records(solution)
    return told


def of_system(solution: Solution) -> dict[str, Any]:
    """The last state of a system, what its numbers are, its events and its ledger."""
    told = {
        **{name: last for name, (last,) in records_of_system(solution, AT_THE_END, slice(-1, None)).items()},
        "coordinates": [name for name, _ in solution.described.coordinates],
        "contacts": list(solution.described.contacts),
        "units": units_of(solution),
        "stats": solution.stats.as_dict(),
    }
    if EVENTS in solution.recorded:
        told["events"] = [event_as_json(event) for event in solution.events]
    if LEDGER in solution.recorded:
        told["ledger"] = last_of(solution.find_ledger([-1]))
    return told


def of_bodies(solution: SceneSolution) -> dict[str, Any]:
    """The bodies and contacts of the last record of a scene, and its ledger."""
    kept = solution.recorded
    told: dict[str, Any] = {"t": float(solution.t[-1])}
    if BODIES in kept:
        told["bodies"] = {name: body_as_json(solution[name], -1) for name in solution.names}
    if CONTACTS in kept:
        told["contacts"] = contacts_as_json(solution)
    if LEDGER in kept:
        told["ledger"] = last_of(solution.ledger)
    return told | {
        "units": UNITS_OF_SCENE | {"P": "N" if solution.stats.springs else "N s"}, "stats": asdict(solution.stats),
    }  # fmt: skip


def units_of(solution: Solution) -> dict[str, Any]:
    """Units of the values that are printed of a system."""
    described = solution.described
    q, u = ([unit for _, unit in pairs] for pairs in (described.coordinates, described.rates))
    return {"t": "s", "q": q, "u": u, "g_N": "m", "P_N": "N s", "P_F": "N s", "ledger": "J"}


def last_of(ledger: Mapping[str, Any]) -> dict[str, float]:
    """The works and energies at the end [J]."""
    return {name: float(column[-1]) for name, column in ledger.items()}


def records_of_system(
    solution: Solution, names: tuple[str, ...] = (*AT_THE_END, "P_N", "P_F"), rows: slice = slice(None)
) -> dict[str, Any]:  # fmt: skip
    """Columns of a system; what was not recorded is left out."""
    from nonsmooth.mechanics.system import ContactMode

    own = solution.__getstate__()
    columns = {name: own[name][rows].tolist() for name in names if own[name] is not None}
    if "mode" in columns:
        columns["mode"] = [[ContactMode(code).name for code in row] for row in columns["mode"]]
    return columns


def records_of_bodies(solution: SceneSolution) -> dict[str, Any]:
    """Every record of every body."""
    told: dict[str, Any] = {"t": solution.t.tolist()}
    if BODIES in solution.recorded:
        told["bodies"] = {name: body_as_json(solution[name], slice(None)) for name in solution.names}
    return told


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
