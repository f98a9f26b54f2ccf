"""``nonsmooth classify`` and ``nonsmooth map`` as a user types them."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass

import numpy as np
import pytest

import nonsmooth as ns
from models import PainleveRod
from nonsmooth.commands.cli import main


@pytest.fixture(autouse=True)
def in_a_folder_of_its_own(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


def test_classify_prints_the_solutions_as_words(capsys):
    assert main(["classify", "painleve-rod", "--state", "th=pi/3", "thdot=6", "--restitution", "1"]) == 0
    text = capsys.readouterr().out
    assert text.startswith("INDETERMINATE") and "6.81361" in text and "energetic" in text and "0.255297" in text


def test_classify_takes_coordinates_and_gives_json(capsys):
    height = repr(0.5 * math.sin(math.pi / 3))
    assert (
        main(["classify", "painleve-rod", "--set", "mu=2", "--q", "0", height, "pi/3", "--u", "-1", "0", "0", "--json"])
        == 0
    )
    data = json.loads(capsys.readouterr().out)
    assert data["kind"] == "INCONSISTENT" and data["solutions"] == [] and data["chatter_ratio"] == [None]


@pytest.mark.parametrize("state", [["painleve-rod"], ["painleve-rod", "--state", "slip=0"], ["billiard-ball"]])
def test_classify_draws_every_state(state, tmp_path):
    assert main(["classify", *state, "--plot", "case.png"]) == 0
    assert (tmp_path / "case.png").read_bytes()[:4] == b"\x89PNG"


def test_map_writes_a_figure_and_a_netcdf_file_that_reads_back(capsys, tmp_path):
    import xarray

    command = ["map", "painleve-rod", "--axis", "th=0:pi/2:40", "--axis", "mu=0:3:31", "--state", "thdot=5"]
    assert main(command) == 0
    assert "inconsistent" in capsys.readouterr().out
    assert (tmp_path / "painleve-rod-map.png").read_bytes()[:4] == b"\x89PNG"
    with xarray.open_dataset(tmp_path / "painleve-rod-map.nc", engine="scipy") as chart:
        assert dict(chart.sizes) == {"th": 40, "mu": 31, "solution": 3}
        assert set(np.unique(chart.n_solutions)) == {0, 1, 2}
        assert chart.attrs["thdot"] == 5.0 and "INCONSISTENT" in chart.kind.flag_meanings


def test_map_of_one_axis_as_npz_with_parameters_from_a_list(tmp_path):
    assert main(["map", "painleve-rod", "--axis", "mu=0.5,2", "--out", "a.npz", "--plot", "a.svg"]) == 0
    with np.load(tmp_path / "a.npz") as data:
        assert data["n_solutions"].tolist() == [1, 0] and data["mu"].tolist() == [0.5, 2.0]
        assert json.loads(str(data["about"]))["dims"]["la_N"] == ["mu", "solution"]
    assert (tmp_path / "a.svg").read_text().startswith("<?xml")


@pytest.mark.parametrize(
    "command, message",
    [
        (["map", "bouncing-ball"], "give axes"),
        (["map", "painleve-rod", "--axis", "th"], "NAME=LOW:HIGH"),
        (["map", "painleve-rod", "--axis", "th=1:0"], "LOW < HIGH"),
        (["map", "painleve-rod", "--axis", "th=0:x"], "no number"),
        (["map", "painleve-rod", "--axis", "th=0:1", "--axis", "th=0:2"], "twice"),
        (["map", "painleve-rod", "--axis", "th=0:1", "--state", "th=0.5"], "fixed by --state"),
        (["map", "painleve-rod", "--axis", "thh=0:1"], "did you mean 'th'"),
        (["map", "painleve-rod", "--axis", "th=0:1", "--out", "map.csv"], ".nc"),
        (["classify", "painleve-rod", "--q", "0", "0", "0"], "go together"),
        (["classify", "bouncing-ball", "--q", "0", "--u", "-1"], "an impact comes first"),
    ],
)
def test_refusals_are_one_line_and_write_nothing(command, message, capsys, tmp_path):
    assert main(command) == 2
    error = capsys.readouterr().err
    assert message in error and error.count("\n") == 1
    assert list(tmp_path.iterdir()) == []


def test_axes_of_a_map_are_those_of_a_sweep(tmp_path):
    axes = ["mu=0.5:2:3:log", "th=0.1:1.5:3:rad"]
    assert main(["map", "painleve-rod", "--axis", *axes, "--out", "a.npz", "--plot", "a.svg"]) == 0
    with np.load(tmp_path / "a.npz") as data:
        assert data["mu"] == pytest.approx([0.5, 1.0, 2.0], rel=1e-15)
        assert data["n_solutions"].shape == (3, 3)


@dataclass(frozen=True)
class Leaning(PainleveRod):
    """A rod whose rest angle bears the name of a variable of its state."""

    th: float = 1.0


def test_a_name_of_a_parameter_and_of_a_variable_is_refused_as_an_axis():
    with pytest.raises(ns.InvalidInput, match="'th' has two meanings, a parameter and a variable of state"):
        ns.paradox_map(Leaning(), th=[0.5, 1.0], progress=False)
