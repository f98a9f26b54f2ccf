"""``python -m benchmarks paradox``: states a second of maps, microseconds of a classification, the cost of a contact.

Times are of the processor, not of the clock: a map of 10^6 states in one thread, the smallest of a few repeats.
"""

from __future__ import annotations

import functools
import platform
import time
from collections.abc import Callable
from typing import Any

import numpy as np

from benchmarks.core_scenes import row_of_blocks
from nonsmooth.catalogue.entries import load
from nonsmooth.paradox.classify import classify
from nonsmooth.studies.paradox_map import paradox_map

REPEATS = 3
SIDE = 1000  # states along each of two axes
MAPS: dict[str, dict[str, tuple[float, float]]] = {
    "painleve-rod": {"th": (0.0, 1.57), "mu": (0.0, 3.0)},
    "spatial-painleve-rod": {"th": (0.05, 1.5), "phi": (-1.5, 1.5)},
    "bilateral-rod": {"th": (0.0, 1.57), "thdot": (-9.0, 9.0)},
    "sprag-slip": {"th": (0.1, 1.5), "thdot": (-5.0, 5.0)},
}
CLASSIFIED = 200  # classifications timed together
BLOCKS = (1, 2, 4, 6, 8)


def main(argv: list[str] | None = None) -> int:
    """Print the tables; returns the exit code."""
    print(f"{platform.platform()}, Python {platform.python_version()}, processor time, least of {REPEATS}\n")
    for name, ends in MAPS.items():
        axes: dict[str, Any] = {axis: np.linspace(*end, SIDE) for axis, end in ends.items()}
        model = load(name)()
        whole_map(model, {axis: values[:2] for axis, values in axes.items()})  # compile
        seconds = least_time(functools.partial(whole_map, model, axes))
        print(f"map of {SIDE**2} states, {name:20} {seconds:7.3f} s  ({1e9 * seconds / SIDE**2:.0f} ns a state)")
    print()
    for n in BLOCKS:
        seconds = classification_time(n)
        print(f"classify {n} blocks at rest in a row ({4**n:5d} modes): {1e6 * seconds:9.0f} us")
    return 0


def whole_map(model: Any, axes: dict[str, Any]) -> None:
    """A map in one thread, to its end."""
    if paradox_map(model, workers=1, progress=False, **axes).attrs["interrupted"]:
        raise KeyboardInterrupt


def classification_time(n: int) -> float:
    """Seconds of one classification of n blocks that rest."""
    system = row_of_blocks(n)
    q, u = np.zeros(system.n_q), np.zeros(system.n_u)
    calls = max(1, CLASSIFIED // 4**n)
    classify(system, 0.0, q, u)  # compile

    def run() -> None:
        for _ in range(calls):
            classify(system, 0.0, q, u)

    return least_time(run) / calls


def least_time(run: Callable[[], Any]) -> float:
    """The least processor time of a few repeats [s]."""
    times = []
    for _ in range(REPEATS):
        start = time.process_time()
        run()
        times.append(time.process_time() - start)
    return min(times)
