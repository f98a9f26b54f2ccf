"""The film of a scene has the poses, the shapes, the contacts and the curves of its run."""

from itertools import pairwise

import numpy as np
import pytest

import nonsmooth as ns
from models.scenes import BoxStack, CardHouse, MasonryArch, Turntable
from nonsmooth.drawing.bodies import places
from nonsmooth.drawing.facets import triangles_of
from nonsmooth.drawing.planar_bodies import rounded
from nonsmooth.drawing.player import scene_film
from nonsmooth.drawing.player.film import ShapeKind
from nonsmooth.drawing.player.scene_film import film_of_scene
from nonsmooth.mechanics.system import ContactMode
from nonsmooth.scenes.parts import parts_of
from nonsmooth.scenes.places import compose, matrix_of, place_of

EXACT = 1e-12  # relative to metres: roundings of two ways through one place


def run(scene, steps=40, **options):
    return ns.simulate(scene, (0, 2e-3 * steps), integrator=ns.MoreauJean(dt=2e-3), **options)


@pytest.fixture(scope="module")
def stack():
    return run(BoxStack(n=3, dim=2), steps=50)


def moved_body(shape, dim):
    """A run of one body that flies and turns."""
    scene = ns.Scene(gravity=np.zeros(dim))
    turn, spin = (0.7, 2.0) if dim == 2 else ((0.5, 0.5, 0.5, -0.5), (1.0, 2.0, -3.0))
    scene.body(shape, density=1000, position=np.arange(1.0, dim + 1), turn=turn, spin=spin, name="body")
    return run(scene)


@pytest.mark.parametrize(
    "shape",
    [
        ns.Disc(0.1), ns.Capsule(0.3, 0.1), ns.Box(0.2, 0.4), ns.Polygon([(1, 1), (3, 1), (2, 2)]),
        ns.Polygon([(1, 1), (3, 1), (2, 2)], radius=0.2),
        ns.Compound((ns.Disc(0.2), (1, 0)), (ns.Box(0.2, 0.4), (0, 2), 0.6), (ns.Capsule(1, 0.1), (0, 0), 1.0)),
    ],
    ids=lambda shape: type(shape).__name__,
)  # fmt: skip
def test_planar_shapes_are_where_detection_has_them(shape):
    sol = moved_body(shape, 2)
    film = film_of_scene(sol)
    for k in (0, len(sol.t) - 1):
        (frame,) = places(sol, k)
        for drawn, part in zip(film.bodies[0].shapes, parts_of(shape, 2), strict=True):
            points = film.position[k, 0] + drawn.points @ matrix_of(film.turn[k, 0]).T
            at = compose(frame, part.place)
            is_round = drawn.kind in (ShapeKind.DISC, ShapeKind.CAPSULE)
            assert drawn.radius == (part.radius if is_round else 0.0)
            expected = at[:2] + part.vertices @ matrix_of(at[2]).T if is_round else rounded(part, frame)
            np.testing.assert_allclose(points, expected, atol=EXACT)


@pytest.mark.parametrize(
    "shape",
    [
        ns.Sphere(0.1), ns.Capsule(0.3, 0.1), ns.Box(0.2, 0.4, 0.1), ns.Cylinder(0.1, 0.3), ns.Ellipsoid(0.1, 0.2, 0.3),
        ns.Polyhedron([(1, 0, 0), (1.4, 0, 0), (1, 0.3, 0), (1, 0, 0.2), (1.2, 0.2, 0.2)]),
        ns.Compound(
            (ns.Sphere(0.2), (1, 0, 0)), (ns.Box(0.2, 0.4, 0.1), (0, 2, 0), (0.6, 0, 0.8, 0)),
            (ns.Capsule(1, 0.1), (0, 0, 1), (0.6, 0.8, 0, 0)),
        ),
    ],
    ids=lambda shape: type(shape).__name__,
)  # fmt: skip
def test_spatial_shapes_are_where_detection_has_them(shape):
    sol = moved_body(shape, 3)
    film = film_of_scene(sol)
    for k in (0, len(sol.t) - 1):
        (frame,) = places(sol, k)
        body = place_of(film.position[k, 0], film.turn[k, 0])
        for drawn, part in zip(film.bodies[0].shapes, parts_of(shape, 3), strict=True):
            at = compose(frame, part.place)
            if drawn.kind == ShapeKind.FACETS:
                points = body[:3] + drawn.points @ matrix_of(body[3:]).T
                expected = at[:3] + triangles_of(part).reshape(-1, 3) @ matrix_of(at[3:]).T
                np.testing.assert_allclose(points, expected, atol=EXACT)
                continue
            if drawn.kind == ShapeKind.BOX:
                np.testing.assert_allclose(compose(body, drawn.place), at, atol=EXACT)
                assert drawn.points.tolist() == [list(part.size)]
                continue
            ends = np.outer([-1.0, 1.0], [0, 0, part.size[2]]) if drawn.kind == ShapeKind.CAPSULE else np.zeros((1, 3))
            points = body[:3] + drawn.points @ matrix_of(body[3:]).T
            np.testing.assert_allclose(points, at[:3] + ends @ matrix_of(at[3:]).T, atol=EXACT)
            assert drawn.radius == part.radius


def test_a_half_plane_and_a_half_space_have_their_normals_and_offsets():
    for normal, half in (((-0.6, 0.8), ns.HalfPlane), ((0.0, -0.6, 0.8), ns.HalfSpace)):
        scene = ns.Scene(gravity=np.zeros(len(normal)))
        scene.fixed(half(normal, 0.3), name="ground")
        film = film_of_scene(run(scene))
        ((shape,),) = [body.shapes for body in film.bodies]
        d = len(normal)
        turn = shape.place[2] if d == 2 else shape.place[3:]
        np.testing.assert_allclose(matrix_of(turn)[:, -1], normal, atol=EXACT)
        place = film.position[0, 0] + shape.place[:d]
        assert place @ normal == pytest.approx(0.3, rel=EXACT)
        assert film.bodies[0].is_fixed


def test_what_is_guided_is_neither_fixed_nor_free():
    film = film_of_scene(run(Turntable()))
    assert [(body.name, body.is_fixed, body.is_guided) for body in film.bodies] == [
        ("table", False, True), ("ball", False, False),
    ]  # fmt: skip


def test_contacts_of_a_frame_are_those_of_its_record(stack):
    film = film_of_scene(stack)
    contacts = film.contacts
    assert film.is_of_last_step and len(film.times) == len(stack.t)
    for k in (0, 1, len(stack.t) - 1):
        own, rows = stack.contacts(stack.t[k]), slice(contacts.start[k], contacts.start[k + 1])
        np.testing.assert_array_equal(contacts.point[rows], own.point)
        np.testing.assert_array_equal(contacts.mode[rows], own.mode)
        force = contacts.P_N[rows, None] * contacts.normal[rows] + contacts.P_F[rows]
        np.testing.assert_allclose(force, own.P, rtol=1e-13, atol=1e-15)
    # the impulses carry the weight of a step: of all three cubes on the ground
    rows = slice(contacts.start[-2], contacts.start[-1])
    on_ground = ["ground" in film.contact_names[number] for number in contacts.number[rows]]
    assert contacts.P_N[rows][on_ground].sum() == pytest.approx(2e-3 * BoxStack(n=3, dim=2).loads()[0], rel=1e-9)
    assert (contacts.mode[rows] == ContactMode.STICK).all()


def test_each_contact_of_two_bodies_has_a_name_of_its_own(stack):
    film = film_of_scene(stack)
    for k in range(1, len(film.times)):
        number = film.contacts.number[film.contacts.start[k] : film.contacts.start[k + 1]]
        assert len(set(number)) == len(number)
    assert film.contact_names[:2] == ("ground / box 0 (1)", "ground / box 0 (2)")


def test_a_single_contact_of_two_bodies_is_named_without_a_number():
    assert film_of_scene(run(Turntable())).contact_names == ("table / ball",)


def test_curves_of_a_scene_are_those_of_the_run():
    sol = run(MasonryArch(n=5))
    curves = {(curve.group, curve.name): curve.values for curve in film_of_scene(sol).curves}
    np.testing.assert_array_equal(curves["penetration", "the deepest since the frame before"], sol.penetration)
    np.testing.assert_array_equal(curves["contacts", "candidates"], np.diff(sol.all_contacts.offsets))
    loaded = [(sol.contacts(t).P_N > 0).sum() for t in sol.t]
    np.testing.assert_array_equal(curves["contacts", "with an impulse"], loaded)
    (residual,) = [values for (group, _), values in curves.items() if group == "residual"]
    np.testing.assert_allclose(10 ** residual[1:], sol.residual[1:])


def test_the_worst_residual_stands_with_its_contact_and_its_time():
    sol = run(MasonryArch(n=5))
    place = f"(contact {sol.stats.worst_contact}, {sol.stats.worst_pair}, at t = {sol.stats.worst_time:.4g} s)"
    assert film_of_scene(sol).about["worst residual"] == f"{sol.residual.max():.2g} {place}"


def test_a_run_of_more_records_than_are_played_says_so_and_keeps_its_worst_figures(monkeypatch):
    monkeypatch.setattr(scene_film, "POSES_SHOWN", 200)
    monkeypatch.setattr(scene_film, "FEWEST", 10)
    sol = run(CardHouse(), steps=400)
    depths = np.random.default_rng(7).random(len(sol.t))  # a house at rest has none of its own
    object.__setattr__(sol, "penetration", depths)
    film = film_of_scene(sol)
    n = 200 // len(sol.names)
    assert n - 1 <= len(film.times) <= n + 1 and film.times[0] == sol.t[0] and film.times[-1] == sol.t[-1]
    assert f"{len(film.times)} of {len(sol.t)} records are frames" in film.detail
    assert np.ptp(np.diff(film.times)) <= 2e-3 * (1 + 1e-9)
    (deepest,) = [curve.values for curve in film.curves if curve.group == "penetration"]
    assert deepest[1:].tolist() == [depths[(sol.t > before) & (sol.t <= t)].max() for before, t in pairwise(film.times)]
    for k, t in enumerate(film.times):
        assert film.contacts.start[k + 1] - film.contacts.start[k] == len(sol.contacts(t))


def test_a_run_that_was_loaded_needs_its_scene_to_be_shown(stack, tmp_path):
    path = stack.save(tmp_path / "stack.npz")
    with pytest.raises(ns.InvalidInput, match="has no shapes; give its scene"):
        ns.SceneSolution.load(path).view(tmp_path / "stack.html")
    page = ns.SceneSolution.load(path, BoxStack(n=3, dim=2).scene()).view(tmp_path / "stack.html")
    assert "ground / box 0" in page.read_text()


def test_without_a_path_a_notebook_shows_the_scene(stack):
    assert stack.view()._repr_html_().startswith("<iframe")


def test_the_title_names_the_ready_scene_and_its_bodies():
    sol = ns.simulate(BoxStack(n=2, dim=2), (0, 0.002), integrator=ns.MoreauJean(dt=1e-3))
    assert film_of_scene(sol).title == "box-stack: planar, 3 bodies, 2 of them dynamic"
    scene = ns.Scene(gravity=(0, 0))
    scene.body(ns.Disc(0.1), density=1.0, position=(0, 0))
    assert repr(scene) == "Scene(planar, 1 body, 1 of them dynamic)"
