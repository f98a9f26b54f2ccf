"""Pictures and animations of scenes: bodies where they are, at the instants asked for, as wide as a column."""

import shutil

import numpy as np
import pytest

import nonsmooth as ns
from models.scenes import BoxStack
from nonsmooth.drawing.scene_figures import AZIMUTH, FORESHORTENED, camera


@pytest.fixture(scope="module")
def stack():
    return ns.simulate(BoxStack(n=2, dim=2), (0, 0.1), integrator=ns.MoreauJean(dt=2e-3))


def test_a_picture_is_drawn_at_the_times_asked_for_and_as_wide_as_a_column(stack, tmp_path):
    figure = stack.picture(tmp_path / "stack.pdf", times=[0.02, 0.08], width=85)
    assert [axes.get_title() for axes in figure.axes] == ["t = 0.02 s", "t = 0.08 s"]
    assert figure.get_figwidth() * 25.4 == pytest.approx(85)
    assert {axes.title.get_fontsize() for axes in figure.axes} == {8.0}
    assert (tmp_path / "stack.pdf").read_bytes().startswith(b"%PDF")


@pytest.mark.parametrize("times", [[0.2], [], [[0.0, 0.1]], [np.nan], "soon"])
def test_a_time_outside_the_run_is_refused(stack, times):
    with pytest.raises(ns.InvalidInput, match="times must be"):
        stack.picture(times=times)


def test_a_width_that_is_none_is_refused(stack):
    with pytest.raises(ns.InvalidInput, match="width must be"):
        stack.picture(width=-85)


def test_the_three_axes_are_equally_long_in_a_spatial_picture():
    lengths = np.linalg.norm(camera()[:2], axis=0)  # of x, y and z
    np.testing.assert_allclose(lengths, FORESHORTENED, rtol=1e-15 * 4)
    np.testing.assert_allclose(camera() @ camera().T, np.eye(3), atol=1e-15)
    assert AZIMUTH < 0


@pytest.mark.parametrize("ending", [".gif", ".webp"])
def test_an_animation_of_a_scene_moves(ending, tmp_path):
    from PIL import Image

    scene = ns.Scene(gravity=(0, -9.81))
    scene.fixed(ns.HalfPlane((0, 1)))
    scene.body(ns.Disc(0.1), density=1000, position=(0, 1), velocity=(1, 0))
    sol = ns.simulate(scene, (0, 0.4), integrator=ns.MoreauJean(dt=2e-3))
    with Image.open(sol.animate(tmp_path / f"disc{ending}", fps=50)) as animation:
        assert animation.n_frames == 25
        places = []
        for k in (0, 24):
            animation.seek(k)
            shot = np.asarray(animation.convert("RGB")).astype(int)
            rows, columns = np.nonzero(shot[..., 2] - shot[..., 0] > 40)
            places.append((rows.mean(), columns.mean()))
    assert places[1][0] > places[0][0] + 50 and places[1][1] > places[0][1] + 20  # down, and to the right


def test_an_mp4_needs_ffmpeg_and_says_so(stack, tmp_path, monkeypatch):
    monkeypatch.setattr(shutil, "which", lambda name: None)
    with pytest.raises(ns.MissingExtra, match=r"written by ffmpeg, which is not installed; .* \.gif or \.webp"):
        stack.animate(tmp_path / "stack.mp4")
    assert not list(tmp_path.iterdir())


@pytest.mark.skipif(shutil.which("ffmpeg") is None, reason="ffmpeg is not installed")
def test_an_mp4_is_written_where_ffmpeg_is_there(stack, tmp_path):
    assert b"ftyp" in stack.animate(tmp_path / "stack.mp4").read_bytes()[:16]
