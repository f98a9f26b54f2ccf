"""The command line as a user meets it: what it prints, writes, refuses, and returns."""

import json
import subprocess
import sys

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.cli import main

QUICK = ["--t-end", "0.01", "--no-plot"]


def test_version_is_printed(capsys):
    with pytest.raises(SystemExit) as stop:
        main(["--version"])
    assert stop.value.code == 0
    assert capsys.readouterr().out.strip() == f"nonsmooth {ns.__version__}"


def test_list_names_every_model_with_its_parameters(capsys):
    assert main(["list"]) == 0
    printed = capsys.readouterr().out
    assert all(name in printed for name in ("sprag-slip", "painleve-rod", "bouncing-ball", "mu=1.3"))


def test_run_prints_the_paradox_it_met_and_draws(tmp_path, capsys):
    figure = tmp_path / "run.png"
    assert main(["run", "sprag-slip", "--t-end", "0.1", "--plot", str(figure)]) == 0
    printed = capsys.readouterr().out
    assert "1 inconsistent" in printed and "impact without collision" in printed
    assert figure.read_bytes().startswith(b"\x89PNG")


def test_json_holds_the_final_state_and_nothing_else_is_printed(capsys):
    assert main(["run", "painleve-rod", "--set", "mu=2", "--state", "th=pi/3", "thdot=0", "--json", *QUICK]) == 0
    result = json.loads(capsys.readouterr().out)
    assert result["status"] == "FINISHED"
    assert result["paradoxes"][0]["kind"] == "INCONSISTENT"
    assert len(result["q"]) == 3


def test_state_may_be_typed_as_coordinates(capsys):
    assert main(["run", "bouncing-ball", "--q0", "2", "--u0=-1", "--dt", "1e-3", "--every", "2", "--json", *QUICK]) == 0
    result = json.loads(capsys.readouterr().out)
    assert np.isclose(result["q"][0], 2 - 0.01 - 9.81 / 2 * 1e-4, atol=1e-12)


@pytest.mark.parametrize("name", ["run.npz", "run.h5"])
def test_saved_runs_are_read_back(tmp_path, name, capsys):
    assert main(["run", "sliding-block", "--out", str(tmp_path / name), *QUICK]) == 0
    assert ns.Solution.load(tmp_path / name).success


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["run", "sprag-slp"], "did you mean 'sprag-slip'?"),
        (["run", "sprag-slip", "--set", "mue=1"], "did you mean 'mu'?"),
        (["run", "sprag-slip", "--set", "mu"], "NAME=VALUE"),
        (["run", "sprag-slip", "--set", "mu=big"], "mu must be a number"),
        (["run", "sprag-slip", "--set", "mu=-1"], "mu"),
        (["run", "sprag-slip", "--state", "tht=1"], "did you mean 'th'?"),
        (["run", "sprag-slip", "--q0", "1", "2"], "--q0 and --u0 go together"),
        (["run", "sprag-slip", "--dt", "0"], "dt must be positive"),
        (["run", "sprag-slip", "--t-end=-1"], "must not run backwards"),
        (["run", "sprag-slip", "--selection", "free"], "selection rule"),
        (["run", "sprag-slip", "--out", "nowhere/run.npz"], "there is no folder 'nowhere'"),
        (["run", "sprag-slip", "--plot", "nowhere/run.png"], "there is no folder 'nowhere'"),
    ],
)
def test_bad_input_is_one_sentence_and_exit_code_2(arguments, message, capsys):
    assert main(arguments) == 2
    captured = capsys.readouterr()
    assert message in captured.err
    assert captured.out == "" and captured.err.count("\n") == 1


def test_a_run_that_fails_is_saved_and_ends_with_code_3(tmp_path, capsys):
    out = tmp_path / "part.npz"
    arguments = ["run", "self-locking-rod", "--set", "th0=0.9", "mu=1", "--out", str(out), *QUICK]
    assert main(arguments) == 3
    assert "no solution" in capsys.readouterr().out
    assert ns.Solution.load(out).status == ns.Status.NO_SOLUTION


@pytest.mark.parametrize(
    "code", ["import nonsmooth", "from nonsmooth.cli import build_parser; build_parser().format_help()"]
)
def test_heavy_packages_are_not_imported_before_they_are_needed(code):
    heavy = ["numpy", "numba", "scipy", "matplotlib", "qpsolvers", "xarray", "h5py"]
    check = f"{code}; import sys; print([name for name in {heavy} if name in sys.modules])"
    printed = subprocess.run([sys.executable, "-c", check], capture_output=True, text=True, check=True).stdout
    assert printed.strip() == "[]"
