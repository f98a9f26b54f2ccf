"""Scenes in nonsmooth, by steps of a run; and how deep the bodies of any program lie in one another, by its gaps."""

from nonsmooth.integrators.assembly.progress import DONE
from nonsmooth.integrators.moreau_jean.contact_solver import ContactSolver
from nonsmooth.integrators.moreau_jean.options import MoreauJean
from nonsmooth.runs.scene_run import SceneRun


class Motion:
    """A scene in motion."""

    def __init__(self, scene, dt, **options):
        self.dt = dt
        integrator = MoreauJean(dt=dt, contacts=ContactSolver(**options))
        self.run = SceneRun(scene, (0.0, dt), integrator, 1, None)
        self.motion = self.run.world.bodies.motion
        self.moving = self.motion.moves == 1

    def step(self, count):
        if self.run.assembly.take_steps(self.dt, count) != DONE:
            raise ArithmeticError("a body is nowhere")

    def places(self):
        x, d = self.motion.x[self.moving], self.run.scene.dim
        return x[:, :d].copy(), (x[:, 2] if d == 2 else x[:, 3:]).copy()

    def residual(self):
        """The worst since the last call."""
        figures = self.run.assembly.progress.figures
        worst, figures.since_residual = float(figures.since_residual), 0.0
        return worst


class Judge:
    """The gaps of a scene, wherever its bodies are."""

    def __init__(self, scene, dt):
        self.run = SceneRun(scene, (0.0, dt), MoreauJean(dt=dt), 1, None)
        self.motion = self.run.world.bodies.motion
        self.moving = self.motion.moves == 1

    def penetration(self, position, turn):
        """The deepest [m]."""
        x, d = self.motion.x, self.run.scene.dim
        x[self.moving, :d] = position
        x[self.moving, d:] = turn.reshape(len(position), -1)
        count = self.run.assembly.find_contacts()
        return max(0.0, -float(self.run.assembly.found.gap[:count].min(initial=0.0)))
