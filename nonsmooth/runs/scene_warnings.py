"""What is said once a run of a scene has ended: figures that its user has to know, each with what ends it."""

from __future__ import annotations

from nonsmooth.errors import (
    EnergyGainWarning,
    PenetrationWarning,
    ResidualWarning,
    SimultaneousImpactWarning,
    warn_caller,
)
from nonsmooth.integrators.assembly.progress import MOST_TURN
from nonsmooth.results.scene_solution import SceneSolution
from nonsmooth.results.stats import SceneStats
from nonsmooth.results.summary import worst_place
from nonsmooth.runs.scene_run import SceneRun

MOST_OF_A_CHAIN = 20  # chosen: bodies, as of a break at billiards: in a pile all blows meet others, and none is told
DEEP = 0.01  # chosen: of the smallest shape: a penetration that is told


def warn_of(run: SceneRun, solution: SceneSolution) -> None:
    """Warn of each of these figures that is past what goes without saying."""
    stats, smallest = solution.stats, run.assembly.smallest
    if stats.missed and solution.success:
        warn_caller(missed_residual(stats), ResidualWarning)
    if stats.energy_gains:
        warn_caller(rebound_gain(stats), EnergyGainWarning)
    if stats.struck_together and len(run.scene.bodies) <= MOST_OF_A_CHAIN:
        warn_caller(struck_by_several(stats), SimultaneousImpactWarning)
    if stats.worst_penetration > DEEP * smallest:
        warn_caller(deep_penetration(stats, smallest, run.what_is_deep), PenetrationWarning)
    if stats.worst_joint_drift > DEEP * smallest:
        warn_caller(far_drift(stats, smallest), PenetrationWarning)
    counts = run.assembly.progress.counts
    if counts.spun:
        name = run.scene.bodies[int(counts.spinner)].name
        warn_caller(far_turn(name, int(counts.spun)), PenetrationWarning)


def rebound_gain(stats: SceneStats) -> str:
    """What is to be said of a run whose contacts gained energy."""
    return (
        f"the contacts gained energy in {stats.energy_gains} impacts, up to {stats.worst_energy_gain:.3g} J: "
        "Newton's law of impact lets them where e > 0 and friction acts, or several contacts are hit at once; "
        "e = 0 gains nothing"
    )


def struck_by_several(stats: SceneStats) -> str:
    """What is to be said of a run in which Newton's law decided impacts of several pairs at once."""
    times = "" if stats.struck_together == 1 else f" (as bodies were in {stats.struck_together} steps)"
    return (
        f"{stats.first_together} was struck by several bodies at once{times}, and Newton's law of impact with e > 0 "
        "rebounds them together, one answer of many: a smaller dt, or spaces wider than the way in a step, let blows "
        "follow one another, and e = 0 has no rebound"
    )


def deep_penetration(stats: SceneStats, smallest: float, why: str) -> str:
    """What is to be said of a run whose bodies were deep in one another."""
    return (
        f"bodies were up to {stats.worst_penetration:.2g} m in one another, and the smallest reaches {smallest:.2g} m: "
        + why
    )


def far_drift(stats: SceneStats, smallest: float) -> str:
    """What is to be said of a run whose joints came apart."""
    return (
        f"the points of a joint were up to {stats.worst_joint_drift:.2g} m apart, and the smallest body reaches "
        f"{smallest:.2g} m: velocities that a joint stops at the start, or bodies that turn far in a step or "
        "swing faster than it under a pull; a smaller dt ends this"
    )


def far_turn(name: str, spun: int) -> str:
    """What is to be said of a run in which a body turned far in a step while it touched."""
    return (
        f"{name} turned by more than {MOST_TURN:g} rad in a step while it touched, as bodies did {spun} times: "
        "contacts are those of the beginning of a step, and what is thin may have passed through what it met; "
        "a smaller dt ends this"
    )


def missed_residual(stats: SceneStats) -> str:
    """What is to be said of a run whose contact problems were not all solved to the tolerance."""
    return (
        f"in {stats.missed} of {stats.steps} steps the contact problem was solved to less than tol = {stats.tol:g}, at "
        f"worst to {stats.worst_residual:.2g}{worst_place(stats)}; interior points for larger islands, more sweeps, or "
        "a larger tol, end this: MoreauJean(dt, contacts=ns.ContactSolver(interior=..., sweeps=..., tol=...))"
    )
