"""The result of `simulate` for a scene: bodies as arrays, contacts of each record beside one another."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from nonsmooth.checks.arrays import as_number
from nonsmooth.errors import InvalidInput, Status, nearest, shown
from nonsmooth.mechanics.system import ContactMode
from nonsmooth.results.recorded import Recorded
from nonsmooth.results.scene_paradoxes import SceneParadox, no_rows, paradox_of
from nonsmooth.results.scene_records import (
    BODIES,
    CONTACTS,
    ENERGIES,
    EVENTS,
    JOINT_IMPULSES,
    KINDS,
    LEDGER,
    OF_BODIES,
    PAIRS,
    SCALAR,
    WORKS,
)
from nonsmooth.views import Worded, view

if TYPE_CHECKING:
    from pathlib import Path

    from nonsmooth.scenes.scene import Body, Scene


class SpringStats(NamedTuple):
    """What the steps of a run with compliant contacts were."""

    omega: float  # sqrt(k/m) of the lightest body [1/s]
    longest_allowed: float  # step, 1/omega [s]
    longest: float  # that was taken [s]
    shortest: float  # [s]
    rejected: int  # whose error was too large


@dataclass(frozen=True)
class SceneStats:
    """What a run of a scene cost, and its worst figures.

    Attributes
    ----------
    steps : int
    contacts, most_contacts : int
        That were candidates: of the last step, and of the step that had the most.
    islands : int
        Groups of bodies that touch, of the last step.
    methods : dict of str to int
        How many contact problems, of islands and steps, each method ended; "kept" for those that the impulses of the
        step before already solved.
    sweeps, factorisations : int
        Of block Gauss-Seidel, and of Newton's method.
    impacts : int
        Steps in which contacts rebounded.
    asleep : int
        Steps that were left out: the step before began and ended at rest and needed no solution, so all are alike.
    tol : float
        The residual asked for, relative to the impulses.
    worst_residual, last_residual : float
        Over all steps and of the last one: |natural map| / |impulses|, recomputed.
    missed : int
        Steps whose residual stayed above ``tol``.
    worst_penetration, last_penetration : float
        Deepest gap at the beginning of a step [m], over all steps and of the last one.
    wall_time, compile_time : float
        [s]
    energy_gains : int
        Steps in which the contacts gained energy as they rebounded, as Newton's law of impact lets them.
    worst_energy_gain : float
        The most that they gained in one [J].
    struck_together : int
        Steps in which a body was struck by several others, and Newton's law with e > 0 rebounded them at once.
    first_together : str
        When the first of them was, and the body.
    rebounds_limited : int
        Steps in which several contacts rebounded, and their impulses were scaled: Newton's law asked for more energy
        than the e^2 of what they had taken.
    springs : SpringStats, optional
        Of a run with compliant contacts.
    islands_asleep : int
        Islands that were left out of steps, counted step by step: nothing of them is looked for, written or solved.
    inconsistent : int
        Slides without a force, each of them an impact without collision (``paradoxes`` has them).
    indeterminate_steps : int
        Steps in which an island had several solutions.
    worst_joint_drift, last_joint_drift : float
        The farthest apart that the points of a joint were at the beginning of a step [m], over all steps and of the
        last one.
    """

    steps: int
    contacts: int
    most_contacts: int
    islands: int
    methods: dict[str, int]
    sweeps: int
    factorisations: int
    impacts: int
    asleep: int
    tol: float
    worst_residual: float
    last_residual: float
    missed: int
    worst_penetration: float
    last_penetration: float
    wall_time: float
    compile_time: float
    energy_gains: int = 0
    worst_energy_gain: float = 0.0
    struck_together: int = 0
    first_together: str = ""
    springs: SpringStats | None = None
    islands_asleep: int = 0
    rebounds_limited: int = 0
    worst_joint_drift: float = 0.0
    last_joint_drift: float = 0.0
    inconsistent: int = 0
    indeterminate_steps: int = 0


class BodyState(NamedTuple):
    """A body at one time, as a function of ``events=`` is given it."""

    position: np.ndarray  # (2|3,) of the centre of mass [m]
    turn: float | np.ndarray  # angle [rad], or (4,) unit quaternion (w, x, y, z)
    velocity: np.ndarray  # (2|3,) [m/s]
    spin: float | np.ndarray  # [rad/s], or (3,) in the axes of the world


class BodyMotion(NamedTuple):
    """The motion of one body."""

    t: np.ndarray  # (n_t,) [s]
    position: np.ndarray  # (n_t, 2|3) of the centre of mass [m]
    turn: np.ndarray  # (n_t,) angle [rad], or (n_t, 4) unit quaternion (w, x, y, z)
    velocity: np.ndarray  # (n_t, 2|3) [m/s]
    spin: np.ndarray  # (n_t,) or (n_t, 3), in the axes of the world [rad/s]

    def __repr__(self) -> str:
        return view(Worded, "repr")(self)

    def _repr_html_(self) -> str:
        return view(Worded, "html")(self)


class JointImpulses(NamedTuple):
    """The impulses that held two bodies together."""

    t: np.ndarray  # (n_t,) [s]
    P: np.ndarray  # (n_t, 2|3) of the last step before each record, on the second body, in the axes of the world [N s]

    def __repr__(self) -> str:
        return view(Worded, "repr")(self)

    def _repr_html_(self) -> str:
        return view(Worded, "html")(self)


@dataclass(frozen=True, eq=False)
class SceneContacts:
    """The contacts of one record; ``i`` pushes ``j`` along ``normal``.

    Attributes
    ----------
    t : float
        [s]
    i, j : (m,) indices of bodies
    point, normal : (m, 2|3)
        Midway between the surfaces [m], and out of body i.
    gap : (m,) before the last step [m]
    P : (m, 2|3)
        Impulses of the last step in the axes of the world, on body j [N s]; of a run with compliant contacts the forces
        [N].
    P_N, P_F : (m,)
        Their normal part, and the size of their tangential part.
    mode : (m,) ContactMode
    names : (n_b,) of all bodies
    """

    t: float
    i: np.ndarray
    j: np.ndarray
    point: np.ndarray
    normal: np.ndarray
    gap: np.ndarray
    P: np.ndarray
    mu: np.ndarray
    names: list[str]

    def __len__(self) -> int:
        return len(self.i)

    @property
    def P_N(self) -> np.ndarray:
        """Normal impulses [N s]."""
        return normal_and_friction(self.P, self.normal)[0]

    @property
    def P_F(self) -> np.ndarray:
        """Sizes of the tangential impulses [N s]."""
        return normal_and_friction(self.P, self.normal)[1]

    @property
    def mode(self) -> np.ndarray:
        """OPEN without an impulse; STICK within the friction cone, SLIDE on it, to 1e-8 of it."""
        return modes_of(*normal_and_friction(self.P, self.normal), self.mu)

    def of(self, name: str) -> SceneContacts:
        """Those of one body."""
        k = index_of(name, self.names)
        rows = np.flatnonzero((self.i == k) | (self.j == k))
        return SceneContacts(
            self.t, self.i[rows], self.j[rows], self.point[rows], self.normal[rows], self.gap[rows], self.P[rows],
            self.mu[rows], self.names,
        )  # fmt: skip

    def __repr__(self) -> str:
        loaded = int((self.P_N > 0).sum())
        return f"SceneContacts({len(self)} at t = {self.t:.6g} s, {loaded} of them loaded)"


def normal_and_friction(P: np.ndarray, normal: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Normal parts (m,) of impulses, and the sizes of their tangential parts."""
    P_N = (P * normal).sum(axis=1)
    return P_N, np.linalg.norm(P - P_N[:, None] * normal, axis=1)


def modes_of(P_N: np.ndarray, P_F: np.ndarray, mu: np.ndarray) -> np.ndarray:
    """What contacts with such impulses do."""
    sliding = np.where(P_F >= mu * P_N * (1 - 1e-8), ContactMode.SLIDE, ContactMode.STICK)
    return np.where(P_N > 0, sliding, ContactMode.OPEN)


Columns = Any  # arrays by name: a dictionary, or a structured array


def columns_of(
    records: Columns, contacts: Columns, kinds: tuple[str, ...], works: tuple[str, ...] = WORKS
) -> dict[str, Any]:
    """The arrays of a `SceneSolution` from columns, or rows, of records and contacts; None for what was not kept."""
    columns: dict[str, Any] = {name: records[name] for name in SCALAR}
    columns |= {name: records[name] if BODIES in kinds else None for name in OF_BODIES}
    columns["ledger"] = {name: records[name] for name in (*ENERGIES, *works)} if LEDGER in kinds else None
    columns["all_contacts"] = columns["events"] = columns[PAIRS] = columns[JOINT_IMPULSES] = None
    if CONTACTS in kinds:
        offsets = np.concatenate(([0], np.cumsum(records["n_contacts"], dtype=np.int64)))
        of_contacts = (contacts[name][: offsets[-1]] for name in ContactColumns._fields[1:])
        columns["all_contacts"] = ContactColumns(offsets, *of_contacts)
        known = records.dtype.names if isinstance(records, np.ndarray) else records
        no_joints = np.zeros((len(records["t"]), 0, contacts["point"].shape[1]))
        columns[JOINT_IMPULSES] = records[JOINT_IMPULSES] if JOINT_IMPULSES in known else no_joints
    return columns


class ContactColumns(NamedTuple):
    """The contacts of all records, one behind the other; those of record k are offsets[k] to offsets[k + 1] - 1."""

    offsets: np.ndarray
    i: np.ndarray
    j: np.ndarray
    point: np.ndarray
    normal: np.ndarray
    gap: np.ndarray
    P: np.ndarray
    mu: np.ndarray

    def __repr__(self) -> str:
        return view(Worded, "repr")(self)

    def _repr_html_(self) -> str:
        return view(Worded, "html")(self)


@dataclass(frozen=True, eq=False)
class SceneSolution:
    """The result of `simulate` for a `Scene`.

    Attributes
    ----------
    t : (n_t,) times of the records [s]
    position : (n_t, n_b, 2|3) centres of mass [m]
    turn : (n_t, n_b) angles [rad], or (n_t, n_b, 4) unit quaternions (w, x, y, z)
    velocity : (n_t, n_b, 2|3) [m/s]
    spin : (n_t, n_b) or (n_t, n_b, 3) angular velocities, in the axes of the world [rad/s]
    all_contacts : ContactColumns
        ``contacts(t)`` gives those of one record.
    ledger : dict of (n_t,) arrays [J]
        "kinetic", "potential", and the works since the start by "force" (gravity), "friction", "normal", "surface"
        (what guided bodies and belts put in) and "projection" (of gravity, on what bodies are moved beside their
        velocities). With compliant contacts also the energy in the springs, "elastic", and the work of the dampers,
        "damping", which is a part of that by "normal" and "friction".
    events : SceneEvents
        Landings, partings, slips and sticks of pairs of bodies, where ``record=`` asked for them.
    pairs : ScenePairs
        What each pair of bodies exchanged since the record before, impulses and works, where ``record=`` asked for
        them.
    joint_impulses : (n_t, n_j, 2|3)
        Of the last step before each record, on the second body of each joint, in the axes of the world [N s]; kept with
        the contacts. ``joint(name)`` gives those of one.
    t_events : list of (k,)
        Times of the events of each function of the user [s].
    residual, penetration : (n_t,)
        The worst of the steps since the record before: |natural map| / |impulses|, and the deepest gap [m].
    stats : SceneStats
    status : Status, message : str, success : bool
    names : list of str
        The bodies, in the order of the arrays.
    scene : Scene or None
        None for a run that was loaded without it.
    centres : (n_b, 2|3)
        Of mass, in the frames of the shapes [m].
    joint_names : list of str
        The joints, in the order of ``joint_impulses``.
    paradox_rows : (m, 15)
        ``paradoxes`` as numbers.
    """

    t: np.ndarray
    residual: np.ndarray
    penetration: np.ndarray
    stats: SceneStats
    status: Status
    message: str
    names: list[str]
    scene: Scene | None
    centres: np.ndarray
    position: Recorded = Recorded(BODIES)
    turn: Recorded = Recorded(BODIES)
    velocity: Recorded = Recorded(BODIES)
    spin: Recorded = Recorded(BODIES)
    all_contacts: Recorded = Recorded(CONTACTS)
    ledger: Recorded = Recorded(LEDGER)
    events: Recorded = Recorded(EVENTS)
    pairs: Recorded = Recorded(PAIRS)
    joint_impulses: Recorded = Recorded(CONTACTS)
    t_events: list[np.ndarray] = field(default_factory=list)
    about: dict[str, Any] = field(default_factory=dict)
    joint_names: list[str] = field(default_factory=list)
    paradox_rows: np.ndarray = field(default_factory=no_rows)

    @property
    def paradoxes(self) -> list[SceneParadox]:
        """Where islands of few contacts had no solution, or several: the first 200 of a run."""
        return [paradox_of(row, self.names, self.dim) for row in self.paradox_rows]

    @property
    def success(self) -> bool:
        """Whether the end was reached, or a terminal event."""
        return self.status in (Status.FINISHED, Status.EVENT_REACHED)

    @property
    def dim(self) -> int:
        """2 in the plane, 3 in space."""
        return self.centres.shape[1]

    @property
    def recorded(self) -> tuple[str, ...]:
        """What was recorded: "bodies", "contacts", "ledger", "events", "pairs"."""
        columns = {BODIES: "position", CONTACTS: "all_contacts", LEDGER: "ledger", EVENTS: "events", PAIRS: "pairs"}
        return tuple(kind for kind in KINDS if vars(self)[columns[kind]] is not None)

    @property
    def bodies(self) -> list[Body]:
        """The bodies that the scene had in the run, with their shapes; it may have grown since.

        Raises
        ------
        InvalidInput
            Where a run was loaded without its scene.
        """
        if self.scene is None:
            raise InvalidInput("a run that was loaded has no shapes; give its scene: SceneSolution.load(path, scene)")
        return self.scene.bodies[: len(self.names)]

    @property
    def q(self) -> np.ndarray:
        """(n_t, n_q): places and turns of all bodies, one body after the other."""
        return _side_by_side(self.position, self.turn)

    @property
    def u(self) -> np.ndarray:
        """(n_t, n_u): velocities and angular velocities of all bodies, one body after the other."""
        return _side_by_side(self.velocity, self.spin)

    def __getitem__(self, name: str) -> BodyMotion:
        """The motion of a body, by name."""
        k = index_of(name, self.names)
        return BodyMotion(self.t, self.position[:, k], self.turn[:, k], self.velocity[:, k], self.spin[:, k])

    def __iter__(self) -> Iterator[str]:
        return iter(self.names)

    def contacts(self, t: float | None = None) -> SceneContacts:
        """The contacts of the record nearest to a time [s]; of the last record, if left out.

        Raises
        ------
        InvalidInput
            For a time outside the run.
        """
        k = len(self.t) - 1
        if t is not None:
            t = as_number("t", t, "s")
            if not self.t[0] <= t <= self.t[-1]:
                raise InvalidInput(f"t must lie in [{self.t[0]:g}, {self.t[-1]:g}] s, the times of the run; got {t:g}")
            k = int(np.argmin(np.abs(self.t - t)))
        every = self.all_contacts
        rows = slice(every.offsets[k], every.offsets[k + 1])
        return SceneContacts(
            float(self.t[k]), every.i[rows], every.j[rows], every.point[rows], every.normal[rows], every.gap[rows],
            every.P[rows], every.mu[rows], self.names,
        )  # fmt: skip

    def joint(self, name: str) -> JointImpulses:
        """The impulses of a joint, by name.

        Raises
        ------
        InvalidInput
            For a joint that is not there, and where contacts were not recorded.
        """
        if name not in self.joint_names:
            raise InvalidInput(f"there is no joint {shown(name)}; {nearest(name, self.joint_names)}")
        return JointImpulses(self.t, self.joint_impulses[:, self.joint_names.index(name)])

    def summary(self) -> str:
        """The run in a few lines: bodies, contacts, residual, penetration, energy, cost."""
        return view(self, "summary")(self)

    def picture(
        self, path: str | Path | None = None, n: int = 1, times: Any = None, width: float | None = None
    ) -> Any:  # fmt: skip
        """Draw the scene at n instants, the last one if n is 1, or at ``times`` [s], ``width`` [mm] wide (needs the
        extra [plot]); returns the figure."""
        return view(self, "picture")(self, path, n, times, width)

    def animate(self, path: str | Path | None = None, fps: int = 25) -> Any:
        """Write a .gif, .webp or .mp4 (needs the extra [plot], an .mp4 ffmpeg); without a path a notebook shows what
        comes back."""
        return view(self, "animate")(self, path, fps)

    def plot(self, path: str | Path | None = None) -> Any:
        """Draw energies, residual and contacts over the time (needs the extra [plot]); returns the figure."""
        return view(self, "plot")(self, path)

    def view(self, path: str | Path | None = None) -> Any:
        """The player of the scene: one .html file that any browser opens offline, or inline in a notebook.

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
            When this was loaded without its scene, or the path cannot be written.
        """
        return view(self, "view")(self, path)

    def to_xarray(self) -> Any:
        """An ``xarray.Dataset`` of what was recorded, with names and units (needs the extra [data]).

        Dimensions are t, body (by name), axis and, of quaternions, component; contacts stand one behind the other along
        ``contact``, those of record k from contact_offset[k] to contact_offset[k + 1] - 1.

        Returns
        -------
        xarray.Dataset

        Raises
        ------
        MissingExtra
            Where xarray is not installed.

        Examples
        --------
        >>> import nonsmooth as ns
        >>> scene = ns.Scene(gravity=(0, -9.81))
        >>> ball = scene.body(ns.Disc(0.1), mass=1.0, position=(0, 1), name="ball")
        >>> fall = ns.simulate(scene, (0, 0.1), integrator=ns.MoreauJean(dt=1e-2))
        >>> round(float(fall.to_xarray().position.sel(body="ball", axis="y")[-1]), 6)
        0.95095
        """
        return view(self, "dataset")(self)

    def to_dataframe(self, what: str = "bodies") -> Any:
        """A ``pandas.DataFrame`` (needs the extra [data]).

        Parameters
        ----------
        what : {"bodies", "contacts", "records", "events", "pairs"}
            A row a body of each record, a contact of each record with the names of its bodies, a record, an event of a
            pair of bodies, or what a pair exchanged since the record before.

        Returns
        -------
        pandas.DataFrame

        Raises
        ------
        InvalidInput, MissingExtra
            For another table, one that was not recorded, and where pandas is not installed.
        """
        return view(self, "table")(self, what)

    def save(self, path: str | Path) -> Path:
        """Write to .npz, or to .h5 (needs the extra [io]), no shapes; or .nc, netCDF for other programs ([data])."""
        return view(self, "save")(self, path)

    @staticmethod
    def load(path: str | Path, scene: Scene | None = None) -> SceneSolution:
        """Read what `save` wrote; with the scene, which is not stored, its pictures can be drawn again."""
        return view(SceneSolution, "load")(path, scene)

    def _repr_html_(self) -> str:
        return view(self, "html")(self)

    def __repr__(self) -> str:
        return (
            f"SceneSolution({self.status.name}, t = {self.t[-1]:.6g} s, {len(self.names)} bodies, "
            f"{self.stats.steps} steps, worst residual {self.stats.worst_residual:.1e})"
        )


def index_of(name: Any, names: list[str]) -> int:
    """The place of a body among all, or `InvalidInput` with the name that is nearest."""
    if name not in names:
        raise InvalidInput(f"there is no body {shown(name)}; {nearest(name, names)}")
    return names.index(name)


def _side_by_side(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    n_t, n_b = first.shape[:2]
    both = np.concatenate((first, second.reshape(n_t, n_b, -1)), axis=2)
    return both.reshape(n_t, -1)
