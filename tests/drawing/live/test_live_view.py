"""A run that is seen in a browser while it goes on: its state is what is sent, and nobody who looks ends it."""

import json
import subprocess
import sys
import urllib.request

import numpy as np
import pytest

import nonsmooth as ns
from models import BouncingBall, SpragSlip
from models.scenes import BoxStack, TumblingBox
from nonsmooth.commands.cli import main
from nonsmooth.drawing.live.meshes import mesh_of, outline_of
from nonsmooth.drawing.live.view import LiveModel, LiveScene
from nonsmooth.drawing.player.scene_film import body_of

FLOAT32 = 2.0**-23  # relative: what is sent has float32
STEP = ns.MoreauJean(dt=1e-3)
ADDRESS = "nonsmooth: live view at http://127.0.0.1:"


@pytest.fixture
def viser():
    return pytest.importorskip("viser", reason='a live view needs viser: pip install "nonsmooth[live]"')


@pytest.fixture
def views(viser, monkeypatch):
    """The live views of the test's runs."""
    opened = []
    for kind in (LiveModel, LiveScene):

        def open_and_keep(self, kind_open=kind.open):
            opened.append(self)
            kind_open(self)

        monkeypatch.setattr(kind, "open", open_and_keep)
    return opened


@pytest.fixture
def without_viser(monkeypatch):
    monkeypatch.setitem(sys.modules, "viser", None)


def sent_poses(window, n_b):
    """Positions (n_b, 3) and turns (n_b, 4) as the server has them for a browser."""
    position, turn = np.full((n_b, 3), np.nan), np.full((n_b, 4), np.nan)
    for handle, bodies in window.batches:
        position[bodies], turn[bodies] = handle.batched_positions, handle.batched_wxyzs
    return position, turn


def test_bodies_in_space_are_sent_where_the_run_has_them(views):
    sol = ns.simulate(TumblingBox(), (0, 0.05), integrator=STEP, view=True)
    position, turn = sent_poses(views[0].window, len(sol.names))
    assert np.abs(sol.turn[-1, -1] - sol.turn[0, -1]).max() > 1e-3
    np.testing.assert_allclose(position, sol.position[-1], atol=FLOAT32 * np.abs(sol.position).max())
    np.testing.assert_allclose(turn, sol.turn[-1], atol=FLOAT32)


def test_planar_bodies_and_their_contacts_are_sent_in_the_plane(views):
    scene = BoxStack(n=2, dim=2).scene()
    sol = ns.simulate(scene, (0, 0.02), integrator=STEP, view=True)
    window = views[0].window
    position, turn = sent_poses(window, len(sol.names))
    flat = np.column_stack([sol.position[-1], np.zeros(len(sol.names))])
    np.testing.assert_allclose(position, flat, atol=FLOAT32 * np.abs(flat).max())
    np.testing.assert_allclose(2 * np.arctan2(turn[:, 3], turn[:, 0]), sol.turn[-1], atol=4 * FLOAT32)
    found = sol.contacts()
    np.testing.assert_allclose(window.contacts.points[:, :2], found.point[found.P_N > 0], atol=1e-6)
    corners = sol.position[-1, 2] + np.array([(-0.1, -0.1), (0.1, -0.1), (0.1, 0.1), (-0.1, 0.1)])
    for corner in corners:  # of the upper box, in its outline
        assert np.abs(window.lines.points[..., :2] - corner).max(axis=-1).min() < 1e-6


def test_lines_of_a_model_are_sent_as_its_shape_has_them(views):
    rod = SpragSlip()
    sol = ns.simulate(rod, (0, 0.3), *rod.state(), integrator=STEP, view=True)
    lines = [*rod.outline(), *rod.shape(sol.q[-1])]
    ends = np.concatenate([np.stack([line[:-1], line[1:]], axis=1) for line in lines])
    np.testing.assert_allclose(views[0].window.lines.points[..., :2], ends, atol=4 * FLOAT32 * np.abs(ends).max())
    assert views[0].window.clock.content == "**t = 0.3 s**"


def test_a_browser_that_leaves_does_not_end_the_run(views):
    import viser
    from websockets.sync.client import connect

    heard = []

    def look(part):
        port = views[0].window.server.get_port()
        with urllib.request.urlopen(f"http://127.0.0.1:{port}", timeout=10) as page:
            assert page.status == 200 and b"<html" in page.read()
        with connect(f"ws://127.0.0.1:{port}", subprotocols=[f"viser-v{viser.__version__}"]) as browser:
            heard.append(browser.recv(timeout=10))

    ball = BouncingBall()
    sol = ns.simulate(ball, (0, 0.5), *ball.state(), integrator=STEP, view=True, progress=look)
    assert sol.success and sol.t[-1] == 0.5 and heard and all(len(message) > 0 for message in heard)


def test_the_next_run_is_seen_at_the_same_address(views, capfd):
    ball = BouncingBall()
    for _ in range(2):
        ns.simulate(ball, (0, 0.01), *ball.state(), integrator=STEP, view=True)
    first, second = (view.window.server for view in views)
    said = capfd.readouterr()
    assert first is second and said.out == "" and said.err.count(ADDRESS) <= 1


def test_what_cannot_be_shown_ends_the_view_and_not_the_run(viser, monkeypatch):
    monkeypatch.setattr(LiveModel, "segments", property(lambda self: 1 / 0))
    monkeypatch.setattr(LiveModel, "open", lambda self: setattr(self, "window", Unused()))
    ball = BouncingBall()
    with pytest.warns(ns.NonsmoothWarning, match="the live view ended, and the run goes on: "):
        sol = ns.simulate(ball, (0, 0.5), *ball.state(), integrator=STEP, view=True)
    assert sol.success


class Unused:
    def close(self):
        """Nothing was opened."""


def test_bits_are_those_of_a_run_that_nobody_sees(views):
    rod = SpragSlip()
    seen, unseen = (ns.simulate(rod, (0, 0.3), *rod.state(), integrator=STEP, view=view) for view in (True, False))
    assert seen.q.tobytes() == unseen.q.tobytes() and seen.P_N.tobytes() == unseen.P_N.tobytes()


def test_without_viser_a_sentence_says_what_brings_it(without_viser):
    ball = BouncingBall()
    with pytest.raises(ns.MissingExtra, match=r'a live view needs viser; .*pip install "nonsmooth\[live\]"'):
        ns.simulate(ball, (0, 0.1), *ball.state(), integrator=STEP, view=True)
    assert ns.simulate(ball, (0, 0.1), *ball.state(), integrator=STEP).success


def test_a_model_without_a_shape_is_not_shown(viser):
    sliding = ns.System(n_q=1, mass=unit_mass, force=no_force)
    with pytest.raises(ns.InvalidInput, match=r"nothing to show: its model has no shape\(q\); leave view=True out"):
        ns.simulate(sliding, (0, 0.1), [0.0], [1.0], integrator=STEP, view=True)


def unit_mass(t, q, p, M):
    M[0, 0] = 1.0


def no_force(t, q, u, p, h):
    h[0] = 0.0


def test_the_command_line_says_the_address_on_stderr_alone(viser):
    words = [
        sys.executable,
        "-m",
        "nonsmooth",
        "run",
        "bouncing-ball",
        "--t-end",
        "0.1",
        "--no-plot",
        "--json",
        "--live",
    ]
    ended = subprocess.run(words, capture_output=True, text=True, timeout=120)
    assert ended.returncode == 0 and json.loads(ended.stdout)["t"] == 0.1
    assert ended.stderr.count(ADDRESS) == 1


def test_the_command_line_refuses_what_cannot_be_shown(viser, capsys, tmp_path):
    assert main(["run", "bouncing-ball", "--live", "--t-end", "-1"]) == 2
    assert ADDRESS not in capsys.readouterr().err


# --- shapes

GOLDEN = 0.5 * (1 + np.sqrt(5))
ICOSAHEDRON = np.array([np.roll((0.0, a, b * GOLDEN), k) for k in range(3) for a in (-1, 1) for b in (-1, 1)])  # edge 2
SOLIDS = [  # shape, volume [m^3], the part of it that its facets leave out at most
    (ns.Sphere(0.2), 4 / 3 * np.pi * 0.2**3, 0.05),
    (ns.Box(0.1, 0.2, 0.4), 0.008, 1e-12),
    (ns.Capsule(0.5, 0.1), np.pi * 0.01 * 0.5 + 4 / 3 * np.pi * 0.001, 0.06),
    (ns.Polyhedron(0.1 * ICOSAHEDRON), 5 / 12 * (3 + np.sqrt(5)) * 0.2**3, 1e-12),
    (ns.Cylinder(0.1, 0.3), np.pi * 0.1**2 * 0.3, 0.02),
    (ns.Ellipsoid(0.1, 0.2, 0.3), 4 / 3 * np.pi * 0.006, 0.04),
]


def drawn(shape, gravity):
    scene = ns.Scene(gravity=gravity)
    body = scene.body(shape, density=1.0)
    return mesh_of(body_of(body, np.zeros(scene.dim), scene.dim), 1.0)


@pytest.mark.parametrize("shape, volume, missing", SOLIDS, ids=lambda value: type(value).__name__)
def test_a_mesh_encloses_the_volume_of_its_solid(shape, volume, missing):
    pytest.importorskip("trimesh")
    corners, triangles = drawn(shape, (0, 0, -9.81))
    a, b, c = np.moveaxis(corners[triangles], 1, 0)
    found = np.einsum("nk,nk->", a, np.cross(b, c)) / 6  # by Gauss's theorem; positive where seen from outside
    assert (1 - missing) * volume <= found <= volume * (1 + 1e-12)


@pytest.mark.parametrize(
    "shape, area, missing",
    [(ns.Disc(0.2), np.pi * 0.04, 0.06), (ns.Polygon([(0, 0), (0.3, 0), (0, 0.4)]), 0.06, 1e-12)],
)
def test_a_planar_mesh_has_the_area_of_its_body(shape, area, missing):
    mesh = drawn(shape, (0, -9.81))
    a, b, c = np.moveaxis(mesh.corners[mesh.triangles], 1, 0)
    assert (1 - missing) * area <= np.cross(b - a, c - a)[:, 2].sum() / 2 <= area * (1 + 1e-12)
    edges = outline_of(mesh)
    assert np.cross(edges[:, 0], edges[:, 1])[:, 2].sum() / 2 == pytest.approx(
        np.cross(b - a, c - a)[:, 2].sum() / 2, rel=1e-12
    )
