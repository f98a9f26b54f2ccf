"""What friction in joints leaves open at the beginning of a step of a machine: none of its motions fits, or several.

Asked of the machines whose bearings may have no loads, or several (``bearings.py``). All loads of the problem of the
step with its joints sliding on are found (contact/bearing_loads.py):

    none       no force fits the slide: the joints seize at once, an impact without collision. Loads grow without a
               bound, in proportions that A keeps, until all stands: the solver begins with these
    several    those of the least largest load are taken: of one bearing the ones that are there for less friction,
               and that come back where it yields to its load
    one        the solver begins with it: a fixed point of loads need not be stable

Where a path of that search is lost nothing is said.
"""

from __future__ import annotations

import numpy as np

from nonsmooth.contact.bearing_loads import all_loads
from nonsmooth.integrators.assembly.accelerations import SceneInStep
from nonsmooth.integrators.assembly.bearings import begin_joint, find_doubtful_machine
from nonsmooth.integrators.assembly.drive_rows import drive_of
from nonsmooth.integrators.assembly.paradox import Before, Verdict
from nonsmooth.integrators.records import INCONSISTENT, INDETERMINATE
from nonsmooth.jit import interpreted
from nonsmooth.mechanics.system import ContactMode

GROWTH_SWEEPS = 30  # chosen: of the proportions in which loads grow, to some digits: the solver begins with them

drive_at, begin_row = interpreted(drive_of), interpreted(begin_joint)


class Machine:
    """A machine in a step whose joints slide: what its bearings bear, and where its friction would hold it."""

    def __init__(self, assembly: SceneInStep) -> None:
        bearings, drives = assembly.bearings, assembly.drives
        n, n_k = int(bearings.count), int(bearings.drives)
        self.rows, self.of = bearings.drive[:n_k].copy(), bearings.of[:n].copy()
        self.sign, self.rate = bearings.sign[:n_k].copy(), bearings.rate[:n_k].copy()
        self.arm = drives.arm[[drive_at(drives, key) for key in assembly.found.key[self.rows]]]
        above, Q = 3 * n, bearings.Q
        self.answer = Q[:above, :n_k].reshape(n, 3, n_k).copy()  # of bearings to friction
        self.b = Q[:above, -1].reshape(n, 3).copy()
        self.G, self.gamma = Q[above : above + n_k, :n_k].copy(), Q[above : above + n_k, -1].copy()
        self.A = -self.answer.transpose(0, 2, 1)[:, self.of] * (self.sign * self.arm)[self.of, None]

    def friction(self, loads: np.ndarray) -> np.ndarray:
        """What the loads of bearings let the friction of each joint be at most."""
        return self.arm * np.bincount(self.of, loads, len(self.rows))

    def slides_on(self, loads: np.ndarray) -> bool:
        """Whether all joints still slide as they do at the end of the step."""
        return bool((self.sign * (self.gamma - self.G @ (self.sign * self.friction(loads))) > 0.0).all())

    def seizing(self) -> np.ndarray:
        """Friction that stops all joints, in the proportions in which loads without a bound grow, rho ~ |A rho|."""
        rho = np.ones(len(self.b))
        for _ in range(GROWTH_SWEEPS):
            rho = np.linalg.norm(np.einsum("pqa,q->pa", self.A, rho), axis=1)
            rho /= rho.max()
        friction = self.friction(rho)
        slowed = self.sign * (self.G @ (self.sign * friction))
        return friction * np.max(self.sign * self.gamma / np.where(slowed > 0.0, slowed, np.inf))


def examine_machines(assembly: SceneInStep) -> list[Verdict]:
    """What is found of the doubtful machines of the step at hand; their friction begins as it is to be taken."""
    if assembly.progress.has_pins == 0:
        return []
    verdicts: list[Verdict] = []
    places, d = assembly.progress.places, assembly.dim
    find, dt, k = find_doubtful_machine[d], float(assembly.progress.dt), -1
    while True:
        k = int(find(places.bodies, places.found, places.network, places.drives, places.bearings, k + 1, dt, d))
        if k < 0:
            return verdicts
        machine = Machine(assembly)
        loads = all_loads(machine.A, machine.b)
        if loads is None:
            continue
        going_on = [load for load in loads if machine.slides_on(load)]
        kind = INCONSISTENT if len(loads) == 0 else INDETERMINATE
        if len(loads) == 0 or len(going_on) > 1:
            of = np.ones(len(machine.rows), bool)
            verdicts.append(Verdict(machine.rows, before_step(assembly, machine), kind, of, len(going_on), 0))
        friction = machine.friction(going_on[0]) if going_on else machine.seizing()
        for c, sign, most in zip(machine.rows, machine.sign, friction, strict=True):
            begin_row(assembly.drives, assembly.found, assembly.network, c, (sign, most, dt))


def before_step(assembly: SceneInStep, machine: Machine) -> Before:
    """The joints of a machine slide."""
    m, d = len(machine.rows), assembly.dim
    gamma, sign = np.zeros((m, d)), machine.sign
    gamma[:, 1] = machine.rate
    slip = sign.astype(int) if d == 2 else np.zeros(m, int)
    return Before(np.full(m, ContactMode.SLIDE), slip, gamma, np.zeros((m, d)))
