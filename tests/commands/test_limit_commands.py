"""``nonsmooth study penalty`` and ``nonsmooth study convergence``."""

import re

import pytest

from nonsmooth.commands.cli import main

pytest.importorskip("xarray")


def test_study_penalty_prints_a_line_a_stiffness_and_draws(tmp_path, monkeypatch, capsys):
    pytest.importorskip("matplotlib")
    monkeypatch.chdir(tmp_path)
    start = ["--state", "th=0.78", "thdot=1", "--t-end", "0.05"]
    assert (
        main(["study", "penalty", "sprag-slip", *start, "--damping-time", "1", "--stiffness", "1e4", "1e5", "1e6"]) == 0
    )
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == "sprag-slip: the penalty limit"
    assert [line.split()[0] for line in lines[2:5]] == ["1e+04", "1e+05", "1e+06"]
    assert lines[-1] == "figure: sprag-slip-penalty.png"
    assert (tmp_path / "sprag-slip-penalty.png").exists()


def test_study_convergence_prints_orders(capsys):
    start = ["--set", "th_w=-1.5", "--state", "th=1", "--t-end", "1"]
    dt = ["--dt", "1e-2", "5e-3", "2.5e-3"]
    assert main(["study", "convergence", "wall-pendulum", "--no-plot", *start, *dt]) == 0
    out = capsys.readouterr().out
    assert "wall-pendulum: convergence with the step" in out and "dt^2" in out


@pytest.mark.parametrize(
    ("arguments", "title"),
    [
        (["--integrator", "event-driven", "--rtol", "1e-4", "1e-6"], "convergence with the tolerance"),
        (["--integrator", "adaptive", "--rtol", "1e-3", "1e-6", "--reference", "event-driven"],
         "convergence with the tolerance"),
        (["--integrator", "penalty", "--stiffness", "1e6", "--damping-ratio", "1", "--rtol", "1e-5", "1e-6"],
         "convergence with the tolerance"),
        (["--integrator", "moreau-jean", "--theta", "1", "--dt", "1e-3", "1e-4", "--reference", "event-driven"],
         "convergence with the step"),
    ],
)  # fmt: skip
def test_study_convergence_takes_any_integrator(arguments, title, capsys):
    start = ["--state", "th=0.78", "thdot=1", "--t-end", "0.1"]
    assert main(["study", "convergence", "sprag-slip", "--no-plot", *start, *arguments]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == f"sprag-slip: {title}" and "error_event_t" in lines[1]
    assert re.search(r"\(\d\.\d\d\)", lines[3])  # an order


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["penalty", "sprag-slip", "--damping", "1", "--damping-time", "1"], "either --damping or --damping-time"),
        (["penalty", "sprag-slip", "--damping", "1", "--damping-ratio", "1"], "either damping or damping_ratio"),
        (["penalty", "sprag-slip", "--stiffness", "1e6", "1e5"], "stiffness must increase"),
        (["convergence", "sprag-slip", "--dt", "0"], "dt must be positive"),
        (["convergence", "sprag-slip", "--times", "99"], "times must increase within"),
        (["convergence", "sprag-slip", "--rtol", "1e-6"], "--rtol is no option of --integrator moreau-jean"),
        (["convergence", "sprag-slip", "--integrator", "event-driven", "--dt", "1e-3"], "--dt is no option of"),
        (["convergence", "sprag-slip", "--integrator", "adaptive", "--dt", "1e-3"], "--dt is no option of"),
        (["convergence", "sprag-slip", "--integrator", "penalty"], "needs --stiffness"),
        (
            ["convergence", "sprag-slip", "--integrator", "penalty", "--stiffness", "1e6", "--rtol", "2"],
            "rtol must lie in",
        ),
    ],
)
def test_bad_input_is_one_line_and_code_2(arguments, words, capsys):
    assert main(["study", *arguments, "--no-plot"]) == 2
    error = capsys.readouterr().err.strip().splitlines()
    assert words in error[-1]
