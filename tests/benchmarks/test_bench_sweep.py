"""The benchmark of sweeps times the sweeps that it names."""

import numpy as np

from benchmarks import sweep


def test_table_gives_every_cell_a_speed_and_a_start_of_its_own(monkeypatch):
    monkeypatch.setattr(sweep, "SIDE", 6)
    table = sweep.cells_of_their_own("q0[0]")
    assert table.size == 36 and table.dtype.names == ("vb", "q0[0]")
    assert all(np.unique(table[name]).size == 36 for name in table.dtype.names)
    assert 0.05 <= table["vb"].min() and table["vb"].max() <= 0.5


def test_table_runs_of_starts_by_state_and_as_coordinates_are_the_same(monkeypatch):
    monkeypatch.setattr(sweep, "SIDE", 3)
    task = sweep.belt_task()
    by_state, by_number = (sweep.sweep(task, sweep.cells_of_their_own(s), progress=False) for s in ("x", "q0[0]"))
    for name in ("q", "u"):
        assert np.isfinite(by_state[name]).all() and by_state[name].shape == (9, 1)
        np.testing.assert_array_equal(by_state[name].values, by_number[name].values)


def test_map_is_timed_in_one_and_in_two_threads(monkeypatch, capsys):
    monkeypatch.setattr(sweep, "MAP_SIDE", 10)
    sweep.print_map()
    out = capsys.readouterr().out
    assert "map of 100 states, 1 workers" in out and "map of 100 states, 2 workers" in out
