"""Periodic motions found from a simulation, from a near cycle, or from a start: see ``shooting`` for the equations."""

from __future__ import annotations

from typing import Any

import numpy as np

from nonsmooth.checks.arrays import as_positive
from nonsmooth.cycles.cycle import LimitCycle
from nonsmooth.cycles.drift import Drift, as_coordinates, find_drift
from nonsmooth.cycles.mode_sequence import ContactLost, is_forced, period_of
from nonsmooth.cycles.phase import PhaseGuess
from nonsmooth.cycles.shooting import Shooting
from nonsmooth.errors import InvalidInput
from nonsmooth.integrators.event_driven.options import EventDriven
from nonsmooth.integrators.moreau_jean.options import MoreauJean
from nonsmooth.mechanics.model_system import as_rated
from nonsmooth.mechanics.start import answers_start, forms_of, own_state, own_time, start_of
from nonsmooth.mechanics.system import System
from nonsmooth.results.solution import Solution
from nonsmooth.runs.simulate import simulate_whole
from nonsmooth.scenes.given import as_model

DYING = 0.1  # chosen: a motion whose extent falls so far, from one fifth of a simulation to the last, has no cycle
ATTEMPTS = 5  # chosen: simulations, each twice as long as the one before
CYCLE_RTOL, CYCLE_ATOL = 1e-8, 1e-10  # chosen: of the simulation between events


@answers_start
def limit_cycle(
    system: Any,
    guess: Any = None,
    duration: float | None = None,
    dt: float | None = None,
    forcing: float | None = None,
    drift: Any = None,
    state: Any = None,
) -> LimitCycle:
    """The periodic motion near a guess.

    Parameters
    ----------
    system : System, model, or Scene
    guess : Solution, LimitCycle, (q0, u0) or dict, optional
        A simulated motion whose end is nearly periodic; a cycle of the system at other parameters; or a start from
        which to simulate. The model's default state when left out.
    state : (q0, u0) or dict, optional
        The start from which to simulate, as of `simulate`.
    duration : float, optional
        Of the simulation; the model's ``t_end`` when left out [s]. A motion that has not settled is continued for
        twice, four times, ... as long.
    dt : float, optional
        Simulate by `MoreauJean` with this step [s]; by `EventDriven` when left out.
    forcing : float, optional
        Period of the excitation [s], where the model's functions read the time. The cycle's is a multiple of it.
    drift : sequence of int or str, optional
        The coordinates that may go on by the same amount in every period, by number or by the model's name of them:
        those along which nothing of the system changes (the height of a toy that climbs down a pole), also together
        (the angles of discs on a turning shaft), or with the time (a drive at a constant rate). Found when left out;
        an empty list asks for a cycle that closes in all of them.

    Returns
    -------
    LimitCycle
        Stable or not: the multipliers tell. Its ``drift`` says how far each coordinate goes on in a period.

    Raises
    ------
    InvalidInput
        When the motion comes to rest or has no period, when impacts follow one another in one instant, when a
        coordinate is to drift with which the system changes, or when the cycle of the guessed sequence of modes does
        not close; the message says which event broke it, or which coordinate goes on.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> from nonsmooth.catalogue import BeltOscillator
    >>> cycle = ns.limit_cycle(BeltOscillator(vb=0.2))
    >>> round(cycle.period, 8), round(cycle.stick_duration, 8), cycle.is_stable
    (2.02034826, 0.25014763, True)
    """
    model = as_model(system)
    system = as_rated(model, "limit_cycle")
    if guess is not None and state is not None:
        raise InvalidInput("give either guess or state; got both")
    word, guess = ("guess", guess) if state is None else ("state", state)
    coordinates = as_coordinates(drift, system)
    if isinstance(guess, LimitCycle):
        _require_same_kind(system, guess)
        forcing = guess.forcing if forcing is None else forcing
        coordinates = () if drift is None and not guess.drifts else coordinates
    if forcing is not None:
        as_positive("forcing", forcing, "s")
    start = _start(model, system, guess, word)
    directions = find_drift(system, [start], forcing is not None, coordinates)
    _require_forcing(system, forcing, directions)
    try:
        if isinstance(guess, LimitCycle):
            return _closed(system, guess.guesses(), forcing, directions, guess.scale)
        if isinstance(guess, Solution):
            return _closed(system, period_of(guess, forcing, directions), forcing, directions)
        return _settled(model, system, start, duration, dt, forcing, directions)
    except InvalidInput as broken:
        if not directions.has_time:
            raise
        raise type(broken)(
            f"{broken} (this system's functions change with time, as a drive does that goes on at a constant rate; "
            "where they have a period, give it as forcing=)"
        ) from broken


def _closed(
    system: System, guess: list[PhaseGuess], forcing: float | None, drift: Drift, scale: np.ndarray | None = None
) -> LimitCycle:
    """The cycle with the phases of a guess; one with a scale counts as near."""
    return Shooting(system, guess, scale, forcing=forcing, drifts=len(drift) > 0).solve()


def _start(model: Any, system: System, guess: Any, word: str) -> tuple[float, np.ndarray, np.ndarray]:
    """t, q and u at which a simulation begins, or a state of the motion that was given."""
    if isinstance(guess, LimitCycle):
        first = guess.phases[0]
        return float(first.x[-1]) if guess.has_time else 0.0, first.q[: system.n_q], first.u[: system.n_q]
    if isinstance(guess, Solution):
        _require_same_size(system, guess)
        return float(guess.t[-1]), guess.q[-1], guess.u[-1]
    state = own_state(model)
    if guess is not None:
        return 0.0, *start_of(model, guess, word)
    if state is None:
        raise InvalidInput(f"this system has no default state; give state={forms_of(model)}")
    return 0.0, *state()


def _require_same_size(system: System, guess: Solution) -> None:
    """Raise for a motion of a system with another number of coordinates."""
    if guess.q.shape[1] != system.n_q:
        raise InvalidInput(
            f"guess must be a motion of this system, with {system.n_q} coordinates; got one with {guess.q.shape[1]}"
        )


def _require_forcing(system: System, forcing: float | None, drift: Drift) -> None:
    """Raise unless the period of the excitation is given where, and only where, the system reads the time."""
    if forcing is None and is_forced(system) and not drift.has_time:
        raise InvalidInput(
            "this system's functions change with time; give forcing=, the period of its excitation [s] (a drive that "
            "goes on at a constant rate, with coordinates that follow it, needs none: it is found)"
        )
    if forcing is not None and not is_forced(system):
        raise InvalidInput("this system's functions do not change with time; leave forcing out, the period is its own")


def _require_same_kind(system: System, guess: LimitCycle) -> None:
    """Raise for the cycle of a system with other numbers of coordinates or contacts."""
    sizes, others = ((s.n_q, s.n_c) for s in (system, guess.system))
    if sizes != others:
        raise InvalidInput(
            f"guess must be a cycle of this system, with {sizes[0]} coordinates and {sizes[1]} contacts; "
            f"got one with {others[0]} and {others[1]}"
        )


def _settled(
    model: Any, system: System, start: tuple[float, np.ndarray, np.ndarray], duration: float | None, dt: float | None,
    forcing: float | None, drift: Drift,
) -> LimitCycle:  # fmt: skip
    """The cycle of a simulated motion, continued for longer while it has not settled."""
    t, q, u = start
    duration = own_time(model, "t_end") if duration is None else as_positive("duration", duration, "s")
    if duration is None:
        raise InvalidInput("this system has no t_end of its own; give duration=")
    integrator = EventDriven(CYCLE_RTOL, CYCLE_ATOL) if dt is None else MoreauJean(dt=dt)
    for attempt in range(ATTEMPTS):
        end = t + duration * 2**attempt
        run = simulate_whole(system, (t, end), q, u, integrator=integrator, project=dt is not None and attempt > 0)
        try:
            return _closed(system, period_of(run, forcing, drift), forcing, drift)
        except ContactLost:
            raise
        except InvalidInput as broken:
            if attempt == ATTEMPTS - 1:
                _require_alive(run, broken, drift)
                raise
        t, q, u = float(run.t[-1]), run.q[-1], run.u[-1]
    raise AssertionError


def _require_alive(run: Solution, broken: InvalidInput, drift: Drift) -> None:
    """Raise when the motion has become much smaller on its way: it has no cycle because it dies out."""
    fifth = 0.2 * (run.t[-1] - run.t[0])
    q = drift.rest(run.t, run.q) if drift else run.q
    first, last = (np.ptp(q[part], axis=0) for part in (run.t <= run.t[0] + fifth, run.t >= run.t[-1] - fifth))
    if 0 < last.max() and (last <= DYING * first).all():
        raise InvalidInput(
            f"the motion dies out: it shrinks by a factor {(last.max() / first.max()):.2g} from t = {run.t[0]:g} to "
            f"{run.t[-1]:g} s of the last simulation, so there is no cycle near this start; give another one"
        ) from broken
