"""What friction holds does not slip, whatever solvers leave of it: on platforms, turntables, in stacks and houses."""

import numpy as np
import pytest

import nonsmooth as ns

G = 9.81  # [m/s^2]
NO_SLIP = 1e-8  # derived: [m] of some hundred steps with velocities that solvers leave at 1e-8 of 0.5 m/s, 1e-2 s each


def shuttle(t, a=0.5, period=6.0):
    """There and back in a period, with an acceleration of a, even, and -a."""
    third, u = period / 6, t % period
    is_back = u >= 3 * third
    u -= 3 * third * is_back
    way = 2 * a * third**2
    if u < third:
        x = 0.5 * a * u * u
    elif u < 2 * third:
        x = 0.5 * a * third**2 + a * third * (u - third)
    else:
        x = way - 0.5 * a * (3 * third - u) ** 2
    return way - x if is_back else x


def load(scene, mass, layers=3):
    """Put a pallet there, with boxes in layers, and thin sheets between them."""
    scene.body(ns.Box(1.2, 1.0, 0.15), mass=10 * mass, position=(0, 0, 0.075), name="pallet")
    z = 0.15
    for _ in range(layers):
        for i in range(3):
            for j in range(2):
                scene.body(ns.Box(0.3, 0.3, 0.25), mass=mass, position=((i - 1) * 0.301, (j - 0.5) * 0.301, z + 0.125))
        scene.body(ns.Box(1.2, 1.0, 0.001), mass=0.1 * mass, position=(0, 0, z + 0.2505))
        z += 0.251


@pytest.mark.upkeep
@pytest.mark.parametrize("tol", [1e-8, 1e-10])
@pytest.mark.parametrize("dt", [1e-2, 2.5e-3])
@pytest.mark.parametrize("mass", [1.0, 1e-2])
def test_a_pallet_on_a_platform_that_moves_to_and_fro_does_not_slip(tol, dt, mass):
    """Its acceleration changes at ends of steps: within one, a dt^2/8 of its way is none of a parabola."""
    scene = ns.Scene(gravity=(0, 0, -G), material=ns.Material(mu=0.5))
    scene.kinematic(ns.Box(3, 2, 0.2), motion=lambda t: (shuttle(t, period=1.5), 0, -0.1), name="platform")
    load(scene, mass)
    sol = ns.simulate(scene, (0, 3.0), integrator=ns.MoreauJean(dt=dt, contacts=ns.ContactSolver(tol=tol)), every=5)
    way = np.array([shuttle(t, period=1.5) for t in sol.t])
    slip = sol.position[:, 1:, 0] - sol.position[0, 1:, 0] - way[:, None]
    assert np.abs(slip).max() < NO_SLIP and np.abs(sol.position[:, 1:, 2] - sol.position[0, 1:, 2]).max() < NO_SLIP
    assert sol.stats.missed == 0


def test_a_card_of_a_standing_house_does_not_jump():
    """Playing cards of 0.3 mm: what two parallel edges choose by a rounding moved one by 83 um along its normal."""
    L, W, t, a, levels = 0.088, 0.063, 0.0003, np.radians(25), 3
    scene = ns.Scene(gravity=(0, 0, -G), material=ns.Material(mu=0.8))
    scene.fixed(ns.HalfSpace((0, 0, 1)))
    z, H, pitch = 0.0, L * np.cos(a) + t * np.sin(a), L * (1 + 1e-9)
    for k in range(levels):
        cards, x_0 = levels - k, 0.5 * k * pitch
        for i in range(cards):
            for side in (-1, 1):
                x = x_0 + i * pitch + side * (L / 2 * np.sin(a) + t / 2 * np.cos(a))
                turn = (np.cos(a / 2), 0, -side * np.sin(a / 2), 0)
                scene.body(ns.Box(t, W, L), mass=0.0018, position=(x, 0, z + H / 2), turn=turn)
        for i in range(cards - 1):
            scene.body(ns.Box(L, W, t), mass=0.0018, position=(x_0 + (i + 0.5) * pitch, 0, z + H + t / 2))
        z += H + t
    sol = ns.simulate(scene, (0, 1.0), integrator=ns.MoreauJean(dt=0.01))
    assert np.abs(np.diff(sol.position, axis=0)).max() < NO_SLIP and sol.stats.missed == 0
