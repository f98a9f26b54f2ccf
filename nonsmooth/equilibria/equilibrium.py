"""Steady sliding: states of rest while the surfaces move under the contacts.

    f(q, 0, la_N) = 0,    g_N(q) = 0        with the signs of sliding and of the normal forces fixed

by Newton's method, damped so that the Newton correction shrinks (the natural monotonicity test, which does not depend
on the units of the equations). An equilibrium of the fixed signs whose forces do not have these signs is *virtual*:
the smooth system has it, the mechanical one has not. Source: Deuflhard, *Newton Methods for Nonlinear Problems* (2004),
section 3.3.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from nonsmooth.checks.arrays import as_instance, as_number, as_vector
from nonsmooth.equilibria.sliding_mode import SlidingMode, mu_of
from nonsmooth.errors import InvalidInput
from nonsmooth.mechanics.initial_state import contact_state, evaluate
from nonsmooth.mechanics.model_system import as_rated
from nonsmooth.mechanics.situation import largest_closed_gap
from nonsmooth.mechanics.start import own_state
from nonsmooth.mechanics.system import BILATERAL, GIVEN_FORCE, NORMAL_FORCE, System
from nonsmooth.scenes.given import as_model
from nonsmooth.views import Worded

EQUILIBRIUM_NEWTON_STEPS = 60  # chosen: Newton steps before a guess is given up
SHORTEST_CORRECTION = 1e-6  # chosen: part of a Newton correction below which there is no descent left
CONVERGED = 1e-8  # derived: relative correction after which one more step reaches rounding: convergence is quadratic


class NotIsolated(InvalidInput):
    """The stiffness of the sliding system is singular: equilibria form a curve, or one is about to vanish."""


@dataclass(frozen=True, eq=False, repr=False)
class Equilibrium(Worded):
    """A state of steady sliding.

    Attributes
    ----------
    q : ndarray (n_q,)
    la_N, la_F : ndarray (n_c,)
        Forces of the contacts [N]; zero for open contacts. In space la_F is along the direction of sliding.
    gamma_F : ndarray (n_c,)
        Sliding velocities [m/s]; in space their sizes.
    residual : float
        Largest unbalanced force, relative to the largest force in the balance.
    wrong : tuple of str
        What contradicts the signs that were assumed; empty for an equilibrium of the mechanical system.
    mode : SlidingMode
        The smooth system whose equilibrium it is.
    """

    q: np.ndarray
    la_N: np.ndarray
    la_F: np.ndarray
    gamma_F: np.ndarray
    residual: float
    wrong: tuple[str, ...]
    mode: SlidingMode

    @property
    def is_virtual(self) -> bool:
        """Whether it belongs to the assumed signs only."""
        return bool(self.wrong)

    @property
    def multipliers(self) -> np.ndarray:
        """la_N of the constraints (n_a,)."""
        return self.la_N[self.mode.constrained]


def equilibrium(
    system: Any,
    guess: ArrayLike | None = None,
    sliding: ArrayLike | None = None,
    normal: ArrayLike | None = None,
    t: float = 0.0,
) -> Equilibrium:
    """The state of steady sliding near a guess.

    Parameters
    ----------
    system : System, model, or Scene
    guess : (n_q,), optional
        Coordinates to start from; those of the model's default state when left out. Unilateral contacts whose gap
        is open at the guess stay open.
    sliding : (n_c,), optional
        Signs of gamma_F; those of the surface velocities when left out, as they must be in space.
    normal : (n_c,), optional
        Signs of the normal forces of bilateral contacts; +1 when left out.
    t : float
        Time at which the functions are evaluated [s].

    Returns
    -------
    Equilibrium
        Its ``is_virtual`` says whether the forces contradict the assumed signs, ``wrong`` how.

    Raises
    ------
    InvalidInput
        When a closed contact does not slide at rest, when no equilibrium is found, or when it is not isolated.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> from nonsmooth.catalogue import SpragSlip
    >>> rod = SpragSlip()
    >>> at = ns.equilibrium(rod)
    >>> round(float(at.q[1]), 9), round(float(at.la_N[0]), 6), at.is_virtual
    (0.84962671, 38.551699, False)
    >>> other = ns.equilibrium(rod, guess=[2.7, 0.57], normal=[-1])
    >>> round(float(other.q[1]), 9), other.wrong
    (0.572612565, ('contact 0 would have to be pulled, but its normal force is 28.0915 N',))
    """
    given = as_model(system)
    system = as_rated(given, "equilibrium")
    q = _start(system, given) if guess is None else as_vector("guess", guess, system.n_q)
    mode = sliding_mode(system, q, sliding, normal, as_number("t", t, "s"))
    try:
        return _solved(mode, q, np.zeros(mode.n_a))
    except NotIsolated:
        return _solved(mode, q, _holding_forces(mode, q))


def as_equilibrium(at: Any) -> Equilibrium:
    """An equilibrium, or `InvalidInput`."""
    return as_instance("at", at, Equilibrium, "an Equilibrium, as ns.equilibrium(system) gives")


def follow_equilibrium(at: Equilibrium, **changes: float) -> Equilibrium:
    """The equilibrium of the same contacts and signs after some parameters have changed.

    Raises
    ------
    InvalidInput
        When there is none near the old one; the message says for which values.
    """
    mode = replace(at.mode, system=at.mode.system.with_parameters(**changes))
    try:
        return _solved(mode, at.q, at.multipliers)
    except InvalidInput as error:
        values = ", ".join(f"{name} = {value:g}" for name, value in changes.items())
        raise type(error)(f"at {values}: {error}") from None


def sliding_mode(
    system: System, q: np.ndarray, sliding: ArrayLike | None, normal: ArrayLike | None, t: float
) -> SlidingMode:
    """The closed contacts at q and their signs, as given or as the surfaces move."""
    gaps, _, gamma_F = contact_state(system, t, q, np.zeros(system.n_u))
    kinds = system.kinds[:, 0]
    closed = tuple(
        int(i) for i in np.flatnonzero((kinds == BILATERAL) | (kinds == GIVEN_FORCE) | (gaps <= largest_closed_gap(q)))
    )
    if sliding is not None and (system.kinds[:, 1] > 1).any():
        raise InvalidInput("sliding= gives signs, and friction in two directions has the direction of the surface")
    s = np.sign(gamma_F) if sliding is None else _signs("sliding", sliding, system.n_c)
    n = np.ones(system.n_c) if normal is None else _signs("normal", normal, system.n_c)
    for i in closed:
        if system.kinds[i, 1] and s[i] == 0:
            cure = "; give sliding=, the signs of gamma_F, for a contact that is about to move"
            raise InvalidInput(
                f"{system.described.contacts[i]} does not slide at rest (its surface does not move), so its equilibria "
                f"are not isolated{cure if system.kinds[i, 1] == 1 else ', and in space it has no direction to go in'}"
            )
        if n[i] < 0 and kinds[i] != BILATERAL:
            raise InvalidInput(f"{system.described.contacts[i]} can only push; normal = -1 is for bilateral contacts")
    return SlidingMode(system, closed, s, n, t)


def _signs(name: str, value: Any, n_c: int) -> np.ndarray:
    signs = as_vector(name, value, n_c)
    if not np.isin(signs, (-1.0, 1.0)).all():
        raise InvalidInput(f"{name} must hold +1 or -1 for each contact; got {signs.tolist()}")
    return signs


def _start(system: System, given: Any) -> np.ndarray:
    """The coordinates of the model's default state, or zero."""
    state = own_state(given)
    return np.array(state()[0], float) if state else np.zeros(system.n_q)


def _holding_forces(mode: SlidingMode, q: np.ndarray) -> np.ndarray:
    """The la_N that come nearest to balance at q: a pin gives a pendulum its stiffness by its force alone."""
    without = mode.force(q, np.zeros_like(q), np.zeros(mode.n_a)).real
    return np.linalg.lstsq(mode.force_rows(q).T, -without, rcond=None)[0]


def _solved(mode: SlidingMode, q: np.ndarray, la_N: np.ndarray) -> Equilibrium:
    """Newton's method from q and la_N of the constraints."""
    n, x = q.size, np.concatenate([q, la_N])
    for _ in range(EQUILIBRIUM_NEWTON_STEPS):
        J = balance_jacobian(mode, x[:n], x[n:])
        dx = _solve(J, -balance(mode, x))
        groups = (slice(0, n), slice(n, None))
        if all(np.abs(dx[k]).max(initial=0.0) <= CONVERGED * np.abs(x[k]).max(initial=0.0) for k in groups):
            x = x + dx
            x = x + _solve(J, -balance(mode, x))
            return _described(mode, x[:n], x[n:], _relative_residual(mode, x, J))
        x = _damped(mode, x, dx, J)
    raise InvalidInput(
        f"no equilibrium was found from the guess: {EQUILIBRIUM_NEWTON_STEPS} Newton steps end at "
        f"q = {np.array2string(x[:n])}; start nearer to it, or give other signs of sliding"
    )


def balance(mode: SlidingMode, x: np.ndarray) -> np.ndarray:
    """(f, g_N) at x = (q, la_N)."""
    n = mode.system.n_q
    q, rest = x[:n], np.zeros(n)
    return np.concatenate([mode.force(q, rest, x[n:]).real, mode.gaps(q).real])


def balance_jacobian(mode: SlidingMode, q: np.ndarray, la_N: np.ndarray) -> np.ndarray:
    """d(f, g_N)/d(q, la_N)."""
    R, W_N = mode.force_rows(q), mode.normal_rows(q).real
    return np.block([[-mode.stiffness(q, la_N), R.T], [W_N, np.zeros((mode.n_a, mode.n_a))]])


def _solve(J: np.ndarray, b: np.ndarray) -> np.ndarray:
    rows = np.abs(J).max(axis=1, keepdims=True)
    columns = np.abs(J).max(axis=0)
    if not (rows > 0).all() or not (columns > 0).all() or np.linalg.cond(J / rows / columns, 1) > 1e13:
        raise NotIsolated(
            "the equilibria near the guess are not isolated: the stiffness of the sliding system is singular, so some "
            "motion meets no restoring force"
        )
    return np.linalg.solve(J, b)


def _damped(mode: SlidingMode, x: np.ndarray, dx: np.ndarray, J: np.ndarray) -> np.ndarray:
    """x after the longest of the steps dx, dx/2, dx/4 ... that leaves a smaller correction."""
    part, size = 1.0, np.abs(dx)
    for k in (slice(0, mode.system.n_q), slice(mode.system.n_q, None)):  # what is below rounding shrinks by chance
        largest = np.maximum(np.abs(x[k]), size[k]).max(initial=0.0)
        size[k] = np.maximum(size[k], max(CONVERGED * largest, np.finfo(float).tiny))
    while part > SHORTEST_CORRECTION:
        trial = x + part * dx
        following = np.linalg.solve(J, -balance(mode, trial))
        if np.isfinite(following).all() and np.linalg.norm(following / size) <= (1 - part / 4) * np.sqrt(x.size):
            return trial
        part /= 2
    return x + dx


def _relative_residual(mode: SlidingMode, x: np.ndarray, J: np.ndarray) -> float:
    """max |f_i| / max (|J| |x|)_i: against the forces that balance."""
    n = mode.system.n_q
    f = balance(mode, x)[:n]
    terms = (np.abs(J[:n]) @ np.abs(x)).max()
    return float(np.abs(f).max() / terms) if terms > 0 else 0.0


def _described(mode: SlidingMode, q: np.ndarray, multipliers: np.ndarray, residual: float) -> Equilibrium:
    """The forces, and what contradicts the assumed signs."""
    system, t, rest = mode.system, mode.t, np.zeros_like(q)
    gaps, _, gamma_F = contact_state(system, t, q, rest)
    la_N = np.where(system.kinds[:, 0] == GIVEN_FORCE, evaluate(system, NORMAL_FORCE, t, q, rest), 0.0)
    la_N[mode.constrained] = multipliers
    la_F, wrong, names = np.zeros(system.n_c), [], system.described.contacts
    for i in range(system.n_c):
        if i not in mode.closed:
            if gaps[i] < 0:
                wrong.append(f"{names[i]} was taken as open, but it penetrates by {-gaps[i]:g} m")
            continue
        if mode.normal[i] * la_N[i] <= 0:
            must = "be pulled" if mode.normal[i] < 0 else "press"
            wrong.append(f"{names[i]} would have to {must}, but its normal force is {la_N[i]:.6g} N")
        if system.kinds[i, 1]:
            mu = float(mu_of(system.laws, i, abs(gamma_F[i])))
            la_F[i] = -mode.sliding[i] * mu * mode.normal[i] * la_N[i]
            if mode.sliding[i] * gamma_F[i] < 0:
                wrong.append(f"{names[i]} slides against its assumed sign, gamma_F = {gamma_F[i]:g} m/s")
    return Equilibrium(q, la_N, la_F, gamma_F, residual, tuple(wrong), mode)
