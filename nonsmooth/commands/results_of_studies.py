"""What studies of equilibria, cycles and bifurcations found, as JSON: numbers, and the units of each name."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from nonsmooth.commands.outputs import attrs_as_json, dataset_as_json, plain, units_of_state

UNITS = {
    "eigenvalues": "1/s", "growth": "1/s", "la_N": "N", "la_F": "N", "gamma_F": "m/s", "period": "s", "begins": "s",
    "duration": "s", "stick_duration": "s",
}  # fmt: skip


def as_json(results: Mapping[str, Any]) -> dict[str, Any]:
    """Everything that a study found, by name."""
    found: dict[str, Any] = {}
    for name, result in results.items():
        found[name] = FORMS[name](result)
    return found


def sliding(small: Any) -> dict[str, Any]:
    """Steady sliding: where, under which forces, and its eigenvalues."""
    at = small.equilibrium
    return {
        "coordinates": [name for name, _ in at.mode.system.described.coordinates],
        "contacts": list(at.mode.system.described.contacts),
        **{name: plain(getattr(at, name)) for name in ("q", "la_N", "la_F", "gamma_F")},
        "residual": float(at.residual), "wrong": list(at.wrong), "verdict": small.verdict.name,
        "eigenvalues": plain(small.eigenvalues), "units": units_of_state(at.mode.system) | UNITS,
    }  # fmt: skip


def path(found: Any) -> dict[str, Any]:
    """Eigenvalues along a parameter, and where the verdict changes."""
    return {
        "parameter": found.parameter, "values": plain(found.values), "eigenvalues": plain(found.eigenvalues),
        "growth": plain(found.growth), "verdicts": [verdict_name(verdict) for verdict in found.verdicts],
        "changes": [{"between": [float(before), float(after)], "from": was.name, "to": becomes.name}
                    for before, after, was, becomes in found.changes],
        "units": {name: UNITS[name] for name in ("eigenvalues", "growth")},
    }  # fmt: skip


def verdict_name(verdict: Any) -> str:
    """The name of a verdict, from its code."""
    from nonsmooth.equilibria.linearise import Verdict

    return Verdict(int(verdict)).name


def chart(found: Any) -> dict[str, Any]:
    """A map over two parameters."""
    return {"about": attrs_as_json(found.attrs), **dataset_as_json(found)}


def cycle(found: Any) -> dict[str, Any]:
    """A periodic motion: period, multipliers, half the range of each coordinate, phases."""
    return {
        "period": float(found.period), "is_stable": bool(found.is_stable), "is_marginal": bool(found.is_marginal),
        "residual": float(found.residual), "stick_duration": float(found.stick_duration),
        "multipliers": plain(found.multipliers),
        "coordinates": [name for name, _ in found.system.described.coordinates],
        "amplitudes": plain(found.amplitudes), "drift": plain(found.drift),
        "start": {"q": plain(found.q[0]), "u": plain(found.u[0])},
        "phases": [{"label": phase.label, "begins": float(phase.begins), "duration": float(phase.duration),
                    "ends_in_impact": phase.jump is not None} for phase in found.phases],
        "units": units_of_state(found.system) | {name: UNITS[name] for name in ("period", "begins", "duration",
                                                                              "stick_duration")},
    }  # fmt: skip


def branch(found: Any) -> dict[str, Any]:
    """Cycles along a parameter, and what changes on the way."""
    return {
        "parameter": found.parameter, "values": plain(found.values), "period": plain(found.periods),
        "stick_duration": [float(one.stick_duration) for one in found.cycles],
        "multipliers": [plain(one.multipliers) for one in found.cycles],
        "amplitudes": [plain(one.amplitudes) for one in found.cycles],
        "changes": [{"kind": change.kind, "value": float(change.value) if change.is_located else None,
                     "between": [float(change.before), float(change.after)]} for change in found.changes],
        "units": {name: UNITS[name] for name in ("period", "stick_duration")},
    }  # fmt: skip


def diagram(found: Any) -> dict[str, Any]:
    """Maxima, or points of a section, of the motions along a parameter."""
    return {
        "parameter": found.parameter, "values": plain(found.values), "coordinate": found.coordinate_label,
        "upwards": [plain(points) for points in found.upwards],
        "downwards": [plain(points) for points in found.downwards],
        "opens": plain(found.opens), "settled": plain(found.settled),
        "periods": None if found.periods is None else plain(found.periods),
        "units": units_of_state(found.system) | {"periods": "s"},
    }  # fmt: skip


FORMS = {"diagram": diagram, "sliding": sliding, "path": path, "map": chart, "cycle": cycle, "branch": branch}
