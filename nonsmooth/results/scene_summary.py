"""A run of a scene in a few lines of text."""

from __future__ import annotations

import html
from typing import TYPE_CHECKING

from nonsmooth.mechanics.system import ContactMode

if TYPE_CHECKING:
    from nonsmooth.results.scene_solution import SceneSolution


def summary(solution: SceneSolution) -> str:
    """How the run ended, its contacts, its worst figures, its energy and what it cost."""
    stats, ledger = solution.stats, solution.ledger
    contacts = solution.contacts()
    named = (ContactMode.STICK, ContactMode.SLIDE, ContactMode.OPEN)
    modes = ", ".join(f"{int((contacts.mode == mode).sum())} {mode.name.lower()}" for mode in named)
    by = ", ".join(f"{count} {name}" for name, count in stats.methods.items()) or "none"
    change = {name: float(values[-1] - values[0]) for name, values in ledger.items()}
    works = ", ".join(f"{name} {change[name]:.6g}" for name in ("force", "friction", "normal", "surface"))
    rest = change["kinetic"] - sum(change[name] for name in ("force", "friction", "normal", "surface"))
    if stats.springs is not None:
        return compliant_summary(solution, f"{len(contacts)} ({modes}); most {stats.most_contacts}", change)
    per_step = f" ({stats.wall_time / stats.steps * 1e3:.3g} ms a step)" if stats.steps else ""
    missed = f"; {stats.missed} steps above tol = {stats.tol:g}" if stats.missed else f" (tol = {stats.tol:g})"
    return "\n".join(
        [
            f"{solution.about['scene']}: {solution.message} (t = {solution.t[-1]:.9g} s)",
            f"contacts at the end: {len(contacts)} ({modes}) in {stats.islands} islands; most {stats.most_contacts}",
            f"worst residual {stats.worst_residual:.1e}, of the last step {stats.last_residual:.1e}{missed}",
            f"worst penetration {stats.worst_penetration:.3g} m, of the last step {stats.last_penetration:.3g} m",
            f"energy: kinetic {change['kinetic']:+.6g} J = work of {works} J (the rest, {rest:+.1g} J, is rounding)",
            f"  bodies moved beside their velocities: {change['projection']:+.3g} J of gravity",
            f"{stats.steps} steps, {stats.impacts} with rebounds, {stats.asleep} left out at rest",
            f"contact problems of islands solved by {by}; {stats.sweeps} sweeps, {stats.factorisations} factorisations",
            f"wall time {stats.wall_time:.3g} s{per_step}, compiling or loading {stats.compile_time:.3g} s",
        ]
    )


def compliant_summary(solution: SceneSolution, contacts: str, change: dict[str, float]) -> str:
    """The same of a run with compliant contacts: its steps, and how its energy closes."""
    stats, springs = solution.stats, solution.stats.springs
    assert springs is not None
    works = ", ".join(f"{name} {change[name]:.6g}" for name in ("force", "friction", "normal", "surface"))
    rest = change["kinetic"] - sum(change[name] for name in ("force", "friction", "normal", "surface"))
    return "\n".join(
        [
            f"{solution.about['scene']}: {solution.message} (t = {solution.t[-1]:.9g} s)",
            f"{solution.about['integrator']}",
            f"closed contacts at the end: {contacts}",
            f"deepest {stats.worst_penetration:.3g} m, at the end {stats.last_penetration:.3g} m",
            f"energy: kinetic {change['kinetic']:+.6g} J = work of {works} J (the rest, {rest:+.1g} J, is error)",
            f"  springs hold {change['elastic']:+.6g} J more, dampers took {-change['damping']:.6g} J",
            f"{stats.steps} steps of {springs.shortest:.2g} to {springs.longest:.2g} s, {springs.rejected} in vain; "
            f"longest step allowed {springs.longest_allowed:.2g} s, 1/omega of the lightest body, omega = "
            f"{springs.omega:.4g} 1/s",
            f"wall time {stats.wall_time:.3g} s, compiling or loading {stats.compile_time:.3g} s",
        ]
    )


def as_html(solution: SceneSolution) -> str:
    """The summary for a notebook."""
    return f"<pre>{html.escape(summary(solution))}</pre>"
