"""What a sweep runs: the contract of a task, and the task made of a plain function.

A task answers for a batch of cells at once: columns of axis values in, columns of results out. A cell that fails has a
status and a message instead of an exception; its results are NaN.
"""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from enum import IntEnum
from typing import Any, Protocol

import numpy as np

from nonsmooth.errors import (
    InvalidInput,
    NonsmoothError,
    Status,
    UnknownName,
    nearest,
    shown,
)
from nonsmooth.jit import identity as identity_of
from nonsmooth.mechanics.model_system import as_system
from nonsmooth.results.failures import StepFailure
from nonsmooth.runs.run import Run


class CellStatus(IntEnum):
    """How a cell ended: as the integration did (the members of `Status`), or in one of the ways added here."""

    NOT_RUN = 0
    FINISHED = Status.FINISHED
    NO_SOLUTION = Status.NO_SOLUTION
    NOT_SOLVED = Status.NOT_SOLVED
    NOT_FINITE = Status.NOT_FINITE
    MASS_NOT_POSITIVE = Status.MASS_NOT_POSITIVE
    NEGATIVE_FRICTION = Status.NEGATIVE_FRICTION
    INTERRUPTED = Status.INTERRUPTED
    STEP_VANISHED = Status.STEP_VANISHED
    CHATTERING = Status.CHATTERING
    EVENT_REACHED = Status.EVENT_REACHED
    EVENT_FAILED = Status.EVENT_FAILED
    BUDGET_SPENT = Status.BUDGET_SPENT
    CONTRADICTED = Status.CONTRADICTED
    PROGRESS_FAILED = Status.PROGRESS_FAILED
    FAILED = 20  # an exception: parameters out of range, or raised by the task's own function
    CRASHED = 21  # the process that ran the cell died, also when it ran this cell alone
    TIMED_OUT = 22


@dataclass
class Batch:
    """The results of N cells.

    Attributes
    ----------
    values : dict of arrays (N, ...)
    status : (N,) CellStatus
    messages : dict
        Number of the cell within the batch -> what went wrong.
    inadmissible : int
        Number of cells whose initial state penetrates a contact or violates a bilateral one.
    elapsed : float
        Wall time [s].
    """

    values: dict[str, np.ndarray]
    status: np.ndarray
    messages: dict[int, str] = field(default_factory=dict)
    inadmissible: int = 0
    elapsed: float = 0.0

    def take(self, cells: np.ndarray, other: Batch) -> None:
        """Put the results of some cells, run again, in place of theirs."""
        self.status[cells] = other.status
        self.elapsed += other.elapsed
        for k, cell in enumerate(cells.tolist()):
            self.messages.pop(cell, None)
            if k in other.messages:
                self.messages[cell] = other.messages[k]
        for name, values in other.values.items():
            self.put(name, cells, values)

    def put(self, name: str, cells: np.ndarray | slice, values: np.ndarray) -> None:
        """Write the results (k, ...) of k cells."""
        put(self.values, name, cells, values, len(self.status))


# stand in a unit for that of each coordinate, or velocity
OF_COORDINATE, OF_VELOCITY = "[q]", "[u]"


@dataclass(frozen=True)
class Variable:
    """A result of each cell: its further dimensions, unit and meaning, and whether it is a text."""

    dims: tuple[str, ...] = ()
    unit: str = ""
    meaning: str = ""
    is_text: bool = False


class Task(Protocol):
    """What `sweep` asks of a task."""

    holds_interpreter: bool  # whether threads would wait for each other

    @property
    def variables(self) -> dict[str, Variable]:
        """What is known of the results before the first cell; names that are missing here have no unit."""

    @property
    def coordinates(self) -> dict[str, list[str]]:
        """Labels along further dimensions; "coordinate_unit" are the units of "coordinate"."""

    def unit(self, name: str) -> str:
        """Unit of an axis, "" where it is not known."""

    def check(self, names: tuple[str, ...]) -> None:
        """Raise `UnknownName` for an axis that the task does not take."""

    def identity(self) -> str:
        """A text that is equal for equal tasks, in every process; `Unidentified` where nothing distinguishes them."""

    def load(self) -> None:
        """Compile what the cells will call: this is not part of their time."""

    def __call__(self, columns: Mapping[str, np.ndarray]) -> Batch:
        """Run a batch."""


class FunctionTask:
    """A function of the axes, called once a cell.

    Parameters
    ----------
    function : callable
        ``function(**cell)``, one keyword an axis; returns a number, an array of numbers, or a dict of those. To leave
        this process it must be picklable.
    """

    holds_interpreter = True
    variables: dict[str, Variable] = {}
    coordinates: dict[str, list[str]] = {}

    def __init__(self, function: Callable) -> None:
        self.function = function

    def check(self, names: tuple[str, ...]) -> None:
        """Raise unless the function takes these keywords."""
        try:
            signature = inspect.signature(self.function)
        except ValueError:
            return
        except Exception:  # whatever an object raises that is asked what it takes
            raise InvalidInput(f"task must be a function of the axes; got {shown(self.function)}") from None
        kinds = {name: parameter.kind for name, parameter in signature.parameters.items()}
        if inspect.Parameter.VAR_KEYWORD not in kinds.values():
            for name in names:
                if name not in kinds:
                    raise UnknownName(f"the task {name_of(self.function)} takes no {name!r}; {nearest(name, kinds)}")
        try:
            signature.bind(**dict.fromkeys(names))
        except TypeError as error:
            raise InvalidInput(
                f"the task {name_of(self.function)}{signature} needs another axis, or a default: {error}"
            ) from None

    def unit(self, name: str) -> str:
        """Not known of a function's arguments."""
        return ""

    def load(self) -> None:
        """Nothing that is known here."""

    def identity(self) -> str:
        """Name and content of the function."""
        function = self.function
        own = getattr(function, "identity", None) if type(function).__module__.startswith("nonsmooth.") else None
        return f"{name_of(function)}\n{own() if own is not None else identity_of(function).hex()}"

    def value(self, **cell: Any) -> dict[str, Any]:
        """What is kept of a cell."""
        return as_values(self.function(**cell))

    def __call__(self, columns: Mapping[str, np.ndarray]) -> Batch:
        """Call the function for each cell of a batch."""
        N = len(next(iter(columns.values())))
        results: list[dict[str, Any] | Exception] = []
        before = Run.interrupted
        for i in range(N):
            try:
                results.append(self.value(**{name: values[i].item() for name, values in columns.items()}))
            except Exception as error:
                results.append(error)
            if Run.interrupted != before:  # of a run that Ctrl-C cut, the function had a part
                raise KeyboardInterrupt
        return stack(results)


def identity_of_model(model: Any, *functions: Any) -> str:
    """A text that is equal for equal models: parameters, contacts, the content of its functions and of further ones."""
    system = as_system(model)
    numbers = type(model).__qualname__, system.name, tuple(system.numbers.items())
    return identity_of(numbers, tuple(system.functions), *map(system.given, system.functions), system.contacts,
                       *functions).hex()  # fmt: skip


def name_of(function: Any) -> str:
    """A callable as a person would call it."""
    while isinstance(function, functools.partial):
        function = function.func
    module, name = getattr(function, "__module__", ""), getattr(function, "__qualname__", type(function).__qualname__)
    return f"{module}.{name}"


def as_values(result: Any) -> dict[str, Any]:
    """What a function gave back for a cell, as named numbers, arrays and texts."""
    named = result if isinstance(result, Mapping) else {"value": result}
    values: dict[str, Any] = {}
    for name, value in named.items():
        if isinstance(value, str):
            values[str(name)] = value
            continue
        try:
            values[str(name)] = np.asarray(value, dtype=np.float64)
        except (TypeError, ValueError):
            raise InvalidInput(f"{name} must be a number, an array of numbers or a text; got {value!r}") from None
    return values


def stack(results: list[dict[str, Any] | Exception]) -> Batch:
    """The results of cells one by one as columns; NaN where a cell has no such result."""
    batch = Batch({}, np.full(len(results), int(CellStatus.FINISHED)))
    for i, result in enumerate(results):
        if isinstance(result, Exception):
            batch.status[i], batch.messages[i] = status_of(result), words_of(result)
            continue
        for name, value in result.items():
            batch.put(name, np.array([i]), np.array([value]))
    return batch


def status_of(error: Exception) -> int:
    """How a cell ended that raised: as its run did, where it was a run."""
    return int(error.solution.status if isinstance(error, StepFailure) else CellStatus.FAILED)


def words_of(error: Exception) -> str:
    """What went wrong, in a sentence; of errors that are not this package's, with their type."""
    return str(error) if isinstance(error, NonsmoothError) else f"{type(error).__name__}: {error}"


def put(columns: dict[str, np.ndarray], name: str, cells: np.ndarray | slice, values: np.ndarray, N: int) -> None:
    """Write the results of some cells into columns of N that hold NaN, or an empty text, where nothing was written.

    Raises
    ------
    InvalidInput
        When the results differ in shape or kind from those written before.
    """
    is_text = values.dtype.kind in "OU"
    if name not in columns and isinstance(cells, slice) and cells == slice(0, N):
        columns[name] = values.astype(object if is_text else float, copy=False)
        return
    if name not in columns:
        columns[name] = np.full((N, *values.shape[1:]), "" if is_text else np.nan, object if is_text else float)
    column = columns[name]
    if column.shape[1:] != values.shape[1:] or (column.dtype == object) != is_text:
        raise InvalidInput(
            f"the result {name} must be alike in every cell; it has shape {column.shape[1:]} in one and "
            f"{values.shape[1:]} in another" + (", or is a text in one of them" if is_text else "")
        )
    column[cells] = values


def as_slice(cells: np.ndarray) -> np.ndarray | slice:
    """Numbers of cells, as a slice where they are all those from one to another: that is five times as fast."""
    is_whole = len(cells) > 0 and bool((np.diff(cells) == 1).all())
    return slice(int(cells[0]), int(cells[-1]) + 1) if is_whole else cells
