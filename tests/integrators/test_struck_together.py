"""Newton's law of impact at several coupled contacts at once: the run says that this is one answer of many."""

import re
import warnings
from typing import NamedTuple

import numpy as np
import pytest

import nonsmooth as ns
from models import WallPendulum
from nonsmooth.catalogue.entries import load, model_entries
from tests.integrators.test_several_impacts import INTEGRATORS, after, beads, of_all

NEWTON = [ns.Contact(e_N=1.0, name=f"bead {k}") for k in range(4)]


def silently(*args, **options):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        return ns.simulate(*args, **options)


@of_all
def test_five_touching_beads_under_newtons_law_are_told_once_with_time_and_contacts(integrator):
    said = r"at t = (\S+) s bead 0, bead 1, bead 2 and bead 3 were hit at once.*impact='sequential'"
    with pytest.warns(ns.SimultaneousImpactWarning, match=said) as caught:
        u = after([1.0] * 5, [1, 0, 0, 0, 0], NEWTON, integrator)
    assert len(caught) == 1
    step = getattr(integrator, "dt", 1e-9)  # of which the message names the beginning
    assert 5e-3 - step <= float(re.match(said, str(caught[0].message))[1]) <= 5e-3 + 1e-9
    np.testing.assert_allclose(u, [-0.6, 0.4, 0.4, 0.4, 0.4], rtol=0, atol=1e-12)


@of_all
@pytest.mark.parametrize("contact", [ns.Contact(), ns.Contact(e_N=1.0, impact="sequential"),
                                     ns.Contact(e_N=0.5, impact="poisson")])  # fmt: skip
def test_no_restitution_and_laws_of_several_contacts_are_not_told(integrator, contact):
    sol = silently(beads([1.0] * 5, [contact] * 4), (0, 0.1), [-5e-3, 0, 0, 0, 0], [1.0, 0, 0, 0, 0],
                   integrator=integrator)  # fmt: skip
    assert sol.stats.struck_together == 0 and sol.stats.first_together == ""


class Corner(NamedTuple):
    a: float  # of the second wall: its normal is (cos a, sin a)


def unit(t, q, p, M):
    M[0, 0] = M[1, 1] = 1.0


def free(t, q, u, p, h):
    h[0] = 0.0


def walls(t, q, p, g_N):
    g_N[0] = q[1]
    g_N[1] = np.cos(p.a) * q[0] + np.sin(p.a) * q[1]


def in_corner(a, e=(0.5, 0.5)):
    contacts = [ns.Contact(e_N=e[0], name="floor"), ns.Contact(e_N=e[1], name="wall")]
    return ns.System(coordinates=["x", "y"], mass=unit, force=free, gap=walls, contacts=contacts, parameters=Corner(a))


@of_all
def test_a_ball_in_a_right_corner_rebounds_from_each_wall_by_its_own_law_and_is_not_told(integrator):
    sol = silently(in_corner(0.0), (0, 0.1), [0.02, 0.02], [-1.0, -1.0], integrator=integrator)
    np.testing.assert_allclose(sol.u[-1], [0.5, 0.5], rtol=0, atol=1e-12)
    assert sol.stats.struck_together == 0


@of_all
def test_a_ball_in_an_oblique_corner_is_told(integrator):
    with pytest.warns(ns.SimultaneousImpactWarning, match="floor and wall were hit at once"):
        ns.simulate(in_corner(-0.5), (0, 0.1), [0.04, 0.01], [-2.0, -0.5], integrator=integrator)


@of_all
def test_a_blow_that_lets_the_other_contact_part_is_one_impact(integrator):
    """The ball lies at the wall and strikes the floor, which drives it off the wall: a > 0."""
    a = 0.5
    along = np.array([-np.sin(a), np.cos(a)])  # down the wall
    q = np.array([0.0, 0.0]) + 0.02 * along
    sol = silently(in_corner(a), (0, 0.1), q, -along, integrator=integrator)
    assert sol.u[-1][1] == pytest.approx(0.5 * np.cos(a), abs=1e-9)
    assert sol.stats.struck_together == 0


@of_all
def test_a_striker_without_restitution_is_not_told_and_one_with_is_whatever_the_others_have(integrator):
    def three(e_0, e_1):
        return beads([1.0] * 3, [ns.Contact(e_N=e_0), ns.Contact(e_N=e_1)])

    start = ([-5e-3, 0, 0], [1.0, 0, 0])
    assert silently(three(0.0, 1.0), (0, 0.1), *start, integrator=integrator).stats.struck_together == 0
    with pytest.warns(ns.SimultaneousImpactWarning):
        found = ns.simulate(three(1.0, 0.0), (0, 0.1), *start, integrator=integrator).u[-1]
    np.testing.assert_allclose(found, [-1 / 3, 2 / 3, 2 / 3], rtol=0, atol=1e-9)  # bead 1 and 2 go on as one


@pytest.mark.parametrize("integrator", [*INTEGRATORS, ns.MoreauJean(dt=1e-4)])
def test_beads_that_rest_in_their_weight_are_not_told(integrator):
    class P(NamedTuple):
        g: float = 9.81

    def mass(t, q, p, M):
        for i in range(3):
            M[i, i] = 1.0

    def weight(t, q, u, p, h):
        for i in range(3):
            h[i] = -p.g

    def heights(t, q, p, g_N):
        g_N[0], g_N[1], g_N[2] = q[0], q[1] - q[0], q[2] - q[1]

    pile = ns.System(n_q=3, mass=mass, force=weight, gap=heights, contacts=[ns.Contact(e_N=0.9)] * 3, parameters=P())
    assert silently(pile, (0, 0.3), np.zeros(3), np.zeros(3), integrator=integrator).stats.struck_together == 0


def test_one_contact_is_never_told():
    model = WallPendulum(e=1.0)
    assert silently(model, (0, 3), *model.state(), integrator=ns.MoreauJean(dt=1e-3)).stats.struck_together == 0


def test_what_was_told_stands_in_the_summary_and_in_the_file(tmp_path):
    with pytest.warns(ns.SimultaneousImpactWarning):
        sol = ns.simulate(beads([1.0] * 5, NEWTON), (0, 0.1), [-5e-3, 0, 0, 0, 0], [1.0, 0, 0, 0, 0],
                          integrator=ns.MoreauJean(dt=1e-2))  # fmt: skip
    assert "were hit at once" in sol.summary()
    assert ns.Solution.load(sol.save(tmp_path / "run.npz")).stats == sol.stats


def discs(centres, e):
    """Discs of radius 0.1 m in a row, without weight; the first one moves to the others at 1 m/s."""
    scene = ns.Scene(gravity=(0.0, 0.0), material=ns.Material(mu=0.0, e=e))
    for k, x in enumerate(centres):
        velocity = (1.0, 0.0) if k == 0 else (0.0, 0.0)
        scene.body(ns.Disc(0.1), density=1.0, position=(x, 0.0), velocity=velocity, name=f"disc {k}")
    return scene


def test_a_body_of_a_scene_between_two_others_is_told():
    with pytest.warns(ns.SimultaneousImpactWarning, match=r"at t = 0\.05\d* s disc 1 was struck by several") as caught:
        sol = ns.simulate(discs([0.0, 0.25, 0.45], e=1.0), (0, 0.1), integrator=ns.MoreauJean(dt=1e-3))
    assert len(caught) == 1 and sol.stats.struck_together >= 1


def test_blows_of_a_scene_that_follow_one_another_and_blows_without_rebound_are_not_told():
    apart = silently(discs([0.0, 0.25, 0.46], e=1.0), (0, 0.1), integrator=ns.MoreauJean(dt=1e-3))
    np.testing.assert_allclose(apart.velocity[-1, :, 0], [0.0, 0.0, 1.0], rtol=0, atol=1e-9)
    assert apart.stats.struck_together == 0
    soft = silently(discs([0.0, 0.25, 0.45], e=0.0), (0, 0.1), integrator=ns.MoreauJean(dt=1e-3))
    assert soft.stats.struck_together == 0


def test_corners_of_one_box_on_a_floor_are_one_impact():
    scene = ns.Scene(gravity=(0.0, -9.81), material=ns.Material(mu=0.3, e=0.5))
    scene.fixed(ns.HalfPlane((0, 1)))
    scene.body(ns.Box(0.2, 0.2), density=1000, position=(0.0, 0.15))
    assert silently(scene, (0, 0.5), integrator=ns.MoreauJean(dt=1e-3)).stats.struck_together == 0


@of_all
def test_newtons_law_that_was_chosen_is_no_surprise(integrator):
    """The same answer without a warning; the summary counts it all the same."""
    chosen = [ns.Contact(e_N=1.0, impact="newton")] * 4
    sol = silently(beads([1.0] * 5, chosen), (0, 0.1), [-5e-3, 0, 0, 0, 0], [1.0, 0, 0, 0, 0], integrator=integrator)
    np.testing.assert_allclose(sol.u[-1], [-0.6, 0.4, 0.4, 0.4, 0.4], rtol=0, atol=1e-12)
    assert sol.stats.struck_together == 1 and "were hit at once" in sol.summary()


@pytest.mark.parametrize("name", sorted(model_entries()))
def test_no_run_of_a_ready_model_warns_by_default(name):
    """Who chose nothing is warned of nothing: a model takes the law of impact that is right for it."""
    model = load(name)()
    silently(model, (0.0, model.t_end), *model.state(), integrator=ns.MoreauJean(model.dt))
