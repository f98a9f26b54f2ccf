"""A scene in the hands of the caller: so many steps at a time, and between them whatever a controller does."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from nonsmooth.checks.arrays import as_count, as_instance, as_number
from nonsmooth.errors import InvalidInput, Status, shown
from nonsmooth.integrators.moreau_jean.options import MoreauJean
from nonsmooth.jit import running_time
from nonsmooth.results.recorded import KINDS_OF_SCENE
from nonsmooth.results.scene_bodies import SceneState
from nonsmooth.results.scene_solution import SceneSolution
from nonsmooth.runs.recorder import SceneRecorder
from nonsmooth.runs.scene_run import SceneRun
from nonsmooth.runs.scene_warnings import warn_of
from nonsmooth.runs.times import RecordTimes, listed
from nonsmooth.scenes.given import as_scene


class SteppedRun(SceneRun):
    """A run whose end is not known."""

    is_counted = False

    def _times(self, t_span: tuple[float, float], every: int, t_eval: Any) -> RecordTimes:
        """Start and end of the first step; others follow."""
        return listed(np.array(t_span))


class Stepper:
    """A scene that goes on by steps of `MoreauJean` as it is asked to, with a record after each `step`.

    The steps are those of `simulate`, to the same bits. Between two calls a controller reads ``bodies`` and says what
    forces and motors, which are functions of what it can change, give from then on: it is sampled, and its own state is
    the caller's.

    Parameters
    ----------
    scene : Scene or ready scene
    integrator : MoreauJean, optional
        With a step of its own; that of the scene's ``dt`` when left out.
    t_0 : float
        Start [s].
    record : str or sequence of str, optional
        As of `simulate`.

    Raises
    ------
    InvalidInput
        For what is no scene, another integrator, and a scene that cannot begin.

    Examples
    --------
    A controller that keeps a cart at x = 1, asked every 10 ms:

    >>> import nonsmooth as ns
    >>> scene, push = ns.Scene(gravity=(0, -9.81), material=ns.Material(mu=0.01)), [0.0]
    >>> ground = scene.fixed(ns.HalfPlane((0, 1)), name="ground")
    >>> cart = scene.body(ns.Box(0.4, 0.1), mass=1.0, position=(0, 0.05), name="cart")
    >>> force = scene.force("cart", lambda t, bodies: (push[0], 0.0))
    >>> stepper = ns.Stepper(scene, ns.MoreauJean(dt=1e-3))
    >>> for _ in range(400):
    ...     cart = stepper.step(10)["cart"]
    ...     push[0] = 20 * (1 - cart.position[0]) - 8 * cart.velocity[0]
    >>> round(stepper.t, 9), abs(cart.position[0] - 1) < 0.01
    (4.0, np.True_)
    >>> sol = stepper.solution()  # a record each 10 ms, as of simulate(..., every=10)
    """

    def __init__(
        self, scene: Any, integrator: MoreauJean | None = None, *, t_0: float = 0.0,
        record: str | Sequence[str] | None = None,
    ) -> None:  # fmt: skip
        given = as_scene(scene)
        if given is None:
            raise InvalidInput(f"a stepper goes on with an ns.Scene, or a ready scene; got {shown(scene)}")
        if integrator is None:
            if given.dt is None:
                raise InvalidInput("the scene has no dt; give integrator=ns.MoreauJean(dt)")
            integrator = MoreauJean(given.dt)
        method = as_instance("integrator", integrator, MoreauJean, "ns.MoreauJean(dt), whose steps are of one length")
        t_0, recorder = as_number("t_0", t_0, "s"), SceneRecorder(KINDS_OF_SCENE.chosen(record))
        self._run = SteppedRun(given, (t_0, t_0 + method.dt), method, 1, None, recorder)
        self._run.dt = method.dt
        self._run.write_record()

    @property
    def t(self) -> float:
        """The time that the scene has come to [s]."""
        return self._run.now

    @property
    def bodies(self) -> SceneState:
        """All bodies at that time, by name."""
        world = self._run.world
        motion = world.bodies.motion
        return SceneState(self.t, self._run.names, world.scene, *world.record(motion.x.copy(), motion.v.copy()))

    def step(self, n: int = 1) -> SceneState:
        """Take n steps, and record where they lead.

        Raises
        ------
        InvalidInput
            For an n that is no whole number above 0.
        StepFailure
            Where a step cannot be taken, or a function of the user's says nothing that can be used; it has what was
            recorded until then. A stepper that failed goes no further.
        """
        run, n = self._run, as_count("n", n)
        if run.status != Status.RUNNING:
            raise run.failure(self.solution())
        end, began = run.steps + n, running_time()
        while run.steps < end and run.status == Status.RUNNING:
            run.take_steps(end - run.steps)
        run.wall_time += running_time() - began
        run.write_record()
        if run.status != Status.RUNNING:
            run.assembly.end_step()
            raise run.failure(self.solution())
        return self.bodies

    def solution(self) -> SceneSolution:
        """What was recorded so far, as `simulate` gives it back."""
        run = self._run
        run.recorder.empty(run)
        status = run.status
        run.status = Status.FINISHED if status == Status.RUNNING else status
        try:
            solution = run.solution()
        finally:
            run.status = status
        warn_of(run, solution)
        return solution

    def __repr__(self) -> str:
        return f"Stepper({self._run.scene!r}, {self._run.integrator!r}), at t = {self.t:g} s"
