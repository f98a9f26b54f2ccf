"""Scenes that stand: each by its criterion, from both sides where there are two."""

import math

import numpy as np
import pytest

import nonsmooth as ns
from models.scenes import BlockOnIncline, BoxStack, CardHouse, KaplaTower, MasonryArch, Pyramid, Wall
from models.scenes.masonry_arch import LEAST_RATIO

EXACT = 1e-12  # chosen: a residual at which what is left of a velocity at rest is rounding, and becomes 0
# stones that fall upon one another ask for more than some steps reach
FALLS = pytest.mark.filterwarnings("ignore::nonsmooth.errors.ResidualWarning")


def moved(solution):
    return np.abs(solution.position - solution.position[0]).max()


def test_least_thickness_of_an_arch_of_many_stones_is_that_of_milankovitch():
    # stones hinge at their joints only, half a stone from where the thrust would touch: an error of its angle squared
    for n in (20, 40, 80, 160, 320):
        below = LEAST_RATIO - MasonryArch(n=n).least_ratio()
        assert -5e-7 <= below <= 0.25 * (math.pi / n) ** 2  # the source gives six digits


@FALLS
@pytest.mark.parametrize("n", [15, 21])
def test_arch_stands_above_its_least_thickness_and_falls_below(n, simulate, most_creep):
    least = MasonryArch(n=n).least_ratio()
    stands = simulate(MasonryArch(n=n, ratio=1.005 * least), 2.0)
    assert stands.stats.missed == 0 and moved(stands) <= most_creep(stands)
    falls = simulate(MasonryArch(n=n, ratio=0.995 * least), 2.0, every=50)
    assert moved(falls) > 0.2 * MasonryArch.R


@FALLS
def test_arch_of_many_stones_is_bracketed_within_one_per_cent(simulate, most_creep):
    stands = simulate(MasonryArch(n=41, ratio=1.008 * LEAST_RATIO), 1.0)
    assert stands.stats.missed == 0 and moved(stands) <= most_creep(stands)
    falls = simulate(MasonryArch(n=41, ratio=0.992 * LEAST_RATIO), 2.0, every=50)
    assert moved(falls) > 0.2 * MasonryArch.R


@pytest.mark.parametrize("mu", [0.2, 0.5])
def test_cards_stand_up_to_their_friction_limit(mu, simulate):
    limit = CardHouse(mu=mu).largest_angle()
    card = CardHouse(mu=mu, angle=0.999 * limit)
    stands, falls = simulate(card, 0.5, tol=EXACT), simulate(CardHouse(mu=mu, angle=1.001 * limit), 1.0)
    assert moved(stands) == 0.0
    push = stands.contacts().of("left").of("right").P_N / card.dt
    assert push == pytest.approx([card.push()], rel=1e-7)
    assert moved(falls) > 0.2 * card.length


@pytest.mark.parametrize("mu", [0.2, 0.5])
def test_thin_cards_stand_below_the_arc_tangent_of_twice_mu(mu):
    assert CardHouse(mu=mu, thickness=1e-9).largest_angle() == pytest.approx(math.atan(2 * mu), rel=1e-7)


@pytest.mark.parametrize("share", [0.5, 0.99])
def test_block_below_its_friction_limit_does_not_creep_at_all(share, simulate):
    solution = simulate(BlockOnIncline(share=share), 10.0, tol=EXACT, every=100)
    assert moved(solution) == 0.0 and np.ptp(solution.turn, axis=0).max() == 0.0


def test_block_above_its_friction_limit_slides_with_what_is_left(simulate):
    model = BlockOnIncline(share=1.5, mu=0.3)
    block = simulate(model, 0.5)["block"]
    way = np.linalg.norm(block.position - block.position[0], axis=1)
    np.testing.assert_allclose(way, 0.5 * model.acceleration() * block.t**2, atol=1e-8)


@pytest.mark.parametrize("dim", [2, 3])
def test_stack_carries_its_loads_and_does_not_drift(dim, simulate, most_creep):
    model = BoxStack(n=5, dim=dim)
    solution = simulate(model, 2.0)
    assert moved(solution) <= most_creep(solution)
    contacts = solution.contacts()
    loads = [contacts.P_N[np.minimum(contacts.i, contacts.j) == k].sum() / model.dt for k in range(model.n)]
    np.testing.assert_allclose(loads, model.loads(), rtol=1e-7)


LAID = [Pyramid(rows=6), Wall(courses=5, bricks=3), KaplaTower(layers=8)]


@pytest.mark.parametrize("model", LAID, ids=lambda model: model.name)
def test_what_is_laid_on_one_another_stands(model, simulate):
    solution = simulate(model, 1.0)
    assert moved(solution) <= 1e-9
    weight = model.load(0) if isinstance(model, KaplaTower) else model.weight()
    assert solution.contacts().of("ground").P_N.sum() / model.dt == pytest.approx(weight, rel=1e-7)


def rebuilt(scene, order):
    """The scene with its bodies in another order."""
    other = ns.Scene(gravity=scene.gravity, material=scene.material)
    for k in order:
        body = scene.bodies[k]
        if body.kind == 1:
            other.fixed(body.shape, position=body.position, turn=body.turn, name=body.name)
        else:
            other.body(body.shape, density=body.density, position=body.position, turn=body.turn, name=body.name)
    return other


def test_order_of_bodies_changes_a_falling_arch_by_its_residuals_only(simulate):
    model = MasonryArch(n=7, ratio=0.07)
    scene = model.scene()
    order = np.random.default_rng(1).permutation(len(scene))
    one, other = (simulate(s, 0.5, dt=model.dt) for s in (scene, rebuilt(scene, order)))
    for name in one:
        # hinges turn within 0.5 s, nothing has hit yet: errors of 1e-8 of each of 250 steps grow by the fall alone
        np.testing.assert_allclose(one[name].position, other[name].position, atol=1e-6)
    assert moved(one) > 0.1


@pytest.mark.parametrize("power", [-3, 4])
def test_units_of_length_and_mass_scaled_by_powers_of_two_change_no_bit_of_a_slide(power, simulate):
    c = 2.0**power
    size = {"a": 0.4, "b": 0.3, "c": 0.2}
    model = BlockOnIncline(share=1.5, mu=0.3)
    scaled = BlockOnIncline(
        share=1.5, mu=0.3, g=model.g * c, density=model.density, **{name: c * length for name, length in size.items()}
    )
    one, other = simulate(model, 0.2), simulate(scaled, 0.2)
    np.testing.assert_array_equal(c * one.position, other.position)
    np.testing.assert_array_equal(one.turn, other.turn)
