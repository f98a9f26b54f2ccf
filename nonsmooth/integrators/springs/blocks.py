"""Blocks of the steps of a scene on springs: where others are, the rates at the stages, the works."""

from __future__ import annotations

from typing import Annotated as Array

from nonsmooth.integrators.records import N_LEDGER
from nonsmooth.integrators.springs.table import STAGES
from nonsmooth.jit.blocks import Block, Floats

# columns of the works besides those of the ledger: what springs hold, and what dampers took
ELASTIC_ENERGY, DAMPING_WORK = N_LEDGER, N_LEDGER + 1  # code: of a column
N_COLUMNS = N_LEDGER + 2  # derived


class SpringPlaces(Block):
    """Addresses of the blocks that a step is handed."""

    bodies: int
    motion: int
    shapes: int
    surfaces: int
    scratch: int
    found: int
    network: int
    law: int
    springs: int
    rates: int
    ledger: int
    scales: int
    pairs: int
    joints: int
    coils: int
    drives: int
    reactions: int
    row: int


class Stages(Block, stages=STAGES, columns=N_COLUMNS):
    """Rates at the stages of a step."""

    x: Array[Floats, "stages", "n_b", "n_x"]
    v: Array[Floats, "stages", "n_b", "n"]
    work: Array[Floats, "stages", 1, "columns"]
    force: Array[Floats, "n_b", "n"]  # forces and moments [N], [N m]


class Books(Block, columns=N_COLUMNS):
    """Works since the start [J]."""

    work: Array[Floats, "columns"]
