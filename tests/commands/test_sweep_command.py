"""``nonsmooth sweep``: axes as they are typed, files, summaries, exit codes."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest

import nonsmooth as ns
from models.painleve_rod import PainleveRod
from nonsmooth.commands.cli import main
from nonsmooth.commands.typed_input import read_axis

SHORT = ["--t-end", "0.05", "--dt", "1e-3"]


@pytest.mark.parametrize(
    ("text", "values", "unit"),
    [
        ("mu=0:2:5", [0, 0.5, 1, 1.5, 2], ""),
        ("th=-pi/4:pi/4:3", [-math.pi / 4, 0, math.pi / 4], ""),
        ("dt=1e-4:1e-2:3:log", [1e-4, 1e-3, 1e-2], ""),
        ("dt=1e-4:1e-2:3:log:s", [1e-4, 1e-3, 1e-2], "s"),
        ("vb=0:1:2:m/s", [0, 1], "m/s"),
        ("th=0.1,pi/2", [0.1, math.pi / 2], ""),
        ("th=0.1,0.2:rad", [0.1, 0.2], "rad"),
        ("q0[0]=1:0:2", [1, 0], ""),
    ],
)
def test_axes_as_they_are_typed(text, values, unit):
    axis = read_axis(text)
    assert axis.name == text.split("=")[0] and axis.unit == unit
    np.testing.assert_allclose(axis.values, values, rtol=1e-15, atol=1e-16)


@pytest.mark.parametrize(
    "text", ("mu", "mu=", "=1:2:3", "mu=0:1:2.5", "mu=a:b:3", "mu=0:1:3:log", "mu=0:1:0", "mu=nan,1")
)
def test_axes_that_are_none(text):
    with pytest.raises(ns.InvalidInput, match="--axis|axis mu"):
        read_axis(text)


def test_a_map_from_the_command_line(tmp_path, capsys):
    out, plot = tmp_path / "map.npz", tmp_path / "map.png"
    code = main(["sweep", "painleve-rod", "--axis", "mu=0.5:2:4", "--axis", "th=0.5:1.4:3", "--measure", "paradoxes",
                 "--workers", "2", "--out", str(out), "--plot", str(plot), *SHORT])  # fmt: skip
    printed = capsys.readouterr()
    assert code == 0 and printed.err == "" and "12 cells (4 x 3)" in printed.out and str(out) in printed.out
    task = ns.RunTask(PainleveRod(), "paradoxes", t_span=(0, 0.05), integrator=ns.MoreauJean(1e-3))
    axes = {"mu": np.linspace(0.5, 2, 4), "th": np.linspace(0.5, 1.4, 3)}
    np.testing.assert_array_equal(ns.load_sweep(out).paradoxes, ns.sweep(task, axes, progress=False).paradoxes)
    assert plot.stat().st_size > 0


def test_failures_are_listed_and_a_sweep_of_nothing_but_failures_is_one(capsys):
    assert main(["sweep", "painleve-rod", "--axis", "mu=-1,0.5", *SHORT]) == 0
    printed = capsys.readouterr().out
    assert "1 cells failed:" in printed and "mu = -1: FAILED, mu must not be negative" in printed
    assert main(["sweep", "painleve-rod", "--axis", "mu=-2,-1", *SHORT]) == 3


def test_fail_fast_and_bad_input_end_with_one_line(tmp_path, capsys):
    assert main(["sweep", "painleve-rod", "--axis", "mu=-1,0.5", "--fail-fast", *SHORT]) == 3
    assert main(["sweep", "painleve-rod", "--axis", "muu=0:1:3", *SHORT]) == 2
    three = ["--axis", "mu=0:1:3", "th=1,1.1", "thdot=0,1", "--plot", str(tmp_path / "map.png")]
    assert main(["sweep", "painleve-rod", *three, *SHORT]) == 2
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) == 3 and "did you mean 'mu'?" in lines[1] and "--plot needs one or two axes" in lines[2]


def test_a_journal_resumes_from_the_command_line(tmp_path, capsys):
    command = ["sweep", "belt-oscillator", "--axis", "vb=0.1:0.4:4", "--journal", str(tmp_path / "j.jsonl"), *SHORT]
    assert main(command) == 0 and main(command) == 0
    assert "4 cells (4), 4 of them from the journal" in capsys.readouterr().out
    assert main([*command, "--anew", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["cells_from_journal"] == 0 and found["status"] == {"FINISHED": 4} and found["axes"] == {"vb": 4}


def test_progress_as_json_goes_to_stderr(capsys):
    assert main(["sweep", "belt-oscillator", "--axis", "vb=0.1:0.4:4", "--progress", "json", *SHORT]) == 0
    assert json.loads(capsys.readouterr().err.splitlines()[-1])["done"] == 4


def test_json_holds_every_result_over_its_axes(capsys):
    axes = ["--axis", "mu=1:2:3", "thdot=0,5", "--measure", "final_state", "modes"]
    assert main(["sweep", "painleve-rod", *axes, "--json", *SHORT]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["coordinates"]["mu"] == [1.0, 1.5, 2.0] and found["results"]["q"]["dims"][:2] == ["mu", "thdot"]
    rod = PainleveRod(mu=1.5)
    alone = ns.simulate(rod, (0, 0.05), *rod.state(thdot=5.0), integrator=ns.MoreauJean(1e-3))
    assert found["results"]["q"]["values"][1][1] == alone.q[-1].tolist()
    assert found["results"]["modes"]["values"][1][1] and np.shape(found["results"]["status"]["values"]) == (3, 2)


def test_a_figure_of_a_text_is_refused_before_any_run(monkeypatch, capsys):
    monkeypatch.setattr("nonsmooth.sweeps.sweep.sweep", None)
    assert main(["sweep", "painleve-rod", "--axis", "mu=1:2:3", "--measure", "modes", "--plot", "x.png", *SHORT]) == 2
    assert "needs a measure that is a number; modes is a text" in capsys.readouterr().err


def test_coordinates_of_different_units_have_a_line_each(capsys):
    """q = (x, y, th): metres and radians have no common range."""
    assert main(["sweep", "painleve-rod", "--axis", "mu=0.4,0.5", *SHORT]) == 0
    printed = capsys.readouterr().out
    lines = {line.split()[0]: line.split() for line in printed.splitlines()}
    assert lines["q[y]"][-1] == "m" and lines["q[th]"][-1] == "rad" and lines["u[th]"][-1] == "rad/s"
    assert "[q]" not in printed
    low, high = (float(lines["q[th]"][k]) for k in (1, 3))
    assert 0 < low <= high < 3.2
