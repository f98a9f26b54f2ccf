"""What a sweep refuses before it starts, and the words it does it with; what it shows while it runs."""

from __future__ import annotations

import io
import json
import time

import numpy as np
import pytest
import xarray as xr

import nonsmooth as ns
from models.bead_chain import BeadChain
from models.belt_oscillator import BeltOscillator
from models.self_locking_rod import SelfLockingRod
from nonsmooth.sweeps.progress import Progress, Snapshot, duration
from tests.systems import ball

BELT = ns.RunTask(BeltOscillator(), t_span=(0, 0.1), integrator=ns.MoreauJean(1e-2))
ROD = ns.RunTask(SelfLockingRod(), t_span=(0, 0.01))


def two(x, y=0.0):
    return x + y


REFUSED = [
    (BELT, {"vbb": [0.1]}, ns.UnknownName, r"no axis 'vbb'; did you mean 'vb'\?"),
    (BELT, {"q0[3]": [0.1]}, ns.InvalidInput, r"q0\[3\]: the state has 1 entries"),
    (BELT, {"vb": [0.1, float("nan")]}, ns.InvalidInput, r"the axis vb must be finite; vb\[1\] is nan"),
    (BELT, {"vb": [0.1, float("inf")]}, ns.InvalidInput, r"vb\[1\] is inf"),
    (BELT, {"vb": []}, ns.InvalidInput, "the axis vb must have at least one value"),
    (BELT, {"vb": 0.1}, ns.InvalidInput, "the axis vb must be a vector"),
    (BELT, {"vb": [0.1, 0.2, 0.1]}, ns.InvalidInput, "values of the axis vb must differ; 0.1 stands there twice"),
    (BELT, [ns.Axis("vb", [0.1]), ns.Axis("vb", [0.2])], ns.InvalidInput, "the axis vb is given twice"),
    (BELT, {"vb": [0.1], "model.vb": [0.2]}, ns.InvalidInput, "two axes vary model.vb"),
    (BELT, {"vb": [None]}, ns.InvalidInput, "must hold numbers or texts"),
    (two, {"x": np.arange(1e6), "y": np.arange(1e6)}, ns.InvalidInput, "results of 1000000000000 cells need"),
    (BELT, {}, ns.InvalidInput, "axes must be"),
    (BELT, [{"vb": 0.1}, {"x": 0.1}], ns.InvalidInput, "every row of a table must have the columns"),
    (two, {"z": [1]}, ns.UnknownName, "takes no 'z'; known: x, y"),
    (two, {"y": [1]}, ns.InvalidInput, "needs another axis, or a default: missing a required argument: 'x'"),
    (3, {"x": [1]}, ns.InvalidInput, "a task must be a RunTask, a model or a function; got int"),
]


@pytest.mark.parametrize(("task", "axes", "error", "words"), REFUSED)
def test_refusals_name_the_axis_and_the_cure(task, axes, error, words):
    with pytest.raises(error, match=words):
        ns.sweep(task, axes, progress=False)


OPTIONS = [
    ({"workers": 0}, "workers must be a whole number"),
    ({"batch": 0}, "batch must be a whole number"),
    ({"retries": -1}, "retries must be a whole number"),
    ({"timeout": 0.0}, "timeout must be positive"),
    ({"progress": "loud"}, "progress must be True"),
    ({"out": "map.csv"}, "must end in one of .npz, .nc"),
    ({"out": "no such folder/map.npz"}, "there is no folder"),
    ({"scheduler": "tcp://a", "executor": ns.LocalPool}, "give either executor or scheduler"),
    ({"scheduler": "tcp://127.0.0.1:1", "timeout": 1.0}, "timeout needs worker processes"),
]


@pytest.mark.parametrize(("options", "words"), OPTIONS)
def test_refused_options(options, words):
    with pytest.raises(ns.InvalidInput, match=words):
        ns.sweep(two, {"x": [1, 2]}, **({"progress": False} | options))


def test_a_task_that_cannot_travel_says_what_it_is():
    with pytest.raises(ns.InvalidInput, match=r"the task .*<lambda> cannot be pickled.*workers=1"):
        ns.sweep(lambda x: x, {"x": [1]}, workers=2, progress=False)


def test_refused_tasks():
    belt = BeltOscillator()
    for options, words in (
        ({"measures": "amplitud"}, r"no measure 'amplitud'; did you mean 'amplitude'\?"),
        ({"measures": []}, "must name at least one result"),
        ({"selection": "none"}, "no selection rule 'none'"),
        ({"state": {"velocty": 1.0}}, r"no variable 'velocty'; did you mean 'velocity'\?"),
        ({"state": {"q0": [0.0]}}, "give q0 and u0"),
        ({"state": {"q0": [0.0, 0.0], "u0": [0.0]}}, "q0 must have 1 entries"),
        ({"window": 1.5}, r"window must lie in \[0, 1\]"),
        ({"t_span": (1.0, 0.0)}, "t_span must not run backwards"),
    ):
        with pytest.raises(ns.InvalidInput, match=words):
            ns.RunTask(belt, **options)
    with pytest.raises(ns.InvalidInput, match="no dt to step with; give integrator"):
        ns.RunTask(ball(), t_span=(0, 1))
    given = ns.RunTask(belt, t_span=(0, 1), state={"q0": [0.0], "u0": [0.0]})
    with pytest.raises(ns.InvalidInput, match=r"use q0\[i\]"):
        ns.sweep(given, {"x": [0.0]}, progress=False)


def test_a_name_with_two_meanings_must_be_told_apart():
    """theta is the integrator's; th0 is the rod's; a model with a field dt has two."""
    from dataclasses import make_dataclass

    model = make_dataclass("Odd", [("dt", float, 1.0)], bases=(BeltOscillator,), frozen=True)()
    task = ns.RunTask(model, t_span=(0, 0.1), integrator=ns.MoreauJean(1e-2))
    with pytest.raises(ns.InvalidInput, match="two meanings; say model.dt or integrator.dt"):
        ns.sweep(task, {"dt": [1e-2]}, progress=False)
    assert ns.sweep(task, {"integrator.dt": [1e-2, 1e-3]}, progress=False).status.values.tolist() == [1, 1]


def test_options_out_of_range_fail_their_cells():
    found = ns.sweep(BELT, {"theta": [0.3, 0.5], "dt": [1e-2, 5e-3]}, progress=False)
    assert found.status.values.tolist() == [[ns.CellStatus.FAILED] * 2, [ns.CellStatus.FINISHED] * 2]
    assert "theta must lie in" in str(found.message.values[0, 0])


def test_entries_of_the_state_are_axes_under_both_of_their_names():
    for one, other in (("q[0]", "q0[0]"), ("u[0]", "u0[0]")):
        found = [ns.sweep(BELT, {"vb": [0.1, 0.2], name: [0.0, 0.01]}, progress=False) for name in (one, other)]
        np.testing.assert_array_equal(found[0].q.values, found[1].q.values)
        assert found[0].q.dims == ("vb", one, "coordinate") and (found[0].u.diff(one) != 0).any()
    with pytest.raises(ns.InvalidInput, match=r"two axes vary q0\[0\]; keep one of them"):
        ns.sweep(BELT, {"q[0]": [0.0], "q0[0]": [0.1]}, progress=False)
    with pytest.raises(ns.InvalidInput, match=r"q0\[0\] twice"):
        ns.RunTask(BeltOscillator(), t_span=(0, 0.02), state={"q[0]": 0.0, "q0[0]": 0.1})


def test_a_table_runs_row_by_row():
    rows = [{"vb": 0.1, "x": 0.0}, {"vb": 0.2, "x": 0.1}, {"vb": 0.1, "x": 0.0}]
    found = ns.sweep(BELT, rows, progress=False)
    assert found.q.dims == ("cell", "coordinate") and found.vb.values.tolist() == [0.1, 0.2, 0.1]
    grid = ns.sweep(BELT, {"vb": [0.1, 0.2], "x": [0.0, 0.1]}, progress=False)
    np.testing.assert_array_equal(found.q.values[:2, 0], [grid.q.values[0, 0, 0], grid.q.values[1, 1, 0]])
    pandas = pytest.importorskip("pandas")
    xr.testing.assert_identical(found, ns.sweep(BELT, pandas.DataFrame(rows), progress=False))
    frame = found.drop_dims("coordinate").to_dataframe()
    assert len(frame) == 3 and set(frame.columns) >= {"vb", "x", "status"}


def test_axes_carry_units():
    found = ns.sweep(BELT, {"vb": ([0.1, 0.2], "m/s"), "x": [0.0], "dt": [1e-2], "t_end": [0.1]}, progress=False)
    assert [found[name].attrs["units"] for name in ("vb", "x", "dt", "t_end")] == ["m/s", "m", "s", "s"]
    assert found.q.attrs["units"] == "m" and found.u.attrs["units"] == "m/s"


def test_the_end_may_vary():
    found = ns.sweep(BELT, {"t_end": [0.05, 0.1]}, progress=False)
    belt = BeltOscillator()
    for t_end, q in zip((0.05, 0.1), found.q.values, strict=True):
        assert q == ns.simulate(belt, (0, t_end), *belt.state(), integrator=ns.MoreauJean(1e-2)).q[-1]


@pytest.mark.parametrize("ending", ("npz", "nc"))
def test_results_come_back_from_disk(tmp_path, ending):
    if ending == "nc":
        pytest.importorskip("netCDF4")
    task = ns.RunTask(BeadChain(), ["final_state", "modes", "impacts"], t_span=(0, 0.1))
    path = tmp_path / f"found.{ending}"
    found = ns.sweep(task, {"e": [-1.0, 0.5], "velocity": [0.5, 1.0]}, out=path, progress=False)
    assert [file.name for file in tmp_path.iterdir()] == [path.name]
    again = ns.load_sweep(path)
    xr.testing.assert_equal(found, again)
    assert again.attrs["study"] == found.attrs["study"] and again.q.attrs["long_name"] == found.q.attrs["long_name"]
    (tmp_path / "other.npz").write_bytes(b"no archive")
    with pytest.raises(ns.InvalidInput, match="other.npz is no result of a sweep"):
        ns.load_sweep(tmp_path / "other.npz")


class Terminal(io.StringIO):
    def isatty(self):
        return True


def test_progress_is_a_line_on_a_terminal_and_silent_in_a_pipe():
    for stream, shows in ((Terminal(), True), (io.StringIO(), False)):
        with Progress(True, 100, 20, stream) as progress:
            progress.period = 0.0
            progress.add(30, 2)
        assert ("50/100 cells (50%)" in stream.getvalue() and "2 failed" in stream.getvalue()) == shows


def test_progress_json_is_a_line_each(monkeypatch):
    stream = io.StringIO()
    with Progress("json", 10, 0, stream) as progress:
        progress.add(4, 1)  # within the second: nothing
        assert stream.getvalue() == ""
    (line,) = stream.getvalue().splitlines()
    entry = json.loads(line)
    assert (entry["done"], entry["total"], entry["failed"]) == (4, 10, 1) and entry["remaining"] >= 0


def test_rate_and_remaining_time_count_this_session_only(monkeypatch):
    clock = iter([100.0, 110.0, 110.0])
    monkeypatch.setattr("nonsmooth.sweeps.progress.time.perf_counter", lambda: next(clock))
    progress = Progress(False, 100, 50)
    progress.done += 10
    assert progress.snapshot() == Snapshot(60, 100, 0, 10.0, 1.0, 40.0)
    assert [duration(s) for s in (40, 600, 7200)] == ["40 s", "10 min", "2.0 h"]


def test_a_function_sees_each_snapshot():
    seen = []
    ns.sweep(two, {"x": np.arange(5.0)}, progress=seen.append)
    assert seen[-1].done == 5 and seen[-1].total == 5


def test_what_a_worker_compiles_before_its_first_cells_is_no_part_of_the_rate(monkeypatch):
    """10 s until the first of 100 cells is back, of which it took 0.1 s: 9.9 s are left, not 990."""
    now = [100.0]
    monkeypatch.setattr("nonsmooth.sweeps.progress.time.perf_counter", lambda: now[0])
    stream = io.StringIO()
    progress = Progress(True, 100, 0, stream)
    now[0] = 110.0
    progress.finish(np.arange(1), 0, 0.1)
    assert progress.snapshot().remaining == pytest.approx(9.9) and stream.getvalue() == ""


def test_first_cells_that_compiled_on_their_way_are_not_announced_as_a_long_sweep(monkeypatch):
    """One of 1000 cells takes 3 s, and all others a millisecond: 50 min are no estimate."""
    now = [100.0]
    monkeypatch.setattr("nonsmooth.sweeps.progress.time.perf_counter", lambda: now[0])
    stream = io.StringIO()
    progress = Progress(True, 1000, 0, stream)
    for cells, seconds in ((1, 3.0), (600, 0.6), (100, 0.5)):
        now[0] += seconds
        progress.finish(np.arange(cells), 0, seconds)
    assert stream.getvalue() == "" and progress.snapshot().remaining == pytest.approx(299 * 4.1 / 701)


@pytest.mark.upkeep
@pytest.mark.parametrize("workers", [1, 2])
def test_a_model_that_compiles_for_long_is_not_announced_as_a_long_sweep(workers, monkeypatch, capsys):
    """Also where threads run the cells: three seconds of compiling are no cell's."""
    from nonsmooth.sweeps.map_task import MapTask

    load, loaded = MapTask.load, []

    def slow(task):
        if not loaded:
            time.sleep(1.5)
        loaded.append(load(task))

    monkeypatch.setattr(MapTask, "load", slow)
    ns.paradox_map(BeltOscillator(), x=np.linspace(0, 1, 100), workers=workers)
    assert loaded and "will take" not in capsys.readouterr().err


def test_an_option_of_the_runs_is_answered_by_its_place():
    with pytest.raises(ns.InvalidInput, match=r"sweep takes no t_span=; .*RunTask\(model, measures, t_span=..., state"):
        ns.sweep(BeltOscillator(), {"vb": [0.1]}, t_span=(0, 1), state={"x": 0.1})
    with pytest.raises(TypeError, match="unexpected keyword argument 'speed'"):
        ns.sweep(BeltOscillator(), {"vb": [0.1]}, speed=1)


@pytest.mark.parametrize(("name", "unit"), [("vb", "mm/s"), ("x", "mm"), ("c", "N/m"), ("dt", "ms")])
def test_a_unit_that_is_not_the_models_is_refused(name, unit):
    """Values are not converted, so another label would be a wrong number."""
    with pytest.raises(ns.InvalidInput, match=rf"the axis {name} is in .*not converted; .*without '{unit}'"):
        ns.sweep(BELT, {name: ([0.1, 0.2], unit)}, progress=False)


def test_a_unit_is_the_same_in_another_spelling():
    found = ns.sweep(BELT, {"c": ([0.1, 0.2], "N*s/m")}, progress=False)
    assert found.c.attrs["units"] == "N*s/m"
