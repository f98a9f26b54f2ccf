"""Command lines nobody would type, made from the parser's own options: each ends with a code of ours and in our words.

The words of an option are those it wants, and odd ones: those of other options, empty, endless, not finite, no numbers,
folders, devices, other alphabets. A process that has the program loaded forks for each line, so that one that dies or
hangs takes nothing with it; what still runs after `PATIENCE` gets Ctrl-C and has to end then.
"""

from __future__ import annotations

import argparse
import json
import os
import random
import re
import signal
import sys
import time
from pathlib import Path
from typing import NamedTuple

import nonsmooth.__main__
import nonsmooth.commands.cli

PATIENCE = 1.0  # s before Ctrl-C
GRACE = 10.0  # s after it, before SIGKILL: a line that hangs
CODES = (0, 2, 3, 4, 130)
OURS = re.compile(r"nonsmooth\b.*: |\{|$")  # a line on stderr; JSON of `--progress json`
HELP = {"-h", "--help"}
USUAL = 0.8  # part of the words that an option wants
MODELS = ("bouncing-ball", "painleve-rod", "sprag-slip", "belt-oscillator", "follower-force-arm", "woodpecker")
NUMBERS = ("0.01", "1", "1e-3", "pi/4", "2", "0.5", "100", "1e4")
ODD = (
    "", " ", "-", "--", "=", "x=", "=1", "a=b", "mu=mu", "nan", "inf", "-inf", "1e400", "10**400", "-1", "0", "-0.0",
    "1e-320", "pi/0", "1,2", "1:2", "1:2:3", "mu=1:2:3:log:m:s", "mu=::", "mu=0:1:1e9", "mu=,", "mu=nan", "th=1:1:1",
    "(" * 300, "9" * 5000, "1+" * 3000 + "1", "0x10", "1_0", "True", "None", "lambda: 0", "[]", "__import__('os')",
    "é", "模型", "\udcff", "a\nb", "%s", "{}", "*", "/", ".", "..", "/dev/null", "/dev/full", "/proc/self/mem",
    "no/folder/x.npz", "x.npz", "x.png", "x.nc", "x" * 300 + ".png", "folder.npz", "text.npz", "text.hdf5", "text.csv",
    "bouncing-bal", "core", "stability",
)  # fmt: skip
WANTED = {
    "set": ("mu=2", "e=0.5", "m=1e3", "g=0", "mu=-1", "m=0", "l=nan", "k=1e300", "mu"),
    "state": ("th=pi/4", "thdot=0", "slip=-1", "height=1", "velocity=1e200", "x=inf", "q=1"),
    "axis": ("mu=0:2:3", "th=0.1:1.5:3:log:rad", "slip=1,-1", "mu=1", "vb=0.1:0.3:3", "mu=2:1", "m=1e-3:1e3:2:log"),
    "measure": ("final_state", "amplitude", "period", "modes", "paradoxes", "impacts", "residual", "end_time"),
    "solver": ("auto", "lemke", "nsgs", "auto,lemke", ","),
    "files": ("text.npz", "problem.npz", "folder.npz", "x.npz"),
    "integrator": ("moreau-jean", "event-driven", "penalty", "adaptive", "auto"),
    "out": ("x.npz", "x.nc", "x.h5", "x.txt"),
    "plot": ("x.png", "x.pdf", "x.svg", "x.txt"),
    "t_end": ("0.01", "0.1", "1", "1e-9", "1e9"),
    "dt": ("1e-2", "1e-3", "1e-5", "1"),
    "t": ("0", "1"),
    "workers": ("1", "2", "0"),
}  # fmt: skip


class Ended(NamedTuple):
    """How a command line ended."""

    words: list[str]
    code: int  # negative: by a signal
    stdout: str
    stderr: str
    after_ctrl_c: float  # s; NaN where it ended by itself

    def fault(self) -> str:
        """What is not ours about it; empty where nothing is."""
        foreign = [line for line in self.stderr.replace("\r", "\n").split("\n") if not OURS.match(line)]
        if self.code not in CODES:
            return f"code {self.code}"
        if foreign:
            return f"a line that is not ours: {foreign[0][:200]!r}"
        if "--json" in self.words and self.code == 0 and not (is_json(self.stdout) or HELP & set(self.words)):
            return "no JSON on stdout"
        return "" if self.code == 0 or self.stderr or self.stdout else "not a word"


def is_json(text: str) -> bool:
    """Whether a text is one JSON object on a line."""
    try:
        return text.count("\n") == 1 and isinstance(json.loads(text), dict)
    except ValueError:
        return False


def leaves(parser: argparse.ArgumentParser, name: tuple[str, ...] = ()) -> dict[tuple[str, ...], list[argparse.Action]]:
    """The options of each command, by the words that call it."""
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            return {
                key: found for word, sub in action.choices.items() for key, found in leaves(sub, (*name, word)).items()
            }
    return {name: parser._actions}


def command_line(chance: random.Random, commands: dict[tuple[str, ...], list[argparse.Action]]) -> list[str]:
    """One line: a command, its positional words, some of its options; now and then a word is lost or one too many."""
    name = chance.choice(sorted(commands))
    words = list(name)
    options = [action for action in commands[name] if action.option_strings]
    for action in commands[name]:
        if not action.option_strings or action.required:
            words += typed(chance, action)
    for action in chance.sample(options, min(len(options), chance.choice((0, 0, 1, 1, 2, 3, 6)))):
        words += typed(chance, action)
    if chance.random() < 0.05:
        words.pop(chance.randrange(len(words)))
    if chance.random() < 0.05:
        words.insert(chance.randrange(len(words) + 1), chance.choice(ODD))
    return words


def typed(chance: random.Random, action: argparse.Action) -> list[str]:
    """An option with its words."""
    words = [chance.choice(action.option_strings)] if action.option_strings else []
    if action.nargs == 0:
        return words
    many = chance.choice((1, 1, 2, 3)) if action.nargs in ("+", "*") else 1
    return words + [word_for(chance, action) for _ in range(many)]


def word_for(chance: random.Random, action: argparse.Action) -> str:
    """A word that an option wants, mostly."""
    if chance.random() > USUAL:
        return chance.choice(ODD)
    if action.choices:
        return chance.choice(sorted(map(str, action.choices)))
    if action.dest == "model":
        return chance.choice(MODELS)
    name = action.dest.removesuffix("es") if action.dest == "axes" else action.dest
    wanted = WANTED.get("axis" if name == "ax" else name) or (WANTED["plot"] if action.type is Path else NUMBERS)
    return chance.choice(wanted)


def run(words: list[str], folder: Path) -> Ended:
    """The line in a process of its own."""
    outputs = [folder.parent / name for name in ("stdout", "stderr")]
    began = time.perf_counter()
    child = os.fork()
    if child == 0:
        alone(words, folder, outputs)
    code, ctrl_c = None, float("nan")
    while code is None:
        time.sleep(0.005)
        done, status = os.waitpid(child, os.WNOHANG)
        code = os.waitstatus_to_exitcode(status) if done else None
        elapsed = time.perf_counter() - began
        if code is None and ctrl_c != ctrl_c and elapsed > PATIENCE:
            ctrl_c = elapsed
            os.kill(child, signal.SIGINT)
        elif code is None and elapsed > PATIENCE + GRACE:
            os.kill(child, signal.SIGKILL)
    ended = time.perf_counter() - began
    texts = [path.read_text("utf-8", errors="replace") for path in outputs]
    return Ended(words, code, *texts, ended - ctrl_c)


def alone(words: list[str], folder: Path, outputs: list[Path]) -> None:
    """What the child does, as the program does it."""
    os.setsid()
    for number, path in enumerate(outputs, 1):
        os.dup2(os.open(path, os.O_WRONLY | os.O_CREAT | os.O_TRUNC), number)
    os.chdir(folder)
    signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        sys.argv = ["nonsmooth", *words]
        nonsmooth.__main__.nonsmooth()
    except SystemExit as end:
        sys.stdout.flush()
        os._exit(end.code if isinstance(end.code, int) else 1)
    except BaseException:
        import traceback

        traceback.print_exc()
        sys.stderr.flush()
    os._exit(1)


def prepare(folder: Path) -> None:
    """Files that are not what their endings say."""
    folder.mkdir()
    (folder / "folder.npz").mkdir()
    for name in ("text.npz", "text.hdf5", "text.csv"):
        (folder / name).write_text("not what it says\n")


def main(seed: int, n: int, place: str) -> None:
    """Run n lines; one JSON object a line for each that is foreign, and one at the end."""
    folder = Path(place, "here")
    prepare(folder)
    for module in (
        "matplotlib.figure",
        "xarray",
        "nonsmooth.sweeps.sweep",
        "nonsmooth.commands.run",
        "nonsmooth.runs.simulate",
    ):
        __import__(module)
    chance, commands = random.Random(seed), leaves(nonsmooth.commands.cli.build_parser())
    slowest, codes = 0.0, dict.fromkeys(CODES, 0)
    for _ in range(n):
        ended = run(command_line(chance, commands), folder)
        fault = ended.fault()
        codes[ended.code] = codes.get(ended.code, 0) + 1
        slowest = max(slowest, 0.0 if ended.after_ctrl_c != ended.after_ctrl_c else ended.after_ctrl_c)
        if fault:
            print(
                json.dumps({"words": [w[:60] for w in ended.words], "fault": fault, "stderr": ended.stderr[-2000:]}),
                flush=True,
            )
    print(json.dumps({"codes": codes, "after_ctrl_c": slowest}), flush=True)


if __name__ == "__main__":
    main(int(sys.argv[1]), int(sys.argv[2]), sys.argv[3])
