"""The player in a real browser: what it shows and says is what the run did.

A Chromium without a window opens the files; `window.player` (docs/viewer.md) is read, and screenshots are looked at.
"""

import base64
import html
import io
import time

import numpy as np
import pytest

import nonsmooth as ns
from benchmarks.chromium import new_chromium
from models import BouncingBall, RockingBlock, SpragSlip, WallPendulum
from models.scenes import BoxStack, Pyramid
from nonsmooth.drawing.player.film import Body, Contacts, Curve, Film, Shape, ShapeKind
from nonsmooth.drawing.player.packing import LEVELS
from nonsmooth.drawing.player.page import page_of

FLOAT32 = 2.0**-23  # relative: the page keeps numbers in float32
READY = 20.0  # s, for a page to start on a busy machine


@pytest.fixture(scope="module")
def chromium(tmp_path_factory):
    try:
        opened = new_chromium(tmp_path_factory.mktemp("profile"))
    except ns.MissingExtra as reason:
        pytest.skip(f"the player is not tested in a browser: {reason}")
    yield opened
    opened.quit()


class Opened:
    """A page in the browser."""

    def __init__(self, chromium, path):
        self.chromium = chromium
        chromium.get(path.as_uri())
        self.wait_for("document.documentElement.dataset.ready")
        assert self.ask("document.documentElement.dataset.ready") == "yes", self.ask("document.body.innerText")
        self.do("player.setDark(false)")

    def ask(self, expression):
        return self.chromium.execute_script(f"return {expression}")

    def do(self, statement):
        self.chromium.execute_script(statement)

    def wait_for(self, expression):
        until = time.monotonic() + READY
        while not self.ask(expression):
            assert time.monotonic() < until, f"{expression} did not come true in {READY} s"
            time.sleep(0.02)

    def curve(self, group, name):
        return next(c["value"] for c in self.ask("player.curves()") if (c["group"], c["name"]) == (group, name))

    def pixel_of(self, point):
        """Where in a screenshot a point of the scene is."""
        left, top = self.ask("(({left, top}) => [left, top])(document.getElementById('stage').getBoundingClientRect())")
        return np.array(self.ask(f"player.project({list(map(float, point))})")) + [left, top]

    def screenshot(self):
        from PIL import Image

        return np.asarray(Image.open(io.BytesIO(self.chromium.get_screenshot_as_png())).convert("RGB")).astype(int)

    def scene(self):
        """The screenshot with everything but the scene white."""
        shot = self.screenshot()
        box = self.ask(
            "(b => [b.left, b.top, b.right, b.bottom])(document.getElementById('stage').getBoundingClientRect())"
        )
        left, top, right, bottom = (round(x) for x in box)
        blank = np.full_like(shot, 255)
        blank[top:bottom, left:right] = shot[top:bottom, left:right]
        return blank

    def complaints(self):
        return [entry["message"] for entry in self.chromium.get_log("browser") if entry["level"] == "SEVERE"]


def is_blue(shot):
    """The pixels of bodies: blue well above red."""
    return shot[..., 2] - shot[..., 0] > 25


@pytest.fixture(scope="module")
def ball(chromium, tmp_path_factory):
    model = BouncingBall(e=0.5)
    sol = ns.simulate(model, (0, 1), *model.state(), integrator=ns.MoreauJean(dt=1e-3))
    return sol, sol.view(tmp_path_factory.mktemp("ball") / "ball.html")


@pytest.fixture(scope="module")
def rod(chromium, tmp_path_factory):
    model = SpragSlip()
    sol = ns.simulate(model, (0, 0.6), *model.state(), integrator=ns.MoreauJean(dt=1e-3))
    return sol, sol.view(tmp_path_factory.mktemp("rod") / "rod.html")


@pytest.mark.upkeep
def test_each_frame_says_what_the_run_did(chromium, rod):
    sol, path = rod
    page = Opened(chromium, path)
    assert page.ask("player.frames") == len(sol.t) and page.ask("player.bodies").index("rod") == 2
    first = np.array([0.0, sol.q[0, 0]])  # the pivot
    for k in (0, 1, 37, 300, len(sol.t) - 1):
        page.do(f"player.seek({float(sol.t[k])!r})")
        assert page.ask("player.frame") == k and page.ask("player.time") == sol.t[k]
        body = page.ask("player.body(2)")
        assert body["turn"][0] == pytest.approx(sol.q[k, 1] - sol.q[0, 1], abs=4 * FLOAT32)
        middle = np.array([0.0, sol.q[k, 0]]) - 2.5 * np.array([np.cos(sol.q[k, 1]), np.sin(sol.q[k, 1])])
        np.testing.assert_allclose(body["position"], middle, atol=4 * FLOAT32 * np.abs(first).max())
        assert page.curve("velocities", "θ'") == pytest.approx(sol.u[k, 1], rel=FLOAT32)
        kinetic = sol.ledger["kinetic"]
        assert page.curve("energies", "kinetic") == pytest.approx(kinetic[k] - kinetic[0], rel=FLOAT32)
        (contact,) = page.ask("player.contacts()")
        assert contact["mode"].split()[0] == ("stick", "slide")[int(sol.mode[k, 0]) - 1]
        if k:
            force = sol.P_N[k, 0] / (sol.t[k] - sol.t[k - 1])
            assert contact["normal"] == pytest.approx(force, rel=8 * FLOAT32)
            assert contact["friction"] == pytest.approx(abs(sol.P_F[k, 0, 0]) / 1e-3, rel=1e-5)
    assert page.complaints() == []


def test_a_body_is_drawn_where_the_run_has_it(chromium, ball):
    sol, path = ball
    page = Opened(chromium, path)
    page.do("document.getElementById('forces').click()")
    heights, diameters = [], []
    for t in (0.0, 0.3, 0.7):
        page.do(f"player.seek({t})")
        k = int(page.ask("player.frame"))
        centre = page.pixel_of([0.0, np.interp(page.ask("player.time"), sol.t, sol.q[:, 0]) + 0.05])
        edge = page.pixel_of([0.05, np.interp(page.ask("player.time"), sol.t, sol.q[:, 0]) + 0.05])
        y, x = np.nonzero(is_blue(page.scene()))
        found = [(x.min() + x.max()) / 2, (y.min() + y.max()) / 2]
        np.testing.assert_allclose(found, centre, atol=1.5, err_msg=f"frame {k}")
        assert np.ptp(x) / 2 == pytest.approx(edge[0] - centre[0], abs=2.0)
        heights.append([found[1], sol.q[k, 0]])
        diameters.append(np.ptp(x) + 1)
    pixels, metres = np.diff(heights, axis=0).T
    # the ball, 0.1 m wide, is the measure: its edge is found to a pixel of some 20
    np.testing.assert_allclose(-pixels * 0.1 / np.mean(diameters), metres, rtol=0.1)
    assert page.complaints() == []


def test_zoom_and_drag_move_what_is_drawn_and_what_is_projected_alike(chromium, ball):
    from selenium.webdriver import ActionChains

    page = Opened(chromium, ball[1])
    before = page.pixel_of([0.0, 0.5])
    stage = chromium.find_element("id", "stage")
    ActionChains(chromium).click_and_hold(stage).move_by_offset(40, -25).release().perform()
    np.testing.assert_allclose(page.pixel_of([0.0, 0.5]) - before, [40, -25], atol=1.0)
    page.do("document.getElementById('stage').dispatchEvent(new WheelEvent('wheel', {deltaY: 300, clientX: 90}))")
    centre = page.pixel_of([0.0, 1.05])
    y, x = np.nonzero(is_blue(page.scene()))
    assert (x.min() + x.max()) / 2 == pytest.approx(centre[0], abs=1.5)


def test_it_plays_in_the_time_of_the_run_stops_at_the_end_and_starts_again(chromium, ball):
    sol, path = ball
    page = Opened(chromium, path)
    page.do("player.speed = 0.5; window.began = performance.now(); player.play()")
    page.wait_for("player.time > 0.1")
    played, waited = page.ask("[player.time, (performance.now() - began) / 1000]")
    assert page.ask("player.isPlaying") and played <= 0.5 * waited + 1e-3
    page.do("player.speed = 5")
    page.wait_for("!player.isPlaying")
    assert page.ask("player.time") == sol.t[-1] and page.ask("player.rate") > 1
    page.do("player.play(); player.pause()")
    assert page.ask("player.time") < sol.t[-1]


def test_a_drag_on_the_time_line_and_keys_move_in_time(chromium, ball):
    from selenium.webdriver import ActionChains, Keys

    sol, path = ball
    page = Opened(chromium, path)
    chart = chromium.find_elements("css selector", "#charts .chart canvas")[1]
    left, width = 62, chart.size["width"] - 62 - 14  # the axis within the chart
    for share in (0.25, 0.8):
        aim = left + share * width - chart.size["width"] / 2
        ActionChains(chromium).move_to_element_with_offset(chart, round(aim), 20).click().perform()
        assert page.ask("player.time") == pytest.approx(share * sol.t[-1], abs=1.5 / width * sol.t[-1] + 1e-3)
    frame = page.ask("player.frame")
    ActionChains(chromium).send_keys(Keys.ARROW_RIGHT, Keys.ARROW_RIGHT, Keys.ARROW_LEFT).perform()
    assert page.ask("player.frame") == frame + 1
    ActionChains(chromium).send_keys(Keys.HOME, "n").perform()
    assert page.ask("player.frame") == page.ask("player.marks[0].frame")
    assert sol.t[np.searchsorted(sol.t, sol.events[0].t, "right")] == page.ask("player.time")
    assert page.complaints() == []


def test_a_paradox_is_told_with_what_was_chosen(chromium, rod):
    sol, path = rod
    page = Opened(chromium, path)
    told = chromium.find_element("id", "events").text
    for paradox in sol.paradoxes:
        assert f"{paradox.t:.5f} s" in told
    assert "no force fits the sliding: impact without collision, then stick" in told
    assert [mark["choice"] for mark in page.ask("player.marks") if mark["choice"]] == [p.choice for p in sol.paradoxes]


def test_a_click_picks_a_body_and_its_state_is_told(chromium, tmp_path):
    from selenium.webdriver import ActionChains

    block = RockingBlock()
    sol = ns.simulate(block, (0, 0.5), *block.state(), integrator=ns.MoreauJean(dt=1e-3))
    page = Opened(chromium, sol.view(tmp_path / "block.html"))
    stage = chromium.find_element("id", "stage")
    x, y = page.ask("player.project(player.body(1).position)")
    aim = [round(x - stage.size["width"] / 2), round(y - stage.size["height"] / 2)]
    ActionChains(chromium).move_to_element_with_offset(stage, *aim).click().perform()
    assert page.ask("player.picked") == 1
    told = chromium.find_element("id", "body").text
    assert "block" in told and f"y {sol.q[0, 1]:.4f} m" in told
    ActionChains(chromium).move_to_element_with_offset(stage, 5 - stage.size["width"] // 2, 0).click().perform()
    assert page.ask("player.picked") is None


def test_contacts_have_the_colours_of_the_figures(chromium, rod):
    from nonsmooth.drawing.colours import STRIPS
    from nonsmooth.mechanics.system import ContactMode

    sol, path = rod
    page = Opened(chromium, path)
    for mode in (ContactMode.STICK, ContactMode.SLIDE):
        k = int(np.flatnonzero(sol.mode[:, 0] == mode)[5])
        page.do(f"player.goTo({k})")
        page.do("document.querySelector('#forces[aria-pressed=true]')?.click()")  # no arrow over the point
        x, y = np.rint(page.pixel_of(page.ask("player.contacts()[0].point"))).astype(int)
        colour = STRIPS[mode, int(np.sign(sol.slip[k, 0])) if mode == ContactMode.SLIDE else 0]
        expected = [int(colour[i : i + 2], 16) for i in (1, 3, 5)]
        near = page.screenshot()[y - 4 : y + 5, x - 4 : x + 5].reshape(-1, 3)
        assert np.abs(near - expected).sum(axis=1).min() <= 6


def test_the_impulse_of_an_instant_is_told_and_drawn_though_the_contact_is_open_again(chromium, tmp_path):
    pendulum = WallPendulum(e=0.8)
    sol = ns.simulate(pendulum, (0, 1), *pendulum.state(th=1.0), integrator=ns.EventDriven())
    page = Opened(chromium, sol.view(tmp_path / "pendulum.html"))
    page.do("player.nextEvent()")
    (contact,), k = page.ask("player.contacts()"), int(page.ask("player.frame"))
    assert page.ask(f"player.times[{k}] == player.times[{k - 1}]") and contact["mode"] == "open"
    assert contact["normal"] == pytest.approx(sol.P_N.max(), rel=8 * FLOAT32) and "N s" in page.ask(
        "document.body.innerText"
    )
    x, y = np.rint(page.pixel_of(contact["point"])).astype(int)
    beside = page.screenshot()[y, x + 25]  # along the arrow, which pushes the bob from the wall
    page.do("document.getElementById('forces').click()")
    without = page.screenshot()[y, x + 25]
    assert beside.sum() < 200 < without.sum()


def test_inline_in_a_notebook_it_plays_in_its_frame(chromium, ball, tmp_path):
    sol, _ = ball
    notebook = tmp_path / "notebook.html"
    notebook.write_text(f"<html><body><p>In [1]:</p>{sol.view()._repr_html_()}</body></html>")
    chromium.get(notebook.as_uri())
    chromium.switch_to.frame(0)
    until = time.monotonic() + READY
    while chromium.execute_script("return document.documentElement.dataset.ready") != "yes":
        assert time.monotonic() < until
        time.sleep(0.02)
    assert chromium.execute_script("player.goTo(7); return player.time") == sol.t[7]
    chromium.switch_to.default_content()


def test_names_are_shown_as_they_are_written(chromium, tmp_path):
    title = 'a <b>bold</b> & "quoted" name'
    path = tmp_path / "name.html"
    path.write_text(page_of(spatial_film(title=title)))
    Opened(chromium, path)
    assert chromium.find_element("id", "title").text == title and html.escape(title) in path.read_text()


# --- space


def spatial_film(title="a ball and a box", n_t=60):
    """A ball that goes round, with a contact under it, a box that turns, and a ball at rest, above a floor."""
    t = np.linspace(0.0, 3.0, n_t)
    ball = np.column_stack([np.cos(t), np.sin(t), 0.2 + 0.0 * t])
    box = np.column_stack([0.0 * t, 0.0 * t, 0.5 + 0.1 * t])
    turn = np.tile([1.0, 0.0, 0.0, 0.0], (n_t, 4, 1))
    turn[:, 2] = np.column_stack([np.cos(t / 2), 0.0 * t, 0.0 * t, np.sin(t / 2)])
    bodies = (
        Body("floor", (Shape(ShapeKind.HALF_SPACE, np.zeros((0, 3))),), is_fixed=True),
        Body("ball", (Shape(ShapeKind.SPHERE, np.zeros((1, 3)), 0.2),)),
        Body("box", (Shape(ShapeKind.BOX, np.array([[0.2, 0.1, 0.05]])),)),
        Body("still ball", (Shape(ShapeKind.SPHERE, np.zeros((1, 3)), 0.1),)),
    )
    one, up = np.ones(n_t), np.tile([0.0, 0.0, 1.0], (n_t, 1))
    foot = ball - [0.0, 0.0, 0.2]
    contacts = Contacts(
        np.arange(n_t + 1), 0 * one, foot, up, 2 * one, 0 * one, 0.05 * one, 0.01 * up[:, [2, 0, 0]], 0.3 * one
    )
    curves = (Curve("energies", "kinetic", "J", np.sin(t)),)
    position = np.stack([0.0 * ball, ball, box, 0.0 * ball + [-0.8, -0.8, 0.1]], axis=1)
    return Film(title, t, bodies, position, turn, contacts, curves=curves)


@pytest.fixture
def space(chromium, tmp_path):
    path = tmp_path / "space.html"
    path.write_text(page_of(spatial_film()))
    return Opened(chromium, path)


def middle_of_ball(page):
    """The middle of the picked ball's pixels."""
    page.do("player.pick(1)")
    page.do("document.getElementById('forces').click()")
    middle = middle_of_magenta(page)
    page.do("document.getElementById('forces').click()")
    return middle


def middle_of_magenta(page):
    """The middle of the picked body's pixels: magenta."""
    y, x = np.nonzero(is_magenta(page.scene()))
    return np.array([(x.min() + x.max()) / 2, (y.min() + y.max()) / 2])


def is_magenta(shot):
    """The pixels of what is picked."""
    return (shot[..., 0] - shot[..., 1] > 40) & (shot[..., 2] - shot[..., 1] > 40)


def require_rim(page, centre, radius):
    """The rim of a picked disc is drawn to a pixel, its trail may be drawn elsewhere."""
    shot = is_magenta(page.scene())
    for angle in np.linspace(0, 2 * np.pi, 12, endpoint=False):
        x, y = np.rint(page.pixel_of(centre + radius * np.array([np.cos(angle), np.sin(angle)]))).astype(int)
        assert shot[y - 1 : y + 2, x - 1 : x + 2].any(), f"no rim at {angle:.2f} rad"


def test_in_space_a_ball_is_drawn_where_the_film_has_it(space):
    film = spatial_film()
    for k in (0, 20, 45):
        space.do(f"player.goTo({k})")
        np.testing.assert_allclose(space.ask("player.body(1).position"), film.position[k, 1], atol=2 * FLOAT32)
        np.testing.assert_allclose(space.ask("player.body(2).turn"), film.turn[k, 2], atol=2 * FLOAT32)
        # a ball is seen a little beside its centre: by its radius^2 / distance of perspective
        np.testing.assert_allclose(middle_of_ball(space), space.pixel_of(film.position[k, 1]), atol=2.5)
    assert space.complaints() == []


@pytest.mark.upkeep
def test_in_space_faces_that_are_turned_away_are_left_out_and_no_other(chromium, tmp_path):
    scene = scene_in_space()[0]
    scene.body(ns.Cylinder(0.1, 0.2), density=500, position=(0.3, -0.5, 0.6), spin=(2, 1, 0), name="cylinder")
    text = ns.simulate(scene, (0, 0.1), integrator=ns.MoreauJean(dt=5e-3)).view().text
    choice, path = "> planes[f + 3])) continue;", tmp_path / "scene.html"
    assert choice in text
    shots = []
    for rule in (choice, "> -Infinity)) continue;", ">= Infinity)) continue;"):  # ours; all, left to WebGL; none
        path.write_text(text.replace(choice, rule))
        page = Opened(chromium, path)
        page.do("player.goTo(15); document.getElementById('forces').click()")
        shots.append(page.scene())
    ours, all_faces, none = shots
    assert (ours == all_faces).all() and (ours != none).any(axis=2).sum() > 5000


def test_in_space_a_film_that_plays_too_slowly_has_fewer_pixels_and_all_of_them_where_it_stands(chromium, tmp_path):
    path, wish = tmp_path / "space.html", "const FLUENT = 30;"
    text = page_of(spatial_film())
    assert wish in text
    path.write_text(text.replace(wish, "const FLUENT = 1e6;"))
    page = Opened(chromium, path)
    width = "document.getElementById('stage').width"
    full = page.ask(width)
    page.do("player.speed = 0.05; player.play()")
    page.wait_for(f"{width} <= {0.5 * full + 1}")
    page.do("player.pause()")
    assert page.ask(width) == full and page.complaints() == []


def test_in_space_up_is_up_and_a_drag_turns_the_view(space, chromium):
    from selenium.webdriver import ActionChains

    low, high = space.pixel_of([0, 0, 0]), space.pixel_of([0, 0, 1])
    assert high[1] < low[1] - 20 and abs(high[0] - low[0]) < 0.1 * (low[1] - high[1])  # perspective
    before = space.pixel_of([1, 0, 0])
    stage = chromium.find_element("id", "stage")
    ActionChains(chromium).click_and_hold(stage).move_by_offset(80, 0).release().perform()
    assert abs(space.pixel_of([1, 0, 0])[0] - before[0]) > 20
    np.testing.assert_allclose(middle_of_ball(space), space.pixel_of([1.0, 0.0, 0.2]), atol=2.5)


def test_in_space_a_click_picks_the_ball(space, chromium):
    from selenium.webdriver import ActionChains

    stage = chromium.find_element("id", "stage")
    space.do("player.goTo(30)")
    x, y = space.ask("player.project(player.body(1).position)")
    aim = [round(x - stage.size["width"] / 2), round(y - stage.size["height"] / 2)]
    ActionChains(chromium).move_to_element_with_offset(stage, *aim).click().perform()
    assert space.ask("player.picked") == 1 and "ball" in chromium.find_element("id", "body").text


def test_a_film_in_16_bits_is_the_same_to_half_a_step(chromium, tmp_path, monkeypatch):
    film, path = spatial_film(), tmp_path / "rounded.html"
    monkeypatch.setattr("nonsmooth.drawing.player.page.EXACT_NUMBERS", 0)
    path.write_text(page_of(film))
    page = Opened(chromium, path)
    step = np.ptp(film.position, axis=(0, 1)) / LEVELS
    assert "16 bits" in chromium.find_element("id", "detail").text
    for k in (0, 1, 30, 59):
        page.do(f"player.goTo({k})")
        error = np.abs(page.ask("player.body(1).position") - film.position[k, 1])
        assert (error <= 0.5 * step + 2 * FLOAT32).all()
        assert page.ask("player.contacts()[0].P_N") == pytest.approx(0.05, rel=2.0**-11)


def test_in_space_contacts_tell_their_forces(space):
    space.do("player.goTo(10)")
    (contact,) = space.ask("player.contacts()")
    span = 3.0 / 59
    assert contact["normal"] == pytest.approx(0.05 / span, rel=1e-6)
    assert contact["friction"] == pytest.approx(0.01 / span, rel=1e-6) and contact["mode"] == "slide"


# --- scenes of bodies


def scene_in_space():
    """A stack of three cubes, a ball that is thrown past it, and a dumb-bell whose halves are not alike."""
    scene = BoxStack(n=3, dim=3).scene()
    scene.body(ns.Sphere(0.1), density=1000, position=(0.6, 0, 0.5), velocity=(0, 0.5, 1), name="ball")
    dumb_bell = ns.Compound((ns.Sphere(0.08), (0, 0, 0)), (ns.Box(0.1, 0.1, 0.1), (0.3, 0, 0)))
    scene.body(dumb_bell, density=500, position=(-0.9, 0, 0.6), spin=(0, 3, 2), name="dumb-bell")
    return scene, "ball"


def scene_in_the_plane():
    """A disc that rolls off a tilted plane, beside a stack of three squares."""
    scene = BoxStack(n=3, dim=2).scene()
    scene.fixed(ns.HalfPlane((-0.6, 0.8), -0.9), material=ns.Material(mu=0.8), name="slope")
    scene.body(ns.Disc(0.1), density=1000, position=(1.8, 0.6), velocity=(-0.5, 0), name="ball")
    return scene, "ball"


@pytest.mark.upkeep
@pytest.mark.parametrize("build", [scene_in_space, scene_in_the_plane], ids=["space", "plane"])
def test_bodies_of_a_scene_are_drawn_where_the_run_has_them_and_its_contacts_counted(chromium, tmp_path, build):
    scene, name = build()
    sol = ns.simulate(scene, (0, 0.3), integrator=ns.MoreauJean(dt=2e-3), every=2)
    page = Opened(chromium, sol.view(tmp_path / "scene.html"))
    assert page.ask("player.frames") == len(sol.t) and page.ask("player.bodies") == sol.names
    ball = sol.names.index(name)
    page.do(f"player.pick({ball}); document.getElementById('forces').click()")
    for k in (0, 30, len(sol.t) - 1):
        page.do(f"player.goTo({k})")
        for b in range(len(sol.names)):
            np.testing.assert_allclose(page.ask(f"player.body({b}).position"), sol.position[k, b], atol=4 * FLOAT32)
            np.testing.assert_allclose(page.ask(f"player.body({b}).turn"), np.atleast_1d(sol.turn[k, b]), atol=4e-7)
        if sol.dim == 3:
            np.testing.assert_allclose(middle_of_magenta(page), page.pixel_of(sol.position[k, ball]), atol=2.5)
        else:
            require_rim(page, sol.position[k, ball], 0.1)
        contacts = sol.contacts(sol.t[k])
        told = page.ask("player.contacts()")
        assert len(told) == len(contacts) == page.curve("contacts", "candidates")
        assert [contact["mode"] != "open" for contact in told] == (contacts.P_N > 0).tolist()
        np.testing.assert_allclose([contact["normal"] for contact in told], contacts.P_N, rtol=1e-5, atol=1e-12)
    assert page.complaints() == []


def test_a_box_within_a_compound_is_drawn_at_its_own_place(chromium, tmp_path):
    scene = ns.Scene(gravity=(0, 0, 0))
    turn = (np.cos(0.4), 0.0, np.sin(0.4), 0.0)
    shape = ns.Compound((ns.Box(0.2, 0.2, 0.2), (0, 0, 0)), (ns.Box(0.2, 0.1, 0.4), (1.0, 0, 0), turn))
    scene.body(shape, density=1000, position=(0, 0, 0), turn=(np.cos(0.3), np.sin(0.3), 0, 0), name="bar")
    sol = ns.simulate(scene, (0, 0.01), integrator=ns.MoreauJean(dt=0.01))
    page = Opened(chromium, sol.view(tmp_path / "bar.html"))
    page.do("player.goTo(1)")
    axes = rotation(turn), rotation((np.cos(0.3), np.sin(0.3), 0, 0))
    corners = np.array([[x, y, z] for x in (-0.1, 0.1) for y in (-0.05, 0.05) for z in (-0.2, 0.2)])
    placed = (corners @ axes[0].T + [1.0, 0, 0]) @ axes[1].T
    cube = np.array([[x, y, z] for x in (-0.1, 0.1) for y in (-0.1, 0.1) for z in (-0.1, 0.1)]) @ axes[1].T
    pixels = np.array([page.pixel_of(corner) for corner in np.concatenate([placed, cube])])
    y, x = np.nonzero(is_blue(page.scene()))
    np.testing.assert_allclose([x.min(), x.max(), y.min(), y.max()], np.ravel(
        [[pixels[:, i].min(), pixels[:, i].max()] for i in (0, 1)]), atol=2.5)  # fmt: skip


def rotation(quaternion):
    from scipy.spatial.transform import Rotation

    w, x, y, z = quaternion
    return Rotation.from_quat([x, y, z, w]).as_matrix()


def test_round_and_polyhedral_bodies_of_a_saved_scene_are_drawn_where_they_are(chromium, tmp_path):
    scene = ns.Scene(gravity=(0, 0, 0))
    corners = [(x, y, z) for x in (-0.1, 0.1) for y in (-0.1, 0.1) for z in (-0.1, 0.1)]
    for k, shape in enumerate((ns.Polyhedron(corners), ns.Cylinder(0.1, 0.2), ns.Ellipsoid(0.1, 0.15, 0.12))):
        scene.body(shape, density=1000.0, position=(0.5 * k, 0, 0), velocity=(0, 0, 0.1), spin=(0, 0, 3.0))
    sol = ns.simulate(scene, (0, 0.5), integrator=ns.MoreauJean(dt=0.05))
    loaded = ns.SceneSolution.load(sol.save(tmp_path / "run.npz"), scene)
    page = Opened(chromium, loaded.view(tmp_path / "run.html"))
    page.do("player.goTo(6)")
    shot = page.screenshot()
    for b in range(3):
        assert page.ask(f"player.body({b})")["position"] == pytest.approx(sol.position[6, b], abs=1e-6)
        x, y = np.round(page.pixel_of(sol.position[6, b])).astype(int)
        assert is_blue(shot[y, x]), shot[y, x]
    assert page.complaints() == []


def luminance(colour):
    """Relative, of WCAG 2; colour (3,) from 0 to 255."""
    c = np.asarray(colour) / 255
    return np.where(c <= 0.04045, c / 12.92, ((c + 0.055) / 1.055) ** 2.4) @ [0.2126, 0.7152, 0.0722]


def contrast_of(page, css, what):
    """Of the colour of an element with the ground of the page, at least, over all such elements."""
    read = f"""Array.from(document.querySelectorAll('{css}'), (one) => getComputedStyle(one).{what})
        .concat(getComputedStyle(document.body).backgroundColor)"""
    found = [[int(c) for c in text[text.index("(") + 1 : -1].split(",")[:3]] for text in page.ask(read) if "(" in text]
    *colours, ground = map(luminance, found)
    return min((max(c, ground) + 0.05) / (min(c, ground) + 0.05) for c in colours)


def test_in_the_dark_ground_words_modes_and_curves_are_told_apart_from_it(chromium, rod):
    page = Opened(chromium, rod[1])
    shots = []
    for is_dark in (False, True):
        page.do(f"player.setDark({str(is_dark).lower()}); player.goTo(300)")
        shots.append(page.screenshot())
        assert contrast_of(page, "header *, aside *", "color") > 4.5  # WCAG 2.1, words
    assert np.median(shots[0]) > 200 and np.median(shots[1]) < 60
    assert contrast_of(page, "#legend circle", "fill") > 3 and contrast_of(page, ".key span", "color") > 3  # graphics
    words = page.ask("getComputedStyle(document.querySelector('.key span')).color")
    page.do("player.setDark(false)")
    assert words != page.ask("getComputedStyle(document.querySelector('.key span')).color")


@pytest.mark.upkeep
@pytest.mark.parametrize(
    "build", [SpragSlip, RockingBlock, lambda: BoxStack(n=2, dim=3)], ids=["rod", "block", "boxes"]
)
def test_on_a_phone_all_is_within_the_width_and_no_part_on_another(chromium, tmp_path, build):
    model = build()
    start = model.state() if hasattr(model, "state") else ()
    path = ns.simulate(model, (0, 0.05), *start, integrator=ns.MoreauJean(dt=1e-3)).view(tmp_path / "run.html")
    phone = {"width": 390, "height": 844, "deviceScaleFactor": 2, "mobile": True}
    chromium.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", phone)
    try:
        page = Opened(chromium, path)
        page.do("player.goTo(player.frames - 1); player.pick(player.bodies.length - 1)")
        page.wait_for("document.documentElement.scrollWidth <= 390")
        chart = "#charts .chart:nth-child(2)"
        parts = ["#scene", "#timeline", chart, f"{chart} .key", "aside"]
        boxes = page.ask(f"""{parts}.map((css) => document.querySelector(css).getBoundingClientRect())
            .map((b) => [b.left, b.top, b.right, b.bottom])""")
        for left, top, right, bottom in boxes:
            assert 0 <= left < right <= 390.5 and bottom > top
        for above, below in zip(boxes, boxes[1:], strict=False):
            assert above[3] <= below[1] + 1
        scene = page.scene()
        assert scene.shape[1] == 780
        low = page.ask("Math.min(...Array.from(document.querySelectorAll('nav button'), (b) => b.offsetHeight))")
        assert low >= 32  # pixels that a finger hits
    finally:
        chromium.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})


def test_energies_have_the_colours_of_the_figures(chromium, rod):
    from nonsmooth.drawing.colours import ENERGIES

    page = Opened(chromium, rod[1])
    told = page.ask(
        "Array.from(document.querySelectorAll('.key span'), (s) => [s.textContent, getComputedStyle(s).color])"
    )
    colours = {text.rsplit(" ", 1)[0].removeprefix("work: "): colour for text, colour in told}
    for name in ("kinetic", "potential", "friction", "surface"):
        expected = ", ".join(str(int(ENERGIES[name][0][i : i + 2], 16)) for i in (1, 3, 5))
        assert colours[name] == f"rgb({expected})"


def test_rounding_is_not_drawn_as_motion(chromium, tmp_path):
    """Gaps of a guided rod of 5 m are 1e-11 m, energies of balls at rest 1e-17 J: the axis is that of the motion."""
    n = 40
    t = np.linspace(0, 1, n)
    rng = np.random.default_rng(0)
    base = spatial_film(n_t=n)
    curves = (Curve("energies", "kinetic", "J", 1e-17 * rng.normal(size=n), scale=2.0),
              Curve("gaps", "g_0", "m", 1e-11 * rng.normal(size=n)))  # fmt: skip
    path = tmp_path / "still.html"
    path.write_text(page_of(Film("still", t, base.bodies, base.position, base.turn, base.contacts, curves=curves)))
    page = Opened(chromium, path)
    for chart in (1, 2):
        rows, n_columns = page.ask(f"""(() => {{
            const canvas = document.querySelectorAll('#charts canvas')[{chart}], pen = canvas.getContext('2d');
            const {{data, width, height}} = pen.getImageData(0, 0, canvas.width, canvas.height), rows = new Set();
            let columns = 0;
            for (let x = 70; x < width - 20; x += 5) for (let y = 20; y < height - 20; y++) {{
                const i = 4 * (y * width + x);
                if (data[i + 2] - data[i] > 60 && data[i + 3] > 200) {{ rows.add(y); columns++; }}
            }}
            return [rows.size, columns];
        }})()""")
        assert rows <= 3 and n_columns > 50


def test_the_picked_body_says_how_fast_it_goes_in_the_figures_that_are_known(chromium, tmp_path):
    ball = BouncingBall()
    sol = ns.simulate(ball, (0, 0.3), *ball.state(), integrator=ns.MoreauJean(dt=1e-3))
    page = Opened(chromium, sol.view(tmp_path / "ball.html"))
    page.do("player.goTo(200); player.pick(1)")
    told = chromium.find_element("id", "body").text.splitlines()
    speed = {line[:3]: float(line.split()[-2]) for line in told if line.startswith("v_")}
    mean = (sol.q[200, 0] - sol.q[199, 0]) / (sol.t[200] - sol.t[199])
    assert speed["v_y"] == pytest.approx(mean, rel=2e-3) and speed["v_x"] == 0.0
    assert "x 0 m" in told  # not 1e-18


def test_a_narrow_page_is_not_scrolled_sideways(chromium, tmp_path):
    sol = ns.simulate(BoxStack(n=2, dim=2), (0, 0.02), integrator=ns.MoreauJean(dt=1e-3))
    path = sol.view(tmp_path / "run.html")
    size = chromium.get_window_size()
    try:
        chromium.set_window_size(400, 800)
        page = Opened(chromium, path)
        assert page.ask("document.documentElement.scrollWidth") <= page.ask("window.innerWidth")
    finally:
        chromium.set_window_size(size["width"], size["height"])


def test_the_picture_that_is_saved_is_what_is_seen_with_its_contacts(chromium, rod):
    """The rod and, at its first frame, its cone: every pixel that the overlay has drawn is there."""
    from PIL import Image

    page = Opened(chromium, rod[1])
    saved = np.asarray(Image.open(io.BytesIO(base64.b64decode(page.ask("player.picture()").partition(",")[2]))))
    width, height = page.ask("(c => [c.width, c.height])(document.getElementById('stage'))")
    assert saved.shape[:2] == (height, width) and is_blue(saved[..., :3].astype(int)).sum() > 200
    assert (saved[..., 3] == 255).all()


def test_in_space_the_picture_is_not_empty(space):
    from PIL import Image

    saved = np.asarray(Image.open(io.BytesIO(base64.b64decode(space.ask("player.picture()").partition(",")[2]))))
    assert len(np.unique(saved.reshape(-1, 4), axis=0)) > 20


@pytest.mark.parametrize(("rows", "are_shown"), [(3, "true"), (6, "false")])
def test_forces_of_many_bodies_are_shown_when_asked_for_and_the_scene_has_most_of_a_small_window(
    chromium, tmp_path, rows, are_shown
):  # fmt: skip
    pyramid = Pyramid(rows=rows)  # of 6 and 21 bodies
    page = Opened(
        chromium, ns.simulate(pyramid, (0, 0.02), integrator=ns.MoreauJean(dt=2e-3)).view(tmp_path / "p.html")
    )
    assert page.ask("document.getElementById('forces').ariaPressed") == are_shown
    page.do("document.getElementById('forces').click()")
    assert page.ask("document.getElementById('forces').ariaPressed") != are_shown
    size = chromium.get_window_size()
    try:
        chromium.execute_cdp_cmd("Emulation.setDeviceMetricsOverride",
                                 {"width": 1280, "height": 660, "deviceScaleFactor": 1, "mobile": False})  # fmt: skip
        page.wait_for("document.querySelectorAll('.chart')[2].hidden")
        width, height = page.ask("(b => [b.width, b.height])(document.getElementById('scene').getBoundingClientRect())")
        assert width * height > 0.5 * 1280 * 660
        page.do("player.pick(1)")
        assert not page.ask("document.querySelectorAll('.chart')[2].hidden")
    finally:
        chromium.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})
        chromium.set_window_size(size["width"], size["height"])


# --- colours and camera


def lane(dim, speeds=(1.0, 2.0, 3.0, 40.0)):
    """Four bodies without weight that fly along x, in turn of one material and of the other; the last flies away."""
    scene = ns.Scene(gravity=np.zeros(dim), material=ns.Material(mu=0.25, e=0.5))
    rubber = ns.Material(mu=0.9, name="rubber")
    for k, speed in enumerate(speeds):
        place, velocity = np.zeros(dim), np.zeros(dim)
        place[1], velocity[0] = 0.6 * k, speed
        shape = ns.Sphere(0.2) if dim == 3 else ns.Disc(0.2)
        scene.body(shape, density=1000, position=place, velocity=velocity, material=rubber if k % 2 else None)
    return ns.simulate(scene, (0, 1), integrator=ns.MoreauJean(dt=0.02))


def colours_of(page, count=4):
    """The colour that most pixels of each body have near its centre: its hue, whatever light falls on it."""
    shot, found = page.scene(), []
    for b in range(count):
        x, y = np.rint(page.pixel_of(page.ask(f"player.body({b}).position"))).astype(int)
        near = shot[y - 2 : y + 3, x - 2 : x + 3].reshape(-1, 3)
        hue = near - near.min(axis=1, keepdims=True)
        found.append(hue[np.argmax(hue.max(axis=1))] / max(hue.max(), 1))
    return np.array(found)


def are_alike(a, b):
    return np.abs(a - b).max() < 0.15


@pytest.mark.upkeep
@pytest.mark.parametrize("dim", [2, 3])
def test_bodies_are_coloured_alike_by_body_by_material_or_by_speed(chromium, tmp_path, dim):
    page = Opened(chromium, lane(dim, speeds=(1.0, 1.0, 2.0, 2.0)).view(tmp_path / "lane.html"))
    assert page.ask("player.colourings") == ["plain", "body", "material", "speed"]
    page.do("player.goTo(10)")
    found = {}
    for by in ("plain", "body", "material", "speed"):
        page.do(f"player.colours = '{by}'")
        assert page.ask("document.getElementById('colours').value") == by
        found[by] = colours_of(page)
    for a in range(4):
        for b in range(a):
            assert are_alike(found["plain"][a], found["plain"][b])
            assert not are_alike(found["body"][a], found["body"][b])
            assert are_alike(found["material"][a], found["material"][b]) == (a % 2 == b % 2)
            assert are_alike(found["speed"][a], found["speed"][b]) == (a // 2 == b // 2)
    legend = "document.getElementById('legend').innerText"
    assert "speed of the centre, 0 to 2 m/s" in page.ask(legend)
    page.do("player.colours = 'material'")
    assert "rubber" in page.ask(legend) and "μ = 0.25, e = 0.5" in page.ask(legend)
    page.do("document.dispatchEvent(new KeyboardEvent('keydown', {key: 'k', bubbles: true}))")
    assert page.ask("player.colours") == "speed" and page.complaints() == []


def test_colours_follow_the_speed_of_each_frame(chromium, tmp_path):
    """A ball that falls from rest is dark first and light at last; of one material there is nothing to choose."""
    ball = BouncingBall(e=0.5)
    sol = ns.simulate(ball, (0, 0.4), *ball.state(height=1.0), integrator=ns.MoreauJean(dt=1e-2))
    page = Opened(chromium, sol.view(tmp_path / "ball.html"))
    assert page.ask("player.colourings") == ["plain", "body", "speed"]
    page.do("player.colours = 'speed'; player.goTo(1)")
    slow = colours_of(page, 2)[1]
    page.do("player.goTo(player.frames - 1)")
    fast = colours_of(page, 2)[1]
    assert slow.argmax() == 2 and fast.argmin() == 2  # blue, and yellow
    assert page.ask("(() => { try { player.colours = 'age'; } catch (error) { return error.message; } })()").startswith(
        "bodies have no colours age"
    )


@pytest.mark.parametrize("dim", [2, 3])
def test_the_camera_follows_what_moves_though_one_body_runs_away(chromium, tmp_path, dim):
    """The three are in view at every frame, and larger than when all of the motion, 40 m, is."""
    page = Opened(chromium, lane(dim).view(tmp_path / "lane.html"))
    assert page.ask("player.isFollowing")
    width, height = page.ask("(c => [c.clientWidth, c.clientHeight])(document.getElementById('stage'))")

    def size_of_the_first():
        centre, beside = (page.ask(f"player.project({point})") for point in across())
        return np.hypot(*np.subtract(centre, beside))

    def across():
        place = page.ask("player.body(0).position")
        return place, [place[0], place[1] + 0.2, *place[2:]]

    followed = []
    for k in (0, 20, 50):
        page.do(f"player.goTo({k})")
        places = np.array([page.ask(f"player.project(player.body({b}).position)") for b in range(3)])
        assert (places > 0).all() and (places < [width, height]).all()
        np.testing.assert_allclose(places[1], [width / 2, height / 2], atol=1.5)  # that of the middle speed
        followed.append(size_of_the_first())
    page.do("document.getElementById('follow').click()")
    assert not page.ask("player.isFollowing") and 4 * size_of_the_first() < min(followed)
    page.do("player.follow(true); player.pick(3); player.goTo(50)")
    np.testing.assert_allclose(page.ask("player.project(player.body(3).position)"), [width / 2, height / 2], atol=1.5)
    assert page.complaints() == []


@pytest.mark.parametrize("build", [SpragSlip, BouncingBall, RockingBlock])
def test_a_motion_that_fills_the_view_is_not_followed_unasked(chromium, tmp_path, build):
    model = build()
    sol = ns.simulate(model, (0, 0.5), *model.state(), integrator=ns.MoreauJean(dt=1e-3))
    page = Opened(chromium, sol.view(tmp_path / "run.html"))
    assert not page.ask("player.isFollowing")
    page.do("document.getElementById('follow').click()")
    assert page.ask("player.isFollowing")
