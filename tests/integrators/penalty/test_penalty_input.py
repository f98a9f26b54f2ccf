"""What `Penalty` refuses, and in which words."""

import math

import pytest

import nonsmooth as ns
from models import BouncingBall, PainleveRod, SpragSlip
from tests.systems import ball


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"stiffness": 0.0}, "stiffness must be positive"),
        ({"stiffness": -1e6}, "stiffness must be positive"),
        ({"stiffness": math.nan}, "stiffness must be finite"),
        ({"damping": -1.0}, "damping must not be negative"),
        ({"damping_ratio": -0.1}, "damping_ratio must not be negative"),
        ({"damping": 1.0, "damping_ratio": 0.1}, "either damping or damping_ratio"),
        ({"mass": 1.0}, "mass belongs to damping_ratio"),
        ({"damping_ratio": 0.1, "mass": 0.0}, "mass must be positive"),
        ({"law": "clipt"}, "did you mean 'clipped'"),
        ({"law": "hunt-crossley", "damping_ratio": 0.1}, "no damping ratio"),
        ({"friction": "smooth"}, "friction must be 'coulomb' or Regularised"),
        ({"rtol": 1e-15}, "rtol must lie in"),
        ({"atol": 0.0}, "atol must be positive"),
    ],
)
def test_options_out_of_range_are_refused_by_name(options, words):
    with pytest.raises(ns.InvalidInput, match=words):
        ns.Penalty(**{"stiffness": 1e6, **options})


def test_velocity_scale_of_regularised_friction_must_be_positive():
    with pytest.raises(ns.InvalidInput, match="v_s must be positive"):
        ns.Regularised(v_s=0.0)


def test_contact_that_is_deeper_than_a_slip_of_the_pen_is_refused():
    rod = PainleveRod()
    q0, u0 = rod.state()
    q0[1] -= 0.1
    with pytest.raises(ns.InvalidInput, match="contact 0 is indented by 0.1 m at the start"):
        ns.simulate(rod, (0, 0.1), q0, u0, integrator=ns.Penalty(stiffness=1e6))
    sprag = SpragSlip()
    q0, u0 = sprag.state(th=0.85, thdot=0.0)
    q0[0] += 0.1
    with pytest.raises(ns.InvalidInput, match="contact 0 is indented by 0.1 m"):
        ns.simulate(sprag, (0, 0.1), q0, u0, integrator=ns.Penalty(stiffness=1e6))


def test_contact_at_its_static_depth_may_start_there_however_soft():
    ball = BouncingBall()
    k = 10.0
    solution = ns.simulate(ball, (0, 1.0), [-ball.m * ball.g / k], [0.0], integrator=ns.Penalty(stiffness=k))
    assert abs(solution.q[-1, 0] + ball.m * ball.g / k) < 1e-9


def test_stiffness_whose_oscillation_time_cannot_resolve_is_refused_with_the_cure():
    ball = BouncingBall()
    with pytest.raises(ns.InvalidInput, match="cannot be met in double precision.*smaller stiffness, or rtol >="):
        ns.simulate(ball, (0, 1.0), *ball.state(height=1.0), integrator=ns.Penalty(stiffness=1e24))


def force_until_0_3(t, q, u, p, h):
    h[0] = -9.81 + 0.0 * math.sqrt(0.3 - t)


def test_model_function_that_fails_is_named_at_the_time_it_fails():
    system = ball(ns.Contact(), force=force_until_0_3)
    with pytest.raises(ns.ModelFunctionError, match="force raised ValueError.*t = 0.3 s") as caught:
        ns.simulate(system, (0, 1.0), [1.0], [0.0], integrator=ns.Penalty(stiffness=1e6))
    assert abs(caught.value.t - 0.3) < 1e-12
    assert caught.value.solution.t[-1] <= 0.3
