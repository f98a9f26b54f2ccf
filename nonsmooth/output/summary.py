"""A run in a few lines of text."""

from __future__ import annotations

import html
from typing import TYPE_CHECKING

import numpy as np

from nonsmooth.system import ContactMode

if TYPE_CHECKING:
    from nonsmooth.solution import Event, ParadoxEvent, Solution

SHOWN = 12  # entries of a sequence before the rest is counted


def summary(solution: Solution) -> str:
    """Modes with times, paradoxes and how they were resolved, energy, worst figures and cost."""
    lines = [f"{solution.about.get('system', 'system')}: {solution.message} (t = {solution.t[-1]:.9g} s)"]
    lines += _modes(solution) + _paradoxes(solution) + _energy(solution) + _figures(solution)
    return "\n".join(lines)


def as_html(solution: Solution) -> str:
    """The summary for a notebook."""
    return f"<pre>{html.escape(summary(solution))}</pre>"


def _modes(solution: Solution) -> list[str]:
    events = [event for event in solution.events if _is_change(event)]
    lines = [f"modes: {len(events)} changes"]
    for event in events[:SHOWN]:
        lines.append(
            f"  {event.t:12.6f} s  contact {event.contact}  {_mode(event.mode_before, event.slip_before):8} -> "
            f"{_mode(event.mode_after, event.slip_after):8}" + ("  impact" if event.kind.name == "IMPACT" else "")
        )
    return _shortened(lines, len(events))


def _is_change(event: Event) -> bool:
    return event.kind.name in ("MODE_CHANGE", "IMPACT")


def _paradoxes(solution: Solution) -> list[str]:
    paradoxes = solution.paradoxes
    inconsistent = sum(event.n_solutions == 0 for event in paradoxes)
    steps = solution.stats.indeterminate_steps
    lines = [
        f"paradoxes: {inconsistent} inconsistent, {len(paradoxes) - inconsistent} indeterminate episodes "
        f"({steps} of {solution.stats.steps} steps had several solutions)"
    ]
    lines += [_paradox(event) for event in paradoxes[:SHOWN]]
    return _shortened(lines, len(paradoxes))


def _paradox(event: ParadoxEvent) -> str:
    impulses = f"P_N = {event.P_N:.6g} N s, P_F = {event.P_F:.6g} N s"
    if event.n_solutions == 0:
        outcome = f"no force fits the sliding: impact without collision, {impulses}"
        return f"  {event.t:12.6f} s  contact {event.contact}  {outcome}"
    among = " | ".join(event.alternatives) or f"{event.n_solutions} solutions"
    return f"  {event.t:12.6f} s  contact {event.contact}  {among}: took {event.choice}"


def _energy(solution: Solution) -> list[str]:
    ledger = solution.ledger
    change = ledger["kinetic"][-1] - ledger["kinetic"][0]
    works = ", ".join(f"{name} {ledger[name][-1]:.6g}" for name in ("force", "friction", "normal", "surface"))
    lines = [f"energy: kinetic {change:+.6g} J = work of {works} J"]
    if "potential" in ledger:
        total = ledger["kinetic"] + ledger["potential"]
        lines.append(f"  kinetic + potential changed by {total[-1] - total[0]:+.6g} J")
    return lines


def _figures(solution: Solution) -> list[str]:
    stats = solution.stats
    per_step = stats.wall_time / stats.steps * 1e9 if stats.steps else float("nan")
    return [
        f"worst residual {stats.worst_residual:.1e}, penetration {stats.worst_penetration:.3g} m, "
        f"energy balance of a step {stats.ledger_error:.1e}",
        f"{stats.steps} steps; contact problems: {stats.lcp_solved} solved ({stats.lcp_kept} kept), "
        f"{stats.lcp_skipped} steps without any",
        f"wall time {stats.wall_time:.3g} s ({per_step:.0f} ns a step), compiling or loading "
        f"{stats.compile_time:.3g} s",
    ]


def _shortened(lines: list[str], total: int) -> list[str]:
    return [*lines, f"  ... and {total - SHOWN} more"] if total > SHOWN else lines


def _mode(mode: int, slip: int) -> str:
    return ContactMode(mode).name.lower() + {1: " +", -1: " -", 0: ""}[int(np.sign(slip))]
