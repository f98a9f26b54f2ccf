"""A run of a scene in a few lines of text."""

from __future__ import annotations

import html
from typing import TYPE_CHECKING

from nonsmooth.mechanics.system import ContactMode
from nonsmooth.results.scene_records import CONTACTS, LEDGER

if TYPE_CHECKING:
    from nonsmooth.results.scene_solution import SceneSolution


def summary(solution: SceneSolution) -> str:
    """How the run ended, its contacts, its worst figures, its energy and what it cost."""
    stats = solution.stats
    by = ", ".join(f"{count} {name}" for name, count in stats.methods.items()) or "none"
    per_step = f" ({stats.wall_time / stats.steps * 1e3:.3g} ms a step)" if stats.steps else ""
    missed = f"; {stats.missed} steps above tol = {stats.tol:g}" if stats.missed else f" (tol = {stats.tol:g})"
    return "\n".join(
        [
            f"{solution.about['scene']}: {solution.message} (t = {solution.t[-1]:.9g} s)",
            f"contacts at the end: {stats.contacts}{modes(solution)} in {stats.islands} islands; "
            f"most {stats.most_contacts}",
            f"worst residual {stats.worst_residual:.1e}, of the last step {stats.last_residual:.1e}{missed}",
            f"worst penetration {stats.worst_penetration:.3g} m, of the last step {stats.last_penetration:.3g} m",
            *(energy(solution) if LEDGER in solution.recorded else []),
            f"{stats.steps} steps, {stats.impacts} with rebounds, {stats.asleep} left out at rest",
            f"contact problems of islands solved by {by}; {stats.sweeps} sweeps, {stats.factorisations} factorisations",
            f"wall time {stats.wall_time:.3g} s{per_step}, compiling or loading {stats.compile_time:.3g} s",
        ]
    )


def modes(solution: SceneSolution) -> str:
    """How many contacts of the last record stick, slide and are open, where they were recorded."""
    if CONTACTS not in solution.recorded:
        return ""
    found, named = solution.contacts().mode, (ContactMode.STICK, ContactMode.SLIDE, ContactMode.OPEN)
    return f" ({', '.join(f'{int((found == mode).sum())} {mode.name.lower()}' for mode in named)})"


def energy(solution: SceneSolution) -> list[str]:
    """What became of the energy."""
    change = {name: float(values[-1] - values[0]) for name, values in solution.ledger.items()}
    works = ", ".join(f"{name} {change[name]:.6g}" for name in ("force", "friction", "normal", "surface"))
    rest = change["kinetic"] - sum(change[name] for name in ("force", "friction", "normal", "surface"))
    return [
        f"energy: kinetic {change['kinetic']:+.6g} J = work of {works} J (the rest, {rest:+.1g} J, is rounding)",
        f"  bodies moved beside their velocities: {change['projection']:+.3g} J of gravity",
    ]


def as_html(solution: SceneSolution) -> str:
    """The summary for a notebook."""
    return f"<pre>{html.escape(summary(solution))}</pre>"
