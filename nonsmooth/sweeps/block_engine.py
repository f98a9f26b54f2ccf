"""Many runs of a compiled model in one compiled call.

For each cell i of a block: clear the memory of one run, write the parameters and the start of cell i, find the modes of
its contacts, step to the end, reduce events and motion to the numbers of the cell. Nothing is allocated per run; the
call holds no lock of the interpreter, so that threads take a block each. It returns to Python some fifty times a
second, where Ctrl-C is heard, and goes on in the cell and the step where it stopped.
A run begins from cleared memory: its result depends on its cell alone, not on the block that it is in.

A run that goes on until its motion has settled is judged at the records where it is T, 2 T, 4 T, ... long, and ends
there or goes on as it is: no step is taken twice.
"""

from __future__ import annotations

import functools
import time
from typing import Annotated as Array
from typing import Any, NamedTuple

import numpy as np

from nonsmooth.checks.memory import require_memory
from nonsmooth.errors import InvalidInput, Status
from nonsmooth.integrators.contract import Integrator, Schedule, loop_at
from nonsmooth.integrators.fixed_step import FixedStep
from nonsmooth.integrators.records import (
    EVENT_CONTACT,
    EVENT_KIND,
    EVENT_MODE_1,
    EVENT_SLIP_1,
    IMPACT,
    MODE_CHANGE,
    Counters,
    Record,
    State,
    Worst,
    no_rows,
)
from nonsmooth.jit import handle_of, interpreted, kernel
from nonsmooth.jit.blocks import WORD, B, Block, Floats, Handle, Ints, count_words, head_words, new, numbers, view
from nonsmooth.jit.specialised import Specialised
from nonsmooth.mechanics.compiled import Model, model_of
from nonsmooth.mechanics.contact_problem import Work, model_facts
from nonsmooth.mechanics.initial_modes import ADMISSIBLE, RAISED, initial_modes
from nonsmooth.mechanics.laws import LAW_WIDTH
from nonsmooth.mechanics.sys import Sys, new_sys
from nonsmooth.mechanics.system import System
from nonsmooth.results.recorded import COORDINATES, EVENTS, KINDS, MODES
from nonsmooth.runs.ongoing import columns_of, left_out, set_handles, skip
from nonsmooth.runs.recorder import ROW_CAPACITY
from nonsmooth.runs.run import next_block
from nonsmooth.runs.simulate_system import in_space
from nonsmooth.runs.specialise import loop_of_system
from nonsmooth.runs.system_run import FIRST_BLOCK
from nonsmooth.runs.times import Timetable
from nonsmooth.signals.interruption import end_if_asked
from nonsmooth.signals.telling import tell

BLOCK_EVENT_CAPACITY = 32  # chosen: rows, and those of a moment; the kernel empties them
SCHEDULES = 4  # chosen: kept at a time: of a run of a million steps one takes 24 MB
N_KINDS = 4  # chosen: kinds of event
N_CODES = 64  # chosen: changes of mode kept for a mode sequence
ASKS_AMPLITUDE, ASKS_PERIOD = 1, 2  # code: what is to have settled
TIME_ROUNDING = 1e-9  # chosen: of a fixed step: what separates its record from the end of a run is rounding below it
STILL_COORDINATE = 1e-12  # chosen: a coordinate whose range is below this part of its size does not move


class Call(Block):
    """What a call of ``run_cells`` is to do, and where it stands."""

    loop: Handle  # of the integrator
    last: int  # the cell before which it ends
    max_steps: int  # a cell counts as one more
    window: float  # the fraction of the span from which on records are reduced; -1: none are
    first_look: float  # length of a run after which it is judged whether its motion has settled; 0: it is not
    look: float  # the next time of that in the present cell
    settle: float  # of a settled motion: how much amplitudes and periods within the window differ at most
    asks: int  # what is to have settled: ASKS_AMPLITUDE, ASKS_PERIOD, or both
    is_rigid: int  # whether contacts have modes at the start
    is_prepared: int  # whether the memory of the cell is filled already
    is_patient: int  # whether it returns where a contact problem is not solved
    is_stuck: int  # and has
    is_full: int  # whether it returned for want of rows
    is_begun: int  # whether the cell is
    cell: int
    steps_done: int


class Cells(Block, n_q=0):
    """What N runs start from and leave behind; n = n_u, c = n_c, n_q = 0 where q' = u."""

    call: Call
    work: Array[Work, "n_q = n_q"]  # of the modes at the start
    p: Array[Floats, "N", "n_p"]  # parameters
    laws: Array[Floats, "N", "n_c", LAW_WIDTH]
    q_0: Array[Floats, "N", "n_q or n"]  # start
    u_0: Array[Floats, "N", "n"]
    q: Array[Floats, "N", "n_q or n"]  # end
    u: Array[Floats, "N", "n"]
    t: Array[Floats, "N"]  # time reached
    status: Array[Ints, "N"]  # Status
    start: Array[Ints, "N"]  # RAISED, INADMISSIBLE, ADMISSIBLE
    mode: Array[Ints, "N", "n_c"]  # at the end
    slip: Array[Ints, "N", "n_c"]
    worst: Array[Floats, "N", head_words(Worst)]
    counters: Array[Ints, "N", head_words(Counters)]
    events: Array[Ints, "N", N_KINDS]  # number of events of each kind
    codes: Array[Ints, "N", "n_codes"]  # modes in the order of their beginning; -1: no more
    n_codes: Array[Ints, "N"]  # how many there were
    low: Array[Floats, "N", "n_q or n"]  # least coordinates over the records of the window
    high: Array[Floats, "N", "n_q or n"]  # largest
    change: Array[Floats, "N", "n_q or n"]  # part of that range by which a half of the window has a smaller one
    period: Array[Floats, "N", "n_q or n"]  # mean time between upward crossings of the middle; NaN: fewer than two
    period_change: Array[Floats, "N", "n_q or n"]  # part of it by which the earlier and the later differ


@kernel(
    "void(int64, int64, int64, float64[:, ::1], float64[:, ::1], int64, int64, int64)",
    short_loops=True,
    takes_arrays=True,
)
def run_cells(sys_at, schedule_at, cells_at, state_words, memory_words, state_at, record_at, memory_at):
    """Run the cells of a call as far as its steps go; the records of its window are reduced to low, high, period."""
    sys, schedule = view(sys_at, Sys), view(schedule_at, Schedule)
    cells, state, record = view(cells_at, Cells), view(state_at, State), view(record_at, Record)
    call = cells.call
    call.steps_done, call.is_full, call.is_stuck = 0, 0, 0
    for i in range(call.cell, call.last):
        status = Status.RUNNING.value
        if call.is_begun == 0:
            set_system(i, cells, sys)
            renew(state_words)
            if call.is_prepared == 0:
                renew(memory_words)
            status = set_start(i, schedule.t[0], sys, state, record, cells)
            call.is_begun, call.cell, call.look = 1, i, schedule.t[0] + call.first_look
        while status == Status.RUNNING:
            if call.steps_done >= call.max_steps:
                return
            before, is_first = state.counters.steps, state.counters.is_begun == 0
            max_steps = min(call.max_steps - call.steps_done, steps_to_look(call, schedule, state))
            status = loop_at(call.loop, sys_at, schedule_at, max_steps, state_at, record_at, memory_at)
            call.steps_done += state.counters.steps - before
            if is_first:
                note_modes(i, sys.n_c, state, record, cells)
            note_events(i, state, cells)
            if status == Status.NOT_SOLVED and call.is_patient != 0:
                call.is_stuck = 1
                return
            if status == Status.RUNNING and call.first_look > 0.0:
                status = judge(i, sys.n_q, schedule, state, record, cells)
            if status == Status.RUNNING and schedule.every > 0 and record.counts.rows + 2 > record.t.shape[0]:
                if call.window >= 0.0:
                    call.is_full = 1
                    return
                record.counts.rows = 0
            if status == Status.RUNNING and state.counters.steps == before:
                call.steps_done += 1  # events alone
        store(i, sys.n_c, status, state, cells)
        if call.window >= 0.0 and status == Status.FINISHED:
            reduce_motion(i, sys.n_q, call.window, record, cells)
        call.is_begun, call.cell = 0, i + 1
        call.steps_done += 1


@kernel
def set_start(i, t, sys, state, record, cells):
    """The header at the start of cell i; returns a Status."""
    for j in range(sys.n_q):
        state.q[j] = cells.q_0[i, j]
    for j in range(sys.n):
        state.u[j] = cells.u_0[i, j]
    state.now = t
    record.counts.rows, record.counts.next, record.steps.n_steps = 0, 0, 0
    cells.start[i] = ADMISSIBLE
    if cells.call.is_rigid != 0:
        cells.start[i] = initial_modes(sys, t, state, cells.work)
    if cells.start[i] == RAISED:
        note_modes(i, sys.n_c, state, record, cells)
        return Status.NOT_FINITE.value
    return Status.RUNNING.value


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
def note_modes(i, n_c, state, record, cells):
    """Begin the sequence of cell i with the modes of its first record, and its counts of events with zero."""
    for k in range(cells.codes.shape[1]):
        cells.codes[i, k] = -1
    cells.n_codes[i] = 0
    for kind in range(N_KINDS):
        cells.events[i, kind] = 0
    for contact in range(n_c):
        if record.counts.rows > 0:
            note_code(i, contact, record.mode[0, contact], record.slip[0, contact], cells)
        else:
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
def store(i, n_c, status, state, cells):
    """Write down where the run of cell i ended."""
    cells.status[i], cells.t[i] = status, state.now
    for j in range(state.u.shape[0]):
        cells.u[i, j] = state.u[j]
    for j in range(state.q.shape[0]):
        cells.q[i, j] = state.q[j]
        cells.low[i, j] = cells.high[i, j] = cells.change[i, j] = np.nan
        cells.period[i, j] = cells.period_change[i, j] = np.nan
    for k in range(n_c):
        cells.mode[i, k], cells.slip[i, k] = state.mode[k], state.slip[k]
    figures, counted = numbers(state.worst), numbers(state.counters)
    for k in range(figures.shape[0]):
        cells.worst[i, k] = figures[k]
    for k in range(counted.shape[0]):
        cells.counters[i, k] = counted[k]


@kernel
def steps_to_look(call, schedule, state):
    """How many steps may be taken before the run is judged again; one of a method that chooses them."""
    dt = schedule.dt[min(state.counters.interval, schedule.dt.shape[0] - 1)]
    if call.first_look == 0.0:
        return call.max_steps
    return max(1, int((call.look - state.now) / dt)) if dt > 0.0 else 1


@kernel
def judge(i, n, schedule, state, record, cells):
    """At the first record that is not before the next look: FINISHED where the motion has settled, else RUNNING, and
    the run is looked at again when it is twice as long."""
    call, m, rounding = cells.call, record.counts.rows, TIME_ROUNDING * schedule.dt[0]
    if m == 0 or record.t[m - 1] < call.look - rounding:
        return Status.RUNNING.value
    t = record.t[m - 1]
    if t <= call.look + rounding:
        record.t[m - 1] = call.look  # not a rounding away, as the end of a run of that length
    reduce_motion(i, n, call.window, record, cells)
    if has_settled(i, n, cells):
        state.now = record.t[m - 1]
        return Status.FINISHED.value
    record.t[m - 1], t_0 = t, schedule.t[0]
    while call.look <= t + rounding:
        call.look = t_0 + 2.0 * (call.look - t_0)
    return Status.RUNNING.value


@kernel
def has_settled(i, n, cells):
    """Whether what is asked for changes by no more than it may within the window, in every coordinate."""
    for j in range(n):
        if cells.call.asks & ASKS_AMPLITUDE and not cells.change[i, j] <= cells.call.settle:
            return False
        if cells.call.asks & ASKS_PERIOD and not cells.period_change[i, j] <= cells.call.settle:
            return False
    return True


@kernel
def reduce_motion(i, n, window, record, cells):
    """Range of each coordinate over the records of the window, how much smaller it is in a half of them, and the mean
    time between its upward crossings of the middle of that range (linear between two records)."""
    q, t_record, m = record.q, record.t, record.counts.rows
    first = first_from(t_record[0] + window * (t_record[m - 1] - t_record[0]), 0, m - 1, t_record)
    half = first_from(0.5 * (t_record[first] + t_record[m - 1]), first, m - 1, t_record)
    for j in range(n):
        low, high = q[first, j], q[first, j]
        for k in range(first + 1, m):
            low, high = min(low, q[k, j]), max(high, q[k, j])
        cells.low[i, j], cells.high[i, j], cells.change[i, j], cells.period_change[i, j] = low, high, 0.0, 0.0
        if high - low <= STILL_COORDINATE * max(abs(low), abs(high)):
            continue
        least = min(range_of(j, first, half, q), range_of(j, half, m, q))
        cells.change[i, j] = 1.0 - least / (high - low)
        time_crossings(i, j, 0.5 * (low + high), first, record, cells)


@kernel
def time_crossings(i, j, middle, first, record, cells):
    """The mean time between upward crossings of the middle; that of the earlier half of them and that of the later are
    compared where there are three or more, and differ by all of it where there are fewer."""
    q, t_record, m = record.q, record.t, record.counts.rows
    total = 0
    for k in range(first + 1, m):
        if q[k - 1, j] - middle < 0.0 <= q[k, j] - middle:
            total += 1
    n, central, t_first, t_central, t_last = 0, (total - 1) // 2, 0.0, 0.0, 0.0
    for k in range(first + 1, m):
        below, above = q[k - 1, j] - middle, q[k, j] - middle
        if below < 0.0 <= above:
            t_last = t_record[k - 1] + (t_record[k] - t_record[k - 1]) * below / (below - above)
            if n == 0:
                t_first = t_last
            if n == central:
                t_central = t_last
            n += 1
    cells.period_change[i, j] = 1.0
    if total > 1:
        cells.period[i, j] = (t_last - t_first) / (total - 1)
    if total > 2:
        early, late = (t_central - t_first) / central, (t_last - t_central) / (total - 1 - central)
        cells.period_change[i, j] = abs(late - early) / cells.period[i, j]


@kernel
def first_from(t, first, last, t_record):
    """The first record of [first, last] that is not before t; the last, if all are."""
    while first < last and t_record[first] < t:
        first += 1
    return first


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


def grown(record: Record, sizes: dict[str, int]) -> Record:
    """A record with twice the rows, and what is written of them."""
    larger = new(Record, **sizes | {"m": 2 * len(record.t)})
    m = record.counts.rows
    for old, column in zip(columns_of(record), columns_of(larger), strict=True):
        column[: min(m, len(column))] = old[:m]
    larger.counts.rows, larger.counts.next = m, record.counts.next
    return larger


class Settling(NamedTuple):
    """When a run may end: at T, 2 T, 4 T, ... after its start, where its motion has settled."""

    T: float  # [s]
    tolerance: float
    asks: int  # ASKS_AMPLITUDE, ASKS_PERIOD, or both


class BlockEngine:
    """Runs blocks of cells of one system shape with one integrator.

    Parameters
    ----------
    system : System
        Its functions and kinds of contact; parameters and laws come with the cells.
    integrator : Integrator
    table : Timetable
        Record times.
    selection : int
        Which solution is taken where there are several.
    window : float
        The fraction of the span from which on records are reduced to ranges and periods; -1: none.
    has_sequence : bool
        Whether the sequence of modes is kept.
    has_events : bool
        Whether events are.
    until : Settling, optional
        What a run that may end before the timetable does is to have come to; when left out all go to its end.
    """

    def __init__(
        self, system: System, integrator: Integrator, table: Timetable, selection: int, window: float,
        has_sequence: bool, has_events: bool = True, until: Settling | None = None,
    ) -> None:  # fmt: skip
        if system.is_spatial and not integrator.is_spatial:
            integrator = in_space(integrator, system)
        self.system, self.integrator, self.table, self.window = system, integrator, table, window
        self.model: Model = model_of(system)
        self.selection, self.until = selection, until
        self.kept = KINDS
        if isinstance(integrator, FixedStep):  # what the numbers of a cell are not found from is not computed
            self.kept = (COORDINATES, MODES, *((EVENTS,) if has_events else ()))
        rows = ROW_CAPACITY if table.every > 0 else table.count
        self.sizes = {"m": rows, **system.sizes, "steps": int(integrator.chooses_steps), "degree": integrator.degree,
                      "curved": integrator.curved, **no_rows(left_out(self.kept))}  # fmt: skip
        needed = WORD * count_words(Record, **self.sizes)
        require_memory(needed, f"the {rows} records of a run", "record less (every=), or stop earlier")
        self.n_codes = N_CODES if has_sequence else 0
        self.max_steps = FIRST_BLOCK  # of the next call, for some 0.02 s
        self.steps = 0.0  # of the cells until now
        self.load()

    def load(self) -> None:
        """Compile what the cells call."""
        if self.model.is_compiled:
            self.integrator.load(self.system)
            run_cells.load()

    def new_cells(self, N: int) -> Cells:
        """Room for N cells."""
        system = self.system
        return new(Cells, N=N, n_p=len(system.p), **system.sizes, n_codes=self.n_codes)

    def loop_of_system(self, sys: Sys, state: State, memory: Any, N: int) -> Specialised | None:
        """The loop compiled for the system alone, where the steps of all cells until now, and of N more, pay for it."""
        if not isinstance(self.integrator, FixedStep):
            return None
        t_0, t_end = self.table.span
        self.steps += N * (t_end - t_0) / self.integrator.dt
        return loop_of_system(self.integrator, self.model, sys, state, memory, self.steps)

    def run(self, cells: Cells) -> dict[int, InvalidInput]:
        """Run every cell of a block whose p, laws, q_0 and u_0 are set; the rest of its arrays is the result.

        Returns
        -------
        dict
            The cells whose start the integrator refuses, and why.
        """
        if not self.model.is_current:
            self.model = model_of(self.system)
        block = BlockRun(self, cells)
        if self.integrator.is_prepared:
            return block.run_prepared()
        block.run(0, len(cells.p))
        for i in np.flatnonzero(cells.status == Status.NOT_SOLVED).tolist():
            block.retry(i)
        return {}


@functools.lru_cache(maxsize=SCHEDULES)
def schedule_of(engine: BlockEngine) -> Schedule:
    """The times of the runs of an engine, which all its blocks read; kept, for of long runs they take milliseconds."""
    return engine.table.schedule()


class BlockRun:
    """The blocks in which the cells of a block are run one after the other."""

    def __init__(self, engine: BlockEngine, cells: Cells) -> None:
        self.engine, self.cells = engine, cells
        self.integrator, self.is_compiled = engine.integrator, engine.model.is_compiled
        system, sizes = engine.system, engine.sizes
        self.sys = new_sys(system, engine.model.handle, model_facts(system))
        self.schedule = schedule_of(engine)
        capacity = BLOCK_EVENT_CAPACITY + self.integrator.events_at_once * system.n_c
        state = new(State, **system.sizes, capacity=capacity)
        skip(state.skips, engine.kept)
        self.state, self.state_words = renewable(state)
        self.memory, self.memory_words = renewable(self.integrator.memory(system, engine.selection))
        self.record = new(Record, **sizes)
        set_handles(self.integrator, self.is_compiled, self.sys, self.schedule, self.memory)
        self.memory_words[1] = self.memory_words[0]
        here = cells.call
        self.own_loop = own = engine.loop_of_system(self.sys, self.state, self.memory, len(cells.p))  # held: it is code
        address = 0 if own is None else own.address  # of one that is still being compiled 0
        here.loop = Handle(address) if address else handle_of(self.integrator.loop, self.is_compiled)
        here.window, here.is_rigid, here.is_prepared = engine.window, self.integrator.is_rigid, 0
        if engine.until is not None:
            here.first_look, here.settle, here.asks = engine.until

    def run(self, first: int, last: int) -> None:
        """Run the cells from one to another."""
        here, engine = self.cells.call, self.engine
        here.is_begun, here.cell, here.last = 0, first, last
        while here.cell < last:
            end_if_asked()
            began = time.perf_counter()
            here.max_steps = engine.max_steps
            self._call()
            engine.max_steps = next_block(int(here.steps_done), time.perf_counter() - began)
            tell((here.cell + self._part() * here.is_begun) / len(self.cells.p))
            if here.is_full:
                self.record = grown(self.record, engine.sizes)
            if here.is_stuck:
                here.is_patient = self.integrator.load_for_retry(engine.system, self.memory, self.is_compiled)

    def _call(self) -> None:
        kernel = run_cells.compiled if self.is_compiled else interpreted(run_cells)
        blocks = self.sys, self.schedule, self.cells, self.state, self.record, self.memory
        handed: list[Any] = [block.address if self.is_compiled else block for block in blocks]
        with np.errstate(all="ignore"):  # of the interpreted loop; what is not finite the loop itself finds
            kernel(*handed[:3], self.state_words, self.memory_words, *handed[3:])

    def _part(self) -> float:
        """The part of the span that the run of the present cell has behind it."""
        times = self.schedule.t
        return float((self.state.now - times[0]) / (times[-1] - times[0])) if times[-1] > times[0] else 1.0

    def retry(self, i: int) -> None:
        """Run a cell whose contact problem was not solved, with what decides more of them."""
        self.cells.call.is_patient = 1
        self.run(i, i + 1)
        self.cells.call.is_patient = 0

    def run_prepared(self) -> dict[int, InvalidInput]:
        """Run all cells, each after its memory was filled with what depends on its start."""
        cells, state, refused = self.cells, self.state, {}
        names = list(self.engine.system.numbers)
        cells.call.is_prepared = 1
        for i in range(len(cells.p)):
            system = self.engine.system.with_parameters(**dict(zip(names, cells.p[i].tolist(), strict=True)))
            self.memory_words[0] = self.memory_words[1]
            state.q[:], state.u[:], state.now = cells.q_0[i], cells.u_0[i], self.schedule.t[0]
            try:
                self.integrator.prepare(system, float(self.schedule.t[-1]), state, self.memory)
            except InvalidInput as error:
                refused[i] = error
                continue
            self.run(i, i + 1)
        return refused
