"""Compliant contact of any small planar system by SciPy's solve_ivp: one smooth piece after the other.

Of a `System` only the equations are taken, its functions of t, q, u (scipy_modes.py); forces, modes and events are
done here, in Python:

    M u' = h + W_N^T la_N + W_F^T la_F,    la_N = k d + c d',    d = -g_N    (unilateral: while d > 0 and la_N > 0)
    sticking: gamma_F' = 0,   sliding: la_F = -s mu |la_N|

A unilateral contact is loaded while min(d, k d + c d') > 0. A slide ends where gamma_F falls to zero, a stick where
|la_F| reaches mu |la_N|; what follows is the stick, or the slide that its force drives.
"""

import numpy as np
from scipy.integrate import solve_ivp

from benchmarks.adapters.scipy_modes import OPEN, STICK, Equations

MOMENT = 1e-9  # s after an event in which what has just fallen to zero may not fall again
MOST_PIECES = 10_000  # smooth pieces of a run: more are a driver that goes in a circle


class Springs(Equations):
    """A system on springs k and dampers c; the mode of a contact is `OPEN`, `STICK`, or the sign of its slide."""

    def __init__(self, system, k, c):
        super().__init__(system)
        self.k, self.c, self.n_rates = k, c, 0
        self.mu = [law.coefficients(system.parameter_values)[0] if law else 0.0 for law in self.laws]

    def loads(self, t, q, u):
        """(la_N of loaded contacts, min(d, la_N), which is above zero where they are loaded), (n_c,) each."""
        d, gamma = -self.gaps(t, q), self.velocities(t, q, u)[::2]
        la_N = self.k * d - self.c * gamma
        return la_N, np.minimum(d, la_N)

    def dynamics(self, t, y, modes):
        """(u', forces (n_c, 2))."""
        q, u = y[: self.n], y[self.n :]
        M, h = self.call("mass", (self.n, self.n), t, q), self.call("force", (self.n,), t, q, u)
        (W, _), la_N = self.rows(t, q), self.loads(t, q, u)[0]
        forces = np.zeros((self.n_c, 2))
        for i, mode in enumerate(modes):
            if mode != OPEN:
                forces[i] = la_N[i], 0.0 if mode == STICK else -mode * self.mu[i] * abs(la_N[i])
        stuck = [i for i, mode in enumerate(modes) if mode == STICK]
        free = np.linalg.solve(M, h + W.T @ forces.ravel())
        if stuck:
            T = W[[2 * i + 1 for i in stuck]]
            rates = self.row_rates(t, q, u)[[2 * i + 1 for i in stuck]]
            forces[stuck, 1] = np.linalg.solve(T @ np.linalg.solve(M, T.T), -(T @ free + rates))
            free = free + np.linalg.solve(M, T.T @ forces[stuck, 1])
        return free, forces

    def rates(self, t, y, modes):
        self.n_rates += 1
        return np.concatenate([y[self.n :], self.dynamics(t, y, modes)[0]])

    def reserve(self, i, t, y, modes):
        """What friction of a contact that sticks has left."""
        la_N, la_F = self.dynamics(t, y, modes)[1][i]
        return self.mu[i] * abs(la_N) - abs(la_F)

    def functions(self, modes):
        """(Function of (t, y) that falls to zero where a piece ends, contact, whether friction changes there)."""
        found = []
        for i, mode in enumerate(modes):
            if self.kinds[i] == "unilateral":
                sign = -1.0 if mode == OPEN else 1.0
                load = lambda t, y, i=i, sign=sign: sign * self.loads(t, y[: self.n], y[self.n :])[1][i]
                found.append((load, i, False))
            if mode == STICK:
                found.append((lambda t, y, i=i: self.reserve(i, t, y, modes), i, True))
            elif mode != OPEN and self.laws[i] is not None:
                slide = lambda t, y, i=i, s=mode: s * self.velocities(t, y[: self.n], y[self.n :])[2 * i + 1]
                found.append((slide, i, True))
        return found

    def after(self, t, y, modes, i, is_friction):
        """The modes where contact i comes to rest, slips, lands or lifts off."""
        if modes[i] == OPEN:
            gamma = self.velocities(t, y[: self.n], y[self.n :])[2 * i + 1]
            return [*modes[:i], float(np.sign(gamma)) or 1.0, *modes[i + 1 :]]
        if not is_friction:
            return [*modes[:i], OPEN, *modes[i + 1 :]]
        held = [*modes[:i], STICK, *modes[i + 1 :]]
        if modes[i] != STICK and self.reserve(i, t, y, held) > 0.0:
            return held
        return [*modes[:i], float(-np.sign(self.dynamics(t, y, held)[1][i, 1])), *modes[i + 1 :]]

    def begin(self, t, y):
        """The modes at the start; what rests there sticks, or slips."""
        gamma, loaded = self.velocities(t, y[: self.n], y[self.n :]), self.loads(t, y[: self.n], y[self.n :])[1] > 0.0
        closed = [loaded[i] or self.kinds[i] == "bilateral" for i in range(self.n_c)]
        modes = [(float(np.sign(gamma[2 * i + 1])) or STICK) if closed[i] else OPEN for i in range(self.n_c)]
        for i in [i for i, mode in enumerate(modes) if mode == STICK]:
            if self.reserve(i, t, y, modes) < 0.0:
                modes = self.after(t, y, modes, i, is_friction=True)
        return modes


def motion(system, k, c, q0, u0, times, method, rtol, atol):
    """(States (m, 2 n) at the times, the first of which is the start, steps, evaluations of the rates).

    Raises RuntimeError where SciPy does not reach the end, or returns what is not finite.
    """
    springs, n = Springs(system, k, c), system.n_q
    t, y, steps = float(times[0]), np.concatenate([q0, u0]).astype(float), 0
    found = np.zeros((len(times), 2 * n))
    found[0], modes = y, springs.begin(t, y)
    for _ in range(MOST_PIECES):
        functions = springs.functions(modes)
        piece = solve_ivp(
            lambda s, x, modes=modes: springs.rates(s, x, modes), (t, times[-1]), y, method=method, rtol=rtol,
            atol=atol, events=[as_event(function, t) for function, *_ in functions] or None, dense_output=True,
        )  # fmt: skip
        if not piece.success or not np.isfinite(piece.y).all():
            raise RuntimeError(f"{method} stopped at t = {piece.t[-1]}: {piece.message}")
        inside = (times > t) & (times <= piece.t[-1])
        if inside.any():
            found[inside] = piece.sol(times[inside]).T
        t, y, steps = piece.t[-1], piece.y[:, -1], steps + len(piece.t) - 1
        which = next((e for e, ends in enumerate(piece.t_events or []) if len(ends)), None)
        if which is None:
            return found, steps, springs.n_rates
        modes = springs.after(t, y, modes, *functions[which][1:])
    raise RuntimeError(f"{method} came to t = {t} in {MOST_PIECES} pieces")


def as_event(function, begin):
    """An event function of SciPy, which does not see what is at zero at the beginning."""
    event = lambda t, y: 1.0 if t - begin < MOMENT else function(t, y)
    event.terminal, event.direction = True, -1.0
    return event
