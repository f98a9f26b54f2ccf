"""What is kept of a run in a sweep: numbers, by name.

    amplitude   a_j = (max q_j - min q_j) / 2 over the window, the last part of the run; and by which part of it the
                range over a half of the window is smaller: of a settled motion, whose period fits into a half, by none
    period      mean time between two upward crossings of (max q_j + min q_j) / 2 in the window; and by which part of
                it those of the earlier and of the later crossings differ
    modes       the modes of the contacts in the order of their beginning

Each is read from the arrays of the compiled block, and from a Solution where the run is not made in blocks.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from nonsmooth.errors import UnknownName, nearest
from nonsmooth.integrators.records import (
    EVENT_CONTACT,
    EVENT_KIND,
    EVENT_MODE_1,
    EVENT_SLIP_1,
    IMPACT,
    INCONSISTENT,
    INDETERMINATE,
    MODE_CHANGE,
    Worst,
)
from nonsmooth.jit.blocks import fields_of
from nonsmooth.results.events import mode_name
from nonsmooth.results.solution import Solution
from nonsmooth.sweeps.block_engine import N_CODES, STILL_COORDINATE, Cells
from nonsmooth.sweeps.task import OF_COORDINATE, Variable

Values = dict[str, np.ndarray]
RESIDUAL, PENETRATION = (list(fields_of(Worst)).index(name) for name in ("residual", "penetration"))  # derived: columns
# chosen: of an amplitude: that between two halves of a window which resolves the motion differs by less
SETTLED_AMPLITUDE = 0.01


@dataclass(frozen=True)
class Measure:
    """A kind of result.

    Attributes
    ----------
    variables : dict
        What it gives.
    of_cells : callable
        (Cells) -> values (N, ...).
    of_solution : callable
        (Solution, first record of the window) -> values of one cell.
    needs_motion, needs_sequence, needs_events : bool
        What the compiled block has to keep for it.
    """

    variables: dict[str, Variable]
    of_cells: Callable[[Cells], Values]
    of_solution: Callable[[Solution, int], dict[str, Any]]
    needs_motion: bool = False
    needs_sequence: bool = False
    needs_events: bool = False


def count_events(name: str, meaning: str, *kinds: int) -> Measure:
    """The number of events of some kinds."""
    return Measure(
        {name: Variable(meaning=meaning)},
        lambda cells: {name: cells.events[:, list(kinds)].sum(axis=1).astype(float)},
        lambda solution, _: {name: np.isin(solution.event_rows[:, EVENT_KIND], kinds).sum()},
        needs_events=True,
    )


def amplitude_of(solution: Solution, first: int) -> dict[str, Any]:
    """Half the range of each coordinate over the window, and how much smaller it is in a half of it."""
    t, q = solution.t[first:], solution.q[first:]
    if not solution.success:
        return dict.fromkeys(("amplitude", "amplitude_change"), np.full(q.shape[1], np.nan))
    half = min(int(np.searchsorted(t, 0.5 * (t[0] + t[-1]))), len(t) - 1)
    low, high = q.min(axis=0), q.max(axis=0)
    parts = [np.ptp(part, axis=0) if len(part) else np.zeros(q.shape[1]) for part in (q[:half], q[half:])]
    moves = high - low > STILL_COORDINATE * np.maximum(abs(low), abs(high))
    change = 1.0 - np.minimum(*parts) / np.where(moves, high - low, 1.0)
    return {"amplitude": 0.5 * (high - low), "amplitude_change": np.where(moves, change, 0.0)}


def period_of(solution: Solution, first: int) -> dict[str, Any]:
    """Mean time between upward crossings of the middle of the range, of each coordinate."""
    t, q = solution.t[first:], solution.q[first:]
    low, high = q.min(axis=0), q.max(axis=0)
    middle = 0.5 * (low + high)
    period = np.full(q.shape[1], np.nan)
    change = np.full(q.shape[1], 0.0 if solution.success else np.nan)
    for j in (
        np.flatnonzero(high - low > STILL_COORDINATE * np.maximum(abs(low), abs(high))) if solution.success else ()
    ):
        below, above = q[:-1, j] - middle[j], q[1:, j] - middle[j]
        k = np.flatnonzero((below < 0) & (above >= 0))
        times = t[k] + (t[k + 1] - t[k]) * below[k] / (below[k] - above[k])
        change[j] = 1.0
        if len(k) > 1:
            period[j] = (times[-1] - times[0]) / (len(k) - 1)
        if len(k) > 2:
            central = (len(k) - 1) // 2
            early, late = (times[central] - times[0]) / central, (times[-1] - times[central]) / (len(k) - 1 - central)
            change[j] = abs(late - early) / period[j]
    return {"period": period, "period_change": change}


def modes_of_cells(cells: Cells) -> Values:
    """The sequences of codes as texts; equal sequences are worded once."""
    rows, place = np.unique(np.column_stack([cells.codes, cells.n_codes]), axis=0, return_inverse=True)
    n_c = cells.mode.shape[1]
    texts = np.array([sequence(row[:-1][row[:-1] >= 0], n_c, row[-1]) for row in rows], dtype=object)
    return {"modes": texts[place.reshape(-1)]}


def modes_of(solution: Solution, _: int) -> dict[str, Any]:
    """The sequence of modes as a text."""
    rows = solution.event_rows
    rows = rows[np.isin(rows[:, EVENT_KIND], (MODE_CHANGE, IMPACT))]
    n_c = solution.mode.shape[1]
    codes = [code(i, solution.mode[0, i], solution.slip[0, i]) for i in range(n_c)]
    codes += [code(*row) for row in rows[:, [EVENT_CONTACT, EVENT_MODE_1, EVENT_SLIP_1]].astype(int)]
    return {"modes": sequence(np.array(codes[:N_CODES], dtype=int), n_c, len(codes))}


def code(contact: int, mode: int, slip: int) -> int:
    """A mode as the compiled block writes it."""
    return 16 * contact + 4 * mode + slip + 1


def sequence(codes: np.ndarray, n_c: int, total: int) -> str:
    """Codes as "slide -, stick, slide +"; of several contacts, each with its number."""
    parts = [(f"{c // 16}: " if n_c > 1 else "") + mode_name(c // 4 % 4, c % 4 - 1) for c in codes.tolist()]
    return ", ".join(parts) + (f", {total - len(parts)} more" if total > len(parts) else "")


MEASURES = {
    "final_state": Measure(
        {"q": Variable(("coordinate",), OF_COORDINATE, "coordinates at the end"),
         "u": Variable(("coordinate",), f"{OF_COORDINATE}/s", "velocities at the end")},
        lambda cells: {"q": cells.q, "u": cells.u},
        lambda solution, _: {"q": solution.q[-1], "u": solution.u[-1]},
    ),
    "amplitude": Measure(
        {"amplitude": Variable(("coordinate",), OF_COORDINATE, "half the range over the window"),
         "amplitude_change": Variable(("coordinate",), "", "part of it that a half of the window lacks")},
        lambda cells: {"amplitude": 0.5 * (cells.high - cells.low), "amplitude_change": cells.change.copy()},
        amplitude_of, needs_motion=True,
    ),
    "period": Measure(
        {"period": Variable(("coordinate",), "s", "mean time between upward crossings of the middle of the range"),
         "period_change": Variable(("coordinate",), "", "part of it by which earlier and later crossings differ")},
        lambda cells: {"period": cells.period, "period_change": cells.period_change.copy()},
        period_of, needs_motion=True,
    ),
    "modes": Measure(
        {"modes": Variable(meaning="modes of the contacts in the order of their beginning", is_text=True)},
        modes_of_cells, modes_of, needs_sequence=True, needs_events=True,
    ),
    "paradoxes": count_events("paradoxes", "events without a solution, or with several", INCONSISTENT, INDETERMINATE),
    "inconsistent": count_events("inconsistent", "impacts without collision", INCONSISTENT),
    "indeterminate": count_events("indeterminate", "episodes with several solutions", INDETERMINATE),
    "impacts": count_events("impacts", "impacts", IMPACT),
    "mode_changes": count_events("mode_changes", "changes of mode, impacts among them", MODE_CHANGE, IMPACT),
    "residual": Measure(
        {"residual": Variable(meaning="worst residual of a contact problem, relative to max |c|")},
        lambda cells: {"residual": cells.worst[:, RESIDUAL]},
        lambda solution, _: {"residual": solution.stats.worst_residual},
    ),
    "penetration": Measure(
        {"penetration": Variable((), "m", "deepest gap at a mid-point")},
        lambda cells: {"penetration": cells.worst[:, PENETRATION]},
        lambda solution, _: {"penetration": solution.stats.worst_penetration},
    ),
    "end_time": Measure(
        {"end_time": Variable((), "s", "time reached")},
        lambda cells: {"end_time": cells.t}, lambda solution, _: {"end_time": solution.t[-1]},
    ),
}  # fmt: skip


CHANGES = {"amplitude_change": "amplitude", "period_change": "period"}  # and what they are of


def settled(values: Values, tolerance: float) -> np.ndarray | None:
    """(N,) 1 where every amplitude and period agrees within the window, 0 where one does not, NaN where a run did not
    reach its end; None where nothing of that kind is measured."""
    changes = [values[name] for name in CHANGES if name in values]
    if not changes:
        return None
    change = np.concatenate(changes, axis=1)
    return np.where(np.isnan(change).any(axis=1), np.nan, (change <= tolerance).all(axis=1))


def doubt_of(values: Values, tolerance: float) -> str:
    """What is to be said of motions that have not settled; nothing where all have."""
    found = settled(values, tolerance)
    if found is None or not (found == 0.0).any():
        return ""
    worst = {what: values[name] for name, what in CHANGES.items() if name in values}
    parts = [
        f"the {what} still changes in {int((change > tolerance).any(axis=1).sum())} of {len(change)} cells, by up to "
        f"{np.nanmax(change):.0%} from one half of the window to the other ({what}_change)"
        for what, change in worst.items() if (change > tolerance).any()
    ]  # fmt: skip
    return (
        f"{'; '.join(parts)}: these motions have not settled to {tolerance:g}, drift, or repeat more slowly "
        "(settled = 0); take a later end, a later window, or settle_by=, until which such runs are made longer"
    )


def measure_named(name: str) -> Measure:
    """A measure by its name, or `UnknownName` with the nearest."""
    if name not in MEASURES:
        raise UnknownName(f"there is no measure {name!r}; {nearest(name, MEASURES)}")
    return MEASURES[name]
