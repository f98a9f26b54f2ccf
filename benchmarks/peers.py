"""Other programs as methods of a work-precision study, through the scripts in ``adapters``.

Siconos runs in the Python that has it, in a process of its own that answers one run after another; SciPy and MuJoCo run
here. What is not installed is left out.
"""

from __future__ import annotations

import importlib
import json
import subprocess
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.siconos import interpreter
from nonsmooth.results.failures import StepFailure
from nonsmooth.studies.reference import Problem
from nonsmooth.studies.work_precision import Trial

FOLDER = Path(__file__).parent / "adapters"
STEPS = tuple(10.0 ** (-0.5 * k) for k in range(4, 10))  # of the span: 1e-2 to 3e-5
TOLERANCES = tuple(10.0**-k for k in range(3, 13))


def peers() -> dict[str, Any]:
    """Every program that is installed, by its label."""
    found: dict[str, Any] = {}
    if interpreter() is not None:
        found["Siconos"] = Siconos()
        found["Siconos, events"] = Siconos(has_events=True)
    for label, module, package, settings in (
        ("SciPy", "scipy_motions", "scipy", TOLERANCES),
        ("MuJoCo", "mujoco_motions", "mujoco", STEPS),
    ):
        if imports(package):
            found[label] = InProcess(adapter(module), settings, is_step=label == "MuJoCo")
    return found


def imports(package: str) -> bool:
    """Whether a package is installed whole."""
    try:
        importlib.import_module(package)
    except ImportError:
        return False
    return True


def adapter(name: str) -> Any:
    """A module of the folder."""
    return importlib.import_module(f"benchmarks.adapters.{name}")


class InProcess:
    """A program that runs here: ``module.SCENES[name](problem, p, setting)`` gives (q, seconds, evaluations, steps)."""

    def __init__(self, module: Any, values: Sequence[float], is_step: bool) -> None:
        self.module, self.values, self.is_step = module, values, is_step

    def settings(self, name: str, problem: Problem) -> Sequence[float]:
        """Steps or tolerances."""
        span = problem.span[1] - problem.span[0]
        return [span * v if self.is_step else v for v in self.values] if name in self.module.SCENES else []

    def run(self, name: str, problem: Problem, setting: float) -> Trial:
        """One run."""
        return Trial(*self.module.SCENES[name](problem, problem.model, setting))


class Siconos:
    """Siconos: its Moreau-Jean over its step, or its event-driven scheme, which has the tolerance that it has."""

    scenes = (
        "ball through Zeno", "sliding block", "rod, slip and stick", "rocking block", "pendulum against a wall",
        "bead chain", "slider-crank", "woodpecker", "belt, stick-slip", "sprag-slip, limit cycle",
        "sprag-slip, seizures",
    )  # fmt: skip

    def __init__(self, has_events: bool = False) -> None:
        self.has_events = has_events
        self.process: subprocess.Popen[str] | None = None
        self.positions: dict[tuple[str, float], np.ndarray] = {}  # read once, the repeats are timed only

    def settings(self, name: str, problem: Problem) -> Sequence[float]:
        """Steps [s] of the scenes that the adapter knows."""
        if self.has_events:
            return [float(problem.times[0])] if name == self.scenes[0] else []
        span = problem.span[1] - problem.span[0]
        return [span * part for part in STEPS] if name in self.scenes else []

    def run(self, name: str, problem: Problem, setting: float) -> Trial:
        """One run; each step evaluates the forces once."""
        _, q0, u0 = problem.start
        answer = self.ask({
            "scene": name, "dt": setting, "events": self.has_events, "times": problem.times.tolist(),
            "q0": q0.tolist(), "u0": u0.tolist(), "read": (name, setting) not in self.positions,
            "p": {key: float(value) for key, value in problem.system.parameter_values.items()},
        })  # fmt: skip
        if "error" in answer:
            raise StepFailure(f"Siconos: {answer['error']}", None, np.nan)  # type: ignore[arg-type]
        q = self.positions.setdefault((name, setting), np.array(answer["q"]))
        return Trial(q, answer["wall_time"], answer["steps"], answer["steps"])

    def ask(self, request: dict[str, Any]) -> dict[str, Any]:
        """One answer of the process, which is started with the first request."""
        if self.process is None:
            self.process = subprocess.Popen(
                [str(interpreter()), str(FOLDER / "siconos_motions.py")],
                stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True,
            )  # fmt: skip
        assert self.process.stdin is not None and self.process.stdout is not None
        self.process.stdin.write(json.dumps(request) + "\n")
        self.process.stdin.flush()
        line = self.process.stdout.readline()
        if line:
            answer: dict[str, Any] = json.loads(line)
            return answer
        code = self.close()  # the next request starts another one
        return {"error": f"its process has ended with the code {code}"}

    def close(self) -> int | None:
        """End the process; its exit code."""
        if self.process is None:
            return None
        with self.process as ended:  # closes its pipes and waits
            self.process = None
        return ended.returncode
