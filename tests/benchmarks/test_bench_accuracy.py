"""The benchmark of accuracy: every scene runs, two methods agree on it, and its page says what was measured."""

import json

import numpy as np
import pytest

import nonsmooth as ns
from benchmarks import accuracy, command, motions, peers
from benchmarks.accuracy_page import page
from nonsmooth.studies.comparison import as_problem
from nonsmooth.studies.work_precision import Trial, as_known, distance

pytest.importorskip("xarray")

SCENES = accuracy.scenes()


@pytest.mark.parametrize("name", SCENES)
def test_event_driven_meets_its_tolerance_on_every_scene(name):
    scene = SCENES[name]
    problem = as_problem(scene.system, scene.t_span, scene.q0, scene.u0, scene.times)
    pair = (ns.EventDriven(rtol=1e-10, atol=1e-12), ns.Adaptive(rtol=1e-8, atol=1e-10))
    known = as_known(scene.reference or pair, problem)
    assert known.disagreement < 1e-5  # errors are per step: the scenes magnify a thousandfold at most
    q = problem.run(ns.EventDriven(rtol=1e-7, atol=1e-9), problem.times).q[-len(problem.times) :]
    assert distance(q, known.q) < 1e-5


def test_beads_of_the_scene_end_as_their_closed_form():
    scene = SCENES["bead chain"]
    assert np.isfinite(scene.reference(2.0)).all() and len(scene.reference(2.0)) == motions.BEADS


def test_page_has_times_ratios_and_bounds():
    class Other:
        """Another program: never better than 1e-3, in a known time."""

        def settings(self, name, problem):
            return (1.0,)

        def run(self, name, problem, setting):
            q = np.array([[SCENES["ball through Zeno"].reference(t)[0] + 2e-3] for t in problem.times])
            return Trial(q, 0.5, 1, 1)

    study = ns.work_precision(
        {"ball through Zeno": SCENES["ball through Zeno"]},
        {"EventDriven": ns.OwnMethod(ns.EventDriven, (1e-6,)), "Other": Other()}, repeats=1,
    )  # fmt: skip
    text = page(study, "a machine", "figure.png", 1)
    assert "a machine" in text and "](figure.png)" in text and "closed form" in text
    row = next(line for line in text.splitlines() if line.startswith("| ball through Zeno"))
    ours = 1e3 * study.cost_at(1e-4, "ball through Zeno", "EventDriven")
    assert f"> 500 (> {500 / ours:.2g}×)" in row


def test_command_writes_its_page_and_figure(tmp_path, capsys):
    pytest.importorskip("matplotlib")
    out = tmp_path / "accuracy.md"
    assert accuracy.main(["sliding", "--repeats", "1", "--out", str(out)]) == 0
    assert "sliding block: reference given" in capsys.readouterr().out
    assert (tmp_path / "accuracy.png").stat().st_size > 0 and "MoreauJean" in out.read_text()


def test_a_peer_that_ends_is_a_failure_of_its_run(monkeypatch):
    method = peers.Siconos()
    scene = SCENES["ball through Zeno"]
    problem = as_problem(scene.system, scene.t_span, scene.q0, scene.u0, scene.times)
    monkeypatch.setattr(method, "ask", lambda request: json.loads('{"error": "its process has ended"}'))
    with pytest.raises(ns.StepFailure, match="has ended"):
        method.run("ball through Zeno", problem, 1e-3)
    assert method.settings("a scene that it cannot express", problem) == []


def test_options_of_this_benchmark_are_refused_elsewhere(capsys):
    assert command.main(["core", "--peers"]) == 2
    assert "--peers belongs to `accuracy`; leave it out of `core`" in capsys.readouterr().err
