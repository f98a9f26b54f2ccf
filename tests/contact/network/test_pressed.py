"""Islands solved by the contacts that press: which are left out, which come back, and what is left where none helps."""

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.contact.network import pressed
from nonsmooth.contact.network.from_inside import STARTS
from nonsmooth.contact.network.gauss_seidel import relax
from nonsmooth.contact.network.pressed import PRESSED_STARTS as STARTS_OF
from nonsmooth.contact.network.pressed import are_pressed, contacts_of, part_of, solve_pressed, solve_whole
from nonsmooth.jit import interpreted
from tests.contact.network.problems import copy_of, heap, judge

TOL = 1e-9


def swept(n, dim, sweeps=10):
    """A heap with the impulses that some sweeps leave, far from the tolerance."""
    network = heap(n, dim)
    for _ in range(sweeps):
        for c in range(int(network.n_c)):
            interpreted(relax)(network, c, dim, 3 * (dim - 1))
    assert judge(network) > 1e3 * TOL
    return network


@pytest.mark.parametrize("dim", [2, 3])
def test_an_island_is_solved_by_what_presses_and_its_open_contacts_have_no_impulse(dim):
    network = swept(60, dim)
    contacts = contacts_of(network, 0)
    left_out = contacts[~are_pressed(network, contacts)]
    assert 0 < len(left_out) < len(contacts)
    assert solve_pressed(network, 0, TOL, STARTS_OF[network.b.shape[1]]) > 0
    assert judge(network) <= TOL and not network.P[left_out].any() and (network.gamma[left_out, 0] >= 0.0).all()


@pytest.mark.parametrize("dim", [2, 3])
def test_what_is_left_out_and_approaches_comes_back(dim, monkeypatch):
    """Of no more than every second contact, which do not hold the others apart."""
    network = swept(60, dim)
    monkeypatch.setattr(pressed, "are_pressed", lambda _, contacts: np.arange(len(contacts)) % 2 == 0)
    solve_pressed(network, 0, TOL, STARTS_OF[network.b.shape[1]])
    assert judge(network) <= TOL and (network.P[contacts_of(network, 0)[1::2], 0] > 0.0).any()


def test_what_is_no_better_is_put_back(monkeypatch):
    network = swept(60, 3)
    before = copy_of(network)
    monkeypatch.setattr(pressed, "from_inside", lambda part, *_: part.P.fill(1.0) or True)
    solve_pressed(network, 0, TOL, STARTS_OF[network.b.shape[1]])
    solve_whole(network, 0, TOL, STARTS)
    np.testing.assert_array_equal(network.P, before.P)
    np.testing.assert_array_equal(network.v, before.v)


def test_no_bit_depends_on_the_room_for_factors(monkeypatch):
    ends = []
    for fill in (1, 100):
        monkeypatch.setattr(pressed, "FIRST_FILL_OF_PART", fill)
        network = swept(60, 3)
        solve_whole(network, 0, TOL, STARTS)
        ends.append(network.P.copy())
    np.testing.assert_array_equal(*ends)


@pytest.mark.parametrize("dim", [2, 3])
def test_a_part_has_the_velocities_of_the_whole_where_the_others_have_no_impulse(dim):
    network = swept(40, dim)
    contacts = contacts_of(network, 0)
    kept = contacts[network.P[contacts, 0] > 0.0]
    part = part_of(network, kept)
    np.testing.assert_allclose(part.gamma, network.gamma[kept], atol=1e-14)
    assert part.n_c == len(kept) < len(contacts) and len(part.v) <= len(network.v)


@pytest.mark.upkeep
def test_a_falling_heap_of_discs_is_solved_in_every_step():
    """Sweeps and factors alone miss 278 of these 1000 steps, as islands of more than 200 bodies were left by before."""
    rng = np.random.default_rng(1)
    scene = ns.Scene(gravity=(0, -9.81), material=ns.Material(mu=0.4))
    scene.fixed(ns.HalfPlane((0, 1)))
    for k in range(300):
        place = (0.11 * (k % 12) + rng.uniform(-0.0045, 0.0045), 0.06 + 0.11 * (k // 12))
        scene.body(ns.Disc(0.05), density=1000, position=place)
    stats = ns.simulate(scene, (0, 1), integrator=ns.MoreauJean(dt=1e-3), every=100).stats
    assert stats.missed == 0 and stats.most_contacts > 400


@pytest.mark.upkeep
@pytest.mark.parametrize("seed", range(3))
def test_a_shaken_packing_is_solved_in_every_step(seed):
    """343 spheres, each in the middle of four of the layer below, thrown at random: 1650 contacts, many next to the
    edge of the cone. With `interior=200` three of five steps are left at 1e-3."""
    rng = np.random.default_rng(seed)
    scene = ns.Scene(gravity=(0, 0, -9.81), material=ns.Material(mu=0.4))
    scene.fixed(ns.HalfSpace((0, 0, 1)))
    for layer, x, y in np.ndindex(7, 7, 7):
        place = (0.1 * x + 0.05 * (layer % 2), 0.1 * y + 0.05 * (layer % 2), 0.05 + 0.0708 * layer)
        scene.body(ns.Sphere(0.05), density=1000, position=place, velocity=0.5 * rng.normal(size=3))
    stats = ns.simulate(scene, (0, 0.01), integrator=ns.MoreauJean(dt=2e-3)).stats
    assert stats.missed == 0 and stats.methods["interior points"] >= 3 and stats.most_contacts > 1600
