"""Contact forces and impulses of a run, told apart.

What acts for a time is a force [N]. What acts at an instant, or in a step in which bodies collide or a slide jams, is
an impulse [N s], which has no force: half the step would double it. So is what a contact carries between two records
only, and neither before nor after.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from nonsmooth.drawing.colours import FRICTION, GREY, NORMAL, cycled
from nonsmooth.drawing.labels import legend_above, show_no_rounding
from nonsmooth.integrators.records import EVENT_KIND, EVENT_T, IMPACT, INCONSISTENT

if TYPE_CHECKING:
    from nonsmooth.results.solution import Solution

MOST_CURVES = 8  # chosen: contacts with a curve of their own, those that carry most
PEAKLESS, CUT = (
    0.99,
    4.0,
)  # chosen: an axis is cut where the largest hundredth of the forces is that many times the rest


@dataclass(frozen=True)
class Loads:
    """What contacts carried between two records.

    Attributes
    ----------
    t : (n + 1,) times of the records [s]
    is_impulse : (n, n_c) whether what a contact carries between two records is an impulse
    normal, friction : (n, n_c) forces [N], or impulses [N s]; of friction in two directions the size
    contacts : the contacts shown, in order
    names : of all contacts
    """

    t: np.ndarray
    is_impulse: np.ndarray
    normal: np.ndarray
    friction: np.ndarray
    contacts: np.ndarray
    names: tuple[str, ...]

    @property
    def has_forces(self) -> bool:
        """Whether anything acts for a time."""
        return bool(self.normal[~self.is_impulse].any() or self.friction[~self.is_impulse].any())

    @property
    def has_impulses(self) -> bool:
        """Whether anything acts at an instant."""
        return bool(self.normal[self.is_impulse].any() or self.friction[self.is_impulse].any())

    @property
    def has_friction(self) -> bool:
        """Whether any contact has a friction force."""
        return bool(self.friction[~self.is_impulse].any())

    @property
    def is_alone(self) -> bool:
        """Whether there is one contact: its forces share an axis."""
        return self.normal.shape[1] == 1


def loads_of(solution: Solution) -> Loads:
    """Forces and impulses between the records of a run."""
    span = np.diff(solution.t)
    normal, friction = solution.P_N[1:], along_surface(solution.P_F[1:])
    carried = np.abs(solution.P_N).sum(axis=0) + np.abs(along_surface(solution.P_F)).sum(axis=0)
    contacts = np.sort(np.argsort(-carried, kind="stable")[:MOST_CURVES])
    contacts, names = contacts[carried[contacts] > 0], tuple(solution.described.contacts)
    if solution.la is not None:  # the integrator knows forces; impulses stand between two records of one instant
        la = solution.la[1:]
        is_impulse = np.broadcast_to((span == 0)[:, None], normal.shape)
        normal, friction = (
            np.where(is_impulse, normal, la[:, :, 0]),
            np.where(is_impulse, friction, along_surface(la[:, :, 1:])),
        )
        return Loads(solution.t, is_impulse, normal, friction, contacts, names)
    is_shock = ((span == 0) | shock_within(solution))[:, None]
    is_impulse = is_shock | is_lonely(((normal != 0) | (friction != 0)) & ~is_shock)
    size = np.where(is_impulse, 1.0, span[:, None])
    return Loads(solution.t, is_impulse, normal / size, friction / size, contacts, names)


def is_lonely(loaded: np.ndarray) -> np.ndarray:
    """Loads (n, n_c) that last from one record to the next only; before the first and after the last they may go on."""
    padded = np.pad(loaded, ((1, 1), (0, 0)), constant_values=True)
    return loaded & ~padded[:-2] & ~padded[2:]


def along_surface(P_F: np.ndarray) -> np.ndarray:
    """Friction (n, n_c): with its sign in the plane, its size in space, zero without."""
    return P_F[:, :, 0] if P_F.shape[2] == 1 else np.linalg.norm(P_F, axis=2)


def shock_within(solution: Solution) -> np.ndarray:
    """Whether a collision, or an impact without one, happened between two records (n,)."""
    kinds = solution.event_rows[:, EVENT_KIND]
    t = solution.event_rows[(kinds == IMPACT) | (kinds == INCONSISTENT), EVENT_T]
    is_there = np.zeros(len(solution.t) - 1, bool)
    if len(is_there):
        is_there[np.maximum(record_after(solution.t, t) - 1, 0)] = True
    return is_there


def record_after(t: np.ndarray, t_events: np.ndarray) -> np.ndarray:
    """The first record that shows what came of an event; of two records of one instant the second.

    An event of a method of fixed steps is found in the step that begins at its time.
    """
    last = np.maximum(np.searchsorted(t, t_events, "right") - 1, 0)
    is_double = t[last] == t[np.maximum(last - 1, 0)]
    return np.where(is_double & (last > 0), last, np.minimum(last + 1, len(t) - 1))


def draw_forces(axes: Any, loads: Loads, k: np.ndarray, kind: str) -> None:
    """Forces between records, of "normal" and "friction" of one contact together, else of one kind; none in a shock."""
    for i in loads.contacts:
        for force, own, dashes in (("normal", NORMAL, "-"), ("friction", FRICTION, "--")):
            values = np.where(loads.is_impulse[:, i], np.nan, getattr(loads, force)[:, i])[k]
            if force not in kind or not np.isfinite(values).any() or not np.nan_to_num(values).any():
                continue
            colour, style = (own, dashes) if loads.is_alone else cycled(curve(loads, i))[:2]
            label = force if loads.is_alone else loads.names[i]
            edges = np.append(loads.t[k], loads.t[k[-1] + 1])
            draw_steps(axes, values, edges, edgecolor=colour, lw=1.1, ls=style, label=label)
    axes.set_ylabel(f"{'force' if loads.is_alone else kind} [N]{chosen(loads)}")
    forces = [np.where(loads.is_impulse, 0.0, getattr(loads, force)) for force in kind.split()]
    cut_at_peaks(axes, np.concatenate(forces, axis=1))
    show_no_rounding(axes)
    legend_above(axes)


def draw_steps(axes: Any, values: np.ndarray, edges: np.ndarray, **look: Any) -> None:
    """What ``axes.stairs`` draws, whose limits are those of its corners: that takes each for a curve of its own, and a
    second for 20 000."""
    from matplotlib.patches import StepPatch

    no_baseline: Any = None
    axes.add_artist(StepPatch(values, edges, baseline=no_baseline, fill=False, **look))
    is_known = np.isfinite(values)
    corners = [(edges[at][is_known], values[is_known]) for at in (slice(None, -1), slice(1, None))]
    axes.update_datalim(np.concatenate([np.column_stack(pair) for pair in corners]))
    axes.autoscale_view()


def curve(loads: Loads, i: int) -> int:
    """Which of the shown contacts contact i is."""
    return int(np.searchsorted(loads.contacts, i))


def chosen(loads: Loads) -> str:
    """How many contacts are shown, where it is not all of them."""
    n_c = loads.normal.shape[1]
    return f"\n{len(loads.contacts)} most loaded\nof {n_c}" if n_c > MOST_CURVES else ""


def cut_at_peaks(axes: Any, force: np.ndarray) -> None:
    """An axis whose few largest forces would hide the rest ends before them, and says how far they reach."""
    size = np.abs(force).max(axis=1) if len(force) else np.zeros(1)
    limit = float(np.quantile(size, PEAKLESS))
    if limit > 0 and size.max() > CUT * limit:
        axes.set_ylim(-1.2 * limit if force.min() < 0 else -0.05 * limit, 1.2 * limit)
        axes.text(0.99, 0.95, f"peaks up to {size.max():.3g} N", transform=axes.transAxes, fontsize=8, ha="right",
                  va="top", bbox={"fc": "white", "ec": "none", "alpha": 0.85, "pad": 1.0})  # fmt: skip


def draw_impulses(axes: Any, loads: Loads) -> None:
    """The impulses of shocks: stems for one contact or a few, dots over the number of the contact for many."""
    if loads.normal.shape[1] > MOST_CURVES:
        draw_impulses_of_many(axes, loads)
        return
    axes.axhline(0.0, color=GREY, lw=0.6)
    for i in loads.contacts:
        k = np.flatnonzero(loads.is_impulse[:, i])
        for kind, own, marker in (("normal", NORMAL, "o"), ("friction", FRICTION, "s")):
            values = getattr(loads, kind)[k, i]
            shown = values != 0
            if not shown.any():
                continue
            if not loads.is_alone:
                own, _, marker = cycled(curve(loads, i))  # a marker is filled for the normal direction
            label = kind if loads.is_alone else f"{kind}, {loads.names[i]}"
            axes.vlines(loads.t[k[shown] + 1], 0.0, values[shown], color=own, lw=1.0)
            size, inside = (3.0, own) if kind == "normal" else (5.5, "none")  # both are seen where they are equal
            axes.plot(loads.t[k[shown] + 1], values[shown], marker, color=own, ms=size, mfc=inside, label=label,
                      clip_on=False, zorder=3)  # fmt: skip
    axes.set_ylabel("impulse of\nshocks [N s]")
    legend_above(axes)


def draw_impulses_of_many(axes: Any, loads: Loads) -> None:
    """Space and time: a dot for each contact of each shock, the darker the larger its normal impulse."""
    from matplotlib.colors import LogNorm

    size = np.where(loads.is_impulse, np.abs(loads.normal), 0.0)
    when, which = np.nonzero(size)
    if not len(when):
        return
    values = size[when, which]
    order = np.argsort(values)
    dots = axes.scatter(
        loads.t[when + 1][order], which[order], c=values[order], s=3, cmap="cividis_r", linewidths=0,
        norm=LogNorm(max(values.max() * 1e-4, values.min()), values.max() * 1.0001), rasterized=True,
    )  # fmt: skip
    axes.figure.colorbar(dots, ax=axes, pad=0.01, label="normal impulse\n[N s]")
    axes.set_ylabel("number of\nthe contact")
    axes.set_ylim(-0.5, loads.normal.shape[1] - 0.5)
