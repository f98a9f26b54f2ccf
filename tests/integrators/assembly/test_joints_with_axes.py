"""Hinges, sliders and their like against an integrator of their equations, closed forms, invariants, other scenes."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

import nonsmooth as ns

G = 9.81
DTS = (4e-3, 2e-3)
EPS = np.finfo(float).eps
AT, AXIS = np.array([0.3, 0.1, -0.2]), np.array([1.0, 2.0, 2.0]) / 3
AXIS_B = np.array([2.0, 1.0, -2.0]) / 3  # at right angles to it
KINDS = ("joint", "hinge", "slider", "cylindrical", "universal", "fix", "planar", "slot")


def run(scene, t_end, dt, **options):
    return ns.simulate(scene, (0, t_end), integrator=ns.MoreauJean(dt=dt), **options)


def is_of_second_order(errors, within=0.15):
    assert abs(math.log2(errors[-2] / errors[-1]) - 2) < within, errors


def with_joint(scene, kind, a, b, at=AT, **options):
    more = {"joint": {}, "fix": {}, "universal": {"axis": AXIS, "axis_b": AXIS_B}}.get(kind, {"axis": AXIS})
    return getattr(scene, kind)(a, b, at=at, **more, **options)


# --- an integrator of the equations of two bodies in space: accelerations from multipliers


MASSES = np.array([1.0, 2.0])
MOMENTS = np.array([[0.02, 0.05, 0.06], [0.09, 0.04, 0.11]])
PLACES = np.array([[0.0, 0.0, 0.0], [0.5, 0.3, -0.3]])
STARTS = np.array([[0.3, -0.2, 0.1, 1.0, -2.0, 0.5], [0.1, 0.2, -0.3, -1.0, 1.5, 2.0]])


def violations(kind, x, R):
    """What a joint holds, of many places (m, 2, 3) and rotations (m, 2, 3, 3) from the start."""
    first, second = (x[:, b] + np.einsum("mxy,y->mx", R[:, b], AT - PLACES[b]) for b in range(2))
    gap = second - first
    frame = np.array([AXIS, AXIS_B, np.cross(AXIS, AXIS_B)])
    e, f, g = (np.einsum("mxy,y->mx", R[:, 0], axis) for axis in frame)
    e_b, f_b = (np.einsum("mxy,y->mx", R[:, 1], axis) for axis in frame[:2])

    def dot(a, b):
        return (a * b).sum(axis=1)

    point, turn = list(gap.T), [dot(f, e_b), dot(g, e_b)]
    held = {
        "joint": point, "hinge": point + turn, "slider": [dot(f, gap), dot(g, gap), *turn, dot(g, f_b)],
        "cylindrical": [dot(f, gap), dot(g, gap), *turn], "universal": [*point, dot(e, f_b)],
        "fix": [*point, *turn, dot(g, f_b)], "planar": [dot(e, gap), *turn], "slot": [dot(f, gap), dot(g, gap)],
    }  # fmt: skip
    return np.stack(held[kind], axis=1)


STENCIL = np.array([-2, -1, 1, 2]) * 1e-3


def moved(x, R, v):
    """Places and rotations a little along velocities (k, 12), at the four points of a stencil each."""
    ways = (STENCIL[:, None, None] * v).reshape(-1, 2, 6)
    turns = Rotation.from_rotvec(ways[:, :, 3:].reshape(-1, 3)).as_matrix().reshape(-1, 2, 3, 3)
    return x + ways[:, :, :3], turns @ R


def rows_and_curvature(kind, x, R, v):
    """J, and the second derivative of what is held along a steady motion, by differences of fourth order."""
    found = violations(kind, *moved(x, R, np.eye(12))).reshape(4, 12, -1)
    J = np.einsum("s,skr->rk", np.array([1, -8, 8, -1]) / 12e-3, found)
    along = violations(kind, *moved(x, R, v[None])).reshape(4, -1)
    here = violations(kind, x[None], R[None])[0]
    return J, (np.array([-1, 16, 16, -1]) @ along - 30 * here) / 12e-6


def masses_at(R):
    M = np.zeros((12, 12))
    for b in range(2):
        M[6 * b : 6 * b + 3, 6 * b : 6 * b + 3] = MASSES[b] * np.eye(3)
        M[6 * b + 3 : 6 * b + 6, 6 * b + 3 : 6 * b + 6] = R[b] @ np.diag(MOMENTS[b]) @ R[b].T
    return M


def fitted(kind):
    """The start, made to fit the joint by the least impulse."""
    R, v = np.tile(np.eye(3), (2, 1, 1)), STARTS.ravel()
    J, _ = rows_and_curvature(kind, PLACES, R, v)
    W = np.linalg.solve(masses_at(R), J.T)
    return v - W @ np.linalg.solve(J @ W, J @ v)


def exact(kind, t_end):
    """Centres, rotations and velocities at the end."""

    def rates(t, y):
        x, v = y[:6].reshape(2, 3), y[24:]
        R = y[6:24].reshape(2, 3, 3)
        M, (J, curvature) = masses_at(R), rows_and_curvature(kind, x, R, v)
        h = np.tile(np.array([0, 0, -G, 0, 0, 0]), 2) * np.repeat(MASSES, 6)
        for b in range(2):
            omega = v[6 * b + 3 : 6 * b + 6]
            h[6 * b + 3 : 6 * b + 6] = -np.cross(omega, M[6 * b + 3 : 6 * b + 6, 6 * b + 3 : 6 * b + 6] @ omega)
        K = np.block([[M, J.T], [J, np.zeros((len(J), len(J)))]])
        a = np.linalg.solve(K, np.concatenate((h, -curvature)))[:12]
        turning = np.cross(np.repeat(v.reshape(2, 6)[:, None, 3:], 3, axis=1), R.transpose(0, 2, 1)).transpose(0, 2, 1)
        return np.concatenate((v.reshape(2, 6)[:, :3].ravel(), turning.ravel(), a))

    start = np.concatenate((PLACES.ravel(), np.tile(np.eye(3), (2, 1, 1)).ravel(), fitted(kind)))
    return solve_ivp(rates, (0, t_end), start, method="DOP853", rtol=1e-9, atol=1e-10).y[:, -1]


def tumbling_on(kind, g=0.0):
    """Two bodies of which one tumbles about the other."""
    scene, v = ns.Scene(gravity=(0, 0, -g)), fitted(kind).reshape(2, 6)
    for b in range(2):
        scene.body(
            ns.Sphere(0.3), mass=MASSES[b], inertia=MOMENTS[b], position=PLACES[b], velocity=v[b, :3], spin=v[b, 3:],
            name=f"{b}",
        )  # fmt: skip
    with_joint(scene, kind, "0", "1")
    return scene


@pytest.mark.parametrize("kind", KINDS)
def test_two_tumbling_bodies_on_a_joint_follow_their_equations_to_second_order(kind):
    t_end = 0.5
    end = exact(kind, t_end)
    errors = []
    for dt in DTS:
        sol = run(tumbling_on(kind, G), t_end, dt)
        turns = [Rotation.from_quat(sol.turn[-1, b], scalar_first=True).as_matrix() for b in range(2)]
        found = np.concatenate((sol.position[-1].ravel(), np.ravel(turns)))
        speeds = np.concatenate((sol.velocity[-1], sol.spin[-1]), axis=1).ravel()
        errors.append(max(np.abs(found - end[:24]).max(), np.abs(speeds - end[24:]).max()))
        assert sol.stats.missed == 0 and sol.stats.worst_joint_drift < 1e-10
        work = sol.ledger["kinetic"] + sol.ledger["potential"]
        assert np.ptp(work) < 20 * dt**2
    is_of_second_order(errors)


@pytest.mark.parametrize("kind", KINDS)
def test_joined_bodies_keep_their_momentum_and_to_second_order_the_angular_one(kind):
    def turned(dt):
        sol = run(tumbling_on(kind), 0.5, dt)
        momentum = np.einsum("b,tbk->tk", MASSES, sol.velocity)
        assert np.abs(momentum - momentum[0]).max() < 500 * 16 * EPS
        R = np.array([[Rotation.from_quat(q, scalar_first=True).as_matrix() for q in now] for now in sol.turn])
        own = np.einsum("tbxy,by,tbzy,tbz->tbx", R, MOMENTS, R, sol.spin)
        L = (MASSES[:, None] * np.cross(sol.position, sol.velocity) + own).sum(axis=1)
        return np.abs(L - L[0]).max()

    losses = [turned(dt) for dt in DTS]
    assert losses[-1] < 1e-12 or math.log2(losses[0] / losses[1]) > 1.8


# --- closed forms


def test_a_slider_runs_down_its_incline_and_the_joint_says_what_holds_it():
    slope, m, arm = 0.4, 3.0, 0.2
    along = np.array([math.cos(slope), 0, -math.sin(slope)])
    up = np.array([math.sin(slope), 0, math.cos(slope)])
    scene = ns.Scene(gravity=(0, 0, -G))
    scene.fixed(ns.Sphere(0.01), name="rail")
    scene.body(ns.Box(0.1, 0.1, 0.1), mass=m, position=arm * up, name="cart")
    scene.slider("rail", "cart", at=(0, 0, 0), axis=2.0 * along, name="way")
    dt = 1e-2
    sol = run(scene, 1.0, dt)
    way = 0.5 * G * math.sin(slope) * sol.t**2
    np.testing.assert_allclose(sol["cart"].position, arm * up + way[:, None] * along, atol=1e-13)
    np.testing.assert_allclose(
        sol.joint_impulses[1:, 0] / dt, np.tile(m * G * math.cos(slope) * up, (100, 1)), atol=1e-9
    )
    # the weight has a component along the way on an arm from the point that the joint acts at, which goes with the cart
    moment = np.cross(arm * up, (0, 0, -m * G)) + np.cross(arm * up, -m * G * math.sin(slope) * along)
    np.testing.assert_allclose(sol.joint_torques[1:, 0] / dt, np.tile(-moment, (100, 1)), atol=1e-9)


def test_a_rotor_in_a_hinge_on_a_turntable_takes_the_gyroscopic_torque():
    """I spin about the axle and Omega across it: the torque of the hinge is Omega x I spin."""
    omega, spin, I = 0.7, 30.0, 0.05
    torques = []
    for dt in (2e-3, 1e-3):
        scene = ns.Scene(gravity=(0, 0, 0))
        scene.kinematic(ns.Sphere(0.01), position=(0, 0, -1), spin=(0, 0, omega), name="table")
        scene.body(ns.Sphere(0.1), mass=1.0, inertia=(I, 0.03, 0.03), spin=(spin, 0, omega), name="rotor")
        scene.hinge("table", "rotor", at=(0, 0, 0), axis=(1, 0, 0), name="axle")
        sol = run(scene, 0.5, dt)
        np.testing.assert_allclose(np.linalg.norm(sol["rotor"].spin, axis=1), math.hypot(spin, omega), rtol=1e-4)
        middle = omega * (sol.t[-1] - dt / 2)
        exact = omega * I * spin * np.array([-math.sin(middle), math.cos(middle), 0])
        torques.append(np.abs(sol.joint_torques[-1, 0] / dt - exact).max())
    is_of_second_order(torques, 0.4)


@pytest.mark.upkeep
def test_a_universal_joint_hands_on_the_rate_of_cardans_formula():
    """Hinges at both shafts, and a joint between: three rows too many."""
    bend, rate = 0.6, 2.0
    shaft = np.array([math.cos(bend), math.sin(bend), 0])
    errors = []
    for dt in (4e-3, 2e-3):
        scene = ns.Scene(gravity=(0, 0, 0))
        scene.fixed(ns.Sphere(0.01), position=(0, 0, -2), name="frame")
        scene.kinematic(ns.Sphere(0.05), position=(-1, 0, 0), spin=(rate, 0, 0), name="driver")
        driven = rate * math.cos(bend)  # with the axis of the driver at right angles to both shafts
        scene.body(ns.Sphere(0.05), mass=1.0, position=shaft, spin=driven * shaft, name="driven")
        scene.hinge("frame", "driven", at=shaft, axis=shaft)
        scene.universal("driver", "driven", at=(0, 0, 0), axis=(0, 0, 1), axis_b=np.cross((0, 0, 1), shaft))
        sol = run(scene, 2.0, dt)
        phi = rate * sol.t
        exact = rate * math.cos(bend) / (1 - math.sin(bend) ** 2 * np.sin(phi) ** 2)
        errors.append(np.abs(sol["driven"].spin @ shaft - exact).max())
        assert sol.stats.missed == 0 and sol.stats.worst_joint_drift < 1e-6
    is_of_second_order(errors, 0.3)


def bricards_linkage():
    """Five rods of 1 m and 1 kg on six hinges, each across its rods (IFToMM A04)."""
    corners = np.array([[0, 0, 0], [1, 0, 0], [1, -1, 0], [1, -1, 1], [0, -1, 1], [0, 0, 1]], float)
    axes = np.array([[0, 1, 0], [0, 0, 1], [1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 0, 0]], float)
    scene = ns.Scene(gravity=(0, -G, 0))
    scene.fixed(ns.Sphere(0.01), name="0")
    for k in range(5):
        way = corners[k + 1] - corners[k]
        size = np.where(way != 0, 1.0, 0.1)
        scene.body(ns.Box(*size), mass=1.0, position=(corners[k] + corners[k + 1]) / 2, name=f"{k + 1}")
    for k in range(6):
        scene.hinge(f"{k}", f"{(k + 1) % 6}", at=corners[k], axis=axes[k])
    return scene


def test_bricards_linkage_moves_although_its_rows_say_one_thing_twice_and_keeps_its_energy():
    """30 rows on 30 velocities, and one freedom."""
    swings = []
    for dt in (4e-3, 2e-3):
        sol = run(bricards_linkage(), 2.0, dt)
        E = sol.ledger["kinetic"] + sol.ledger["potential"]
        swings.append(np.ptp(E))
        assert sol.stats.missed == 0 and np.ptp(sol["3"].position[:, 0]) > 1.5
        assert sol.stats.worst_joint_drift < 1e-10
        assert np.abs(sol.joint_impulses / dt).max() < 40  # [N]: a rod weighs 10 N; rigid rows had 1e7
    assert swings[1] < 0.3 * swings[0] and swings[1] < 2e-5


def test_a_fast_top_elsewhere_leaves_a_loop_of_joints_as_soft_as_it_is_alone():
    """What turns fast somewhere else says nothing of how a machine moves."""
    scene = bricards_linkage()
    inertia = np.diag([1.0, 2.0, 2.5])
    scene.body(ns.Sphere(0.1), mass=1.0, inertia=inertia, position=(9, 0, 0), spin=(300, 20, 20), name="top")
    near, alone = run(scene, 0.4, 4e-3), run(bricards_linkage(), 0.4, 4e-3)
    assert np.array_equal(near.joint_impulses, alone.joint_impulses)


@pytest.mark.parametrize("dim", [2, 3])
def test_windows_of_four_bars_go_through_their_flat_position_where_their_rows_are_dependent(dim):
    """Two windows of rods of 1 m and 1 kg, upright, pushed at 1 m/s (IFToMM A02): one angle from upright for all."""

    def point(x, y):
        return (x, y) if dim == 2 else (x, y, 0.0)

    def rod(scene, name, place, velocity, spin):  # small, so that no rod touches another where all lie flat
        inertia, spin = (1 / 12, spin) if dim == 2 else ((1 / 12,) * 3, (0, 0, spin))
        shape = ns.Disc(0.05) if dim == 2 else ns.Sphere(0.05)
        scene.body(shape, mass=1.0, inertia=inertia, position=place, velocity=velocity, spin=spin, name=name)

    axis = {} if dim == 2 else {"axis": (0, 0, 1)}
    upright, flat = 3 * 1 / 3 + 2 * 1.0, 3 * 0.5 + 2 * 1.0  # inertia [kg m^2] and arm [kg m] of all
    exact = solve_ivp(
        lambda t, y: [y[1], flat * G * math.sin(y[0]) / upright], (0, 2.5), [0, 1.0], rtol=1e-11, atol=1e-12
    ).y[:, -1]  # fmt: skip
    assert exact[0] > 1.5 * math.pi  # twice through the flat position
    errors = []
    for dt in DTS:
        scene = ns.Scene(gravity=point(0, -G))
        scene.fixed(ns.Disc(0.01) if dim == 2 else ns.Sphere(0.01), name="ground")
        for k in range(3):
            rod(scene, f"crank {k}", point(k, 0.5), point(0.5, 0), -1.0)
            scene.hinge("ground", f"crank {k}", at=point(k, 0), name=f"low {k}", **axis)
        for k in range(2):
            rod(scene, f"coupler {k}", point(k + 0.5, 1), point(1.0, 0), 0.0)
            for side in range(2):
                scene.hinge(f"crank {k + side}", f"coupler {k}", at=point(k + side, 1), **axis)
        sol = run(scene, 2.5, dt)
        did = sol.joint("low 1")
        errors.append(max(abs(-did.angle[-1] - exact[0]), abs(-did.angle_rate[-1] - exact[1])))
        E = sol.ledger["kinetic"] + sol.ledger["potential"]
        assert sol.stats.missed == 0 and np.abs(E - E[0]).max() < 2e-3 * (dt / 1e-3) ** 2
    assert errors[-1] < 1e-3 and math.log2(errors[0] / errors[1]) > 1.8


def test_a_chain_of_hinges_hangs_still_and_a_fixed_one_carries_its_moment():
    scene, dt = ns.Scene(gravity=(0, 0, -G)), 2e-3
    scene.fixed(ns.Sphere(0.01), name="0")
    for k in range(1, 21):
        scene.body(ns.Box(0.02, 0.02, 0.08), mass=0.1, position=(0, 0, -0.1 * k + 0.05), name=f"{k}")
        scene.hinge(f"{k - 1}", f"{k}", at=(0, 0, -0.1 * (k - 1)), axis=(1, 0, 0) if k % 2 else (0, 1, 0))
    sol = run(scene, 2.0, dt)
    assert (sol.position == sol.position[0]).all() and sol.stats.missed == 0
    np.testing.assert_allclose(sol.joint_impulses[-1, :, 2] / dt, 0.1 * G * np.arange(20, 0, -1), rtol=1e-9)
    beam = ns.Scene(gravity=(0, -G))
    beam.fixed(ns.Disc(0.01), position=(0, -1), name="wall")
    for k in range(10):
        beam.body(ns.Box(0.1, 0.02), mass=0.1, position=(0.1 * k + 0.05, 0), name=f"{k}")
        beam.fix("wall" if k == 0 else f"{k - 1}", f"{k}", at=(0.1 * k, 0))
    sol = run(beam, 2.0, dt)
    # each step is solved to a part of 1e-8 of its impulses, whose drift the position pass takes back
    assert np.abs(sol.position - sol.position[0]).max() < 1e-9 and sol.stats.missed == 0
    left = np.arange(10, 0, -1)
    np.testing.assert_allclose(sol.joint_impulses[-1, :, 1] / dt, 0.1 * G * left, rtol=1e-6)
    np.testing.assert_allclose(sol.joint_torques[-1] / dt, 0.1 * G * left * 0.05 * left, rtol=1e-6)


# --- plane and space


@pytest.mark.parametrize("kind", ["hinge", "slider", "fix", "slot"])
def test_a_joint_of_the_plane_is_that_of_space(kind):
    """Two links that hang on a hinge and swing; they turn by maps that differ by dt^3 in a step."""

    def swung(dim, dt):
        def point(x, y):
            return (x, y) if dim == 2 else (x, y, 0.0)

        scene = ns.Scene(gravity=point(0, -G))
        scene.fixed(ns.Disc(0.01) if dim == 2 else ns.Sphere(0.01), name="hook")
        for k, x in enumerate((0.25, 0.8)):
            box = ns.Box(0.5, 0.1) if dim == 2 else ns.Box(0.5, 0.1, 0.1)
            inertia = 0.03 if dim == 2 else (0.02, 0.03, 0.03)
            scene.body(box, mass=1.0 + k, inertia=inertia, position=point(x, 0.0), name=f"{k}")
        axis = {"axis": point(0.6, 0.8)} if kind in ("slider", "slot") else {}
        turn = {"axis": (0, 0, 1)} if dim == 3 else {}
        scene.hinge("hook", "0", at=point(0, 0), **turn)
        getattr(scene, kind)("0", "1", at=point(0.5, 0), **(axis or (turn if kind == "hinge" else {})))
        if dim == 3 and kind == "slot":  # which lets the bodies turn: held in the plane
            scene.planar("hook", "1", axis=(0, 0, 1))
        sol = run(scene, 0.5, dt)
        assert sol.stats.missed == 0
        return sol.position[-1, 1:, :2]

    errors = [np.abs(swung(2, dt) - swung(3, dt)).max() for dt in DTS]
    assert errors[-1] < 1e-12 or math.log2(errors[0] / errors[1]) > 1.8


# --- threads, checkpoints, what is refused


def four_bars():
    """Two cranks and a coupler on four hinges in space: three rows say what others do."""
    l, start = 0.5, 0.7
    way = l * np.array([math.sin(start), 0, -math.cos(start)])
    turn = (math.cos(start / 2), 0, -math.sin(start / 2), 0)
    scene = ns.Scene(gravity=(0, 0, -G))
    scene.fixed(ns.Sphere(0.01), name="hook")
    for k, x in enumerate((-0.5, 0.5)):
        position = np.array([x, 0, 0]) + way / 2
        scene.body(ns.Box(0.02, 0.04, l), mass=0.4, position=position, turn=turn, name=f"crank {k}")
    scene.body(ns.Box(1.0, 0.04, 0.02), mass=1.0, position=way, name="coupler")
    for k, x in enumerate((-0.5, 0.5)):
        scene.hinge("hook", f"crank {k}", at=(x, 0, 0), axis=(0, 1, 0), name=f"low {k}")
        scene.hinge(f"crank {k}", "coupler", at=np.array([x, 0, 0]) + way, axis=(0, 1, 0), name=f"high {k}")
    return scene


def test_four_bars_on_hinges_have_their_one_freedom():
    l, m_c, m = 0.5, 0.4, 1.0
    of_crank = m_c * (l**2 + 0.02**2) / 12 + m_c * l**2 / 4
    stiffness, inertia = (m_c + m) * G * l, 2 * of_crank + m * l**2
    exact = solve_ivp(
        lambda t, y: [y[1], -stiffness / inertia * math.sin(y[0])], (0, 1), [0.7, 0], rtol=1e-11, atol=1e-12
    ).y[0, -1]
    errors = []
    for dt in DTS:
        sol = run(four_bars(), 1.0, dt)
        x, y, z = sol["coupler"].position.T
        errors.append(abs(math.atan2(x[-1], -z[-1]) - exact))
        assert np.abs(y).max() < 1e-12 and np.abs(sol["coupler"].spin).max() < 1e-4 and sol.stats.missed == 0
    is_of_second_order(errors, 0.1)


# --- places of joints over many steps


def holds_its_places(scene, steps, dt=1e-3):
    """A run whose joints are never off by more than 1e-10 m."""
    sol = run(scene, steps * dt, dt, every=steps // 200)
    assert sol.stats.missed == 0 and sol.stats.worst_joint_drift < 1e-10
    return sol


def conserved(sol):
    return sol.ledger["kinetic"] + sol.ledger["potential"]


@pytest.mark.upkeep
@pytest.mark.parametrize("kind", KINDS)
def test_joints_hold_their_places_for_a_hundred_thousand_steps(kind):
    sol = holds_its_places(tumbling_on(kind), 100_000)
    x, R = sol.position, Rotation.from_quat(sol.turn.reshape(-1, 4), scalar_first=True).as_matrix()
    far = np.abs(x).max()  # they fly off, and places are rounded
    assert np.abs(violations(kind, x, R.reshape(-1, 2, 3, 3))).max() < 1e-10 + 64 * EPS * far
    E = conserved(sol)
    assert np.ptp(E) < 1e-5 * E[0]
    momentum = np.einsum("b,tbk->tk", MASSES, sol.velocity)
    assert np.abs(momentum - momentum[0]).max() < 1e-12


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_joints_hold_their_places_for_a_million_steps(kind):
    E = conserved(holds_its_places(tumbling_on(kind), 1_000_000))
    assert np.ptp(E) < 1e-5 * E[0]


@pytest.mark.upkeep
@pytest.mark.parametrize("dim", [2, 3])
def test_a_pendulum_and_a_slider_hold_their_places_in_the_plane_and_in_space(dim):
    scene, flat = ns.Scene(gravity=(0,) * (dim - 1) + (-G,)), (0,) * (dim - 2)
    shape = ns.Box(0.4, *(0.1,) * (dim - 1))
    scene.fixed(ns.Disc(0.01) if dim == 2 else ns.Sphere(0.01), name="hook")
    scene.body(shape, mass=1.0, position=(0.2, *flat, 0), name="arm")
    scene.body(shape, mass=2.0, position=(0.6, *flat, 0), name="carriage")
    scene.joint("hook", "arm", at=(0,) * dim)
    scene.slider("arm", "carriage", axis=(0,) * (dim - 1) + (1,), limits=(-0.1, 0.2))
    E = conserved(holds_its_places(scene, 20_000))
    assert np.isfinite(E).all() and E[-1] < 1e-6  # the limits of the slider take energy, and nothing gives any


@pytest.mark.upkeep
def test_loops_hold_their_places():
    sol = holds_its_places(four_bars(), 20_000)
    assert np.ptp(conserved(sol)) < 1e-4 * np.ptp(sol.ledger["potential"])


@pytest.mark.parametrize("turn", [0.1, 0.3])
def test_joints_hold_their_places_where_bodies_turn_far_in_a_step(turn):
    scene, dt = ns.Scene(gravity=(0, 0)), 1e-2
    scene.fixed(ns.Disc(0.01), name="hook")
    scene.body(ns.Disc(0.1), mass=1.0, position=(1.0, 0), velocity=(0, turn / dt), spin=turn / dt, name="bob")
    scene.joint("hook", "bob", at=(0, 0))
    sol = holds_its_places(scene, 10_000, dt)
    assert np.abs(np.linalg.norm(sol["bob"].position, axis=1) - 1.0).max() < 1e-10


def test_places_are_held_beside_contacts_that_stay_closed():
    scene = ns.Scene(gravity=(0, -G), material=ns.Material(mu=0.2))
    scene.fixed(ns.HalfPlane((0, 1)), name="ground")
    scene.body(ns.Box(0.4, 0.4), mass=5.0, position=(0, 0.2), velocity=(3.0, 0), name="cart")
    scene.body(ns.Disc(0.1), mass=1.0, position=(0.8, 0.6), velocity=(3.0, 0), name="bob")
    scene.joint("cart", "bob", at=(0, 0.6))
    sol = holds_its_places(scene, 4000)
    assert sol.stats.worst_penetration < 1e-6 and np.ptp(sol["cart"].turn) > 0.1  # it tips, and falls back


def test_bits_do_not_depend_on_threads_and_a_run_is_resumed(tmp_path):
    whole = run(four_bars(), 0.5, 1e-3)
    assert (run(four_bars(), 0.5, 1e-3, threads=2).position == whole.position).all()
    place = tmp_path / "run.npz"
    run(four_bars(), 0.5, 1e-3, checkpoint=place, max_steps=123, on_failure="return")
    resumed = run(four_bars(), 0.5, 1e-3, checkpoint=place, resume=place)
    for name in ("position", "velocity", "joint_impulses", "joint_torques"):
        assert (getattr(resumed, name) == getattr(whole, name)).all()


def a_and_b(dim=3):
    scene = ns.Scene(gravity=(0,) * (dim - 1) + (-G,))
    shape = ns.Disc(0.1) if dim == 2 else ns.Sphere(0.1)
    scene.fixed(shape, name="a")
    scene.fixed(shape, position=(5,) * dim, name="c")
    scene.body(shape, mass=1.0, position=(1,) * dim, name="b")
    return scene


@pytest.mark.parametrize(
    ("dim", "kind", "options", "message"),
    [
        (3, "hinge", {"axis": (0, 0, 0)}, "axis of door must have a length"),
        (3, "hinge", {}, "axis of door is missing; give 3 numbers"),
        (3, "hinge", {"axis": (0, math.nan, 1)}, "axis of door"),
        (2, "hinge", {"axis": (0, 1)}, "door turns in the plane, about no other axis; leave out axis="),
        (2, "slider", {"axis": (0, 0, 1)}, "axis of door must have 2 entries"),
        (2, "universal", {"axis": (0, 1), "axis_b": (1, 0)}, "door is a universal joint, which is one of space"),
        (2, "planar", {"axis": (0, 1)}, "door is a planar joint, which is one of space"),
        (3, "universal", {"axis": (0, 0, 1), "axis_b": (0, 1, 1)}, "must be at right angles; they are at 45 degrees"),
        (3, "fix", {"a": "b"}, "door joins b to itself"),
        (3, "fix", {"b": "c"}, "door joins a and c, and no impulse moves either"),
        (3, "fix", {"b": "d"}, "door joins 'd', which is no body"),
    ],
)  # fmt: skip
def test_a_joint_that_is_none_is_refused(dim, kind, options, message):
    given = {"a": "a", "b": "b", "at": (0.0,) * dim, "name": "door"} | options
    with pytest.raises(ns.InvalidInput, match=message):
        getattr(a_and_b(dim), kind)(given.pop("a"), given.pop("b"), **given)


def test_methods_that_do_not_hold_joints_with_axes_say_so():
    scene = a_and_b(2)
    scene.slider("a", "b", axis=(1, 0), name="rail")
    with pytest.raises(ns.InvalidInput, match="rail"):
        ns.simulate(scene, (0, 0.1), integrator=ns.EventDriven())
    with pytest.raises(ns.InvalidInput, match="rail is a slider joint, which no system of a scene holds"):
        scene.system()
    for integrator in (ns.Adaptive(), "auto"):
        assert ns.simulate(scene, (0, 0.1), integrator=integrator).success


def test_who_asks_for_a_joint_among_the_bodies_hears_where_it_is():
    scene = ns.Scene(gravity=(0, -9.81))
    scene.fixed(ns.Disc(0.01), name="wall")
    scene.body(ns.Disc(0.1), mass=1.0, position=(1, 0), name="bob")
    scene.hinge("wall", "bob", at=(0, 0), name="pin")
    sol = ns.simulate(scene, (0, 0.01), integrator=ns.MoreauJean(dt=1e-3))
    with pytest.raises(ns.InvalidInput, match=r"pin is a joint; sol.joint\('pin'\) has what it did"):
        sol["pin"]
    assert sol.joint("pin").angle[-1] < 0.0
