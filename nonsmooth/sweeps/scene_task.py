"""The task of a sweep over scenes: a function of the axes builds one, it is run, and functions of the run are kept."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from nonsmooth.checks.arrays import as_count
from nonsmooth.errors import InvalidInput, shown
from nonsmooth.jit import identity
from nonsmooth.results.recorded import KINDS_OF_SCENE
from nonsmooth.results.scene_solution import SceneSolution
from nonsmooth.runs.asked import require_integrator
from nonsmooth.runs.simulate import simulate_whole
from nonsmooth.runs.times import as_span, own_steps
from nonsmooth.scenes.given import as_scene
from nonsmooth.sweeps.task import FunctionTask, as_values, name_of


class SceneTask(FunctionTask):
    """Runs of the scenes that a function builds, and what is kept of each.

    Parameters
    ----------
    make_scene : callable
        ``make_scene(**cell)``, one keyword an axis; returns a `Scene`, or what has a method ``scene()``.
    measures : callable or sequence of callables
        Each takes the `SceneSolution` and returns a number, an array or a dict of those; the first two are kept under
        the name of the function.
    t_span : (float, float), optional
        [s]; (0, t_end) of each scene when left out.
    integrator : MoreauJean or Penalty, optional
        MoreauJean(dt) of each scene when left out.
    every : int
        Steps between two records.
    record : sequence of str, optional
        What is recorded, as of `simulate`.

    Raises
    ------
    InvalidInput
        For what is no function, measures of no run, options that break a rule.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> def pushed(mu):
    ...     scene = ns.Scene(gravity=(0, -10.0), material=ns.Material(mu=mu))
    ...     scene.fixed(ns.HalfPlane((0, 1)))
    ...     scene.body(ns.Box(0.2, 0.1), mass=1.0, position=(0, 0.05), velocity=(1.0, 0), name="box")
    ...     return scene
    >>> def way(sol):
    ...     return sol["box"].position[-1, 0]
    >>> task = ns.SceneTask(pushed, way, t_span=(0, 0.5), integrator=ns.MoreauJean(dt=1e-3))
    >>> ns.sweep(task, {"mu": [0.25, 0.5]}).way.values.round(3).tolist()  # v^2/(2 mu g)
    [0.2, 0.1]
    """

    def __init__(
        self,
        make_scene: Callable[..., Any],
        measures: Callable[..., Any] | Sequence[Callable[..., Any]],
        *,
        t_span: tuple[float, float] | None = None,
        integrator: Any = None,
        every: int = 1,
        record: Sequence[str] | None = None,
    ) -> None:
        if not callable(make_scene):
            raise InvalidInput(f"make_scene must be a function of the axes; got {shown(make_scene)}")
        super().__init__(make_scene)
        self.measures = [measures] if callable(measures) else measures
        if not isinstance(self.measures, list | tuple) or not self.measures or not all(map(callable, self.measures)):
            raise InvalidInput(f"measures must be functions of the run of a scene; got {shown(measures)}")
        if integrator is not None:
            require_integrator(integrator)
        self.t_span, self.integrator = None if t_span is None else as_span(t_span), integrator
        self.every, self.record = as_count("every", every), KINDS_OF_SCENE.chosen(record)

    def identity(self) -> str:
        """Of the function that builds, those that measure, and of the run."""
        of_measures = [FunctionTask(measure).identity() for measure in self.measures]
        options = (self.t_span, self.integrator, getattr(self.integrator, "contacts", None), self.every, self.record)
        return "\n".join([super().identity(), *of_measures, identity(options).hex()])

    def value(self, **cell: Any) -> dict[str, Any]:
        """Build the scene of a cell, run it, measure."""
        scene = as_scene(self.function(**cell))
        if scene is None:
            raise InvalidInput(f"{name_of(self.function)} must return an ns.Scene, or a ready scene")
        solution: Any = simulate_whole(
            scene, self.t_span, integrator=own_steps(scene) if self.integrator is None else self.integrator,
            every=self.every, record=self.record, progress=None,
        )  # fmt: skip
        return self._measured(solution)

    def _measured(self, solution: SceneSolution) -> dict[str, Any]:
        values: dict[str, Any] = {}
        for measure in self.measures:
            found = measure(solution)
            named = found if isinstance(found, Mapping) else {name_of(measure).split(".")[-1]: found}
            values |= as_values(named)
        return values
