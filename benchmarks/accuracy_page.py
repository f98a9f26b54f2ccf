"""The page docs/benchmarks/accuracy.md from a study of run time against error."""

from __future__ import annotations

import textwrap

import numpy as np

from nonsmooth.studies.work_precision_result import WorkPrecision

COLUMNS = 100  # chosen: of a line of Markdown (tests/test_house.py)
TARGETS = (1e-4, 1e-6)  # errors at which programs are compared
METHOD = """\
interleaved repeats, time of the loop over the steps alone. The error is the mean distance of the positions to the
reference at 16 times, over the largest position. A time at equal error is read off the runs of a method, log-log
between neighbours, from where on every dearer run meets it; `>` is the time of the dearest run where none does, and
a dash stands where the program was not run. In brackets: how many times that of the fastest integrator of ours.
Where no closed form is known, the reference is `EventDriven(rtol=1e-12)` beside `Adaptive(rtol=1e-10)`; of
slider-crank and woodpecker beside `EventDriven(rtol=1e-10)`, since time steps meet their series of impacts too
slowly (see [the models](../models.md)). Below ten times their difference no error is told.

Integrators of ours: steps of 1e-2 to 3e-6 of the span, or tolerances 1e-3 to 1e-12 (`Adaptive`: to 1e-10). Siconos
4.4: `MoreauJeanOSI`, theta = 1/2, LCP by Lemke, its loop in C++ (`run`), gaps compiled, steps of 1e-2 to 3e-5. It has
no given normal force: on the belt a weight makes it, and the smooth part of the friction law is a force. It has no
bilateral contact with friction: sprag-slip has two unilateral ones with a play of 1e-9 m (1e-6 and 1e-12 m give the
same to 3 %); without play the tip wedges, since only the difference of the two normal forces is determined.
SciPy: `solve_ivp` (DOP853) with events written by hand, one mode after the other, for these scenes only. MuJoCo:
`implicitfast`, elliptic cone, default softness of its contacts. The adapters are in `benchmarks/adapters`. Other work
ran on the machine, and interleaving spreads it over all methods: ratios tell more than times."""
OWN = ("Adaptive", "EventDriven", "MoreauJean")


def page(study: WorkPrecision, machine: str, figure: str, repeats: int) -> str:
    """The whole page."""
    said = (
        f"Made by `python -m benchmarks accuracy --peers --out docs/benchmarks/accuracy.md` on {machine}; "
        f"medians of {repeats} {METHOD}"
    )
    parts = [
        "# Run time against error",
        *(textwrap.fill(part, COLUMNS, break_long_words=False, break_on_hyphens=False) for part in said.split("\n\n")),
        f"![error against wall time]({figure})",
        f"![error against force evaluations]({figure.replace('.png', '_evaluations.png')})",
    ]
    for target in TARGETS:
        parts += [f"## Milliseconds at an error of {target:g}", comparison(study, target)]
    parts += ["## Smallest errors", best(study)]
    failures = [f"- {scene}: {line.strip()}" for scene in study.scenes for line in study.failures(scene)]
    if failures:
        parts += ["## Runs that did not reach their end", "\n".join(failures)]
    return "\n\n".join(parts) + "\n"


def comparison(study: WorkPrecision, target: float) -> str:
    """A table of times at equal error; each other program with its ratio to the fastest integrator of ours."""
    methods = [method for method in study.methods if any(len(study.curve(s, method)[0]) for s in study.scenes)]
    rows = [["scene", *methods]]
    for scene in study.scenes:
        times = {method: 1e3 * study.cost_at(target, scene, method) for method in methods}
        own = [times[method] for method in OWN if method in times and np.isfinite(times[method])]
        fastest = min(own) if own else np.nan
        rows.append([scene, *(cell(study, scene, method, times[method], fastest) for method in methods)])
    return table(rows)


def cell(study: WorkPrecision, scene: str, method: str, time: float, fastest: float) -> str:
    """A time; of another program also how many times the fastest of ours; with > where no run met the error."""
    sign = ""
    if not np.isfinite(time):
        sign, time = "> ", 1e3 * study.dearest(scene, method)
    if not np.isfinite(time):
        return "–"
    return f"{sign}{time:.3g}" + ("" if method in OWN or np.isnan(fastest) else f" ({sign}{time / fastest:.2g}×)")


def best(study: WorkPrecision) -> str:
    """A table of the smallest errors, and of how far the references differ."""
    rows = [["scene", "references differ by", *study.methods]]
    for scene in study.scenes:
        disagreement, floor = float(study.data.disagreement.sel(scene=scene)), study.floor_of(scene)
        errors = [study.best_error(scene, method) for method in study.methods]
        told = ["–" if np.isnan(e) else f"{e:.0e}" if e > floor else f"< {floor:.0e}" for e in errors]
        rows.append([scene, f"{disagreement:.0e}" if disagreement > 0 else "closed form", *told])
    return table(rows)


def table(rows: list[list[str]]) -> str:
    """Rows as a table in Markdown."""
    lines = ["| " + " | ".join(row) + " |" for row in rows]
    return "\n".join([lines[0], "|" + "---|" * len(rows[0]), *lines[1:]])
