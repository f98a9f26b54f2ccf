"""Two rough contacts that wedge a mechanism: G is singular, many impulses hold it, and there is one motion."""

import math
from typing import NamedTuple

import numpy as np
import pytest

import nonsmooth as ns

METHODS = [ns.EventDriven(), ns.Adaptive(), ns.MoreauJean(1e-3)]
NAMES = [type(method).__name__ for method in METHODS]


class Rod(NamedTuple):
    """A rod with one end at a wall, the other on a floor; both may be guides that hold it on both sides."""

    m: float = 1.2  # [kg]
    I: float = 0.064  # [kg m^2]
    mu_wall: float = 0.7
    mu_floor: float = 0.7
    half: float = 0.4  # [m] of the length
    g: float = 9.81  # [m/s^2]
    torque: float = 0.0  # [N m]


def rod_mass(t, q, p, M):
    M[0, 0] = M[1, 1] = p.m
    M[2, 2] = p.I


def rod_force(t, q, u, p, h):
    h[1] = -p.m * p.g
    h[2] = p.torque


def rod_gaps(t, q, p, g_N):
    g_N[0] = q[0] + p.half * math.sin(q[2])
    g_N[1] = q[1] - p.half * math.cos(q[2])


def rod_tangents(t, q, p, W_F):
    W_F[0, 0, 1] = 1.0
    W_F[0, 0, 2] = -p.half * math.sin(q[2])
    W_F[1, 0, 0] = 1.0
    W_F[1, 0, 2] = -p.half * math.cos(q[2])


def rod(bilateral, **parameters):
    contacts = [
        ns.Contact(mu=name, bilateral=side) for name, side in zip(("mu_wall", "mu_floor"), bilateral, strict=True)
    ]
    return ns.System(
        coordinates=["x", "y", "th"], mass=rod_mass, force=rod_force, gap=rod_gaps, tangent=rod_tangents,
        contacts=contacts, parameters=Rod(**parameters),
    )  # fmt: skip


def state(th, w):
    """Both ends on their lines, turning at w [rad/s]."""
    x, y = -Rod().half * math.sin(th), Rod().half * math.cos(th)
    return [x, y, th], [-y * w, x * w, w]


def jams(bilateral):
    """Slides that no forces go with, or several: the impact of friction stops them."""
    rng = np.random.default_rng(3)
    for _ in range(12):
        parameters = {"mu_wall": rng.uniform(1.0, 3.0), "mu_floor": rng.uniform(1.0, 3.0), "torque": rng.normal()}
        yield rod(bilateral, **parameters), *state(rng.uniform(0.5, 1.3), rng.uniform(-1.0, 1.0))


@pytest.mark.parametrize("bilateral", [(True, True), (True, False)], ids=["two guides", "a guide and a floor"])
def test_moreau_jean_goes_through_a_jam_as_the_other_methods_do(bilateral):
    """Of those that no force goes with: rest, after a step at most; the others only end."""
    stopped = 0
    for system, q0, u0 in jams(bilateral):
        exact = ns.simulate(system, (0.0, 0.05), q0, u0, integrator=ns.EventDriven())
        is_jam = all(event.kind == ns.EventKind.INCONSISTENT and event.t == 0.0 for event in exact.events)
        stopped += is_jam
        for dt in (1e-2, 1e-3):
            sol = ns.simulate(system, (0.0, 0.05), q0, u0, integrator=ns.MoreauJean(dt))
            assert sol.success and exact.success
            if is_jam:
                np.testing.assert_allclose(sol.q[-1], exact.q[-1], rtol=0, atol=dt * np.abs(u0).max())
                np.testing.assert_allclose(sol.u[-1], 0.0, atol=1e-8)
                assert np.ptp(sol.q[-3:], axis=0).max() <= 1e-9  # it does not creep, but for the residual
    assert stopped >= 2


class Wedge(NamedTuple):
    """A particle in two rough guides at an angle: nothing moves it, many forces hold it."""

    angle: float = 1.1  # [rad]
    a: float = 3.0  # [m/s^2] along x
    b: float = -2.0  # [m/s^2] along y
    belt: float = 0.0  # [m/s] speed of the first surface
    mu: float = 0.7


def unit_mass(t, q, p, M):
    M[0, 0], M[1, 1] = 1.0, 2.0


def pull(t, q, u, p, h):
    h[0], h[1] = p.a, p.b


def wedge_gaps(t, q, p, g_N):
    g_N[0] = q[1]
    g_N[1] = q[0] * math.sin(p.angle) - q[1] * math.cos(p.angle)


def wedge_tangents(t, q, p, W_F):
    W_F[0, 0, 0] = 1.0
    W_F[1, 0, 0], W_F[1, 0, 1] = math.cos(p.angle), math.sin(p.angle)


def belt_speed(t, q, p, w_F):
    w_F[0, 0] = -p.belt


@pytest.mark.parametrize("integrator", METHODS, ids=NAMES)
@pytest.mark.parametrize("belt", [0.0, 0.5])
@pytest.mark.parametrize("angle", [0.4, 1.1, math.pi / 2, 2.5])
def test_a_particle_in_two_guides_has_one_motion_whatever_the_forces(angle, belt, integrator):
    """With a belt the first contact slides by its surface: forces of either sign of its la_N hold the particle."""
    system = ns.System(
        coordinates=["x", "y"], mass=unit_mass, force=pull, gap=wedge_gaps, tangent=wedge_tangents,
        surface_velocity=belt_speed, contacts=[ns.Contact(mu="mu", bilateral=True)] * 2,
        parameters=Wedge(angle=angle, belt=belt),
    )  # fmt: skip
    zero = np.zeros(2)
    found = ns.classify(system, 0.0, zero, zero)
    assert found.kind == ns.ParadoxKind.REGULAR and found.n_solutions == 1 and found.is_complete
    sol = ns.simulate(system, (0.0, 0.05), zero, zero, integrator=integrator)
    assert sol.success and not sol.paradoxes and sol.stats.indeterminate_steps == 0
    np.testing.assert_allclose(sol.q, 0.0, atol=1e-12)
