"""The energy of every step is accounted for, whatever moves, for any theta: T_1 - T_0 = the works booked."""

import math

import numpy as np
import pytest
import scipy.integrate

import nonsmooth as ns
from models import BeadChain, BeltOscillator, BouncingBall, PainleveRod, RockingBlock, SlidingBlock, SpragSlip

MODELS = [BouncingBall(), SlidingBlock(), BeltOscillator(), PainleveRod(), SpragSlip(), RockingBlock(), BeadChain(n=8)]
WORKS = ("force", "friction", "normal", "surface")


def run(model, t_end=0.5, **options):
    return ns.simulate(model, (0, t_end), *model.state(), integrator=ns.MoreauJean(dt=1e-3, **options))


@pytest.mark.filterwarnings("ignore::nonsmooth.SimultaneousImpactWarning")  # what is asked holds for it too
@pytest.mark.parametrize("theta", [0.5, 0.7, 1.0])
@pytest.mark.parametrize("model", MODELS, ids=lambda model: model.name)
def test_kinetic_energy_changes_by_the_works_in_every_record(model, theta):
    ledger = run(model, theta=theta).ledger
    works = np.column_stack([ledger[name] for name in WORKS])
    sizes = np.abs(np.diff(works, axis=0)).sum(axis=0).sum() + ledger["kinetic"].max()
    # one rounding of each term a step, all summed: far below the work of a single step
    rounding = len(works) * np.finfo(float).eps * sizes
    assert np.abs(ledger["kinetic"] - ledger["kinetic"][0] - works.sum(axis=1)).max() <= rounding


@pytest.mark.parametrize("theta", [0.5, 1.0])
def test_friction_takes_energy_and_the_belt_gives_it(theta):
    ledger = run(SpragSlip(), theta=theta).ledger
    slip_work, belt_work = np.diff(ledger["friction"]), ledger["surface"][-1]
    # where the tip sticks, the mean of the end velocities at the mid-point's rows is not 0 but O(dt^2)
    assert slip_work[slip_work > 0].sum() < 1e-3**2 * -slip_work.sum() < belt_work


def test_potential_drift_stands_beside_the_ledger_and_is_of_second_order():
    def mass(t, q, p, M):
        M[0, 0] = 1.0

    def force(t, q, u, p, h):
        h[0] = -q[0] - q[0] ** 3

    def potential(t, q, p, V):
        V[0] = q[0] ** 2 / 2 + q[0] ** 4 / 4

    spring = ns.System(n_q=1, mass=mass, force=force, potential=potential)
    drifts = []
    for dt in (1e-2, 5e-3):
        ledger = ns.simulate(spring, (0, 3), [1.0], [0.0], integrator=ns.MoreauJean(dt=dt)).ledger
        drifts.append(np.abs(np.diff(ledger["kinetic"] + ledger["potential"])).sum())
    assert 3.5 < drifts[0] / drifts[1] < 4.5


def test_restitution_loses_the_share_of_energy_that_newton_says():
    e = 0.6
    solution = run(BouncingBall(e=e), t_end=0.6)  # one impact, at 0.4515 s
    landing = solution.ledger["kinetic"].max()
    assert np.isclose(solution.ledger["normal"][-1], -(1 - e**2) * landing, rtol=5e-3)  # the step of the impact: O(dt)


@pytest.mark.parametrize("integrator", [ns.MoreauJean(dt=1e-4), ns.EventDriven(rtol=1e-9, atol=1e-11)], ids=repr)
def test_work_of_the_changing_mass_stands_beside_the_work_of_the_gyroscopic_force(integrator):
    """A free two-link arm: h is gyroscopic alone, the kinetic energy stays, and h takes (u, dM/dt u)/2."""

    def mass(t, q, p, M):
        M[0, 0], M[1, 1] = 2.0, 1.0
        M[0, 1] = M[1, 0] = math.cos(q[0] - q[1])

    def force(t, q, u, p, h):
        h[0] = -math.sin(q[0] - q[1]) * u[1] ** 2
        h[1] = math.sin(q[0] - q[1]) * u[0] ** 2

    arm = ns.System(n_q=2, mass=mass, force=force)
    solution = ns.simulate(arm, (0, 2), [0.0, 1.0], [3.0, -1.0], integrator=integrator, t_eval=np.linspace(0, 2, 4001))
    q, u, t = solution.q, solution.u, solution.t
    power = -np.sin(q[:, 0] - q[:, 1]) * (u[:, 0] - u[:, 1]) * u[:, 0] * u[:, 1]  # (u, dM/dt u)/2
    work = scipy.integrate.cumulative_simpson(power, x=t, initial=0.0)
    # |u| < 8 rad/s: steps of second order miss (8 dt)^2 = 6e-7 of the work, Simpson's rule (8 * 5e-4)^4
    assert np.abs(u).max() < 8.0 and 0.5 < np.ptp(work) < 6.0
    assert np.abs(solution.ledger["mass"] - work).max() < 6e-7
    assert np.abs(solution.ledger["force"] + work).max() < 6e-7
    assert "mass" not in run(RockingBlock(), t_end=0.01).ledger
