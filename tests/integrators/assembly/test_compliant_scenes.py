"""`Compliance` in scenes: springs implicit in the step, R on the diagonal of the contact problem."""

import math

import numpy as np
import pytest

import nonsmooth as ns
from models.scenes import BoxStack, MasonryArch

G = 9.81


def step(k, c=0.0, dt=1e-3, **options):
    return ns.MoreauJean(dt, theta=1.0, compliance=ns.Compliance(k, c), **options)


@pytest.mark.parametrize("dim", [2, 3])
def test_a_stack_sinks_to_the_depth_that_bears_it(dim):
    """Every contact at its load over n k when it has come to rest: a statement without time, exact to the tolerance."""
    stack, points = BoxStack(n=5, dim=dim), 2 if dim == 2 else 4
    k = 1e8 if dim == 2 else 1e7
    solution = ns.simulate(stack, (0, 2), integrator=step(k, c=1e-2 * k), t_eval=[2.0])
    depths = np.cumsum(stack.loads() / (points * k))
    sunk = solution.position[0, 1:, -1] - solution.position[-1, 1:, -1]
    assert np.abs(sunk / depths - 1).max() < 1e-6
    assert solution.stats.missed == 0


def test_a_scene_and_its_system_take_the_same_compliant_steps():
    """One law in two codes: a ball that settles on a ground and a ball on it, to the tolerance of 200 steps.

    They touch throughout: in the step in which a contact closes a system looks at the gap without gravity."""
    scene = ns.Scene(gravity=(0, -G), material=ns.Material(mu=0.0))
    scene.fixed(ns.HalfPlane((0, 1)), name="ground")
    scene.body(ns.Disc(0.1), mass=2.0, position=(0, 0.1), name="low")
    scene.body(ns.Disc(0.08), mass=1.0, position=(0.0, 0.28), name="high")
    integrator = step(1e6, 500.0)
    found = ns.simulate(scene, (0, 0.2), integrator=integrator, t_eval=[0.1, 0.2])
    counted = ns.simulate(scene.system(), (0, 0.2), *scene.state(), integrator=integrator, t_eval=[0.1, 0.2])
    assert np.abs(found.velocity[1:, 1:, 1] - counted.u[-2:, 1::3]).max() < 1e-9
    assert np.abs(found.position[1:, 1:, 1] - counted.q[-2:, 1::3]).max() < 1e-11


def test_the_implicit_step_nears_the_springs_resolved_in_time():
    """Two methods of one mechanics, of first order in the step: half the step, half the distance."""
    scene = ns.Scene(gravity=(0, -G), material=ns.Material(mu=0.0))
    scene.fixed(ns.HalfPlane((0, 1)), name="ground")
    scene.body(ns.Disc(0.1), mass=2.0, position=(0, 0.1), name="low")
    scene.body(ns.Disc(0.08), mass=1.0, position=(0.0, 0.28), name="high")
    exact = ns.simulate(scene, (0, 0.02), integrator=ns.Penalty(1e6, damping=500.0), t_eval=[0.02]).position[-1, :, 1]
    errors = []
    for dt in (2e-5, 1e-5):
        run = ns.simulate(scene, (0, 0.02), integrator=step(1e6, 500.0, dt), t_eval=[0.02])
        errors.append(np.abs(run.position[-1, :, 1] - exact).max())
    assert 0.4 < errors[1] / errors[0] < 0.6


def test_an_arch_settles_by_the_compliance_of_its_joints():
    """The distance from the rigid arch falls like 1/k, and a stiffness without end is the rigid arch."""
    arch = MasonryArch(n=15, ratio=0.15)
    rigid = ns.simulate(arch, (0, 0.4), integrator=ns.MoreauJean(1e-3), t_eval=[0.4]).position[-1]
    errors = []
    for k in (1e9, 1e10, math.inf):
        run = ns.simulate(arch, (0, 0.4), integrator=step(k, 0.05 * k if k < math.inf else 0.0), t_eval=[0.4])
        errors.append(np.abs(run.position[-1] - rigid).max())
    assert 9.0 < errors[0] / errors[1] < 11.0
    assert errors[2] < 1e-9


def test_springs_that_are_soft_are_told():
    """A block deeper in the ground than a hundredth of its size."""
    scene = ns.Scene(gravity=(0, -G))
    scene.fixed(ns.HalfPlane((0, 1)))
    scene.body(ns.Box(0.2, 0.2), mass=2.0, position=(0, 0.1))
    with pytest.warns(ns.PenetrationWarning, match="the springs are soft"):
        ns.simulate(scene, (0, 0.5), integrator=step(1e3, 100.0))
