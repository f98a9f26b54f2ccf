"""The path of smoothed problems followed to the problem itself, through its folds.

    F(z, s) = 0,  z = (x, y),  s = log t:  ``smoothed``;  it begins at large s, where there is one solution
    tangent    T = +-(z', 1) / |(z', 1)|,        z' = dz/ds
    predictor  (z, s) <- (z, s) + h T
    corrector  Newton on F = 0 and T . (z - z_predicted, s - s_predicted) = 0

Where friction is not associated the path turns back and forth in t. The sign of T is that of -det(dF/dz), which is
positive at the start: so a path is never followed backwards, and a jump to another branch is seen. A step that turns by
more than a limit, jumps, or is not corrected is made shorter; where that does not help, the path has turned within the
tolerance of a corrector, and steps from before are made again with a far smaller tolerance. Where two branches come so
near that roundings hide the gap, the sign changes in the shortest step, and the path goes straight on. As long as
impulses are bounded so is the path, and it ends in a solution.

Lengths are those of the cones, relative to where a contact stands: |dz|^2 = (|W^-1 dx|^2 + |W dy|^2) / (2 n_c t). On
the way Newton's method on the augmented Lagrangian (``al_newton``) is tried from the impulses: it finds the digits.

Source: Allgower and Georg, Numerical Continuation Methods, Springer 1990, chapters 6 and 11; Mehrotra, SIAM J. Optim. 2
(1992) 575-601 (steps by a share of the way to the boundary).
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from nonsmooth.contact.blocks.natural_map import natural_map_entry
from nonsmooth.contact.network.rounds import Rounds
from nonsmooth.contact.network.smoothed import ROUNDING_OF_SLIP, Smoothed, linearise, room, to_dual
from nonsmooth.jit.blocks import new

PATH_START = 4.0  # measured: s at which Newton's method finds the one solution from impulses that do not press at all
# measured: C; four packings of 258 contacts have 0, 18, 4 and 88 folds with it, with 2 t in place of C t^2 22, 120,
# 163 and 84
PATH_OPENING = 1.0
FIRST_LENGTH, LONGEST_STEP = 0.5, 2.0  # chosen: h at first, and the most that s moves in a step
BOUNDARY_SHARE = (
    0.6  # measured: of the way to the boundary of the cones that a predictor goes; as many factors with 0.8
)
CORRECTOR_SHARE = 0.9  # chosen: of the same way, for a corrector
CORRECTED = 0.03  # measured: size of the last correction at the contact that moves most; with 0.1 and 0.3 more are lost
CORRECTED_FINE = 1e-5  # chosen: where steps are made again
MOST_CORRECTIONS, MOST_CUTS = 8, 9  # chosen
LENGTH_CUT = 0.3  # chosen
LEAST_COSINE = 0.7  # chosen: of two tangents
LENGTH_GROWTH = (2.0, 2.0, 1.5, 1.1)  # chosen: of h after so many corrections; more shorten it
LENGTH_FALL = 0.9  # chosen
STEPS_BACK, FINE_STEPS = 3, 12  # chosen: steps made again, and then with the small tolerance; then twice as many
FINE_LENGTH = 0.03  # chosen: h of the first of them, times LENGTH_CUT once more each time
MOST_RETURNS = 8  # chosen: times in a row
CROSSING_LENGTH = 1e-4  # chosen: h below which a path whose determinant changes its sign crosses another one
RECOVERY = 30  # chosen: steps after which the next return is a first one
REMEMBERED = 200  # derived: 3 * 2^5 steps back, and those that are made again
CORRECTED_AT_START = 1e-2  # chosen: size of the last correction at the start
SETTLING_STEPS = 60  # chosen
PATH_END = math.log(1e-10)  # measured: t below which roundings hide the path
FIRST_ATTEMPT = math.log(1e-2)  # measured: s at which factors are first tried
ATTEMPT_FALL, ATTEMPT_STEPS = math.log(2.0), 60  # chosen: they are tried again after such a fall of s, or as many steps
MOST_PATH_FACTORS = 5000  # measured: 258 contacts take 200 to 2300, 525 700 to 3200
MOST_PATH_CONTACTS = 700  # measured: 529 are solved; of 949 errors of 1e-6 to 3e-5 are left after 70 to 90 s
ISLAND_SHARE = 0.1  # chosen: of the tolerance, for one island of several


class Direction(NamedTuple):
    """A step, a place, or a form on steps, which does not ask for v."""

    x: np.ndarray
    y: np.ndarray
    v: np.ndarray
    s: float

    def times(self, factor: float) -> Direction:
        """This direction, so many times as long."""
        return Direction(factor * self.x, factor * self.y, factor * self.v, factor * self.s)

    def dot(self, other: Direction) -> float:
        """Its value for a step."""
        return float(np.vdot(self.x, other.x) + np.vdot(self.y, other.y)) + self.s * other.s


class Tangent(NamedTuple):
    """The unit tangent, and the scalar product with it as a form."""

    step: Direction
    form: Direction


class Path:
    """The path of island k of prepared rounds, whose columns are laid out."""

    def __init__(self, rounds: Rounds, k: int) -> None:
        islands, network = rounds.network.islands, rounds.network
        self.rounds, self.k, self.factors = rounds, k, 0
        self.side = -1.0
        self.contacts = islands.contacts[islands.contact_start[k] : islands.contact_start[k + 1]]
        self.bodies = slice(islands.body_start[k], islands.body_start[k + 1])
        self.point = new(Smoothed, m=len(self.contacts), n_b=len(network.v))
        self.mu = network.mu[self.contacts]
        network.P[:] = 0.0
        rounds.measured_error(rounds.rho)
        gamma = network.gamma[self.contacts]
        self.point.v_unit = np.abs(gamma).max()
        self.point.P_unit = self.point.v_unit / rounds.rho[self.contacts].mean()
        self._begin(gamma / self.point.v_unit)

    def _begin(self, gamma: np.ndarray) -> None:
        """y of contacts without impulses, and x = t y^-1."""
        self.s = PATH_START
        point, t = self.point, math.exp(PATH_START)
        a = gamma[:, 0] / self.mu + PATH_OPENING * t**2
        point.y[:, 1:] = gamma[:, 1:]
        point.y[:, 0] = a + np.sqrt(gamma[:, 1] ** 2 + gamma[:, 2] ** 2 + (ROUNDING_OF_SLIP * a) ** 2)
        inverse = point.y * (1.0, -1.0, -1.0)
        point.x[:] = t * inverse / (point.y * inverse).sum(axis=1, keepdims=True)
        network = self.rounds.network
        network.P[self.contacts] = self.impulses()
        self.rounds.measured_error(self.rounds.rho)
        point.v[self.bodies] = network.v[self.rounds.solver.direct.factor.columns.body[self.bodies]]

    def impulses(self) -> np.ndarray:
        """P of the contacts of the island (n, 3)."""
        P = self.point.P_unit * self.point.x
        P[:, 0] /= self.mu
        return P

    def linearise(self) -> bool:
        """Find the step to the path and its derivative at the point; False where there is none."""
        point, direct = self.point, self.rounds.solver.direct
        point.t = math.exp(self.s)
        point.opening = PATH_OPENING * point.t**2
        self.factors += 1
        if not linearise(self.rounds.network.address, direct.address, point.address, self.k):
            return False
        return bool(np.isfinite(point.dx).all() and np.isfinite(point.path_x).all())

    def correction(self) -> Direction:
        """The step to the path at the same t, copied from the point."""
        return Direction(self.point.dx.copy(), self.point.dy.copy(), self.point.dv.copy(), 0.0)

    def derivative(self) -> Direction:
        """The derivative by s, copied from the point."""
        return Direction(self.point.path_x.copy(), self.point.path_y.copy(), self.point.path_v.copy(), 1.0)

    def dual(self, step: Direction) -> Direction:
        """The scalar product with a step, as a form."""
        x, y = np.empty_like(step.x), np.empty_like(step.y)
        to_dual(self.point.w, step.x, step.y, x, y)
        scale = 1.0 / (2 * len(x) * self.point.t)
        return Direction(scale * x, scale * y, step.v, step.s)

    def size(self, step: Direction) -> float:
        """How far the contact goes that goes farthest."""
        form = self.dual(step)
        squares = (form.x * step.x).sum(axis=1) + (form.y * step.y).sum(axis=1)
        return math.sqrt(2 * len(squares) * float(squares.max()))

    def tangent(self) -> Tangent:
        """That at the point which was linearised, forward."""
        step = self.derivative()
        form = self.dual(step)
        scale = self.side * self.sign_of_determinant() / math.sqrt(form.dot(step))
        return Tangent(step.times(scale), form.times(scale))

    def sign_of_determinant(self) -> float:
        """Of the matrix; its factors keep the inverses of their pivots."""
        pivots = self.rounds.solver.direct.factor.D[self.bodies].reshape(-1, 6, 6)
        return float(np.linalg.slogdet(pivots)[0].prod())

    def move(self, step: Direction, length: float) -> None:
        """Go along a step."""
        self.point.x[:] += length * step.x
        self.point.y[:] += length * step.y
        self.point.v[:] += length * step.v
        self.s += length * step.s

    def room(self, step: Direction) -> float:
        """How many times a step stays inside the cones."""
        return float(room(self.point.x, self.point.y, step.x, step.y))

    def place(self) -> Direction:
        """Where the path is."""
        return Direction(self.point.x.copy(), self.point.y.copy(), self.point.v.copy(), self.s)

    def go_to(self, place: Direction) -> None:
        """Be there again."""
        self.point.x[:], self.point.y[:], self.point.v[:], self.s = place

    def settle(self) -> Tangent | None:
        """Newton's method at the start; the tangent there, or None where it does not converge."""
        for _ in range(SETTLING_STEPS):
            if not self.linearise():
                return None
            step = self.correction()
            size = self.size(step)
            if size <= CORRECTED_AT_START:
                return self.tangent()
            self.move(step, min(1.0, CORRECTOR_SHARE * self.room(step)))
        return None

    def correct(self, tangent: Tangent, length: float, tolerance: float) -> tuple[Tangent, int] | None:
        """Newton's method across a tangent, after such a step: the tangent at its end, and its corrections."""
        for count in range(MOST_CORRECTIONS):
            if not self.linearise():
                return None
            along, step = self.derivative(), self.correction()
            ds = -tangent.form.dot(step) / tangent.form.dot(along)
            step = Direction(step.x + ds * along.x, step.y + ds * along.y, step.v + ds * along.v, ds)
            size = self.size(step)
            if not size < math.inf:
                return None
            is_found = size <= tolerance
            after = self.tangent() if is_found else tangent
            if is_found and length <= CROSSING_LENGTH and tangent.form.dot(after.step) <= -LEAST_COSINE:
                self.side = -self.side
                after = Tangent(after.step.times(-1.0), after.form.times(-1.0))
            if is_found and not tangent.form.dot(after.step) >= LEAST_COSINE:
                return None
            self.move(step, min(1.0, CORRECTOR_SHARE * self.room(step)))
            if is_found:
                return after, count
        return None

    def advance(self, tangent: Tangent, length: float, tolerance: float) -> tuple[Tangent, float] | None:
        """A step of at most this length: the tangent after it, and the length for the next; None where all fail."""
        place = self.place()
        most = min(BOUNDARY_SHARE * self.room(tangent.step), LONGEST_STEP / max(abs(tangent.step.s), 1e-300))
        length = min(length, most)
        for cuts in range(MOST_CUTS):
            self.move(tangent.step, length)
            corrected = self.correct(tangent, length, tolerance)
            if corrected is not None:
                after, count = corrected
                growth = LENGTH_GROWTH[count] if count < len(LENGTH_GROWTH) else LENGTH_FALL
                return after, length if cuts > 0 else growth * length
            self.go_to(place)
            length *= LENGTH_CUT
        return None


class Returns:
    """Where a path was, and how often it had to go back."""

    def __init__(self) -> None:
        self.places: list[tuple[Direction, Tangent]] = []
        self.level = self.fine = self.calm = 0

    def remember(self, place: Direction, tangent: Tangent) -> None:
        """Keep a place, forget the oldest, and note a step that succeeded."""
        self.places = [*self.places[1 - REMEMBERED :], (place, tangent)]
        if self.fine > 0:
            self.fine -= 1
            self.calm = 0
        else:
            self.calm += 1
            self.level = 0 if self.calm >= RECOVERY else self.level

    def go_back(self) -> tuple[Direction, Tangent]:
        """A place from before, from which steps are fine."""
        back = min(STEPS_BACK << self.level, len(self.places) - 1)
        self.fine = (FINE_STEPS << self.level) + back
        self.level += 1
        self.places = self.places[: len(self.places) - back]
        return self.places[-1]


def follow_paths(rounds: Rounds, tol: float, until: float) -> None:
    """Follow the path of each island of spheres with friction that errs; the best impulses are kept."""
    network, islands = rounds.network, rounds.network.islands
    if rounds.is_over(tol, until) or not (rounds.may_factorise and rounds.are_spheres()):
        return

    def error_of(contacts: np.ndarray) -> float:
        network.P[:] = rounds.best
        rounds.measured_error(rounds.rho)
        mu, rho, weight = network.mu[contacts], rounds.rho[contacts], rounds.weight[contacts]
        return natural_map_entry(mu, rho, weight, network.P[contacts].ravel(), network.gamma[contacts].ravel(), 3)

    def is_solved(path: Path) -> bool:
        network.P[:] = rounds.best
        network.P[path.contacts] = path.impulses()
        rounds.solver.direct.kappa[path.k] = 0.0  # the factors at hand are those of the path
        rounds.factorise()
        return rounds.is_over(tol, until) or error_of(path.contacts) <= ISLAND_SHARE * tol

    for k in range(islands.count):
        contacts = islands.contacts[islands.contact_start[k] : islands.contact_start[k + 1]]
        is_rough = (network.mu[contacts] > 0.0).all() and (network.soft[contacts] == 0.0).all()
        is_small = len(contacts) <= MOST_PATH_CONTACTS
        if is_rough and is_small and not rounds.is_over(tol, until) and error_of(contacts) > ISLAND_SHARE * tol:
            path = Path(rounds, k)
            follow(path, MOST_PATH_FACTORS, until, is_solved)
            rounds.factors += path.factors
            rounds.solver.direct.kappa[k] = 0.0
            network.P[:] = rounds.best


def follow(path: Path, most: int, until: float, is_solved: Callable[[Path], bool]) -> bool:
    """Follow the path with ``most`` factors or some more; whether an attempt on the way solved the problem."""
    tangent = path.settle()
    if tangent is None:
        return False
    returns, length, tried, since = Returns(), FIRST_LENGTH, FIRST_ATTEMPT + ATTEMPT_FALL, 0
    returns.remember(path.place(), tangent)
    while path.factors < most and path.s > PATH_END and time.monotonic() < until:
        done = path.advance(tangent, length, CORRECTED_FINE if returns.fine > 0 else CORRECTED)
        if done is None:
            if returns.level == MOST_RETURNS:
                return False
            place, tangent = returns.go_back()
            path.go_to(place)
            length = FINE_LENGTH * LENGTH_CUT**returns.level
            continue
        tangent, length = done
        returns.remember(path.place(), tangent)
        since += 1
        if path.s <= tried - ATTEMPT_FALL or (path.s <= FIRST_ATTEMPT and since >= ATTEMPT_STEPS):
            if is_solved(path):
                return True
            tried, since = min(tried, path.s), 0
    return False
