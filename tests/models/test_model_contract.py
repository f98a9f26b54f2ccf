"""What every model promises: its functions agree with one another, its states with its contacts, its checks refuse."""

from __future__ import annotations

import dataclasses
import inspect
import math

import numpy as np
import pytest

import models
from models import (
    BeadChain,
    BeltOscillator,
    BilateralRod,
    BilliardBall,
    BouncingBall,
    FollowerForceArm,
    InclinedBlock,
    LeadScrew,
    ModeCoupling,
    PainleveRod,
    RobotFinger,
    RockingBlock,
    SelfLockingRod,
    SliderCrank,
    SlidingBlock,
    SpatialPainleveRod,
    SpinningTop,
    SpragSlip,
    WallPendulum,
    Woodpecker,
)
from nonsmooth.errors import InvalidInput, UnknownName
from nonsmooth.jit import call_model, compile_model, kernel
from nonsmooth.mechanics.model_system import as_system
from nonsmooth.mechanics.system import (
    DAMPING,
    FORCE,
    GAP,
    KINEMATICS,
    MASS,
    NORMAL,
    POTENTIAL,
    ROW_RATES,
    STIFFNESS,
    SURFACE_VELOCITY,
    TAKES_U,
    TANGENT,
)

MODELS = [
    BeadChain(n=3),
    BeltOscillator(),
    BilateralRod(l=1.4, m=0.7, I=0.2),
    BilliardBall(m=0.7, R=0.3, mu=0.4, e=0.5),
    BouncingBall(),
    FollowerForceArm(P=0.0),  # with P the force has no potential
    InclinedBlock(alpha=0.4, F=0.7),
    ModeCoupling(),
    LeadScrew(m=1.3, I=0.7, r=0.8, lam=0.4, mu=0.5, R=2.0, cx=0.3),
    PainleveRod(l=1.4, m=0.7, I=0.2),
    RobotFinger(m1=0.7, m2=0.4, l1=0.6, l2=0.5, H=0.62, tau_psi=0.3, tau_1=-0.4, tau_2=0.2),
    RockingBlock(),
    SelfLockingRod(l=1.4, vb=-0.6),
    SliderCrank(),
    SlidingBlock(),
    SpatialPainleveRod(l=1.4, m=0.7, I=0.2),
    SpinningTop(m=0.7, A=0.3, C=0.5, h=0.4, r=0.1),
    SpragSlip(R=3.0),
    WallPendulum(l=1.4, th_w=0.2),
    Woodpecker(),
]
WITHOUT_GAP = (BeltOscillator, FollowerForceArm, ModeCoupling)
APART = (BouncingBall, BeadChain, SliderCrank, WallPendulum)  # their default state does not touch
IN_CONTACT = [m for m in MODELS if not isinstance(m, WITHOUT_GAP + APART)]
STEP = 1e-5  # central differences: truncation 1e-10, rounding 1e-11 of quantities of order 1


def name(model):
    return model.name


def sample(system):
    rng = np.random.default_rng(7)
    return rng.uniform(0.2, 0.9, system.n_q), rng.uniform(-2.0, 2.0, system.n_u)


def gradient(function, x):
    """d function/dx by central differences, the derivative's index last."""
    columns = []
    for j in range(x.size):
        step = np.zeros(x.size)
        step[j] = STEP
        columns.append((function(x + step) - function(x - step)) / (2 * STEP))
    return np.stack(columns, axis=-1)


def along(system, q):
    """B (n_q, n_u) with q' = B u."""
    return system.evaluate(KINEMATICS, 0.0, q, q) if KINEMATICS in system.functions else np.eye(system.n_q)


def close(actual, expected):
    np.testing.assert_allclose(actual, expected, rtol=1e-7, atol=1e-8 * (1 + np.abs(expected).max()))


def test_every_exported_model_is_tested_here():
    assert sorted(type(model).__name__ for model in MODELS) == sorted(models.__all__)
    assert set(models.__all__) <= set(dir(models))


def test_unknown_model_is_refused_with_the_known_ones():
    with pytest.raises(AttributeError, match="PainleveRod"):
        _ = models.PainleveRob


@pytest.mark.parametrize("model", MODELS, ids=name)
def test_model_is_accepted_as_a_system_with_finite_default_state(model):
    system = as_system(model)
    q0, u0 = model.state()
    assert q0.shape == (system.n_q,) and u0.shape == (system.n_u,)
    assert q0.dtype == u0.dtype == np.float64
    assert len(model.coordinates) == system.n_q
    assert model.t_end > model.dt > 0
    assert system.name == model.name and model.source
    assert as_system(model) is system  # hashable: the system is built once


@pytest.mark.parametrize("model", MODELS, ids=name)
def test_parameters_are_the_fields_and_nothing_else(model):
    system = model.system()
    numbers = [field.name for field in dataclasses.fields(model) if not isinstance(getattr(model, field.name), str)]
    assert list(system.parameter_values) == numbers
    with pytest.raises(UnknownName):
        system.with_parameters(no_such_parameter=1.0)


@pytest.mark.parametrize("model", [m for m in MODELS if not isinstance(m, WITHOUT_GAP)], ids=name)
def test_normal_row_is_the_gradient_of_the_gap(model):
    system = model.system()
    q, u = sample(system)
    slope = gradient(lambda q: system.evaluate(GAP, 0.0, q, u), q)
    close(system.evaluate(NORMAL, 0.0, q, u), slope @ along(system, q))


def contact_points(model, q):
    """Position of each contact point along its surface (n_c,)."""
    if isinstance(model, PainleveRod | BilateralRod):
        return np.array([q[0] - 0.5 * model.l * math.cos(q[2])])
    if isinstance(model, SelfLockingRod | SpragSlip):
        return np.array([-model.l * math.cos(q[-1])])
    if isinstance(model, LeadScrew):
        return np.array([q[0] * math.sin(model.lam) + model.r * q[1] * math.cos(model.lam)])
    if isinstance(model, InclinedBlock):
        return np.array([q[0] * math.cos(model.alpha) + q[1] * math.sin(model.alpha)])
    if isinstance(model, RockingBlock):
        corner = np.array([[-0.5, 0.5], [-0.5, -0.5]]) * np.array([[model.width], [model.height]])
        return q[0] + corner[0] * math.cos(q[2]) - corner[1] * math.sin(q[2])
    if isinstance(model, SliderCrank):
        across = np.array([-1.0, 1.0, -1.0, 1.0]) * model.a
        up = np.array([1.0, 1.0, -1.0, -1.0]) * model.b
        return model.slider_centre(q)[0] + across * math.cos(q[2]) - up * math.sin(q[2])
    if isinstance(model, Woodpecker):  # heights of the beak and of the two edges
        beak = q[0] + model.lM * q[1] + model.hS + (model.lG - model.lS) * q[2]
        return np.array([beak, q[0] + model.rM * q[1] - model.hM, q[0] + model.rM * q[1] + model.hM])
    return q[:1]


@pytest.mark.parametrize("model", [m for m in MODELS if m.system().d == 1], ids=name)
def test_tangential_row_is_the_velocity_of_the_contact_point(model):
    system = model.system()
    q, u = sample(system)
    close(system.evaluate(TANGENT, 0.0, q, u)[:, 0, :], gradient(lambda q: contact_points(model, q), q))


@pytest.mark.parametrize("model", [m for m in MODELS if m.system().n_c], ids=name)
def test_row_rates_are_the_rates_of_the_rows_along_the_motion(model):
    system = model.system()
    q, u = sample(system)

    def velocities(time):
        columns = []
        for which in (NORMAL, TANGENT):
            if which in system.functions:
                there = q + time * along(system, q) @ u
                W = system.evaluate(which, time, there, u).reshape(system.n_c, -1, system.n_u)
                columns.append(W @ u)
            elif which == NORMAL:
                columns.append(np.zeros((system.n_c, 1)))
        return np.concatenate(columns, axis=1)

    close(system.evaluate(ROW_RATES, 0.0, q, u), (velocities(STEP) - velocities(-STEP)) / (2 * STEP))


@pytest.mark.parametrize("model", MODELS, ids=name)
def test_force_at_rest_is_minus_the_gradient_of_the_potential(model):
    system = model.system()
    q, u = sample(system)
    slope = gradient(lambda q: system.evaluate(POTENTIAL, 0.0, q, u)[0], q)
    close(system.evaluate(FORCE, 0.0, q, 0 * u), -slope @ along(system, q))


@pytest.mark.parametrize("model", [m for m in MODELS if DAMPING in m.system().functions], ids=name)
def test_stiffness_and_damping_are_minus_the_jacobians_of_the_force(model):
    system = model.system()
    q, u = sample(system)
    close(system.evaluate(STIFFNESS, 0.0, q, u), -gradient(lambda q: system.evaluate(FORCE, 0.0, q, u), q))
    close(system.evaluate(DAMPING, 0.0, q, u), -gradient(lambda u: system.evaluate(FORCE, 0.0, q, u), u))


@pytest.mark.parametrize("model", MODELS, ids=name)
def test_mass_matrix_is_symmetric_positive_definite(model):
    system = model.system()
    M = system.evaluate(MASS, 0.0, *sample(system))
    assert (M == M.T).all() and np.linalg.eigvalsh(M).min() > 0


@pytest.mark.parametrize("model", IN_CONTACT, ids=name)
def test_default_state_touches_without_approaching(model):
    system = model.system()
    q0, u0 = model.state(th=model.th0) if isinstance(model, SelfLockingRod) else model.state()
    g_N, W_N = system.evaluate(GAP, 0.0, q0, u0), system.evaluate(NORMAL, 0.0, q0, u0)
    assert np.abs(g_N).min() <= 1e-15 * (1 + np.abs(q0).max())
    i = np.abs(g_N).argmin()
    assert abs(W_N[i] @ u0) <= 4e-16 * (np.abs(W_N[i]) @ np.abs(u0) + 1)


@pytest.mark.parametrize("model", [PainleveRod(), BilateralRod()], ids=name)
def test_tip_slips_at_the_given_velocity(model):
    q0, u0 = model.state(th=0.8, thdot=-3.0, slip=0.7)
    assert model.system().evaluate(TANGENT, 0.0, q0, u0)[0, 0] @ u0 == pytest.approx(0.7, abs=1e-14)


def test_sprag_slip_sliding_velocity_is_minus_the_literature_v_t():
    rod = SpragSlip()
    q0, u0 = rod.state(th=0.8, thdot=3.0)
    system = rod.system()
    gamma_F = system.evaluate(TANGENT, 0.0, q0, u0)[0, 0] @ u0 + system.evaluate(SURFACE_VELOCITY, 0.0, q0, u0)[0, 0]
    assert gamma_F == pytest.approx(-rod.v_t(0.8, 3.0), abs=1e-13)


@pytest.mark.parametrize("model", MODELS, ids=name)
def test_picture_is_a_list_of_plane_polylines(model):
    q0, _ = model.state()
    for line in [*model.shape(q0), *model.outline()]:
        assert line.ndim == 2 and line.shape[1] == 2 and np.isfinite(line).all()


@pytest.mark.parametrize("model", MODELS, ids=name)
def test_each_line_of_the_picture_has_a_name(model):
    q0, _ = model.state()
    assert len(model.parts) == len(set(model.parts)) == len(model.shape(q0))


PLACED = [m for m in MODELS if any(contact.at for contact in m.system().contacts)]


@pytest.mark.parametrize("model", PLACED, ids=name)
def test_contact_frames_move_as_the_rows_say(model):
    """Along its normal a contact point moves by the row W_N, along its tangent by W_F; of a bead by its own part."""
    system = model.system()
    q, u = sample(system)
    contact_frames = system.described.contact_frames
    points, normals, tangents = contact_frames(q)
    motion = gradient(lambda q: contact_frames(q)[0], q)  # (n_c, 2, n_q)
    assert points.shape == normals.shape == tangents.shape == (system.n_c, 2)
    np.testing.assert_allclose([n @ n for n in normals] + [t @ t for t in tangents], 1.0, atol=1e-15)
    np.testing.assert_allclose(np.sum(normals * tangents, axis=1), 0.0, atol=1e-15)
    if NORMAL in system.functions:
        W_N = system.evaluate(NORMAL, 0.0, q, u)
        own = np.eye(system.n_c, dtype=bool) if isinstance(model, BeadChain) else np.ones(W_N.shape, bool)
        close(np.einsum("kd,kdj->kj", normals, motion)[own], W_N[own])
    if TANGENT in system.functions:
        close(np.einsum("kd,kdj->kj", tangents, motion), system.evaluate(TANGENT, 0.0, q, u)[:, 0])


@pytest.mark.parametrize("model", [PainleveRod(), RockingBlock(), SpragSlip(), SelfLockingRod(th0=0.9)], ids=name)
def test_picture_touches_the_ground_where_the_gap_is_zero(model):
    q0, _ = model.state()
    assert min(line[:, 1].min() for line in model.shape(q0)) == pytest.approx(0.0, abs=1e-14)


@pytest.mark.parametrize("tilt", [0.4, -0.3])
def test_picture_of_a_block_turns_with_the_corner(tilt):
    block = RockingBlock(width=0.3)
    q0, _ = block.state(tilt=tilt)
    corners = block.shape(q0)[0][:2]
    np.testing.assert_allclose(corners[:, 1], block.system().evaluate(GAP, 0.0, q0, q0), atol=1e-15)
    np.testing.assert_allclose(corners[:, 0], contact_points(block, q0), atol=1e-15)


@kernel
def evaluate(model, which, t, q, u, p, out):
    return call_model(model, which, t, q, u, p, out)


# the functions of BilateralRod are those of PainleveRod
@pytest.mark.upkeep
@pytest.mark.parametrize("model", [m for m in MODELS if not isinstance(m, BilateralRod)], ids=name)
def test_compiled_functions_agree_with_the_interpreted_ones(model):
    system = model.system()
    functions = {which: (f, which in TAKES_U, system.shape_of(which)) for which, f in system.functions.items()}
    compiled = compile_model(functions, system.n_q, system.n_u, system.unpack, system.p.size)
    q, u = sample(system)
    for which in functions:
        out = np.zeros(system.shape_of(which))
        assert evaluate(compiled.address, which, 0.0, q, u, system.p, out.reshape(-1))
        # sin and cos of the two libraries may differ in the last place
        np.testing.assert_allclose(out, system.evaluate(which, 0.0, q, u), rtol=1e-14, atol=1e-14)


@pytest.mark.parametrize(
    "build",
    [
        lambda: BouncingBall(m=0.0),
        lambda: BouncingBall(e=1.1),
        lambda: BouncingBall(g="heavy"),
        lambda: BouncingBall().state(height=-1.0),
        lambda: BilliardBall(R=0.0),
        lambda: BilliardBall(mu=0.0),
        lambda: BilliardBall().state(speed=math.nan),
        lambda: SlidingBlock(mu=-0.1),
        lambda: SlidingBlock(m=-1.0),
        lambda: SlidingBlock().state(speed=math.inf),
        lambda: InclinedBlock(alpha=math.pi / 2),
        lambda: InclinedBlock(F=math.nan),
        lambda: BeltOscillator(k=0.0),
        lambda: BeltOscillator(N=-1.0),
        lambda: BeltOscillator(vb=0.2).averaged_amplitude(),
        lambda: BeltOscillator(law="cubbic"),
        lambda: BeltOscillator(law="two-coefficient", mu_k=0.5),
        lambda: BeltOscillator(vb=0.42, law="smoothed").averaged_amplitude(),
        lambda: BeltOscillator(vb=0.1, law="smoothed").averaged_rate(1.0),
        lambda: BeltOscillator(law="stribeck").averaged_rate(0.1),
        lambda: BeltOscillator(law="smoothed").release_position(),
        lambda: FollowerForceArm(m2=0.0),
        lambda: FollowerForceArm(th0=math.pi / 2).critical_loads(),
        lambda: ModeCoupling(kz=0.0),
        lambda: ModeCoupling(k=0.0).critical_friction(),
        lambda: ModeCoupling(k=0.0, kx=0.0).equilibrium(),
        lambda: PainleveRod(l=0.0),
        lambda: PainleveRod(e=2.0),
        lambda: PainleveRod(I=-1.0),
        lambda: PainleveRod().coefficients(1.0, 0.0, 0.0),
        lambda: PainleveRod(mu=0.5).impact_without_collision(),
        lambda: PainleveRod().impact_without_collision(slip=1.0),
        lambda: PainleveRod().impact_without_collision(law="elastic"),
        lambda: BilateralRod(m=math.nan),
        lambda: SelfLockingRod(th0=math.pi / 2),
        lambda: SelfLockingRod(R=-1.0),
        lambda: SelfLockingRod(vb=0.0).normal_force(),
        lambda: SpinningTop(A=1.0, C=2.5),
        lambda: SpinningTop(r=-0.1),
        lambda: RobotFinger(H=1.0),
        lambda: RobotFinger().state(th2=math.nan),
        lambda: SpragSlip(kth=-1.0),
        lambda: SpragSlip(l=0.0),
        lambda: SpragSlip().reduced(0.8, branch=0),
        lambda: SpragSlip().state(th=math.nan),
        lambda: SliderCrank(l2=0.1),
        lambda: SliderCrank(c=0.0),
        lambda: Woodpecker(rM=0.0025),
        lambda: Woodpecker(e2=1.5),
        lambda: RockingBlock(width=0.0),
        lambda: RockingBlock().fall_time(tilt=0.3),
        lambda: BeadChain(n=0),
        lambda: BeadChain(n=2.5),
        lambda: BeadChain(gap=-1e-3),
        lambda: WallPendulum(th_w=2.0),
        lambda: WallPendulum().impact_times(2, th=4.0),
        lambda: WallPendulum(th_w=0.5).impact_times(2, th=3.0),
    ],
)
def test_values_out_of_range_are_refused(build):
    with pytest.raises(InvalidInput):
        build()


@pytest.mark.parametrize("model", [m for m in MODELS if hasattr(m, "natural_state")], ids=name)
def test_natural_state_takes_the_variables_in_the_order_of_state(model):
    names = [key for key in inspect.signature(model.state).parameters]
    s = np.random.default_rng(3).uniform(0.2, 0.9, len(names))
    x = np.zeros(2 * len(model.coordinates))
    model.natural_state(0.0, s, model, x)
    q, u = model.state(**dict(zip(names, s.tolist(), strict=True)))
    np.testing.assert_array_equal(x, np.concatenate([q, u]))


def test_models_that_propose_a_map_have_its_axes():
    proposed = [m for m in MODELS if hasattr(m, "map_axes")]
    assert len(proposed) >= 4
    for model in proposed:
        known = {*inspect.signature(model.state).parameters, *model.system().parameter_values}
        assert all(axis in known and low < high for axis, low, high in model.map_axes)
