"""Maps of paradoxes are sweeps: the same numbers in any batch, with journal, workers and single failures."""

from __future__ import annotations

import math

import numpy as np
import pytest
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


def test_a_map_names_the_state_that_is_refused():
    rod = PainleveRod()

    def state(th):
        if 0.6 < th < 0.8:
            raise ns.InvalidInput("th is forbidden")
        return rod.state(th=th)

    with pytest.raises(ns.InvalidInput, match=r"th is forbidden \(at th = 0.7\)"):
        ns.paradox_map(rod, state=state, th=[0.5, 0.7, 0.9])
    assert ns.paradox_map(rod, state=state, th=[0.5, 0.9]).sizes["th"] == 2


def test_values_that_the_model_refuses_are_told_from_those_that_came_before():
    """The rules of a model are asked once for each row; what was accepted in one batch is not asked again."""
    task = ns.MapTask(PainleveRod(), th=1.0)
    axes = {"mu": np.array([0.5, -0.5, 0.7, 0.5 + 1e-9]), "thdot": np.linspace(0, 5, 7)}
    for batch in (1, 3, 28):
        found = ns.sweep(task, axes, batch=batch, progress=False)
        is_refused = found.status == ns.CellStatus.FAILED
        np.testing.assert_array_equal(is_refused, np.broadcast_to(axes["mu"][:, None] < 0, (4, 7)))
        assert np.isfinite(found.p.values[~is_refused.values]).all()
