"""What a run gives back: states, impulses, modes, events, energy ledger, figures of merit."""

from __future__ import annotations

import functools
from collections.abc import Callable
from dataclasses import dataclass, field, fields
from enum import IntEnum
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from nonsmooth.checks.arrays import as_name
from nonsmooth.errors import InvalidInput, Status
from nonsmooth.integrators import records
from nonsmooth.integrators.fixed_step import FixedStep
from nonsmooth.jit.blocks import fields_of, numbers
from nonsmooth.mechanics.description import Description, numbered, title_of
from nonsmooth.mechanics.system import MASS, POTENTIAL, ContactMode, System
from nonsmooth.results.forms import REAL, WHOLE, Rule
from nonsmooth.results.motion import Motion, Side, StateAt
from nonsmooth.results.recorded import (
    COORDINATES,
    EVENTS,
    GAPS,
    IMPULSES,
    KINDS,
    KINDS_BETWEEN,
    LEDGER,
    MODES,
    VELOCITIES,
    Recorded,
    not_recorded,
)
from nonsmooth.views import view


class EventKind(IntEnum):
    """What happened at an event."""

    MODE_CHANGE = records.MODE_CHANGE
    IMPACT = records.IMPACT
    INCONSISTENT = records.INCONSISTENT
    INDETERMINATE = records.INDETERMINATE


WHOLE_COLUMNS = (  # code: of an event; its impulses and velocities are no whole numbers, and may be infinite
    records.EVENT_KIND, records.EVENT_CONTACT, records.EVENT_MODE_0, records.EVENT_SLIP_0, records.EVENT_MODE_1,
    records.EVENT_SLIP_1, records.EVENT_SOLUTIONS, records.EVENT_FOUND,
)  # fmt: skip
MOST_NAMED = 5  # chosen: contacts by name in a message
NONE_TOGETHER = 0, ""  # of a run in which no contacts were hit at once
MAX_EVENTS = 200_000  # chosen: kept in a solution; the rest are counted
CANDIDATE_NAMES = ("free", "stick", "slide +", "slide -", "slide + (P_N < 0)", "slide - (P_N < 0)")


@dataclass(frozen=True)
class Event:
    """A change at one contact, found in the step that begins at t.

    Attributes
    ----------
    t : float
        Beginning of the step [s].
    kind : EventKind
    contact : int
    mode_before, mode_after : ContactMode
    slip_before, slip_after : int
        Signs of sliding.
    P_N, P_F : float
        Impulses of the step [N s].
    gamma_N, gamma_F : float
        Contact velocities before the step [m/s].
    """

    t: float
    kind: EventKind
    contact: int
    mode_before: ContactMode
    slip_before: int
    mode_after: ContactMode
    slip_after: int
    P_N: float
    P_F: float
    gamma_N: float
    gamma_F: float


@dataclass(frozen=True)
class ParadoxEvent(Event):
    """A step whose sliding had no force (INCONSISTENT: an impact without collision), or the first step of an episode in
    which the contact problem had several solutions (INDETERMINATE).

    Attributes
    ----------
    n_solutions : int
        Number of solutions of the rigid problem: 0 where sliding was inconsistent.
    alternatives : tuple of str
        The admissible modes among which the selection rule chose, where they are known one by one; none where sliding
        was inconsistent.
    """

    n_solutions: int
    alternatives: tuple[str, ...]

    @property
    def choice(self) -> str:
        """The mode that was taken: of an impact without collision, the mode after it."""
        return mode_name(self.mode_after, self.slip_after)


@dataclass(frozen=True, eq=False, repr=False)
class Stats:
    """What a run cost, and its worst figures.

    Attributes
    ----------
    steps, lcp_solved, lcp_skipped, lcp_kept : int
        Steps; contact problems solved; steps without a closed contact; problems answered by the impulses or
        the modes of the step before.
    pivots : int
        Of Lemke's method.
    indeterminate_steps : int
        Steps whose problem had several solutions.
    worst_residual : float
        Of the accepted contact problems, relative to max |c|.
    worst_penetration : float
        Deepest gap at a mid-point [m].
    ledger_error : float
        Largest error of the energy balance of one step, relative to the sum of the sizes of the terms of a step,
        the largest so far; of a run whose ledger was recorded.
    energy_gains : int
        Impacts, or steps with an impact, in which the contacts gained energy, as Newton's law with friction lets them
        (docs/theory/moreau_jean.md); of rigid contacts.
    worst_energy_gain : float
        The most that one of them gained [J].
    struck_together : int
        Impacts, or steps with an impact, in which Newton's law with e_N > 0 rebounded several coupled contacts at once.
    first_together : str
        When the first of them was, and which contacts it struck.
    uncounted : int
        Contact problems of several contacts whose solutions were not counted: neither certified to be one, nor
        enumerated, nor near enough to a problem that was (docs/theory/selection.md).
    shared : int
        Contact problems in which redundant contacts share a load: their impulses are one admissible share of many
        (docs/theory/moreau_jean.md).
    wall_time, compile_time : float
        [s]
    rejected, evaluations, jacobians, factorisations : int
        Of an integrator that chooses its steps: steps that were refused, evaluations of the rates, Jacobians, and
        factorisations of its linear systems.
    """

    steps: int
    lcp_solved: int
    lcp_skipped: int
    lcp_kept: int
    pivots: int
    indeterminate_steps: int
    events_dropped: int
    worst_residual: float
    worst_penetration: float
    ledger_error: float
    wall_time: float
    compile_time: float
    is_compiled: bool
    energy_gains: int = 0
    worst_energy_gain: float = 0.0
    uncounted: int = 0
    shared: int = 0
    rejected: int = 0
    evaluations: int = 0
    jacobians: int = 0
    factorisations: int = 0
    struck_together: int = 0
    first_together: str = ""

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Stats) and vars(self) == vars(other)

    def __hash__(self) -> int:
        return hash(tuple(vars(self).values()))

    def __repr__(self) -> str:
        return f"Stats({', '.join(f'{name}={value!r}' for name, value in self.as_dict().items())})"

    def as_dict(self) -> dict[str, Any]:
        """The figures by name, as far as they are known."""
        return {name: value for name, value in vars(self).items() if value is not None}

    @classmethod
    def from_run(cls, state: records.State, system: System, *about: Any) -> Stats:
        """From the counters and the worst figures that a run left in its state; ``about``: see ``of_numbers``."""
        struck = int(state.together.count), first_together(system, state.together)
        return cls.of_numbers(numbers(state.counters).tolist(), numbers(state.worst).tolist(), struck, *about)

    @classmethod
    def of_numbers(
        cls, counters: list[int], worst_figures: list[float], struck: tuple[int, str], wall_time: float,
        compile_time: float, dropped: int, is_compiled: bool, recorded: tuple[str, ...],
    ) -> Stats:  # fmt: skip
        """From the numbers of a run's counters and worst figures, and its impacts at several contacts at once."""
        c = dict(zip(fields_of(records.Counters), counters, strict=True))
        worst = dict(zip(fields_of(records.Worst), worst_figures, strict=True))
        known_error: Any = worst["ledger_error"] if LEDGER in recorded else None
        return cls(
            c["steps"], c["solved"], c["skipped"], c["kept"], c["pivots"], c["several"], dropped + c["events_lost"],
            worst["residual"], worst["penetration"], known_error, wall_time,
            compile_time, is_compiled, c["gains"], worst["gain"], c["uncounted"], c["shared"], c["rejected"],
            c["evaluations"], c["jacobians"], c["factorisations"], *struck,
        )  # fmt: skip


setattr(Stats, "ledger_error", Recorded(LEDGER, "ledger_error"))  # noqa: B010  # to a type checker it stays a number

# the columns of the records, in memory and in every file: dtype and shape
PER_RECORD: dict[str, Rule] = {
    "t": (REAL, ("n_t",)), "q": (REAL, ("n_t", "n_q")), "u": (REAL, ("n_t", "n_u")), "g_N": (REAL, ("n_t", "n_c")),
    "P_N": (REAL, ("n_t", "n_c")), "P_F": (REAL, ("n_t", "n_c", "d")), "mode": (WHOLE, ("n_t", "n_c")),
    "slip": (WHOLE, ("n_t", "n_c")),
}  # fmt: skip


# the kind of each field that is there if its kind was recorded
KIND_OF = {
    "q": COORDINATES, "u": VELOCITIES, "g_N": GAPS, "P_N": IMPULSES, "P_F": IMPULSES, "la": IMPULSES, "mode": MODES,
    "slip": MODES, "find_ledger": LEDGER, "event_rows": EVENTS,
}  # fmt: skip


def per_record(record: records.Columns, recorded: tuple[str, ...]) -> dict[str, Any]:
    """Those columns of the rows that a run wrote; None for what was not recorded."""
    columns = record._asdict() | {"P_N": record.P[:, :, 0], "P_F": record.P[:, :, 1:]}
    return {name: columns[name] if KIND_OF.get(name) in (None, *recorded) else None for name in PER_RECORD}


@dataclass(frozen=True, eq=False)
class Solution:
    """The result of `simulate`.

    What was not recorded (``record=``) is no field with a value: asked for, it raises `InvalidInput`.

    Attributes
    ----------
    t : (n_t,) times of the records [s]
    q, u : (n_t, n_q), (n_t, n_u)
    g_N : (n_t, n_c) gaps [m]
    P_N : (n_t, n_c), P_F : (n_t, n_c, d)
        Impulses since the record before, of the first one since the start [N s].
    mode : (n_t, n_c) ContactMode, and slip : (n_t, n_c) sign of sliding, of the last step
    event_rows : (n_events, 13)
        The events as numbers; ``events`` and ``paradoxes`` give them as objects.
    ledger : dict of (n_t,) arrays [J]
        "kinetic", and the work since the start by "force", "friction", "normal", "surface", "projection";
        "potential" where the system has one. Where M depends on q or t: "mass", the rest of the kinetic energy, which
        is the work (u, dM/dt u)/2 of the changing mass (the gyroscopic part of h takes as much) and the errors of all.
    la : (n_t, n_c, 2) normal and friction forces [N], or None where the integrator works with impulses
    stats : Stats
    status : Status, message : str, success : bool
    t_events, q_events, u_events : list of (k,), (k, n_q), (k, n_u)
        Of each function in ``simulate(events=...)``: when it reached zero, and the state there.
    theta : float or None
        Of a time stepping all of whose steps are records: what the motion between them is found with.
    names : Description or None
        Of a run read from a file: the names that the file has.
    named_model : dict or None
        Of a run read from a file: what the model is called, and its parameters.
    """

    t: np.ndarray
    q: np.ndarray
    u: np.ndarray
    g_N: np.ndarray
    P_N: np.ndarray
    P_F: np.ndarray
    mode: np.ndarray
    slip: np.ndarray
    event_rows: np.ndarray
    find_ledger: Callable[[Any], dict[str, np.ndarray]]
    stats: Stats
    status: Status
    message: str
    about: dict[str, Any] = field(default_factory=dict)
    system: System | None = None
    la: np.ndarray | None = None
    find_motion: Callable[[], Motion] | None = None
    t_events: list[np.ndarray] = field(default_factory=list)
    q_events: list[np.ndarray] = field(default_factory=list)
    u_events: list[np.ndarray] = field(default_factory=list)
    theta: float | None = None
    names: Description | None = None
    named_model: dict[str, Any] | None = None

    @classmethod
    def from_run(
        cls, system: System, rest: dict[str, Any] | Callable[[], dict[str, Any]], event_rows: np.ndarray | None,
        status: Status, message: str, user_events: tuple[list[np.ndarray], ...] = ([], [], []),
    ) -> Solution:  # fmt: skip
        """What a run came to; ``rest``: the other fields (``rest_of_run``), or what finds them once one is asked."""
        solution = object.__new__(cls)
        t_events, q_events, u_events = user_events
        vars(solution).update(
            system=system, event_rows=event_rows, status=status, message=message, t_events=t_events, q_events=q_events,
            u_events=u_events, **({"_find_rest": rest} if callable(rest) else rest),
        )  # fmt: skip
        return solution

    @property
    def is_found(self) -> bool:
        """Whether all that is known of the run was asked for; nothing is to be said of one of which it was not."""
        return "stats" in vars(self)

    def __getstate__(self) -> dict[str, Any]:
        """All that is known: another process, or a copy, need not have what it is found from."""
        own = vars(self) if self.stats else {}  # which finds the others too
        return {part.name: own[part.name] if part.name in own else getattr(self, part.name) for part in fields(self)}

    @property
    def recorded(self) -> tuple[str, ...]:
        """What was recorded: "coordinates", "velocities", "gaps", "impulses", "modes", "ledger", "events"."""
        own = self.__getstate__()
        held = {kind for name, kind in KIND_OF.items() if own[name] is not None}
        return tuple(kind for kind in KINDS if kind in held)

    def changed(self, **changes: Any) -> Solution:
        """The same with other values of some fields."""
        return Solution(**(self.__getstate__() | changes))

    def without_start(self) -> Solution:
        """The same without its first record; impulses and works remain those since the start."""
        own = self.__getstate__()
        changes = {name: own[name][1:] for name in (*PER_RECORD, "la") if own[name] is not None}
        if own["find_ledger"] is not None:
            changes["find_ledger"] = functools.partial(_ledger_behind_start, own["find_ledger"], len(self.t))
        return self.changed(**changes, theta=None)  # a step less than the motion has

    @property
    def described(self) -> Description:
        """Names and units of the coordinates, names of the contacts; numbers where they are not known."""
        if self.system is None:
            return self.names or numbered(self.q.shape[1], self.mode.shape[1])
        return self.system.described

    def __getitem__(self, name: str) -> np.ndarray:
        """The column of a coordinate or its rate, by name: ``sol["th"]``, ``sol["thdot"]`` (n_t,).

        Raises
        ------
        UnknownName
            For a name that the system does not give; without names they are "q[0]", "u[0]".
        """
        places = {known: (self.q, k) for k, (known, _) in enumerate(self.described.coordinates)}
        places |= {known: (self.u, k) for k, (known, _) in enumerate(self.described.rates)}
        column, k = places[as_name("coordinate or velocity", name, places)]
        return column[:, k]

    @property
    def success(self) -> bool:
        """Whether the end, or a terminal event, was reached."""
        return self.status in (Status.FINISHED, Status.EVENT_REACHED)

    def __call__(self, t: ArrayLike, side: Side = "right") -> StateAt:
        """The state between the records, ``q, u = sol(t)``.

        Of EventDriven and Penalty the error is of order 5 in the step, as that of the records (in motion stiffer than
        the step of order 4); of Adaptive it stays a few tolerances; of MoreauJean it is of order 2. Of the last two an
        impact lies within its step. q' = u throughout.

        Parameters
        ----------
        t : float or array_like (m,)
            Within the times of the run [s].
        side : {"right", "left"}
            Where the velocities jump: those after the jump, or before it.

        Returns
        -------
        StateAt
            q (n_q,), u (n_u,) at one time; q (m, n_q), u (m, n_u) at m times.

        Raises
        ------
        InvalidInput
            For a time outside the run, and where the steps are not known.

        Examples
        --------
        >>> import nonsmooth as ns
        >>> from nonsmooth.catalogue import BouncingBall
        >>> ball = BouncingBall(e=0.5, g=10.0)
        >>> sol = ns.simulate(ball, (0, 1), *ball.state(height=5.0), integrator=ns.EventDriven())
        >>> q, u = sol(0.5)
        >>> round(float(q[0]), 12), round(float(u[0]), 12), round(float(sol(1.0, side="left").u[0]), 12)
        (3.75, -5.0, -10.0)
        """
        return self.motion(t, side)

    @functools.cached_property
    def motion(self) -> Motion:
        """The motion as a function of time; found when first asked for."""
        if self.find_motion is None:
            for kind in KINDS_BETWEEN:
                if kind not in self.recorded:
                    raise not_recorded(f"the motion between the records (it needs the {kind})", kind)
            raise InvalidInput(
                "this solution knows its records only: its integrator keeps no steps, or none in a checkpoint, or not "
                "every step was recorded; run without every=, t_eval= and checkpoint= to ask for other times"
            )
        return self.find_motion()

    @functools.cached_property
    def ledger(self) -> dict[str, np.ndarray]:
        """Energies and works since the start, by name; found when first asked for."""
        return self.find_ledger(slice(None))

    @property
    def events(self) -> list[Event]:
        """Mode changes, impacts and paradoxes, in order."""
        return [event_of(row) for row in self.event_rows]

    @property
    def paradoxes(self) -> list[ParadoxEvent]:
        """The events at which rigid mechanics had no solution, or several."""
        is_paradox = self.event_rows[:, records.EVENT_KIND] >= records.INCONSISTENT
        return [event_of(row) for row in self.event_rows[is_paradox]]  # type: ignore[misc]

    def summary(self) -> str:
        """The run in a few lines: modes with times, paradoxes, worst figures, energy, cost."""
        return view(self, "summary")(self)

    def plot(self, path: str | Path | None = None) -> Any:
        """Draw the run (needs the extra [plot]); returns the Matplotlib figure, saved to ``path`` if given."""
        return view(self, "plot")(self, path)

    def picture(
        self, path: str | Path | None = None, n: int = 5, times: Any = None, width: float | None = None
    ) -> Any:  # fmt: skip
        """Draw a planar scene at n instants, or at ``times`` [s], ``width`` [mm] wide (needs the extra [plot]); returns
        the figure, saved to ``path`` if any."""
        return view(self, "picture")(self, path, n, times, width)

    def animate(self, path: str | Path | None = None, fps: int = 25) -> Any:
        """Write a .gif, .webp or .mp4 of a planar scene (needs the extra [plot], an .mp4 ffmpeg); without a path a
        notebook shows what comes back."""
        return view(self, "animate")(self, path, fps)

    def view(self, path: str | Path | None = None) -> Any:
        """The player of a planar scene: one .html file that any browser opens offline, or inline in a notebook.

        Parameters
        ----------
        path : path-like, optional
            Where to write; without it a notebook shows what comes back.

        Returns
        -------
        Path or Page
            The file, or the page.

        Raises
        ------
        InvalidInput
            When the model has no ``shape(q)``, this was read from a file, or the path cannot be written.
        """
        return view(self, "view")(self, path)

    def to_xarray(self) -> Any:
        """An ``xarray.Dataset`` with names and units (needs the extra [data]).

        Dimensions are t, coordinate and velocity (by name, where the model has names), contact, direction and event.

        Returns
        -------
        xarray.Dataset

        Raises
        ------
        MissingExtra
            Where xarray is not installed.
        """
        return view(self, "dataset")(self)

    def to_dataframe(self, what: str = "records") -> Any:
        """A ``pandas.DataFrame`` (needs the extra [data]).

        Parameters
        ----------
        what : {"records", "events"}
            A row a record, or a row an event.

        Returns
        -------
        pandas.DataFrame

        Raises
        ------
        InvalidInput, MissingExtra
            For another table, and where pandas is not installed.
        """
        return view(self, "table")(self, what)

    def save(self, path: str | Path) -> Path:
        """Write to .npz, or to .h5 (needs the extra [io]); or to .nc, netCDF for other programs ([data])."""
        return view(self, "save")(self, path)

    @staticmethod
    def load(path: str | Path, model: Any = None) -> Solution:
        """Read what `save` wrote: the numbers, the motion between the records, names and units, and the model.

        Parameters
        ----------
        path : path-like
            .npz, .h5, or .nc; or a checkpoint.
        model : System, model, its class, or str, optional
            Where the model is; a text is a name as in `nonsmooth list`, or ``FILE.py:NAME``, whose file is run. When
            left out, the one that the file names: a registered one, or one of a module that was imported. A class and
            a text get the parameters that the file has.

        Returns
        -------
        Solution

        Raises
        ------
        InvalidInput
            For a file that is none, or damaged, and for a model that does not fit.

        Warns
        -----
        ModelNotFoundWarning
            Where the model that the file names is not found: pictures are left out.
        """
        return view(Solution, "load")(path, model)

    def __repr__(self) -> str:
        return f"Solution({self.status.name}, t = {self.t[-1]:.6g} s, {self.stats.steps} steps)"

    def _repr_html_(self) -> str:
        return view(self, "html")(self)


class FoundLater:
    """A field of a `Solution` that is found, with the others of its kind, when one of them is first asked for; there if
    its kind was recorded."""

    def __init__(self, name: str) -> None:
        self.name = name
        self.kind = KIND_OF.get(name)

    def __get__(self, solution: Solution | None, owner: type) -> Any:
        if solution is None:
            return self
        own = vars(solution)
        if self.name not in own:
            own.update({**own["_find_rest"](), **own})  # what was set stays
        value = own[self.name]
        if value is None and self.kind is not None and self.kind not in solution.recorded:
            raise not_recorded(self.name.removeprefix("find_"), self.kind)
        return value

    def __set__(self, solution: Solution, value: Any) -> None:
        vars(solution)[self.name] = value


FOUND_LATER = (*PER_RECORD, "find_ledger", "find_motion", "stats", "about", "la", "theta")
for _name in (*FOUND_LATER, "event_rows"):
    setattr(Solution, _name, FoundLater(_name))


def rest_of_run(
    system: System, integrator: Any, record: records.Columns, stats: Stats, find_motion: Callable[[], Motion] | None,
    recorded: tuple[str, ...],
) -> dict[str, Any]:  # fmt: skip
    """The fields of a solution that are found later, from the rows of the loop."""
    return per_record(record, recorded) | {
        "find_ledger": finder_of_ledger(system, record, recorded), "find_motion": find_motion, "stats": stats,
        "about": about_run(system, integrator),
        "la": record.la if integrator.has_forces and IMPULSES in recorded else None,
        "theta": theta_of(integrator) if find_motion is not None else None,
    }  # fmt: skip


def mode_name(mode: int, slip: int) -> str:
    """A mode as a person would write it; a closed contact without friction is not locked: it slides freely."""
    name = "closed" if mode == ContactMode.LOCKED else ContactMode(mode).name.lower()
    return name + {1: " +", -1: " -", 0: ""}[int(slip)]


def first_together(system: System, together: records.Together) -> str:
    """When contacts were first struck together, and which; nothing where they never were."""
    if not together.count:
        return ""
    names = [system.described.contacts[i] for i in np.flatnonzero(together.struck)]
    more = [f"{len(names) - MOST_NAMED} more"] if len(names) > MOST_NAMED + 1 else []
    names = (names[:MOST_NAMED] if more else names) + more
    return f"at t = {float(together.t):.6g} s {', '.join(names[:-1])} and {names[-1]}"


def rebound_together(stats: Stats) -> str:
    """What is to be said of a run in which Newton's law decided several contacts at once."""
    times = "" if stats.struck_together == 1 else f" ({stats.struck_together} times in all)"
    return (
        f"{stats.first_together} were hit at once{times}, and Newton's law of impact with e_N > 0 rebounds them "
        "together, one answer of many: impact='sequential' strikes one after the other, as a smaller dt does where "
        "they are apart, impact='poisson' gives back what was compressed, impact='energetic' gives it back as equal "
        "springs do, e_N = 0 has no rebound, and impact='newton' chooses this answer"
    )


def theta_of(integrator: Any) -> float | None:
    """Where a time stepping takes its forces; None of a method that keeps its steps."""
    return float(integrator.theta) if isinstance(integrator, FixedStep) else None


def energy_gain(stats: Stats) -> str:
    """What is to be said of a run whose contacts gained energy."""
    impacts = "one impact" if stats.energy_gains == 1 else f"{stats.energy_gains} impacts"
    return (
        f"the contacts gained energy in {impacts}, up to {stats.worst_energy_gain:.3g} J: Newton's law of impact lets "
        "them where coefficients differ, as e_N > 0 with friction of e_F = 0; a single contact with "
        "impact='energetic', or one e for e_N and e_F of all contacts, does not gain"
    )


@functools.lru_cache(maxsize=64)
def words_of(integrator: Any) -> str:
    """An integrator as it would be typed; measured: 10 us, for a run of 150."""
    return repr(integrator)


def about_run(system: System, integrator: Any) -> dict[str, Any]:
    """What was run, by name."""
    return {
        "system": title_of(system),
        "integrator": words_of(integrator),
        **system.parameter_values,
    }


def works_by_name(columns: np.ndarray) -> dict[str, np.ndarray]:
    """The works since the start (m, 5) as the ledger's columns."""
    names = ("force", "friction", "normal", "surface", "projection")
    return {name: columns[:, k] for k, name in enumerate(names)}


def finder_of_ledger(
    system: System | None, record: Any, recorded: tuple[str, ...]
) -> Callable[[Any], dict[str, np.ndarray]] | None:
    """What finds the ledger at some rows of a record: without the system, or its motion, the works alone."""
    if LEDGER not in recorded:
        return None
    if system is None or COORDINATES not in recorded or VELOCITIES not in recorded:
        return functools.partial(_works_at, record.ledger)
    return functools.partial(ledger_of, system, record.t, record.q, record.u, record.ledger)


def _works_at(works: np.ndarray, rows: Any) -> dict[str, np.ndarray]:
    return works_by_name(works[rows])


def ledger_of(
    system: System, t: np.ndarray, q: np.ndarray, u: np.ndarray, works: np.ndarray, rows: Any
) -> dict[str, np.ndarray]:
    """Energies and works at some rows of a record."""
    ledger = works_by_name(works[rows])
    ledger["kinetic"] = kinetic_energy(system, t[rows], q[rows], u[rows])
    if mass_changes(system):
        change = ledger["kinetic"] - kinetic_energy(system, t[:1], q[:1], u[:1])
        ledger["mass"] = change - sum(ledger[name] for name in ("force", "friction", "normal", "surface"))
    if POTENTIAL in system.functions:
        states = zip(t[rows], q[rows], u[rows], strict=True)
        ledger["potential"] = np.array([system.evaluate(POTENTIAL, *state)[0] for state in states])
    return ledger


def _ledger_behind_start(
    find_ledger: Callable[[Any], dict[str, np.ndarray]], m: int, rows: Any
) -> dict[str, np.ndarray]:
    """The ledger at some rows of a record of m rows, its first one not counted."""
    return find_ledger(np.arange(1, m)[rows])


def mass_changes(system: System) -> bool:
    """Whether M depends on the coordinates or the time."""
    return system.reads(MASS, "q") or system.reads(MASS, "t")


def kinetic_energy(system: System, t: np.ndarray, q: np.ndarray, u: np.ndarray) -> np.ndarray:
    """(u, M u)/2 at each of the states (m,), (m, n), (m, n)."""
    if mass_changes(system):
        masses = np.array([system.evaluate(MASS, *state) for state in zip(t, q, u, strict=True)])
        return 0.5 * np.einsum("ki,kij,kj->k", u, masses, u)
    return 0.5 * np.einsum("ki,ij,kj->k", u, system.evaluate(MASS, t[0], q[0], u[0]), u)


def event_of(row: np.ndarray) -> Event:
    """A row of the events as an object."""
    integer = {k: int(row[k]) for k in WHOLE_COLUMNS}
    fields: dict[str, Any] = {
        "t": float(row[records.EVENT_T]),
        "kind": EventKind(integer[records.EVENT_KIND]),
        "contact": integer[records.EVENT_CONTACT],
        "mode_before": ContactMode(integer[records.EVENT_MODE_0]),
        "slip_before": integer[records.EVENT_SLIP_0],
        "mode_after": ContactMode(integer[records.EVENT_MODE_1]),
        "slip_after": integer[records.EVENT_SLIP_1],
        "P_N": float(row[records.EVENT_P_N]),
        "P_F": float(row[records.EVENT_P_F]),
        "gamma_N": float(row[records.EVENT_GAMMA_N]),
        "gamma_F": float(row[records.EVENT_GAMMA_F]),
    }
    if integer[records.EVENT_KIND] < records.INCONSISTENT:
        return Event(**fields)
    found = integer[records.EVENT_FOUND] if integer[records.EVENT_SOLUTIONS] > 0 else 0
    alternatives = tuple(name for k, name in enumerate(CANDIDATE_NAMES) if found >> k & 1)
    return ParadoxEvent(**fields, n_solutions=integer[records.EVENT_SOLUTIONS], alternatives=alternatives)
