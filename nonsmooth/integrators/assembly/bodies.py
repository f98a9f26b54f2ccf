"""The bodies of a scene in a step: one row each.

Places and velocities are those of the centre of mass and the principal axes (`Motion`, in scenes/detection.py). Bodies
that are fixed or told how to move stand among the others: impulses do not move them.

Contacts of bodies that are pressed without impacts, and of guided ones, are looked for where these are in the middle
of the step, x_0 + dt/2 v_0: so sliding is of second order, as is what guided bodies carry (guided.py). Those of others
are looked for at x_0: an impulse there keeps the angular momentum of bodies that move with the velocity after it to
rounding. What is about to meet the former goes along with them until then, by dt/2 times their velocity (beside.py):
how two bodies lie to one another must not depend on how fast both travel.
"""

from __future__ import annotations

from math import sqrt
from typing import Annotated as Array

from nonsmooth.jit import kernel
from nonsmooth.jit.blocks import Block, Floats, Ints
from nonsmooth.scenes.detection import Motion


class Bodies(Block, n="3 * (dim - 1)", n_x="4 * dim - 5", moments="2 * dim - 3"):
    """Of n_b bodies in the plane (dim 2) or in space (3)."""

    motion: Motion  # at the time of the state; in a step, with the impulses found so far
    x_0: Array[Floats, "n_b", "n_x"]  # places at the beginning of the step
    v_0: Array[Floats, "n_b", "n"]  # and velocities
    v_free: Array[Floats, "n_b", "n"]  # at its end, were there no contact; of guided ones at t = dt/2 (1 + lead)
    v_mid: Array[Floats, "n_b", "n"]  # and in its middle
    spin: Array[Floats, "n_b", "moments"]  # in space: at the end of the step (spatial.py) [rad/s]
    gain: Array[Floats, "n_b", "n"]  # by which the velocity of a guided one changes in half a step
    gain_before: Array[Floats, "n_b", "n"]  # and in half of the step before, as it was told; NaN at the start
    lead: float  # 2 - 2 theta: by how much of half a step its velocities are ahead of its middle
    mass: Array[Floats, "n_b"]  # [kg]
    moments: Array[Floats, "n_b", "moments"]  # of inertia about the principal axes [kg m^2]
    surface: Array[Floats, "n_b", "dim"]  # velocity of its surface, in its own axes [m/s]
    gravity: Array[Floats, "dim"]  # [m/s^2]
    load: Array[Floats, "n_b", "n"]  # applied force and torque, in the axes of the world [N, N m]
    kick: Array[Floats, "n_b", "moments"]  # in space: what that torque gives in the step [rad/s]
    strongest: float  # the largest force of a mass [m/s^2]
    v_move: Array[Floats, "n_b", "n"]  # by which they moved in the step
    partner: Array[Ints, "n_b"]  # which other body gives it impulses, or that several do
    keeps: Array[Ints, "n_b"]  # whether it was pressed in the step before, in an island without an impact
    beside: Array[Floats, "n_b", "dim"]  # velocity of such bodies, in its island of the step before [m/s]
    shift: Array[Floats, "n_b", "n"]  # from x_0 to the place at which its contacts are looked for


@kernel
def fall_of(bodies, dt):
    """g dt, what gravity gives in a step, and applied forces at most [m/s]."""
    square = 0.0
    for k in range(bodies.gravity.shape[0]):
        square += bodies.gravity[k] * bodies.gravity[k]
    return dt * (sqrt(square) + bodies.strongest)
