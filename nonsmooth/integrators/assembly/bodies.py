"""The bodies of a scene in a step: one row each.

Places and velocities are those of the centre of mass and the principal axes (`Motion`, in scenes/detection.py). Bodies
that are fixed or told how to move stand among the others: impulses do not move them.
"""

from __future__ import annotations

from typing import Annotated as Array

from nonsmooth.jit.blocks import Block, Floats
from nonsmooth.scenes.detection import Motion


class Bodies(Block, n="3 * (dim - 1)", n_x="4 * dim - 5", moments="2 * dim - 3"):
    """Of n_b bodies in the plane (dim 2) or in space (3)."""

    motion: Motion  # at the time of the state; in a step, with the impulses found so far
    v_0: Array[Floats, "n_b", "n"]  # velocities at the beginning of the step
    v_free: Array[Floats, "n_b", "n"]  # at its end, were there no contact
    v_mid: Array[Floats, "n_b", "n"]  # and in its middle
    mass: Array[Floats, "n_b"]  # [kg]
    moments: Array[Floats, "n_b", "moments"]  # of inertia about the principal axes [kg m^2]
    surface: Array[Floats, "n_b", "dim"]  # velocity of its surface, in its own axes [m/s]
    gravity: Array[Floats, "dim"]  # [m/s^2]
    v_move: Array[Floats, "n_b", "n"]  # by which they moved in the step
