"""A run in a few lines of text."""

from __future__ import annotations

import html
from collections import Counter
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from nonsmooth.integrators.records import (
    EVENT_FOUND,
    EVENT_KIND,
    EVENT_MODE_0,
    EVENT_MODE_1,
    EVENT_SLIP_0,
    EVENT_SLIP_1,
    EVENT_SOLUTIONS,
    IMPACT,
    INCONSISTENT,
    MODE_CHANGE,
)
from nonsmooth.mechanics.system import ContactMode
from nonsmooth.numerics.rounding import EPS
from nonsmooth.results.events import event_of, mode_name
from nonsmooth.results.ledger import STEP
from nonsmooth.results.recorded import CONTACTS, EVENTS, KINDS, LEDGER, MODES
from nonsmooth.results.stats import energy_gain, friction_gain, rebound_together

if TYPE_CHECKING:
    from nonsmooth.results.events import Event, ParadoxEvent
    from nonsmooth.results.scene_solution import SceneSolution
    from nonsmooth.results.solution import Solution
    from nonsmooth.results.stats import SceneStats

ALIKE = [EVENT_KIND, EVENT_MODE_0, EVENT_SLIP_0, EVENT_MODE_1, EVENT_SLIP_1, EVENT_SOLUTIONS, EVENT_FOUND]
ROUNDINGS_OF_ENERGY = 64  # chosen: of the largest energy or work, that a step may leave in the sum
TOLD_OF_STEPS = 0.01  # chosen: of the largest energy or work, from which the work of the steps is said
POWERS = ("force", "friction", "normal", "surface")  # defined: works that change the kinetic energy
ENTRIES_SHOWN = 12  # chosen: entries of a sequence before the rest is counted


def summary(solution: Solution) -> str:
    """Modes with times, paradoxes and how they were resolved, energy, worst figures and cost."""
    lines = [f"{solution.about.get('system') or 'system'}: {solution.message} (t = {solution.t[-1]:.9g} s)"]
    recorded = solution.recorded
    lines += _chosen(solution) + (_modes(solution) if {MODES, EVENTS} <= set(recorded) else [])
    lines += (_paradoxes(solution) if EVENTS in recorded else []) + _energy(solution, recorded) + _figures(solution)
    left_out = [kind for kind in KINDS if kind not in recorded]
    return "\n".join(lines + ([f"not recorded: {', '.join(left_out)}"] if left_out else []))


def _chosen(solution: Solution | SceneSolution) -> list[str]:
    """Which integrator was chosen, and why; and what ran in the interpreter."""
    about = solution.about
    chosen = [f"{about['integrator']}, because {about['chosen']}"] if "chosen" in about else []
    return chosen + ([f"interpreted: {about['interpreted']}"] if "interpreted" in about else [])


def as_html(result: Solution | SceneSolution) -> str:
    """The summary for a notebook."""
    return f"<pre>{html.escape(result.summary())}</pre>"


def _modes(solution: Solution) -> list[str]:
    if not solution.mode.shape[1]:
        return ["no contacts"]
    rows = solution.event_rows[np.isin(solution.event_rows[:, EVENT_KIND], (MODE_CHANGE, IMPACT))]
    events = [event_of(row) for row in rows[:ENTRIES_SHOWN]]
    dropped = solution.stats.events_dropped
    several = f"; {dropped} more events were not kept" if dropped else ""
    lines = [f"modes: {_count(len(rows), 'change')}{several}; at the end {_at_the_end(solution)}"]
    names = _contacts(solution)
    lines += [f"  {event.t:12.6f} s  {names[event.contact]}  {change_in_words(event)}" for event in events]
    return lines + _counted(rows[ENTRIES_SHOWN:], change_in_words)


def _contacts(solution: Solution) -> list[str]:
    """The names of the contacts, of one width."""
    names = solution.described.contacts
    width = max(map(len, names), default=0)
    return [name.ljust(width) for name in names]


def change_in_words(event: Event) -> str:
    before, after = (mode_name(*pair) for pair in _modes_of(event))
    return f"{before:8} -> {after:8}{'  impact' if event.kind.name == 'IMPACT' else ''}".rstrip()


def _modes_of(event: Event) -> tuple[tuple[int, int], tuple[int, int]]:
    return (event.mode_before, event.slip_before), (event.mode_after, event.slip_after)


def _at_the_end(solution: Solution) -> str:
    names = [mode_name(mode, np.sign(slip)) for mode, slip in zip(solution.mode[-1], solution.slip[-1], strict=True)]
    if len(names) <= 4:
        return ", ".join(names)
    return ", ".join(f"{count} {name}" for name, count in Counter(names).most_common())


def _counted(rest: np.ndarray, words_of: Callable[[Any], str]) -> list[str]:
    """The events beyond those shown, each kind with its number; events that are alike are worded once."""
    if not len(rest):
        return []
    _, first, counts = np.unique(rest[:, ALIKE], axis=0, return_index=True, return_counts=True)
    numbers: Counter[str] = Counter()
    for k in np.argsort(first):
        numbers[words_of(event_of(rest[first[k]]))] += int(counts[k])
    kinds = [f"{_count(count, 'time')} {' '.join(text.split())}" for text, count in numbers.most_common(4)]
    return [f"  ... and {len(rest)} more: {'; '.join(kinds)}{'; ...' if len(numbers) > 4 else ''}"]


def _count(number: int, what: str) -> str:
    return f"{number} {what}" if number == 1 else f"{number} {what}s"


def _paradoxes(solution: Solution) -> list[str]:
    rows = solution.event_rows[solution.event_rows[:, EVENT_KIND] >= INCONSISTENT]
    paradoxes: list[Any] = [event_of(row) for row in rows[:ENTRIES_SHOWN]]
    inconsistent = int((rows[:, EVENT_SOLUTIONS] == 0).sum())
    steps, uncounted = solution.stats.indeterminate_steps, solution.stats.uncounted
    names = _contacts(solution)
    missed = f"; in {uncounted} the solutions were not counted" if uncounted else ""
    lines = [counted_paradoxes(inconsistent, len(rows) - inconsistent, steps, solution.stats.steps, missed)]
    lines += [paradox_line(event, names[event.contact]) for event in paradoxes]
    return lines + _counted(rows[ENTRIES_SHOWN:], paradox_in_words)


def counted_paradoxes(inconsistent: int, episodes: int, several: int, steps: int, missed: str = "") -> str:
    """How many paradoxes there were in so many steps, of which some had several solutions."""
    return (
        f"paradoxes: {inconsistent} inconsistent, {_count(episodes, 'indeterminate episode')} "
        f"({several} of {steps} steps had several solutions{missed})"
    )


def paradox_line(event: ParadoxEvent, where: str) -> str:
    """A paradox with its time and its place, what was taken and with which impulses."""
    what = f"{paradox_in_words(event)}, P_N = {event.P_N:.6g} N s, P_F = {event.P_F:.6g} N s"
    return f"  {event.t:12.6f} s  {where}  {what}"


def paradox_in_words(event: ParadoxEvent) -> str:
    if event.n_solutions == 0:
        return f"no force fits the sliding: impact without collision, then {event.choice}"
    among = f" ({' | '.join(event.alternatives)})" if event.alternatives else ""
    return f"{event.n_solutions} solutions{among}: took {event.choice}"


def _energy(solution: Solution, recorded: tuple[str, ...]) -> list[str]:
    stats = solution.stats
    ledger = solution.find_ledger([0, -1]) if LEDGER in recorded else {}
    done = {name: float(work[-1] - work[0]) for name, work in ledger.items()}
    contact_work = sum(done[name] for name in ("friction", "normal", "surface")) if done else 0.0
    lines = [_balance(done, contact_work)] if done else []
    lines += [f"  {energy_gain(stats)}"] if stats.energy_gains else []
    lines += [f"  {friction_gain(stats)}"] if stats.friction_gains else []
    lines += [f"  {rebound_together(stats, solution.system)}"] if stats.struck_together else []
    if done and ledger["projection"].any():
        lines.append(f"  moving positions back to the surfaces: {ledger['projection'][-1]:+.6g} J")
    if "potential" in done:
        change, potential = done["kinetic"], done["potential"]
        lines.append(
            f"  kinetic + potential {change + potential:+.6g} J, of which contacts {contact_work:+.6g} J; the rest, "
            f"{change + potential - contact_work:+.6g} J, is forces outside the potential and drift"
        )
    return lines


def _balance(done: dict[str, float], contact_work: float) -> str:
    """The change of kinetic energy, where that is known, and the works."""
    works = ", ".join(f"{name} {done[name]:.6g}" for name in ("force", "friction", "normal", "surface"))
    if "kinetic" not in done:
        return f"energy: work of {works} J"
    rest = f"to {abs(done['kinetic'] - done['force'] - contact_work):.1g} J"
    if "mass" in done:
        rest = f"the rest, {done['mass']:+.6g} J, goes with the changing mass"
    return f"energy: kinetic {done['kinetic']:+.6g} J = work of {works} J ({rest})"


def _figures(solution: Solution) -> list[str]:
    stats = solution.stats
    shared = f"; in {stats.shared} the impulses are one share of many" if stats.shared else ""
    per_step = f" ({stats.wall_time / stats.steps * 1e9:.0f} ns a step)" if stats.steps else ""
    balance = f", energy balance of a step {stats.ledger_error:.1e}" if LEDGER in solution.recorded else ""
    return [
        f"worst residual {stats.worst_residual:.1e}, penetration {stats.worst_penetration:.3g} m{balance}",
        f"{stats.steps} steps; contact problems: {stats.lcp_solved} solved ({stats.lcp_kept} kept), "
        f"{stats.lcp_skipped} steps without any{shared}",
        f"wall time {stats.wall_time:.3g} s{per_step}, compiling or loading {stats.compile_time:.3g} s",
    ]


def scene_summary(solution: SceneSolution) -> str:
    """How the run ended, its contacts, its worst figures, its energy and what it cost."""
    stats = solution.stats
    if stats.springs is not None:
        return _compliant_summary(solution)
    if np.isnan(stats.tol):
        return _summary_as_system(solution)
    by = ", ".join(f"{count} {name}" for name, count in stats.methods.items()) or "none"
    per_step = f" ({stats.wall_time / stats.steps * 1e3:.3g} ms a step)" if stats.steps else ""
    missed = f"; {stats.missed} steps above tol = {stats.tol:g}" if stats.missed else f" (tol = {stats.tol:g})"
    return "\n".join(
        [
            f"{solution.about['scene']}: {solution.message} (t = {solution.t[-1]:.9g} s)",
            *_chosen(solution),
            f"contacts at the end: {stats.contacts}{_modes_in_scene(solution)} in {stats.islands} islands; "
            f"most {stats.most_contacts}",
            f"worst residual {stats.worst_residual:.1e}{worst_place(stats)}, of the last step "
            f"{stats.last_residual:.1e}{missed}",
            f"worst penetration {stats.worst_penetration:.3g} m, of the last step {stats.last_penetration:.3g} m",
            *_paradoxes_in_scene(solution),
            *_joints(solution),
            *(_energy_of_scene(solution) if LEDGER in solution.recorded else []),
            f"{stats.steps} steps{_lengths(stats)}, {stats.impacts} with rebounds"
            + (f" ({stats.struck_together} of them of several bodies at once)" if stats.struck_together else "")
            + (f", {stats.rebounds_limited} limited to the energy there was" if stats.rebounds_limited else "")
            + f", {stats.asleep} left out at rest"
            + (f"; islands left out of steps: {stats.islands_asleep}" if stats.islands_asleep else ""),
            f"contact problems of islands solved by {by}; {stats.sweeps} sweeps, {stats.factorisations} factorisations",
            f"wall time {stats.wall_time:.3g} s{per_step}, compiling or loading {stats.compile_time:.3g} s",
        ]
    )


def _lengths(stats: SceneStats) -> str:
    """Of steps that were chosen by their error."""
    if stats.lengths is None:
        return ""
    return f" of {stats.lengths.shortest:.2g} to {stats.lengths.longest:.2g} s, {stats.lengths.rejected} in vain"


def worst_place(stats: SceneStats) -> str:
    """Where and when the residual was the worst; nothing where none was above 0."""
    if stats.worst_contact < 0:
        return ""
    return f" (contact {stats.worst_contact}, {stats.worst_pair}, at t = {stats.worst_time:.4g} s)"


def _compliant_summary(solution: SceneSolution) -> str:
    """The same of a run with compliant contacts: its steps, and how its energy closes."""
    stats, springs = solution.stats, solution.stats.springs
    assert springs is not None
    return "\n".join(
        [
            f"{solution.about['scene']}: {solution.message} (t = {solution.t[-1]:.9g} s)",
            f"{solution.about['integrator']}",
            f"closed contacts at the end: {stats.contacts}{_modes_in_scene(solution)}; most {stats.most_contacts}",
            f"deepest {stats.worst_penetration:.3g} m, at the end {stats.last_penetration:.3g} m",
            *(_compliant_energy(solution) if LEDGER in solution.recorded else []),
            f"{stats.steps} steps{_lengths(stats)}; longest step allowed {springs.longest_allowed:.2g} s, 1/omega of "
            f"the lightest body, omega = {springs.omega:.4g} 1/s",
            f"wall time {stats.wall_time:.3g} s, compiling or loading {stats.compile_time:.3g} s",
        ]
    )


def _summary_as_system(solution: SceneSolution) -> str:
    """The same of a run that was integrated as its system, whose steps are those of another integrator."""
    stats, about = solution.stats, solution.about
    chosen = f", because {about['chosen']}" if "chosen" in about else ""
    return "\n".join(
        [
            f"{about['scene']}: {solution.message} (t = {solution.t[-1]:.9g} s)",
            f"{about['integrator']}, as its system{chosen}",
            f"closed contacts at the end: {stats.contacts}{_modes_in_scene(solution)}; {about['contacts']}",
            f"worst penetration {stats.worst_penetration:.3g} m",
            *_paradoxes_in_scene(solution),
            *_joints(solution),
            *([_balance_of_scene(_changes(solution), "error")] if LEDGER in solution.recorded else []),
            f"{stats.steps} steps, {stats.impacts} impacts of contacts",
            f"wall time {stats.wall_time:.3g} s, compiling or loading {stats.compile_time:.3g} s",
        ]
    )


def _modes_in_scene(solution: SceneSolution) -> str:
    """How many contacts of the last record stick, slide and are open, where they were recorded."""
    if CONTACTS not in solution.recorded:
        return ""
    found, named = solution.contacts().mode, (ContactMode.STICK, ContactMode.SLIDE, ContactMode.OPEN)
    return f" ({', '.join(f'{int((found == mode).sum())} {mode.name.lower()}' for mode in named)})"


def _paradoxes_in_scene(solution: SceneSolution) -> list[str]:
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


def _joints(solution: SceneSolution) -> list[str]:
    """How well the joints held, of a scene that has some."""
    count, stats = len(solution.joint_names), solution.stats
    if count == 0:
        return []
    apart = f"apart by up to {stats.worst_joint_drift:.3g} m, in the last step {stats.last_joint_drift:.3g} m"
    return [f"{count} {'joint' if count == 1 else 'joints'}, {apart}"]


def _changes(solution: SceneSolution) -> dict[str, float]:
    """Of energies and works, from the start to the end [J]."""
    return {name: float(values[-1] - values[0]) for name, values in solution.ledger.items()}


def _balance_of_scene(change: dict[str, float], is_rest: str) -> str:
    """The kinetic energy as the sum of the works, and what the rest is."""
    works = ", ".join(f"{name} {change[name]:.6g}" for name in POWERS)
    rest = _rest_of(change)
    return f"energy: kinetic {change['kinetic']:+.6g} J = work of {works} J (the rest, {rest:+.1g} J, is {is_rest})"


def _rest_of(change: dict[str, float]) -> float:
    """What the works leave of the change of the kinetic energy [J]."""
    return change["kinetic"] - sum(change[name] for name in POWERS)


def _compliant_energy(solution: SceneSolution) -> list[str]:
    """What became of the energy, where springs hold some."""
    change = _changes(solution)
    return [
        _balance_of_scene(change, "error"),
        f"  springs hold {change['elastic']:+.6g} J more, dampers took {-change['damping']:.6g} J",
    ]


def _energy_of_scene(solution: SceneSolution) -> list[str]:
    """What became of the energy."""
    change = _changes(solution)
    largest = max(float(np.abs(solution.ledger[name]).max(initial=0.0)) for name in ("kinetic", *POWERS))
    is_rounding = abs(_rest_of(change)) <= ROUNDINGS_OF_ENERGY * EPS * max(1, solution.stats.steps) * largest
    of_steps, most = np.abs(solution.ledger[STEP]).max(initial=0.0), TOLD_OF_STEPS * largest
    told = [
        f"  of the work of normals {change[STEP]:+.3g} J is that of the steps, where contacts move over a body: "
        f"more than {TOLD_OF_STEPS:.0%} of the energy, which no law takes; a smaller dt ends this"
    ]
    return [
        _balance_of_scene(change, "rounding" if is_rounding else "the error of the steps, less with a smaller dt"),
        f"  corrections of positions: {change['projection']:+.3g} J of gravity",
        *(told if of_steps > most else []),
    ]
