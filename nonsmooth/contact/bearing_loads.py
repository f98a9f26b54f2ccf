"""All loads of bearings that slide, whose friction is in proportion to what they bear.

    rho_p = |b_p + sum_q A_pq rho_q|,    p = 1..n,    b_p, A_pq in R^3,    rho >= 0

b_p is what bearing p bears without friction, A_pq what the friction of a unit load of q adds to it. The right side is a
contraction, and the loads are one, where the spectral radius of |A_pq| is below 1. Else there may be none, or several:
squared the equations are n quadrics, with 2^n roots in projective space (Bézout), and all of them are found by a
homotopy from rho_p^2 = tau^2, along paths of complex numbers that meet no singular point for almost every gamma on the
unit circle:

    H(x, t) = gamma (1 - t) (rho_p^2 - tau^2) + t (rho_p^2 - |b_p tau + A_p rho|^2),    x = (tau, rho),   t = 0..1

Paths that end in one point, or are lost, are followed with another gamma: a double root stays one, a jump does not.
Source: Sommese and Wampler, *The Numerical Solution of Systems of Polynomials* (2005), chapters 3 and 8.
"""

from __future__ import annotations

import itertools

import numpy as np

ANGLES_OF_GAMMA = (
    0.6435011,
    2.1,
    4.5,
)  # chosen: angles of gamma, none that loads would have: the first one mostly does
FIRST_AHEAD, LEAST_AHEAD, LARGEST_AHEAD = 0.05, 1e-10, 0.2  # chosen: of t
ON_PATH = 1e-10  # chosen: correction of |x| = 1 by which a point is on its path
CORRECTIONS = 4  # chosen: of Newton's method a step, of which the first are quadratic where the step is short enough
MOST_AHEAD = 5000  # chosen: steps of a path: some hundred are enough
AT_INFINITY = 1e-9  # chosen: tau of |x| = 1 below which a load has no bound
NOT_COMPLEX = 1e-7  # chosen: imaginary part of a load, of the largest: a double root has that of a root of a rounding
ZERO_LOAD = 1e-14  # chosen: of the largest load: a bearing of a smaller one bears nothing
ONE_END = 1e-12  # chosen: 1 - |x . y| below which two ends are one
SAME_LOAD = 1e-6  # chosen: of the largest load: roots that are nearer are one
POLISHING = 8  # chosen: steps of Newton's method in real numbers


def all_loads(A: np.ndarray, b: np.ndarray) -> np.ndarray | None:
    """Find all loads.

    Parameters
    ----------
    A : (n, n, 3)
        What the friction of a unit load of bearing q adds to what p bears.
    b : (n, 3)
        What they bear without friction [N], or [N s].

    Returns
    -------
    (s, n)
        The solutions by the size of their largest load, least first; none: s = 0. Or None, where a path was lost.

    Examples
    --------
    >>> import numpy as np
    >>> from nonsmooth.contact.bearing_loads import all_loads
    >>> A, b = np.zeros((1, 1, 3)), np.zeros((1, 3))
    >>> A[0, 0], b[0] = (-2, 0, 0), (1, 0, 0)  # rho = |1 - 2 rho|
    >>> all_loads(A, b).round(12)
    array([[0.33333333],
           [1.        ]])
    >>> len(all_loads(A, -b))  # rho = |1 + 2 rho|
    0
    """
    n, size = len(b), np.linalg.norm(b)
    if size == 0.0:
        return np.zeros((1, n))
    bears = (np.linalg.norm(b, axis=1) > ZERO_LOAD * size) | (np.linalg.norm(A, axis=2) > ZERO_LOAD).any(axis=1)
    k = np.flatnonzero(bears)
    A, b = A[np.ix_(k, k)], b[k] / size
    form = np.concatenate((b[:, None], A), axis=1)  # (n, n + 1, 3) of x = (tau, rho)
    ends = ends_of_paths(form)
    if np.isnan(ends).any():
        return None
    tau = np.where(np.abs(ends[:, 0]) > AT_INFINITY, ends[:, 0], np.nan)
    rho = ends[:, 1:] / tau[:, None]
    largest = np.abs(rho).max(axis=1, initial=0.0)
    is_load = (np.abs(rho.imag).max(axis=1) <= NOT_COMPLEX * largest) & (rho.real.min(axis=1) >= -NOT_COMPLEX * largest)
    loads = distinct([polished(A, b, load) for load in rho[is_load].real])
    found = np.zeros((len(loads), n))
    if len(loads):
        found[:, k] = size * loads
    return found


def ends_of_paths(form: np.ndarray) -> np.ndarray:
    """The roots x (2^n, n + 1) of the quadrics, |x| = 1; of a path that is lost NaN."""
    signs = itertools.product((-1.0, 1.0), repeat=len(form))
    x = np.array([(1.0, *of_root) for of_root in signs], complex)
    for phase in ANGLES_OF_GAMMA:
        ends = follow(form, x, np.exp(1j * phase))
        cosines = np.abs(ends.conj() @ ends.T) - np.eye(len(ends))
        if cosines.max() < 1.0 - ONE_END:  # not of NaN
            break
    return ends


def follow(form: np.ndarray, x: np.ndarray, gamma: complex) -> np.ndarray:
    """The ends of the paths from x (m, n + 1) at t = 0."""
    x = x / np.linalg.norm(x, axis=1)[:, None]
    t, step = np.zeros(len(x)), np.full(len(x), FIRST_AHEAD)
    for _ in range(MOST_AHEAD):
        go = np.flatnonzero(t < 1.0)
        if len(go) == 0:
            break
        ahead = np.minimum(t[go] + step[go], 1.0)
        there, is_met = corrected(form, predicted(form, x[go], t[go], ahead, gamma), ahead, gamma)
        met = go[is_met]
        x[met], t[met] = there[is_met], ahead[is_met]
        step[met] = np.minimum(2.0 * step[met], LARGEST_AHEAD)
        step[go[~is_met]] *= 0.25
        lost = go[step[go] < LEAST_AHEAD]
        x[lost], t[lost] = np.nan, 1.0
    x[t < 1.0] = np.nan
    return x


def value(form: np.ndarray, x: np.ndarray, t: np.ndarray, gamma: complex) -> tuple[np.ndarray, ...]:
    """H (m, n), its derivative by x (m, n, n + 1) and by t (m, n)."""
    n = x.shape[1] - 1
    borne = np.einsum("pqa,mq->mpa", form, x)
    start, goal = x[:, 1:] ** 2 - x[:, :1] ** 2, x[:, 1:] ** 2 - np.einsum("mpa,mpa->mp", borne, borne)
    of_goal = -2.0 * np.einsum("mpa,pqa->mpq", borne, form)
    of_start = np.zeros_like(of_goal)
    of_start[:, :, 0] = -2.0 * x[:, :1]
    own = np.arange(n)
    of_start[:, own, own + 1] = 2.0 * x[:, 1:]
    of_goal[:, own, own + 1] += 2.0 * x[:, 1:]
    s = t[:, None]
    dx = gamma * (1.0 - s)[..., None] * of_start + s[..., None] * of_goal
    return gamma * (1.0 - s) * start + s * goal, dx, goal - gamma * start


def on_sphere(x: np.ndarray, dx: np.ndarray, right: np.ndarray) -> np.ndarray:
    """The solution of dx y = right across x."""
    matrix = np.concatenate((dx, x.conj()[:, None]), axis=1)
    return np.linalg.solve(matrix, np.concatenate((right, np.zeros((len(x), 1))), axis=1)[..., None])[..., 0]


def predicted(form: np.ndarray, x: np.ndarray, t: np.ndarray, ahead: np.ndarray, gamma: complex) -> np.ndarray:
    """The points of the paths at t = ahead, by Heun's method."""
    h = (ahead - t)[:, None]
    _, dx, dt = value(form, x, t, gamma)
    rate = on_sphere(x, dx, -dt)
    first = x + h * rate
    _, dx, dt = value(form, first, ahead, gamma)
    return x + 0.5 * h * (rate + on_sphere(first, dx, -dt))


def corrected(form: np.ndarray, x: np.ndarray, t: np.ndarray, gamma: complex) -> tuple[np.ndarray, np.ndarray]:
    """The points of the paths near x, and whether they are."""
    size = np.ones(len(x))
    for _ in range(CORRECTIONS):
        x = x / np.linalg.norm(x, axis=1)[:, None]
        H, dx, _ = value(form, x, t, gamma)
        y = on_sphere(x, dx, -H)
        x, size = x + y, np.linalg.norm(y, axis=1)
    return x / np.linalg.norm(x, axis=1)[:, None], size <= ON_PATH


def polished(A: np.ndarray, b: np.ndarray, load: np.ndarray) -> np.ndarray:
    """Newton's method from a load, of rho^2 - |b + A rho|^2 = 0; where that stalls, what there is."""
    for _ in range(POLISHING):
        borne = b + np.einsum("pqa,q->pa", A, load)
        slope = 2.0 * np.diag(load) - 2.0 * np.einsum("pa,pqa->pq", borne, A)
        load = load - np.linalg.lstsq(slope, load**2 - (borne**2).sum(axis=1), rcond=None)[0]
    return np.maximum(load, 0.0)


def distinct(loads: list[np.ndarray]) -> np.ndarray:
    """The loads that differ, the least first."""
    found: list[np.ndarray] = []
    for load in sorted(loads, key=max):
        if all(np.abs(load - other).max() > SAME_LOAD * load.max() for other in found):
            found.append(load)
    return np.array(found)
