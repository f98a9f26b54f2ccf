"""Events of the user in a scene: where a function f(t, bodies) reaches zero, as in SciPy's ``solve_ivp``.

f is looked at at the start and after each step. Where it reaches zero, or passes through it, its root is found on the
motion within the step (results/scene_motion.py) as that of a system is (user_events.py). A function that passes through
zero and back within a step is not seen. A run that ends at an event ends with that step.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from nonsmooth.errors import Status
from nonsmooth.results.scene_bodies import SceneState
from nonsmooth.results.scene_motion import SceneMotion, struck_bodies
from nonsmooth.runs.recorder import SceneRun
from nonsmooth.runs.user_events import OF_SCENE, EventFailed, Stop, UserEvent, root

Record = tuple[np.ndarray, ...]  # position, turn, velocity and spin of all bodies


class SceneWatch:
    """The functions of the user, followed from step to step.

    Parameters
    ----------
    run : SceneRun
    functions : sequence of callables
    """

    def __init__(self, run: SceneRun, functions: Sequence[Callable]) -> None:
        self.events = [UserEvent(function, k, OF_SCENE) for k, function in enumerate(functions)]
        self.scene, self.names = run.scene, run.names
        self.moves = run.world.bodies.motion.moves == 1
        self.joined = np.array([(joint.a.index, joint.b.index) for joint in run.scene.joints], np.int64).reshape(-1, 2)
        self.before, self.loaded = record_of(run), np.zeros((0, 2), np.int64)

    def steps_at_once(self, run: SceneRun, most: int) -> int:
        """How many steps may be taken until the next look."""
        return 1

    def look(self, run: SceneRun, t: float, t_end: float) -> None:
        """Look at the functions at the end of the step from t to t_end."""
        now, loaded = record_of(run), loaded_pairs(run)
        is_smooth = t == t_end or run.world.surfaces.is_compliant == 1 or not run.has_islands
        struck = np.zeros_like(self.moves) if is_smooth else self._struck(loaded)
        position, turn, velocity, spin = (np.stack(pair) for pair in zip(self.before, now, strict=True))
        motion = SceneMotion(np.array([t, t_end]), position, turn, velocity, spin, struck[None])
        stops = [stop for event in self.events if (stop := self._follow(event, motion, t_end, now)) is not None]
        self.before, self.loaded = now, loaded
        if not stops:
            return
        first = min(stops, key=lambda stop: stop.t)
        for event in self.events:
            event.found = [found for found in event.found if found[0] <= first.t]
        run.end_at(first)

    def _struck(self, loaded: np.ndarray) -> np.ndarray:
        return struck_bodies(self.loaded, loaded, self.joined, self.moves)

    def _follow(self, event: UserEvent, motion: SceneMotion, t: float, now: Record) -> Stop | None:
        """The next value of a function; a reason to stop, if it is one."""

        def state_at(moment: float) -> tuple[SceneState]:
            return (self._state(moment, tuple(part[0] for part in motion(np.array([moment])))),)

        try:
            (t_before, before), event.seen = event.seen, (t, event(t, self._state(t, now)))
            after = event.seen[1]
            if not event.is_reached(before, after):
                return None
            t_found = root(event, state_at, t_before, t, before, after)
        except EventFailed as failed:
            message = f"the event function {event.name} {failed.args[0]}, at t = {failed.args[1]:.9g} s"
            return Stop(t, Status.EVENT_FAILED, message, cause=failed.__cause__)
        event.found.append((t_found,))
        if len(event.found) != event.limit:
            return None
        message = f"{event.name} was reached at t = {t_found:.9g} s; stopped at the end of this step, t = {t:.9g} s"
        return Stop(t_found, Status.EVENT_REACHED, message)

    def _state(self, t: float, record: Record) -> SceneState:
        return SceneState(t, self.names, self.scene, *record)

    @property
    def t_events(self) -> list[np.ndarray]:
        """Times (k,) of each function's events [s]."""
        return [np.array([found[0] for found in event.found]) for event in self.events]


def record_of(run: SceneRun) -> Record:
    """The bodies of a run at its present time."""
    motion = run.world.bodies.motion
    return run.world.record(motion.x.copy(), motion.v.copy())


def loaded_pairs(run: SceneRun) -> np.ndarray:
    """(n, 2) the bodies of contacts that carried something in the last step."""
    rows = run.assembly.contact_rows()
    is_loaded = rows.own[:, 0] > 0.0
    return np.stack((rows.i[is_loaded], rows.j[is_loaded]), axis=1)
