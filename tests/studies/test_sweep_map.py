"""Maps of paradoxes through the sweep: the same numbers as `paradox_map`, with journal, workers and single failures."""

from __future__ import annotations

import math

import numpy as np
import xarray as xr

import nonsmooth as ns
from models.painleve_rod import PainleveRod
from models.rocking_block import RockingBlock


def test_a_map_through_the_sweep_is_the_map():
    axes = {"mu": np.linspace(0.2, 2.0, 7), "th": np.linspace(0.2, 1.5, 9), "thdot": np.linspace(0, 8, 5)}
    chart = ns.paradox_map(PainleveRod(), **axes)
    found = ns.sweep(ns.MapTask(PainleveRod()), axes, workers=2, batch=50, progress=False)
    for name in ("n_solutions", "kind", "p", "b", "gamma_F", "la_N"):
        np.testing.assert_array_equal(found[name], chart[name])
    several = {"tilt": [0.0, 0.1], "mu": [0.2, 0.8]}
    chart = ns.paradox_map(RockingBlock(), **several)
    found = ns.sweep(ns.MapTask(RockingBlock()), several, progress=False)
    np.testing.assert_array_equal(found.n_solutions, chart.n_solutions)
    assert found.la_N.dims == ("tilt", "mu", "solution", "contact")


def test_paradoxes_stand_beyond_the_critical_friction():
    """Slender rod sliding towards its tip: m p = 1 + 3 cos^2 th - 3 mu sin th cos th; the paradox is p < 0."""
    mu, th = np.linspace(0.5, 2.5, 41), np.linspace(0.1, 1.5, 57)
    found = ns.sweep(ns.MapTask(PainleveRod(), slip=-1.0, thdot=0.0), {"mu": mu, "th": th}, progress=False)
    p = 1 + 3 * np.cos(th) ** 2 - 3 * mu[:, None] * np.sin(th) * np.cos(th)
    np.testing.assert_allclose(found.p, p / PainleveRod().m, atol=1e-13 * 10)
    np.testing.assert_array_equal(found.n_solutions == 0, p < 0)  # at rest b = -g < 0


def test_a_state_out_of_range_fails_alone(tmp_path):
    axes = {"mu": [-1.0, 0.5, 2.0], "thdot": [0.0, 6.0]}
    task = ns.MapTask(PainleveRod(), th=math.pi / 3)
    found = ns.sweep(task, axes, journal=tmp_path / "j.jsonl", progress=False)
    assert found.status.values.tolist() == [[ns.CellStatus.FAILED] * 2] + [[ns.CellStatus.FINISHED] * 2] * 2
    assert np.isnan(found.n_solutions.values[0]).all()
    again = ns.sweep(task, axes, journal=tmp_path / "j.jsonl", progress=False)
    assert again.attrs["cells_from_journal"] == 6
    xr.testing.assert_equal(found, again)
