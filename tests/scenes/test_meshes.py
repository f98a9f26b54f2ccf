"""Shapes from files of triangles: hulls, convex parts, and what is wrong with a file."""

import sys

import numpy as np
import pytest

import nonsmooth as ns

trimesh = pytest.importorskip("trimesh")


def corner_piece():
    """An L of two blocks, not convex: volume 3, its hull 3.5."""
    outline = [(0, 0), (1, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2), (0, 1)]
    triangles = [(0, 1, 4), (0, 4, 7), (1, 2, 3), (1, 3, 4), (7, 4, 5), (7, 5, 6)]
    return trimesh.creation.extrude_triangulation(outline, triangles, height=1.0)


@pytest.mark.parametrize("ending", ["stl", "obj", "ply", "glb"])
def test_a_box_of_a_file_is_the_box(ending, tmp_path):
    path = tmp_path / f"box.{ending}"
    trimesh.creation.box((200, 100, 50)).export(path)
    shape = ns.mesh(path, scale=1e-3)
    assert len(shape.vertices) == 8 and len(shape.faces) == 6
    np.testing.assert_allclose(np.ptp(shape.vertices, axis=0), (0.2, 0.1, 0.05), rtol=1e-6)
    scene = ns.Scene(gravity=(0, 0, -9.81), material=ns.Material(mu=0.5))
    scene.fixed(ns.HalfSpace((0, 0, 1)))
    scene.body(shape, density=1000, position=(0, 0, 0.025), name="box")
    sol = ns.simulate(scene, (0, 0.1), integrator=ns.MoreauJean(1e-3))
    assert sol["box"].position[-1, 2] == pytest.approx(0.025, abs=1e-8)


def test_a_mesh_that_is_not_convex_is_told_and_cut(tmp_path):
    pytest.importorskip("coacd")
    path = tmp_path / "corner.stl"
    corner_piece().export(path)
    with pytest.warns(ns.NotUnderstoodWarning, match="is not convex, and its hull, of 1.17 times its volume"):
        hull = ns.mesh(path)
    parts = ns.mesh(path, cut=0.05)
    scene = ns.Scene(gravity=(0, 0, 0))
    masses = [scene.body(shape, density=1.0, position=(5.0 * k, 0, 0)) for k, shape in enumerate((hull, parts))]
    for body in masses:
        scene.force(body, (1.0, 0, 0))
    sol = ns.simulate(scene, (0, 1), integrator=ns.MoreauJean(0.1))
    speeds = [sol[body.name].velocity[-1, 0] for body in masses]  # a force of 1 N for 1 s: 1/m
    assert 1 / speeds[0] == pytest.approx(3.5, rel=1e-6) and 1 / speeds[1] == pytest.approx(3.0, rel=0.05)


def test_a_mesh_that_is_not_closed_is_told(tmp_path):
    path = tmp_path / "open.obj"
    box = trimesh.creation.box((1, 1, 1))
    trimesh.Trimesh(box.vertices, box.faces[:-1]).export(path)
    with pytest.warns(ns.NotUnderstoodWarning, match="is not closed"):
        assert len(ns.mesh(path).vertices) == 8


def test_a_hull_of_many_corners_says_how_far_the_others_stand_out(tmp_path):
    path = tmp_path / "ball.ply"
    trimesh.creation.icosphere(subdivisions=3).export(path)  # 642 corners
    with pytest.warns(ns.NotUnderstoodWarning, match=r"more than 200 corners: those left out stand out by 0.0\d+ m"):
        ball = ns.mesh(path)
    assert len(ball.vertices) == 200


def test_what_is_no_mesh_is_refused_in_a_sentence(tmp_path, monkeypatch):
    flat, text = tmp_path / "flat.obj", tmp_path / "text.stl"
    flat.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nf 1 2 3\nf 2 4 3\n")
    text.write_text("what is this")
    for path, message in ((flat, "flat.obj"), (text, "text.stl"), (tmp_path / "none.stl", "none.stl")):
        with pytest.raises(ns.InvalidInput, match=message):
            ns.mesh(path)
    with pytest.raises(ns.InvalidInput, match="cut must be above 0"):
        ns.mesh(flat, cut=0)
    monkeypatch.setitem(sys.modules, "trimesh", None)
    with pytest.raises(ns.MissingExtra, match=r"nonsmooth\[mesh\]"):
        ns.mesh(flat)
