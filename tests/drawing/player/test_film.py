"""A film has the poses, impulses, events and curves of its run; packing gives them back; a page holds all it needs."""

import base64
import dataclasses
import gzip
import re

import numpy as np
import pytest

import nonsmooth as ns
from models import BeadChain, BeltOscillator, BouncingBall, PainleveRod, SpragSlip, WallPendulum, Woodpecker
from nonsmooth.drawing.player.film import Body, Contacts, Curve, Film, MarkKind, Shape, ShapeKind, no_contacts
from nonsmooth.drawing.player.packing import LEVELS, packed, quantised, rounded
from nonsmooth.drawing.player.page import EXACT_NUMBERS, Page, as_json, page_of, show, strongest
from nonsmooth.drawing.player.rigid_fit import pose_of, seen_from
from nonsmooth.drawing.player.solution_film import EVENTS_SHOWN, RECORDS_SHOWN, film_of_solution, record_after


@pytest.fixture(scope="module")
def ball():
    model = BouncingBall(e=0.5)
    return ns.simulate(model, (0, 1.6), *model.state(), integrator=ns.MoreauJean(dt=5e-4))  # 3200 steps


@pytest.fixture(scope="module")
def seizing_rod():
    rod = SpragSlip()
    return ns.simulate(rod, (0, 0.5), *rod.state(), integrator=ns.MoreauJean(dt=1e-3))


def unpacked(entry):
    """What the page makes of an array."""
    planes = np.frombuffer(gzip.decompress(base64.b64decode(entry["data"])), np.uint8)
    if entry["dtype"] == "d2":
        jumps = planes.reshape(2, -1).T.copy().view("<u2").reshape(entry["shape"])
        whole = np.cumsum(jumps, axis=0, dtype=np.uint16)
        return np.array(entry["low"]) + np.array(entry["step"]) * whole
    size = int(entry["dtype"][1:])
    return planes.reshape(size, -1).T.copy().view("<" + entry["dtype"]).reshape(entry["shape"])


# --- poses


def test_a_line_that_turns_has_its_angle_continuously_and_a_spring_is_no_rigid_body():
    angle = np.linspace(0.0, 9.0, 50)
    square = np.array([[-1.0, 0.0], [1.0, 0.0], [1.0, 1.0], [-1.0, 1.0]])
    turned = np.array([square @ [[np.cos(a), np.sin(a)], [-np.sin(a), np.cos(a)]] + [a, -a] for a in angle])
    pose = pose_of(turned)
    assert pose.is_rigid
    np.testing.assert_allclose(pose.angle, angle, atol=1e-14)
    np.testing.assert_allclose(
        pose.centre, np.column_stack([angle, 0.0 * angle]) + turned.mean(1) - [[1, 0]] * angle[:, None]
    )
    np.testing.assert_allclose(seen_from(pose, turned), np.tile(square - square.mean(0), (50, 1, 1)), atol=1e-13)
    assert not pose_of(np.array([[[0.0, 0.0], [1.0, 0.0]], [[0.0, 0.0], [1.1, 0.0]]])).is_rigid


def test_a_rod_of_the_film_is_where_and_turned_as_the_run_says():
    rod = PainleveRod()
    sol = ns.simulate(rod, (0, 0.3), *rod.state(), integrator=ns.MoreauJean(dt=1e-3))
    film = film_of_solution(sol)
    assert [body.name for body in film.bodies if not body.is_fixed] == ["rod"] and len(film.times) == len(sol.t)
    np.testing.assert_allclose(film.position[:, 1], sol.q[:, :2], atol=1e-15)
    np.testing.assert_allclose(film.turn[:, 1], sol.q[:, 2] - sol.q[0, 2], atol=1e-14)


@pytest.mark.parametrize("model", [BeltOscillator(), Woodpecker(), WallPendulum()], ids=lambda model: model.name)
def test_shapes_in_their_frames_are_the_lines_of_the_picture(model):
    sol = ns.simulate(model, (0, 20 * model.dt), *model.state(), integrator=ns.MoreauJean(dt=model.dt))
    film = film_of_solution(sol)
    first = sum(body.is_fixed for body in film.bodies)
    for k in (0, len(sol.t) - 1):
        for b, line in enumerate(model.shape(sol.q[k]), start=first):
            (shape,) = film.bodies[b].shapes
            points = shape.points[k] if shape.kind == ShapeKind.BENDING else shape.points
            c, s = np.cos(film.turn[k, b]), np.sin(film.turn[k, b])
            placed = film.position[k, b] + points @ np.array([[c, s], [-s, c]])
            np.testing.assert_allclose(placed, line[: len(placed)], atol=1e-6 * np.abs(line).max())  # RIGID


def swinging(shape, outline=None):
    """A pendulum that is drawn by a function."""

    def mass(t, q, p, M):
        M[0, 0] = 1.0

    def force(t, q, u, p, h):
        h[0] = -9.81 * np.sin(q[0])

    system = ns.System(coordinates=[("th", "rad")], mass=mass, force=force, shape=shape, outline=outline)
    return ns.simulate(system, (0, 0.1), [0.3], [0.0], integrator=ns.MoreauJean(dt=1e-2))


def test_lines_may_have_names_in_a_dictionary():
    def rod(q):
        return [[0.0, 0.0], [np.sin(q[0]), -np.cos(q[0])]]

    def bob(q):
        return np.array([[0.9, -0.1], [1.1, 0.1]]) * [np.sin(q[0]), 1.0]

    named = swinging(lambda q: {"rod": rod(q), "bob": bob(q)})
    listed = swinging(lambda q: (rod(q), bob(q)))
    one, other = film_of_solution(named), film_of_solution(listed)
    assert [body.name for body in one.bodies] == ["rod", "bob"]
    assert [body.name for body in other.bodies] == ["part 0", "part 1"]
    np.testing.assert_array_equal(one.position, other.position)
    assert len(named.picture(n=2).axes[0].lines) == 4


@pytest.mark.parametrize("drawn", [{}, [], 3, {"rod": 1.0}, [np.zeros((2, 3))], [np.zeros(2)], "rod", None])
def test_what_is_no_polyline_is_refused(drawn):
    with pytest.raises(ns.InvalidInput, match=r"shape\(q\) must return a list of polylines \(k, 2\)"):
        film_of_solution(swinging(lambda q: drawn))


@pytest.mark.parametrize("still", [[], {}, ()])
def test_where_nothing_stands_still_the_surroundings_are_an_empty_list(still):
    sol = swinging(lambda q: [[[0.0, 0.0], [np.sin(q[0]), -np.cos(q[0])]]], lambda: still)
    assert len(sol.picture(n=2).axes[0].lines) == 2  # the rod at two instants, nothing else
    assert [body.name for body in film_of_solution(sol).bodies] == ["part 0"]


@pytest.mark.parametrize("drawn", [3, {"wall": 1.0}, [np.zeros((2, 3))], "wall", None])
def test_surroundings_that_are_no_polylines_are_refused(drawn):
    with pytest.raises(ns.InvalidInput, match=r"outline\(\) must return a list of polylines \(k, 2\)"):
        swinging(lambda q: [np.zeros((2, 2))], lambda: drawn).picture()


# --- frames, impulses, events, curves


def test_frames_are_equally_spaced_records_and_those_beside_each_event(ball):
    film = film_of_solution(ball)
    assert RECORDS_SHOWN <= len(film.times) <= RECORDS_SHOWN + 2 * EVENTS_SHOWN
    assert set(film.times) <= set(ball.t) and film.times[-1] == ball.t[-1]
    assert np.diff(film.times).max() <= 3 * 5e-4 + 1e-12  # 3200 steps over 1200 frames
    for mark in film.marks:
        assert film.times[mark.frame] == ball.t[np.searchsorted(ball.t, mark.t, "right")]
        assert film.times[mark.frame - 1] == pytest.approx(mark.t, abs=1e-12)
    assert f"{len(film.times)} of {len(ball.t)} records are frames" in film.detail


def test_no_impulse_is_lost_between_frames(ball):
    film = film_of_solution(ball)
    assert len(film.times) < len(ball.t)
    assert film.contacts.P_N.sum() == pytest.approx(ball.P_N[1:].sum(), rel=1e-13)
    upto = np.searchsorted(ball.t, film.times[700], "right")
    assert film.contacts.P_N[:701].sum() == pytest.approx(ball.P_N[1:upto].sum(), rel=1e-13)


def test_an_impact_of_one_instant_is_shown_by_the_second_of_its_two_records():
    t = np.array([0.0, 0.5, 1.0, 1.0, 1.5])
    assert record_after(t, np.array([1.0, 0.5, 1.5])).tolist() == [3, 2, 4]


def test_a_paradox_is_marked_with_what_was_chosen(seizing_rod):
    marks = [mark for mark in film_of_solution(seizing_rod).marks if mark.choice]
    assert [mark.t for mark in marks] == [event.t for event in seizing_rod.paradoxes]
    assert [mark.choice for mark in marks] == [event.choice for event in seizing_rod.paradoxes]
    assert marks[0].kind == MarkKind.INCONSISTENT and "impact without collision" in marks[0].text


def test_events_of_the_user_are_marked(ball):
    model = BouncingBall(e=0.5)

    def half(t, q, u):
        return q[0] - 0.5

    sol = ns.simulate(model, (0, 0.4), *model.state(), integrator=ns.MoreauJean(dt=1e-3), events=half)
    (mark,) = [mark for mark in film_of_solution(sol).marks if mark.kind == MarkKind.USER]
    assert mark.t == sol.t_events[0][0]


@pytest.mark.filterwarnings("ignore::nonsmooth.SimultaneousImpactWarning")  # what is asked holds for it too
def test_more_events_than_are_marked_are_counted():
    chain = BeadChain(n=20)
    sol = ns.simulate(chain, (0, 0.5), *chain.state(), integrator=ns.MoreauJean(dt=1e-3))
    film = film_of_solution(sol)
    assert len(film.marks) == EVENTS_SHOWN < len(sol.event_rows)
    assert f"{len(sol.event_rows) - EVENTS_SHOWN} more events than the first" in film.detail


def test_curves_are_those_of_the_run(seizing_rod):
    curves = {(curve.group, curve.name): curve.values for curve in film_of_solution(seizing_rod).curves}
    np.testing.assert_array_equal(curves["coordinates", "θ"], seizing_rod.q[:, 1])
    np.testing.assert_array_equal(curves["gaps", "g_0"], seizing_rod.g_N[:, 0])
    kinetic = seizing_rod.ledger["kinetic"]
    np.testing.assert_array_equal(curves["energies", "kinetic"], kinetic - kinetic[0])
    np.testing.assert_allclose(curves["forces", "normal 0"][1:], seizing_rod.P_N[1:, 0] / np.diff(seizing_rod.t))
    assert np.isnan(curves["forces", "normal 0"][0])


def test_a_friction_law_gives_the_cone_its_static_coefficient():
    belt = BeltOscillator(mu_k=0.3, m0=0.4, law="two-coefficient")
    sol = ns.simulate(belt, (0, 0.1), *belt.state(), integrator=ns.MoreauJean(dt=1e-2))
    film = film_of_solution(sol)
    assert (film.contacts.mu == 0.4).all() and "gaps" not in {curve.group for curve in film.curves}


def test_a_run_without_length_or_contacts_has_a_film():
    for model in (BouncingBall(), WallPendulum()):
        sol = ns.simulate(model, (0, 0), *model.state(), integrator=ns.MoreauJean(dt=1e-3))
        assert len(film_of_solution(sol).times) == 1 and "<html" in page_of(film_of_solution(sol))


# --- packing


def test_packed_arrays_come_back_bit_for_bit():
    values = np.random.default_rng(1).normal(size=(7, 3)).astype(np.float32)
    assert (unpacked(packed(values)) == values).all()
    assert (unpacked(packed(values.astype(float), "<f8")) == values).all()
    assert unpacked(packed(np.array([-1, 0, 3]), "<i1")).tolist() == [-1, 0, 3]
    assert unpacked(packed(np.zeros((0, 2)))).shape == (0, 2)


def test_quantised_positions_are_half_a_step_away_at_most():
    values = np.random.default_rng(2).normal(size=(40, 5, 3)) * [1.0, 10.0, 0.0] + [3.0, 0.0, 7.0]
    step = np.ptp(values, axis=(0, 1)) / LEVELS
    assert (np.abs(unpacked(quantised(values)) - values) <= 0.5 * step * (1 + 1e-9) + 1e-14).all()


def test_rounded_impulses_keep_eleven_bits():
    values = np.random.default_rng(3).lognormal(0.0, 8.0, 1000)
    assert (np.abs(rounded(values) / values - 1.0) <= 2.0**-11).all()
    assert rounded(np.zeros(2)).tolist() == [0.0, 0.0]


# --- the page


def spatial_film(n_t=3, n_b=2, per=0):
    turn = np.tile([1.0, 0.0, 0.0, 0.0], (n_t, n_b, 1))
    position = np.random.default_rng(4).normal(size=(n_t, n_b, 3))
    bodies = tuple(Body(f"ball {i}", (Shape(ShapeKind.SPHERE, np.zeros((1, 3)), 0.1),)) for i in range(n_b))
    contacts = no_contacts(n_t, 3)
    if per:
        m = n_t * per
        up, size = np.tile([0.0, 0.0, 1.0], (m, 1)), np.random.default_rng(5).random(m)
        one = np.ones(m)
        contacts = Contacts(np.arange(n_t + 1) * per, np.arange(m) % per, up, up, one, 0 * one, size, 0 * up, one)
    return Film("balls", np.arange(n_t) * 0.1, bodies, position, turn, contacts)


def test_a_page_is_one_file_that_names_no_other(ball, tmp_path):
    path = show(ball, tmp_path / "ball.html")
    text = path.read_text()
    assert path.stat().st_size < 300_000 and "%%" not in text
    for page in (text, page_of(spatial_film())):
        assert not re.search(r"""(src|href)=(?!["']data:)|@import|url\(|fetch\(|XMLHttp""", page)


def test_three_js_is_in_spatial_pages_only_and_its_licence_beside_it(ball):
    from importlib import resources

    script = re.compile(r'id="three">(.*?)</script>', re.S)
    assert script.search(page_of(film_of_solution(ball)))[1] == ""
    source = gzip.decompress(base64.b64decode(script.search(page_of(spatial_film()))[1]))
    assert b"SPDX-License-Identifier: MIT" in source[:300]
    assert "three.js authors" in (resources.files("nonsmooth.drawing.player") / "three.LICENSE").read_text()


def test_names_of_a_film_are_text_in_the_page_and_no_markup():
    film = dataclasses.replace(spatial_film(), title="<script>alert(1)</script>", about={"a": "</script><b>"})
    text = page_of(film)
    assert "alert(1)" in text and "<script>alert" not in text and "</script><b>" not in text


def test_a_large_film_says_what_it_rounds_and_leaves_out():
    film = spatial_film(n_t=500, n_b=1000, per=1300)
    assert film.position.size + film.turn.size > EXACT_NUMBERS
    data = as_json(film)
    assert (
        "positions to" in data["detail"] and "of 650000 contacts in all frames the 600000 strongest" in data["detail"]
    )
    step = np.ptp(film.position, axis=(0, 1)) / LEVELS
    assert (np.abs(unpacked(data["position"]) - film.position) <= 0.5 * step * (1 + 1e-9)).all()
    assert sum(len(entry["data"]) for entry in (data["position"], data["turn"], *data["contacts"].values())) < 20e6


def test_of_too_many_contacts_the_strongest_of_each_frame_are_kept():
    contacts = spatial_film(per=5).contacts
    kept = strongest(contacts, 2)
    assert kept.start.tolist() == [0, 2, 4, 6]
    for k in range(3):
        assert sorted(kept.P_N[2 * k : 2 * k + 2]) == sorted(contacts.P_N[5 * k : 5 * k + 5])[-2:]
    assert strongest(contacts, 5) is contacts


def test_without_a_path_a_notebook_shows_the_page(ball):
    page = ball.view()
    assert isinstance(page, Page) and page._repr_html_().startswith("<iframe") and "notebook" in repr(page)


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"position": np.zeros((3, 2, 4))}, "position must be"),
        ({"turn": np.zeros((3, 2))}, "turn must have the shape"),
        ({"contacts": no_contacts(2, 3)}, "start must count"),
        ({"curves": (Curve("energies", "kinetic", "J", np.zeros(2)),)}, "each curve"),
        (
            {"bodies": (Body("a", (Shape(ShapeKind.DISC, np.zeros((1, 2)), 1.0),)),) * 2},
            "disc is no shape of a film in 3",
        ),
    ],
)
def test_a_film_whose_parts_do_not_fit_is_refused(changes, said):
    with pytest.raises(ns.InvalidInput, match=said):
        dataclasses.replace(spatial_film(), **changes)


def test_a_solution_without_a_picture_is_refused(ball, tmp_path):
    loaded = ns.Solution.load(ball.save(tmp_path / "ball.npz"))
    assert loaded.view(tmp_path / "ball.html").stat().st_size > 0
    with pytest.raises(ns.InvalidInput, match="shape"):
        dataclasses.replace(loaded, system=None).view(tmp_path / "ball.html")
    with pytest.raises(ns.InvalidInput, match=r"one of \.html"):
        ball.view(tmp_path / "ball.gif")
