"""Plain time stepping through the Génot–Brogliato point of the rod: what docs/theory/event_driven.md says of it."""

import math

import numpy as np

import nonsmooth as ns
from models import PainleveRod

T_END, SPEED = 0.05, 4.0  # s; rad/s, above the speed of the rod after the point


def test_moreau_jean_meets_the_impact_with_some_steps_only_and_converges_with_those():
    rod = PainleveRod(mu=2.0)
    start = rod.state(th=math.radians(34), thdot=2.0, slip=-6.0)
    exact = ns.simulate(rod, (0.0, T_END), *start, integrator=ns.EventDriven(1e-12, 1e-14)).q[-1, 2]
    steps = 10.0 ** np.random.default_rng(200).uniform(-5.0, -3.0, 200)
    met, missed = [], []
    for dt in steps:
        run = ns.simulate(rod, (0.0, T_END), *start, integrator=ns.MoreauJean(dt))
        error = abs(run.q[-1, 2] - exact)
        (met if any(e.kind == ns.EventKind.INCONSISTENT for e in run.paradoxes) else missed).append((dt, error))
    assert 0.4 <= len(met) / len(steps) <= 0.6  # NUMERICS section 5
    assert all(error < SPEED * dt for dt, error in met)  # the impact is placed to one step
    assert max(error for dt, error in missed if dt < 1e-4) > 0.01  # an error of order one at small steps too
