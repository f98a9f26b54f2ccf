"""Runs with a checkpoint, of integrators that choose their steps."""

from __future__ import annotations

from typing import Any

import numpy as np

from nonsmooth.jit.blocks import numbers
from nonsmooth.mechanics.system import System
from nonsmooth.runs.adaptive_run import AdaptiveRun
from nonsmooth.runs.event_run import EventRun
from nonsmooth.runs.extrapolation_run import ExtrapolationRun
from nonsmooth.runs.streaming import Streaming


def adaptive_run(
    system: System, integrator: Any, t_record: np.ndarray, every: int, q0: np.ndarray, u0: np.ndarray, selection: int,
    project: bool,
) -> StreamedTrail:  # fmt: skip
    """The run that fits an integrator."""
    if getattr(integrator, "has_rigid_contacts", False):
        kind = StreamedExtrapolation if getattr(integrator, "extrapolates", False) else StreamedEvents
        return kind(system, integrator, t_record, every, q0, u0, selection, project)
    return StreamedPenalty(system, integrator, t_record, every, q0, u0, project)


class StreamedTrail(Streaming, AdaptiveRun):
    """The rows of the trail go to the file; the steps between them are not kept."""

    def __init__(self, system: System, *arguments: Any) -> None:
        self.P_0 = np.zeros((1, system.n_c, 2))  # impulses up to the last row that was written
        super().__init__(system, *arguments)
        self.trail = self._new_trail(keeps_steps=False)

    def _collect_rows(self) -> None:
        """They are taken when they are written."""

    def new_rows(self) -> np.ndarray:
        t, x, la, mode, slip = self._written()
        record = self._record_of(x, mode, slip, self.P_0)
        if len(t):
            n, n_c = self.system.n_u, self.system.n_c
            self.P_0[0] = np.stack(np.split(x[-1, 2 * n + n_c : 2 * n + 3 * n_c], 2), axis=1)
        self.trail.counts.rows = 0
        return self.as_rows(t, record, la if "la" in (self.store.row.names or ()) else None)

    def last_row(self) -> np.ndarray | None:
        """The start, of a run that stopped before its first record."""
        if self.store.n_records:
            return None
        ((t, x, la, mode, slip),) = self._start_row()
        return self.as_rows(
            t, self._record_of(x, mode, slip, self.P_0), la if "la" in (self.store.row.names or ()) else None
        )

    def memory(self) -> dict[str, np.ndarray]:
        return super().memory() | {
            "counts": numbers(self.trail.counts), "P_0": self.P_0.view(np.int64)
        }  # fmt: skip


class StreamedPenalty(StreamedTrail, AdaptiveRun):
    """Compliant contacts."""


class StreamedEvents(StreamedTrail, EventRun):
    """Rigid contacts and located events."""


class StreamedExtrapolation(StreamedTrail, ExtrapolationRun):
    """Extrapolated steps."""
