"""Pictures and animations of scenes: bodies where they are, at the instants asked for, as wide as a column."""

import shutil
import subprocess
import sys
from types import SimpleNamespace

import numpy as np
import pytest

import nonsmooth as ns
from models.scenes import BoxStack
from nonsmooth.commands.cli import main
from nonsmooth.drawing.animation import find_ffmpeg
from nonsmooth.drawing.plots import new_figure
from nonsmooth.drawing.scene import ARROW
from nonsmooth.drawing.scene_contacts import scene_contact_marks
from nonsmooth.drawing.scene_figures import draw_bodies, extent_of
from nonsmooth.drawing.spatial_bodies import AZIMUTH, FORESHORTENED, camera, grounds_seen, spatial_extent


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


@pytest.mark.parametrize(
    "shape, height", [(ns.Box(0.4, 0.3, 0.2), 0.1), (ns.Sphere(0.1), 0.1), (ns.Ellipsoid(2e-3, 1e-3, 1e-3), 1e-3)]
)
def test_the_ground_is_seen_on_all_sides_of_one_body_at_rest(shape, height):
    """It was as wide as the body's centre moves."""
    scene = ns.Scene(gravity=(0, 0, -9.81))
    scene.fixed(ns.HalfSpace((0, 0, 1)))
    scene.body(shape, mass=1.0, position=(1, 2, height))
    sol = ns.simulate(scene, (0, 0.01), integrator=ns.MoreauJean(dt=1e-3))
    (ground,) = grounds_seen(sol, 0, camera())
    low, high = spatial_extent(sol)
    assert ground[:, 0].min() < low[0] < high[0] < ground[:, 0].max() and ground[:, 1].min() < low[1]


def thrown_disc():
    scene = ns.Scene(gravity=(0, -9.81))
    scene.fixed(ns.HalfPlane((0, 1)))
    scene.body(ns.Disc(0.1), density=1000, position=(0, 1), velocity=(1, 0))
    return ns.simulate(scene, (0, 0.4), integrator=ns.MoreauJean(dt=2e-3))


def test_of_bodies_in_one_another_the_same_one_hides_the_other_in_every_frame(stack):
    """What is drawn at one height is drawn as it was added: free, fixed and guided bodies."""
    for record in range(20):
        axes = new_figure(3.0, 3.0).subplots()
        drawn = draw_bodies(axes, stack, record, extent_of(stack))
        places = [axes.get_children().index(artist) for artist in drawn if artist.get_zorder() == 1]
        assert len(places) == 3 and places == sorted(places)


@pytest.mark.parametrize("ending", [".gif", ".webp"])
def test_an_animation_of_a_scene_moves(ending, tmp_path):
    from PIL import Image

    with Image.open(thrown_disc().animate(tmp_path / f"disc{ending}", fps=50)) as animation:
        assert animation.n_frames == 25
        places = []
        for k in (0, 24):
            animation.seek(k)
            shot = np.asarray(animation.convert("RGB")).astype(int)
            rows, columns = np.nonzero(shot[..., 2] - shot[..., 0] > 40)
            places.append((rows.mean(), columns.mean()))
    assert places[1][0] > places[0][0] + 50 and places[1][1] > places[0][1] + 20  # down, and to the right


def test_an_animation_shows_loaded_contacts_and_what_they_exert_on_the_free_body(stack):
    """Of two cubes at rest: the impulses of a step carry weight times step, upwards; those of the ground twice that."""
    axes = new_figure(4.0, 4.0).subplots()
    axes.set_ylim(0.0, 1.0)
    lines, dots = scene_contact_marks(axes, stack, np.eye(2))(len(stack.t) - 1)
    contacts = stack.contacts()
    np.testing.assert_array_equal(dots.get_offsets(), contacts.point)
    spans = np.array([end - start for start, end in lines.get_segments()])
    weight = BoxStack(n=2, dim=2).density * 0.2**2 * 9.81
    (label,) = (text.get_text() for text in axes.figure.legends[0].get_texts() if "impulse" in text.get_text())
    full = float(label.split()[-3])
    low = contacts.point[:, 1] < 0.1
    carried = [spans[rows, 1].sum() / ARROW * full for rows in (low, ~low)]
    assert carried == pytest.approx([2 * weight * 2e-3, weight * 2e-3], rel=5e-3)  # the label has three figures
    assert (spans[:, 1] > 0).all() and "stick" in [text.get_text() for text in axes.figure.legends[0].get_texts()]


def test_an_animation_without_recorded_contacts_shows_bodies_alone(tmp_path):
    run = ns.simulate(BoxStack(n=2, dim=2), (0, 0.02), integrator=ns.MoreauJean(dt=2e-3), record=["bodies"])
    assert scene_contact_marks(new_figure(4.0, 4.0).subplots(), run, np.eye(2))(1) == []
    assert run.animate(tmp_path / "stack.gif").stat().st_size > 1000


def test_an_mp4_needs_ffmpeg_and_says_so(stack, tmp_path, monkeypatch):
    monkeypatch.setattr(shutil, "which", lambda name: None)
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    with pytest.raises(ns.MissingExtra, match=r"written by ffmpeg, which is not installed; .* \.gif or \.webp"):
        stack.animate(tmp_path / "stack.mp4")
    assert not list(tmp_path.iterdir())


def test_ffmpeg_of_a_python_package_is_taken_where_there_is_no_other(monkeypatch):
    monkeypatch.setattr(shutil, "which", lambda name: None)
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", SimpleNamespace(get_ffmpeg_exe=lambda: "/there/ffmpeg"))
    assert find_ffmpeg() == "/there/ffmpeg"


def test_why_ffmpeg_ended_is_told_and_no_file_is_left(stack, tmp_path, monkeypatch):
    program = tmp_path / "ffmpeg"
    program.write_text("#!/bin/sh\necho 'Unknown encoder' >&2\nexit 1\n")
    program.chmod(0o755)
    monkeypatch.setattr(shutil, "which", lambda name: str(program))
    with pytest.raises(ns.FileFailure, match="ffmpeg could not write the animation: Unknown encoder"):
        stack.animate(tmp_path / "stack.mp4")
    assert list(tmp_path.iterdir()) == [program]


with_ffmpeg = pytest.mark.skipif(
    shutil.which("ffmpeg") is None, reason="an .mp4 is written by ffmpeg: install Debian's package ffmpeg"
)


def images_of(path):
    """The frames a second and the images (n, height, width, 3) of a film, as ffmpeg reads them."""
    ask = ["ffprobe", "-v", "error", "-show_entries", "stream=width,height,r_frame_rate", "-of", "csv=p=0", str(path)]
    width, height, rate = subprocess.run(ask, capture_output=True, text=True, check=True).stdout.strip().split(",")
    read = ["ffmpeg", "-v", "error", "-i", str(path), "-f", "rawvideo", "-pix_fmt", "rgb24", "-"]
    raw = subprocess.run(read, capture_output=True, check=True).stdout
    return rate, np.frombuffer(raw, np.uint8).reshape(-1, int(height), int(width), 3).astype(int)


@pytest.mark.upkeep
@with_ffmpeg
def test_an_mp4_shows_the_motion_at_its_frames_a_second(tmp_path):
    rate, images = images_of(thrown_disc().animate(tmp_path / "disc.mp4", fps=50))
    assert rate == "50/1" and len(images) == 25
    places = [np.argwhere(image[..., 2] - image[..., 0] > 40).mean(axis=0) for image in (images[0], images[-1])]
    assert (places[1] - places[0] > [20, 50]).all()  # down, and to the right


@with_ffmpeg
def test_the_command_line_writes_an_mp4_of_a_model(tmp_path, capsys):
    path = tmp_path / "rod.mp4"
    words = ["run", "wall-pendulum", "--t-end", "0.3", "--dt", "1e-3", "--no-plot", "--animate", str(path)]
    assert main(words) == 0 and str(path) in capsys.readouterr().out
    _, images = images_of(path)
    assert len(images) >= 25 and (images[0] != images[-1]).any()
