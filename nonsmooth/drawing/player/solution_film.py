"""The film of a planar run: the lines of a model's ``shape(q)`` as bodies, its contacts where the model says they act.

A model may give ``outline()``, lines of the surroundings; ``parts``, the names of what ``shape`` gives;
the contacts where their ``at(q)`` says. Only records are shown, none between two.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from nonsmooth.drawing import colours
from nonsmooth.drawing.forces import record_after
from nonsmooth.drawing.labels import spelt
from nonsmooth.drawing.player.film import Body, Contacts, Curve, Film, Mark, MarkKind, Shape, ShapeKind, no_contacts
from nonsmooth.drawing.player.rigid_fit import is_closed, pose_of, seen_from
from nonsmooth.drawing.plots import nearest_records, some_of
from nonsmooth.drawing.scene import scene_model
from nonsmooth.integrators.records import EVENT_T, EVENT_WIDTH
from nonsmooth.jit import interpreted
from nonsmooth.mechanics.laws import static_coefficient
from nonsmooth.results.events import ParadoxEvent, event_of
from nonsmooth.results.ledger import ELASTIC, ENERGIES
from nonsmooth.results.recorded import COORDINATES, EVENTS, GAPS, IMPULSES, LEDGER, MODES, VELOCITIES
from nonsmooth.results.summary import change_in_words, paradox_in_words

if TYPE_CHECKING:
    from nonsmooth.results.events import Event
    from nonsmooth.results.solution import Solution

RECORDS_SHOWN = 1200  # chosen: frames equally spaced in time: 20 s at 60 a second
EVENTS_SHOWN = 400  # chosen: marked on the time line, the record before and the one after among the frames
OTHER_WORK = (colours.CYCLE[5], colours.DASHES)  # chosen: of a work without a colour of its own: that of no other
DOTS = (1.0, 2.0)  # chosen: dashes and gaps of a dotted line, in its widths
HELD = (*ENERGIES, ELASTIC)  # defined: columns of a ledger that are energies
Lines = list[np.ndarray]


def film_of_solution(solution: Solution) -> Film:
    """The film of a run of a model with a ``shape(q)``.

    Parameters
    ----------
    solution : Solution

    Returns
    -------
    Film

    Raises
    ------
    InvalidInput
        When the model has no ``shape(q)``, or the solution was read from a file.
    """
    model = scene_model(solution)
    rows = solution.event_rows[:EVENTS_SHOWN] if EVENTS in solution.recorded else np.zeros((0, EVENT_WIDTH))
    records = records_shown(solution, rows[:, EVENT_T])
    bodies, centres, angles = bodies_of(model, solution.q[records])
    return Film(
        title=str(solution.about.get("system", "")),
        times=solution.t[records],
        bodies=tuple(bodies),
        position=np.stack(centres, axis=1),
        turn=np.stack(angles, axis=1),
        contacts=contacts_of(solution, model, records),
        contact_names=tuple(contact.name for contact in solution.system.contacts) if solution.system else (),
        marks=marks_of(solution, rows, records),
        curves=tuple(curves_of(solution, records)),
        about=about_in_words(solution),
        detail=detail_of(solution, records),
    )


def records_shown(solution: Solution, t_events: np.ndarray) -> np.ndarray:
    """The records nearest to equally spaced instants, and those before and after each event."""
    after = record_after(solution.t, t_events)
    every = np.concatenate([nearest_records(solution.t, RECORDS_SHOWN), [0], after, np.maximum(after - 1, 0)])
    return np.unique(every)


def bodies_of(model: Any, q: np.ndarray) -> tuple[list[Body], Lines, Lines]:
    """Bodies, their positions (n_t, 2) and angles (n_t,): those of the surroundings first."""
    bodies, centres, angles = [], [], []
    n_t = len(q)
    for k, line in enumerate(model.outline() if model.outline else []):
        bodies.append(Body(f"surroundings {k}", (still_shape(line),), is_fixed=True))
        centres.append(np.zeros((n_t, 2)))
        angles.append(np.zeros(n_t))
    shapes = [model.shape(state) for state in q]
    names = model.parts or shapes[0].names
    for k, name in enumerate(names):
        lines = np.stack([lines_now[k] for lines_now in shapes])
        pose = pose_of(lines)
        shape = (
            still_shape(lines[0] - pose.centre[0])
            if pose.is_rigid
            else Shape(ShapeKind.BENDING, seen_from(pose, lines))
        )
        bodies.append(Body(name, (shape,)))
        centres.append(pose.centre)
        angles.append(pose.angle)
    return bodies, centres, angles


def still_shape(line: np.ndarray) -> Shape:
    """A closed line as a polygon, an open one as a polyline, in the frame of its body."""
    return Shape(ShapeKind.POLYGON, line[:-1]) if is_closed(line) else Shape(ShapeKind.POLYLINE, line)


def contacts_of(solution: Solution, model: Any, records: np.ndarray) -> Contacts:
    """The contacts of each frame whose place is known, open ones too; their impulses since the frame before."""
    n_t = len(records)
    if model.contact_frames is None or not {MODES, IMPULSES} <= set(solution.recorded):
        return no_contacts(n_t, 2)
    frames = np.array([model.contact_frames(q) for q in solution.q[records]])
    placed = np.flatnonzero(np.isfinite(frames).all(axis=(0, 1, 3)))
    point, normal, tangent = (frames[:, k, placed].reshape(-1, 2) for k in range(3))
    P_N, P_F = (impulses_between(P, records)[:, placed] for P in (solution.P_N, solution.P_F))
    return Contacts(
        start=np.arange(n_t + 1) * len(placed),
        number=np.tile(placed, n_t),
        point=point,
        normal=normal,
        mode=solution.mode[records][:, placed].reshape(-1),
        slip=np.sign(solution.slip[records][:, placed]).reshape(-1),
        P_N=P_N.reshape(-1),
        P_F=P_F.sum(axis=2).reshape(-1, 1) * tangent,  # d = 0 without friction, else 1
        mu=np.tile(cone_coefficients(solution)[placed], n_t),
    )


def impulses_between(P: np.ndarray, records: np.ndarray) -> np.ndarray:
    """The sum of the impulses of the records after the frame before, up to its own; the last one is the end."""
    sums = np.zeros((len(records), *P.shape[1:]))
    if len(records) > 1:
        sums[1:] = np.add.reduceat(P, records[:-1] + 1)
    return sums


def cone_coefficients(solution: Solution) -> np.ndarray:
    """The coefficient of each contact up to which it sticks (n_c,), or slides where its law has no sticking."""
    system: Any = solution.system
    mu = interpreted(static_coefficient)
    return np.array([mu(system.laws, i) for i in range(system.n_c)])


def marks_of(solution: Solution, rows: np.ndarray, records: np.ndarray) -> tuple[Mark, ...]:
    """The events that are kept, and those of the user, in words."""
    frames = np.searchsorted(records, record_after(solution.t, rows[:, EVENT_T]))
    names = solution.described.contacts
    marks = [mark_of(event_of(row), int(frame), names) for row, frame in zip(rows, frames, strict=True)]
    for number, times in enumerate(solution.t_events):
        at = np.minimum(np.searchsorted(solution.t[records], times[:EVENTS_SHOWN]), len(records) - 1)
        text = f"event {number} of the user"
        marks += [Mark(float(t), int(k), MarkKind.USER, text) for t, k in zip(times, at, strict=False)]
    return tuple(sorted(marks, key=lambda mark: mark.t))


def mark_of(event: Event, frame: int, names: Sequence[str]) -> Mark:
    """An event of a contact in words."""
    kind = MarkKind(event.kind.name.lower().replace("_", " "))
    if isinstance(event, ParadoxEvent):
        return Mark(event.t, frame, kind, f"{names[event.contact]}: {paradox_in_words(event)}", event.choice)
    change = " ".join(change_in_words(event).replace("->", "→").split())
    return Mark(event.t, frame, kind, f"{names[event.contact]}: {change}")


def curves_of(solution: Solution, records: np.ndarray) -> list[Curve]:
    """Energies and works, gaps, coordinates, velocities and mean contact forces at the frames, as far as recorded."""
    of_kinds = {
        LEDGER: energy_curves, GAPS: gap_curves, COORDINATES: coordinate_curves, VELOCITIES: velocity_curves,
        IMPULSES: force_curves,
    }  # fmt: skip
    return [curve for kind, find in of_kinds.items() if kind in solution.recorded for curve in find(solution, records)]


def gap_curves(solution: Solution, records: np.ndarray) -> list[Curve]:
    """Some gaps; a contact under a given normal force has none."""
    system: Any = solution.system
    with_gap = [i for i, contact in enumerate(system.contacts) if not contact.normal_force]
    return [Curve("gaps", f"g_{with_gap[k]}", "m", solution.g_N[records, with_gap[k]]) for k in some_of(len(with_gap))]


def energy_curves(solution: Solution, records: np.ndarray) -> list[Curve]:
    """Changes of energies, and works, since the start."""
    return ledger_curves(solution.find_ledger(records))


def ledger_curves(ledger: Mapping[str, np.ndarray]) -> list[Curve]:
    """Changes of energies, and works, since the first frame."""
    works = {("" if name in HELD else "work: ") + name: ledger[name] for name in ledger}
    order = sorted(works, key=lambda name: name not in HELD)
    scale = max((float(np.abs(ledger[name]).max(initial=0.0)) for name in HELD if name in ledger), default=0.0)
    return [
        Curve("energies", name, "J", works[name] - works[name][0], scale, *energy_look(name))
        for name in order
        if np.ptp(works[name]) > 0
    ]


def energy_look(name: str) -> tuple[str, tuple[float, ...]]:
    """Colour and dashes of an energy or a work, those of the figures."""
    colour, dashes = colours.ENERGIES.get(name.removeprefix("work: "), OTHER_WORK)
    if isinstance(dashes, tuple):
        return colour, dashes[1]
    return colour, DOTS if dashes == colours.DOTS else ()


def coordinate_curves(solution: Solution, records: np.ndarray) -> list[Curve]:
    """Some coordinates."""
    return [
        Curve("coordinates", spelt(name), unit, solution.q[records, i])
        for i, name, unit in shown_of(solution.described.coordinates)
    ]


def velocity_curves(solution: Solution, records: np.ndarray) -> list[Curve]:
    """Some velocities."""
    named = solution.described.velocities or [
        (f"{spelt(name)}'", f"{unit}/s" if unit else "") for name, unit in solution.described.coordinates
    ]
    return [Curve("velocities", spelt(name), unit, solution.u[records, i]) for i, name, unit in shown_of(named)]


def shown_of(named: Sequence[tuple[str, str]]) -> list[tuple[int, str, str]]:
    """The coordinates or velocities that have curves: number, name and unit."""
    return [(int(i), *named[i]) for i in some_of(len(named))]


def force_curves(solution: Solution, records: np.ndarray) -> list[Curve]:
    """Mean contact forces between two frames; none at an instant, and at the start."""
    span = np.concatenate([[0.0], np.diff(solution.t[records])])[:, None]
    curves = []
    for name, P in (("normal", solution.P_N), ("friction", solution.P_F.sum(axis=2))):
        P = impulses_between(P, records)
        force = np.divide(P, span, out=np.full_like(P, np.nan), where=span > 0)
        curves += [Curve("forces", f"{name} {i}", "N", force[:, i]) for i in some_of(P.shape[1]) if P[:, i].any()]
    return curves


def about_in_words(solution: Solution) -> dict[str, str]:
    """What was run, its parameters, and how it ended."""
    values = {k: f"{v:.6g}" if isinstance(v, float) else str(v) for k, v in solution.about.items() if k != "system"}
    return {"outcome": solution.message, **values}


def detail_of(solution: Solution, records: np.ndarray) -> str:
    """What is left out."""
    n = len(solution.t)
    said = "every record is a frame" if len(records) == n else f"{len(records)} of {n} records are frames"
    more = len(solution.event_rows) - EVENTS_SHOWN if EVENTS in solution.recorded else 0
    kept = f"; {more} more events than the first {EVENTS_SHOWN} are not marked" if more > 0 else ""
    lost = solution.stats.events_dropped
    return said + kept + (f"; {lost} events were not kept by the run" if lost else "")
