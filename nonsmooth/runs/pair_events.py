"""What happens at the contacts of a scene from step to step, for runs that are asked for it by ``record=``.

A pair of bodies is loaded in a step where one of its points has an impulse, on springs where one has a force at its
end, and slides where all points that have one lie on their friction cones. A change of that from one step to the next
is an event (results/events.py). Pairs that touch when a run begins have not landed; what they do in their first step is
no change.
"""

from __future__ import annotations

import math

import numpy as np

from nonsmooth.integrators.assembly.step import TIGHT
from nonsmooth.mechanics.system import ContactMode
from nonsmooth.results.events import SceneEventKind
from nonsmooth.results.scene_contacts import modes_of
from nonsmooth.results.table import event_arrays, event_row
from nonsmooth.runs.recorder import SceneRun

MOST_EVENTS = 1_000_000  # chosen: that are kept: 64 MB in the plane, 72 in space
TOUCHING = -1  # code: of a pair before its first step


class PairEvents:
    """The pairs of a run that are loaded, and what happened to them.

    Parameters
    ----------
    run : SceneRun
        At its start.
    """

    def __init__(self, run: SceneRun) -> None:
        assembly = run.assembly
        self.n_b = len(run.names)
        self.row = event_row(run.scene.dim)
        self.kept: list[np.ndarray] = []
        self.count = 0
        margin = TIGHT * assembly.smallest if math.isfinite(assembly.smallest) else 0.0
        n, found, body = assembly.find_contacts(margin), assembly.found, assembly.shapes.body
        self.pairs = np.unique(body[found.shape_i[:n]] * self.n_b + body[found.shape_j[:n]])
        self.modes = np.full(len(self.pairs), TOUCHING)

    def steps_at_once(self, run: SceneRun, most: int) -> int:
        """How many steps may be taken until the next look: all that would be left out at rest, else one."""
        progress = run.assembly.progress
        return most if run.has_islands and progress.is_resting == 1 and progress.whole == progress.dt_at_rest else 1

    def look(self, run: SceneRun, t: float, t_end: float) -> None:
        """Note what changed in the step from t to t_end."""
        pairs, modes, P_N, P = self._loaded(run)
        if np.array_equal(pairs, self.pairs) and np.array_equal(modes, self.modes):
            return
        known, before, now = np.intersect1d(self.pairs, pairs, assume_unique=True, return_indices=True)
        was, rests = self.modes[before], modes[now]
        kind = np.full(len(pairs), SceneEventKind.LANDING)
        kind[now] = np.where(rests == ContactMode.SLIDE, SceneEventKind.SLIP, SceneEventKind.STICK)
        happened = np.ones(len(pairs), bool)
        happened[now] = (was != TOUCHING) & (was != rests)
        parted = ~np.isin(self.pairs, known) & (self.modes != TOUCHING)
        self._keep(t, kind[happened], pairs[happened], P_N[happened], P[happened])
        gone = int(parted.sum())
        none = np.full(gone, SceneEventKind.PARTING), self.pairs[parted], np.zeros(gone), np.zeros((gone, P.shape[1]))
        self._keep(t, *none)
        self.pairs, self.modes = pairs, modes
        if self.count >= MOST_EVENTS:
            run.spend(f"the room for {MOST_EVENTS} events")

    def _loaded(self, run: SceneRun) -> tuple[np.ndarray, ...]:
        """The pairs with impulses, on springs forces, in order: modes, normal impulses, impulses on body j."""
        every = run.assembly.contact_rows()
        rows = type(every)(*(column[every.own[:, 0] > 0.0] for column in every))
        P = rows.own
        slides = modes_of(P[:, 0], np.linalg.norm(P[:, 1:], axis=1), rows.mu) == ContactMode.SLIDE
        pairs, at = np.unique(rows.i * self.n_b + rows.j, return_inverse=True)
        sticking = np.bincount(at, weights=~slides, minlength=len(pairs)) > 0
        P_sum = np.stack([np.bincount(at, weights=part, minlength=len(pairs)) for part in rows.P.T], axis=1)
        P_N = np.bincount(at, weights=P[:, 0], minlength=len(pairs))
        return pairs, np.where(sticking, ContactMode.STICK, ContactMode.SLIDE), P_N, P_sum

    def _keep(self, t: float, kind: np.ndarray, pairs: np.ndarray, P_N: np.ndarray, P: np.ndarray) -> None:
        """Keep events of one time."""
        if len(kind) == 0:
            return
        rows = np.empty(len(kind), self.row)
        rows["t"], rows["kind"], rows["P_N"], rows["P"] = t, kind, P_N, P
        rows["i"], rows["j"] = np.divmod(pairs, self.n_b)
        self.kept.append(rows)
        self.count += len(rows)

    def columns(self) -> dict[str, np.ndarray]:
        """All of them, as a solution has them."""
        return event_arrays(np.concatenate([np.empty(0, self.row), *self.kept]))
