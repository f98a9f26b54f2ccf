"""Siconos beside us, where it is installed: its solvers run in the Python that has them, through the script in
``adapters``. Source: https://nonsmooth.gricad-pages.univ-grenoble-alpes.fr/siconos
"""

from __future__ import annotations

import functools
import shutil
import subprocess
import tempfile
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

ADAPTER = Path(__file__).parent / "adapters" / "siconos_lcp.py"
STEP_ADAPTER = ADAPTER.with_name("siconos_steps.py")
SYSTEM_PATH = "/usr/bin:/usr/local/bin"  # packages of the system are not seen by a virtual environment


class Answers(NamedTuple):
    """z (count, n) and the time of each solve, call from Python included [s]."""

    z: np.ndarray
    time: np.ndarray


@functools.cache
def interpreter() -> str | None:
    """The Python that can import Siconos; None if there is none."""
    for found in {shutil.which("python3", path=SYSTEM_PATH), shutil.which("python3")} - {None}:
        probe = subprocess.run([str(found), "-c", "import siconos.numerics"], capture_output=True)
        if probe.returncode == 0 and ADAPTER.is_file():
            return found
    return None


def solve_lcps(batches: list[tuple[np.ndarray, np.ndarray]]) -> dict[str, list[Answers]]:
    """Each batch A (count, n, n), b (count, n) by every solver of the adapter; empty without Siconos."""
    python = interpreter()
    if python is None:
        return {}
    problems: dict[str, Any] = {}
    for k, (A, b) in enumerate(batches):
        problems |= {f"A_{k}": A, f"b_{k}": b}
    answers = answers_of(python, ADAPTER, problems)
    names = sorted({key.split("_")[0] for key in answers})
    return {
        name: [Answers(answers[f"{name}_z_{k}"], answers[f"{name}_time_{k}"]) for k in range(len(batches))]
        for name in names
    }


def solve_steps(problems: list[tuple[np.ndarray, np.ndarray, np.ndarray]]) -> list[tuple[np.ndarray, float]]:
    """Impulses and processor time of each frictional contact problem (W, q, mu); empty without Siconos."""
    python = interpreter()
    if python is None:
        return []
    arrays: dict[str, Any] = {}
    for k, (W, q, mu) in enumerate(problems):
        arrays |= {f"W_{k}": W, f"q_{k}": q, f"mu_{k}": mu}
    answers = answers_of(python, STEP_ADAPTER, arrays)
    return [(answers[f"r_{k}"], float(answers[f"time_{k}"])) for k in range(len(problems))]


def answers_of(python: str, script: Path, problems: dict[str, Any]) -> dict[str, np.ndarray]:
    """What a script of Siconos's Python answers to some arrays."""
    with tempfile.TemporaryDirectory() as folder:
        source, target = Path(folder, "problems.npz"), Path(folder, "answers.npz")
        np.savez(source, **problems)
        subprocess.run([python, str(script), str(source), str(target)], check=True, capture_output=True)
        return dict(np.load(target))
