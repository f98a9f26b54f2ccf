"""Derivatives by a complex step: against closed forms and against the Jacobians that the models write themselves."""

from __future__ import annotations

import math
from math import exp

import numba
import numpy as np
import pytest

from models import BeltOscillator, FollowerForceArm, ModeCoupling, PainleveRod, SelfLockingRod, SpragSlip, WallPendulum
from nonsmooth.errors import InvalidInput
from nonsmooth.mechanics.system import DAMPING, FORCE, STIFFNESS
from nonsmooth.numerics.complex_step import complexified, jacobian

EPS = np.finfo(float).eps


def helper(x):
    return math.sin(x) * exp(-x)


@numba.njit
def compiled_helper(x):
    return math.sqrt(1.0 + x * x)


def branches(x):
    return abs(x[0]) + max(x[1], 0.0) + min(x[1], -2.0) + (x[0] ** 3 if x[0] < 0.0 else x[0])


CASES = [
    (lambda x: [math.atan2(x[1], x[0])], lambda a, b: [[-b / (a * a + b * b), a / (a * a + b * b)]]),
    (lambda x: [np.hypot(x[0], x[1])], lambda a, b: [[a / math.hypot(a, b), b / math.hypot(a, b)]]),
    (lambda x: [np.abs(x[0]) * math.fabs(x[1])], lambda a, b: [[-abs(b), -abs(a) if b < 0 else abs(a)]]),
    (lambda x: [math.copysign(x[0], x[1])], lambda a, b: [[-1.0 if b > 0 else 1.0, 0.0]]),
    (lambda x: [helper(x[0]), compiled_helper(x[1])],
     lambda a, b: [[(math.cos(a) - math.sin(a)) * exp(-a), 0], [0, b / math.sqrt(1 + b * b)]]),
    (lambda x: [math.tanh(x[0]) + np.sign(x[0]) * x[1], math.degrees(x[1])],
     lambda a, b: [[1 / math.cosh(a) ** 2, -1.0], [0.0, 180 / math.pi]]),
    (lambda x: [branches(x)], lambda a, b: [[-1 + 3 * a * a, 1.0 if b > 0 else 0.0]]),
]  # fmt: skip


@pytest.mark.parametrize("case", range(len(CASES)))
@pytest.mark.parametrize("b", [1.7, -0.4])
def test_derivative_of_a_function_is_exact_to_rounding(case, b):
    function, derivative = CASES[case]
    value, J = jacobian(complexified(function), np.array([-0.8, b]))
    np.testing.assert_allclose(J, derivative(-0.8, b), rtol=8 * EPS, atol=8 * EPS)
    np.testing.assert_allclose(value, function(np.array([-0.8, b])), rtol=8 * EPS)


@pytest.mark.parametrize("model", [
    BeltOscillator(), FollowerForceArm(), ModeCoupling(), PainleveRod(), SelfLockingRod(), SpragSlip(), WallPendulum(),
], ids=lambda model: model.name)  # fmt: skip
def test_jacobians_of_a_model_agree_with_those_it_writes_itself(model):
    system = model.system()
    rng = np.random.default_rng(3)
    q, u = rng.uniform(-1, 1, system.n_q), rng.uniform(-1, 1, system.n_u)
    force = complexified(system.functions[FORCE])
    for which, x in ((STIFFNESS, q), (DAMPING, u)):

        def h(z, which=which):
            out = np.zeros(system.n_u, complex)
            force(0.0, z if which == STIFFNESS else q, z if which == DAMPING else u, system.unpack(*system.p), out)
            return out

        own = system.evaluate(which, 0.0, q, u) if which in system.functions else np.zeros((q.size, q.size))
        J = jacobian(h, x)[1]
        if which in system.functions or which == DAMPING:
            np.testing.assert_allclose(-J, own, atol=20 * EPS * max(1.0, np.abs(J).max()))


def test_function_that_keeps_real_arrays_is_refused_instead_of_losing_the_derivative():
    def force(x):
        scratch = np.zeros(1)
        scratch[0] = x[0] ** 2
        return scratch

    with pytest.raises(InvalidInput, match="complex"):
        jacobian(complexified(force), np.array([1.0]))


@pytest.mark.parametrize("function", [
    lambda x: [math.log(x[0])], lambda x: [1.0 / x[0]], lambda x: [math.sqrt(x[0] - 1.0)],
])  # fmt: skip
def test_pole_or_argument_outside_the_domain_is_refused(function):
    with pytest.raises(InvalidInput, match="not smooth"):
        jacobian(complexified(function), np.array([0.0]))
