"""Events of the user in a scene: where a function f(t, bodies) reaches zero, as in SciPy's ``solve_ivp``.

f is looked at at the start and after each step. Where it reaches zero, or passes through it, the time is that of the
straight line between its two values: exact to O(dt^2) for a smooth motion, and to the step across an impact. A function
that passes through zero and back within a step is not seen. A run that ends at an event ends with that step.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence

import numpy as np

from nonsmooth.errors import Status
from nonsmooth.integrators.assembly.world import World
from nonsmooth.results.recorded import index_of
from nonsmooth.results.scene_bodies import BodyState
from nonsmooth.runs.recorder import SceneRun
from nonsmooth.runs.user_events import OF_SCENE, EventFailed, Stop, UserEvent
from nonsmooth.scenes.places import conjugate, times


class BodiesNow(Mapping[str, BodyState]):
    """The bodies of a run at its present time, by name."""

    def __init__(self, world: World, names: list[str]) -> None:
        self.world, self.names = world, names

    def __getitem__(self, name: str) -> BodyState:
        b, d, motion = index_of(name, self.names), self.world.dim, self.world.bodies.motion
        x, v = motion.x[b].copy(), motion.v[b].copy()
        if d == 2:
            return BodyState(x[:2], float(x[2]), v[:2], float(v[2]))
        return BodyState(x[:3], times(x[3:], conjugate(self.world.frames[b, 3:])), v[:3], v[3:])

    def __contains__(self, name: object) -> bool:
        return name in self.names

    def __iter__(self) -> Iterator[str]:
        return iter(self.names)

    def __len__(self) -> int:
        return len(self.names)


class SceneWatch:
    """The functions of the user, followed from step to step.

    Parameters
    ----------
    run : SceneRun
    functions : sequence of callables
    """

    def __init__(self, run: SceneRun, functions: Sequence[Callable]) -> None:
        self.events = [UserEvent(function, k, OF_SCENE) for k, function in enumerate(functions)]
        self.bodies = BodiesNow(run.world, run.names)

    def steps_at_once(self, run: SceneRun, most: int) -> int:
        """How many steps may be taken until the next look."""
        return 1

    def look(self, run: SceneRun, t: float, t_end: float) -> None:
        """Look at the functions at the end of the step from t to t_end."""
        stops = [stop for event in self.events if (stop := self._follow(event, t_end)) is not None]
        if not stops:
            return
        first = min(stops, key=lambda stop: stop.t)
        for event in self.events:
            event.found = [found for found in event.found if found[0] <= first.t]
        run.end_at(first)

    def _follow(self, event: UserEvent, t: float) -> Stop | None:
        """The next value of a function; a reason to stop, if it is one."""
        try:
            (t_before, before), event.seen = event.seen, (t, event(t, self.bodies))
        except EventFailed as failed:
            message = f"the event function {event.name} {failed.args[0]}, at t = {t:.9g} s"
            return Stop(t, Status.EVENT_FAILED, message, cause=failed.__cause__)
        after = event.seen[1]
        if not event.is_reached(before, after):
            return None
        t_found = t_before + (t - t_before) * (before / (before - after))
        event.found.append((t_found,))
        if len(event.found) != event.limit:
            return None
        message = f"{event.name} was reached at t = {t_found:.9g} s; stopped at the end of this step, t = {t:.9g} s"
        return Stop(t_found, Status.EVENT_REACHED, message)

    @property
    def t_events(self) -> list[np.ndarray]:
        """Times (k,) of each function's events [s]."""
        return [np.array([found[0] for found in event.found]) for event in self.events]
