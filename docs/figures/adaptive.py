"""The tables and the figure of docs/theory/adaptive.md: ``python docs/figures/adaptive.py [FOLDER]``.

Error of ns.Adaptive over a run, against its tolerance: the largest |q_i - q_i,ref| at 200 times, in
1e-2 + max |q_i,ref|, which is what atol = rtol/100 and rtol allow it in one step. Reference: ns.EventDriven at 1e-12,
whose own error is a tenth of that; the ball and the block against their closed forms.
"""

from __future__ import annotations

import math
import sys
import textwrap
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

import nonsmooth as ns
from nonsmooth.catalogue import (
    BeadChain,
    BeltOscillator,
    BouncingBall,
    PainleveRod,
    RockingBlock,
    SliderCrank,
    SlidingBlock,
    SpragSlip,
    WallPendulum,
    Woodpecker,
)
from nonsmooth.drawing.colours import BLACK, CYCLE, GREY, WASHED
from nonsmooth.drawing.labels import LETTER
from nonsmooth.drawing.plots import WIDTH, new_figure, save_figure

LEAST = 1e-13  # smaller errors are drawn here
TITLE = 16  # letters in a line of a title
TOLERANCES = (1e-4, 1e-6, 1e-8, 1e-9, 1e-10)
N_TIMES = 200
BELT = BeltOscillator(vb=0.2)
SCENES = {
    "ball, e = 0.5, through Zeno": (BouncingBall(e=0.5), {"height": 1.0}, 2.0),
    "ball, e = 0.8, through Zeno": (BouncingBall(e=0.8), {"height": 1.0}, 4.5),
    "block that stops": (SlidingBlock(), {}, 1.0),
    "rod: slip, stick, slip": (PainleveRod(mu=0.5), {"th": math.pi / 3, "thdot": 0.0, "slip": 1.0}, 0.3),
    "belt, stick–slip": (BELT, {"x": BELT.release_position(), "velocity": 0.2}, 10.0),
    "rocking block": (RockingBlock(), {"tilt": 0.1}, 3.0),
    "pendulum and wall": (WallPendulum(), {"th": 1.0}, 5.0),
    "sprag-slip set 1": (SpragSlip.set_1(cth=0.5), {"th": 0.8, "thdot": 0.0}, 3.0),
    "sprag-slip set 2, seizures": (SpragSlip(), {"th": 0.8, "thdot": 0.0}, 3.0),
    "10 beads and a wall": (BeadChain(n=10), {"velocity": 1.0}, 0.5),
    "slider-crank, clearance": (SliderCrank(), {}, 0.2),
    "woodpecker": (Woodpecker(), {}, 0.3),
}


class Row(NamedTuple):
    """One run: its error in units of 1e-2 + max |q|, and its numbers of steps."""

    scene: str
    rtol: float
    error: float
    steps: int
    plain_steps: int
    status: str


def reference(model: Any, state: tuple, t: np.ndarray) -> np.ndarray:
    """(m, n_q) the coordinates at the times t, by a closed form or by events."""
    if isinstance(model, BouncingBall):
        return np.array([[model.height(moment)] for moment in t])
    if isinstance(model, SlidingBlock):
        return np.array([[model.position(moment), 0.0] for moment in t])[:, : len(state[0])]
    return ns.simulate(model, (0.0, t[-1]), *state, integrator=ns.EventDriven(1e-12, 1e-14), t_eval=t).q


def rows() -> Iterator[Row]:
    """Every scene at every tolerance."""
    for name, (model, start, t_end) in SCENES.items():
        state = model.state(**start)
        t = np.linspace(0.0, t_end, N_TIMES + 1)
        exact = reference(model, state, t)
        scale = 1e-2 + np.abs(exact).max(axis=0)
        for rtol in TOLERANCES:
            sol = ns.simulate(
                model, (0.0, t_end), *state, integrator=ns.Adaptive(rtol, 1e-2 * rtol), t_eval=t, on_failure="return"
            )
            error = float((np.abs(sol.q - exact[: len(sol.t)]) / scale).max())
            free = ns.simulate(
                model, (0.0, t_end), *state, integrator=ns.Adaptive(rtol, 1e-2 * rtol), every=1000, on_failure="return"
            )
            yield Row(name, rtol, error, free.stats.steps, free.stats.evaluations, sol.status.name)


def table(found: list[Row]) -> str:
    """error/rtol and, in brackets, plain steps, in Markdown."""
    lines = [
        "| scene | " + " | ".join(f"`{rtol:.0e}`" for rtol in TOLERANCES) + " |",
        "|---" * (1 + len(TOLERANCES)) + "|",
    ]
    for name in SCENES:
        cells = [f"{row.error / row.rtol:.2g} ({row.plain_steps})" if row.status == "FINISHED" else row.status
                 for row in found if row.scene == name]  # fmt: skip
        lines.append(f"| {name} | " + " | ".join(cells) + " |")
    return "\n".join(lines)


def between_the_steps() -> str:
    """Error at 4000 times over that at the ends of the steps, both in rtol (1e-2 + max |q_i,ref|), in Markdown."""
    lines = []
    for name, (model, start, t_end) in SCENES.items():
        if isinstance(model, SlidingBlock):
            continue
        state, t, cells = model.state(**start), np.linspace(0.0, t_end, 4001), []
        for rtol in TOLERANCES:
            sol = ns.simulate(model, (0.0, t_end), *state, integrator=ns.Adaptive(rtol, 1e-2 * rtol))
            moments = np.unique(np.concatenate((t, sol.t)))
            exact = reference(model, state, moments)
            errors = np.abs(sol(moments).q - exact).max(axis=0, where=np.isin(moments, t)[:, None], initial=0.0)
            at_ends = np.abs(sol(moments).q - exact).max(axis=0, where=np.isin(moments, sol.t)[:, None], initial=0.0)
            scale = rtol * (1e-2 + np.abs(exact).max(axis=0))
            cells.append(f"{(errors / scale).max():.2g} / {(at_ends / scale).max():.2g}")
        lines.append(f"| {name} | " + " | ".join(cells) + " |")
    return "\n".join(lines)


def draw(found: list[Row], path: Path | None = None) -> Any:
    """Error against tolerance, a panel a scene."""
    figure = new_figure(WIDTH, 6.4)
    panels = figure.subplots(4, 3, sharex=True, sharey=True)
    ends = np.array([min(TOLERANCES), max(TOLERANCES)])
    for axes, name in zip(panels.ravel(), SCENES, strict=True):
        own = [row for row in found if row.scene == name and row.status == "FINISHED"]
        axes.loglog(ends, ends, color=BLACK, lw=0.8, ls="--", label="error = rtol")
        axes.loglog(ends, 10 * ends, color=GREY, lw=0.8, ls=":", label="error = 10 rtol")
        rtol, error = [row.rtol for row in own], [max(row.error, LEAST) for row in own]
        axes.loglog(rtol, error, "o-", color=CYCLE[0], ms=3, lw=1.2, label="measured")
        axes.set_title("\n".join(textwrap.wrap(name, TITLE)), fontsize=LETTER)
        axes.set(xticks=[1e-10, 1e-7, 1e-4], yticks=[LEAST, 1e-9, 1e-5], xlim=(3e-11, 3e-4), ylim=(0.2 * LEAST, 5e-3))
        axes.grid(True, which="major", color=WASHED)
    panels[-1, 1].set_xlabel("rtol [-], atol = rtol/100", fontsize=9)
    figure.supylabel("largest error of a coordinate over the run [of its largest]", fontsize=9)
    figure.legend(
        *axes.get_legend_handles_labels(), loc="outside lower center", ncols=3, fontsize=LETTER, frameon=False
    )
    return save_figure(figure, path)


if __name__ == "__main__":
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent
    measured = list(rows())
    print(table(measured), between_the_steps(), sep="\n\n")
    draw(measured, folder / "adaptive_tolerance.png")
