"""Impacts of scenes by other laws than Newton's, against systems and closed forms; refusals; rules of selection."""

import math

import numpy as np
import pytest

import nonsmooth as ns
from models.painleve_rod import PainleveRod
from nonsmooth.integrators.assembly.struck import MOST_STRUCK

LAWS = ["newton", "sequential", "poisson", "energetic"]
OTHERS = LAWS[1:]
G = (0.0, -9.81)
EXACT = ns.EventDriven(rtol=1e-10, atol=1e-12)


def on_ground(law, mu=0.3, e=0.5):
    scene = ns.Scene(gravity=G, material=ns.Material(mu=mu, e=e, impact=law))
    scene.fixed(ns.HalfPlane((0, 1)), name="ground")
    return scene


def corner(law, mu=0.3):
    """A box that falls on a corner, obliquely: a slide that stops or turns back within the impact."""
    scene = on_ground(law, mu)
    scene.body(ns.Box(0.3, 0.2), density=1000, position=(0, 0.5), turn=0.4, velocity=(1, -1), spin=2.0, name="box")
    return scene


def face(law):
    """A box that falls flat, on two corners at once."""
    scene = on_ground(law)
    scene.body(ns.Box(0.3, 0.2), density=1000, position=(0, 0.2), velocity=(1.0, 0.0), name="box")
    return scene


def pendulum(law):
    """A disc on a pin that swings against a wall without friction: the joint holds in the impact."""
    scene = ns.Scene(gravity=G, material=ns.Material(mu=0.0, e=0.5, impact=law))
    scene.fixed(ns.HalfPlane((1, 0)), name="wall")
    scene.fixed(ns.Disc(0.01), position=(0.05, 0.5), name="hook")
    scene.body(ns.Disc(0.1), density=1000, position=(0.4, 0.2), name="bob")
    scene.joint("hook", "bob", at=(0.05, 0.5))
    return scene


def cradle(law, e, dim=2, n=5):
    """Beads in a row, of which the first strikes the others at .15 s."""
    scene = ns.Scene(gravity=(0.0,) * dim, material=ns.Material(mu=0.0, e=e, impact=law))
    for k in range(n):
        place, speed = np.zeros(dim), np.zeros(dim)
        place[0], speed[0] = 0.1 * k - 0.15 * (k == 0), k == 0
        shape = ns.Disc(0.05) if dim == 2 else ns.Sphere(0.05)
        scene.body(shape, mass=1.0, position=place, velocity=speed, name=f"bead {k}")
    return scene


def ends(scene, t_end, integrator):
    sol = ns.simulate(scene, (0, t_end), integrator=integrator)
    return np.concatenate([sol.velocity[-1].ravel(), sol.spin[-1].ravel()]), sol


@pytest.mark.upkeep
@pytest.mark.filterwarnings("ignore::nonsmooth.errors.FrictionGainWarning")
@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize(
    ("make", "t_end"),
    [
        (corner, 0.2),
        (lambda law: corner(law, mu=0.0), 0.2),
        (lambda law: corner(law, mu=1.0), 0.2),
        (face, 0.2),
    ],
)
def test_a_step_has_the_impact_of_a_system_to_second_order(make, t_end, law):
    """Events are located there, here the step is divided: what differs is the flight, by dt^2 (2.5e-5 m/s at 1 ms)."""
    exact, sol = ends(make(law), t_end, EXACT)
    assert np.abs(exact).max() > 0.1 and abs(sol.ledger["normal"][-1]) > 1e-2
    errors = []
    for dt in (1e-3, 2.5e-4):
        found, sol = ends(make(law), t_end, ns.MoreauJean(dt))
        errors.append(np.abs(found - exact).max())
        assert sol.stats.missed == sol.stats.energy_gains == 0
    assert errors[1] <= 1e-5 and errors[1] <= max(errors[0] / 3, 1e-7)


@pytest.mark.upkeep
@pytest.mark.parametrize("law", OTHERS)
def test_a_joint_holds_in_an_impact_by_each_law(law):
    """One degree of freedom without friction: e is a ratio of velocities, impulses and works at once."""
    exact, sol = ends(pendulum("newton"), 0.7, EXACT)
    assert sol.ledger["normal"][-1] < -1.0
    found, sol = ends(pendulum(law), 0.7, ns.MoreauJean(2.5e-4))
    np.testing.assert_allclose(found, exact, atol=1e-4)
    assert sol.stats.last_joint_drift < 1e-8


def test_laws_differ_where_a_slide_is_reversed():
    found = [ends(corner(law, mu=1.0), 0.2, ns.MoreauJean(1e-3))[0] for law in ("newton", "poisson", "energetic")]
    assert min(np.abs(a - b).max() for a, b in ((found[0], found[1]), (found[1], found[2]))) > 1e-3


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("e", [1.0, 0.6])
def test_beads_that_are_struck_one_after_the_other_pass_it_on(e, dim):
    """Of equal masses each blow leaves (1 - e)/2 and hands on (1 + e)/2; behind it the slower ones strike again."""
    found, _ = ends(cradle("sequential", e, dim, n=3), 0.2, ns.MoreauJean(1e-3))
    v = np.array([1.0, 0.0, 0.0])
    while (closing := v[:-1] - v[1:]).max() > 1e-12:
        k = int(np.argmax(closing))
        mean, half = 0.5 * (v[k] + v[k + 1]), 0.5 * e * closing[k]
        v[k], v[k + 1] = mean - half, mean + half
    np.testing.assert_allclose(found[: 3 * dim : dim], v, atol=1e-9)


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("e", [1.0, 0.6])
def test_poissons_law_gives_back_e_of_the_compression_of_a_chain(e, dim):
    """Compression leaves the common velocity 1/5; the impulses of expansion are e times those of compression."""
    found, _ = ends(cradle("poisson", e, dim), 0.25, ns.MoreauJean(1e-3))
    expected = 0.2 + e * (0.2 - np.array([1.0, 0.0, 0.0, 0.0, 0.0]))
    np.testing.assert_allclose(found[: 5 * dim : dim], expected, atol=1e-7)


@pytest.mark.parametrize("law", OTHERS)
def test_nothing_is_gained_and_momentum_is_kept(law):
    rng = np.random.default_rng(4)
    scene = ns.Scene(gravity=(0, 0), material=ns.Material(mu=0.3, e=0.8, impact=law))
    for k in range(12):
        place = (0.25 * (k % 4), 0.25 * (k // 4))
        scene.body(
            ns.Disc(0.1), mass=1.0 + k % 3, position=place, velocity=rng.normal(size=2), spin=rng.normal(), name=f"{k}"
        )
    sol = ns.simulate(scene, (0, 0.5), integrator=ns.MoreauJean(1e-3))
    mass = np.array([1.0 + k % 3 for k in range(12)])
    momentum = np.einsum("b,tbk->tk", mass, sol.velocity)
    kinetic = sol.ledger["kinetic"]
    assert kinetic[-1] < 0.95 * kinetic[0] and (np.diff(kinetic) <= 1e-9 * kinetic[0]).all()
    np.testing.assert_allclose(momentum, np.tile(momentum[0], (len(momentum), 1)), atol=1e-12)
    works = sol.ledger["normal"] + sol.ledger["friction"]
    np.testing.assert_allclose(kinetic - kinetic[0], works, atol=1e-10 * kinetic[0])


@pytest.mark.parametrize("law", OTHERS)
def test_what_rests_on_the_ground_bears_blows_and_rests_again(law):
    scene = on_ground(law)
    scene.body(ns.Box(0.3, 0.1), density=1000, position=(0, 0.05), name="plate")
    scene.body(ns.Disc(0.05), density=1000, position=(0.05, 0.4), name="ball")
    sol = ns.simulate(scene, (0, 1.0), integrator=ns.MoreauJean(1e-3))
    energy = sol.ledger["kinetic"] + sol.ledger["potential"]
    assert sol.stats.missed == sol.stats.energy_gains == 0 and sol.penetration.max() < 1e-5
    assert energy[-1] < energy[0] - 1.0 and sol["ball"].position[:, 1].max() < 0.41
    np.testing.assert_allclose(sol["plate"].velocity[-1], 0.0, atol=1e-9)


@pytest.mark.parametrize(
    ("materials", "integrator", "message"),
    [
        ((("newton", 0.5), ("poisson", 0.5)), ns.MoreauJean(1e-3), "unlike laws of impact"),
        ((("poisson", 0.5), ("poisson", 0.8)), ns.MoreauJean(1e-3), "'poisson' of a scene needs one e"),
        ((("energetic", 0.5), ("energetic", 0.0)), ns.MoreauJean(1e-3), "'energetic' of a scene needs e > 0"),
        ((("energetic", 0.5), ("energetic", 0.5)), ns.Penalty(1e6), "springs and dampers say how bodies rebound"),
    ],
)
def test_what_has_no_one_law_is_refused_by_name(materials, integrator, message):
    scene = ns.Scene(gravity=G)
    scene.fixed(ns.HalfPlane((0, 1)), name="ground", material=ns.Material(e=materials[0][1], impact=materials[0][0]))
    for k, (law, e) in enumerate(materials):
        material = ns.Material(e=e, impact=law, name=f"{k}")
        scene.body(ns.Disc(0.1), mass=1.0, position=(k, 1.0), material=material, name=f"disc {k}")
    with pytest.raises(ns.InvalidInput, match=message):
        ns.simulate(scene, (0, 0.01), integrator=integrator)


def test_two_pairs_with_laws_of_their_own_are_refused():
    scene = ns.Scene(gravity=G)
    scene.fixed(ns.HalfPlane((0, 1)), name="ground", material=ns.Material(e=0.5, name="ground"))
    scene.body(ns.Disc(0.1), mass=1.0, position=(0, 1), material=ns.Material(e=0.5, name="plain"))
    scene.body(ns.Disc(0.1), mass=1.0, position=(1, 1), material=ns.Material(e=0.5, impact="poisson", name="other"))
    with pytest.raises(ns.InvalidInput, match="rebound by one law of impact, and .* have 'newton', .* have 'poisson'"):
        ns.simulate(scene, (0, 0.01), integrator=ns.MoreauJean(1e-3))


def test_a_law_in_space_is_one_without_friction():
    scene = ns.Scene(gravity=(0, 0, -9.81), material=ns.Material(mu=0.1, e=0.5, impact="energetic"))
    scene.fixed(ns.HalfSpace((0, 0, 1)), name="ground")
    scene.body(ns.Sphere(0.1), mass=1.0, position=(0, 0, 1))
    with pytest.raises(ns.InvalidInput, match="'energetic' in space is one without friction"):
        ns.simulate(scene, (0, 0.01), integrator=ns.MoreauJean(1e-3))


def test_an_island_that_is_too_large_ends_the_run_with_what_was_computed():
    scene = cradle("sequential", 0.9, n=MOST_STRUCK + 3)
    with pytest.raises(
        ns.StepFailure, match=f"up to {MOST_STRUCK} closed contacts, and bead .* is of a larger"
    ) as told:
        ns.simulate(scene, (0, 0.2), integrator=ns.MoreauJean(1e-3))
    sol = told.value.solution
    assert sol.t[-1] == pytest.approx(0.15, abs=2e-3) and np.isfinite(sol.velocity).all()


def turning_rod(mu=2.0):
    """A rod that slides and turns: it may go on sliding, lift off, or stick at once."""
    q, u = PainleveRod().state(th=math.pi / 3, thdot=6.0, slip=-1.0)
    scene = ns.Scene(gravity=G, material=ns.Material(mu=mu))
    scene.fixed(ns.HalfPlane((0, 1)), name="ground")
    thin = 1e-3
    scene.body(
        ns.Capsule(1.0, thin), mass=1.0, inertia=1 / 12, name="rod", position=(q[0], q[1] + thin), turn=q[2],
        velocity=(u[0] - thin * u[2], u[1]), spin=u[2],
    )  # fmt: skip
    return scene


def test_a_rule_of_selection_takes_the_solution_that_a_system_takes():
    taken = {}
    for rule in ("compliant-limit", "lift-off", "impact"):
        scene, options = turning_rod(), {"integrator": ns.MoreauJean(1e-3), "selection": rule}
        sol = ns.simulate(scene, (0, 0.01), **options)
        system = ns.simulate(scene.system(), (0, 0.01), *scene.state(), **options)
        # a step of a scene has its rows in the middle, so an impulse of some g dt differs by dt
        np.testing.assert_allclose(sol.u[-1, 3:], system.u[-1], atol=2e-2 if rule == "impact" else 1e-9)
        assert [event.choice for event in sol.paradoxes] == [event.choice for event in system.paradoxes]
        taken[rule] = sol.u[-1, 3:]
    assert np.abs(taken["impact"] - taken["lift-off"]).max() > 0.1


def test_a_checkpoint_knows_the_rule_of_its_run(tmp_path):
    place, options = tmp_path / "rod.npz", {"integrator": ns.MoreauJean(1e-3)}
    ns.simulate(turning_rod(), (0, 0.01), checkpoint=place, **options)
    with pytest.raises(ns.NonsmoothError, match="selection"):
        ns.simulate(turning_rod(), (0, 0.01), checkpoint=place, resume=place, selection="impact", **options)


def test_springs_take_no_rule():
    with pytest.raises(ns.InvalidInput, match="springs have one answer"):
        ns.simulate(turning_rod(), (0, 0.01), integrator=ns.Penalty(1e6), selection="impact")
