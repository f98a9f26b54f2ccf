"""The command line as a user meets it: what it prints, writes, refuses, and returns."""

import argparse
import json
import math
import os
import pty
import re
import select
import signal
import subprocess
import sys
import time
from subprocess import DEVNULL, PIPE

import numpy as np
import pytest

import nonsmooth as ns
from models import BeltOscillator
from nonsmooth.commands.cli import build_parser, main
from nonsmooth.commands.typed_input import number

QUICK = ["--t-end", "0.01", "--no-plot"]
PATIENCE = 120  # s for another interpreter: on a new machine it compiles the loop first


def refused(arguments):
    """The exit code of arguments that may be refused by the parser already."""
    try:
        return main(arguments)
    except SystemExit as stop:
        return stop.code


def in_python(code, *arguments, stdout=PIPE, stderr=PIPE):
    """The code, run by an interpreter of its own that never waits for a user."""
    command = [sys.executable, "-c", code, *map(str, arguments)]
    return subprocess.run(command, stdin=DEVNULL, stdout=stdout, stderr=stderr, text=True, timeout=PATIENCE)


def read_until(terminal, text, seconds):
    """What a terminal shows until the text appears on it; fails when it does not in time."""
    shown, end = b"", time.monotonic() + seconds
    while text not in shown:
        is_ready, _, _ = select.select([terminal], [], [], max(0.0, end - time.monotonic()))
        try:
            piece = os.read(terminal, 1000) if is_ready else b""
        except OSError:  # the program has ended: nobody holds the other end
            piece = b""
        assert piece, f"the program said {shown!r} and no more"
        shown += piece
    return shown


def test_version_is_printed(capsys):
    with pytest.raises(SystemExit) as stop:
        main(["--version"])
    assert stop.value.code == 0
    assert capsys.readouterr().out.strip() == f"nonsmooth {ns.__version__}"


def test_list_names_every_model_with_its_parameters(capsys):
    assert main(["list"]) == 0
    printed = capsys.readouterr().out
    assert all(name in printed for name in ("sprag-slip", "painleve-rod", "bouncing-ball", "mu=1.3"))


def test_the_examples_of_the_help_are_understood_and_its_options_stand_in_groups(capsys):
    with pytest.raises(SystemExit):
        main(["run", "--help"])
    said = capsys.readouterr().out
    examples = re.findall(r"^  nonsmooth (.*)$", said, re.MULTILINE)
    assert len(examples) == 4 and all(build_parser().parse_args(words.split()).act for words in examples)
    assert said.index("the model and its start:") < said.index("the integrator:") < said.index("what is printed:")


def test_run_prints_the_paradox_it_met_and_draws(tmp_path, capsys):
    figure = tmp_path / "run.png"
    assert main(["run", "sprag-slip", "--t-end", "0.1", "--plot", str(figure)]) == 0
    printed = capsys.readouterr().out
    assert "1 inconsistent" in printed and "impact without collision" in printed
    assert figure.read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize("law", ["cubic", "stribeck"])
def test_a_parameter_that_is_a_text_is_set_by_its_text(law, capsys):
    assert main(["run", "belt-oscillator", "--set", f"law={law}", "--json", "--dt", "1e-3", *QUICK]) == 0
    belt = BeltOscillator(law=law)
    sol = ns.simulate(belt, (0, 0.01), *belt.state(), integrator=ns.MoreauJean(dt=1e-3))
    assert json.loads(capsys.readouterr().out)["u"] == sol.u[-1].tolist()


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


@pytest.mark.upkeep
@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["run", "sprag-slp"], "did you mean 'sprag-slip'?"),
        (["run", "ball"], "did you mean 'billiard-ball' or 'bouncing-ball' or 'wrecking-ball'?"),
        (
            ["run", "rod"],
            "did you mean 'bilateral-rod' or 'painleve-rod' or 'self-locking-rod' or 'spatial-painleve-rod'?",
        ),
        (["run", "sprag-slip", "--set", "mue=1"], "did you mean 'mu'?"),
        (["run", "sprag-slip", "--set", "mu"], "NAME=VALUE"),
        (["run", "sprag-slip", "--set", "mu=big"], "mu must be a number"),
        (["run", "belt-oscillator", "--set", "law=stribek"], "did you mean 'stribeck'?"),
        (["run", "belt-oscillator", "--set", "law=3"], "known: cubic, smoothed, stribeck, two-coefficient"),
        (["run", "belt-oscillator", "--set", "lawe=cubic"], "there is no parameter 'lawe'; did you mean 'law'?"),
        (["sweep", "belt-oscillator", "--axis", "law=cubic,stribeck"], "'cubic' is no number"),
        (["run", "sprag-slip", "--set", "mu=-1"], "mu"),
        (["run", "sprag-slip", "--state", "tht=1"], "did you mean 'th'?"),
        (["run", "sprag-slip", "--q0", "1", "2"], "--q0 and --u0 go together"),
        (["run", "sprag-slip", "--dt", "0"], "dt must be positive"),
        (["run", "sprag-slip", "--t-end=-1"], "must not run backwards"),
        (["run", "sprag-slip", "--selection", "free"], "selection rule"),
        (["run", "sprag-slip", "--dt", "-1e-3"], "dt must be positive [s]; got -0.001"),
        (["run", "sprag-slip", "--dt", "nan"], "dt must be finite"),
        (["run", "sprag-slip", "--theta", "0.2"], "theta must lie in [0.5, 1]"),
        (["run", "sprag-slip", "--every", "0"], "every must be a whole number"),
        (["run", "sprag-slip", "--t-eval", "0.2", "0.1"], "t_eval must increase"),
        (["run", "sprag-slip", "--set", "mu=1", "mu=2"], "gives mu twice"),
        (["run", "sprag-slip", "--set", "mu=nan"], "mu must be finite"),
        (["run", "sprag-slip", "--set", "mu=__import__('os')"], "is no number"),
        (["run", "bouncing-ball", "--set", "e=1.5"], "e must lie in [0, 1]; got 1.5"),
        (["run", "bead-chain", "--set", "n=2.5"], "the parameter n must be a whole number; got 2.5"),
        (["run", "sprag-slip", "--q0", "1", "2", "3", "--u0", "0", "0"], "q0 must have 2 entries; got 3"),
        (["run", "sprag-slip", "--q0", "1", "nan", "--u0", "0", "0"], "q0 must be finite; q0[1] is nan"),
        (["run", "sprag-slip", "--q0", "1", "1", "--u0", "0", "0", "--state", "th=1"], "either --state, or --q0"),
        (["run", "sprag-slip", "--dt", "1e-300"], "too small"),
        (["run", "sprag-slip", "--plot", "run.png", "--no-plot"], "either --plot or --no-plot"),
        (["run", "sprag-slip", "--out", "run.csv"], "must end in one of .npz"),
        (["run", "sprag-slip", "--plot", "run.txt"], "must end in one of .png"),
        (["run", "sprag-slip", "--animate", "run.avi"], "must end in one of .gif"),
        (["run", "sprag-slip", "--view", "run.pdf"], "must end in one of .html"),
        (["run", "sprag-slip", "--view", "nowhere/run.html"], "there is no folder 'nowhere'"),
        (["run", "sprag-slip", "--animate", "nowhere/run.gif"], "there is no folder 'nowhere'"),
        (["solve", "nowhere.npz", "--plot", "nowhere/profile.png"], "there is no folder 'nowhere'"),
        (["run", "sprag-slip", "--out", "nowhere/run.npz"], "there is no folder 'nowhere'"),
        (["run", "sprag-slip", "--plot", "nowhere/run.png"], "there is no folder 'nowhere'"),
        (["run", "sprag-slip", "--plot", ""], "is a folder"),
        (["run", "sprag-slip", "--out", "."], "is a folder"),
        (["run", "sprag-slip", "--t-eval", "5", "7"], "t_eval must increase within [0, 1]; got [5. 7.]"),
        (["run", "sprag-slip", "--t-eval", "0.1", "--every", "2"], "either every or t_eval"),
        (["run", "sprag-slip", "--every", "1.5"], "'1.5' is no whole number"),
        (["run", "sprag-slip", "--dt", "1e-12"], "GiB are free; take a larger every or dt"),
        (["run", "bead-chain", "--set", "n=2.7"], "the parameter n must be a whole number; got 2.7"),
        (["run", "sprag-slip", "--dt"], "argument --dt: expected one argument; see nonsmooth run --help"),
        (["run", "sprag-slip", "--step", "1"], "unrecognized arguments: --step"),
        (["run"], "the following arguments are required: MODEL"),
        ([], "the following arguments are required: COMMAND"),
        (["solve", "problem.npz", "--solver", "lemk"], "did you mean 'lemke'?"),
        (["solve", "problem.npz", "--tol", "-1"], "tol must be positive; got -1"),
    ],
)
def test_bad_input_is_one_sentence_and_exit_code_2(arguments, message, capsys):
    assert refused(arguments) == 2
    captured = capsys.readouterr()
    assert message in captured.err and captured.err.startswith("nonsmooth")
    assert captured.out == "" and captured.err.count("\n") == 1


def test_a_step_longer_than_the_run_is_cut_to_it(capsys):
    assert main(["run", "bouncing-ball", "--dt", "1e300", "--json", *QUICK]) == 0
    result = json.loads(capsys.readouterr().out)
    assert (result["t"], result["stats"]["steps"]) == (0.01, 1)


def test_a_picture_and_an_animation_are_written_where_asked(tmp_path, capsys):
    picture, animation = tmp_path / "scene.svg", tmp_path / "scene.gif"
    assert main(["run", "sliding-block", *QUICK, "--picture", str(picture), "--animate", str(animation)]) == 0
    assert picture.exists() and animation.exists()
    printed = capsys.readouterr().out
    assert f"picture: {picture}" in printed and f"animation: {animation}" in printed


def test_a_player_is_written_where_asked(tmp_path, capsys):
    page = tmp_path / "block.html"
    assert main(["run", "sliding-block", *QUICK, "--no-plot", "--view", str(page)]) == 0
    assert f"player: {page}" in capsys.readouterr().out and page.read_text().startswith("<!doctype html>")


def test_a_run_of_no_length_is_drawn_and_counted(tmp_path, capsys):
    assert main(["run", "sprag-slip", "--t-end", "0", "--plot", str(tmp_path / "run.png")]) == 0
    assert "nan" not in capsys.readouterr().out


def test_a_state_beyond_all_bounds_ends_as_a_failed_run(capsys):
    assert main(["run", "sprag-slip", "--state", "th=1e300", "--json", "--no-plot"]) == 3
    printed = capsys.readouterr()
    assert json.loads(printed.out)["status"] == "NOT_FINITE" and "wrote inf" in printed.err


def test_a_run_that_fails_is_saved_and_ends_with_code_3(tmp_path, capsys):
    out = tmp_path / "part.npz"
    arguments = ["run", "self-locking-rod", "--set", "th0=0.9", "mu=1", "--state", "th=0.9", "--out", str(out), *QUICK]
    assert main(arguments) == 3
    assert "no solution" in capsys.readouterr().out
    assert ns.Solution.load(out).status == ns.Status.NO_SOLUTION


def test_state_typed_as_negative_arithmetic(capsys):
    assert main(["run", "bouncing-ball", "--q0", "2", "--u0", "-pi/4", "--json", *QUICK]) == 0
    result = json.loads(capsys.readouterr().out)
    assert np.isclose(result["u"][0], -math.pi / 4 - 9.81 * 0.01, atol=1e-12)


@pytest.mark.parametrize(
    ("text", "value"),
    [("1e-3", 1e-3), ("-2*pi", -2 * math.pi), ("2**-1", 0.5), ("(1+2)/4", 0.75), (" -1e-3", -1e-3), ("inf", math.inf)],
)
def test_numbers_may_be_arithmetic(text, value):
    assert number(text) == value


@pytest.mark.parametrize(
    "text", ["", "x", "True", "1;2", "abs(1)", "(-1)**0.5", "1/0", "9**9**9", "(" * 300, "1 if 1 else 2"]
)
def test_what_is_no_number_is_refused(text):
    with pytest.raises(argparse.ArgumentTypeError, match="is no number"):
        number(text)


def test_json_has_events_with_names_and_no_nan(capsys):
    assert main(["run", "bouncing-ball", "--t-end", "1", "--json"]) == 0
    result = json.loads(capsys.readouterr().out, parse_constant=lambda name: pytest.fail(f"{name} is no JSON"))
    impact = result["events"][0]
    assert (impact["kind"], impact["mode_before"], impact["mode_after"]) == ("IMPACT", "OPEN", "LOCKED")
    assert set(result["ledger"]) >= {"kinetic", "force", "normal", "potential"}


def test_without_options_a_figure_is_drawn_beside_the_summary(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(["run", "bouncing-ball"]) == 0
    assert "figure: bouncing-ball.png" in capsys.readouterr().out
    assert [path.name for path in tmp_path.iterdir()] == ["bouncing-ball.png"]


def test_without_matplotlib_one_sentence_names_the_extra(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    assert main(["run", "bouncing-ball", "--t-end", "0.01"]) == 0
    assert 'pip install "nonsmooth[plot]"' in capsys.readouterr().err
    assert main(["run", "bouncing-ball", "--t-end", "0.01", "--plot", "run.png"]) == 2
    assert main(["run", "bouncing-ball", "--t-end", "0.01", "--no-plot", "--out", "run.h5"]) == 2
    assert 'pip install "nonsmooth[io]"' in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


def test_quiet_prints_nothing_and_records_at_the_times_asked_for(tmp_path, capsys):
    out = tmp_path / "run.npz"
    arguments = ["run", "bouncing-ball", "--t-end", "0.3", "--t-eval", "0.1", "0.3", "--quiet", "--no-plot"]
    assert main([*arguments, "--out", str(out)]) == 0
    assert capsys.readouterr() == ("", "")
    assert ns.Solution.load(out).t.tolist() == [0.1, 0.3]


def test_an_inconsistent_start_is_reported_in_one_line_and_projected_on_request(capsys):
    start = ["run", "bouncing-ball", "--q0", "-0.1", "--u0", "0", "--quiet", *QUICK]
    assert main(start) == 0
    warned = capsys.readouterr().err
    assert warned.startswith("nonsmooth: warning: ") and warned.count("\n") == 1
    assert main([*start, "--project"]) == 0
    assert capsys.readouterr().err == ""


def test_a_folder_and_a_place_that_takes_no_files_are_refused(tmp_path, capsys):
    (tmp_path / "run.npz").mkdir()
    assert main(["run", "bouncing-ball", "--out", str(tmp_path / "run.npz")]) == 2
    assert "it is a folder" in capsys.readouterr().err
    assert main(["run", "bouncing-ball", "--out", str(tmp_path / ("x" * 300 + ".npz"))]) == 2
    assert "cannot be written" in capsys.readouterr().err


def test_a_failed_run_says_why_on_stderr(capsys):
    assert main(["run", "self-locking-rod", "--set", "th0=0.9", "mu=1", "--state", "th=0.9", "--json", *QUICK]) == 3
    printed = capsys.readouterr()
    assert json.loads(printed.out)["status"] == "NO_SOLUTION"
    assert "no solution" in printed.err


def test_a_closed_pipe_is_no_error():
    code = "from nonsmooth.commands.cli import main; raise SystemExit(main(['list']))"
    reader, writer = os.pipe()
    os.close(reader)
    ended = in_python(code, stdout=writer, stderr=PIPE)
    os.close(writer)
    assert (ended.returncode, ended.stderr) == (0, "")


def test_ctrl_c_saves_what_was_computed_and_progress_shows_on_a_terminal(tmp_path):
    out = tmp_path / "part.npz"
    arguments = ["run", "bouncing-ball", "--t-end", "1e6", "--every", "1000000", "--no-plot", "--out", str(out)]
    code = f"from nonsmooth.commands.cli import main; raise SystemExit(main({arguments}))"
    leader, terminal = pty.openpty()
    run = subprocess.Popen([sys.executable, "-c", code], stdin=DEVNULL, stdout=PIPE, stderr=terminal, text=True)
    os.close(terminal)
    try:
        shown = read_until(leader, b"%", PATIENCE)
        run.send_signal(signal.SIGINT)
        printed, _ = run.communicate(timeout=PATIENCE)
    finally:
        run.kill()
        run.wait()
        os.close(leader)
    assert run.returncode == 130, shown
    assert "interrupted at t = " in printed
    solution = ns.Solution.load(out)
    assert solution.status == ns.Status.INTERRUPTED and 0 < solution.t[-1] < 1e6


def test_solve_prints_a_table_and_tells_failure_by_its_code(tmp_path, capsys):
    np.savez(tmp_path / "small.npz", M=np.array([[2.0, 1.0], [1.0, 2.0]]), q=np.array([-1.0, -1.0]))
    assert (
        main(["solve", str(tmp_path / "small.npz"), "--solver", "auto,lemke", "--plot", str(tmp_path / "p.png")]) == 0
    )
    assert capsys.readouterr().out.count("1 of 1 solved") == 2
    assert (tmp_path / "p.png").exists()
    assert main(["solve", str(tmp_path / "missing.npz")]) == 2


def test_solve_and_list_print_one_json_object_or_nothing(tmp_path, capsys):
    np.savez(tmp_path / "small.npz", M=np.array([[2.0, 1.0], [1.0, 2.0]]), q=np.array([-1.0, -1.0]))
    words = [str(tmp_path / "small.npz"), str(tmp_path / "missing.npz")]
    assert main(["solve", *words, "--json"]) == 3
    solved, missing = json.loads(capsys.readouterr().out)["problems"]
    assert (solved["status"], solved["n"], missing["status"]) == ("SOLVED", 2, "ERROR") and missing["message"]
    assert main(["list", "--json"]) == 0
    found = {model["name"]: model for model in json.loads(capsys.readouterr().out)["models"]}
    assert found["painleve-rod"]["parameters"]["mu"] > 0 and "th" in found["painleve-rod"]["state"]
    assert found["box-stack"]["is"] == "scene"
    assert main(["solve", words[0], "--quiet"]) == main(["list", "--quiet"]) == 0
    assert capsys.readouterr().out == ""


@pytest.mark.parametrize(
    ("options", "ending"),
    [(["event-driven", "--rtol", "1e-6"], "EventDriven(rtol=1e-06"), (["penalty", "--stiffness", "1e6"], "Penalty(")],
)
def test_other_integrators_run_from_the_command_line(options, ending, capsys):
    assert main(["run", "bouncing-ball", "--t-end", "0.5", "--json", "--integrator", *options]) == 0
    result = json.loads(capsys.readouterr().out)
    assert result["status"] == "FINISHED" and result["about"]["integrator"].startswith(ending)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["penalty"], "--integrator penalty needs --stiffness"),
        (["event-driven", "--dt", "1e-3"], "--dt is no option of --integrator event-driven"),
        (["event-driven", "--rtol", "0"], "rtol must lie in"),
        (["moreau-jean", "--damping-ratio", "0.1"], "--damping-ratio is no option of --integrator moreau-jean"),
    ],
)
def test_options_of_another_integrator_are_refused(options, words, capsys):
    assert main(["run", "bouncing-ball", "--no-plot", "--integrator", *options]) == 2
    assert words in capsys.readouterr().err
