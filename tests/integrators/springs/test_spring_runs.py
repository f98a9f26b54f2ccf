"""Runs of scenes with compliant contacts: what is recorded, drawn and loaded; cylinders, polyhedra, ellipsoids."""

import math
import subprocess
import sys

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.commands.cli import main
from nonsmooth.contact.network.matrices import matrices_of
from nonsmooth.drawing.player.scene_film import film_of_scene
from nonsmooth.integrators.springs.scene_springs import half_thickness
from nonsmooth.runs.scene_run import SceneRun
from nonsmooth.scenes.shape_rows import POLYHEDRON, ShapeRow, shape_block

G = 9.81
K = 1e6
SPRINGS = ns.Penalty(K, damping_ratio=0.5)


def sliding_block(v=1.0):
    """A block of 2 kg on the ground, at the depth where its two springs bear it."""
    scene = ns.Scene(gravity=(0, -G), material=ns.Material(mu=0.3))
    scene.fixed(ns.HalfPlane((0, 1)), name="ground")
    scene.body(ns.Box(0.4, 0.1), mass=2.0, position=(0, 0.05 - G / K), velocity=(v, 0), name="block")
    return scene


@pytest.fixture(scope="module")
def run():
    return ns.simulate(sliding_block(), (0, 0.05), integrator=SPRINGS, every=3)


def test_what_is_not_recorded_of_springs_is_refused_by_name_and_changes_no_bit(run):
    """Each kind alone, with records at steps that the run chooses."""
    for kind in ("bodies", "contacts", "ledger"):
        part = ns.simulate(sliding_block(), (0, 0.05), integrator=SPRINGS, every=3, record=[kind])
        assert part.recorded == (kind,) and part.t.tobytes() == run.t.tobytes()
        columns = {"bodies": "position", "contacts": "all_contacts", "ledger": "ledger"}
        for other, column in columns.items():
            if other == kind:
                continue
            with pytest.raises(ns.InvalidInput, match=f"was not recorded.* keeps the {other}"):
                getattr(part, column)
        assert "longest step allowed" in part.summary()
        if kind == "ledger":
            assert {name: value.tobytes() for name, value in part.ledger.items()} == {
                name: value.tobytes() for name, value in run.ledger.items()
            }


@pytest.mark.parametrize("window", [1, 600])
def test_records_of_more_steps_than_there_was_room_for_are_those_of_one_window(run, monkeypatch, window):
    """Windows of two records, which the room for all of them grows with; of more than there is room for at first."""
    monkeypatch.setattr("nonsmooth.runs.recorder.SCENE_WINDOW", window)
    small = ns.simulate(sliding_block(), (0, 0.05), integrator=SPRINGS, every=3)
    assert len(run.t) > 8
    for name in ("t", "position", "velocity", "penetration"):
        assert getattr(small, name).tobytes() == getattr(run, name).tobytes()
    assert all(
        a.tobytes() == b.tobytes()
        for a, b in zip(small.all_contacts.columns.values(), run.all_contacts.columns.values(), strict=True)
    )


def test_what_springs_hold_is_in_files_and_labelled_data(run, tmp_path):
    """Energies as energies, pushes as forces [N]."""
    pytest.importorskip("xarray")
    data = run.to_xarray()
    assert data.elastic.long_name == "elastic energy" and data.damping.long_name == "work since the start by damping"
    np.testing.assert_array_equal(data.elastic, run.ledger["elastic"])
    assert data.contact_P.units == "N"
    again = ns.SceneSolution.load(run.save(tmp_path / "run.npz"))
    assert list(again.ledger) == list(run.ledger) and again.stats == run.stats


def test_the_player_shows_the_forces_of_springs(run):
    """It divides impulses by the time since the frame before: the weight of the block comes out again [N]."""
    film = film_of_scene(run)
    assert not film.is_of_last_step and len(film.times) == len(run.t)
    start, span = film.contacts.start, np.diff(film.times)
    force = [film.contacts.P_N[start[k] : start[k + 1]].sum() / span[k - 1] for k in range(1, len(film.times))]
    expected = [run.contacts(t).P_N.sum() for t in run.t[1:]]
    np.testing.assert_allclose(force, expected, rtol=1e-9)
    assert force[-1] == pytest.approx(2.0 * G, rel=0.05)


def test_a_compliant_run_that_was_stopped_goes_on_to_the_same_bits(tmp_path):
    """Another stiffness is another run."""

    def step(k):
        return ns.MoreauJean(1e-3, theta=1.0, compliance=ns.Compliance(k, 1e-3 * k))

    whole = ns.simulate(sliding_block(), (0, 0.1), integrator=step(K))
    path = tmp_path / "run.nsc"
    ns.simulate(sliding_block(), (0, 0.1), integrator=step(K), checkpoint=path, max_steps=37, on_failure="return")
    with pytest.raises(ns.InvalidInput, match="is of another run"):
        ns.simulate(sliding_block(), (0, 0.1), integrator=step(2 * K), resume=path)
    resumed = ns.simulate(sliding_block(), (0, 0.1), integrator=step(K), resume=path)
    for name in ("t", "position", "velocity", "residual", "penetration"):
        assert getattr(resumed, name).tobytes() == getattr(whole, name).tobytes()


def test_the_problem_of_a_compliant_step_has_the_compliance_on_its_diagonal():
    """gamma = G P + c, from G of the file and from the bodies' velocities and the springs'."""
    step = ns.MoreauJean(1e-3, theta=1.0, compliance=ns.Compliance(K, 10.0))
    run = SceneRun(sliding_block(), (0, 0.01), step, 1, None)
    run.advance(None, None)
    network = run.assembly.network
    n = int(network.n_c)
    G_, c, _, P, d = matrices_of(network, np.arange(n))
    rates = np.einsum("crx,cx->cr", network.J_i[:n], network.v[network.i[:n]])
    rates += np.einsum("crx,cx->cr", network.J_j[:n], network.v[network.j[:n]]) + network.b[:n]
    rates[:, 0] += P.reshape(n, d)[:, 0] / (K * 1e-6 + 10.0 * 1e-3)  # R = 1/(k dt^2 + c dt)
    assert P.reshape(n, d)[:, 0].sum() == pytest.approx(2.0 * G * 1e-3, rel=1e-3)
    np.testing.assert_allclose(G_ @ P + c, rates.ravel(), atol=1e-9)


OCTAGON = [(0.1 * math.cos(a), 0.1 * math.sin(a), z) for z in (-0.1, 0.1) for a in np.arange(8) * math.pi / 4]
UPRIGHT = (math.sqrt(0.5), 0.0, math.sqrt(0.5), 0.0)
SOLIDS = {  # shape, turn, height of the centre, and the points that touch: a cylinder is about its x-axis
    "log": (ns.Cylinder(0.1, 0.2), None, 0.1, 2), "can": (ns.Cylinder(0.1, 0.3), UPRIGHT, 0.15, 8),
    "polyhedron": (ns.Polyhedron(OCTAGON), None, 0.1, 8), "ellipsoid": (ns.Ellipsoid(0.1, 0.15, 0.12), None, 0.12, 1),
    "ball": (ns.Sphere(0.1), None, 0.1, 1),
}  # fmt: skip


@pytest.mark.parametrize("name", SOLIDS)
def test_a_solid_stands_on_springs_at_the_depth_that_bears_it(name):
    """m g = n k depth with the n points in which it touches; a damped spring comes to rest there."""
    shape, turn, height, n = SOLIDS[name]
    scene = ns.Scene(gravity=(0, 0, -G), material=ns.Material(mu=0.3))
    scene.fixed(ns.HalfSpace((0, 0, 1)), name="ground")
    scene.body(shape, mass=2.0, position=(0, 0, height), name="solid", **({} if turn is None else {"turn": turn}))
    run = ns.simulate(scene, (0, 0.5), integrator=SPRINGS, t_eval=[0.5])
    assert len(run.contacts()) == n
    assert height - run["solid"].position[-1, 2] == pytest.approx(2.0 * G / (n * K), rel=1e-6)
    assert run.contacts().P_N.sum() == pytest.approx(2.0 * G, rel=1e-6)


def test_the_thinnest_way_through_a_polyhedron_is_across_its_faces():
    """A slab of 2 mm, turned in its own axes, whose bounding box is wide."""
    box = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) * (0.1, 0.1, 0.001)
    c, s = math.cos(0.7), math.sin(0.7)
    vertices = box @ np.array([(c, 0, -s), (0, 1, 0), (s, 0, c)])
    faces = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))
    row = ShapeRow(
        0, POLYHEDRON, (0, 0, 0, 1, 0, 0, 0), vertices=vertices, faces=faces, size=np.ptp(vertices, axis=0) / 2
    )
    assert half_thickness(shape_block([row])) == pytest.approx(0.001, rel=1e-12)


def test_a_rigid_planar_scene_loads_nothing_of_springs():
    program = """
import sys
import nonsmooth as ns
scene = ns.Scene(gravity=(0, -9.81))
scene.body(ns.Disc(0.1), mass=1.0)
ns.simulate(scene, (0, 0.01), integrator=ns.MoreauJean(dt=1e-3))
print([name for name in sys.modules if "springs" in name or "spring_run" in name])
"""
    said = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True).stdout
    assert said.split("\n")[0] == "[]"


def test_the_penalty_study_takes_a_scene_of_a_file(tmp_path, capsys):
    """FILE.py:NAME, an instance of a Scene."""
    lines = ["import nonsmooth as ns", "pair = ns.Scene(gravity=(0, -9.81))", "pair.fixed(ns.HalfPlane((0, 1)))",
             "pair.body(ns.Disc(0.1), mass=1.0, position=(0, 0.1))"]  # fmt: skip
    (tmp_path / "mine.py").write_text("\n".join(lines))
    line = ["study", "penalty", f"{tmp_path / 'mine.py'}:pair", "--stiffness", "1e6", "1e7", "--no-plot"]
    assert main([*line, "--t-end", "0.05"]) == 0
    assert "the penalty limit" in capsys.readouterr().out
