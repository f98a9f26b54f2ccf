"""Several planar contacts by SciPy's solve_ivp: one set of modes after the other, its forces from a linear system.

A model is given by M(q), h(q, u), gaps(q) and rows(q) = (W_N, W_F). With the modes of the contacts that are closed,

    u' = M^-1 (h + C x),    R u' + R' u = 0:    R = rows that are held, C = W_N - s mu W_F (sliding) or R (sticking)

R' u by the complex step, exact to rounding. An event is a gap, a normal force, a sliding velocity or the rest of the
friction that falls through zero. An impact is one of the contacts that come together, with Newton's restitution; the
others must be apart, or must open by it.
"""

import itertools

import numpy as np

from .scipy_pieces import Pieces, falling

TINY = 1e-30  # complex step
REDUNDANT = 1e-12  # of the largest singular value: two corners of a block that stick on one plane
TOUCH = 1e-15  # m, a gap that is none
TOGETHER = 1e-12  # m, gaps that close at one instant: a parallel block on its two corners
WEAK = 1e-9  # N, a force that is none
RISES = 1e-9  # m
LEAVES = 1e-6  # m/s, of a bounce of 1e-14 m
SLOW = 1e-12  # m/s, a velocity that is none: rounding of the impacts leaves 1e-13


class Contacts:
    """A model, the state of its contacts, and its motion."""

    def __init__(self, mass, force, gaps, rows, mu, e):
        self.mass, self.force, self.gaps, self.rows, self.mu, self.e = mass, force, gaps, rows, mu, e
        self.modes = {}  # of the closed contacts: sign of sliding, or 0

    def split(self, y):
        return y[: len(y) // 2], y[len(y) // 2 :]

    def held(self, modes, W_N, W_F):
        """Rows whose velocities are given, and directions of the forces on them, in the order of the modes."""
        rows, directions = [], []
        for k, s in modes.items():
            rows.append(W_N[k])
            directions.append(W_N[k] - s * self.mu * W_F[k])
            if s == 0:
                rows.append(W_F[k])
                directions.append(W_F[k])
        return np.array(rows), np.array(directions).T

    def pairs(self, modes, x):
        """Normal and friction parts of each contact from the solution of its modes."""
        x, found = list(x), {}
        for k, s in modes.items():
            normal = x.pop(0)
            found[k] = normal, x.pop(0) if s == 0 else -s * self.mu * normal
        return found

    def dynamics(self, y, modes):
        """Accelerations, and the normal and friction force of each closed contact."""
        q, u = self.split(y)
        M, h = self.mass(q), self.force(q, u)
        if not modes:
            return np.linalg.solve(M, h), {}
        R, C = self.held(modes, *self.rows(q))
        slopes, _ = self.held(modes, *(np.imag(W) / TINY for W in self.rows(q + 1j * TINY * u)))
        x = np.linalg.lstsq(R @ np.linalg.solve(M, C), -R @ np.linalg.solve(M, h) - slopes @ u, rcond=REDUNDANT)[0]
        return np.linalg.solve(M, h + C @ x), self.pairs(modes, x)

    def events(self, y):
        """Functions that fall through zero, and what each means."""
        modes, found = dict(self.modes), []
        for k in range(len(self.gaps(self.split(y)[0]))):
            if k not in modes:
                found.append((lambda t, y, k=k: self.height(y, k), self.strikes, k))
                continue
            found.append((lambda t, y, k=k: self.dynamics(y, modes)[1][k][0], self.opens, k))
            if modes[k]:
                found.append((lambda t, y, k=k: modes[k] * self.slip(y, k), self.stops, k))
            else:
                found.append((lambda t, y, k=k: self.rest(y, k, modes), self.slides, k))
        return found

    def slip(self, y, k):
        q, u = self.split(y)
        return self.rows(q)[1][k] @ u

    def approach(self, y, k):
        q, u = self.split(y)
        return self.rows(q)[0][k] @ u

    def height(self, y, k):
        """A gap that is positive where the contact leaves, so that a step may reach over a whole bounce."""
        return self.gaps(self.split(y)[0])[k] + (RISES if self.approach(y, k) > 0 else 0.0)

    def rest(self, y, k, modes):
        """What is left of the friction of a contact that sticks."""
        normal, friction = self.dynamics(y, modes)[1][k]
        return self.mu * normal - abs(friction)

    def opens(self, y, k):
        """With all whose forces vanish at this instant, as those of a block on two corners do."""
        forces = self.dynamics(y, self.modes)[1]
        self.modes = {i: s for i, s in self.modes.items() if i != k and forces[i][0] > WEAK}
        return y

    def stops(self, y, k):
        """What stops together sticks, if it can, else it slides the other way."""
        stopped = [i for i, s in self.modes.items() if i == k or (s and abs(self.slip(y, i)) < SLOW)]
        stuck = self.modes | dict.fromkeys(stopped, 0)
        if min(self.rest(y, i, stuck) for i in stopped) < 0:
            stuck = self.modes | {i: -self.modes[i] for i in stopped}
        self.modes = stuck
        return y

    def slides(self, y, k):
        """The friction force is the one of the new slide."""
        self.modes[k] = -np.sign(self.dynamics(y, self.modes)[1][k][1])
        return y

    def strikes(self, y, k):
        """Impacts until no contact that touches approaches; what stays without velocity may close."""
        gaps = self.gaps(self.split(y)[0])
        together = [int(i) for i in np.flatnonzero(gaps < TOGETHER) if i == k or self.approach(y, i) < -SLOW]
        struck = set()
        while together:
            struck.update(together)
            y = self.impact(y, together)
            velocities = {i: self.approach(y, i) for i in self.modes}
            assert all(v > -SLOW for v in velocities.values()), "an impact that closes others further"
            self.modes = {i: self.modes[i] for i, v in velocities.items() if v < SLOW}
            gaps = self.gaps(self.split(y)[0])
            together = [int(i) for i in np.flatnonzero(gaps < TOUCH) if self.approach(y, i) < -SLOW][:1]
        return self.closed(y, struck)

    def closed(self, y, struck):
        """Close what hardly leaves and would return: the impulse of its last bounces less that of a closed contact."""
        slips = {i: self.slip(y, i) for i in struck if self.approach(y, i) < LEAVES}
        modes = self.modes | {i: np.sign(v) if abs(v) > SLOW else 0 for i, v in slips.items()}
        if not slips or min(normal for normal, _ in self.dynamics(y, modes)[1].values()) < 0:
            assert len(slips) < 2, "which of several contacts opens is not told by their forces"
            return y
        self.modes = modes
        q, u = self.split(y)
        R, C = self.held(modes, *self.rows(q))
        X = np.linalg.solve(self.mass(q), C)
        return np.concatenate([q, u - X @ np.linalg.lstsq(R @ X, R @ u, rcond=REDUNDANT)[0]])

    def impact(self, y, struck):
        """The impulses at contacts that are struck together: sticking, or sliding as they do afterwards."""
        q, u = self.split(y)
        W_N, W_F = self.rows(q)
        for signs in itertools.product((0, 1, -1), repeat=len(struck)):
            modes = dict(zip(struck, signs, strict=True))
            R, C = self.held(modes, W_N, W_F)
            factors = np.concatenate([[1 + self.e[k]] + [1.0] * (s == 0) for k, s in modes.items()])
            X = np.linalg.solve(self.mass(q), C)
            P = np.linalg.lstsq(R @ X, -factors * (R @ u), rcond=REDUNDANT)[0]
            after = u + X @ P
            impulses = self.pairs(modes, P)
            if all(
                normal >= 0 and (s * (W_F[k] @ after) > 0 if s else abs(friction) <= self.mu * normal)
                for (k, s), (normal, friction) in zip(modes.items(), impulses.values(), strict=True)
            ):
                return np.concatenate([q, after])
        raise AssertionError("no impulses of these contacts alone")


def move(problem, rtol, contacts, modes=()):
    """The motion of a model to its end."""
    pieces = Pieces(problem, rtol)
    t, q0, u0 = problem.start
    y = np.concatenate([q0, u0])
    contacts.modes = dict(modes)
    while t < pieces.t_end:
        at, modes = contacts.events(y), dict(contacts.modes)
        rates = lambda t, y, modes=modes: np.concatenate([contacts.split(y)[1], contacts.dynamics(y, modes)[0]])
        t, y, which = pieces.add(rates, t, y, [falling(f) for f, _, _ in at])
        if which is None:
            break
        _, happens, k = at[which]
        y = happens(y, k)
    return pieces.result()
