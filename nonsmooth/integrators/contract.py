"""What an integrator is: the page to read before any other of this room.

An integrator is a frozen dataclass of options, checked in ``__post_init__``, and a compiled loop

    status = loop(sys, schedule, max_steps, state, record, memory)

that takes at most ``max_steps`` steps and returns a `Status`: RUNNING, and it is to be called again, FINISHED, or why
it cannot go on. Its blocks:

    sys        what is constant: the functions, parameters and contacts of the system   mechanics/sys.py
    schedule   the times of the records, and the steps between them                     here
    state      the header: time, state, modes, events, statistics                       records.py
    record     the rows written so far, and the motion within the steps                 records.py
    memory     whatever else the method needs, a block of its own                       ``memory(system)``

Who runs an integrator, in a run, a checkpoint or a sweep, reads the header and the record, and nothing else. The loop
begins from the header, writes the record of the start and sets ``state.counters.is_begun``; it returns where rows or
events are full (``is_full``), and leaves the header at the moment it has come to. All that the next step depends on
stands in the header and the memory: copied back, they give the same bits.

A method with a fixed step writes no loop: it is a `FixedStep`, and its kernel

    status = step(sys, t, dt, state, memory)

takes one step (fixed_step.py). Nor does one that integrates with Radau IIA to located events: radau/located.py.
CONTRIBUTING has the recipe, moreau_jean/ the example.
"""

from __future__ import annotations

from typing import Annotated as Array
from typing import Any, ClassVar, NamedTuple

import numpy as np

from nonsmooth.errors import Status
from nonsmooth.integrators.records import State
from nonsmooth.jit import Callback, Kernel, load_all
from nonsmooth.jit.blocks import Block, Floats, Handle, Ints
from nonsmooth.mechanics.sys import Sys
from nonsmooth.mechanics.system import System

LOOP = "int64(int64, int64, int64, int64, int64, int64)"
loop_at = Callback(LOOP)
STEP = "int64(int64, float64, float64, int64, int64)"
step_at = Callback(STEP, may_fail=False)  # no step of a fixed length comes to what is loaded late
# derived: rows of events that a contact may need at one moment, or in a fixed step: an impact, a paradox, what its
# forces or its mode are then
EVENTS_AT_ONCE = 3


class Schedule(Block):
    """When a run steps and records."""

    step: Handle  # of ``step_at``: one step of a fixed-step method
    span: float  # [s] of the run, also where it is cut short
    every: int  # steps between two records of a method that chooses its steps; 0: at the times t
    t: Array[Floats, "m + 1"]  # times of the records; of a method that chooses its steps and every > 0, start and end
    dt: Array[Floats, "m"]  # length of a fixed step between them
    steps: Array[Ints, "m"]  # and their number


class Suspect(NamedTuple):
    """A state at which the step that failed called the functions of the model."""

    t: float
    q: np.ndarray
    u: np.ndarray


class Handles(NamedTuple):
    """How loops call functions and take blocks: by addresses, or in the interpreter as they are."""

    is_compiled: bool
    callbacks: tuple[Any, ...]  # of the integrator

    def of(self, block: Block) -> Any:
        """What stands for a block."""
        return block.address if self.is_compiled else block


class Integrator:
    """Options of a method, and what it says of itself; the methods below are for those who run it."""

    chooses_steps: ClassVar[bool] = True
    locates_events: ClassVar[bool] = False
    is_rigid: ClassVar[bool] = True  # contacts have modes at the start, and an inadmissible one is told
    has_forces: ClassVar[bool] = False  # rather than impulses
    is_spatial: ClassVar[bool] = False  # whether it takes friction in two directions
    pieces: ClassVar[int] = 1  # polynomials a step, at most
    degree: ClassVar[int] = 0  # and their degree
    curved: ClassVar[int] = 0  # that of the coordinates where q' is not u; 0: they go straight
    events_at_once: ClassVar[int] = EVENTS_AT_ONCE
    budget: ClassVar[str] = ""  # what is used up where the loop returns BUDGET_SPENT
    callbacks: tuple[Kernel, ...] = ()  # what the memory calls by its address: rates, event functions
    specialise: bool | str = False  # whether its loop may be compiled for one system alone; "auto": where that pays

    @property
    def loop(self) -> Kernel:
        """The loop over the steps."""
        raise NotImplementedError

    @property
    def kernels(self) -> tuple[Kernel, ...]:
        """The entry points whose code decides the bits of a run."""
        return (self.loop, *self.callbacks)

    def entry_points(self, system: System) -> list[Kernel]:
        """What the loop may reach for this system, itself first."""
        return [self.loop]

    def load(self, system: System) -> None:
        """Compile what the loop may reach for this system."""
        load_all(self.entry_points(system))

    def memory(self, system: System, selection: int) -> Any:
        """A fresh block with the options in it; nothing of it depends on the start."""
        raise NotImplementedError

    is_prepared: ClassVar[bool] = False  # whether ``prepare`` does anything

    def prepare(self, system: System, t_end: float, state: State, memory: Any) -> None:
        """Fill the memory with what depends on the start in the header, where the loop cannot do that.

        Raises
        ------
        InvalidInput
            For a start that the method cannot take.
        """

    def set_handles(self, sys: Sys, handles: Handles, memory: Any) -> None:
        """Write into the memory by what it calls functions in this process, and where its blocks are."""

    def load_for_retry(self, system: System, memory: Any, is_compiled: bool) -> bool:
        """Get ready what decides a contact problem that was not solved; False if there is nothing more to try."""
        return False

    def suspects(self, schedule: Schedule, state: State, memory: Any) -> list[Suspect]:
        """Where the step that failed called the functions of the model."""
        return [Suspect(float(state.now), state.q, state.u)]

    def step_problem(self, system: System, selection: int) -> Any:
        """A fresh memory in which one step leaves its contact problem as Moreau–Jean does; None: it has none."""
        return None

    def reason(self, status: Status, state: State, memory: Any) -> str:
        """A sentence on an end, in place of the one that all methods share; empty: none."""
        return ""


class Choice:
    """What stands for an integrator until a system and its start are known."""

    def choose(
        self, model: Any, system: System, t_span: tuple[float, float], q: np.ndarray, u: np.ndarray
    ) -> tuple[Integrator, str]:
        """The integrator for a system that starts at q, u, and why."""
        raise NotImplementedError

    def instead(
        self, chosen: Integrator, status: Status, model: Any, system: System, t_span: tuple[float, float]
    ) -> Integrator | None:
        """The integrator for a run that the chosen one has ended with a status; None where there is no other."""
        return None
