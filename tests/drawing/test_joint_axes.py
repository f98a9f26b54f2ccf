"""Axes, limits and reactions of joints in pictures, player and live view: where they are, and what they say."""

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.drawing.joint_axes import gone_with, limits_of, lines_on
from nonsmooth.drawing.live.view import LiveScene, turned
from nonsmooth.drawing.player.film import ShapeKind
from nonsmooth.drawing.player.scene_film import film_of_scene
from nonsmooth.mechanics.system import ContactMode
from nonsmooth.scenes.places import place_of, rotate


def hung(dim):
    """A bar on a hinge with limits, and a block on a slider with one, from a body that turns."""
    scene = ns.Scene(gravity=(0, -9.81) if dim == 2 else (0, 0, -9.81))
    wide, ball = (ns.Box(0.4, 0.1), ns.Disc(0.1)) if dim == 2 else (ns.Box(0.4, 0.1, 0.1), ns.Sphere(0.1))
    scene.kinematic(ball, position=np.ones(dim), spin=1.0 if dim == 2 else (0, 1.0, 0), name="hand")
    scene.body(wide, mass=2.0, position=np.ones(dim) + np.eye(dim)[0], name="bar")
    scene.body(ball, mass=1.0, position=np.ones(dim) - np.eye(dim)[0], name="block")
    axis = {} if dim == 2 else {"axis": (0, 1.0, 0)}
    scene.hinge("hand", "bar", at=np.ones(dim) + 0.8 * np.eye(dim)[0], limits=(-0.5, np.inf), name="hinge", **axis)
    scene.slider("hand", "block", axis=np.eye(dim)[0], limits=(-0.2, 0.3), name="rail")
    scene.ignore(*scene.bodies)
    return scene


@pytest.mark.parametrize("dim", [2, 3])
def test_a_sector_begins_at_its_limit_on_the_side_of_the_second_body(dim):
    scene, size = hung(dim), 0.1
    hinge = scene.joints[0]
    (sector,) = limits_of(hinge, size)
    arms = sector - hinge.at
    assert abs(arms[0]).max() == 0.0 and np.linalg.norm(arms[1:], axis=1) == pytest.approx(size)  # no spoke at no limit
    lowest = np.array([np.cos(0.5), -np.sin(0.5)]) if dim == 2 else np.array([np.cos(0.5), 0.0, np.sin(0.5)])
    np.testing.assert_allclose(arms[1], size * lowest, atol=1e-12)  # about +y in space x turns to -z
    bars = limits_of(scene.joints[1], size)
    ends = {tuple(np.round(bar.mean(axis=0) - scene.joints[1].at, 12)) for bar in bars}
    assert ends == {tuple(np.round(end * np.eye(dim)[0], 12)) for end in (-0.2, 0.3)}
    assert all(abs((bar[1] - bar[0]) @ scene.joints[1].axis) < 1e-15 for bar in bars)


@pytest.mark.parametrize("dim", [2, 3])
def test_the_film_has_lines_on_first_bodies_and_reactions_as_forces(dim):
    scene, dt = hung(dim), 1e-3
    sol = ns.simulate(scene, (0, 0.1), integrator=ns.MoreauJean(dt))
    film = film_of_scene(sol)
    drawn = [shape for shape in film.bodies[0].shapes if shape.kind == ShapeKind.POLYLINE]
    assert len(drawn) == len(lines_on(scene.bodies[0], scene.joints, dim, 1.0)) and film.contact_names == (
        "hinge",
        "rail",
    )
    hand, (line,) = scene.bodies[0], [shape.points for shape in drawn if len(shape.points) > 2]
    place = place_of(sol["hand"].position[-1], sol["hand"].turn[-1])
    where = gone_with(hand, place, scene.joints[0].at[None])[0]
    angle = film.turn[-1, 0]
    np.testing.assert_allclose(film.position[-1, 0] + rotate(angle, line[0]), where, atol=1e-12)
    last = slice(*film.contacts.start[-2:])
    assert (film.contacts.mode[last] == ContactMode.LOCKED).all() and (film.contacts.number[last] == [0, 1]).all()
    P = (film.contacts.P_N[:, None] * film.contacts.normal)[last]
    np.testing.assert_allclose(P, sol.joint_impulses[-1], atol=1e-15)
    np.testing.assert_allclose(film.contacts.point[last][0], where, atol=1e-6)
    assert film.contacts.start.tolist() == list(range(0, 2 * len(film.times) + 1, 2))


def test_a_slack_rope_is_open_and_a_taut_one_is_not():
    scene = ns.Scene(gravity=(0, -9.81))
    scene.fixed(ns.Disc(0.01), name="hook")
    scene.body(ns.Disc(0.05), mass=1.0, position=(0, -0.5), name="bob")
    scene.rope("hook", "bob", length=0.6, name="rope")
    film = film_of_scene(ns.simulate(scene, (0, 0.5), integrator=ns.MoreauJean(1e-3)))
    falls = np.sqrt(0.2 / 9.81)
    is_open = film.contacts.mode == ContactMode.OPEN
    assert is_open[film.times < falls - 1e-3].all() and not is_open[film.times > falls + 2e-3].any()


def test_the_live_view_has_the_lines_where_the_bodies_are(monkeypatch):
    pytest.importorskip("viser", reason='a live view needs viser: pip install "nonsmooth[live]"')
    seen = []
    monkeypatch.setattr(LiveScene, "close", lambda self, close=LiveScene.close: (close(self), seen.append(self)))
    sol = ns.simulate(hung(3), (0, 0.05), integrator=ns.MoreauJean(1e-3), view=True)
    points = seen[0].window.lines.points.reshape(-1, 3)
    hand = sol.scene.bodies[0]
    at = gone_with(hand, place_of(sol["hand"].position[-1], sol["hand"].turn[-1]), sol.scene.joints[0].at[None])[0]
    assert np.abs(points - at).max(axis=1).min() < 1e-6


def test_segments_turn_as_bodies_do():
    rng = np.random.default_rng(2)
    turn, segments = rng.normal(size=(5, 4)), rng.normal(size=(5, 2, 3))
    turn /= np.linalg.norm(turn, axis=1, keepdims=True)
    expected = [[rotate(own, end) for end in segment] for own, segment in zip(turn, segments, strict=True)]
    np.testing.assert_allclose(turned(turn, segments), expected, atol=1e-14)
