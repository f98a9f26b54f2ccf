"""The same event in two motions: what a contact does in the reference, and when it does so in a run.

    t_i : the contact enters a mode in the reference,    t_i* : the run enters that mode, the nearest to t_i in order

A rigid impact is a point in time; the compliant one lasts. Both end by entering a mode, so the entrances are matched:
a bounce with the lift-off, a seizure with the beginning of sticking, a reversal with the new direction of slip.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from nonsmooth.integrators.records import (
    EVENT_CONTACT,
    EVENT_KIND,
    EVENT_MODE_0,
    EVENT_MODE_1,
    EVENT_SLIP_0,
    EVENT_SLIP_1,
    EVENT_T,
    IMPACT,
)
from nonsmooth.results.events import mode_name
from nonsmooth.results.solution import Solution

MATCHED = 8  # chosen: events of the reference that are looked at, from the first on
ENTRANCE = [EVENT_CONTACT, EVENT_MODE_1, EVENT_SLIP_1]  # what is entered
LEFT = [EVENT_MODE_0, EVENT_SLIP_0]


@dataclass(frozen=True)
class Entrances:
    """Contacts entering modes, in order.

    Attributes
    ----------
    t : ndarray (m,)
        When [s].
    what : ndarray (m, 3)
        Contact, mode, sign of sliding.
    """

    t: np.ndarray
    what: np.ndarray

    @classmethod
    def of_run(cls, run: Solution) -> Entrances:
        """Of every event in which a mode changes, and of every impact, which may leave the mode as it was."""
        rows = run.event_rows
        changes = (rows[:, ENTRANCE[1:]] != rows[:, LEFT]).any(axis=1) | (rows[:, EVENT_KIND] == IMPACT)
        return cls(rows[changes, EVENT_T], rows[changes][:, ENTRANCE].astype(int))

    def before(self, t_end: float) -> Entrances:
        """The first ones that are followed by some motion."""
        early = np.flatnonzero(self.t < t_end)[:MATCHED]
        return Entrances(self.t[early], self.what[early])

    def middles(self, t_end: float) -> np.ndarray:
        """(m,) half the time from each to the next later one, or to the end [s]."""
        later = np.append(self.t, t_end)[np.searchsorted(self.t, self.t, side="right")]
        return 0.5 * (later - self.t)

    def matched(self, run: Solution) -> np.ndarray:
        """(m,) when a run enters the same modes, those of a contact in the same order [s]; NaN where it does not."""
        there = Entrances.of_run(run)
        times = np.full(len(self.t), np.nan)
        taken: dict[int, int] = {}
        for i, what in enumerate(self.what):
            alike = np.flatnonzero((there.what == what).all(axis=1))
            alike = alike[alike > taken.get(int(what[0]), -1)]
            if len(alike):
                nearest = int(alike[np.argmin(np.abs(there.t[alike] - self.t[i]))])
                times[i], taken[int(what[0])] = there.t[nearest], nearest
        return times

    @property
    def names(self) -> list[str]:
        """The mode that is entered, with its contact where there are several."""
        several = len(set(self.what[:, 0])) > 1
        return [mode_name(mode, slip) + (f" ({contact})" if several else "") for contact, mode, slip in self.what]
