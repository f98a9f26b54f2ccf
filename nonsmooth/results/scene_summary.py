"""A run of a scene in a few lines of text."""

from __future__ import annotations

import html
from typing import TYPE_CHECKING

import numpy as np

from nonsmooth.mechanics.system import ContactMode
from nonsmooth.numerics.rounding import EPS
from nonsmooth.results.scene_records import CONTACTS, LEDGER, STEP
from nonsmooth.results.summary import ENTRIES_SHOWN, counted_paradoxes, paradox_line

if TYPE_CHECKING:
    from nonsmooth.results.scene_solution import SceneSolution
    from nonsmooth.results.scene_stats import SceneStats

ROUNDINGS_OF_ENERGY = 64  # chosen: of the largest energy or work, that a step may leave in the sum
TOLD_OF_STEPS = 0.01  # chosen: of the largest energy or work, from which the work of the steps is said
POWERS = ("force", "friction", "normal", "surface")  # defined: works that change the kinetic energy


def summary(solution: SceneSolution) -> str:
    """How the run ended, its contacts, its worst figures, its energy and what it cost."""
    stats = solution.stats
    if stats.springs is not None:
        return compliant_summary(solution)
    if np.isnan(stats.tol):
        return summary_as_system(solution)
    by = ", ".join(f"{count} {name}" for name, count in stats.methods.items()) or "none"
    per_step = f" ({stats.wall_time / stats.steps * 1e3:.3g} ms a step)" if stats.steps else ""
    missed = f"; {stats.missed} steps above tol = {stats.tol:g}" if stats.missed else f" (tol = {stats.tol:g})"
    return "\n".join(
        [
            f"{solution.about['scene']}: {solution.message} (t = {solution.t[-1]:.9g} s)",
            f"contacts at the end: {stats.contacts}{modes(solution)} in {stats.islands} islands; "
            f"most {stats.most_contacts}",
            f"worst residual {stats.worst_residual:.1e}{worst_place(stats)}, of the last step "
            f"{stats.last_residual:.1e}{missed}",
            f"worst penetration {stats.worst_penetration:.3g} m, of the last step {stats.last_penetration:.3g} m",
            *paradoxes(solution),
            *joints(solution),
            *(energy(solution) if LEDGER in solution.recorded else []),
            f"{stats.steps} steps, {stats.impacts} with rebounds"
            + (f" ({stats.struck_together} of them of several bodies at once)" if stats.struck_together else "")
            + (f", {stats.rebounds_limited} limited to the energy there was" if stats.rebounds_limited else "")
            + f", {stats.asleep} left out at rest"
            + (f"; islands left out of steps: {stats.islands_asleep}" if stats.islands_asleep else ""),
            f"contact problems of islands solved by {by}; {stats.sweeps} sweeps, {stats.factorisations} factorisations",
            f"wall time {stats.wall_time:.3g} s{per_step}, compiling or loading {stats.compile_time:.3g} s",
        ]
    )


def worst_place(stats: SceneStats) -> str:
    """Where and when the residual was the worst; nothing where none was above 0."""
    if stats.worst_contact < 0:
        return ""
    return f" (contact {stats.worst_contact}, {stats.worst_pair}, at t = {stats.worst_time:.4g} s)"


def compliant_summary(solution: SceneSolution) -> str:
    """The same of a run with compliant contacts: its steps, and how its energy closes."""
    stats, springs = solution.stats, solution.stats.springs
    assert springs is not None
    return "\n".join(
        [
            f"{solution.about['scene']}: {solution.message} (t = {solution.t[-1]:.9g} s)",
            f"{solution.about['integrator']}",
            f"closed contacts at the end: {stats.contacts}{modes(solution)}; most {stats.most_contacts}",
            f"deepest {stats.worst_penetration:.3g} m, at the end {stats.last_penetration:.3g} m",
            *(compliant_energy(solution) if LEDGER in solution.recorded else []),
            f"{stats.steps} steps of {springs.shortest:.2g} to {springs.longest:.2g} s, {springs.rejected} in vain; "
            f"longest step allowed {springs.longest_allowed:.2g} s, 1/omega of the lightest body, omega = "
            f"{springs.omega:.4g} 1/s",
            f"wall time {stats.wall_time:.3g} s, compiling or loading {stats.compile_time:.3g} s",
        ]
    )


def summary_as_system(solution: SceneSolution) -> str:
    """The same of a run that was integrated as its system, whose steps are those of another integrator."""
    stats, about = solution.stats, solution.about
    chosen = f", because {about['chosen']}" if "chosen" in about else ""
    return "\n".join(
        [
            f"{about['scene']}: {solution.message} (t = {solution.t[-1]:.9g} s)",
            f"{about['integrator']}, as its system{chosen}",
            f"closed contacts at the end: {stats.contacts}{modes(solution)}; {about['contacts']}",
            f"worst penetration {stats.worst_penetration:.3g} m",
            *paradoxes(solution),
            *joints(solution),
            *([balance(changes(solution), "error")] if LEDGER in solution.recorded else []),
            f"{stats.steps} steps, {stats.impacts} impacts of contacts",
            f"wall time {stats.wall_time:.3g} s, compiling or loading {stats.compile_time:.3g} s",
        ]
    )


def modes(solution: SceneSolution) -> str:
    """How many contacts of the last record stick, slide and are open, where they were recorded."""
    if CONTACTS not in solution.recorded:
        return ""
    found, named = solution.contacts().mode, (ContactMode.STICK, ContactMode.SLIDE, ContactMode.OPEN)
    return f" ({', '.join(f'{int((found == mode).sum())} {mode.name.lower()}' for mode in named)})"


def paradoxes(solution: SceneSolution) -> list[str]:
    """Where rigid contact left open what happens, of a run in which it did."""
    stats, events = solution.stats, solution.paradoxes
    if not events:
        return []
    episodes = sum(event.n_solutions > 0 for event in events)
    shown = events[:ENTRIES_SHOWN]
    more = [f"  ... and {len(events) - len(shown)} more"] if len(events) > len(shown) else []
    return [
        counted_paradoxes(stats.inconsistent, episodes, stats.indeterminate_steps, stats.steps),
        *(paradox_line(event, f"{event.i}, {event.j}") for event in shown),
        *more,
    ]


def joints(solution: SceneSolution) -> list[str]:
    """How well the joints held, of a scene that has some."""
    count, stats = len(solution.joint_names), solution.stats
    if count == 0:
        return []
    apart = f"apart by up to {stats.worst_joint_drift:.3g} m, in the last step {stats.last_joint_drift:.3g} m"
    return [f"{count} {'joint' if count == 1 else 'joints'}, {apart}"]


def changes(solution: SceneSolution) -> dict[str, float]:
    """Of energies and works, from the start to the end [J]."""
    return {name: float(values[-1] - values[0]) for name, values in solution.ledger.items()}


def balance(change: dict[str, float], is_rest: str) -> str:
    """The kinetic energy as the sum of the works, and what the rest is."""
    works = ", ".join(f"{name} {change[name]:.6g}" for name in POWERS)
    rest = rest_of(change)
    return f"energy: kinetic {change['kinetic']:+.6g} J = work of {works} J (the rest, {rest:+.1g} J, is {is_rest})"


def rest_of(change: dict[str, float]) -> float:
    """What the works leave of the change of the kinetic energy [J]."""
    return change["kinetic"] - sum(change[name] for name in POWERS)


def compliant_energy(solution: SceneSolution) -> list[str]:
    """What became of the energy, where springs hold some."""
    change = changes(solution)
    return [
        balance(change, "error"),
        f"  springs hold {change['elastic']:+.6g} J more, dampers took {-change['damping']:.6g} J",
    ]


def energy(solution: SceneSolution) -> list[str]:
    """What became of the energy."""
    change = changes(solution)
    largest = max(float(np.abs(solution.ledger[name]).max(initial=0.0)) for name in ("kinetic", *POWERS))
    is_rounding = abs(rest_of(change)) <= ROUNDINGS_OF_ENERGY * EPS * max(1, solution.stats.steps) * largest
    of_steps, most = np.abs(solution.ledger[STEP]).max(initial=0.0), TOLD_OF_STEPS * largest
    told = [
        f"  of the work of normals {change[STEP]:+.3g} J is that of the steps, where contacts move over a body: "
        f"more than {TOLD_OF_STEPS:.0%} of the energy, which no law takes; a smaller dt ends this"
    ]
    return [
        balance(change, "rounding" if is_rounding else "the error of the steps, less with a smaller dt"),
        f"  corrections of positions: {change['projection']:+.3g} J of gravity",
        *(told if of_steps > most else []),
    ]


def as_html(solution: SceneSolution) -> str:
    """The summary for a notebook."""
    return f"<pre>{html.escape(summary(solution))}</pre>"
