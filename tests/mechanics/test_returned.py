"""Model functions that return their values: the motion is that of functions that write them."""

import warnings
from typing import NamedTuple

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.mechanics.signatures import returns_values
from nonsmooth.mechanics.system import FORCE, GAP, MASS, NORMAL, TANGENT

with warnings.catch_warnings():
    warnings.simplefilter("ignore", DeprecationWarning)  # of mpmath, whose names SymPy reads
    import sympy as sp


class P(NamedTuple):
    m: float = 1.3
    l: float = 0.7
    g: float = 9.81


def mass(t, q, p, M):
    M[0, 0], M[1, 1] = p.m, p.m * p.l**2


def force(t, q, u, p, h):
    h[0], h[1] = -p.m * p.g, -p.m * p.l * np.sin(q[1]) - u[0]


def gap(t, q, p, g_N):
    g_N[0] = q[0] - p.l * np.cos(q[1])


def tangent(t, q, p, W_F):
    W_F[0, 0, 1] = p.l


def system(**changes):
    functions = {"mass": mass, "force": force, "gap": gap, "tangent": tangent} | changes
    return ns.System(n_q=2, contacts=[ns.Contact(mu=0.3, e_N=0.2)], parameters=P(), **functions)


def lambdified():
    t, m, l, g, x, th, xd, thd = sp.symbols("t m l g x theta xd thetad")
    q, u, p = (x, th), (xd, thd), (m, l, g)
    return {
        "mass": sp.lambdify((t, q, p), sp.Matrix([[m, 0], [0, m * l**2]])),
        "force": sp.lambdify((t, q, u, p), sp.Matrix([-m * g, -m * l * sp.sin(th) - xd])),
        "gap": sp.lambdify((t, q, p), [x - l * sp.cos(th)]),
        "tangent": sp.lambdify((t, q, p), sp.Matrix([[0, l]])),
    }


def arrays():
    def inertia(t, q, p):
        M = np.zeros((2, 2))
        M[0, 0], M[1, 1] = p.m, p.m * p.l**2
        return M

    return {
        "mass": inertia,
        "force": lambda t, q, u, p: (-p.m * p.g, -p.m * p.l * np.sin(q[1]) - u[0]),
        "gap": lambda t, q, p: q[0] - p.l * np.cos(q[1]),
        "tangent": lambda t, q, p: [[0.0, p.l]],
    }


@pytest.mark.upkeep
@pytest.mark.parametrize("functions", [lambdified, arrays])
def test_motion_of_functions_that_return_is_that_of_functions_that_write(functions):
    given = {"q0": [1.0, 0.4], "u0": [0.0, 0.3], "integrator": ns.MoreauJean(dt=1e-3)}
    written = ns.simulate(system(), (0, 1), **given)
    returned = ns.simulate(system(**functions()), (0, 1), **given)
    assert (np.diff(written.u[:, 0]) > 0.1).any()  # an impact
    np.testing.assert_allclose(returned.q, written.q, rtol=0, atol=1e-13)  # some 1000 steps of a few roundings


def test_functions_with_branches_and_unequal_rows_return_their_entries():
    level = 2.0

    def inertia(t, q, p):
        if q[0] > level:
            return [[p.m, 0], [0, 1]]
        return np.array([[1, 0], (0, p.m)])

    made = system(mass=inertia)
    u = np.zeros(2)
    np.testing.assert_array_equal(made.evaluate(MASS, 0.0, np.array([3.0, 0.0]), u), np.diag([1.3, 1.0]))
    np.testing.assert_array_equal(made.evaluate(MASS, 0.0, np.array([1.0, 0.0]), u), np.diag([1.0, 1.3]))
    level = 0.0
    np.testing.assert_array_equal(made.evaluate(MASS, 0.0, np.array([1.0, 0.0]), u), np.diag([1.3, 1.0]))


def test_normal_of_a_returned_gap_is_exact():
    made, q = system(**lambdified()), np.array([1.0, 0.4])
    W_N = made.evaluate(NORMAL, 0.0, q, np.zeros(2))
    np.testing.assert_allclose(W_N, [[1.0, 0.7 * np.sin(0.4)]], rtol=4e-16)
    assert made.name_of(NORMAL) == "gap"


def test_columns_and_rows_of_sympy_have_the_shapes_of_forces_and_rows():
    made, q, u = system(**lambdified()), np.array([1.0, 0.4]), np.array([0.2, 0.1])
    for which in (MASS, FORCE, GAP, TANGENT):
        np.testing.assert_allclose(made.evaluate(which, 0.0, q, u), system().evaluate(which, 0.0, q, u), rtol=4e-16)
    assert not made.reads(TANGENT, "t")
    assert made.reads(FORCE, "u")
    assert not system(force=lambda t, q, u, p: np.array([p.g, q[0]])[:]).reads(FORCE, "u")


def refused(message, **changes):
    with pytest.raises(ns.InvalidInput, match=message):
        ns.simulate(system(**changes), (0, 0.1), [1.0, 0.4], [0.0, 0.3], integrator=ns.MoreauJean(dt=1e-2))


@pytest.mark.upkeep
def test_other_shapes_and_nothing_returned_are_refused():
    def nothing(t, q, u, p):
        h = np.zeros(2)
        h[0] = 1.0

    def sometimes(t, q, u, p):
        if q[0] < 0.0:
            return [0.0, 0.0]
        return None

    refused(r"mass returns an array of shape \(2,\); it must have the shape \(2, 2\)", mass=lambda t, q, p: [p.m, 1.0])
    refused(r"force returns an array of shape \(\); it must have the shape \(2,\)", force=lambda t, q, u, p: 0.0)
    refused(r"tangent returns an array of shape \(2, 1\)|tangent returns an array of shape \(3,\)",
            tangent=lambda t, q, p: [1.0, 2.0, 3.0])  # fmt: skip
    refused("force returns nothing; it must return an array", force=sometimes)
    refused(r"force must take \(t, q, u, p, out\)", force=nothing)


def test_function_that_numba_refuses_is_named_with_its_line():
    def refused_by_numba(t, q, u, p):
        return np.linalg.multi_dot([np.eye(2), np.ones(2)])

    made = system(force=refused_by_numba)
    with pytest.warns(ns.InterpretedWarning, match=r"at line \d+ of test_returned.py, ``return np.linalg.multi_dot"):
        ns.simulate(made, (0, 0.02), [1.0, 0.4], [0.0, 0.3], integrator=ns.MoreauJean(dt=1e-2))


def test_functions_without_a_value_are_told_from_those_with_one():
    def value(t):
        return t

    def leaves(t):
        if t > 0:
            return
        print(t)

    assert returns_values(value)
    assert not returns_values(leaves)
    assert returns_values(lambda t: [t])
    assert returns_values(print)  # in doubt
