"""What a run cost, its worst figures, and what is said of those that its user has to know."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from nonsmooth.integrators import records
from nonsmooth.jit.blocks import fields_of, numbers
from nonsmooth.mechanics.system import System
from nonsmooth.results.recorded import LEDGER, Recorded

MOST_NAMED = 5  # chosen: contacts by name in a message
NONE_TOGETHER = 0, ""  # of a run in which no contacts were hit at once


@dataclass(frozen=True, eq=False, repr=False)
class Stats:
    """What a run cost, and its worst figures.

    Attributes
    ----------
    steps, lcp_solved, lcp_skipped, lcp_kept : int
        Steps; contact problems solved; steps without a closed contact; problems answered by the impulses or
        the modes of the step before.
    pivots : int
        Of Lemke's method.
    indeterminate_steps : int
        Steps whose problem had several solutions.
    worst_residual : float
        Of the accepted contact problems, relative to max |c|.
    worst_penetration : float
        Deepest gap at a mid-point [m].
    ledger_error : float
        Largest error of the energy balance of one step, relative to the sum of the sizes of the terms of a step,
        the largest so far; of a run whose ledger was recorded.
    energy_gains : int
        Impacts, or steps with an impact, in which the contacts gained energy, as Newton's law with friction lets them
        (docs/theory/moreau_jean.md); of rigid contacts.
    worst_energy_gain : float
        The most that one of them gained [J].
    friction_gains, worst_friction_gain : int, float
        Impacts by Newton's law at which friction did work and drove the slide, and the most in one of them [J].
    struck_together : int
        Impacts, or steps with an impact, in which Newton's law with e_N > 0 rebounded several coupled contacts at once.
    first_together : str
        When the first of them was, and which contacts it struck.
    uncounted : int
        Contact problems of several contacts whose solutions were not counted: neither certified to be one, nor
        enumerated, nor near enough to a problem that was (docs/theory/selection.md).
    shared : int
        Contact problems in which redundant contacts share a load: their impulses are one admissible share of many
        (docs/theory/moreau_jean.md).
    wall_time, compile_time : float
        [s]
    rejected, evaluations, jacobians, factorisations : int
        Of an integrator that chooses its steps: steps that were refused, evaluations of the rates, Jacobians, and
        factorisations of its linear systems.
    """

    steps: int
    lcp_solved: int
    lcp_skipped: int
    lcp_kept: int
    pivots: int
    indeterminate_steps: int
    events_dropped: int
    worst_residual: float
    worst_penetration: float
    ledger_error: float
    wall_time: float
    compile_time: float
    is_compiled: bool
    energy_gains: int = 0
    worst_energy_gain: float = 0.0
    uncounted: int = 0
    shared: int = 0
    rejected: int = 0
    evaluations: int = 0
    jacobians: int = 0
    factorisations: int = 0
    struck_together: int = 0
    first_together: str = ""
    friction_gains: int = 0
    worst_friction_gain: float = 0.0

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Stats) and vars(self) == vars(other)

    def __hash__(self) -> int:
        return hash(tuple(vars(self).values()))

    def __repr__(self) -> str:
        return f"Stats({', '.join(f'{name}={value!r}' for name, value in self.as_dict().items())})"

    def as_dict(self) -> dict[str, Any]:
        """The figures by name, as far as they are known."""
        return {name: value for name, value in vars(self).items() if value is not None}

    @classmethod
    def from_run(cls, state: records.State, system: System, *about: Any) -> Stats:
        """From the counters and the worst figures that a run left in its state; ``about``: see ``of_numbers``."""
        struck = int(state.together.count), first_together(system, state.together)
        return cls.of_numbers(numbers(state.counters).tolist(), numbers(state.worst).tolist(), struck, *about)

    @classmethod
    def of_numbers(
        cls, counters: list[int], worst_figures: list[float], struck: tuple[int, str], wall_time: float,
        compile_time: float, dropped: int, is_compiled: bool, recorded: tuple[str, ...],
    ) -> Stats:  # fmt: skip
        """From the numbers of a run's counters and worst figures, and its impacts at several contacts at once."""
        c = dict(zip(fields_of(records.Counters), counters, strict=True))
        worst = dict(zip(fields_of(records.Worst), worst_figures, strict=True))
        known_error: Any = worst["ledger_error"] if LEDGER in recorded else None
        return cls(
            c["steps"], c["solved"], c["skipped"], c["kept"], c["pivots"], c["several"], dropped + c["events_lost"],
            worst["residual"], worst["penetration"], known_error, wall_time,
            compile_time, is_compiled, c["gains"], worst["gain"], c["uncounted"], c["shared"], c["rejected"],
            c["evaluations"], c["jacobians"], c["factorisations"], *struck, c["pushes"], worst["push"],
        )  # fmt: skip


setattr(Stats, "ledger_error", Recorded(LEDGER, "ledger_error"))  # noqa: B010  # to a type checker it stays a number


def first_together(system: System, together: records.Together) -> str:
    """When contacts were first struck together, and which; nothing where they never were."""
    if not together.count:
        return ""
    names = [system.described.contacts[i] for i in np.flatnonzero(together.struck)]
    more = [f"{len(names) - MOST_NAMED} more"] if len(names) > MOST_NAMED + 1 else []
    names = (names[:MOST_NAMED] if more else names) + more
    return f"at t = {float(together.t):.6g} s {', '.join(names[:-1])} and {names[-1]}"


def rebound_together(stats: Stats, system: System | None) -> str:
    """What is to be said of a run in which Newton's law decided several contacts at once; friction in two directions
    has no other law of them."""
    times = "" if stats.struck_together == 1 else f" ({stats.struck_together} times in all)"
    others = (
        "impact='sequential' strikes one after the other, as a smaller dt does where they are apart, impact='poisson' "
        "gives back what was compressed, impact='energetic' gives it back as equal springs do, "
    ) if system is None or system.d < 2 else ""  # fmt: skip
    return (
        f"{stats.first_together} were hit at once{times}, and Newton's law of impact with e_N > 0 rebounds them "
        f"together, one answer of many: {others}e_N = 0 has no rebound, and impact='newton' chooses this answer"
    )


def energy_gain(stats: Stats) -> str:
    """What is to be said of a run whose contacts gained energy."""
    impacts = "one impact" if stats.energy_gains == 1 else f"{stats.energy_gains} impacts"
    return (
        f"the contacts gained energy in {impacts}, up to {stats.worst_energy_gain:.3g} J: Newton's law of impact lets "
        "them where coefficients differ, as e_N > 0 with friction of e_F = 0; a single contact with "
        "impact='energetic', or one e for e_N and e_F of all contacts, does not gain"
    )


def friction_gain(stats: Stats) -> str:
    """What is to be said of a run in which friction drove a slide."""
    impacts = "one impact" if stats.friction_gains == 1 else f"{stats.friction_gains} impacts"
    return (
        f"friction did work in {impacts}, up to {stats.worst_friction_gain:.3g} J: Newton's law of impact takes the "
        "friction at the end for the whole impact, also where the slide is reversed on the way; Contact(impact="
        "'energetic') follows it, and there friction only takes"
    )


class SpringStats(NamedTuple):
    """What the steps of a run with compliant contacts were."""

    omega: float  # sqrt(k/m) of the lightest body [1/s]
    longest_allowed: float  # step, 1/omega [s]


class StepLengths(NamedTuple):
    """What steps were, of a run that chooses them by their error."""

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
    lengths : StepLengths, optional
        Of a run whose steps are as long as their error allows.
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
    lengths: StepLengths | None = None
    islands_asleep: int = 0
    rebounds_limited: int = 0
    worst_joint_drift: float = 0.0
    last_joint_drift: float = 0.0
    inconsistent: int = 0
    indeterminate_steps: int = 0
    worst_contact: int = -1
    worst_pair: str = ""
    worst_time: float = 0.0


def stats_of_scene(named: dict[str, Any]) -> SceneStats:
    """What a file has of a run of a scene."""
    parts = {"springs": SpringStats, "lengths": StepLengths}
    return SceneStats(**named | {name: of(*named[name]) for name, of in parts.items() if named[name] is not None})
