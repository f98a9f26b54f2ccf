"""Functions that worker processes can import, and journals read line by line."""

from __future__ import annotations

import json
import sys
import uuid

import pytest

TASKS = '''
import os, signal, time
from pathlib import Path

def product(x, y):
    return x * y

def slow_product(x, y, seconds=0.02):
    time.sleep(seconds)
    return x * y

def poison(x, y):
    """Kills its own process at one cell."""
    if x == 2 and y == 30:
        os.kill(os.getpid(), signal.SIGKILL)
    return x * y

def dies_once(x, y, marker):
    """Kills its own process the first time that one cell is run."""
    if x == 2 and y == 30 and not Path(marker).exists():
        Path(marker).touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return x * y

def sleeper(x, y):
    if x == 1 and y == 20:
        time.sleep(60)
    return x * y

def picky(x, y):
    if x == 3:
        raise ValueError("x must not be 3")
    return x * y

def several(x):
    return {"square": x * x, "pair": [x, float("nan") if x == 2 else -x], "word": "even" if x % 2 == 0 else "odd"}

def uneven(x):
    return [0.0] * int(x)

def counted(x, y, folder, seconds=0.0):
    """Leaves a line in a file for each call."""
    with open(Path(folder) / "calls.txt", "a") as file:
        file.write(f"{x:g} {y:g}\\\\n")
    time.sleep(seconds)
    return x * y
'''


@pytest.fixture
def tasks(tmp_path, monkeypatch):
    """A module of tasks in a folder that worker processes import from too."""
    name = f"tasks_{uuid.uuid4().hex}"
    (tmp_path / f"{name}.py").write_text(TASKS.replace("\\\\n", "\\n"))
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setenv("PYTHONPATH", str(tmp_path), prepend=":")
    module = __import__(name)
    yield module
    sys.modules.pop(name, None)


@pytest.fixture
def entries():
    """The lines of a journal after its head."""

    def read(path):
        return [json.loads(line) for line in path.read_text().splitlines()[1:]]

    return read
