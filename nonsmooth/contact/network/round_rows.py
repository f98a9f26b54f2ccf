"""Contacts and bodies of round islands as rows of a few numbers: one line or two of the cache each.

Where every arm lies along its normal, normal and tangents do not couple, W_c is diagonal, and a contact is its normal,
its impulse and some numbers, in the place of the kilobyte of the rows of a network. ``spheres`` and ``discs`` write
and relax them, ``round_sweeps`` sweeps.
"""

from __future__ import annotations

from typing import Annotated as Array

from nonsmooth.jit.blocks import Block, Floats, Ints

ROW_WIDTH, BODY_WIDTH = 16, 8  # defined: numbers of a contact, of a body: lines of the cache
# defined: where they stand in a row: normal, impulse and b (of spheres in world axes), then numbers
AT_NORMAL, AT_IMPULSE, AT_OFFSET, AT_FRICTION, AT_NORMAL_MASS, AT_TANGENT_MASS, AT_ARM_I, AT_ARM_J = (
    0,
    3,
    6,
    9,
    10,
    11,
    12,
    13,
)
AT_LIGHTNESS, AT_EASE = 6, 7  # defined: 1/m and 1/I in the row of a body, after its velocities


class RoundRows(Block, row=ROW_WIDTH, body=BODY_WIDTH):
    """Contacts and bodies as rows."""

    contact: Array[Floats, "m", "row"]
    moving: Array[Floats, "n_b", "body"]
    listed: Array[Ints, "m"]  # contacts that are visited in sweeps of few, by the places of their islands
