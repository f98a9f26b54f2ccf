"""Words that were mistyped are answered by the nearest right one; shells complete the rest."""

import json
import os
import pty
import select
import shutil
import subprocess
import time

import numpy as np
import pytest

from nonsmooth.commands.cli import main
from nonsmooth.commands.completion import SHELLS
from nonsmooth.commands.terminal import as_typed
from nonsmooth.errors import closest


@pytest.mark.parametrize(("words", "meant"), [
    ("run bouncing-ball --t-ennd 1", "--t-end"),
    ("run bouncing-ball --quite", "--quiet"),
    ("sweep bouncing-ball --axis e=0:1:2 --worker-s 2", "--workers"),
    ("study penalty bouncing-ball --stifness 1e6", "--stiffness"),
    ("map painleve-rod --axes mu=0:1", "--axis"),
    ("rn bouncing-ball", "run"),
    ("clasify painleve-rod", "classify"),
    ("stability belt-oscillator", "study stability"),
    ("study penalti bouncing-ball", "penalty"),
    ("run bouncing-ball --integrator eventdriven", "event-driven"),
    ("run bouncing-ball --integrator evnt", "event-driven"),
    ("run woodpeker", "woodpecker"),
    ("run bouncing-ball --progress jsn", "json"),
    ("run bouncing-bal", "bouncing-ball"),
    ("run box-stak", "box-stack"),
    ("run painleve-rod --set muu=2", "mu"),
    ("run bouncing-ball --state heigt=1", "height"),
    ("sweep bouncing-ball --axis ee=0:1:2 --t-end 0.1", "e"),
    ("sweep bouncing-ball --axis e=0:1:2 --measure amplitud", "amplitude"),
    ("run bouncing-ball --selection liftof", "lift-off"),
    ("completion bsh", "bash"),
])  # fmt: skip
def test_a_mistyped_word_is_answered_by_the_nearest_one(words, meant, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    try:
        assert main(words.split()) == 2
    except SystemExit as ended:
        assert ended.code == 2
    said = capsys.readouterr().err
    assert f"did you mean {meant!r}?" in said and said.count("\n") == 1


@pytest.mark.parametrize(("words", "have"), [
    ("run bouncing-ball --workers 2", "map, study bifurcation, study penalty, study convergence, sweep have it"),
    ("classify painleve-rod --axis mu=0:1:3", "map, study stability, study cycle, study bifurcation, sweep have it"),
    ("classify painleve-rod --resume file", "run, scene, map, study penalty, study convergence, sweep have it"),
    ("run bouncing-ball --measure=impacts", "sweep has it"),
])  # fmt: skip
def test_a_word_of_other_commands_is_answered_by_their_names(words, have, capsys):
    command, _, word, *_ = words.replace("=", " ").split()
    with pytest.raises(SystemExit) as ended:
        main(words.split())
    assert ended.value.code == 2
    said = f"nonsmooth {command}: there is no {word} here; {have}; see nonsmooth {command} --help\n"
    assert capsys.readouterr().err == said


def test_an_array_that_is_taken_for_a_number_is_answered_by_its_entries(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    source = OWN_MODEL.replace("m: float = 1.0", "m: tuple = None")
    source = source.replace("p.m\n", "p.m[1]\n").replace("parameters=P()", "parameters=P(np.array([1.0, 2.0]))")
    (tmp_path / "two_masses.py").write_text("import numpy as np\n" + source)
    words = "sweep two_masses.py:ball --axis m=1:2:2 --t-end 0.1 --dt 1e-2 --state y=1".split()
    assert main(words) == 2
    assert "there is no axis 'm'; did you mean 'm[0]' or 'm[1]'?" in capsys.readouterr().err


@pytest.mark.parametrize(("words", "shown"), [
    (["sprag-slip"], ["sprag-slip"]),
    (["two.py"], ["two.py:ball", "two.py:other"]),
    (["two.py:other", "box-stack"], ["two.py:other", "box-stack"]),
])  # fmt: skip
def test_list_shows_what_it_is_asked_for(words, shown, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "two.py").write_text(OWN_MODEL + "other = ball.with_parameters(m=2.0)\n")
    assert main(["list", "--json", *words]) == 0
    assert [model["name"] for model in json.loads(capsys.readouterr().out)["models"]] == shown
    assert main(["list", "sprag-slp"]) == 2
    assert "did you mean 'sprag-slip'?" in capsys.readouterr().err


def test_what_is_near_nothing_lists_what_there_is(capsys):
    with pytest.raises(SystemExit):
        main(["qqqqqq"])
    assert "there is no COMMAND 'qqqqqq'; known: list, new, run, scene" in capsys.readouterr().err


@pytest.mark.parametrize("shell", SHELLS)
def test_a_script_for_each_shell_knows_options_and_models(shell, capsys):
    pytest.importorskip("shtab")
    assert main(["completion", shell]) == 0
    script = capsys.readouterr().out
    assert "t-end" in script and "sprag-slip" in script and "bifurcation" in script


@pytest.mark.parametrize(("line", "expected"), [
    (["nonsmooth", "cla"], ["classify"]),
    (["nonsmooth", "run", "sprag"], ["sprag-slip"]),
    (["nonsmooth", "run", "box-stack", "--chec"], ["--checkpoint", "--checkpoint-every"]),
    (["nonsmooth", "study", "bif"], ["bifurcation"]),
])  # fmt: skip
def test_bash_completes_commands_models_and_options(line, expected, tmp_path, capsys):
    pytest.importorskip("shtab")
    bash = shutil.which("bash")
    if bash is None:
        pytest.skip("bash is not installed")
    assert main(["completion", "bash"]) == 0
    (tmp_path / "completion.sh").write_text(capsys.readouterr().out)
    words = " ".join(f"'{word}'" for word in line)
    ask = (
        "source completion.sh; f=$(complete -p nonsmooth | sed 's/.*-F \\([^ ]*\\).*/\\1/'); "
        f"COMP_WORDS=({words}); COMP_CWORD={len(line) - 1}; COMP_LINE='{' '.join(line)}'; COMP_POINT=${{#COMP_LINE}}; "
        f"$f nonsmooth '{line[-1]}' '{line[-2]}'; printf '%s\\n' \"${{COMPREPLY[@]}}\""
    )
    ended = subprocess.run([bash, "-c", ask], cwd=tmp_path, capture_output=True, text=True, timeout=60)
    assert sorted({word.strip() for word in ended.stdout.split()}) == expected


INTERACTIVE = {  # how a shell is begun, and what it needs before its completions
    "bash": (["bash", "--norc", "-i"], ""),
    "zsh": (["zsh", "-f", "-i"], "autoload -Uz compinit; compinit -u -D; "),
}


def shown_in_terminal(words, setup, typed, until, cwd):
    """What a shell shows in a terminal of its own after these keys, until a text is there or half a minute is over."""
    process, terminal = pty.fork()
    if process == 0:  # the shell
        os.chdir(cwd)
        os.execvpe(words[0], words, {**os.environ, "TERM": "dumb", "PS1": "> ", "HISTFILE": "/dev/null"})

    def read(text):
        seen, end = "", time.monotonic() + 30
        while text not in seen and time.monotonic() < end:
            if select.select([terminal], [], [], 0.1)[0]:
                seen += os.read(terminal, 65536).decode(errors="replace")
        return seen

    try:
        os.write(terminal, f"{setup}; echo rea''dy\n".encode())
        read("\nready")
        os.write(terminal, typed.encode())
        return read(until)
    finally:
        os.close(terminal)  # ends the shell
        os.waitpid(process, 0)


@pytest.mark.parametrize(("typed", "until"), [
    ("nonsmooth cla\t", "classify "),
    ("nonsmooth run sprag\t", "sprag-slip "),
    ("nonsmooth study bif\t", "bifurcation "),
    ("nonsmooth map painleve-rod --no-p\t", "--no-plot "),
])  # fmt: skip
@pytest.mark.parametrize("shell", SHELLS)
def test_a_press_of_tab_in_a_shell_completes_the_word(shell, typed, until, tmp_path, capsys):
    pytest.importorskip("shtab")
    if shutil.which(shell) is None:
        pytest.skip(f"{shell} is not installed")
    assert main(["completion", shell]) == 0
    (tmp_path / "completions").write_text(capsys.readouterr().out)
    words, before = INTERACTIVE[shell]
    assert until in shown_in_terminal(words, f'{before}eval "$(cat completions)"', typed, until, tmp_path)


@pytest.mark.parametrize(("said", "typed"), [
    ("it penetrates. project=True moves it.", "it penetrates. --project moves it."),
    ("give duration= and dt=", "give --duration and --dt"),
    ("integrator=ns.MoreauJean(dt) takes it", "--integrator moreau-jean takes it"),
    ("or settle_by=, until which", "or --settle-by, until which"),
    ("give state=dict(th=0.8, thdot=-1)", "give --state th=0.8 thdot=-1"),
    ("selection='lift-off' or dt=1e-3", "--selection 'lift-off' or --dt 1e-3"),
    ("sliding= and integrator.dt=1 are left, and e = 0.5", "sliding= and integrator.dt=1 are left, and e = 0.5"),
    ("give state=(q0, u0) or dict(x=..., th=...)", "give --state x=... th=..."),
    ('give state=(q0, u0) or {"q[0]": ...}', "give --state q[0]=..."),
])  # fmt: skip
def test_keywords_of_the_library_are_said_as_options(said, typed):
    words = ("--project", "--duration", "--dt", "--settle-by", "--state", "--selection", "--integrator")
    options = {word.strip("-").replace("-", "_"): word for word in words}
    assert as_typed(said, options) == typed


OWN_MODEL = """
from typing import NamedTuple
import nonsmooth as ns

class P(NamedTuple):
    m: float = 1.0

def mass(t, q, p, M):
    M[0, 0] = p.m

def force(t, q, u, p, h):
    h[0] = -9.81 * p.m

def gap(t, q, p, g_N):
    g_N[0] = q[0]

ball = ns.System(
    coordinates=[("y", "m")], mass=mass, force=force, gap=gap, contacts=[ns.Contact(e_N=0.5)], parameters=P()
)
"""


@pytest.fixture
def my_model(tmp_path, monkeypatch):
    """A user's model, in a folder below the one where commands are typed; its path."""
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "falling.py").write_text(OWN_MODEL)
    monkeypatch.chdir(tmp_path)
    return "mine/falling.py:ball"


@pytest.mark.parametrize(("words", "advice"), [
    ("run MODEL --state y=-0.1 --t-end 0.01 --dt 1e-3 --no-plot", "--project moves it"),
    ("study bifurcation MODEL --axis m=1:2:2 --state y=1", "give --duration and --dt"),
    ("study cycle MODEL --state y=1", "give --duration"),
    ("sweep MODEL --axis m=1:2:2 --state y=1 --measure amplitude --t-end 1 --dt 1e-2", "or --settle-by, until"),
])  # fmt: skip
def test_a_message_advises_what_can_be_typed(words, advice, my_model, capsys):
    main(words.replace("MODEL", my_model).split())
    said = capsys.readouterr().err
    assert advice in said and "=, " not in said and "=True" not in said


@pytest.mark.upkeep
def test_files_are_named_after_the_model_and_lie_where_the_command_is_typed(my_model, tmp_path):
    for words in (
        "run MODEL --state y=1 --t-end 0.1 --dt 1e-3",
        "map MODEL --state y=0 --axis m=1:2:3 ydot=-1:1:3",
        "study convergence MODEL --state y=1 --t-end 0.1",
        "study penalty MODEL --state y=0.1 --t-end 0.2 --stiffness 1e4 1e5",
        "study bifurcation MODEL --axis m=1:2:2 --state y=1 --duration 0.5 --dt 1e-2",
    ):
        assert main([*words.replace("MODEL", my_model).split(), "--quiet"]) == 0
    made = {path.name for path in tmp_path.iterdir()} - {"mine"}
    assert made == {"ball.png", "ball-map.nc", "ball-map.png", "ball-convergence.png", "ball-penalty.png",
                    "ball-bifurcation.png"}  # fmt: skip
    assert [path.name for path in (tmp_path / "mine").glob("*.png")] == []


def test_what_is_no_model_of_a_file_is_answered_by_its_models(my_model, capsys):
    assert main(["run", f"{my_model.partition(':')[0]}:P"]) == 2
    assert "P is no model: " in (said := capsys.readouterr().err) and "falling.py has the models ball" in said


def test_the_start_and_the_period_of_a_cycle_are_typed(tmp_path, monkeypatch, capsys):
    """The same cycle from another start, and along a parameter."""
    monkeypatch.chdir(tmp_path)
    belt = ["study", "cycle", "belt-oscillator", "--set", "vb=0.2", "--json"]
    periods = []
    for more in ([], ["--state", "x=0.05", "velocity=0.1", "--duration", "30"], ["--dt", "1e-3"]):
        assert main([*belt, *more]) == 0
        periods.append(json.loads(capsys.readouterr().out)["cycle"]["period"])
    np.testing.assert_allclose(periods, periods[0], rtol=1e-8)
    assert main([*belt, "--state", "x=0.05", "--axis", "k=10:11:2"]) == 0
    assert json.loads(capsys.readouterr().out)["branch"]["period"][0] == pytest.approx(periods[0], rel=1e-8)
    assert main([*belt, "--forcing", "-1"]) == 2
    assert "forcing must be positive" in capsys.readouterr().err


def test_a_class_that_cannot_be_made_hides_no_other_model_of_its_file(my_model, capsys):
    path, needs_k = my_model.partition(":")[0], "\nclass Rod:\n    def __init__(self, k):\n        self.k = k\n"
    with open(path, "a") as file:
        file.write(needs_k + "\n    def system(self):\n        return ball\n")
    assert main(["list", path]) == 0
    printed = capsys.readouterr()
    assert "falling.py:ball" in printed.out and printed.out.count("--state") == 1
    assert "falling.py:Rod: Rod cannot be made without arguments" in printed.err and printed.err.count("\n") == 1


def test_files_of_one_name_in_different_folders_are_told_apart(tmp_path, capsys):
    """As three users' models.py in one process: each is run as it is."""
    for k in range(3):
        (tmp_path / str(k)).mkdir()
        (tmp_path / str(k) / "samename.py").write_text(OWN_MODEL.replace("ball =", f"ball_{k} ="))
    assert main(["list", *(str(tmp_path / str(k) / "samename.py") for k in (0, 1, 2, 1))]) == 0
    listed = [line.split()[0].rpartition(":")[2] for line in capsys.readouterr().out.splitlines() if "samename" in line]
    assert listed == ["ball_0", "ball_1", "ball_2", "ball_1"]


@pytest.mark.parametrize(("typed", "meant"), [
    ("theta", "th"), ("Theta", "th"), ("theta_dot", "thdot"), ("thetadot", "thdot"), ("thetd", "th"), ("omega", "om"),
])  # fmt: skip
def test_a_whole_word_is_answered_by_the_name_that_is_short_for_it(typed, meant):
    assert closest(typed, ["om", "omdot", "q0", "th", "thdot", "u0"]) == meant


def test_a_short_name_does_not_answer_a_misspelt_longer_one():
    assert closest("velocty", ["ve", "velocity"]) == "velocity" and closest("mass", ["m", "k"]) == ""
