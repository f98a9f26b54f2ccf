"""Files of the working folder are run by no process that a program or a command starts, whatever they are called."""

import os
import subprocess
import sys
import time

import pytest

pytestmark = pytest.mark.upkeep

# Modules that such processes import first: of the package, of what it needs, and of the standard library.
NAMES = (
    "nonsmooth models numpy numba llvmlite scipy json socket pickle copyreg tempfile hashlib ctypes subprocess "
    "multiprocessing threading signal functools contextlib"
).split()

COMPILES = """
import os
from pathlib import Path
from nonsmooth.contact.blocks.interior import direction, longest_step
from nonsmooth.jit.loading import start_process
process = start_process((), [direction, longest_step])
assert process.wait(240) == 0, process.returncode
assert direction.is_on_disk and longest_step.is_on_disk  # it was another process that compiled
"""
SWEEPS = """
import os
import sys
import nonsmooth as ns

def options(x):
    return {"y": x, "is_safe": float(sys.flags.safe_path), "is_told": float("PYTHONSAFEPATH" in os.environ)}

if __name__ == "__main__":
    found = ns.sweep(options, {"x": [1.0, 2.0, 3.0]}, workers=2, progress=False)
    assert found.y.values.tolist() == [1.0, 2.0, 3.0]
    assert found.is_safe.values.tolist() == [1.0, 1.0, 1.0]
    assert found.is_told.values.tolist() == 3 * [float("PYTHONSAFEPATH" in os.environ)]  # what they start is as ever
"""


@pytest.fixture
def traps(tmp_path):
    """A folder with files of these names, each of which leaves a mark when it is run."""
    folder = tmp_path / "downloads"
    folder.mkdir()
    for name in NAMES:
        (folder / f"{name}.py").write_text(f"open({str(tmp_path / 'marks')!r}, 'a').write('{name} ')\n")
    yield folder
    marks = tmp_path / "marks"
    assert not marks.exists(), f"run: {marks.read_text()}"


def run_in(folder, command):
    environment = {**os.environ, "NONSMOOTH_CACHE_DIR": str(folder.parent / "cache")}
    done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, timeout=280)
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize("text", [COMPILES, SWEEPS], ids=["compiling", "workers of a sweep"])
def test_processes_of_a_program_run_nothing_of_the_working_folder(traps, tmp_path, text):
    script = tmp_path / "elsewhere" / "program.py"
    script.parent.mkdir()
    script.write_text(text)
    run_in(traps, [sys.executable, str(script)])


COMMAND = "import sys; from nonsmooth.commands.cli import main; sys.exit(main(sys.argv[1:]))"


def test_a_first_command_runs_nothing_of_the_working_folder(traps, tmp_path):
    options = ("bouncing-ball", "--no-plot", "--quiet", "--t-end", "0.01")
    run_in(traps, [sys.executable, "-P", "-c", COMMAND, "run", *options])
    until = time.monotonic() + 120.0
    while not any((tmp_path / "cache").glob("*.code")):  # the command has ended, what it began goes on
        assert time.monotonic() < until
        time.sleep(0.1)


def test_a_trap_leaves_its_mark(traps, tmp_path):
    """What the others would see: Python itself, started with a command, searches the working folder."""
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONSAFEPATH"}
    subprocess.run([sys.executable, "-c", "import json"], cwd=traps, env=environment, timeout=60, check=True)
    assert (tmp_path / "marks").read_text() == "json "
    (tmp_path / "marks").unlink()
