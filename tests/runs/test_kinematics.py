"""Systems whose coordinates are not the integrals of their velocities: q' = B(q) u."""

from typing import NamedTuple

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.special import ellipj

import nonsmooth as ns
from nonsmooth.mechanics.system import NORMAL


class Top(NamedTuple):
    A: float = 1.0  # principal moments of inertia [kg m^2]
    B: float = 2.0
    C: float = 3.5


def mass(t, q, p, M):
    M[0, 0], M[1, 1], M[2, 2] = p.A, p.B, p.C


def force(t, q, u, p, h):
    h[0] = (p.B - p.C) * u[1] * u[2]
    h[1] = (p.C - p.A) * u[2] * u[0]
    h[2] = (p.A - p.B) * u[0] * u[1]


def turning(t, q, p, B):
    """The rate of a unit quaternion by the angular velocity in the body's axes."""
    B[0, 0], B[0, 1], B[0, 2] = -0.5 * q[1], -0.5 * q[2], -0.5 * q[3]
    B[1, 0], B[1, 1], B[1, 2] = 0.5 * q[0], -0.5 * q[3], 0.5 * q[2]
    B[2, 0], B[2, 1], B[2, 2] = 0.5 * q[3], 0.5 * q[0], -0.5 * q[1]
    B[3, 0], B[3, 1], B[3, 2] = -0.5 * q[2], 0.5 * q[1], 0.5 * q[0]


VELOCITIES = [("w_1", "rad/s"), ("w_2", "rad/s"), ("w_3", "rad/s")]
OMEGA = 0.3, 1.5, 0.2
LEVEL = [1.0, 0.0, 0.0, 0.0]


def a_top(**changes):
    given = {"coordinates": ["e_0", "e_1", "e_2", "e_3"], "velocities": VELOCITIES, "mass": mass, "force": force,
             "kinematics": turning, "parameters": Top(), "name": "top"}  # fmt: skip
    return ns.System(**given | changes)


def run(system, t_end, dt, **options):
    return ns.simulate(system, (0, t_end), LEVEL, OMEGA, integrator=ns.MoreauJean(dt=dt), **options)


def matrix_of(e):
    """The rotation of a quaternion."""
    w, v = e[0], e[1:]
    cross = np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])
    return np.eye(3) + 2 * w * cross + 2 * cross @ cross


def exact_turn(t_end):
    """Orientation and angular velocity of the top by an independent method, to 1e-12."""

    def rate(t, x):
        B, h = np.zeros((4, 3)), np.zeros(3)
        turning(t, x[:4], Top(), B)
        force(t, x[:4], x[4:], Top(), h)
        return np.concatenate([B @ x[4:], h / np.array(Top())])

    return solve_ivp(rate, (0, t_end), [*LEVEL, *OMEGA], method="DOP853", rtol=1e-13, atol=1e-13).y[:, -1]


def elliptic(t):
    """Euler's top with L^2 > 2 T B started at omega_2 = 0: Landau, Lifshitz, *Mechanics*, section 37."""
    A, B, C = Top()
    omega = np.array([0.5, 0.0, 1.5])
    T2, L2 = A * omega[0] ** 2 + C * omega[2] ** 2, (A * omega[0]) ** 2 + (C * omega[2]) ** 2
    assert L2 > B * T2
    tau = t * np.sqrt((C - B) * (L2 - T2 * A) / (A * B * C))
    sn, cn, dn, _ = ellipj(tau, (B - A) * (T2 * C - L2) / ((C - B) * (L2 - T2 * A)))
    scale = [(T2 * C - L2) / (A * (C - A)), (T2 * C - L2) / (B * (C - B)), (L2 - T2 * A) / (C * (C - A))]
    return omega, np.sqrt(scale) * np.array([cn, sn, dn])


def test_angular_velocities_of_a_free_top_are_elliptic_functions_to_second_order():
    start, end = elliptic(4.0)
    errors = [
        np.abs(ns.simulate(a_top(), (0, 4), LEVEL, start, integrator=ns.MoreauJean(dt=dt)).u[-1] - end).max()
        for dt in (0.02, 0.01, 0.005)
    ]
    assert errors[-1] < 1e-4
    np.testing.assert_allclose(np.log2(np.divide(errors[:-1], errors[1:])), 2.0, atol=0.1)


def test_orientation_of_a_free_top_is_of_second_order():
    end = exact_turn(4.0)
    errors = [np.abs(run(a_top(), 4.0, dt).q[-1] - end[:4]).max() for dt in (0.02, 0.01, 0.005)]
    assert errors[-1] < 1e-4
    np.testing.assert_allclose(np.log2(np.divide(errors[:-1], errors[1:])), 2.0, atol=0.1)


def test_unit_quaternions_stay_so_to_rounding():
    """2 roundings of each of four squares a step, at most as many steps as there are, adding up at worst."""
    sol = run(a_top(), 20.0, 0.02)
    drift = np.abs(np.linalg.norm(sol.q, axis=1) - 1.0)
    assert drift.max() < 8 * np.finfo(float).eps * sol.stats.steps


def test_angular_momentum_of_a_free_top_points_one_way():
    L = np.array(Top()) * OMEGA
    ends = []
    for dt in (0.01, 0.005):
        sol = run(a_top(), 5.0, dt)
        turned = np.array([matrix_of(q) @ (np.array(Top()) * u) for q, u in zip(sol.q, sol.u, strict=True)])
        ends.append(np.abs(turned - L).max())
    assert ends[1] < 1e-3 * np.linalg.norm(L)
    assert ends[0] / ends[1] == pytest.approx(4.0, rel=0.1)


def test_the_interpreter_takes_the_same_steps(monkeypatch):
    compiled = run(a_top(), 0.2, 0.01)
    monkeypatch.setenv("NONSMOOTH_INTERPRET", "1")
    assert run(a_top(), 0.2, 0.01).q.tobytes() == compiled.q.tobytes()


def test_coordinates_and_velocities_have_names_of_their_own(tmp_path):
    sol = run(a_top(), 0.1, 0.01)
    assert (sol["e_0"] == sol.q[:, 0]).all()
    assert (sol["w_3"] == sol.u[:, 2]).all()
    again = ns.Solution.load(sol.save(tmp_path / "top.npz"))
    assert (again["w_2"] == sol["w_2"]).all()
    assert np.array_equal(again(0.055).q, sol(0.055).q)
    assert ns.simulate(a_top(), (0, 0.1), state={"e_0": 1.0, "w_1": 0.3, "w_2": 1.5, "w_3": 0.2},
                       integrator=ns.MoreauJean(dt=0.01)).q.tobytes() == sol.q.tobytes()  # fmt: skip
    unnamed = run(a_top(coordinates=(), n_q=4, velocities=(), n_u=3), 0.1, 0.01)
    assert (unnamed["u[2]"] == sol["w_3"]).all()


def test_a_checkpoint_goes_on_to_the_same_bits(tmp_path):
    whole = run(a_top(), 1.0, 0.01)
    place = tmp_path / "top"
    with pytest.raises(ns.BudgetSpent):
        run(a_top(), 1.0, 0.01, checkpoint=place, max_steps=40)
    resumed = run(a_top(), 1.0, 0.01, resume=place)
    assert resumed.q.tobytes() == whole.q.tobytes()
    assert resumed(0.505).q.tobytes() == whole(0.505).q.tobytes()


def test_between_records_the_motion_is_of_second_order():
    errors = []
    for dt in (0.02, 0.01):
        sol = run(a_top(), 1.0, dt)
        t = 0.5 + dt / 2
        errors.append(np.abs(np.concatenate(sol(t)) - exact_turn(t)).max())
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.2)


def test_an_event_of_the_user_is_found_within_a_step():
    sol = run(a_top(), 3.0, 1e-3, events=lambda t, q, u: q[0])
    found = sol.t_events[0]
    assert len(found) >= 1
    assert abs(exact_turn(found[0])[0]) < 1e-5


def test_a_sweep_runs_in_compiled_blocks():
    start = {"e_0": 1.0, "w_1": 0.3, "w_2": 1.5, "w_3": 0.2}
    task = ns.RunTask(a_top(), t_span=(0, 1), state=start, integrator=ns.MoreauJean(dt=0.01))
    assert task.is_block
    found = ns.sweep(task, {"B": [1.5, 2.0]}, progress=False)
    assert found["q"].dims == ("B", "coordinate")
    assert found["u"].sel(rate="w_1").values[1] == run(a_top(), 1.0, 0.01)["w_1"][-1]
    assert np.array_equal(found["q"].values[1], run(a_top(), 1.0, 0.01).q[-1])


# A pendulum on a ball joint, whose point may meet a floor.


class Pendulum(NamedTuple):
    m: float = 2.0  # [kg], at a distance l of the joint
    l: float = 0.5  # [m]  # noqa: E741
    g: float = 9.81
    depth: float = 0.45  # [m] of a floor below the joint


def of_pendulum(name):
    def moments(t, q, p, M):
        M[0, 0], M[1, 1], M[2, 2] = p.m * p.l**2, p.m * p.l**2, 0.01

    def weights(t, q, u, p, h):
        down = -p.m * p.g * p.l
        h[0] = down * 2 * (q[2] * q[3] + q[0] * q[1]) - (0.01 - p.m * p.l**2) * u[1] * u[2]
        h[1] = -down * 2 * (q[1] * q[3] - q[0] * q[2]) - (p.m * p.l**2 - 0.01) * u[2] * u[0]

    def height(t, q, p, g_N):
        g_N[0] = p.depth - p.l * (q[0] ** 2 - q[1] ** 2 - q[2] ** 2 + q[3] ** 2)

    return {"mass": moments, "force": weights, "gap": height}[name]


def a_pendulum(**changes):
    given = {name: of_pendulum(name) for name in ("mass", "force", "gap")}
    given |= {"n_q": 4, "velocities": VELOCITIES, "kinematics": turning, "parameters": Pendulum(), "name": "pendulum",
              "contacts": [ns.Contact(e_N=0.5)]}  # fmt: skip
    return ns.System(**given | changes)


def test_the_normal_that_is_left_out_is_the_gradient_along_the_kinematics():
    """g_N = depth - l cos(angle): W_N u is its rate along q' = B u."""
    system, q = a_pendulum(), np.array([0.8, 0.6 * 0.8, 0.6 * 0.6, 0.0])
    W, B = system.evaluate(NORMAL, 0.0, q, np.zeros(3))[0], np.zeros((4, 3))
    turning(0.0, q, None, B)
    expected = -Pendulum().l * 2 * np.array([q[0], -q[1], -q[2], q[3]]) @ B
    np.testing.assert_allclose(W, expected, atol=1e-13)


@pytest.mark.upkeep
def test_a_pendulum_on_a_ball_joint_bounces_on_a_floor():
    tilt = 0.9  # rad, well above the floor
    q = [np.cos(tilt / 2), np.sin(tilt / 2), 0.0, 0.0]
    sol = ns.simulate(a_pendulum(), (0, 0.5), q, [0, 0, 0], integrator=ns.MoreauJean(dt=1e-4))
    impacts = [event for event in sol.events if event.kind == ns.EventKind.IMPACT]
    p = Pendulum()
    speed = np.sqrt(2 * p.g / p.l * (p.depth / p.l - np.cos(tilt)))  # of the angle at the floor
    assert impacts[0].gamma_N == pytest.approx(-p.l * speed * np.sqrt(1 - (p.depth / p.l) ** 2), rel=1e-3)
    assert sol.g_N.min() > -1e-3
    assert sol.ledger["normal"][-1] < 0.0


@pytest.mark.parametrize(("changes", "said"), [
    ({"velocities": (), "n_u": 3, "kinematics": None}, r"n_u must equal n_q .* kinematics="),
    ({"kinematics": 3.0}, "kinematics must be a function"),
    ({"kinematics": lambda t, q, B: None}, "kinematics"),
    ({"velocities": ["a", "b"], "n_u": 3}, "velocities must have 3 entries, one for each velocity of n_u; got 2"),
    ({"velocities": ["a", "a", "b"]}, "the velocity 'a' is named twice"),
])  # fmt: skip
def test_what_does_not_fit_is_refused_when_the_system_is_made(changes, said):
    with pytest.raises(ns.InvalidInput, match=said):
        a_top(**changes)


def test_velocities_need_kinematics():
    with pytest.raises(ns.InvalidInput, match="velocities= names those of q' = B u; give kinematics= too"):
        a_top(kinematics=None, velocities=["a", "b", "c", "d"])


def too_wide(t, q, p, B):
    B[0, 3] = 1.0


def wild(t, q, p, B):
    B[0, 0] = np.nan


def test_kinematics_of_a_wrong_shape_are_refused_before_the_run():
    with pytest.raises(ns.InvalidInput, match=r"kinematics raised .*writes an array of shape \(4, 3\)"):
        run(a_top(kinematics=too_wide), 0.1, 0.01)
    with pytest.raises(ns.InvalidInput, match="kinematics"):
        run(a_top(kinematics=lambda t, q, p: np.zeros((3, 3))), 0.1, 0.01)


def test_kinematics_that_are_no_numbers_end_the_run():
    with pytest.raises(ns.StepFailure, match="kinematics"):
        run(a_top(kinematics=wild), 0.1, 0.01)


def wrong_gradient(t, q, p, W_N):
    W_N[0, 0], W_N[0, 1] = 0.1, 0.2


def test_a_normal_that_contradicts_gap_and_kinematics_is_refused():
    q = [np.cos(0.5), np.sin(0.5), 0.0, 0.0]
    with pytest.raises(ns.InvalidInput, match=r"normal must be the gradient of gap.* along B\[:, \d\]"):
        ns.simulate(a_pendulum(normal=wrong_gradient), (0, 0.1), q, [0, 0, 0], integrator=ns.MoreauJean(dt=1e-3))


@pytest.mark.parametrize("ask", [
    lambda s: ns.limit_cycle(s, (0, 1), state=(LEVEL, OMEGA)),
    ns.linearise, ns.equilibrium,
])  # fmt: skip
def test_who_cannot_says_so_and_names_who_can(ask):
    who_can = r"MoreauJean\(dt=\.\.\.\) (and Adaptive )?simulate"
    with pytest.raises(ns.InvalidInput, match=rf"takes no system with kinematics .*; {who_can}"):
        ask(a_top())


@pytest.mark.parametrize("integrator", [ns.EventDriven(), ns.Adaptive(1e-5)])
def test_a_run_with_kinematics_is_read_back_with_its_motion_between_the_steps(integrator, tmp_path):
    sol = ns.simulate(a_top(), (0, 0.3), LEVEL, OMEGA, integrator=integrator)
    back = ns.Solution.load(sol.save(tmp_path / "top.npz"), a_top())
    t = np.linspace(0, 0.3, 17)
    np.testing.assert_array_equal(back(t).q, sol(t).q)
    np.testing.assert_array_equal(back(t).u, sol(t).u)


def test_auto_takes_order_five_where_nothing_touches():
    sol = ns.simulate(a_top(), (0, 1), LEVEL, OMEGA)
    assert sol.about["integrator"].startswith("EventDriven(rtol=1e-08") and "order 5" in sol.about["chosen"]
