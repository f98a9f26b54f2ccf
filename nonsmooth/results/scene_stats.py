"""What a run of a scene cost, and its worst figures."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple


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
        The residual asked for.
    worst_residual, last_residual : float
        Over all steps and of the last one, recomputed: the largest |F| / max(|P|, R / tol) of the islands of a step,
        with F the natural map, P the impulses and R what rounding of the velocities does to F, which counts where
        |F| / |P| is above ``tol``. 0 where nothing is exchanged.
    missed : int
        Steps whose residual is above ``tol``.
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
    worst_contact : int
        The contact of the largest |F| in the worst island of the step of ``worst_residual``: its row among the contacts
        of that step, and behind them its joints. -1 where no residual is above 0.
    worst_pair : str
        Its bodies.
    worst_time : float
        When the step began [s].
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
    worst_contact: int = -1
    worst_pair: str = ""
    worst_time: float = 0.0
