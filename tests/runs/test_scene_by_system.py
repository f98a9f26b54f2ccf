"""Scenes integrated by EventDriven, Adaptive and "auto": as their systems, with the results of scenes."""

import math

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.results.events import SceneEventKind

G = 9.81
GROUND = ns.HalfPlane((0, 1))
METHODS = [ns.EventDriven(rtol=1e-10, atol=1e-12), ns.Adaptive(rtol=1e-8, atol=1e-10)]
EVERYTHING = ("bodies", "contacts", "ledger", "events")


def bouncing(e=0.5, height=0.5, mu=0.0):
    scene = ns.Scene(gravity=(0, -G), material=ns.Material(mu=mu, e=e), t_end=1.0)
    scene.fixed(GROUND, name="ground")
    scene.body(ns.Disc(0.1), mass=2.0, position=(0, 0.1 + height), velocity=(1.0, 0), name="disc")
    return scene


@pytest.mark.upkeep
@pytest.mark.parametrize("integrator", METHODS)
def test_a_bounce_of_a_scene_has_the_height_and_the_impulse_of_its_parabola(integrator):
    e, height, end = 0.5, 0.5, 0.6
    fall = math.sqrt(2 * height / G)
    v = G * fall
    sol = ns.simulate(bouncing(e, height), (0, end), integrator=integrator, record=EVERYTHING)
    assert isinstance(sol, ns.SceneSolution) and sol.success
    rise = end - fall
    np.testing.assert_allclose(sol["disc"].position[-1], [end, 0.1 + e * v * rise - G * rise**2 / 2], rtol=1e-7)
    np.testing.assert_allclose(sol["disc"].velocity[-1], [1.0, e * v - G * rise], rtol=1e-6)
    assert sol["ground"].position[-1].tolist() == [0.0, 0.0]
    landing, parting = list(sol.events)[:2]
    assert (landing.kind, parting.kind) == (SceneEventKind.LANDING, SceneEventKind.PARTING)
    assert (landing.i, landing.j) == ("ground", "disc") and landing.t == pytest.approx(fall, rel=1e-7)
    np.testing.assert_allclose(landing.P, [0.0, 2.0 * (1 + e) * v], rtol=1e-6, atol=1e-9)
    ledger = sol.ledger
    lost = -(1 - e**2) * 0.5 * 2.0 * v**2
    assert ledger["normal"][-1] == pytest.approx(lost, rel=1e-6)
    drift = ledger["kinetic"] + ledger["potential"] - ledger["normal"]
    np.testing.assert_allclose(drift, drift[0], rtol=1e-7)


@pytest.mark.parametrize("integrator", METHODS)
def test_a_disc_slides_until_it_rolls_and_its_contact_says_so(integrator):
    scene, mu = bouncing(0.0, 0.0, mu=0.2), 0.2
    sol = ns.simulate(scene, integrator=integrator, record=EVERYTHING)
    until = 1.0 / (3 * mu * G)  # v/(3 mu g) of a disc
    stick = next(event for event in sol.events if event.kind == SceneEventKind.STICK)
    assert stick.t == pytest.approx(until, rel=1e-5)
    contacts = sol.contacts(1.0)
    assert len(contacts) == 1 and contacts.gap == pytest.approx(0.0, abs=1e-9)
    np.testing.assert_allclose(contacts.normal, [[0, 1]], atol=1e-15)
    np.testing.assert_allclose(contacts.point[0], [sol["disc"].position[-1, 0], 0.0], atol=1e-9)
    assert sol["disc"].velocity[-1, 0] == pytest.approx(2 / 3, rel=1e-6)
    sliding = sol.contacts(0.5 * until)
    assert sliding.mode[0] == ns.ContactMode.SLIDE
    # impulses are those on the second body, the disc: up, and against its motion
    assert sliding.P[0, 1] > 0 and sliding.P[0, 0] == pytest.approx(-mu * sliding.P[0, 1], rel=1e-9)


@pytest.mark.upkeep
@pytest.mark.parametrize("integrator", [*METHODS, ns.MoreauJean(1e-4)])
def test_a_pendulum_of_a_joint_keeps_its_energy_and_its_pin(integrator):
    scene = ns.Scene(gravity=(0, -G))
    scene.fixed(ns.Disc(0.01), name="hook")
    scene.body(ns.Box(0.02, 1.0), mass=1.0, inertia=1 / 12, position=(0.5, 0), turn=math.pi / 2, name="rod")
    scene.joint("hook", "rod", at=(0, 0), name="pin")
    sol = ns.simulate(scene, (0, 0.5), integrator=integrator, record=("bodies", "contacts", "ledger"))
    assert sol.success
    total = sol.ledger["kinetic"] + sol.ledger["potential"]
    np.testing.assert_allclose(total, total[0], atol=1e-5)
    arm = np.linalg.norm(sol["rod"].position, axis=1)
    np.testing.assert_allclose(arm, 0.5, atol=1e-6)
    # m a = m g + P' along the rod at the end: the pin carries the weight and the turning
    spin, turn, t = sol["rod"].spin[-1], sol["rod"].turn[-1], sol.t
    along = np.array([math.sin(turn), -math.cos(turn)])
    force = sol.joint("pin").P[-1] / (t[-1] - t[-2])
    exact = -(0.5 * spin**2 + G * math.cos(turn))
    assert force @ along == pytest.approx(exact, rel=2e-2 if isinstance(integrator, ns.Adaptive) else 2e-3)


@pytest.mark.upkeep
@pytest.mark.parametrize("integrator", METHODS)
def test_a_disc_on_a_guided_lift_is_carried_and_its_work_is_that_of_the_lift(integrator):
    scene = ns.Scene(gravity=(0, -G), material=ns.Material(mu=0.5))
    scene.kinematic(GROUND, velocity=(0.0, 0.3), name="lift")
    scene.body(ns.Disc(0.1), mass=2.0, position=(0, 0.1), velocity=(0, 0.3), name="disc")
    sol = ns.simulate(scene, (1.0, 2.0), integrator=integrator)
    np.testing.assert_allclose(sol["disc"].position[-1], [0.0, 0.4], atol=1e-9)
    np.testing.assert_allclose(sol["lift"].position[-1], [0.0, 0.3], rtol=1e-14)
    assert sol.ledger["surface"][-1] == pytest.approx(2.0 * G * 0.3, rel=1e-8)


def test_spheres_in_space_come_back_as_spheres_that_spin_on():
    scene = ns.Scene(gravity=(0, 0, -G), material=ns.Material(mu=0.0, e=1.0))
    scene.fixed(ns.HalfSpace((0, 0, 1)), name="ground")
    scene.body(ns.Sphere(0.1), mass=1.0, position=(0, 0, 0.6), spin=(0, 0, 2.0), name="ball")
    sol = ns.simulate(scene, (0, 0.5), integrator=ns.EventDriven(rtol=1e-10))
    np.testing.assert_allclose(sol["ball"].turn[-1], [math.cos(0.5), 0, 0, math.sin(0.5)], rtol=1e-14)
    total = sol.ledger["kinetic"] + sol.ledger["potential"]
    np.testing.assert_allclose(total, total[0], rtol=1e-9)
    by_steps = ns.simulate(scene, (0, 0.5), integrator=ns.MoreauJean(1e-4))
    np.testing.assert_allclose(sol["ball"].position[-1], by_steps["ball"].position[-1], atol=2e-3)


def test_events_of_the_user_are_located_in_a_scene_by_its_system():
    def level(t, bodies):
        return bodies["disc"].position[1] - 0.3

    level.terminal = 1
    sol = ns.simulate(bouncing(), integrator=ns.EventDriven(rtol=1e-10), events=level)
    exact = math.sqrt(2 * 0.3 / G)
    assert sol.t_events[0] == pytest.approx([exact], rel=1e-12) and sol.t[-1] == pytest.approx(exact, rel=1e-12)


def test_auto_takes_located_events_where_contacts_are_few_and_steps_elsewhere():
    few = ns.simulate(bouncing())
    assert "EventDriven" in few.about["integrator"] and "1 contact" in few.about["chosen"]
    assert "EventDriven" in few.summary()
    boxes = bouncing()
    boxes.body(ns.Box(0.2, 0.2), mass=1.0, position=(1, 0.1), name="box")
    boxes.dt = 1e-2
    by_steps = ns.simulate(boxes, (0, 0.1))
    assert by_steps.about["integrator"] == repr(ns.MoreauJean(1e-2)) and "touch along faces" in by_steps.about["chosen"]
    within = ns.simulate(boxes, (0, 0.1), integrator=ns.Auto(rtol=1e-6))
    assert "Adaptive(rtol=1e-06" in within.about["integrator"] and "touch along faces" in within.about["chosen"]
    kept = ns.simulate(bouncing(), (0, 0.1), record=["bodies", "pairs"])
    assert "MoreauJean" in kept.about["integrator"] and "takes no record" in kept.about["chosen"]


def many(n):
    scene = ns.Scene(gravity=(0, -G))
    for k in range(n):
        scene.body(ns.Disc(0.1), mass=1.0, position=(k, 0), name=f"disc {k}")
    return scene


def test_too_many_contacts_are_refused_with_their_number_and_the_way_out():
    said = r"EventDriven takes scenes of up to \d+ contacts .* 4950.*MoreauJean\(dt\)"
    with pytest.raises(ns.InvalidInput, match=said):
        ns.simulate(many(100), (0, 1), integrator=ns.EventDriven())
    assert "MoreauJean" in ns.simulate(many(100), (0, 1e-3)).about["integrator"]
    by_steps = ns.simulate(many(100), (0, 0.1), integrator=ns.Adaptive(1e-4))
    assert "4950" in by_steps.about["chosen"] and by_steps.stats.lengths is not None
    np.testing.assert_allclose(by_steps.position[-1, :, 1], -0.5 * G * 0.01, rtol=1e-12)


@pytest.mark.parametrize(
    "options", [{"checkpoint": "x"}, {"resume": "x"}, {"threads": 2}, {"record": ["bodies", "pairs"]}]
)
def test_what_a_run_by_the_system_does_not_take_is_named(options):
    with pytest.raises(ns.InvalidInput, match=f"EventDriven integrates a scene as its system.* {next(iter(options))}="):
        ns.simulate(bouncing(), integrator=ns.EventDriven(), **options)


def test_a_failure_carries_what_was_computed_as_a_scene():
    with pytest.raises(ns.BudgetSpent) as failure:
        ns.simulate(bouncing(), integrator=ns.EventDriven(), max_steps=3)
    assert isinstance(failure.value.solution, ns.SceneSolution) and failure.value.solution.stats.steps == 3


def test_a_paradox_of_a_scene_by_its_system_names_the_bodies():
    rod = ns.Scene(gravity=(0, -G), material=ns.Material(mu=2.0))
    rod.fixed(GROUND, name="ground")
    rod.body(ns.Capsule(1.0, 1e-9), mass=1.0, inertia=1 / 12, position=(0, 0.5 * math.sin(math.pi / 3) + 1e-9),
             turn=math.pi / 3, velocity=(-1.0, 0), name="rod")  # fmt: skip
    sol = ns.simulate(rod, (0, 0.01), integrator=ns.EventDriven())
    paradox = sol.paradoxes[0]
    assert (paradox.kind.name, paradox.i, paradox.j) == ("INCONSISTENT", "ground", "rod")
    by_steps = ns.simulate(rod, (0, 0.01), integrator=ns.MoreauJean(1e-4)).paradoxes[0]
    assert (by_steps.kind, by_steps.slip_before) == (paradox.kind, paradox.slip_before)


def test_a_run_by_the_system_is_drawn_saved_and_read_as_any_of_a_scene(tmp_path):
    scene = bouncing(mu=0.3)
    sol = ns.simulate(scene, integrator=ns.Adaptive(), record=EVERYTHING)
    sol.save(tmp_path / "run.npz")
    back = ns.SceneSolution.load(tmp_path / "run.npz", scene)
    np.testing.assert_array_equal(back.position, sol.position)
    assert "disc" in sol.view(tmp_path / "run.html").read_text()
    assert sol.to_dataframe("contacts").shape[0] == len(sol.all_contacts.i)
    sol.plot(tmp_path / "run.png")
    sol.picture(tmp_path / "picture.png", n=2)


def test_a_selection_rule_is_that_of_the_system():
    with pytest.raises(ns.InvalidInput, match="no selection rule"):
        ns.simulate(bouncing(), integrator=ns.EventDriven(), selection="none")
    assert ns.simulate(bouncing(), integrator=ns.EventDriven(), selection="lift-off").success


def rod_that_strikes(impact, e=0.8, mu=0.3):
    """A slanted rod that slides and strikes the ground with its lower tip."""
    scene = ns.Scene(gravity=(0, 0), material=ns.Material(mu=mu, e=e, impact=impact))
    scene.fixed(GROUND, name="ground")
    scene.body(ns.Capsule(1.0, 1e-9), mass=1.0, inertia=1 / 12, position=(0, 0.5 * math.sin(1.0) + 1e-9), turn=1.0,
               velocity=(-2.0, -1.0), name="rod")  # fmt: skip
    return scene


@pytest.mark.parametrize("integrator", METHODS)
@pytest.mark.parametrize("law", ["newton", "poisson", "energetic"])
def test_a_scene_of_few_contacts_rebounds_by_the_law_that_its_material_names(law, integrator):
    e, mu = 0.8, 0.3
    sol = ns.simulate(rod_that_strikes(law, e, mu), (0, 0.01), integrator=integrator, record=EVERYTHING)
    P = next(event for event in sol.events if event.kind == SceneEventKind.LANDING)
    # W_N = (0, 1, -c/2), W_F = (1, 0, s/2) at the lower tip of a rod of m = l = 1
    c, s = math.cos(1.0), math.sin(1.0)
    G_NN, G_NF = 1.0 + 3.0 * c * c, -3.0 * s * c
    p = G_NN + mu * G_NF  # of a slide to the left, P_F = mu P_N
    # the slide goes on through the impact: |gamma_F| falls by less than it was
    gain = -2.0 + (G_NF + mu * (1.0 + 3.0 * s * s)) * (1 + e) / p
    assert gain < 0.0
    # with a slide in one direction all three laws agree: e is a ratio of velocities, impulses and works at once
    assert P.P_N == pytest.approx((1 + e) / p, rel=1e-6) and P.P[0] == pytest.approx(mu * P.P_N, rel=1e-6)


def test_laws_of_impact_part_where_a_slide_is_reversed_as_those_of_a_contact_do():
    found = {}
    for law in ("newton", "poisson", "energetic"):
        scene = rod_that_strikes(law, mu=1.5)
        sol = ns.simulate(scene, (0, 1e-3), integrator=ns.EventDriven(), record=EVERYTHING)
        system = scene.system()
        assert [contact.impact for contact in system.contacts] == [law, law]
        by_hand = ns.simulate(system, (0, 1e-3), *scene.state(), integrator=ns.EventDriven())
        np.testing.assert_array_equal(sol["rod"].velocity[-1], by_hand.u[-1, :2])
        found[law] = sol["rod"].velocity[-1].tolist()
    assert found["newton"] != found["poisson"] != found["energetic"]


def test_springs_refuse_laws_of_impact_by_name():
    with pytest.raises(ns.InvalidInput, match="a material has impact = 'energetic'.* take MoreauJean"):
        ns.simulate(rod_that_strikes("energetic"), (0, 0.01), integrator=ns.Penalty(1e5))
    assert ns.simulate(rod_that_strikes("newton"), (0, 0.01), integrator=ns.MoreauJean(1e-3)).success
    with pytest.raises(ns.InvalidInput, match="no impact law 'elastic'"):
        ns.Material(impact="elastic")
    scene = rod_that_strikes("energetic")
    scene.body(ns.Disc(0.1), mass=1.0, position=(5, 1), material=ns.Material(impact="poisson"), name="disc")
    with pytest.raises(ns.InvalidInput, match="have unlike laws of impact"):
        scene.system([("disc", "ground")])
