"""Maps of paradoxes with friction in two directions, against the closed forms of the rod in space and single states."""

import math

import numpy as np
import pytest

import nonsmooth as ns
from models import BilliardBall, SpatialPainleveRod

ROD = SpatialPainleveRod(mu=2.0)
ELEVATIONS, AZIMUTHS, SPINS = np.linspace(0.05, 1.55, 61), np.linspace(-1.5, 1.5, 60), np.linspace(-25.0, 25.0, 58)
PLANES = [("th", "phi"), ("th", "psidot"), ("phi", "psidot")]
AXES = {"th": ELEVATIONS, "phi": AZIMUTHS, "psidot": SPINS}
HELD = {"th": 1.0, "phi": 0.3, "psidot": 9.0}


def in_plane(names):
    """Axes and values held fixed of a plane, and its states by name."""
    axes = {name: AXES[name] for name in names}
    held = {name: value for name, value in HELD.items() if name not in names}
    grid = dict(zip(names, np.meshgrid(*axes.values(), indexing="ij"), strict=True))
    return axes, held, {**held, **grid}


@pytest.mark.parametrize("names", PLANES, ids=" and ".join)
def test_a_map_of_the_rod_has_the_numbers_of_its_closed_forms(names):
    axes, held, at = in_plane(names)
    chart = ns.paradox_map(ROD, **axes, **held)
    p = np.vectorize(ROD.p)(at["th"], at["phi"])
    b = np.vectorize(ROD.b)(at["th"], 0.0, at["psidot"])
    p, b = np.broadcast_arrays(p, b, np.zeros(chart.kind.shape))[:2]
    np.testing.assert_allclose(chart.p, p, atol=1e-12)
    np.testing.assert_allclose(chart.b, b, rtol=1e-12, atol=1e-12 * ROD.g)
    np.testing.assert_array_equal(chart.n_solutions, np.where(p > 0, 1, np.where(b > 0, 2, 0)))
    assert set(np.unique(chart.n_solutions)) == {0, 1, 2}
    np.testing.assert_allclose(chart.gamma_F, 1.0, rtol=1e-12)
    modes = dict(zip(chart.modes.attrs["flag_meanings"].split(), chart.modes.attrs["flag_values"], strict=True))
    pressed, la_N = (p > 0) & (b < 0), chart.la_N.values[..., 0]
    np.testing.assert_allclose(la_N[pressed], (-b / p)[pressed], rtol=1e-11)
    assert (chart.modes.values[pressed][:, 0] == modes["slide"]).all()
    assert (chart.modes.values[(p > 0) & (b > 0)][:, 0] == modes["free"]).all()


def distance(values, exact):
    """Of each value from the nearest exact one."""
    return np.abs(np.subtract.outer(values, exact)).min(axis=1)


def test_boundaries_over_elevation_and_azimuth_are_those_of_the_closed_forms():
    """A point lies on an edge of the grid: at an azimuth of it, with th_1 or th_2, or at an elevation, with phi_max."""
    curves = ns.paradox_boundaries(ROD, th=ELEVATIONS, phi=AZIMUTHS, psidot=8.0)
    (line,), met = curves.p, 0
    for th, phi in line:
        on_azimuth = min(abs(AZIMUTHS - phi)) < 1e-14
        exact = ROD.paradoxical_angles(phi) if on_azimuth else [s * ROD.critical_azimuth(th) for s in (1, -1)]
        assert distance([th if on_azimuth else phi], exact) < 1e-12
        met += on_azimuth
    assert 20 < met < len(line) - 20
    for line in curves.b:
        assert np.abs([ROD.lift_off_spin(th) - 8.0 for th in line[:, 0]]).max() < 1e-12 * 8.0
    for th, phi in curves.crossings["p", "b"]:
        assert abs(ROD.p(th, phi)) < 1e-12 and abs(ROD.b(th, 0.0, 8.0)) < 1e-11


def test_boundaries_over_elevation_and_spin_meet_at_the_critical_spins():
    curves = ns.paradox_boundaries(ROD, th=ELEVATIONS, psidot=SPINS, phi=0.0)
    for line in curves.p:
        assert distance(line[:, 0], ROD.paradoxical_angles()).max() < 1e-14
    for line in curves.b:
        assert max(abs(abs(spin) / ROD.lift_off_spin(th) - 1.0) for th, spin in line) < 1e-12
    met = curves.crossings["p", "b"]
    exact = [(th, s * spin) for s in (1, -1) for th, spin in
             zip(ROD.paradoxical_angles(), ROD.critical_spins(), strict=True)]  # fmt: skip
    np.testing.assert_allclose(sorted(map(tuple, met.round(9))), sorted(exact), rtol=1e-8)
    for th, spin in met:
        assert distance([th], ROD.paradoxical_angles()) < 1e-12
        assert distance([abs(spin)], ROD.critical_spins()) < 1e-11


def test_boundaries_over_azimuth_and_spin_are_straight():
    curves = ns.paradox_boundaries(ROD, phi=AZIMUTHS, psidot=SPINS, th=1.0)
    phi_max, spin = ROD.critical_azimuth(1.0), ROD.lift_off_spin(1.0)
    assert len(curves.p) == len(curves.b) == 2
    for line in curves.p:
        assert distance(line[:, 0], [phi_max, -phi_max]).max() < 1e-12
    for line in curves.b:
        assert distance(line[:, 1], [spin, -spin]).max() < 1e-12 * spin
    assert len(curves.crossings["p", "b"]) == 4


@pytest.mark.upkeep
def test_a_map_of_states_at_rest_counts_all_slides():
    """A contact by its G whose cone has up to three solutions at rest, over two components of its load."""
    G = np.array([[1.0, 0.8, 0.3], [0.8, 1.5, 0.1], [0.3, 0.1, 0.7]])
    M_0 = np.eye(5)
    M_0[:3, :3] = np.linalg.inv(G)

    def mass(t, q, p, M):
        M[:] = M_0

    def force(t, q, u, p, h):
        for i in range(3):
            h[i] = M_0[i, 0] * q[3] + M_0[i, 1] * q[4] + M_0[i, 2] * 0.2

    def gap(t, q, p, g_N):
        g_N[0] = q[0]

    def tangent(t, q, p, W_F):
        W_F[0, 0, 1], W_F[0, 1, 2] = 1.0, 1.0

    system = ns.System(
        coordinates=[("N", "m"), ("T", "m"), ("S", "m"), ("load", "-"), ("push", "-")], mass=mass, force=force, gap=gap,
        tangent=tangent, contacts=[ns.Contact(mu=2.5, directions=2)],
    )  # fmt: skip
    b, a = np.linspace(-1, 1, 14), np.linspace(-2, 2, 16)
    chart = ns.paradox_map(system, state=([0.0] * 5, [0.0] * 5), load=b, push=a)
    counts = [[len(ns.contact_solutions(G, [x, y, 0.2], 2.5)) for y in a] for x in b]
    np.testing.assert_array_equal(chart.n_solutions, counts)
    assert set(np.unique(counts)) >= {1, 3}
    np.testing.assert_allclose(chart.p, 1.0 - 2.5 * math.hypot(0.8, 0.3), rtol=1e-12)


def test_coupled_contacts_are_mapped_as_they_are_classified():
    """Two tips that G couples: both slide, a complementarity problem; one rests, not enumerated."""
    rng = np.random.default_rng(3)
    A = rng.normal(size=(6, 6))
    M_0 = np.linalg.inv(A @ A.T + 0.3 * np.eye(6))
    h_0 = M_0 @ [-1.0, 0.2, 0.1, 0.5, 0.3, -0.4]

    def mass(t, q, p, M):
        M[:] = M_0

    def force(t, q, u, p, h):
        h[:] = h_0

    def gap(t, q, p, g_N):
        g_N[0], g_N[1] = q[0], q[3]

    def tangent(t, q, p, W_F):
        for k in range(2):
            W_F[k, 0, 3 * k + 1], W_F[k, 1, 3 * k + 2] = 1.0, 1.0

    system = ns.System(
        coordinates=[(name, "m") for name in ("N1", "x1", "y1", "N2", "x2", "y2")], mass=mass, force=force, gap=gap,
        tangent=tangent, contacts=[ns.Contact(mu=4.0, directions=2), ns.Contact(mu=5.0, directions=2)],
    )  # fmt: skip
    x, y, u = np.linspace(-2, 2, 8), np.linspace(-2, 2, 7), [0.0, 0.0, 0.0, 0.0, 1.0, 0.0]
    chart, met = ns.paradox_map(system, state=([0.0] * 6, u), x1dot=x, y2dot=y), set()
    for i, j in np.ndindex(8, 7):
        c = ns.classify(system, 0.0, [0.0] * 6, [0.0, x[i], 0.0, 0.0, 1.0, y[j]])
        assert chart.n_solutions.values[i, j] == c.n_solutions and chart.kind.values[i, j] == c.kind
        np.testing.assert_allclose(chart.p.values[i, j], c.p, rtol=1e-12)
        for solution in c.solutions:
            np.testing.assert_allclose(M_0 @ solution.du, h_0 + solution.la.ravel(), rtol=1e-9, atol=1e-9)
            friction = -solution.la[:, :1] * np.array([[4.0], [5.0]]) * c.direction
            np.testing.assert_allclose(solution.la[:, 1:], friction, rtol=1e-12)
            assert (solution.la[:, 0] >= 0).all() and (solution.du[[0, 3]] >= -1e-10).all()
            assert np.abs(solution.la[:, 0] * solution.du[[0, 3]]).max() < 1e-9
        met.add(c.n_solutions)
    assert len(met) >= 2
    rest = ns.classify(system, 0.0, [0.0] * 6, [0.0] * 6)
    assert (rest.kind, rest.is_complete) == (ns.ParadoxKind.NOT_ENUMERATED, False)


def test_a_ball_that_slides_and_turns_is_regular():
    chart = ns.paradox_map(BilliardBall(), speed=[0.5, 1.0], w_x=[0.0, 40.0])
    assert (chart.kind == ns.ParadoxKind.REGULAR).all() and (chart.gamma_F > 0).all()


def test_critical_friction_is_the_least_of_all_directions():
    for th in (0.3, 0.9, 1.4):
        q = ROD.state(th, psi=0.7)[0]
        assert ns.critical_friction(ROD, q) == pytest.approx(ROD.critical_friction(th), rel=1e-12)
    least = ns.least_critical_friction(ROD, q, "th", (0.0, math.pi / 2))
    assert least == pytest.approx(ROD.least_critical_friction(), rel=1e-7)
    assert ns.critical_friction(ROD, ROD.state(th=math.pi / 2)[0]) == math.inf
