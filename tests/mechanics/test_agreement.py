"""Functions of a model that contradict one another are refused by name; those that only have kinks are not."""

import dataclasses
import math
from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import nonsmooth as ns
from models import (
    BeadChain,
    BeltOscillator,
    FollowerForceArm,
    LeadScrew,
    ModeCoupling,
    PainleveRod,
    RockingBlock,
    SliderCrank,
    SpragSlip,
    WallPendulum,
    Woodpecker,
)
from nonsmooth.mechanics import inspection
from nonsmooth.mechanics.agreement import (
    DIFFERENCE_STEPS,
    PLACES_ON_LINE,
    contradiction,
    doubt_of_potential,
    wrong_entry,
)

INTEGRATORS = [ns.MoreauJean(dt=1e-3), ns.Adaptive(), ns.EventDriven(), ns.Penalty(1e4, damping_ratio=0.1), "auto"]


class P(NamedTuple):
    m: float = 2.0  # mass [kg]
    k: float = 30.0  # stiffness [N/m]
    c: float = 0.7  # damping [N s/m]
    a: float = 0.1  # amplitude of the floor [m]
    w: float = 60.0  # its frequency [1/s]


def mass(t, q, p, M):
    M[0, 0] = p.m
    M[1, 1] = p.m


def force(t, q, u, p, h):
    h[0] = -p.k * q[0] - p.c * u[0] + 0.2 * p.k * q[1]
    h[1] = -9.81 * p.m + 0.2 * p.k * q[0]


def stiffness(t, q, u, p, K):
    K[0, 0] = p.k
    K[0, 1] = K[1, 0] = -0.2 * p.k


def damping(t, q, u, p, C):
    C[0, 0] = p.c


def potential(t, q, p, V):
    V[0] = 0.5 * p.k * q[0] * q[0] - 0.2 * p.k * q[0] * q[1] + 9.81 * p.m * q[1]


def gap(t, q, p, g_N):
    g_N[0] = q[1] - p.a * math.sin(p.w * t) - 0.3 * math.cos(q[0])


def normal(t, q, p, W_N):
    W_N[0, 0] = 0.3 * math.sin(q[0])
    W_N[0, 1] = 1.0


def gap_rate(t, q, p, w_N):
    w_N[0] = -p.a * p.w * math.cos(p.w * t)


def tangent(t, q, p, W_F):
    W_F[0, 0, 0] = 1.0
    W_F[0, 0, 1] = -0.3 * math.sin(q[0])


def surface_velocity(t, q, p, w_F):
    w_F[0, 0] = -0.4 * math.cos(3.0 * t)


def row_rates(t, q, u, p, r):
    turn = 0.3 * math.cos(q[0]) * u[0]
    r[0, 0] = turn * u[0] + p.a * p.w * p.w * math.sin(p.w * t)
    r[0, 1] = -turn * u[1] + 1.2 * math.sin(3.0 * t)


FUNCTIONS = {
    "mass": mass, "force": force, "stiffness": stiffness, "damping": damping, "potential": potential, "gap": gap,
    "normal": normal, "gap_rate": gap_rate, "tangent": tangent, "surface_velocity": surface_velocity,
    "row_rates": row_rates,
}  # fmt: skip
START = [0.4, 1.0], [0.3, -0.2]


def block(**changes):
    """A mass above a shaken, curved floor, in every function different from zero."""
    given = {"parameters": P()} | FUNCTIONS | changes
    return ns.System(n_q=2, contacts=[ns.Contact(mu=0.2, name="tip")], **given)


def scaled(name, factor, entry=None):
    """A function of the block, all of it or one entry times a factor."""
    right = FUNCTIONS[name]

    def with_u(t, q, u, p, out):
        right(t, q, u, p, out)
        out[entry if entry is not None else ...] *= factor

    def without_u(t, q, p, out):
        right(t, q, p, out)
        out[entry if entry is not None else ...] *= factor

    return {name: with_u if right.__code__.co_argcount == 5 else without_u}


def transposed(t, q, u, p, K):
    K[0, 0] = p.k
    K[0, 1] = -0.2 * p.k


def lopsided(t, q, p, M):
    M[0, 0] = M[1, 1] = p.m
    M[0, 1] = 0.1 * t


CONTRADICTIONS = [
    (scaled("normal", -1.0), r"normal must be the gradient of gap: of tip it writes W_N\[0, 0\] = -0.1168.*"
     r"g_N\[0\] changes by 0.1168.* for each unit of q\[0\]: its sign is turned.*leave normal out"),
    (scaled("normal", 1.001, (0, 1)), r"W_N\[0, 1\] = 1.001, where g_N\[0\] changes by 1 for each unit of q\[1\];"),
    (scaled("normal", 0.0, (0, 0)), r"W_N\[0, 0\] = 0, where"),
    (scaled("gap_rate", -1.0), r"gap_rate must be the rate of gap with time: of tip it writes w_N\[0\] = 6 m/s.*"
     r"-6 m/s at fixed q: its sign is turned.*leave gap_rate out"),
    (scaled("row_rates", -1.0, (0, 0)), r"row_rates must be W_N' u \+ w_N': of tip it writes r\[0, 0\]"),
    (scaled("row_rates", 2.0, (0, 1)), r"row_rates must be W_F' u \+ w_F'.*tangent and surface_velocity"),
    (scaled("stiffness", -1.0), r"stiffness must be K = -dh/dq: it writes K\[0, 0\] = -30, where h\[0\] changes by -30 "
     r"for each unit of q\[0\]: its sign is turned"),
    ({"stiffness": transposed}, r"K\[1, 0\] = 0, where h\[1\] changes by 6 for each unit of q\[0\]"),
    (scaled("damping", -1.0), r"damping must be C = -dh/du: it writes C\[0, 0\] = -0.7.*leave damping out"),
    (scaled("damping", 0.0), r"C\[0, 0\] = 0, where h\[0\] changes by -0.7"),
    (scaled("tangent", -1.0), r"row_rates must be W_F' u \+ w_F'"),
]  # fmt: skip


@pytest.mark.parametrize(("changes", "message"), CONTRADICTIONS)
def test_a_function_that_contradicts_another_is_refused_at_the_start_by_name_with_both_values(changes, message):
    with pytest.raises(ns.InvalidInput, match=message) as refusal:
        inspection.inspect_start(block(**changes), 0.0, *map(np.array, START))
    assert "\n" not in str(refusal.value) and "t = 0 s" in str(refusal.value)


def test_a_model_whose_functions_agree_is_taken():
    assert contradiction(block(), 0.3, *map(np.array, START)) == ""


def test_a_potential_of_the_wrong_sign_is_a_warning_with_the_work_of_the_force():
    with pytest.warns(ns.NonsmoothWarning, match=r"rises by -15\.4966.*the sign of potential is wrong.*unless"):
        inspection.inspect_start(block(**scaled("potential", -1.0)), 0.0, *map(np.array, START))
    assert doubt_of_potential(block(), 0.0, *map(np.array, START)) == ""


def test_a_force_that_happens_to_be_the_gradient_of_the_potential_is_taken_without_a_word():
    """A spring k = 1 N/m pulls at x = 0.5 m with -0.5 N, and 1 N drives it at t = 0: the sum is +dV/dx there."""

    def driven(t, q, u, p, h):
        h[0] = -q[0] + math.cos(2.0 * t)

    def pushed(t, q, u, p, h):
        h[0] = -q[0] + 1.0

    def energy(t, q, p, V):
        V[0] = 0.5 * q[0] * q[0]

    for force in (driven, pushed):
        spring = ns.System(n_q=1, mass=lambda t, q, p, M: M.fill(1.0), force=force, potential=energy)
        sol = ns.simulate(spring, (0, 0.1), [0.5], [0.0], integrator=ns.MoreauJean(dt=1e-2))
        assert sol.status == ns.Status.FINISHED


def test_a_lift_of_twice_the_weight_is_a_warning_and_runs():
    """Nothing in h = 2 m g - m g and V = m g y tells that model from one whose sign was turned."""

    def lifted(t, q, u, p, h):
        h[0] = 2.0 * 9.81 - 9.81

    def energy(t, q, p, V):
        V[0] = 9.81 * q[0]

    balloon = ns.System(n_q=1, mass=lambda t, q, p, M: M.fill(1.0), force=lifted, potential=energy)
    with pytest.warns(ns.NonsmoothWarning, match="unless forces outside it are -2 dV/dq everywhere"):
        sol = ns.simulate(balloon, (0, 1), [0.0], [0.0], integrator=ns.MoreauJean(dt=1e-2))
    assert abs(sol.u[-1, 0] - 9.81) < 1e-12


@pytest.mark.parametrize("integrator", INTEGRATORS, ids=lambda integrator: str(integrator).split("(")[0])
def test_every_integrator_refuses_a_row_with_the_wrong_sign_before_it_steps(integrator, monkeypatch):
    monkeypatch.setenv("NONSMOOTH_INTERPRET", "1")  # spares the compilation of what is refused
    for _ in range(3):  # again, and once more
        with pytest.raises(ns.InvalidInput, match="normal must be the gradient of gap"):
            ns.simulate(block(**scaled("normal", -1.0)), (0, 1), *START, integrator=integrator)


def test_classify_maps_and_sweeps_refuse_it_too():
    rod = PainleveRod().system()

    def turned(t, q, p, W_N):
        W_N[0, 1] = -1.0
        W_N[0, 2] = 0.5 * p.l * math.cos(q[2])

    wrong = dataclasses.replace(rod, normal=turned)
    with pytest.raises(ns.InvalidInput, match="normal must be the gradient of gap"):
        ns.classify(wrong, 0.0, *PainleveRod().state())
    with pytest.raises(ns.InvalidInput, match="normal must be the gradient of gap"):
        ns.paradox_map(wrong, th=[0.5, 1.0], mu=[0.5, 2.0], state=lambda th: PainleveRod().state(th=th))
    q0, u0 = PainleveRod().state()
    task = ns.RunTask(wrong, t_span=(0, 0.01), integrator=ns.MoreauJean(1e-3), state={"q0": q0, "u0": u0})
    found = ns.sweep(task, {"mu": [0.2, 0.5]}, progress=False)
    assert (found.status == int(ns.Status.FINISHED)).sum() == 0
    assert "normal must be the gradient of gap" in str(found.attrs) + str(found)


# Contradictions that show on the way -------------------------------------------------------------------------------


def late(t, q, p, W_N):
    W_N[0, 0] = 0.3 * math.sin(q[0])
    W_N[0, 1] = 1.0 if t < 0.05 else -1.0


@pytest.mark.parametrize("integrator", INTEGRATORS[:4], ids=lambda integrator: type(integrator).__name__)
def test_a_contradiction_on_the_way_ends_a_short_run_with_what_was_computed(integrator):
    with pytest.raises(ns.ModelFunctionError, match=r"normal must be.*W_N\[0, 1\] = -1, .*stopped at t = ") as failure:
        ns.simulate(block(normal=late), (0, 0.1), [0.4, 3.0], [0.3, -0.2], integrator=integrator)
    solution = failure.value.solution
    assert solution.status == ns.Status.CONTRADICTED and len(solution.t) > 1
    assert np.isfinite(solution.q).all() and solution.t[-1] > 0.05


def test_a_long_run_is_looked_at_on_its_way():
    solution = ns.simulate(
        block(normal=late), (0, 1e4), [0.4, 3.0], [0.3, -0.2], integrator=ns.MoreauJean(1e-3), every=1000,
        on_failure="return",
    )  # fmt: skip
    assert solution.status == ns.Status.CONTRADICTED and 0.05 < solution.t[-1] < 1e3


def test_a_mass_matrix_that_loses_its_symmetry_is_named():
    with pytest.raises(ns.ModelFunctionError, match=r"mass matrix must be symmetric: mass writes M\[0, 1\] = 0.01, M"):
        ns.simulate(block(mass=lopsided), (0, 0.1), [0.4, 3.0], [0.3, 0.0], integrator=ns.MoreauJean(1e-3))


def test_a_gap_that_moves_gets_its_rate_where_gap_rate_is_forgotten():
    given = {"row_rates": None, "parameters": P(a=0.02, w=20.0)}
    right, forgotten = (
        ns.simulate(system, (0, 1.5), [0.4, 1.0], [0.3, 0.0], integrator=ns.EventDriven(1e-10, 1e-12))
        for system in (block(**given), block(**given, gap_rate=None))
    )
    assert len(right.events) > 3 and len(right.events) == len(forgotten.events)
    assert np.abs(right.q[-1] - forgotten.q[-1]).max() < 1e-11


# How often ---------------------------------------------------------------------------------------------------------


def test_a_system_is_looked_at_ever_more_rarely(monkeypatch):
    looks = []
    monkeypatch.setattr("nonsmooth.mechanics.inspection.contradiction", lambda *state: looks.append(state[1]) or "")
    system = block()
    for _ in range(64):
        ns.simulate(system, (0, 0.01), *START, integrator=ns.MoreauJean(1e-3))
    assert len(looks) == 14  # the 1st, 2nd, 4th, ... 64th start, and as many ends
    ns.simulate(dataclasses.replace(system, parameters=P(c=0.0)), (0, 0.01), *START, integrator=ns.MoreauJean(1e-3))
    assert len(looks) == 16  # parameters of other signs


# Functions that are not smooth ---------------------------------------------------------------------------------------


def on_line(f):
    """The values of a scalar function at the five places."""
    return lambda h: ([float(f(h * place))] for place in PLACES_ON_LINE)


@settings(max_examples=300, deadline=None)
@given(
    kink=st.one_of(st.just(0.0), st.floats(-12, 0).map(lambda x: 10**x), st.floats(-12, 0).map(lambda x: -(10**x))),
    slope=st.floats(-10, 10), change=st.floats(-1e4, 1e4), jump=st.sampled_from([0.0, 0.0, 1.0, -30.0]),
    curvature=st.floats(-10, 10), value=st.floats(-10, 10),
)  # fmt: skip
def test_a_kink_or_a_jump_wherever_it_is_contradicts_no_derivative(kink, slope, change, jump, curvature, value):
    def f(s):
        return value + slope * s + curvature * s * s + (change * (s - kink) + jump if s > kink else 0.0)

    one_sided = {slope, slope + change} if kink == 0.0 else {slope + change * (kink < 0.0)}
    for derivative in one_sided:
        assert wrong_entry(on_line(f), [derivative], [abs(derivative)], 1.0) is None


@settings(max_examples=300, deadline=None)
@given(
    length=st.floats(-6, 3).map(lambda x: 10**x), slope=st.floats(0.1, 10), phase=st.floats(0, 6),
    error=st.sampled_from([-2.0, -1.0, 1.0, 0.1, 1e-3]),
)  # fmt: skip
def test_a_wrong_derivative_of_a_smooth_function_is_contradicted_at_every_length_scale(length, slope, phase, error):
    def f(s):
        return slope * (s + 0.3 * length * math.sin(s / length + phase))

    derivative = slope * (1.0 + 0.3 * math.cos(phase))
    written = derivative * (1.0 + error)
    wrong = wrong_entry(on_line(f), [written], [abs(written)], length)
    assert wrong is not None and abs(wrong.found - derivative) < 1e-2 * derivative
    assert wrong_entry(on_line(f), [derivative], [abs(derivative)], length) is None


def test_a_ripple_as_short_as_one_step_is_no_contradiction():
    def f(s):  # twice its length is a step, which does not see it
        return s + math.sin(4.0 * math.pi * s / DIFFERENCE_STEPS[0])

    derivative = 1.0 + 4.0 * math.pi / DIFFERENCE_STEPS[0]
    assert wrong_entry(on_line(f), [derivative], [derivative], 0.0) is None


def dry(t, q, u, p, h):
    h[0] = -0.3 * math.copysign(1.0, u[0]) if u[0] != 0.0 else 0.0
    h[1] = -9.81 * p.m - 1e4 * min(q[1], 0.0) - 1e3 * (abs(q[0]) - 1e-6 if abs(q[0]) > 1e-6 else 0.0)


def no_damping(t, q, u, p, C):
    C[0, 0] = 0.0


def springs(t, q, u, p, K):
    K[1, 1] = 1e4 if q[1] < 0.0 else 0.0
    K[1, 0] = 1e3 * math.copysign(1.0, q[0]) if abs(q[0]) > 1e-6 else 0.0


def wedge(t, q, p, g_N):
    g_N[0] = q[1] - 0.5 * abs(q[0]) + 0.1 * max(q[0] - 0.3, 0.0)


def sides(t, q, p, W_N):
    W_N[0, 0] = -0.5 * math.copysign(1.0, q[0]) + (0.1 if q[0] > 0.3 else 0.0)
    W_N[0, 1] = 1.0


@pytest.mark.parametrize("x", [0.0, 1e-9, -1e-7, 1e-6, 5e-5, 0.3, 0.3 + 1e-5, -0.4])
@pytest.mark.parametrize("speed", [0.0, 1e-8, -1e-5, 0.7])
def test_dry_friction_springs_with_play_and_edges_are_no_contradiction(x, speed):
    system = ns.System(
        n_q=2, mass=mass, force=dry, damping=no_damping, stiffness=springs, gap=wedge, normal=sides,
        contacts=[ns.Contact()], parameters=P(),
    )  # fmt: skip
    for y in (0.0, 1e-7, -1e-5, 0.5):
        assert contradiction(system, 0.0, np.array([x, y]), np.array([speed, 0.0])) == ""


@pytest.mark.parametrize(
    "model",
    [BeadChain(n=3), BeltOscillator(), FollowerForceArm(), LeadScrew(), ModeCoupling(), PainleveRod(), RockingBlock(),
     SliderCrank(), SpragSlip(), WallPendulum(), Woodpecker()],
    ids=lambda model: model.name,
)  # fmt: skip
def test_no_model_contradicts_itself_at_states_of_any_size(model):
    system, rng = model.system(), np.random.default_rng(5)
    for size in 10.0 ** rng.uniform(-9, 2, 40):
        q, u = size * rng.standard_normal((2, system.n_q))
        assert contradiction(system, rng.uniform(-10, 10), q, u) == doubt_of_potential(system, 0.0, q, u) == ""
