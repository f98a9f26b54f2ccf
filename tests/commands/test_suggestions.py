"""Words that were mistyped are answered by the nearest right one; shells complete the rest."""

import os
import pty
import select
import shutil
import subprocess
import time

import pytest

from nonsmooth.commands.cli import main
from nonsmooth.commands.completion import SHELLS


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


def test_what_is_near_nothing_lists_what_there_is(capsys):
    with pytest.raises(SystemExit):
        main(["qqqqqq"])
    assert "there is no COMMAND 'qqqqqq'; known: list, run, scene" in capsys.readouterr().err


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
