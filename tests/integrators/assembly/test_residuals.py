"""Residual, count, warning and on_residual of a scene say one thing; what exchanges nothing has none."""

import warnings

import numpy as np
import pytest

import nonsmooth as ns
from models.scenes import SphereBox

DT = 2e-3
POOR = {"sweeps": 2, "interior": 0}
OURS = pytest.mark.filterwarnings("ignore::nonsmooth.SimultaneousImpactWarning", "ignore::nonsmooth.PenetrationWarning")


def heap_of_boxes(dim, n=12):
    rng, scene = np.random.default_rng(dim), ns.Scene(gravity=(0,) * (dim - 1) + (-9.81,), material=ns.Material(mu=0.6))
    scene.fixed(ns.HalfPlane((0, 1)) if dim == 2 else ns.HalfSpace((0, 0, 1)), name="ground")
    for k in range(n):
        place = (*rng.uniform(-0.2, 0.2, dim - 1), 0.2 + 0.3 * k)
        mass = 10.0 ** rng.uniform(-2, 2)
        scene.body(ns.Box(*(0.2,) * dim), mass=mass, position=place, name=f"box {k}")
    return scene


def sleepers():
    """A stack at rest, which sleeps, and spheres that fall beside it."""
    scene = ns.Scene(gravity=(0, 0, -9.81), material=ns.Material(mu=0.6, e=0.3))
    scene.fixed(ns.HalfSpace((0, 0, 1)), name="ground")
    for k in range(3):
        scene.body(ns.Box(0.2, 0.2, 0.2), mass=1.0, position=(5, 0, 0.1 + 0.2 * k), name=f"still {k}")
    for k in range(27):
        place = (0.205 * (k % 3), 0.205 * (k // 3 % 3), 0.5 + 0.21 * (k // 9))
        scene.body(ns.Sphere(0.1), mass=1.0, position=place, name=f"sphere {k}")
    return scene


SCENES = {
    "planar boxes": lambda: heap_of_boxes(2),
    "boxes": lambda: heap_of_boxes(3),
    "spheres": SphereBox(n=64, e=0.5).scene,
    "some asleep": sleepers,
}


def simulate(scene, t_end=0.5, dt=DT, **solver):
    return ns.simulate(scene, (0, t_end), integrator=ns.MoreauJean(dt=dt, contacts=ns.ContactSolver(**solver)))


@pytest.mark.upkeep
@OURS
@pytest.mark.parametrize("solver", [{}, POOR, POOR | {"tol": 1e-4}, {"tol": 1e-14}])
@pytest.mark.parametrize("name", SCENES)
def test_a_step_is_counted_where_its_residual_is_above_the_tolerance(name, solver):
    tol = solver.get("tol", 1e-8)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        sol = simulate(SCENES[name](), **solver)
    told = [str(w.message) for w in caught if w.category is ns.ResidualWarning]
    above = int((sol.residual > tol).sum())
    assert sol.stats.missed == above and len(told) == (1 if above else 0)
    assert sol.stats.worst_residual == sol.residual.max() and sol.stats.last_residual == sol.residual[-1]
    assert (f"; {above} steps above tol" in sol.summary()) == (above > 0)
    if above:
        assert f"in {above} of {sol.stats.steps} steps" in told[0]
        with pytest.raises(ns.StepFailure, match="was solved to a residual of") as failure:
            simulate(SCENES[name](), on_residual="raise", **solver)
        assert failure.value.t == pytest.approx(sol.t[np.argmax(sol.residual > tol)], abs=1e-9)
    else:
        assert simulate(SCENES[name](), on_residual="raise", **solver).success


@pytest.mark.upkeep
@OURS
@pytest.mark.filterwarnings("ignore::nonsmooth.ResidualWarning")
@pytest.mark.parametrize("n", [64, 125])
def test_the_worst_contact_is_one_of_its_step(n):
    sol = simulate(SphereBox(n=n, e=0.0).scene(), **POOR)
    stats, k = sol.stats, int(np.argmax(sol.residual))
    assert stats.missed > 0 and stats.worst_time == pytest.approx(sol.t[k - 1], abs=1e-9)
    contacts = sol.contacts(sol.t[k])
    pair = {sol.names[contacts.i[stats.worst_contact]], sol.names[contacts.j[stats.worst_contact]]}
    assert set(stats.worst_pair.split(", ")) == pair
    place = f"(contact {stats.worst_contact}, {stats.worst_pair}, at t = {stats.worst_time:.4g} s)"
    assert place in sol.summary()


@OURS
@pytest.mark.filterwarnings("ignore::nonsmooth.ResidualWarning")
def test_an_island_is_judged_alike_whatever_else_there_is():
    alone = simulate(SphereBox(n=64, e=0.0).scene(), **POOR)
    scene = SphereBox(n=64, e=0.0).scene()
    scene.fixed(ns.Sphere(0.05), position=(0, 0, 50))
    scene.body(ns.Sphere(0.05), mass=1e9, position=(0, 0, 50.1))
    beside = simulate(scene, **POOR)
    above = alone.residual > 1e-8
    assert above.any()
    np.testing.assert_array_equal(beside.residual[above], alone.residual[above])


ROUND = {"disc": (2, ns.Disc(0.1)), "capsule": (2, ns.Capsule(0.3, 0.1)), "sphere": (3, ns.Sphere(0.1))}


@pytest.mark.parametrize("mu", [0.0, 0.3, 50.0])
@pytest.mark.parametrize("shape", ROUND)
def test_a_body_that_rolls_without_a_load_is_left_alone(shape, mu):
    """After its landing nothing pulls at it: no residual, no impulse, no change of its velocity."""
    (dim, body), worst = ROUND[shape], 0.0
    if shape == "capsule":
        mu = min(mu, 0.1)  # with more friction it tips over as it lands
    flat = (0.0,) * (dim - 2)
    for dt, speed, mass in ((2.5e-4, 3.0, 1.0), (1e-3, 3e2, 1e-6), (1e-3, 1e-6, 1e6), (7e-4, 1.0, 3.0)):
        scene = ns.Scene(gravity=(0.0,) * dim, material=ns.Material(mu=mu))
        scene.fixed(ns.HalfPlane((0, 1)) if dim == 2 else ns.HalfSpace((0, 0, 1)), name="ground")
        height = 0.1 + 20.5 * speed * dt
        velocity = (speed, *flat, -speed)
        scene.body(body, mass=mass, position=(0, *flat, height), velocity=velocity, name="body")
        sol = simulate(scene, 200 * dt, dt)
        landed = sol.t > 30 * dt
        v, stats = sol["body"].velocity, sol.stats
        assert stats.missed == 0 and np.abs(v[landed, -1]).max() <= 1e-14 * speed
        change = np.abs(v[landed] - v[landed][0]).max() / speed
        worst = max(worst, change, sol.residual.max())
    assert worst <= 1e-8


@OURS
def test_convex_bodies_on_a_chute_tell_what_they_leave():
    rng = np.random.default_rng(1)
    scene = ns.Scene(gravity=(0, 0, -9.81), material=ns.Material(mu=0.5, e=0.2))
    scene.fixed(ns.HalfSpace((0, 0, 1)))
    scene.fixed(ns.Box(1.5, 1.0, 0.1), position=(0, 0, 0.5), turn=(np.cos(0.2), 0, np.sin(0.2), 0))
    for k in range(6):
        p = rng.normal(size=(20, 3))
        p *= 0.12 / np.linalg.norm(p, axis=1)[:, None]
        scene.body(ns.Polyhedron(p), density=2500, position=(-0.4 + 0.3 * (k % 3), 0.25 * (k // 3 - 1), 0.9))
    scene.body(ns.Ellipsoid(0.15, 0.1, 0.06), density=1000, position=(0.6, 0, 0.9))
    sol = simulate(scene, 0.8, 1e-3)
    assert sol.stats.missed == int((sol.residual > 1e-8).sum()) == 0
