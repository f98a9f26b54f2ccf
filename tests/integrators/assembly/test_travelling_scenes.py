"""A scene that travels at an even velocity, with what is guided in it, has the motion of the scene at rest."""

import numpy as np
import pytest

import nonsmooth as ns

GROUND = {2: ns.HalfPlane((0, 1)), 3: ns.HalfSpace((0, 0, 1))}
BALL = {2: ns.Disc(0.1), 3: ns.Sphere(0.1)}
BOX = {2: ns.Box(0.3, 0.2), 3: ns.Box(0.3, 0.3, 0.2)}
TILTED = {2: 0.3, 3: (0.9, 0.3, 0.1, 0.3)}
DT = 1e-3  # [s]
# A box that lies loose on four corners and is struck by a corner nearer to its middle may bear on other ones by a
# rounding, and is then 1e-6 m off: of ten such places half are so.
CASES = [(BALL, BALL, 0.0, 0.13), (BOX, BALL, 0.4, 0.13), (BOX, BOX, 0.4, 0.15)]


def seen_from_within(dim, speed, lower, upper, is_guided, mu, beside):
    """What lies in a carriage and what falls upon it, beside its middle: times, places and velocities (n_t, 2, dim)."""
    along, up = speed * np.eye(dim)[0], np.eye(dim)[-1]
    scene = ns.Scene(gravity=-9.81 * up, material=ns.Material(mu=mu, e=0.5 if is_guided else 0.0))
    scene.kinematic(GROUND[dim], velocity=along, name="floor")
    if is_guided:
        scene.kinematic(lower, position=0.1 * up, velocity=along)
    else:
        scene.body(lower, mass=1.0, position=0.1 * up, velocity=along)
    turn = TILTED[dim] if dim == 2 else np.array(TILTED[dim]) / np.linalg.norm(TILTED[dim])
    place = 0.5 * up + beside * np.eye(dim)[0]
    scene.body(upper, mass=1.0, position=place, turn=turn, velocity=along)
    sol = ns.simulate(scene, (0, 0.4), integrator=ns.MoreauJean(dt=DT))
    way = sol.t[:, None, None] * along
    return sol.t, sol.position[:, 1:] - way, sol.velocity[:, 1:] - along


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("is_guided", [False, True])
@pytest.mark.parametrize("lower, upper, mu, beside", CASES)
def test_motion_does_not_depend_on_how_fast_the_scene_travels(dim, is_guided, lower, upper, mu, beside):
    _, x, v = seen_from_within(dim, 0.0, lower[dim], upper[dim], is_guided, mu, beside)
    assert np.abs(np.diff(v, axis=0)).max() > 0.5  # they met
    for speed in (3.0, -30.0):
        _, x_there, v_there = seen_from_within(dim, speed, lower[dim], upper[dim], is_guided, mu, beside)
        assert np.abs(x_there - x).max() < 5e-11  # a rounding of 12 m is 2e-15: 1e4 of them, as impacts let them grow
        assert np.abs(v_there - v).max() < 5e-11 / DT  # a landing closes its gap within a step


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("speed", [0.0, 30.0])
def test_a_ball_that_falls_on_one_lying_in_a_train_drives_it_aside_as_on_the_ground(dim, speed):
    """Both impacts plastic and smooth, n = (s, c) from the one to the other: n.(u_upper - u_lower) = 0 with
    u_upper = (0, -w) + P n/m and u_lower = (-P s/m, 0), so that P = m w c/(1 + s^2)."""
    s = 0.05 / 0.2
    c = np.sqrt(1 - s * s)
    w = np.sqrt(2 * 9.81 * (0.5 - 0.1 - 0.2 * c))
    t, _, v = seen_from_within(dim, speed, BALL[dim], BALL[dim], is_guided=False, mu=0.0, beside=0.05)
    after = np.searchsorted(t, w / 9.81 + 2 * DT)
    normal_error = w * DT / 0.2  # of s, by where in its step the ball lands
    assert v[after, 0, 0] == pytest.approx(-w * s * c / (1 + s * s), rel=normal_error)


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("speed", [1.0, 30.0, -30.0])
@pytest.mark.parametrize("upper", [BALL, BOX])
def test_what_lies_on_edges_that_travel_from_the_start_stays_there(dim, speed, upper):
    """A ball in the slot between two blocks, or a box on one that reaches over its edge by less than half of itself."""
    along, up, aside = speed * np.eye(dim)[0], np.eye(dim)[-1], np.eye(dim)[0]
    scene = ns.Scene(gravity=-9.81 * up, material=ns.Material(mu=0.5))
    scene.kinematic(BOX[dim], position=-0.2 * aside, velocity=along)
    scene.kinematic(BOX[dim], position=(0.2 if upper is BALL else 0.6) * aside, velocity=along)
    place = (0.1 + np.sqrt(0.1**2 - 0.05**2)) * up if upper is BALL else 0.2 * up - 0.06 * aside
    scene.body(upper[dim], mass=1.0, position=place, velocity=along, name="upper")
    sol = ns.simulate(scene, (0, 0.1), integrator=ns.MoreauJean(dt=1e-3))
    assert np.abs(sol["upper"].velocity - along).max() < 1e-12
    assert np.abs(sol["upper"].position - place - sol.t[:, None] * along).max() < 1e-13
