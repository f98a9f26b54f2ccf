"""Painlevé's rod in space: closed forms against Newton's and Euler's equations, and classifications against both."""

import math

import numpy as np
import pytest

import nonsmooth as ns
from models import PainleveRod, SpatialPainleveRod

ROD = SpatialPainleveRod(m=0.7, l=1.4, I=0.2, mu=2.9, g=9.3)
UP = np.array([0.0, 0.0, 1.0])
FLAG, KIND = ns.ParadoxFlag, ns.ParadoxKind


def states(n, seed=1):
    """th, phi, thdot, psidot, psi at random, with signs of p and b of every kind."""
    rng = np.random.default_rng(seed)
    return zip(rng.uniform(0.05, 1.5, n), rng.uniform(-1.5, 1.5, n), rng.uniform(-6, 6, n), rng.uniform(-8, 8, n),
               rng.uniform(-3, 3, n), strict=True)  # fmt: skip


def axis(th, psi):
    return np.array([math.cos(th) * math.cos(psi), math.cos(th) * math.sin(psi), math.sin(th)])


def tip_acceleration(rod, th, thdot, psidot, psi, force):
    """By vectors alone: m r_C'' = F + m g, (I e x e')' = -s e x F, |e| = 1, and the tip is r_C - s e."""
    e, s = axis(th, psi), rod.l / 2
    rate = thdot * np.array([-math.sin(th) * math.cos(psi), -math.sin(th) * math.sin(psi), math.cos(th)])
    rate += psidot * np.cross(UP, e)
    e_2 = np.cross(np.cross(-s * e, force) / rod.I, e) - rate @ rate * e
    return force / rod.m - rod.g * UP - s * e_2


def direction(phi, psi):
    return -np.array([math.cos(psi + phi), math.sin(psi + phi), 0.0])


@pytest.mark.upkeep
def test_closed_forms_are_those_of_newton_and_euler():
    for th, phi, thdot, psidot, psi in states(2000):
        d, la_N = direction(phi, psi), 3.0
        free, pressed = (
            tip_acceleration(ROD, th, thdot, psidot, psi, N * (UP - ROD.mu * d)) for N in (0.0, la_N)
        )  # fmt: skip
        size = 1e-12 * (np.abs(free).max() + np.abs(pressed).max())
        assert ROD.b(th, thdot, psidot) == pytest.approx(free[2], abs=size)
        assert ROD.p(th, phi) * la_N + ROD.b(th, thdot, psidot) == pytest.approx(pressed[2], abs=size)
        along, left = ROD.slip_acceleration(th, phi, thdot, psidot, la_N)
        assert along == pytest.approx(d @ pressed, abs=size)
        assert left == pytest.approx(np.cross(UP, d) @ pressed, abs=size)
        h = np.array([math.cos(psi), math.sin(psi), 0.0])
        columns = [tip_acceleration(ROD, th, thdot, psidot, psi, F) - free for F in (UP, h, np.cross(UP, h))]
        G = np.array([[row @ column for column in columns] for row in (UP, h, np.cross(UP, h))])
        np.testing.assert_allclose(ROD.delassus(th), G, atol=1e-12 * G.max())


def test_every_state_is_classified_as_the_closed_forms_say():
    met = set()
    for th, phi, thdot, psidot, psi in states(400, seed=2):
        state = ROD.state(th, phi, thdot, psidot, 0.8, psi)
        c, p, b = ns.classify(ROD, 0.0, *state), ROD.p(th, phi), ROD.b(th, thdot, psidot)
        exact = ROD.normal_forces(th, phi, thdot, psidot)
        met.add((p > 0, bool(b > 0)))
        assert c.is_complete and c.mode == ("sliding",)
        assert c.p[0] == pytest.approx(p, abs=1e-12 * (1 + ROD.kappa() * (1 + ROD.mu)) / ROD.m)
        assert c.b[0] == pytest.approx(b, abs=1e-12 * (abs(b) + 2 * ROD.g))
        assert c.kind == (KIND.INCONSISTENT, KIND.REGULAR, KIND.INDETERMINATE)[len(exact)]
        assert bool(c.flags & FLAG.PAINLEVE) == (p <= 0)
        np.testing.assert_allclose(c.direction[0], direction(phi, psi)[:2], atol=1e-12)
        assert [s.modes for s in c.solutions] == [("slide",) if la > 0 else ("free",) for la in exact]
        for solution, la_N in zip(c.solutions, exact, strict=True):
            force = la_N * (UP - ROD.mu * direction(phi, psi))
            np.testing.assert_allclose(solution.la[0], force[[2, 0, 1]], rtol=1e-11, atol=1e-12 * (1 + la_N))
            centre = force / ROD.m - ROD.g * UP
            np.testing.assert_allclose(solution.du[:3], centre, rtol=1e-11, atol=1e-11 * (1 + la_N))
    assert len(met) == 4


def test_at_rest_the_rod_has_one_answer():
    """That of its round cone in the axes of the ground: where b > 0, e . a_tip > 0 too, and sticking would pull. p is
    the least of all directions, that of phi = 0."""
    for th, _, thdot, psidot, psi in states(200, seed=3):
        c = ns.classify(ROD, 0.0, *ROD.state(th, 0.0, thdot, psidot, 0.0, psi))
        h = np.array([math.cos(psi), math.sin(psi)])
        R = np.eye(3)
        R[1:, 1:] = np.column_stack([h, [-h[1], h[0]]])
        G = R @ ROD.delassus(th) @ R.T
        free = tip_acceleration(ROD, th, thdot, psidot, psi, np.zeros(3))[[2, 0, 1]]
        found = ns.contact_solutions(G, free, ROD.mu)
        assert c.is_complete and c.mode == ("resting",) and [s.modes[0] for s in c.solutions] == list(found.modes)
        for solution, P in zip(c.solutions, found.P, strict=True):
            np.testing.assert_allclose(solution.la[0], P, rtol=1e-8, atol=1e-9)
        assert c.p[0] == pytest.approx(ROD.p(th, 0.0), rel=1e-11, abs=1e-12)
        assert c.kind == KIND.REGULAR


@pytest.mark.parametrize(("mu", "th_1", "th_2", "Psi_1", "Psi_2", "phi_max"), [
    (1.4, 55.5858, 69.9519, 1.9480490, 3.0096833, 17.7528),
    (5 / 3, 45.0, 75.9638, 1.6817928, 4.1860720, 36.8699),
    (2.0, 37.3774, 79.1877, 1.6151213, 5.3786619, 48.1897),
])  # fmt: skip
def test_the_critical_spins_and_azimuth_of_the_slender_rod(mu, th_1, th_2, Psi_1, Psi_2, phi_max):
    """In units sqrt(g/s): at Psi_1 and Psi_2 p = b = 0 with th' = 0."""
    rod = SpatialPainleveRod.slender(m=2.0, l=0.6, mu=mu)
    unit = math.sqrt(rod.g / (rod.l / 2))
    np.testing.assert_allclose(np.degrees(rod.paradoxical_angles()), [th_1, th_2], atol=5e-5)
    np.testing.assert_allclose(np.array(rod.critical_spins()) / unit, [Psi_1, Psi_2], atol=5e-8)
    assert math.degrees(rod.critical_azimuth()) == pytest.approx(phi_max, abs=5e-5)
    for th, spin in zip(rod.paradoxical_angles(), rod.critical_spins(), strict=True):
        assert abs(rod.p(th, 0.0)) < 1e-12 and abs(rod.b(th, 0.0, spin)) < 1e-12 * rod.g
        assert rod.genot_brogliato_rate(th, 0.5 * spin) == pytest.approx(math.sqrt(0.75) * spin * math.cos(th))
        assert rod.genot_brogliato_rate(th, 1.1 * spin) is None


def test_above_psi_c_a_spin_alone_lifts_the_tip_whatever_the_friction():
    """Psi_c = sqrt(3 sqrt(3)/2) at sin th = 1/sqrt(3): the least over a fine grid of elevations, to second order."""
    th = np.linspace(0.01, 1.56, 20_001)
    for rod in (ROD, SpatialPainleveRod.slender(mu=0.1)):
        least, at = rod.least_lift_off_spin()
        assert least / math.sqrt(rod.g / (rod.l / 2)) == pytest.approx(1.6118549, abs=5e-8)
        grid = [rod.lift_off_spin(x) for x in th]
        assert min(grid) == pytest.approx(least, rel=1e-7) and th[np.argmin(grid)] == pytest.approx(at, abs=1e-4)
        assert rod.b(at, 0.0, 1.001 * least) > 0 > rod.b(at, 0.0, 0.999 * least)
        assert rod.lift_off_spin(0.8, thdot=10.0) == 0.0


def test_the_genot_brogliato_set_is_flagged_where_the_closed_forms_have_it():
    for phi in (0.0, 0.3, -0.5):
        for th in ROD.paradoxical_angles(phi):
            spin = 0.6 * ROD.lift_off_spin(th)
            state = {"th": th, "phi": phi, "psidot": spin, "thdot": ROD.genot_brogliato_rate(th, spin)}
            assert ns.classify(ROD, state=state).flags & FLAG.GENOT_BROGLIATO
            assert not ns.classify(ROD, state=state | {"th": th + 1e-6}).flags & FLAG.GENOT_BROGLIATO


def test_p_vanishes_where_the_closed_forms_say():
    assert ROD.least_critical_friction()[0] == pytest.approx(2 * math.sqrt(1 + ROD.kappa()) / ROD.kappa())
    for phi in (0.0, 0.4, -0.9):
        least, th = ROD.least_critical_friction(phi)
        assert least == pytest.approx(ROD.least_critical_friction()[0] / math.cos(phi), rel=1e-14)
        for elevation in (th, 0.3, 1.2):
            mu = ROD.critical_friction(elevation, phi)
            assert mu >= least and abs(SpatialPainleveRod(mu=mu, m=0.7, l=1.4, I=0.2).p(elevation, phi)) < 1e-12 * mu
    for th in ROD.paradoxical_angles(0.3):
        assert abs(ROD.p(th, 0.3)) < 1e-12
    assert abs(ROD.p(1.1, ROD.critical_azimuth(1.1))) < 1e-12
    assert ROD.paradoxical_angles(1.5) is None and ROD.paradoxical_angles(math.pi) is None
    assert ROD.critical_friction(1.0, math.pi) == math.inf and ROD.critical_azimuth(0.1) is None
    smooth = SpatialPainleveRod(mu=0.3)
    assert smooth.critical_azimuth() is None and smooth.critical_spins() is None


def test_without_azimuth_it_is_the_rod_of_the_plane():
    plane = PainleveRod(m=0.7, l=1.4, I=0.2, mu=2.9, g=9.3)
    for th, _, thdot, _, _ in states(50):
        assert ROD.normal_forces(th, 0.0, thdot) == pytest.approx(plane.normal_forces(th, thdot, -1.0), rel=1e-12)
        solutions = ns.classify(ROD, 0.0, *ROD.state(th, 0.0, thdot)).solutions
        of_plane = ns.classify(plane, 0.0, *plane.state(th, thdot, -1.0)).solutions
        assert len(solutions) == len(of_plane)
        for space, flat in zip(solutions, of_plane, strict=True):
            np.testing.assert_allclose(space.du[[0, 2, 3]], flat.du, rtol=1e-10, atol=1e-10)


def test_a_state_leaves_the_paradox_by_its_azimuth_alone():
    """While the tip slides the azimuth turns: free of force, from p < 0 < b to p > 0 at |phi| = phi_max(th)."""
    from scipy.integrate import solve_ivp

    rod = SpatialPainleveRod(mu=2.0, g=9.81)
    th, spin = math.radians(60.0), 12.0
    q, u = rod.state(th, 0.0, 0.0, spin, 1.0)
    assert rod.p(th, 0.0) < 0 < rod.b(th, 0.0, spin)
    left = rod.slip_acceleration(th, 0.0, 0.0, spin)[1] / 1.0 - spin

    def rate(t, x):
        th, a, w = x[3], x[8], x[9]
        return [*x[5:], 0, 0, -rod.g, -math.sin(th) * math.cos(th) * w * w, 2 * math.tan(th) * a * w]

    def azimuth(x):
        h, s = np.array([math.cos(x[4]), math.sin(x[4])]), rod.l / 2
        v = x[5:7] + s * (x[8] * math.sin(x[3]) * h + x[9] * math.cos(x[3]) * np.array([h[1], -h[0]]))
        return math.remainder(math.atan2(-v[1], -v[0]) - x[4], 2 * math.pi)

    short = solve_ivp(rate, (0, 1e-4), [*q, *u], rtol=1e-12, atol=1e-13).y[:, -1]
    assert azimuth(short) / 1e-4 == pytest.approx(left, rel=1e-2)
    sol = solve_ivp(rate, (0, 0.1), [*q, *u], rtol=1e-11, atol=1e-12, max_step=1e-3)
    path = [(rod.p(x[3], azimuth(x)), x[3], azimuth(x)) for x in sol.y.T]
    leaving = next(k for k, (p, _, _) in enumerate(path) if p > 0)
    (_, th_in, phi_in), (_, _, phi_out) = path[leaving - 1], path[leaving]
    low, high = rod.paradoxical_angles()
    assert low < th_in < high and abs(phi_in) < rod.critical_azimuth(th_in) < abs(phi_out) + 1e-2


@pytest.mark.parametrize("law", ["newton", "poisson", "energetic"])
def test_the_impact_of_the_model_is_the_one_that_is_classified(law):
    state = {"th": 1.0, "phi": 0.5, "thdot": 0.4, "psidot": -2.0, "slip": 0.8}
    rod = SpatialPainleveRod(mu=2.0)
    of_model = rod.impact_without_collision(**state, e=0.6, law=law)
    (listed,) = [x for x in ns.classify(rod, state=state, restitution=0.6).impacts if x.law.name.lower() == law]
    np.testing.assert_allclose([of_model.P_N, *of_model.P_F], [listed.P_N[0], *listed.P_F[0]], rtol=1e-12)
    np.testing.assert_allclose(of_model.u, listed.u, rtol=1e-12, atol=1e-13)
    assert of_model.gamma_N == pytest.approx(listed.gamma_N[0], abs=1e-14)
    np.testing.assert_array_equal(of_model.gamma_F, 0.0)
    assert of_model.path[0].tolist() == [0.0, 0.0, *(-0.8 * np.array([math.cos(0.5), math.sin(0.5)]))]
    with pytest.raises(ns.InvalidInput, match="needs p < 0"):
        rod.impact_without_collision(phi=1.2)


def test_the_slide_turns_while_an_impact_brakes_it_and_compression_does_not_know_how():
    """What ends compression at rest has P_c = -G^-1 gamma whatever the way there; the work of the way is its own."""
    rod = SpatialPainleveRod(mu=2.0)
    found = rod.impact_without_collision(th=1.0, phi=0.5, e=1.0, law="energetic")
    path = found.path
    moving = np.hypot(path[:, 2], path[:, 3]) > 1e-6
    phi = np.arctan2(-path[moving, 3], -path[moving, 2])
    assert ((np.diff(phi) > 0).all() or (np.diff(phi) < 0).all()) and abs(phi[-1] - phi[0]) > 0.1
    for azimuth in (0.0, 0.2, 0.5, -0.7):
        other = rod.impact_without_collision(th=1.0, phi=azimuth, slip=0.6, e=1.0, law="poisson")
        braked = -np.linalg.solve(rod.delassus(1.0), [0.0, *other.path[0, 2:]])
        assert other.P_c == pytest.approx(braked[0], rel=1e-13) and other.P_N == pytest.approx(2 * braked[0], rel=1e-13)


def test_at_the_edge_of_the_paradox_the_tip_still_leaves():
    """By the energetic law gamma_N+ ~ sqrt(|p|) in the plane as p -> 0; where p = 0 is met in phi, it has a limit."""
    rod, plane = SpatialPainleveRod(mu=2.0), PainleveRod(mu=2.0)
    distances, phi_max, th_1 = (1e-4, 1e-6, 1e-8), rod.critical_azimuth(1.0), rod.paradoxical_angles()[0]
    aside = [rod.impact_without_collision(1.0, phi_max - x, e=1.0, law="energetic").gamma_N for x in distances]
    assert aside == pytest.approx([0.1254] * 3, abs=1e-4)
    ahead = [rod.impact_without_collision(th_1 + x, 0.0, e=1.0, law="energetic").gamma_N for x in distances]
    flat = [plane.impact_without_collision(th_1 + x, 0.0, -1.0, e=1.0, law="energetic").gamma_N for x in distances]
    np.testing.assert_allclose(ahead, flat, rtol=1e-6)
    np.testing.assert_allclose(np.divide(ahead[:-1], ahead[1:]), 10.0, rtol=1e-3)
