"""Many runs of a compiled model in one compiled call.

For each cell i of a block: clear the memory of one run, write the parameters and the start of cell i, find the modes of
its contacts, step to the end, reduce events and motion to the numbers of the cell. Nothing is allocated per run; the
call holds no lock of the interpreter, so that threads take a block each. It returns to Python some fifty times a
second, where Ctrl-C is heard, and goes on in the cell and the step where it stopped.
A run begins from cleared memory: its result depends on its cell alone, not on the block that it is in.
"""

from __future__ import annotations

import time
from typing import Annotated as Array
from typing import Any

import numpy as np

from nonsmooth.checks.memory import require_memory
from nonsmooth.errors import Status
from nonsmooth.integrators.moreau_jean.contact import Scratch
from nonsmooth.integrators.moreau_jean.step import Intervals, run
from nonsmooth.integrators.records import (
    EVENT_CONTACT,
    EVENT_KIND,
    EVENT_MODE_1,
    EVENT_SLIP_1,
    IMPACT,
    MODE_CHANGE,
    N_LEDGER,
    Counters,
    Record,
    State,
    Worst,
)
from nonsmooth.jit import interpreted, kernel
from nonsmooth.jit.blocks import WORD, B, Block, Floats, Ints, count_words, head_words, new, numbers, view
from nonsmooth.mechanics.compiled import Model, model_of
from nonsmooth.mechanics.contact_problem import model_facts
from nonsmooth.mechanics.initial_modes import RAISED, initial_modes
from nonsmooth.mechanics.laws import LAW_WIDTH
from nonsmooth.mechanics.sys import Sys, new_sys
from nonsmooth.mechanics.system import System
from nonsmooth.runs.run import FIRST_BLOCK, next_block
from nonsmooth.runs.times import intervals_of
from nonsmooth.signals.interruption import end_if_asked
from nonsmooth.signals.telling import tell

BLOCK_EVENT_CAPACITY = 32  # chosen: rows, and three a contact; the kernel empties them
N_KINDS = 4  # chosen: kinds of event
N_CODES = 64  # chosen: changes of mode kept for a mode sequence
STILL_COORDINATE = 1e-12  # chosen: a coordinate whose range is below this part of its size does not move


class Call(Block):
    """What a call of ``run_cells`` is to do, and where it stands."""

    last: int  # the cell before which it ends
    max_steps: int  # a cell counts as one more
    window: int  # the first record that is reduced; -1: none
    is_retry: int
    is_begun: int  # whether the cell is
    cell: int
    steps_done: int


class Cells(Block):
    """What N runs start from and leave behind; n = n_u, c = n_c."""

    call: Call
    p: Array[Floats, "N", "n_p"]  # parameters
    laws: Array[Floats, "N", "n_c", LAW_WIDTH]
    q_0: Array[Floats, "N", "n"]  # start
    u_0: Array[Floats, "N", "n"]
    q: Array[Floats, "N", "n"]  # end
    u: Array[Floats, "N", "n"]
    t: Array[Floats, "N"]  # time reached
    status: Array[Ints, "N"]  # Status
    start: Array[Ints, "N"]  # RAISED, INADMISSIBLE, ADMISSIBLE
    mode: Array[Ints, "N", "n_c"]  # at the end
    slip: Array[Ints, "N", "n_c"]
    ledger: Array[Floats, "N", N_LEDGER]
    worst: Array[Floats, "N", head_words(Worst)]
    counters: Array[Ints, "N", head_words(Counters)]
    events: Array[Ints, "N", N_KINDS]  # number of events of each kind
    codes: Array[Ints, "N", "n_codes"]  # modes in the order of their beginning; -1: no more
    n_codes: Array[Ints, "N"]  # how many there were
    low: Array[Floats, "N", "n"]  # least coordinates over the records of the window
    high: Array[Floats, "N", "n"]  # largest
    change: Array[Floats, "N", "n"]  # part of that range by which a half of the window has a smaller one
    period: Array[Floats, "N", "n"]  # mean time between upward crossings of the middle; NaN: fewer than two


@kernel("void(int64, int64, int64, float64[:, ::1], float64[:, ::1], int64, int64, int64)", short_loops=True)
def run_cells(sys_at, intervals_at, cells_at, state_memory, scratch_memory, state_at, record_at, scratch_at):
    """Run the cells of a call as far as its steps go; the records of its window are reduced to low, high, period. In a
    retry, what decides the problems that stopped a run is loaded."""
    sys = view(sys_at, Sys)
    cells, state, record = view(cells_at, Cells), view(state_at, State), view(record_at, Record)
    scratch, intervals, call = view(scratch_at, Scratch), view(intervals_at, Intervals), cells.call
    t_record, dts = intervals.t, intervals.dt
    n, n_c, m = sys.n, sys.n_c, t_record.shape[0]
    call.steps_done = 0
    has_newton, may_wait = scratch.planar.has_newton, scratch.planar.may_wait
    for i in range(call.cell, call.last):
        status = Status.RUNNING.value
        if call.is_begun == 0:
            set_system(i, cells, sys)
            renew(state_memory)
            renew(scratch_memory)
            scratch.planar.has_newton, scratch.planar.may_wait = has_newton, may_wait
            for j in range(n):
                state.q[j], state.u[j] = cells.q_0[i, j], cells.u_0[i, j]
            cells.start[i] = initial_modes(sys, t_record[0], state, scratch.work)
            if cells.start[i] == RAISED:
                status = Status.NOT_FINITE.value
            note_modes(i, n_c, state, cells)
            call.is_begun, call.cell = 1, i
        while status == Status.RUNNING:
            if call.steps_done >= call.max_steps:
                return
            before = state.counters.steps
            status = run(
                sys_at, intervals_at, call.max_steps - call.steps_done, state_at, record_at, scratch_at
            )  # fmt: skip
            call.steps_done += state.counters.steps - before
            note_events(i, state, cells)
            if call.is_retry != 0 and status == Status.NOT_SOLVED and scratch.planar.can_decide_redundant == 0:
                scratch.planar.can_decide_redundant = 1
                status = Status.RUNNING.value
        store(i, n, n_c, status, t_record, dts, state, cells)
        if call.window >= 0 and status == Status.FINISHED:
            reduce_motion(i, n, call.window, m, t_record, record, cells)
        call.is_begun, call.cell = 0, i + 1
        call.steps_done += 1


@kernel
def set_system(i, cells, sys):
    """Give the system the parameters and laws of cell i."""
    for k in range(sys.p.shape[0]):
        sys.p[k] = cells.p[i, k]
    for k in range(sys.n_c):
        for column in range(sys.laws.shape[1]):
            sys.laws[k, column] = cells.laws[i, k, column]


@kernel
def renew(memory):
    """Copy the words of a fresh block, row 1, to those of the block in use, row 0."""
    for k in range(memory.shape[1]):
        memory[0, k] = memory[1, k]


@kernel
def note_code(i, contact, mode, slip, cells):
    """Append a mode to the sequence of cell i."""
    m = cells.n_codes[i]
    if m < cells.codes.shape[1]:
        cells.codes[i, m] = 16 * contact + 4 * mode + slip + 1
    cells.n_codes[i] = m + 1


@kernel
def note_modes(i, n_c, state, cells):
    """Begin the sequence of cell i with the modes at the start, and its counts of events with zero."""
    for k in range(cells.codes.shape[1]):
        cells.codes[i, k] = -1
    cells.n_codes[i] = 0
    for kind in range(N_KINDS):
        cells.events[i, kind] = 0
    for contact in range(n_c):
        note_code(i, contact, state.mode[contact], state.slip[contact], cells)


@kernel
def note_events(i, state, cells):
    """Count the events by kind, continue the sequence, and empty them."""
    for m in range(state.counters.n_events):
        kind = int(state.events[m, EVENT_KIND])
        cells.events[i, kind] += 1
        if kind == MODE_CHANGE or kind == IMPACT:
            contact, mode = int(state.events[m, EVENT_CONTACT]), int(state.events[m, EVENT_MODE_1])
            note_code(i, contact, mode, int(state.events[m, EVENT_SLIP_1]), cells)
    state.counters.n_events = 0


@kernel
def store(i, n, n_c, status, t_record, dts, state, cells):
    """Write down where the run of cell i ended."""
    counters = state.counters
    cells.status[i] = status
    interval = counters.interval
    cells.t[i] = t_record[interval]
    if interval < dts.shape[0]:
        cells.t[i] += counters.step * dts[interval]
    for j in range(n):
        cells.q[i, j], cells.u[i, j] = state.q[j], state.u[j]
        cells.low[i, j] = cells.high[i, j] = cells.change[i, j] = cells.period[i, j] = np.nan
    for k in range(n_c):
        cells.mode[i, k], cells.slip[i, k] = state.mode[k], state.slip[k]
    for k in range(N_LEDGER):
        cells.ledger[i, k] = state.ledger[k]
    figures, counted = numbers(state.worst), numbers(counters)
    for k in range(figures.shape[0]):
        cells.worst[i, k] = figures[k]
    for k in range(counted.shape[0]):
        cells.counters[i, k] = counted[k]


@kernel
def reduce_motion(i, n, first, m, t_record, record, cells):
    """Range of each coordinate over the records [first, m), how much smaller it is in a half of them, and the mean time
    between its upward crossings of the middle of that range (linear between two records)."""
    q = record.q
    half = first_of_half(first, m, t_record)
    for j in range(n):
        low, high = q[first, j], q[first, j]
        for k in range(first + 1, m):
            low, high = min(low, q[k, j]), max(high, q[k, j])
        cells.low[i, j], cells.high[i, j], cells.change[i, j] = low, high, 0.0
        if high - low <= STILL_COORDINATE * max(abs(low), abs(high)):
            continue
        least = min(range_of(j, first, half, q), range_of(j, half, m, q))
        cells.change[i, j] = 1.0 - least / (high - low)
        middle = 0.5 * (low + high)
        crossings, t_first, t_last = 0, 0.0, 0.0
        for k in range(first + 1, m):
            below, above = q[k - 1, j] - middle, q[k, j] - middle
            if below < 0.0 <= above:
                t_last = t_record[k - 1] + (t_record[k] - t_record[k - 1]) * below / (below - above)
                if crossings == 0:
                    t_first = t_last
                crossings += 1
        if crossings > 1:
            cells.period[i, j] = (t_last - t_first) / (crossings - 1)


@kernel
def first_of_half(first, m, t_record):
    """The first record of the second half of the window."""
    middle, half = 0.5 * (t_record[first] + t_record[m - 1]), first
    while half < m - 1 and t_record[half] < middle:
        half += 1
    return half


@kernel
def range_of(j, first, last, q):
    """max q_j - min q_j over the records [first, last); zero of none."""
    if first >= last:
        return 0.0
    low, high = q[first, j], q[first, j]
    for k in range(first + 1, last):
        low, high = min(low, q[k, j]), max(high, q[k, j])
    return high - low


def renewable(block: B) -> tuple[B, np.ndarray]:
    """A copy of a block, and its words, with those of the block, which ``renew`` takes."""
    memory = np.stack((block.words, block.words))
    return type(block)(memory[0]), memory


class BlockEngine:
    """Runs blocks of cells of one system shape with one integrator.

    Parameters
    ----------
    system : System
        Its functions and kinds of contact; parameters and laws come with the cells.
    integrator : MoreauJean
    grid : Grid
        Record times, and the steps between them.
    selection : int
        Which solution is taken where there are several.
    window : int
        First record that is reduced to ranges and periods; -1: none.
    has_sequence : bool
        Whether the sequence of modes is kept.
    """

    def __init__(self, system: System, integrator: Any, grid: Any, selection: int, window: int, has_sequence: bool):
        self.system, self.integrator, self.grid, self.window = system, integrator, grid, window
        self.model: Model = model_of(system)
        self.has = model_facts(system)
        self.selection = selection
        needed = WORD * count_words(Record, m=len(grid.t), n=system.n_u, n_c=system.n_c, d=system.d)
        require_memory(needed, f"the {len(grid.t)} records of a run", "record less (every=), or stop earlier")
        self.n_codes = N_CODES if has_sequence else 0
        self.max_steps = FIRST_BLOCK  # of the next call, for some 0.02 s
        self.load()

    def load(self) -> None:
        """Compile what the cells call."""
        if self.model.is_compiled:
            self.integrator.load(self.system)
            run.load()
            run_cells.load()

    def new_cells(self, N: int) -> Cells:
        """Room for N cells."""
        system = self.system
        return new(Cells, N=N, n_p=len(system.p), n=system.n_u, n_c=system.n_c, n_codes=self.n_codes)

    def run(self, cells: Cells) -> None:
        """Run every cell of a block whose p, laws, q_0 and u_0 are set; the rest of its arrays is the result."""
        system, grid = self.system, self.grid
        if not self.model.is_current:
            self.model, self.has = model_of(system), model_facts(system)
        model, kernel = self.model, self.kernel
        sizes = {"n": system.n_u, "n_c": system.n_c, "d": system.d}
        state, state_memory = renewable(new(State, **sizes, capacity=BLOCK_EVENT_CAPACITY + 3 * system.n_c))
        record = new(Record, m=len(self.grid.t), **sizes)
        scratch, scratch_memory = renewable(self.integrator.scratch(system, self.selection))
        sys = new_sys(system, model.handle, self.has)
        used = (sys, intervals_of(grid), cells, state, record, scratch)
        blocks = [block.address if model.is_compiled else block for block in used]

        def call(first: int, last: int, is_retry: bool) -> None:
            """Run the cells from one to another."""
            here = cells.call
            here.is_begun, here.cell, here.last, here.is_retry, here.window = 0, first, last, is_retry, self.window
            while here.cell < last:
                end_if_asked()
                began = time.perf_counter()
                here.max_steps = self.max_steps
                with np.errstate(all="ignore"):  # of the interpreted loop; what is not finite the loop itself finds
                    kernel(*blocks[:3], state_memory, scratch_memory, *blocks[3:])
                self.max_steps = next_block(int(here.steps_done), time.perf_counter() - began)
                part = state.counters.interval / max(1, len(grid.dts)) * here.is_begun
                tell((here.cell + part) / len(cells.p))

        call(0, len(cells.p), False)
        stopped = np.flatnonzero(cells.status == Status.NOT_SOLVED).tolist()
        if stopped and self.integrator.load_for_retry(system, scratch, model.is_compiled):
            for i in stopped:
                call(i, i + 1, True)

    @property
    def kernel(self) -> Any:
        """The loop over cells: compiled, or its source."""
        return run_cells.dispatcher if self.model.is_compiled else interpreted(run_cells)
