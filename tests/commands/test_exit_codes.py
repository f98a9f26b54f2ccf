"""Every exit code and every line on stderr that docs/command_line.md names."""

import math
import re
import sys
import time
from pathlib import Path

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.commands.cli import main
from nonsmooth.jit.cache import words_of
from nonsmooth.jit.waiting import waiting
from nonsmooth.sweeps.progress import Pace, say_estimate

PAGE = Path(__file__).parents[2] / "docs" / "command_line.md"
SHORT = ["--t-end", "0.01", "--no-plot"]


def code_of(arguments):
    """The exit code, also where the parser ends the process."""
    try:
        return main(arguments)
    except SystemExit as stop:
        return stop.code


def lines_of_the_page():
    """The kinds of lines on stderr, by their names in the page."""
    return dict(re.findall(r"^\| `(\w[^`]*)` \| `([^`]*)` \|", PAGE.read_text(), re.M))


def codes_of_the_page():
    return {int(code) for code in re.findall(r"^\| (\d+) \|", PAGE.read_text(), re.M)}


ROWS = [  # arguments, exit code, the kind of line it says on stderr
    (["run", "bouncing-ball", *SHORT], 0, None),
    (["list"], 0, None),
    (["run", "bouncing-ball", "--step", "1"], 2, "usage"),
    (["run", "bouncing-bal"], 2, "refusal"),
    (["run", "bouncing-ball", "--set", "e=nan", *SHORT], 2, "refusal"),
    (["run", "bouncing-ball", "--set", "m=-1", *SHORT], 2, "refusal"),
    (["run", "bouncing-ball", "--set", "e=1e300", *SHORT], 2, "refusal"),
    (["run", "bouncing-ball", "--dt", "5e-324", *SHORT], 2, "refusal"),
    (["run", "bouncing-ball", "--dt", "inf", *SHORT], 2, "refusal"),
    (["run", "bouncing-ball", "--t-end", "nan", "--no-plot"], 2, "refusal"),
    (["run", "bouncing-ball", "--dump-failure", "step.txt", *SHORT], 2, "refusal"),
    (["run", "bouncing-ball", "--dump-failure", "nowhere/step.npz", *SHORT], 2, "refusal"),
    (["run", "bouncing-ball", "--integrator", "event-driven", "--rtol", "0", *SHORT], 2, "refusal"),
    (["run", "bouncing-ball", "--integrator", "penalty", *SHORT], 2, "refusal"),
    (["run", "bouncing-ball", "--q0=-0.1", "--u0=0", *SHORT], 0, "warning"),
    (["classify", "painleve-rod", "--set", "mu=-1"], 2, "refusal"),
    (["classify", "painleve-rod", "--state", "th=nan"], 2, "refusal"),
    (["solve", "nowhere.npz", "--tol", "0"], 2, "refusal"),
    (["solve", "nowhere.npz", "--tol", "2"], 2, "refusal"),
    (["solve", "nowhere.npz"], 2, "refusal"),
    (["run", "self-locking-rod", "--set", "mu=1", "th0=0.9", "--state", "th=0.9", *SHORT], 3, "failure"),
    (["study", "equilibrium", "sprag-slip", "--set", "mu=nan"], 2, None),
    (["sweep", "bouncing-ball", "--axis", "e=0:1:x"], 2, "refusal"),
    (["sweep", "bouncing-ball", "--axis", "ee=0:1:3"], 2, "refusal"),
]


def said_by(capsys):
    """What was written to stderr, but for the word on compiling that the first run on a machine has."""
    lines = capsys.readouterr().err.splitlines()
    return "\n".join(line for line in lines if not re.fullmatch(lines_of_the_page()["compiling"], line))


@pytest.fixture(autouse=True)
def in_a_folder_of_its_own(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


@pytest.mark.parametrize(("arguments", "code", "kind"), ROWS)
def test_the_code_and_the_line_are_those_of_the_page(arguments, code, kind, capsys):
    assert code_of(arguments) == code
    said = said_by(capsys)
    assert code in codes_of_the_page() and "Traceback" not in said
    if kind is None:
        return
    assert re.fullmatch(lines_of_the_page()[kind], said), said
    assert list(Path.cwd().iterdir()) == [] or code != 2


def test_an_interruption_is_told_by_code_and_line(monkeypatch, capsys):
    monkeypatch.setattr("nonsmooth.catalogue.entries.model_entries", interrupt)
    assert main(["list"]) == 130
    assert re.fullmatch(lines_of_the_page()["interruption"], said_by(capsys))


def test_what_takes_long_says_so_before_it_has_taken_it(capsys):
    """A motion that is slower from its middle on: two seconds in it seems to end soon, ten seconds later it stands."""
    pace = Pace()
    assert math.isnan(pace.left(0.0, 0.0)) and pace.left(0.5, 2.0) == pytest.approx(2.0)
    assert [pace.left(0.5, t) for t in (5.0, 11.0, 17.0)][-1] == math.inf
    say_estimate("the study of the ball", 150.0, sys.stderr)
    assert re.fullmatch(lines_of_the_page()["estimate"], said_by(capsys))


@pytest.mark.parametrize("load", [0.0, 100.0])
def test_the_first_use_on_a_machine_says_that_it_compiles(load, monkeypatch, tmp_path, capsys):
    monkeypatch.setenv("NONSMOOTH_CACHE_DIR", str(tmp_path / "cache"))
    monkeypatch.setenv("NONSMOOTH_QUIET", "0")
    monkeypatch.setattr("nonsmooth.jit.waiting.SILENT_TIME", 0.01)
    monkeypatch.setattr("os.getloadavg", lambda: (load, 0.0, 0.0))
    with waiting(lambda: words_of(["solve", "loop"], 12.3, " of moreau_jean")):
        time.sleep(0.3)
    said = capsys.readouterr().err.rstrip("\n")
    assert re.fullmatch(lines_of_the_page()["compiling"], said)
    assert "2 functions of moreau_jean (first use on this machine), about " in said
    assert ("about 12 s; kept" in said) == (load == 0.0) and "12 s" in said


def interrupt(*_, **__):
    raise KeyboardInterrupt


def test_too_little_memory_is_told_in_one_line(monkeypatch, capsys):
    def grow(*_, **__):
        raise MemoryError

    monkeypatch.setattr("nonsmooth.catalogue.entries.model_entries", grow)
    assert main(["list"]) == 2
    assert re.fullmatch(lines_of_the_page()["memory"], said_by(capsys))


def test_a_failed_write_is_told_by_code_and_line(monkeypatch, capsys):
    def refuse(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("os.replace", refuse)
    assert main(["run", "bouncing-ball", "--out", "run.npz", "--quiet", *SHORT]) == 4
    said = said_by(capsys)
    assert re.fullmatch(lines_of_the_page()["write"], said) and "No space left" in said


def test_a_panel_of_what_did_not_happen_is_told_in_one_line(capsys):
    assert main(["run", "bouncing-ball", "--t-end", "0.01", "--plot", "run.png", "--panels", "impulses"]) == 0
    assert re.fullmatch(lines_of_the_page()["no panel"], said_by(capsys)) and not Path("run.png").exists()


def test_a_failure_without_a_contact_problem_is_told_in_one_line(capsys):
    """The speed doubles its exponent each step: the motion ends, but no contact problem does."""
    run = ["run", "bouncing-ball", "--q0", "1e300", "--u0", "1e308", "--set", "g=1e300", "--dt", "1", "--t-end", "1e9"]
    assert main([*run, "--no-plot", "--quiet", "--dump-failure", "step.npz", "--every", "1000"]) == 3
    first, second = said_by(capsys).splitlines()
    assert re.fullmatch(lines_of_the_page()["no problem"], first)
    assert re.fullmatch(lines_of_the_page()["failure"], second) and not Path("step.npz").exists()


def test_a_contact_problem_that_fclib_has_no_place_for_is_told_in_one_line(capsys):
    """Friction of a moving belt that turns negative, under a given normal force."""
    run = ["run", "belt-oscillator", "--set", "m1=1", "m3=0", "vb=5", "--dt", "1e-3", "--quiet", *SHORT]
    assert main([*run, "--dump-failure", "step.hdf5"]) == 3
    first, second = said_by(capsys).splitlines()
    assert re.fullmatch(lines_of_the_page()["no form"], first) and "a given normal force" in first
    assert re.fullmatch(lines_of_the_page()["failure"], second) and not Path("step.hdf5").exists()


def test_no_figure_where_none_can_be_written_is_told_in_one_line(tmp_path, capsys):
    (tmp_path / "bouncing-ball.png").mkdir()
    assert main(["run", "bouncing-ball", "--t-end", "0.01", "--quiet"]) == 0
    assert re.fullmatch(lines_of_the_page()["no figure"], said_by(capsys))


def test_the_address_of_a_live_view_is_told_in_one_line(capsys):
    pytest.importorskip("viser", reason='a live view needs viser: pip install "nonsmooth[live]"')
    from nonsmooth.drawing.live import window

    window.new_server()
    assert re.fullmatch(lines_of_the_page()["live"], said_by(capsys))


def test_the_page_names_no_code_and_no_line_that_is_not_tested():
    tested = {kind for _, _, kind in ROWS if kind} | {
        "interruption", "memory", "compiling", "write", "no problem", "no form", "no figure", "no panel",
            "estimate", "live",
    }  # fmt: skip
    assert set(lines_of_the_page()) == tested
    assert codes_of_the_page() == {code for _, code, _ in ROWS} | {4, 130}


def test_parameters_and_axes_never_run_code(tmp_path, capsys):
    """What a user types is numbers: anything else is refused, not evaluated."""
    bomb = "__import__('pathlib').Path('it-was-run').touch()"
    for arguments in (
        ["run", "bouncing-ball", "--set", f"e={bomb}"], ["run", "bouncing-ball", "--state", f"height={bomb}"],
        ["run", "bouncing-ball", "--dt", bomb], ["sweep", "bouncing-ball", "--axis", f"e={bomb}"],
        ["classify", "painleve-rod", "--set", f"mu={bomb}"], ["run", "bouncing-ball", "--t-eval", bomb],
        ["run", "bouncing-ball", "--set", "e=9**9**9**9"], ["run", "bouncing-ball", "--set", "e=(1).__class__"],
    ):  # fmt: skip
        assert code_of(arguments) == 2
        assert "is no number" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


def test_the_status_of_a_partial_run_is_in_the_file_that_it_saves(tmp_path, capsys):
    run = ["run", "self-locking-rod", "--set", "mu=1", "th0=0.9", "--state", "th=0.9", "--out", "run.npz", *SHORT]
    assert main(run) == 3
    saved = ns.Solution.load("run.npz")
    assert saved.status == ns.Status.NO_SOLUTION and np.isfinite(saved.q).all()
