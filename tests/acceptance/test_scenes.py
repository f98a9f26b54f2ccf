"""The scenes on which other programs were measured: at the same step the error is within 5 % of Siconos's, or better.

The error is the mean distance to the closed form over 2001 samples, positions interpolated linearly between the steps.
"""

import numpy as np
import pytest

import nonsmooth as ns
from models import BouncingBall, SlidingBlock

SICONOS = {  # Siconos 4.4.0, Moreau-Jean, at dt = 1e-2, 1e-3, 1e-4
    "ball": (4.4e-3, 9.5e-4, 3.3e-5),
    "block": (1.9e-5, 2.4e-7, 7.9e-10),
}
SCENES = {
    "ball": (BouncingBall(e=0.5), 2.0, lambda model, t: model.height(t)),
    "block": (SlidingBlock(mu=0.3), 1.0, lambda model, t: model.position(t)),
}


def mean_error(scene, dt):
    model, t_end, exact = SCENES[scene]
    solution = ns.simulate(model, (0, t_end), *model.state(), integrator=ns.MoreauJean(dt=dt))
    t = np.linspace(0, t_end, 2001)
    return np.abs(np.interp(t, solution.t, solution.q[:, 0]) - [exact(model, moment) for moment in t]).mean()


@pytest.mark.parametrize("scene", SCENES)
def test_error_at_the_same_step_is_no_worse_than_siconos(scene):
    errors = [mean_error(scene, dt) for dt in (1e-2, 1e-3, 1e-4)]
    assert (np.array(errors) <= 1.05 * np.array(SICONOS[scene])).all()
