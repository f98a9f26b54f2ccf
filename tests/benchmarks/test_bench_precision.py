"""``python -m benchmarks precision``: the exact ends of its scenes, and its rows and picture."""

from __future__ import annotations

import numpy as np
import pytest

import nonsmooth as ns
from benchmarks import precision
from benchmarks.precision_scenes import CASES, CLOSED, ends

KNOWN = [name for name, case in CASES.items() if case.source == CLOSED or "SciPy" in case.source]


@pytest.mark.parametrize("name", KNOWN)
def test_steps_of_half_a_millisecond_end_where_closed_forms_say(name):
    """To the error of a landing, v dt, and its jump: 2 m/s over .5 s; else to second order."""
    case = CASES[name]
    sol = ns.simulate(case.scene(), (0, case.t_end), integrator=ns.MoreauJean(dt=5e-4), every=10**9)
    error = np.abs(ends(sol) - case.exact(case.scene(), case.t_end)).max()
    assert error < (2e-3 if name == "spheres that meet" else 1e-5)


def test_a_scene_has_rows_and_a_panel(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(precision, "STEPS", (1e-2, 2.5e-3))
    monkeypatch.setattr(precision, "TOLERANCES", (1e-2,))
    monkeypatch.setattr(precision, "imports", lambda package: False)
    picture = tmp_path / "precision.png"
    assert precision.main([str(picture), "box that slides"]) == 0
    rows = [line for line in capsys.readouterr().out.splitlines() if line.startswith("| box that slides")]
    assert [row.split(" | ")[1:3] for row in rows] == [
        ["MoreauJean", "0.01"], ["MoreauJean", "0.0025"], ["Adaptive", "0.01"], ["EventDriven", "0.01"],
    ]  # fmt: skip
    errors = [float(row.split(" | ")[3]) for row in rows]
    assert errors[1] < 0.1 * errors[0] and errors[3] < 1e-9
    assert picture.stat().st_size > 10_000
    assert precision.main(["no such scene"]) == 2
