"""Events of scenes: landings, partings, slips and sticks of pairs of bodies, and functions of the user."""

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.runs import pair_events

G, DT = 9.81, 1e-3
STEP = ns.MoreauJean(dt=DT)
LANDING, PARTING, SLIP, STICK = ns.SceneEventKind


def on_ground(mu=0.5, e=0.0, **ground):
    scene = ns.Scene(gravity=(0, -G), material=ns.Material(mu=mu, e=e))
    scene.fixed(ns.HalfPlane((0, 1)), name="ground", **ground)
    return scene


def with_block(**options):
    scene = on_ground()
    scene.body(ns.Box(0.2, 0.1), **({"mass": 2.0, "position": (0, 0.05), "name": "block"} | options))
    return scene


def with_ball(e, height=0.5):
    scene = on_ground(mu=0.0, e=e)
    scene.body(ns.Disc(0.1), mass=2.0, position=(0, 0.1 + height), name="ball")
    return scene


def run(scene, t_end, **options):
    return ns.simulate(scene, (0, t_end), integrator=STEP, **options)


def falling_on_ground_that_is_named_last():
    scene = ns.Scene(gravity=(0, -G))
    scene.body(ns.Disc(0.1), mass=1.0, position=(0, 0.105), name="ball")
    scene.fixed(ns.HalfPlane((0, 1)), name="ground")
    return scene


def kinds_of(events):
    return [event.kind for event in events]


def test_a_ball_that_bounces_lands_and_parts_at_the_times_of_its_parabolas():
    e, height = 0.5, 0.5
    events = run(with_ball(e, height), 0.9, record=("events",)).events
    speed = np.sqrt(2 * G * height)
    falls = speed / G + np.cumsum([0, 2 * e * speed / G])  # and the second flight, at e times the speed
    assert kinds_of(events)[:3] == [LANDING, PARTING, LANDING]
    np.testing.assert_allclose(events.t[[0, 2]], falls, atol=3 * DT)  # a step an impact, and one of rounding to steps
    assert events.t[1] == pytest.approx(events.t[0] + DT)
    assert (events[0].i, events[0].j) == ("ground", "ball")
    assert events[0].P_N == pytest.approx(2.0 * (1 + e) * speed, rel=2 * G * DT / speed)
    np.testing.assert_allclose(events[0].P, (0, events[0].P_N), rtol=1e-12)
    assert events[1].P_N == 0.0


def test_a_block_that_slides_sticks_when_its_speed_is_spent_and_slips_when_its_tray_is_drawn_away():
    stops = run(with_block(velocity=(1.0, 0)), 0.4, record=("events",)).events
    assert kinds_of(stops) == [STICK]
    assert stops.t[0] == pytest.approx(1.0 / (0.5 * G), abs=DT)

    scene = ns.Scene(gravity=(0, -G), material=ns.Material(mu=0.5))
    a, t_0 = 2.0 * 0.5 * G, 0.05  # an acceleration that friction cannot follow, from t_0 on
    tray = {"motion": lambda t: (0.5 * a * max(0.0, t - t_0) ** 2, 0.0)}
    scene.kinematic(ns.Box(2.0, 0.1), name="tray", **tray)
    scene.body(ns.Box(0.2, 0.1), mass=2.0, position=(0, 0.1), name="block")
    slips = run(scene, 0.1, record=("events",)).events
    assert kinds_of(slips) == [SLIP]
    assert slips.t[0] == pytest.approx(t_0, abs=DT)


def test_what_rests_from_the_start_has_no_events_and_what_is_asleep_costs_no_looks(monkeypatch):
    looks = []
    look = pair_events.PairEvents.look
    monkeypatch.setattr(pair_events.PairEvents, "look", lambda self, *step: (looks.append(step), look(self, *step)))
    solution = run(with_block(), 2.0, record=("events",), every=500)
    assert len(solution.events) == 0
    assert solution.stats.asleep > 1900
    assert len(looks) < 200


def test_recording_events_changes_no_bit_of_the_run():
    scene = with_block(velocity=(1.0, 0), spin=3.0)
    plain = run(scene, 0.3)
    watched = run(scene, 0.3, record=("bodies", "contacts", "ledger", "events"), events=lambda t, bodies: 1.0)
    np.testing.assert_array_equal(plain.q, watched.q)
    np.testing.assert_array_equal(plain.u, watched.u)
    assert plain.recorded == ("bodies", "contacts", "ledger")
    with pytest.raises(ns.InvalidInput, match="events was not recorded; simulate"):
        plain.events  # noqa: B018


def test_impulses_of_a_pair_are_on_its_second_body_whichever_detection_takes_first():
    scene = ns.Scene(gravity=(0, -G))
    scene.body(ns.Box(0.2, 0.2), mass=1.0, position=(0, 0.305), name="upper")
    scene.body(ns.Box(1.0, 0.2), mass=10.0, position=(0, 0.1), name="lower")
    scene.fixed(ns.HalfPlane((0, 1)), name="ground")
    scene.body(ns.Disc(0.1), mass=1.0, position=(0.3, 0.305), name="ball")
    events = run(scene, 0.1, record=("events",)).events
    for pair in (("upper", "lower"), ("lower", "ball")):
        (landing,) = events.of(*pair)
        assert (landing.i, landing.j, landing.kind) == (*pair, LANDING)
        assert landing.P[1] == pytest.approx(landing.P_N if landing.j == "ball" else -landing.P_N) and landing.P_N > 0
    (landing,) = run(falling_on_ground_that_is_named_last(), 0.1, record=("events",)).events
    assert (landing.i, landing.j) == ("ball", "ground")
    np.testing.assert_allclose(landing.P, (0, -landing.P_N))


def test_a_run_of_more_events_than_are_kept_ends_and_says_so(monkeypatch):
    monkeypatch.setattr(pair_events, "MOST_EVENTS", 3)
    with pytest.raises(ns.BudgetSpent, match="the room for 3 events is used up after") as failure:
        run(with_ball(0.8), 3.0, record=("events",))
    assert len(failure.value.solution.events) == 3


def test_a_function_of_the_user_finds_the_apex_and_the_landing_of_a_throw():
    def rises(t, bodies):
        return bodies["ball"].velocity[1]

    def low(t, bodies):
        return bodies["ball"].position[1] - 0.6

    low.direction = -1
    scene = ns.Scene(gravity=(0, -G))
    scene.body(ns.Disc(0.1), mass=1.0, position=(0, 0.5), velocity=(1, 3), name="ball")
    solution = run(scene, 0.6, events=[rises, low])
    np.testing.assert_allclose(solution.t_events[0], [3 / G], atol=1e-13)  # a straight line: to rounding
    down = (3 + np.sqrt(9 - 2 * G * 0.1)) / G  # of a parabola, which the cubic of a step has
    np.testing.assert_allclose(solution.t_events[1], [down], atol=1e-12)


def test_a_terminal_event_ends_the_run_with_its_step_and_is_a_success():
    def hits(t, bodies):
        return bodies["ball"].position[1] - 0.3

    hits.terminal = True
    solution = run(with_ball(0.0), 3.0, events=hits, every=1000)
    fall = np.sqrt(2 * 0.3 / G)
    assert solution.success and solution.status == ns.Status.EVENT_REACHED
    assert solution.t_events[0][0] == pytest.approx(fall, abs=DT)
    assert solution.t_events[0][0] <= solution.t[-1] <= solution.t_events[0][0] + DT
    assert solution["ball"].position[-1, 1] <= 0.3
    assert "was reached at t = " in solution.message


def test_the_second_event_ends_a_run_where_that_is_asked_for_and_later_ones_of_others_are_dropped():
    def beats(t, bodies):
        return np.sin(2 * np.pi * 10 * (t + 1e-4))

    def later(t, bodies):
        return t - 0.0999

    beats.terminal = 2
    solution = run(with_block(), 1.0, events=[beats, later])
    np.testing.assert_allclose(solution.t_events[0], [0.0499, 0.0999], atol=1e-6)
    assert solution.t[-1] == pytest.approx(0.1)


def test_a_function_sees_the_turn_of_the_shape_and_the_names_of_all_bodies():
    seen = {}

    def look(t, bodies):
        seen.update(bodies)
        return 1.0

    scene = ns.Scene(gravity=(0, 0, 0))
    q = np.array([np.cos(0.2), 0, np.sin(0.2), 0])
    two = ns.Compound((ns.Sphere(0.1), (0, 0, 0)), (ns.Sphere(0.1), (0.3, 0.2, 0)))  # axes of inertia of its own
    scene.body(two, mass=1.0, position=(1, 2, 3), turn=tuple(q), spin=(0, 0, 2), name="dumbbell")
    solution = run(scene, DT, events=look)
    assert list(seen) == ["dumbbell"]
    for now, last in zip(seen["dumbbell"], solution["dumbbell"][1:], strict=True):
        np.testing.assert_array_equal(now, last[-1])


@pytest.mark.parametrize(
    ("function", "message"),
    [
        (lambda t, bodies: bodies["bal"].turn, "raised InvalidInput: there is no body 'bal'; did you mean 'ball'"),
        (lambda t, bodies: float("nan"), "returned nan, at t = 0 s"),
    ],
)
def test_a_function_that_fails_ends_the_run_with_its_name(function, message):
    with pytest.raises(ns.EventFunctionError, match=message):
        run(with_ball(0.0), 0.1, events=function)


def test_saved_events_are_read_back(tmp_path):
    def falls(t, bodies):
        return bodies["ball"].position[1] - 0.3

    solution = run(with_ball(0.5), 0.9, record=("events",), events=falls)
    scene = with_ball(0.5)
    read = ns.SceneSolution.load(solution.save(tmp_path / "run.npz"), scene)
    assert read.scene is scene and read.recorded == ("events",)
    assert repr(read.events) == repr(solution.events) and len(read.events) > 2
    for name in ("t", "kind", "i", "j", "P_N", "P"):
        np.testing.assert_array_equal(getattr(read.events, name), getattr(solution.events, name))
    np.testing.assert_array_equal(read.t_events[0], solution.t_events[0])


def test_events_by_name_in_a_table_and_a_dataset():
    pytest.importorskip("pandas")
    pytest.importorskip("xarray")
    solution = run(with_ball(0.5), 0.5, record=("events",), events=lambda t, bodies: t - 0.1)
    table = solution.to_dataframe("events")
    assert list(table.kind) == [event.kind.name for event in solution.events] and set(table.j) == {"ball"}
    data = solution.to_xarray()
    np.testing.assert_array_equal(data.event_P_N, solution.events.P_N)
    np.testing.assert_allclose(data.t_events_0, [0.1])


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"record": ("events",)}, 'a checkpoint keeps no events; leave "events" out of record='),
        ({"events": lambda t, bodies: 1.0}, "a run with a checkpoint looks for no events"),
    ],
)
@pytest.mark.parametrize("integrator", [STEP, ns.Penalty(1e6)])
def test_a_run_with_a_checkpoint_is_refused_events(tmp_path, integrator, options, message):
    with pytest.raises(ns.InvalidInput, match=message):
        ns.simulate(with_block(), (0, 0.1), integrator=integrator, checkpoint=tmp_path / "run.nsc", **options)
    assert not list(tmp_path.iterdir())
