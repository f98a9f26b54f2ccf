"""The task of a sweep over runs of a model: many at a time in the compiled block engine.

What the block engine cannot do, a measure that is a function of the Solution, is run cell by cell through `simulate`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from nonsmooth.checks.arrays import as_count, as_fraction, as_name, as_positive
from nonsmooth.errors import InvalidInput, Status, shown
from nonsmooth.integrators.contract import Integrator
from nonsmooth.jit import identity
from nonsmooth.mechanics.compiled import model_of
from nonsmooth.mechanics.description import title_of
from nonsmooth.mechanics.initial_modes import INADMISSIBLE
from nonsmooth.mechanics.inspection import inspect_start
from nonsmooth.mechanics.model_system import as_system, idle_parameters
from nonsmooth.mechanics.own_law import write_handles
from nonsmooth.mechanics.start import answers_start, forms_of, own_state, split_state, start_of
from nonsmooth.mechanics.system import System
from nonsmooth.results.recorded import KINDS, KINDS_OF_SYSTEM
from nonsmooth.results.solution import Solution
from nonsmooth.runs.asked import SELECTIONS, require_integrator
from nonsmooth.runs.simulate import simulate_whole
from nonsmooth.runs.system_run import MESSAGES
from nonsmooth.runs.times import Timetable, make_timetable, own_steps, span_of
from nonsmooth.scenes.given import as_model
from nonsmooth.sweeps.axis_names import END, AxisNames, Columns, unit_of
from nonsmooth.sweeps.block_engine import ASKS_AMPLITUDE, ASKS_PERIOD, BlockEngine, Settling
from nonsmooth.sweeps.measures import SETTLED_AMPLITUDE, Measure, doubt_of, measure_named, settled
from nonsmooth.sweeps.run_rows import RowBuilder, Rows, combinations
from nonsmooth.sweeps.task import (
    OF_VELOCITY,
    Batch,
    CellStatus,
    Variable,
    as_values,
    identity_of_model,
    name_of,
    words_of,
)

ONE_RECORD = 2**62  # derived: steps between two records: only the start and the end are kept
SETTLED = Variable(meaning="whether amplitude and period agree within the window: 1 or 0")
WINDOW_START = 0.5  # chosen: the window is the second half of a run


def as_measures(measures: Any) -> list[str | Callable[..., Any]]:
    """Names and functions of results, or `InvalidInput`."""
    chosen = [measures] if isinstance(measures, str) or callable(measures) else measures
    if not isinstance(chosen, list | tuple) or not all(isinstance(one, str) or callable(one) for one in chosen):
        raise InvalidInput(f"measures must be names of results or functions of the solution; got {shown(measures)}")
    if not chosen:
        raise InvalidInput("measures must name at least one result; it is empty")
    return list(chosen)


class RunTask:
    """Runs of a model, and what is kept of each.

    Parameters
    ----------
    model : System or model
    measures : str, callable, or sequence of these
        Names: "final_state", "amplitude", "period", "modes", "paradoxes", "inconsistent", "indeterminate", "impacts",
        "mode_changes", "residual", "penetration", "end_time". A callable takes the Solution and returns a number, an
        array or a dict of those; it runs cell by cell.
    t_span : (float, float), optional
        Start and end [s]; (0, t_end) when left out.
    integrator : MoreauJean or another, optional
        MoreauJean(dt) when left out, with the ``dt`` of the model or the system.
    state : dict or (q0, u0), optional
        Arguments of ``model.state``; of a system without one its coordinates and their rates; {"q0[0]": ...} for an
        entry.
    selection : str
        Which solution is taken where a contact problem has several.
    window : float
        Amplitude and period are those of the last part of the run, from this fraction of its span on.
    every : int
        Steps between the records that amplitude and period are taken from.
    settle : float
        A motion has settled where its amplitude in both halves of the window, and the periods of its earlier and of its
        later crossings, agree to this part of them; "settled" says it of each cell (1 or 0), and the sweep warns.
    settle_by : float, optional
        Runs that have not settled go on until they are twice as long, and so on, with the window twice as long too,
        until they have or the end is this late [s]; "end_time" has the end of each, the first record that is not
        before it. When left out all end where they are said to.
    record : str or sequence of str, optional
        What the runs that functions measure record, as of `simulate`; a name decides by itself what is kept.

    Raises
    ------
    InvalidInput
        For options that break a rule; UnknownName for a measure, a selection or a state variable that does not exist.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> from nonsmooth.catalogue import BeltOscillator
    >>> task = ns.RunTask(BeltOscillator(), "amplitude", t_span=(0, 20), integrator=ns.MoreauJean(dt=1e-2))
    >>> found = ns.sweep(task, {"vb": [0.1, 0.2]})
    >>> found.amplitude.dims
    ('vb', 'coordinate')
    """

    @answers_start
    def __init__(
        self,
        model: Any,
        measures: str | Callable[..., Any] | Sequence[str | Callable[..., Any]] = "final_state",
        *,
        t_span: tuple[float, float] | None = None,
        integrator: Any = None,
        state: Any = None,
        selection: str = "compliant-limit",
        window: float = WINDOW_START,
        every: int = 1,
        settle: float = SETTLED_AMPLITUDE,
        settle_by: float | None = None,
        record: str | Sequence[str] | None = None,
    ) -> None:
        model = as_model(model)
        self.model, self.system = model, as_system(model)
        chosen = as_measures(measures)
        self.measures: dict[str, Measure] = {name: measure_named(name) for name in chosen if isinstance(name, str)}
        self.functions = [function for function in chosen if not isinstance(function, str)]
        as_name("selection rule", selection, SELECTIONS)
        self.record = KINDS_OF_SYSTEM.chosen(record)
        self.selection, self.every, self.window = selection, as_count("every", every), as_fraction("window", window)
        self.integrator = own_steps(model) if integrator is None else integrator
        require_integrator(self.integrator)
        self.t_span = span_of(model, t_span)
        self.settle, self.settle_by = as_positive("settle", settle), None
        if settle_by is not None:
            if not self._may_settle:
                raise InvalidInput("settle_by= needs a measure that settles: 'amplitude' or 'period'")
            self.settle_by = as_positive("settle_by", settle_by, "s")
            if self.settle_by < self.t_span[1]:
                raise InvalidInput(f"settle_by must not lie before the end, {self.t_span[1]:g} s; got {settle_by:g}")
            self.measures |= {"end_time": measure_named("end_time")}
        self.state = checked_state(model, state)
        self.names = AxisNames(model, self.integrator)
        self._prepare()
        self._table(self.integrator, self.t_span[1])  # an unfit span or dt is met here

    def _prepare(self) -> None:
        self.rows = RowBuilder(self.model, self.state)
        self.is_block = not self.functions
        self.holds_interpreter = not self.is_block
        self._engines: dict[Any, BlockEngine] = {}

    def __getstate__(self) -> dict[str, Any]:
        state = dict(vars(self))
        for name in ("system", "rows", "_engines", "measures", "names"):  # made again where it arrives
            del state[name]
        return state | {"measure_names": list(self.measures)}

    def __setstate__(self, state: dict[str, Any]) -> None:
        names = state.pop("measure_names")
        vars(self).update(state)
        self.system = as_system(self.model)
        self.measures = {name: measure_named(name) for name in names}
        self.names = AxisNames(self.model, self.integrator)
        self._prepare()

    @property
    def variables(self) -> dict[str, Variable]:
        """The results that are known by name."""
        known = {name: variable for measure in self.measures.values() for name, variable in measure.variables.items()}
        if self.system.kinematics is not None and "u" in known:
            known["u"] = Variable(("rate",), OF_VELOCITY, known["u"].meaning)
        return known | ({"settled": SETTLED} if self._may_settle else {})

    @property
    def _may_settle(self) -> bool:
        return any(measure.needs_motion for measure in self.measures.values())

    @property
    def coordinates(self) -> dict[str, list[str]]:
        """Names and units of the coordinates, and of velocities that are not their rates."""
        described = self.system.described
        named = {"coordinate": described.coordinates, "rate": described.velocities}
        names = {kind: [name for name, _ in pairs] for kind, pairs in named.items()}
        return names | {f"{kind}_unit": [unit for _, unit in pairs] for kind, pairs in named.items()}

    @property
    def about(self) -> dict[str, str]:
        """The system and its parameters in words; an axis takes the place of its own."""
        return in_words(self.system)

    def unit(self, name: str) -> str:
        """Unit of an axis that is a coordinate, its rate, a time step or the end."""
        return "s" if name in ("dt", END) else unit_of(self.system, name)

    @property
    def _has_coordinates(self) -> bool:
        return any("coordinate" in variable.dims for variable in self.variables.values())

    def check(self, names: tuple[str, ...]) -> None:
        """Raise for an axis that neither model, state nor integrator has."""
        parts = self.names.split(dict.fromkeys(names, np.zeros(1)))
        if "q0" in self.state and own_state(self.model) is not None:
            for name in parts.arguments:
                raise InvalidInput(f"the axis {name} is a variable of state(...), but q0 and u0 are given; use q0[i]")

    def identity(self) -> str:
        """Model, parameters, integrator, span, start, measures, and the code of the model's functions."""
        state = {name: np.asarray(value).tolist() for name, value in sorted(self.state.items())}
        parts = (
            self.integrator, self.t_span, state, self.selection, self.window, self.every, list(self.measures),
            self.settle, self.settle_by, *([] if self.record == KINDS else [self.record]),
            [name_of(function) for function in self.functions],
        )  # fmt: skip
        return f"{identity_of_model(self.model, *self.functions)}\n{identity(parts).hex()}"

    def doubt(self, values: dict[str, np.ndarray]) -> str:
        """What is to be said of the results."""
        return doubt_of(values, self.settle)

    def load(self) -> None:
        """Compile the loop for the model as it is."""
        model_of(self.system).loop(self.integrator, self.system)
        if self.is_block:
            self._engine(self.system, self.integrator, self.t_span[1]).load()

    def __call__(self, columns: Columns) -> Batch:
        """Run a batch of cells. Those that have not settled go on until they are twice as long, as far as they may;
        where the block engine cannot do that they are made again."""
        result, stretch = self._run(columns, 1.0), 1.0
        if self.is_block:
            return result
        open_ = self._unsettled(result)
        while self.settle_by is not None and len(open_) and not self._is_last(columns, open_, stretch):
            stretch *= 2.0
            longer = self._run({name: values[open_] for name, values in columns.items()}, stretch)
            result.take(open_, longer)
            open_ = open_[self._unsettled(longer)]
        return result

    def _unsettled(self, result: Batch) -> np.ndarray:
        """Numbers of the cells that have not settled."""
        return np.flatnonzero(result.values["settled"] == 0.0) if "settled" in result.values else np.zeros(0, int)

    def _is_last(self, columns: Columns, cells: np.ndarray, stretch: float) -> bool:
        """Whether runs so many times as long reach the time by which they are to have settled."""
        ends = self.names.split(columns).options.get(END, np.full(1, self.t_span[1]))
        t_0 = self.t_span[0]
        shortest = float(np.min(ends[cells] if len(ends) > 1 else ends)) - t_0
        return t_0 + stretch * shortest >= (self.settle_by or 0.0)

    def _run(self, columns: Columns, stretch: float) -> Batch:
        """Run cells whose spans are so many times those that were given."""
        parts = self.names.split(columns)
        result = Batch({}, np.full(parts.length, int(CellStatus.NOT_RUN)))

        def fail(cells: np.ndarray, error: Exception) -> None:
            result.status[cells] = CellStatus.FAILED
            result.messages.update(dict.fromkeys(cells.tolist(), words_of(error)))

        for integrator, t_end, cells in self._integrators(parts.options, parts.length, fail, stretch):
            for rows in self.rows.rows(parts, cells, fail):
                if rows.system.n_q != self.system.n_q and self._has_coordinates:
                    words = f"{rows.system.n_q} coordinates where the other cells have {self.system.n_q}"
                    fail(rows.cells, InvalidInput(f"{words}: choose measures that do not list coordinates"))
                    continue
                if self.is_block:
                    try:
                        inspect_rows(rows, self.t_span[0])
                    except InvalidInput as error:
                        fail(rows.cells, error)
                        continue
                    self._run_block(rows, integrator, t_end, result, fail)
                else:
                    self._run_singly(rows, integrator, t_end, result, fail)
        is_settled = settled(result.values, self.settle)
        if is_settled is not None:
            result.values["settled"] = np.where(result.status == CellStatus.FINISHED, is_settled, np.nan)
        return result

    def _integrators(
        self, options: Columns, N: int, fail: Callable, stretch: float
    ) -> Iterator[tuple[Any, float, np.ndarray]]:
        """The different integrators and ends, and the cells of each."""
        rows, place = combinations(options, np.arange(N))
        for k, row in enumerate(rows):
            cells = np.flatnonzero(place == k)
            t_end = self._end(row.pop(END, self.t_span[1]), stretch)
            try:
                integrator = replace(self.integrator, **row) if row else self.integrator
                self._table(integrator, t_end)
            except InvalidInput as error:
                fail(cells, error)
                continue
            yield integrator, t_end, cells

    def _end(self, t_end: float, stretch: float) -> float:
        """The end of a run so many times as long, at most the time by which it is to have settled."""
        if stretch == 1.0 or self.settle_by is None:
            return t_end
        return max(t_end, min(self.t_span[0] + stretch * (t_end - self.t_span[0]), self.settle_by))

    def _table(self, integrator: Integrator, t_end: float) -> Timetable:
        every = 1 if integrator.chooses_steps else self._every
        return make_timetable(integrator, (self.t_span[0], t_end), every, None)

    @property
    def _every(self) -> int:
        has_motion = self.functions or any(measure.needs_motion for measure in self.measures.values())
        return self.every if has_motion else ONE_RECORD

    def _engine(self, system: System, integrator: Any, t_end: float) -> BlockEngine:
        """The engine of a system's shape; kept, since the cells of the next batch have the same."""
        key = (tuple(system.functions.items()), system.kinds.tobytes(), repr(integrator), t_end)
        if key not in self._engines:
            if len(self._engines) > 1000:
                self._engines.clear()
            has_motion = any(measure.needs_motion for measure in self.measures.values())
            window = self.window if has_motion else -1.0
            has_sequence = any(measure.needs_sequence for measure in self.measures.values())
            table, until = self._table(integrator, t_end), None
            if self.settle_by is not None and self.settle_by > t_end:
                table, until = self._table(integrator, self.settle_by), self._settling(t_end)
            rule = SELECTIONS[self.selection]
            has_events = any(measure.needs_events for measure in self.measures.values())
            self._engines[key] = BlockEngine(system, integrator, table, rule, window, has_sequence, has_events, until)
        return self._engines[key]

    def _settling(self, t_end: float) -> Settling:
        """When runs that are first looked at at t_end may end."""
        asks = ASKS_AMPLITUDE * ("amplitude" in self.measures) + ASKS_PERIOD * ("period" in self.measures)
        return Settling(t_end - self.t_span[0], self.settle, asks)

    def _run_block(self, rows: Rows, integrator: Integrator, t_end: float, result: Batch, fail: Callable) -> None:
        engine = self._engine(rows.system, integrator, t_end)
        cells = engine.new_cells(len(rows.cells))
        cells.p[:], cells.laws[:], cells.q_0[:], cells.u_0[:] = rows.p, rows.laws, rows.q, rows.u
        write_handles(cells.laws, rows.system.own_laws, rows.system.unpack, cells.p)
        refused = engine.run(cells)
        result.status[rows.cells] = cells.status
        result.inadmissible += int((cells.start == INADMISSIBLE).sum())
        for measure in self.measures.values():
            for name, values in measure.of_cells(cells).items():
                result.put(name, rows.cells, values)
        for k in np.flatnonzero(cells.status != Status.FINISHED):
            ended = Status(int(cells.status[k]))
            words = MESSAGES.get(ended, "a model function raised, or wrote NaN or inf")
            if ended == Status.BUDGET_SPENT:
                words = f"{integrator.budget} is used up"
            result.messages[int(rows.cells[k])] = (
                f"{words.format(contact='a contact')}; stopped at t = {cells.t[k]:.9g} s"
            )
        for cell, refusal in refused.items():
            fail(rows.cells[cell : cell + 1], refusal)

    def _run_singly(self, rows: Rows, integrator: Any, t_end: float, result: Batch, fail: Callable) -> None:
        parameters = list(rows.system.numbers)
        for k, cell in enumerate(rows.cells):
            system = rows.system.with_parameters(**dict(zip(parameters, rows.p[k].tolist(), strict=True)))
            try:
                solution = simulate_whole(
                    system, (self.t_span[0], t_end), rows.q[k], rows.u[k], integrator=integrator,
                    selection=self.selection, on_failure="return",
                    every=1 if integrator.chooses_steps else self._every, record=self.record,
                )  # fmt: skip
                values = self._measure(solution)
            except Exception as error:
                fail(rows.cells[k : k + 1], error)
                continue
            result.status[cell] = int(solution.status)
            if not solution.success:
                result.messages[int(cell)] = solution.message
            for name, value in values.items():
                result.put(name, rows.cells[k : k + 1], np.array([value]))

    def _measure(self, solution: Solution) -> dict[str, Any]:
        first = first_of_window(solution.t, self.window)
        values: dict[str, Any] = {}
        for measure in self.measures.values():
            values |= measure.of_solution(solution, first)
        for function in self.functions:
            found = function(solution)
            values |= as_values(found if isinstance(found, Mapping) else {name_of(function).split(".")[-1]: found})
        return values


def in_words(system: System) -> dict[str, str]:
    """The name of a system and its parameters, those left out that its choices leave unread."""
    values, idle = system.parameter_values, idle_parameters(system)
    words = [f"{name} = {value:.4g}" for name, value in values.items() if name not in idle]
    return {"system": title_of(system), "parameters": "  ".join(words)}


def checked_state(model: Any, given: Any) -> dict[str, Any]:
    """The start of every run: {"q0": ..., "u0": ...}, or variables of the state, and single entries as "q0[1]"."""
    if given is None and own_state(model) is None:
        raise InvalidInput(f"this system has no state(...) of its own; give state={forms_of(model)}")
    if given is not None and not isinstance(given, Mapping):
        return dict(zip(("q0", "u0"), start_of(model, given), strict=True))
    whole, entries, variables = split_state(model, given or {})
    if whole:
        return dict(zip(("q0", "u0"), start_of(model, given), strict=True))
    return {**variables, **{f"{which}0[{k}]": value for (which, k), value in entries.items()}}


def inspect_rows(rows: Rows, t: float) -> None:
    """Try the functions of a system with the values of the first cell and of the last, before compiled code calls them.

    Raises
    ------
    InvalidInput
        For a function that cannot be right.
    """
    for k in {0, len(rows.cells) - 1}:
        values = dict(zip(rows.system.numbers, rows.p[k].tolist(), strict=True))
        inspect_start(rows.system.with_parameters(**values), t, rows.q[k], rows.u[k])


def first_of_window(t: np.ndarray, fraction: float) -> int:
    """The first record that is not before this fraction of the span."""
    return int(np.searchsorted(t, t[0] + fraction * (t[-1] - t[0])))
