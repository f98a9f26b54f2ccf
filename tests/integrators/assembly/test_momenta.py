"""Bodies that meet where nothing pulls: what of their momenta is kept to rounding, and what to an order."""

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.scenes.places import matrix_of

LIKE, UNLIKE = {2: ns.Box(0.3, 0.2), 3: ns.Box(0.2, 0.2, 0.2)}, {3: ns.Box(0.3, 0.2, 0.1)}


def momenta(dim, shape, e, mu, dt):
    """Momentum and angular momentum of two spinning boxes before and after they meet: how far they
    are from one another."""
    rng, scene = np.random.default_rng(2), ns.Scene(gravity=[0.0] * dim, material=ns.Material(mu=mu, e=e))
    sides = np.array(shape.lengths)
    for k in range(2):
        turn, spin = rng.normal(size=4), 3.0 * rng.normal(size=3)
        place = np.array([0.5 * (2 * k - 1), 0.05 * k, 0.0])[:dim]
        turn, spin = (turn[0], spin[0]) if dim == 2 else (turn / np.linalg.norm(turn), spin)
        scene.body(
            shape, mass=1.0 + k, position=place, velocity=[1.0 - 2 * k, *[0.0] * (dim - 1)], turn=turn, spin=spin
        )
    sol = ns.simulate(scene, (0, 1.0), integrator=ns.MoreauJean(dt=dt), every=10**6)
    found = []
    for record in (0, -1):
        p, L = np.zeros(dim), np.zeros(3)
        for k in range(2):
            m, x, v, spin = 1.0 + k, sol.position[record, k], sol.velocity[record, k], sol.spin[record, k]
            p += m * v
            if dim == 2:
                L[2] += m * (x[0] * v[1] - x[1] * v[0]) + m * (sides @ sides) / 12 * spin
            else:
                R = matrix_of(sol.turn[record, k])
                L += m * np.cross(x, v) + R @ (m * (sides @ sides - sides**2) / 12 * (R.T @ spin))
        found.append((p, L))
    assert sol.velocity[-1, 0, 0] < 0.7  # they met
    return [np.abs(after - before).max() for before, after in zip(*found, strict=True)]


@pytest.mark.parametrize("dim, shape, e, mu", [(2, LIKE[2], 0.7, 0.3), (3, UNLIKE[3], 0.0, 0.5)])
def test_bodies_that_do_not_penetrate_keep_both_momenta_to_rounding(dim, shape, e, mu):
    of_p, of_L = momenta(dim, shape, e, mu, 1e-3)
    assert of_p < 1e-14 and of_L < 1e-13


@pytest.mark.parametrize(
    "dim, shape, e, mu, order, part",
    [
        (2, LIKE[2], 0.0, 0.5, 2, 0.02),  # one rolls on the other, and is put back on it
        (2, LIKE[2], 1.0, 0.0, 2, 2.0),  # pushed apart, while they move: the square of what they turn in a step
        (3, LIKE[3], 0.7, 0.3, 2, 2.0),
        (3, LIKE[3], 1.0, 0.0, 2, 2.0),
        (3, LIKE[3], 0.0, 0.5, 1, 0.05),  # one rolls on the other, with the arms of the middle of the step
        (3, UNLIKE[3], 0.7, 0.3, 2, 0.02),
        (3, UNLIKE[3], 1.0, 0.0, 2, 1.0),
    ],
)
def test_momentum_is_kept_to_rounding_and_the_angular_one_to_an_order(dim, shape, e, mu, order, part):
    for dt in (4e-3, 1e-3, 2.5e-4):
        of_p, of_L = momenta(dim, shape, e, mu, dt)
        assert of_p < 1e-14 and of_L < part * dt**order


@pytest.mark.filterwarnings("ignore::nonsmooth.errors.SimultaneousImpactWarning")
@pytest.mark.parametrize("e", [0.0, 0.6])
@pytest.mark.parametrize("dim", [2, 3])
def test_impulses_of_pairs_add_up_to_the_momentum_that_each_body_got(dim, e):
    """From all steps, with landings and rebounds: what gravity does not give comes from the others."""
    up, along = np.eye(dim)[-1], np.eye(dim)[0]
    scene = ns.Scene(gravity=-9.81 * up, material=ns.Material(mu=0.3, e=e))
    scene.fixed((ns.HalfPlane if dim == 2 else ns.HalfSpace)(up), name="ground")
    for k in range(4):
        shape = ns.Box(*[0.2] * dim) if k % 2 else (ns.Disc if dim == 2 else ns.Sphere)(0.1)
        place = 0.03 * k * along + (0.2 + 0.25 * k) * up
        scene.body(shape, mass=1.0 + k, position=place, velocity=0.5 * along, name=f"body {k}")
    sol = ns.simulate(scene, (0, 0.8), integrator=ns.MoreauJean(dt=1e-3))
    axes = ["P_x", "P_y", "P_z"][:dim]
    pairs = sol.to_dataframe("contacts").groupby(["i", "j"])[axes].sum()
    for k, m in enumerate(range(1, 5)):
        name = f"body {k}"
        got = (
            pairs[pairs.index.get_level_values("j") == name].sum()
            - pairs[pairs.index.get_level_values("i") == name].sum()
        )
        change = m * (sol[name].velocity[-1] - sol[name].velocity[0] + 9.81 * 0.8 * up)
        np.testing.assert_allclose(got.values, change, atol=800 * 4 * np.finfo(float).eps * 32.0)
