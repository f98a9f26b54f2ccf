"""The impulse of a landing has the arm of the body's own surface, wherever in its step the body lands."""

import numpy as np
import pytest

import nonsmooth as ns

STARTS = np.linspace(0.0, 1.0, 7, endpoint=False)  # parts of the way of a step
MU, SPEED, FALL = 0.1, 6.0, 4.0  # [m/s] of a slide that does not end


def landed(shape, dim, reach, dt, start, e=0.0, carried=0.0):
    """The spin about the axis at right angles to a slide, after a landing without gravity."""
    scene = ns.Scene(gravity=(0,) * dim, material=ns.Material(mu=MU, e=e))
    ground = ns.HalfPlane((0, 1)) if dim == 2 else ns.HalfSpace((0, 0, 1))
    along, up = np.eye(dim)[0], np.eye(dim)[-1]
    if carried:
        scene.kinematic(ground, velocity=carried * along, name="ground")
    else:
        scene.fixed(ground)
    place = (reach + 0.05 + start * FALL * dt) * up
    scene.body(shape, mass=1.0, position=place, velocity=(SPEED + carried) * along - FALL * up, name="b")
    sol = ns.simulate(scene, (0, 0.02), integrator=ns.MoreauJean(dt=dt))
    spin = sol["b"].spin[-1]
    return float(spin if dim == 2 else spin[1])


@pytest.mark.parametrize("e", [0.0, 0.5])
@pytest.mark.parametrize("carried", [0.0, 30.0])
@pytest.mark.parametrize("dim, shape, reach, inertia", [
    (2, ns.Disc(0.1), 0.1, 0.5 * 0.01),
    (3, ns.Sphere(0.1), 0.1, 0.4 * 0.01),
])  # fmt: skip
def test_a_ball_that_slides_after_its_landing_has_the_spin_of_the_arm_R(dim, shape, reach, inertia, e, carried):
    expected = MU * FALL * (1 + e) * reach / inertia * (-1 if dim == 2 else 1)
    for dt in (4e-3, 1e-3):
        for start in STARTS:
            assert landed(shape, dim, reach, dt, start, e, carried) == pytest.approx(expected, rel=1e-12)
