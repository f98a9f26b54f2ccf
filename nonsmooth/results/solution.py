"""What a run gives back: the columns of its records, and what is found from them once it is asked for.

Kept in other files: events as objects (events.py), the energy ledger (ledger.py), what the run cost and its worst
figures (stats.py), the motion between the records (motion.py); who draws, saves and words a solution
(nonsmooth/views.py).
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from nonsmooth.checks.arrays import as_name
from nonsmooth.errors import InvalidInput, Status
from nonsmooth.integrators import records
from nonsmooth.integrators.fixed_step import FixedStep
from nonsmooth.mechanics.description import Description, numbered, title_of
from nonsmooth.mechanics.system import System
from nonsmooth.results.events import Event, ParadoxEvent, event_of
from nonsmooth.results.ledger import finder_of_ledger, ledger_behind_start
from nonsmooth.results.motion import Motion, Side, StateAt
from nonsmooth.results.recorded import (
    EVENTS,
    KINDS,
    KINDS_BETWEEN,
    LEDGER,
    not_recorded,
)
from nonsmooth.results.sliding import sliding_velocities
from nonsmooth.results.stats import Stats
from nonsmooth.results.table import ALWAYS, SYSTEM, columns_along
from nonsmooth.views import view

PER_RECORD = {column.name: column.kind for column in columns_along(SYSTEM, "n_t", KINDS)}
# the kind of each field that is there if its kind was recorded
KIND_OF = PER_RECORD | {"find_ledger": LEDGER, "event_rows": EVENTS}


def per_record(record: records.Columns, recorded: tuple[str, ...], has_forces: bool) -> dict[str, Any]:
    """Those columns of the rows that a run wrote; None for what was not recorded."""
    columns = record._asdict() | {"P_N": record.P[:, :, 0], "P_F": record.P[:, :, 1:]}
    columns |= {} if has_forces else {"la": None}
    return {name: columns[name] if kind in (ALWAYS, *recorded) else None for name, kind in PER_RECORD.items()}


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
    mode : (n_t, n_c) ContactMode, and slip : (n_t, n_c) sign of sliding, of the last step; 0 where friction has two
        directions: ``gamma_F`` tells them
    event_rows : (n_events, 13)
        The events as numbers; ``events`` and ``paradoxes`` give them as objects.
    ledger : dict of (n_t,) arrays [J]
        "kinetic", and the work since the start by "force", "friction", "normal", "surface", "projection";
        "potential" where the system has one. Where M depends on q or t: "mass", the rest of the kinetic energy, which
        is the work (u, dM/dt u)/2 of the changing mass (the gyroscopic part of h takes as much) and the errors of all.
    la : (n_t, n_c, 1 + d) normal and friction forces [N], or None where the integrator works with impulses
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
        changes = {name: own[name][1:] for name in PER_RECORD if own[name] is not None}
        if own["find_ledger"] is not None:
            changes["find_ledger"] = functools.partial(ledger_behind_start, own["find_ledger"], len(self.t))
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

    @functools.cached_property
    def gamma_F(self) -> np.ndarray:
        """Sliding velocities (n_t, n_c, d) at the records [m/s], also of open contacts; found when first asked for."""
        return sliding_velocities(self.system, self.t, self.q, self.u)

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

    def plot(self, path: str | Path | None = None, panels: Sequence[str] | None = None) -> Any:
        """Draw the run, or some of its ``panels`` such as ``["energy", "modes"]`` (needs the extra [plot]); returns the
        Matplotlib figure, saved to ``path`` if given."""
        return view(self, "plot")(self, path, panels)

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
        if value is None and self.kind and self.kind not in solution.recorded:
            raise not_recorded(self.name.removeprefix("find_"), self.kind)
        return value

    def __set__(self, solution: Solution, value: Any) -> None:
        vars(solution)[self.name] = value


FOUND_LATER = (*PER_RECORD, "find_ledger", "find_motion", "stats", "about", "theta")
for _name in (*FOUND_LATER, "event_rows"):
    setattr(Solution, _name, FoundLater(_name))


def rest_of_run(
    system: System, integrator: Any, record: records.Columns, stats: Stats, find_motion: Callable[[], Motion] | None,
    recorded: tuple[str, ...],
) -> dict[str, Any]:  # fmt: skip
    """The fields of a solution that are found later, from the rows of the loop."""
    return per_record(record, recorded, integrator.has_forces) | {
        "find_ledger": finder_of_ledger(system, record, recorded), "find_motion": find_motion, "stats": stats,
        "about": about_run(system, integrator),
        "theta": theta_of(integrator) if find_motion is not None else None,
    }  # fmt: skip


def theta_of(integrator: Any) -> float | None:
    """Where a time stepping takes its forces; None of a method that keeps its steps."""
    return float(integrator.theta) if isinstance(integrator, FixedStep) else None


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
