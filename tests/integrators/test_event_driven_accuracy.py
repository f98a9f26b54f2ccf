"""Event-driven integration: what its tolerance promises, and random starts."""

import math

import numpy as np
import pytest

import nonsmooth as ns
from models import (
    BeadChain,
    BeltOscillator,
    BilateralRod,
    BouncingBall,
    LeadScrew,
    PainleveRod,
    RockingBlock,
    SpragSlip,
    WallPendulum,
)

BELT = BeltOscillator(vb=0.2)
SCENES = {
    "ball": (BouncingBall(e=0.8), {"height": 1.0}, 4.0),
    "pendulum": (WallPendulum(), {"th": 1.0}, 5.0),
    "rod": (PainleveRod(mu=1.0), {"th": math.radians(75), "thdot": -0.5, "slip": -0.5}, 0.7),
    "belt": (BELT, {"x": BELT.release_position(), "velocity": 0.2}, 10.0),
    "sprag-slip set 1": (SpragSlip.set_1(cth=0.5), {"th": 0.8, "thdot": 0.0}, 3.0),
    "sprag-slip set 2": (SpragSlip(), {"th": 0.8, "thdot": 0.0}, 3.0),
    "rocking block": (RockingBlock(), {"tilt": 0.1}, 3.0),
}


def last(model, state, t_end, rtol):
    sol = ns.simulate(model, (0, t_end), *state, integrator=ns.EventDriven(rtol, 1e-2 * rtol), every=1000)
    return sol.q[-1]


@pytest.mark.parametrize("scene", SCENES)
def test_error_stays_below_a_fifth_of_the_tolerance(scene):
    """Against rtol = 2e-13; that error is some 1e-14 of coordinates and 1e-13 where phases of 10 s run apart."""
    model, start, t_end = SCENES[scene]
    state = model.state(**start)
    reference = last(model, state, t_end, 2e-13)
    for rtol in (1e-4, 1e-6, 1e-9, 1e-11):
        error = np.abs(last(model, state, t_end, rtol) - reference).max()
        assert error < 0.2 * rtol + 1e-12


def random_scene(rng):
    """A model of random parameters, a start and a duration."""
    pick = rng.integers(8)
    if pick == 0:
        rod = PainleveRod(mu=rng.uniform(0.1, 3.0), e=rng.choice([0.0, 0.5, 1.0]))
        return rod, rod.state(th=rng.uniform(0.2, 2.9), thdot=4 * rng.normal(), slip=2 * rng.normal()), 0.3
    if pick == 1:
        rod = PainleveRod(mu=rng.uniform(0.1, 3.0), e=rng.choice([0.0, 0.5, 1.0]))
        q0, u0 = rod.state(th=rng.uniform(0.2, 2.9), thdot=4 * rng.normal(), slip=2 * rng.normal())
        return rod, (q0 + [0.0, rng.uniform(0.0, 0.2), 0.0], u0 + rng.normal(size=3)), 0.3
    if pick == 2:
        rod = SpragSlip(mu=rng.uniform(0.2, 1.6))
        return rod, rod.state(th=rng.uniform(0.3, 1.3), thdot=3 * rng.normal()), 2.0
    if pick == 3:
        rod = BilateralRod(mu=rng.uniform(0.1, 2.5))
        return rod, rod.state(th=rng.uniform(0.2, 1.4), thdot=4 * rng.normal(), slip=2 * rng.normal()), 0.3
    if pick == 4:
        block = RockingBlock(
            width=rng.uniform(0.1, 1.0), height=0.6, mu=rng.uniform(0.0, 1.5), e=rng.choice([0.0, 0.8])
        )
        q0, u0 = block.state(tilt=rng.uniform(-0.5, 0.5))
        return block, (q0 + [0.0, rng.uniform(0.0, 0.2), 0.0], u0 + rng.normal(size=3)), 1.5
    if pick == 5:
        screw = LeadScrew(mu=rng.uniform(0.05, 0.4))
        return screw, screw.state(), 0.3
    if pick == 6:
        pendulum = WallPendulum(th_w=rng.uniform(-0.5, 1.0), e=rng.uniform())
        return pendulum, pendulum.state(th=rng.uniform(1.05, 1.8)), 10.0
    chain = BeadChain(n=int(rng.integers(2, 14)), e=rng.uniform())
    return chain, chain.state(velocity=1.0), 0.5


def reaches_its_end(seed):
    """One random run; no gap is deeper than atol."""
    rng = np.random.default_rng(seed)
    model, start, t_end = random_scene(rng)
    rtol = 10.0 ** rng.uniform(-11, -3)
    rule = rng.choice(["compliant-limit", "impact", "lift-off"])
    sol = ns.simulate(
        model,
        (0, t_end),
        *start,
        integrator=ns.EventDriven(rtol, 1e-2 * rtol),
        selection=str(rule),
        on_failure="return",
    )
    return sol.success and np.isfinite(sol.q).all() and sol.g_N.min() > -1e-2 * rtol - 1e-12


def test_random_starts_reach_their_end():
    assert [seed for seed in range(80) if not reaches_its_end(seed)] == []


@pytest.mark.stress
def test_many_random_starts_reach_their_end():
    assert [seed for seed in range(100, 1700) if not reaches_its_end(seed)] == []
