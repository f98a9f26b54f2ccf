"""``python -m benchmarks exact [NAME ...]``: the scenes of exact friction of 2026 at three steps, beside MuJoCo.

Each scene at 1/60, 1/240 and 1/1000 s, to 1e-8, and in MuJoCo where it is installed, in one process. Two residuals of
the last contact problem of every step, the largest of which is printed:

    natural   |F| / |P|, the one that `tol` asks for
    cones     the largest of  |P - proj_K P| / p,   |g - proj_K* g| / v,   |P.g| / (p v)

over the contacts, with g = gamma + mu |gamma_T| e_N, p the largest impulse and v the largest velocity that a contact
would have without impulses. The second is of the kind that Song, Fan, Ascher and Pai print (primal cone, dual cone,
gap); their scales are not known.
"""

from __future__ import annotations

import os
import platform
import sys
import time
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from benchmarks.exact_scenes import CASES, Case, Places
from benchmarks.peers import adapter, imports
from nonsmooth.integrators.moreau_jean.options import MoreauJean
from nonsmooth.runs.scene_run import SceneRun

STEPS = 60, 240, 1000  # 1/s: of a film, of the authors' code, of the engines
HEADER = (
    "| scene | program | dt [s] | ms a step | contacts | natural | cones | missed | deepest [m] | error | of |\n"
    "|---|---|---|---|---|---|---|---|---|---|---|"
)


class Course(NamedTuple):
    """What came out of a run."""

    seconds: float  # of processor a step
    contacts: int
    natural: float
    cones: float
    missed: str
    depth: float  # [m]
    places: Places


def main(words: list[str]) -> int:
    """Print the tables."""
    if unknown := [name for name in words if name not in CASES]:
        print(f"there is no scene {unknown[0]!r}; known: {', '.join(CASES)}", file=sys.stderr)
        return 2
    print(f"{platform.platform()}, Python {platform.python_version()}, load {os.getloadavg()[0]:.1f}\n\n{HEADER}")
    for name in words or CASES:
        for line in rows(name, CASES[name]):
            print(line, flush=True)
    return 0


def rows(name: str, case: Case) -> Iterator[str]:
    """Ours and MuJoCo's at every step."""
    has_mujoco = imports("mujoco")
    for rate in STEPS:
        yield row(name, "nonsmooth", rate, case, ours(case, 1 / rate))
        if has_mujoco:
            yield row(name, "MuJoCo", rate, case, mujoco(case, 1 / rate))


def row(name: str, program: str, rate: int, case: Case, found: Course) -> str:
    """A row of the table."""
    cells = (
        name, program, f"1/{rate}", f"{1e3 * found.seconds:.3g}", str(found.contacts), number(found.natural),
        number(found.cones), found.missed, number(found.depth), number(case.error(found.places, 1 / rate)), case.says,
    )  # fmt: skip
    return f"| {' | '.join(cells)} |"


def number(value: float) -> str:
    """Two digits, or nothing where it is not known."""
    return "-" if value != value else "0" if value == 0.0 else f"{value:.1e}"


class Watched(SceneRun):
    """A run that looks at every step."""

    may_write = False
    seconds, cones = 0.0, 0.0
    places: list[np.ndarray]

    def take_steps(self, most: int) -> None:
        self.places = [*self.places[:1], *self.places[-1:], self.centres_that_move()]
        began = time.process_time()
        super().take_steps(1)
        self.seconds += time.process_time() - began
        self.cones = max(self.cones, cone_residual(self.assembly.network))

    def centres_that_move(self) -> np.ndarray:
        """Of mass (n, 3) [m]."""
        motion = self.world.bodies.motion
        return motion.x[motion.moves == 1, :3].copy()


def ours(case: Case, dt: float) -> Course:
    """A run of nonsmooth."""
    run = Watched(case.scene(), (0.0, case.t_end), MoreauJean(dt=dt), 1, None)
    run.places = [run.centres_that_move()]
    run.advance(None, None)
    if not run.status.name == "FINISHED":
        raise ArithmeticError(f"the run ended with {run.status.name}: {run.spent}")
    counts, figures = run.assembly.progress.counts, run.assembly.progress.figures
    steps, places = int(counts.steps), np.array([run.places[0], run.places[-1], run.centres_that_move()])
    missed = f"{int(counts.missed)} of {steps}"
    return Course(
        run.seconds / steps, int(counts.most_contacts), float(figures.residual), run.cones, missed,
        max(0.0, float(figures.penetration)), places,
    )  # fmt: skip


def cone_residual(network: Any) -> float:
    """How far impulses and velocities of a contact problem are from the three conditions of its law."""
    m = int(network.n_c)
    if m == 0:
        return 0.0
    P, mu, i, j = network.P[:m], network.mu[:m], network.i[:m], network.j[:m]
    free, gamma = (
        network.b[:m] + np.einsum("cax,cx->ca", network.J_i[:m], v[i]) + np.einsum("cax,cx->ca", network.J_j[:m], v[j])
        for v in (network.v_free, network.v)
    )
    g = gamma.copy()
    g[:, 0] += mu * np.linalg.norm(gamma[:, 1:], axis=1)
    p, v = np.abs(P).max(initial=0.0), np.abs(free).max(initial=0.0)
    if p == 0.0 or v == 0.0:
        return 0.0
    primal = np.linalg.norm(P - projected(P, mu), axis=1) / p
    dual = np.linalg.norm(g - projected(g, 1 / mu), axis=1) / v
    gap = np.abs(np.einsum("ca,ca->c", P, g)) / (p * v)
    return float(max(primal.max(), dual.max(), gap.max()))


def projected(x: np.ndarray, mu: np.ndarray) -> np.ndarray:
    """The points of the cones |x_T| <= mu x_N that are nearest."""
    x_N, size = x[:, 0], np.linalg.norm(x[:, 1:], axis=1)
    on_edge = np.maximum((x_N + mu * size) / (1 + mu * mu), 0.0)
    is_inside = size <= mu * x_N
    share = np.where(is_inside, 1.0, mu * on_edge / np.where(size > 0, size, 1.0))
    return np.column_stack([np.where(is_inside, x_N, on_edge), share[:, None] * x[:, 1:]])


def mujoco(case: Case, dt: float) -> Course:
    """A run of MuJoCo, tuned as its documentation says."""
    motion = adapter("mujoco_exact").Motion(case.scene(), dt)
    places, seconds, contacts, depth = [motion.centres()], 0.0, 0, 0.0
    steps = round(case.t_end / dt)
    for k in range(steps):
        places = [places[0], motion.centres()]
        began = time.process_time()
        motion.step(k * dt)
        seconds += time.process_time() - began
        if motion.is_unstable():
            nowhere = np.full((3, *places[0].shape), np.nan)
            return Course(seconds / (k + 1), contacts, np.nan, np.nan, f"unstable at {k * dt:.2f} s", depth, nowhere)
        contacts, depth = max(contacts, motion.contacts()), max(depth, motion.depth())
    found = np.array([*places, motion.centres()])
    return Course(seconds / steps, contacts, np.nan, np.nan, "-", depth, found)
