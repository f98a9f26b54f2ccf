"""A phase of a motion as it is guessed, before the cycle is computed from it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from nonsmooth.cycles.jump import Jump
from nonsmooth.cycles.mode_flow import ContactState


class PhaseGuess(NamedTuple):
    """A phase of a motion: what the contacts do, the state it begins in, how long it lasts [s], the jump at its end."""

    states: tuple[ContactState, ...]
    x: np.ndarray  # (2 n_q,) q, u; (2 n_q + 1,) q, u, t under an excitation, or a drive that goes on
    duration: float
    jump: Jump | None = None
