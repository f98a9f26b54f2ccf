"""The result of `simulate` for a scene: bodies as arrays, the contacts of all records in one table.

Kept in other files: its columns (table.py), a body or a joint by name (scene_bodies.py), the contacts of a record
(scene_contacts.py), events and paradoxes (events.py), pairs (scene_pairs.py), what the run cost (stats.py).
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from nonsmooth.checks.arrays import as_floats, as_number
from nonsmooth.errors import InvalidInput, Status, shown
from nonsmooth.results.events import SceneEvents, SceneParadox, paradox_of
from nonsmooth.results.recorded import CONTACTS, EVENTS, KINDS_OF_SCENE, LEDGER, PAIRS, index_of, not_recorded
from nonsmooth.results.scene_bodies import BodyMotion, JointMotion, SceneState, SpringForces
from nonsmooth.results.scene_contacts import ContactColumns, SceneContacts
from nonsmooth.results.scene_motion import SceneMotion, struck_bodies
from nonsmooth.results.scene_pairs import ScenePairs
from nonsmooth.results.stats import SceneStats
from nonsmooth.results.table import SCENE, RecordsOfScene, kinds_in, numbered, under
from nonsmooth.scenes.elements import Kind
from nonsmooth.views import view

if TYPE_CHECKING:
    from pathlib import Path

    from nonsmooth.scenes.elements import Body, Joint
    from nonsmooth.scenes.scene import Scene


@dataclass(frozen=True, eq=False)
class SceneSolution(RecordsOfScene):
    """The result of `simulate` for a `Scene`.

    Attributes
    ----------
    columns : dict of str to array
        All arrays by name, as files have them (docs/files.md); those of the records are attributes.
    t : (n_t,) times of the records [s]
    position : (n_t, n_b, 2|3) centres of mass [m]
    turn : (n_t, n_b) angles [rad], or (n_t, n_b, 4) unit quaternions (w, x, y, z)
    velocity : (n_t, n_b, 2|3) [m/s]
    spin : (n_t, n_b) or (n_t, n_b, 3) angular velocities, in the axes of the world [rad/s]
    all_contacts : ContactColumns
        ``contacts(t)`` gives those of one record.
    ledger : dict of (n_t,) arrays [J]
        "kinetic", "potential", and the works since the start by "force" (gravity), "friction", "normal", "surface"
        (what guided bodies and belts put in) and "projection" (of gravity, as the positions of bodies are corrected);
        of "normal", "step" is what rigid contacts and joints took or gave that were pressed in the step before too: an
        error of the steps, and no law. With compliant contacts also the energy in the springs, "elastic", and the work
        of the dampers, "damping", which is a part of that by "normal" and "friction".
    events : SceneEvents
        Landings, partings, slips and sticks of pairs of bodies, where ``record=`` asked for them.
    pairs : ScenePairs
        What each pair of bodies exchanged since the record before, impulses and works, where ``record=`` asked for
        them.
    joint_impulses : (n_t, n_j, 2|3)
        Of the last step before each record, on the second body of each joint, in the axes of the world [N s]; kept with
        the contacts. ``joint(name)`` gives those of one.
    joint_torques : (n_t, n_j) or (n_t, n_j, 3)
        Angular impulses, about the points of the joints [N m s]; limits and motors with a speed are in both.
    t_events : list of (k,)
        Times of the events of each function of the user [s].
    residual, penetration : (n_t,)
        The worst of the steps since the record before: the residual (`SceneStats`), and the deepest gap [m].
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
    find_motion : callable, optional
        Of a run of its system: position, turn, velocity and spin at times; else they are found from the records.
    """

    columns: dict[str, np.ndarray]
    stats: SceneStats
    status: Status
    message: str
    names: list[str]
    scene: Scene | None
    about: dict[str, Any] = field(default_factory=dict)
    joint_names: list[str] = field(default_factory=list)
    find_motion: Callable[[np.ndarray], tuple[np.ndarray, ...]] | None = None
    kinds: ClassVar = {column.name: column.kind for column in SCENE[3]}

    @functools.cached_property
    def all_contacts(self) -> ContactColumns:
        """The contacts of all records."""
        return ContactColumns(self._recorded(CONTACTS, "all_contacts"))

    @functools.cached_property
    def ledger(self) -> dict[str, np.ndarray]:
        """Energies and works since the start, by name."""
        return self._recorded(LEDGER, LEDGER)

    @functools.cached_property
    def events(self) -> SceneEvents:
        """What happened to pairs of bodies."""
        return SceneEvents(self._recorded(EVENTS, EVENTS), self.names)

    @functools.cached_property
    def pairs(self) -> ScenePairs:
        """What pairs of bodies exchanged."""
        return ScenePairs(self._recorded(PAIRS, PAIRS), self.names, self.joint_names)

    @property
    def t_events(self) -> list[np.ndarray]:
        """Times of the events of each function of the user [s]."""
        return numbered(self.columns, "t_events")

    def _recorded(self, kind: str, name: str) -> dict[str, np.ndarray]:
        found = under(self.columns, kind)
        if not found:
            raise not_recorded(name, kind)
        return found

    def __getstate__(self) -> dict[str, Any]:
        """All that is known: another process, or a copy, need not have what the motion is found with."""
        return {
            name: None if name == "find_motion" else value for name, value in vars(self).items() if name != "motion"
        }

    def __call__(self, t: ArrayLike) -> SceneState:
        """The bodies between the records, ``sol(t)["box"].position``.

        Of a run by steps they move on a cubic between two records, of the order of the step, and what is struck in a
        step on a straight line; of `EventDriven` and `Adaptive` as `Solution` has it.

        Parameters
        ----------
        t : float or array_like (m,)
            Within the times of the run [s].

        Returns
        -------
        SceneState
            Position, turn, velocity and spin of all bodies, with m rows at m times; those of a body by its name.

        Raises
        ------
        InvalidInput
            For a time outside the run, and where not every step was recorded.

        Examples
        --------
        >>> import nonsmooth as ns
        >>> scene = ns.Scene(gravity=(0, -10.0))
        >>> ball = scene.body(ns.Disc(0.1), mass=1.0, position=(0, 1), name="ball")
        >>> fall = ns.simulate(scene, (0, 0.5), integrator=ns.MoreauJean(dt=0.1))
        >>> fall(0.25)["ball"].position.round(12).tolist()
        [0.0, 0.6875]
        """
        times = as_floats("t", t)
        if times.ndim > 1 or not ((times >= self.t[0]) & (times <= self.t[-1])).all():
            raise InvalidInput(f"t must lie in [{self.t[0]:g}, {self.t[-1]:g}] s, the times of the run; got {shown(t)}")
        found = self.motion(times.reshape(-1))
        return SceneState(t, self.names, self.scene, *(part if times.ndim else part[0] for part in found))

    @functools.cached_property
    def motion(self) -> Callable[[np.ndarray], tuple[np.ndarray, ...]]:
        """The motion between the records as a function of times (m,); found when first asked for."""
        if self.find_motion is not None:
            return self.find_motion
        if self.scene is None:
            raise InvalidInput("a loaded run does not know what its bodies are; give its scene to load")
        if len(self.t) != self.stats.steps + 1 or len(self.t) < 2:
            raise InvalidInput(
                "this solution knows its records only: not every step was recorded; run without every= and t_eval= to "
                "ask for other times"
            )
        columns = self.position, self.turn, self.velocity, self.spin
        return SceneMotion(
            self.t,
            *columns,
            np.zeros((len(self.t) - 1, len(self.names)), bool) if self.stats.springs else self._struck(),
        )

    def _struck(self) -> np.ndarray:
        """(m, n_b) which bodies an impact reaches in each step."""
        every, kinds = self.all_contacts, [body.kind for body in self.bodies]
        moves = np.array([kind is Kind.DYNAMIC for kind in kinds])
        joined = np.array([(joint.a.index, joint.b.index) for joint in self.joints], np.int64).reshape(-1, 2)
        is_loaded = (every.P * every.normal).sum(axis=1) > 0.0
        pairs = np.stack((every.i, every.j), axis=1)
        of_records = [
            pairs[first:last][is_loaded[first:last]]
            for first, last in zip(every.offsets[:-1], every.offsets[1:], strict=True)
        ]
        steps = zip(of_records[:-1], of_records[1:], strict=True)
        return np.array([struck_bodies(before, after, joined, moves) for before, after in steps])

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
        there = kinds_in(SCENE[self.dim], self.columns)
        return tuple(kind for kind in KINDS_OF_SCENE.all if kind in there)

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
    def joints(self) -> list[Joint]:
        """The joints that the scene had in the run; none where it was loaded without its scene."""
        return [] if self.scene is None else self.scene.joints[: len(self.joint_names)]

    @property
    def q(self) -> np.ndarray:
        """(n_t, n_q): places and turns of all bodies, one body after the other."""
        return _side_by_side(self.position, self.turn)

    @property
    def u(self) -> np.ndarray:
        """(n_t, n_u): velocities and angular velocities of all bodies, one body after the other."""
        return _side_by_side(self.velocity, self.spin)

    def __getitem__(self, body: str | Body) -> BodyMotion:
        """The motion of a body, by its name, or by itself where it is one of the scene that has run."""
        if isinstance(body, str) and body not in self.names and body in self.joint_names:
            raise InvalidInput(f"{body} is a joint; sol.joint({body!r}) has what it did, sol[...] is of bodies")
        is_named = isinstance(body, str) or self.scene is None
        own = [] if is_named else [each.name for each in self.bodies if each is body]
        k = index_of(own[0] if own else body, self.names)
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
        return every.at(slice(every.offsets[k], every.offsets[k + 1]), float(self.t[k]), self.names)

    def joint(self, name: str) -> JointMotion:
        """What a joint did, by name: impulses, and the angle and the travel along its axis, with their rates.

        Raises
        ------
        InvalidInput
            For a joint that is not there, and where contacts were not recorded.
        """
        return view(self, "joint")(self, name)

    def spring(self, name: str) -> SpringForces:
        """Length and force of a spring at the records, by name.

        Raises
        ------
        InvalidInput
            For a spring that is not there, and of a run that was loaded without its scene.
        """
        return view(self, "spring")(self, name)

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

    def plot(self, path: str | Path | None = None, panels: Sequence[str] | None = None) -> Any:
        """Draw energies, residual and contacts over the time, or some of these ``panels``, as ``["energy"]`` (needs the
        extra [plot]); returns the figure."""
        return view(self, "plot")(self, path, panels)

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


def _side_by_side(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    n_t, n_b = first.shape[:2]
    both = np.concatenate((first, second.reshape(n_t, n_b, -1)), axis=2)
    return both.reshape(n_t, -1)
