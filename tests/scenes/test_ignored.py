"""Bodies that ignore one another pass through, and touch all others as before."""

from __future__ import annotations

import numpy as np
import pytest

import nonsmooth as ns

G, DT = 9.81, 1e-3


def scene_of(dim):
    """A ghost above a table above the ground, and a ball upon each side of it."""
    up = (0, 1) if dim == 2 else (0, 0, 1)
    scene = ns.Scene(gravity=tuple(-G * np.array(up)), material=ns.Material(mu=0.3))
    scene.fixed(ns.HalfPlane(up) if dim == 2 else ns.HalfSpace(up), name="ground")
    scene.fixed(ns.Box(4.0, 0.1) if dim == 2 else ns.Box(4.0, 4.0, 0.1), position=0.5 * np.array(up), name="table")
    for k, name in enumerate(("ghost", "ball", "other")):
        shape = ns.Disc(0.1) if dim == 2 else ns.Sphere(0.1)
        scene.body(shape, mass=1.0, position=0.7 * np.array(up) + 0.5 * k * np.eye(dim)[0], name=name)
    return scene


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("integrator", [ns.MoreauJean(DT), ns.Adaptive(1e-4, 1e-7)], ids=["steps", "adaptive"])
def test_a_ghost_falls_through_the_table_and_rests_on_the_ground(dim, integrator):
    scene = scene_of(dim)
    scene.ignore("table", "ghost")
    sol = ns.simulate(scene, (0, 1.0), integrator=integrator)
    assert sol["ghost"].position[-1, -1] == pytest.approx(0.1, abs=1e-4)
    for name in ("ball", "other"):
        assert sol[name].position[-1, -1] == pytest.approx(0.65, abs=1e-4)
    t = sol.t[(sol.t > 0.2) & (sol.t < 0.3)]  # in the table
    free = 0.7 - 0.5 * G * t**2
    assert len(t) and np.abs(np.array([sol(at)["ghost"].position[-1] for at in t]) - free).max() < 1e-3


def test_of_a_group_each_passes_through_each():
    scene = scene_of(2)
    scene.ignore("ghost", scene["ball"], "other")
    names = {frozenset(body.name for body in pair) for pair in scene.apart()}
    assert names == {frozenset(pair) for pair in (("ghost", "ball"), ("ghost", "other"), ("ball", "other"))}
    scene.ignore("ghost", "ball")
    assert len(scene.ignored) == 3


@pytest.mark.upkeep
def test_by_its_system_they_pass_through_one_another_too():
    scene = ns.Scene(gravity=(0, -G), material=ns.Material(mu=0.0))
    scene.fixed(ns.HalfPlane((0, 1)), name="ground")
    for k, name in enumerate("ab"):
        scene.body(ns.Disc(0.1), mass=1.0, position=(0, 0.15 + 0.3 * k), name=name)
    scene.ignore("a", "b")
    assert scene.system().n_c == 2
    sol = ns.simulate(scene, (0, 1.0), integrator=ns.EventDriven())
    np.testing.assert_allclose([sol[name].position[-1, 1] for name in "ab"], 0.1, atol=1e-9)
    by_steps = ns.simulate(scene, (0, 1.0), integrator=ns.MoreauJean(DT))
    np.testing.assert_allclose([by_steps[name].position[-1, 1] for name in "ab"], 0.1, atol=1e-4)


def test_a_link_that_is_joined_may_ignore_another_body_too():
    """Two rods on pins at one place swing through one another, each as one alone."""

    def rods(n):
        scene = ns.Scene(gravity=(0, -G))
        hook = scene.fixed(ns.Disc(0.01), name="hook")
        for k in range(n):
            side = 1 - 2 * k
            rod = scene.body(ns.Box(1.0, 0.02), mass=1.0, position=(0.5 * side, 0), name=f"rod {k}")
            scene.hinge(hook, rod, at=(0, 0))
        return scene

    both = rods(2)
    both.ignore("rod 0", "rod 1")
    together, alone = (ns.simulate(scene, (0, 1.0), integrator=ns.MoreauJean(DT)) for scene in (both, rods(1)))
    np.testing.assert_allclose(together["rod 0"].position, alone["rod 0"].position, atol=1e-12)
    np.testing.assert_allclose(together["rod 1"].position * (-1, 1), alone["rod 0"].position, atol=1e-12)


@pytest.mark.parametrize(("bodies", "said"), [
    (("ball",), "two or more bodies, each once; got ball"), ((), "got none"),
    (("ball", "ball"), "each once; got ball, ball"), (("ball", "bal"), "'bal', .* did you mean 'ball'"),
])  # fmt: skip
def test_what_is_no_pair_is_refused(bodies, said):
    with pytest.raises(ns.InvalidInput, match=said):
        scene_of(2).ignore(*bodies)
