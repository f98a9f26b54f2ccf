"""A classification in words and as plain data."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from nonsmooth.mechanics.laws import ImpactLaw
from nonsmooth.paradox.stability import Stability

if TYPE_CHECKING:
    from nonsmooth.paradox.alternatives import ImpactAlternative
    from nonsmooth.paradox.classify import Classification
    from nonsmooth.paradox.in_space import SpatialClassification
    from nonsmooth.paradox.kinds import ContactIsland, ForceSolution

MEANING = {
    "INCONSISTENT": "no contact force fits this state",
    "REGULAR": "one solution",
    "INDETERMINATE": "rigid-body theory does not decide between {n} solutions",
    "NOT_ENUMERATED": "not every mode was tried; {n} solutions found",
}
STABILITY = {
    Stability.STABLE: "stable",
    Stability.FLUTTER: "stable if c^2/k > {damping:.4g} kg",
    Stability.SADDLE: "unstable (saddle of a stiff contact)",
}
FLAGS = {
    "P_ZERO": "p = 0 within the tolerance",
    "B_ZERO": "b = 0 within the tolerance",
    "GENOT_BROGLIATO": "Génot–Brogliato point: p = b = 0",
    "REVERSE_CHATTER": "sticking coexists with bounces that grow out of it (reverse chatter)",
    "CONTACT_FLUTTER": "a solution flutters unless the contact is damped enough",
    "JAMMED": "jammed: neither forces nor an impact solve it",
    "PAINLEVE": "p <= 0: more normal force presses the bodies together",
}
SOLUTIONS_SHOWN = 16  # chosen: solutions printed


def as_text(c: Classification) -> str:
    """The table of solutions as a person would want to read it."""
    lines = [f"{c.kind.name}: {MEANING[c.kind.name].format(n=c.n_solutions)}"]
    if not c.is_complete and c.kind.name != "NOT_ENUMERATED":
        lines.append("  (some solutions may be missing)")
    lines += [_contact_line(c, i) for i in range(len(c.mode))]
    if len(c.islands) > 1:
        lines += [_island_line(c, island) for island in c.islands]
    lines += [f"  ! {FLAGS[flag.name]}" for flag in type(c.flags) if flag & c.flags and flag.name]
    if c.solutions:
        lines += ["", "solutions (forces in N, accelerations in m/s^2)"]
        lines += _table([_solution_row(j, s) for j, s in enumerate(c.solutions[:SOLUTIONS_SHOWN])], SOLUTION_HEAD)
        if c.n_solutions > SOLUTIONS_SHOWN:
            lines.append(f"  ... and {c.n_solutions - SOLUTIONS_SHOWN} more")
    if c.impacts:
        lines += ["", "impact without collision (impulses in N s, velocities after it in m/s)"]
        lines += _table(_impact_rows(c.impacts[:SOLUTIONS_SHOWN]), IMPACT_HEAD)
    return "\n".join(lines)


def spatial_text(c: SpatialClassification) -> str:
    """What is known of a state with friction in two directions."""
    lines = [f"{c.kind.name}: {MEANING[c.kind.name].format(n=c.n_solutions)}"]
    for i, (name, mode) in enumerate(zip(c.contacts, c.mode, strict=True)):
        way = f" along ({c.direction[i, 0]:.6g}, {c.direction[i, 1]:.6g})" if mode == "sliding" else ""
        known = f", p = {c.p[i]:.6g} 1/kg, b = {c.b[i]:.6g} m/s^2" if np.isfinite(c.p[i]) else ""
        lines.append(f"  {name}: {mode}{way}{known}")
    lines += [f"  ! {FLAGS[flag.name]}" for flag in type(c.flags) if flag & c.flags and flag.name]
    if c.solutions:
        head = ("", "mode", "la_N", "la_F", "stiff contact")
        rows: list[tuple[str, ...]] = [
            (f"{j + 1}", " | ".join(one.modes), _numbers(one.la[:, 0]), " | ".join(_pair(la[1:]) for la in one.la),
             STABILITY[one.stability.kind].format(damping=one.stability.damping))
            for j, one in enumerate(c.solutions[:SOLUTIONS_SHOWN])
        ]  # fmt: skip
        lines += ["", "solutions (forces in N)", *_table(rows, head)]
    if c.impacts:
        lines += ["", "impact without collision (impulses in N s, velocities after it in m/s)"]
        lines += _table(_impact_rows(c.impacts[:SOLUTIONS_SHOWN]), IMPACT_HEAD)
    return "\n".join(lines)


def _pair(values: np.ndarray) -> str:
    return f"({', '.join(f'{value + 0.0:.6g}' for value in values)})"


def spatial_dictionary(c: SpatialClassification) -> dict[str, Any]:
    """Plain lists, numbers and strings."""
    return {
        "t": c.t, "kind": c.kind.name, "n_solutions": c.n_solutions, "is_complete": c.is_complete,
        "flags": [flag.name for flag in type(c.flags) if flag & c.flags], "mode": list(c.mode),
        **{name: getattr(c, name).tolist() for name in ("q", "u", "gamma_N", "gamma_F", "direction", "mu", "b", "p")},
        "solutions": [
            {"modes": list(one.modes), "la": one.la.tolist(), "du": one.du.tolist(),
             "stability": one.stability.kind.name, "least_damping": one.stability.damping} for one in c.solutions
        ],
        "impacts": [_impact_dictionary(impact) for impact in c.impacts],
    }  # fmt: skip


def _island_line(c: Classification, island: ContactIsland) -> str:
    own = [c.contacts[i] for i in island.contacts]
    is_numbered = all(name == f"contact {i}" for i, name in zip(island.contacts, own, strict=True))
    many = is_numbered and len(own) > 1
    names = "contacts " + ", ".join(map(str, island.contacts)) if many else ", ".join(own)
    meaning = MEANING[island.kind.name].format(n=island.n_solutions)
    return f"  {names}, decided apart: {island.kind.name}, {meaning}"


def _contact_line(c: Classification, i: int) -> str:
    line = f"  {c.contacts[i]}: {c.mode[i]}"
    if c.mode[i] == "open":
        return line
    line += f", gamma_F = {c.gamma_F[i]:.6g} m/s, mu = {c.mu[i]:.6g}"
    if np.isfinite(c.p[i]).all():
        line += f"\n             p+ = {c.p[i, 0]:.6g}, p- = {c.p[i, 1]:.6g} 1/kg, b = {c.b[i]:.6g} m/s^2"
    return line


SOLUTION_HEAD = ("", "mode", "la_N", "la_F", "gamma_N'", "gamma_F'", "stiff contact")
IMPACT_HEAD = ("", "law", "e", "P_N", "P_F", "gamma_N", "gamma_F")


def _solution_row(j: int, s: ForceSolution) -> tuple[str, ...]:
    tag = STABILITY[s.stability.kind].format(damping=s.stability.damping)
    note = "" if s.is_unique_force else "; forces not unique"
    columns = (_numbers(column) for column in (s.la_N, s.la_F, s.dgamma_N, s.dgamma_F))
    return (f"{j + 1}", " | ".join(s.modes), *columns, tag + note)


def _impact_row(impact: ImpactAlternative) -> tuple[str, ...]:
    columns = (_numbers(column) if column.ndim == 1 else " | ".join(map(_pair, column))
               for column in (impact.P_N, impact.P_F, impact.gamma_N, impact.gamma_F))  # fmt: skip
    return ("", ImpactLaw(impact.law).name.lower(), f"{impact.e:g}", *columns)


def _impact_rows(impacts: tuple[ImpactAlternative, ...]) -> list[tuple[str, ...]]:
    """A row for each outcome, with the names of all the laws that lead to it."""
    laws: dict[tuple[str, ...], list[str]] = {}
    for impact in impacts:
        _, law, *outcome = _impact_row(impact)
        laws.setdefault(tuple(outcome), []).append(law)
    return [("", ", ".join(dict.fromkeys(names)), *outcome) for outcome, names in laws.items()]


def _numbers(values: np.ndarray) -> str:
    """A column entry: rounding errors of the other entries are not shown."""
    return " | ".join("-" if np.isnan(value) else f"{value + 0.0:.6g}" for value in values)


def _table(rows: list[tuple[str, ...]], head: tuple[str, ...]) -> list[str]:
    table = [head, *rows]
    widths = [max(len(row[j]) for row in table) for j in range(len(head))]
    return ["  " + "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip()
            for row in table]  # fmt: skip


def as_dictionary(c: Classification) -> dict[str, Any]:
    """Plain lists, numbers and strings."""
    return {
        "t": c.t,
        "kind": c.kind.name,
        "n_solutions": c.n_solutions,
        "is_complete": c.is_complete,
        "is_always_regular": c.is_always_regular,
        "flags": [flag.name for flag in type(c.flags) if flag & c.flags],
        "islands": [
            {
                "contacts": list(island.contacts),
                "kind": island.kind.name,
                "n_solutions": island.n_solutions,
                "is_complete": island.is_complete,
            }
            for island in c.islands
        ],
        "mode": list(c.mode),
        **{
            name: getattr(c, name).tolist()
            for name in ("q", "u", "gamma_N", "gamma_F", "mu", "a", "b", "p", "k", "chatter_ratio", "is_bilateral")
        },
        "solutions": [_solution_dictionary(solution) for solution in c.solutions],
        "impacts": [_impact_dictionary(impact) for impact in c.impacts],
    }


def _impact_dictionary(impact: ImpactAlternative) -> dict[str, Any]:
    numbers = {name: getattr(impact, name).tolist() for name in ("P_N", "P_F", "u", "gamma_N", "gamma_F")}
    return {"law": ImpactLaw(impact.law).name.lower(), "e": impact.e, **numbers}


def _solution_dictionary(solution: ForceSolution) -> dict[str, Any]:
    tag = solution.stability
    return {
        "modes": list(solution.modes),
        **{name: getattr(solution, name).tolist() for name in ("la_N", "la_F", "du", "dgamma_N", "dgamma_F")},
        "stability": tag.kind.name,
        "least_damping": tag.damping,
        "is_unique_force": solution.is_unique_force,
    }
