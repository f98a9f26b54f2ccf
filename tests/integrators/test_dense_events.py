"""Dense events are followed, stiff forces too; too many contacts at once end with an error that names the cure.

An elastic ball of 1 kg between the floor and a piston of 1e6 kg that falls on it with 1 m/s. The speed of the ball
times the gap is nearly constant, 0.5 m^2/s, until the ball has the energy of the piston: 1000 m/s in a gap of 0.5 mm, a
million bounces a second. Then the piston is thrown back. Energy and momentum are kept throughout.
"""

import math
from typing import NamedTuple

import numpy as np
import pytest

import nonsmooth as ns
from benchmarks.stress_scenes import Tower, tower


class Piston(NamedTuple):
    m: float = 1.0  # kg
    M: float = 1e6  # kg


PISTON = Piston()


def mass(t, q, p, M):
    M[0, 0] = p.m
    M[1, 1] = p.M


def no_force(t, q, u, p, h):
    h[0] = 0.0


def gaps(t, q, p, g_N):
    g_N[0] = q[0]
    g_N[1] = q[1] - q[0]


def normals(t, q, p, W_N):
    W_N[0, 0] = 1.0
    W_N[1, 0] = -1.0
    W_N[1, 1] = 1.0


def squeezed(integrator, t_end=2.0, **options):
    ball = ns.System(n_q=2, mass=mass, force=no_force, gap=gaps, normal=normals,
                     contacts=[ns.Contact(e_N=1.0)] * 2, parameters=PISTON)  # fmt: skip
    return ns.simulate(ball, (0, t_end), [0.5, 1.0], [1.0, -1.0], integrator=integrator, **options)


def momentum_error(sol):
    """Of the momentum against the impulses of the floor, in that of the piston."""
    momentum = PISTON.m * sol.u[:, 0] + PISTON.M * sol.u[:, 1]
    return np.abs(momentum - momentum[0] - np.cumsum(sol.P_N[:, 0])).max() / PISTON.M


def test_piston_is_thrown_back_by_the_ball():
    """Bounce by bounce, 3139 of them, as Adaptive does it within its tolerance."""
    exact, adapted = squeezed(ns.EventDriven()), squeezed(ns.Adaptive(1e-6, 1e-8))
    for run in (exact, adapted):
        energy = 0.5 * (PISTON.m * run.u[:, 0] ** 2 + PISTON.M * run.u[:, 1] ** 2)
        assert np.ptp(energy) < 1e-9 * energy[0] and momentum_error(run) < 1e-13
        assert run.success and abs(run.u[-1, 1] - 1.0) < 1e-6
    assert 0.0 <= exact.q[-1, 0] <= exact.q[-1, 1]
    assert np.abs(adapted.u[-1] - exact.u[-1]).max() < 1e-5 and len(adapted.events) == len(exact.events)


def test_a_budget_ends_the_run():
    with pytest.raises(ns.BudgetSpent) as failure:
        squeezed(ns.EventDriven(), max_steps=2000)
    assert failure.value.t < 1.0 and failure.value.solution.stats.steps == 2000


def pushed_tower():
    """Ten masses upon each other, the upper one pushed: ten frictional contacts decided at once, and q0, u0."""
    u0 = np.zeros(20)
    u0[18] = 1.0
    return tower(10, Tower()), (np.zeros(20), u0)


def test_more_contacts_than_can_be_enumerated_end_with_the_cure_and_are_stepped():
    """The upper mass alone slides, and stops after v^2/(2 mu g)."""
    masses, start = pushed_tower()
    with pytest.raises(ns.StepFailure, match=r"contacts touch at once.*Adaptive or MoreauJean") as failure:
        ns.simulate(masses, (0, 0.2), *start, integrator=ns.EventDriven(1e-6, 1e-8))
    assert failure.value.t == 0.0 and failure.value.u[18] == 1.0
    stepped = ns.simulate(masses, (0, 1), *start, integrator=ns.Adaptive(1e-6, 1e-8))
    assert stepped.q[-1, 18] == pytest.approx(1 / (2 * masses.parameters.mu * masses.parameters.g), rel=1e-6)


# stiff models


@pytest.mark.parametrize("c, most", [(1e6, 120), (2e4, 120), (1e3, 300)])
def test_stiff_spring_does_not_stall_the_run(c, most):
    """k = 1e8 N/m between two unit masses on a soft spring, with the dampings 50, 1 and 0.05 of the critical one.

    An explicit method of order 5 needs steps of 3/omega = 2e-4 s, or m/c 3 = 1e-6 s: 2e4 to 5e6 of them. The masses
    move as one of 2 kg: x'' = -2 x, cos(sqrt(2) t), to f/k = 2e-8 m.
    """

    def force(t, q, u, p, h):
        pull = p.k * (q[1] - q[0]) + p.c * (u[1] - u[0])
        h[0] = pull - 4.0 * q[0]
        h[1] = -pull

    class Spring(NamedTuple):
        k: float = 1e8
        c: float = 1e6

    pair = ns.System(n_q=2, mass=pair_mass, force=force, parameters=Spring(c=c))
    sol = ns.simulate(pair, (0, 5), [1.0, 1.0], [0.0, 0.0], integrator=ns.EventDriven(1e-6, 1e-8))
    assert sol.success and sol.stats.steps < most
    assert np.abs(sol.q - np.cos(math.sqrt(2) * sol.t)[:, None]).max() < 1e-6


def pair_mass(t, q, p, M):
    M[0, 0] = M[1, 1] = 1.0
