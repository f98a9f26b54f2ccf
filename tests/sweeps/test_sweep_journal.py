"""The journal: what was finished is never lost, never computed again, and never taken from another study."""

from __future__ import annotations

import functools
import json
import os
import signal
import subprocess
import sys
import time

import numpy as np
import pytest
import xarray as xr

import nonsmooth as ns
from models.belt_oscillator import BeltOscillator
from nonsmooth.sweeps.axes import as_plan
from nonsmooth.sweeps.journal import Journal, block_lines, with_checksum
from nonsmooth.sweeps.task import Batch

pytestmark = pytest.mark.upkeep

AXES = {"x": [1.0, 2.0, 3.0], "y": [10.0, 20.0]}


def counting(tasks, folder):
    return functools.partial(tasks.counted, folder=str(folder))


def calls(folder):
    return (folder / "calls.txt").read_text().splitlines()


def test_a_finished_journal_is_read_instead_of_computed(tasks, tmp_path):
    task, journal = counting(tasks, tmp_path), tmp_path / "journal.jsonl"
    first = ns.sweep(task, AXES, journal=journal, progress=False)
    again = ns.sweep(task, AXES, journal=journal, progress=False)
    assert len(calls(tmp_path)) == 6 and again.attrs["cells_from_journal"] == 6
    xr.testing.assert_equal(first, again)


def test_resume_false_begins_anew(tasks, tmp_path):
    task, journal = counting(tasks, tmp_path), tmp_path / "journal.jsonl"
    for _ in range(2):
        ns.sweep(task, AXES, journal=journal, resume=False, progress=False)
    assert len(calls(tmp_path)) == 12 and len(journal.read_text().splitlines()) == 7


def test_numbers_come_back_to_the_bit(tasks, tmp_path):
    axes = {"x": [1.0, 2.0, 3.0, 0.1 + 0.2, 1e-308, 1 / 3]}
    first = ns.sweep(tasks.several, axes, journal=tmp_path / "j.jsonl", progress=False)
    again = ns.sweep(tasks.several, axes, journal=tmp_path / "j.jsonl", progress=False)
    assert np.isnan(first.pair.values[1, 1])
    xr.testing.assert_equal(first, again)
    for line in (tmp_path / "j.jsonl").read_text().splitlines():
        json.loads(line, parse_constant=pytest.fail)  # strict JSON: no NaN


def test_lines_may_stand_in_any_order(tasks, tmp_path):
    """Two workers finish their batches in turns: 0 2 1 3 are all numbers from 0 to 3, out of order."""
    path, axes = tmp_path / "j.jsonl", {"x": [1.0], "y": [1.0, 2.0, 3.0, 4.0]}
    first = ns.sweep(tasks.product, axes, journal=path, progress=False)
    head, *lines = path.read_text().splitlines(keepends=True)
    path.write_text(head + lines[0] + lines[2] + lines[1] + lines[3])
    again = ns.sweep(tasks.product, axes, journal=path, progress=False)
    np.testing.assert_array_equal(again.value, first.value)
    assert again.attrs["cells_from_journal"] == 4


def test_failures_are_finished_cells_with_their_message(tasks, tmp_path):
    first = ns.sweep(tasks.picky, AXES, journal=tmp_path / "j.jsonl", progress=False)
    again = ns.sweep(tasks.picky, AXES, journal=tmp_path / "j.jsonl", progress=False)
    assert again.attrs["cells_from_journal"] == 6 and again.attrs["cells_failed"] == 2
    xr.testing.assert_equal(first, again)


@pytest.mark.parametrize("cut", (1, 9, 25))
def test_a_torn_last_line_is_computed_again(tasks, tmp_path, cut):
    task, journal = counting(tasks, tmp_path), tmp_path / "journal.jsonl"
    whole = ns.sweep(task, AXES, journal=journal, progress=False)
    with open(journal, "r+b") as file:
        file.truncate(journal.stat().st_size - cut)
    again = ns.sweep(task, AXES, journal=journal, progress=False)
    assert again.attrs["cells_from_journal"] == 5 and len(calls(tmp_path)) == 7
    xr.testing.assert_equal(whole, again)
    assert all(json.loads(line) for line in journal.read_text().splitlines())


def test_a_torn_head_is_an_empty_journal(tasks, tmp_path):
    journal = tmp_path / "j.jsonl"
    journal.write_text('{"journal": "nonsmooth sweep", "for')
    assert ns.sweep(tasks.product, AXES, journal=journal, progress=False).attrs["cells_from_journal"] == 0
    assert len(journal.read_text().splitlines()) == 7


def test_a_damaged_line_inside_is_named(tasks, tmp_path):
    journal = tmp_path / "j.jsonl"
    ns.sweep(tasks.product, AXES, journal=journal, progress=False)
    lines = journal.read_text().splitlines()
    lines[3] = lines[3][:-5]
    journal.write_text("\n".join(lines) + "\n")
    with pytest.raises(ns.InvalidInput, match="line 4 of the journal"):
        ns.sweep(tasks.product, AXES, journal=journal, progress=False)


def refused_line(tasks, journal, k):
    with pytest.raises(ns.InvalidInput, match=f"line {k} of the journal .* is damaged; delete that line") as refusal:
        ns.sweep(tasks.product, AXES, journal=journal, progress=False)
    return str(refusal.value)


def test_a_number_that_was_edited_is_named_and_computed_again_where_its_line_is_deleted(tasks, tmp_path):
    task, journal = counting(tasks, tmp_path), tmp_path / "j.jsonl"
    whole = ns.sweep(task, AXES, journal=journal, progress=False)
    lines = journal.read_text().splitlines(keepends=True)
    assert '"value": 20.0' in lines[3]
    edited = [*lines[:3], lines[3].replace("20.0", "21.0"), *lines[4:]]
    journal.write_text("".join(edited))
    with pytest.raises(ns.InvalidInput, match="line 4 of the journal"):
        ns.sweep(task, AXES, journal=journal, progress=False)
    assert journal.read_text() == "".join(edited)
    journal.write_text("".join(lines[:3] + lines[4:]))
    again = ns.sweep(task, AXES, journal=journal, progress=False)
    assert again.attrs["cells_from_journal"] == 5 and len(calls(tmp_path)) == 7
    xr.testing.assert_equal(whole, again)


def test_the_line_of_another_journal_is_no_line_of_this_one(tasks, tmp_path):
    here, there = tmp_path / "here.jsonl", tmp_path / "there.jsonl"
    ns.sweep(tasks.product, AXES, journal=here, progress=False)
    ns.sweep(tasks.slow_product, AXES, journal=there, progress=False)
    own, foreign = (path.read_text().splitlines(keepends=True) for path in (here, there))
    here.write_text("".join([*own[:2], foreign[2], *own[3:]]))
    refused_line(tasks, here, 3)


def test_a_line_that_stands_there_twice_is_one_cell(tasks, tmp_path):
    journal = tmp_path / "j.jsonl"
    whole = ns.sweep(tasks.product, AXES, journal=journal, progress=False)
    lines = journal.read_text().splitlines(keepends=True)
    journal.write_text("".join(lines + lines[2:4]))
    again = ns.sweep(tasks.product, AXES, journal=journal, progress=False)
    assert again.attrs["cells_from_journal"] == 6
    xr.testing.assert_equal(whole, again)


def test_a_head_that_is_damaged_or_of_another_format_is_refused_by_name(tasks, tmp_path):
    journal = tmp_path / "j.jsonl"
    ns.sweep(tasks.product, AXES, journal=journal, progress=False)
    head, *lines = journal.read_text().splitlines(keepends=True)
    later = head.replace('"format": 1', '"format": 2')
    for other, words in (
        (head.replace('"cells": 6', '"cells": 7'), "the first line of the journal .* is damaged"),
        (later, "has format 2; this version reads 1; choose another path, or resume=False"),
    ):
        journal.write_text("".join([other, *lines]))
        with pytest.raises(ns.InvalidInput, match=words):
            ns.sweep(tasks.product, AXES, journal=journal, progress=False)
    journal.write_text(head.rstrip("\n"))
    assert ns.sweep(tasks.product, AXES, journal=journal, progress=False).attrs["cells_from_journal"] == 0


def test_a_head_without_an_end_is_damage_and_what_follows_it_is_not_written_over(tasks, tmp_path):
    """A head that is the whole file was torn; a long text that begins as one is somebody's."""
    journal = tmp_path / "j.jsonl"
    text = '{"journal": "nonsmooth sweep", "notes": "' + 2**20 * "x"
    journal.write_text(text)
    with pytest.raises(ns.InvalidInput, match="is no journal of a sweep"):
        ns.sweep(tasks.product, AXES, journal=journal, progress=False)
    assert journal.read_text() == text


MANY = {"x": np.arange(10_000.0)}  # cells of three blocks, in one batch


def batch_of_many(n, seed=0):
    """Cells in any order with numbers of every kind, texts and failures."""
    rng = np.random.default_rng(seed)
    numbers = rng.normal(size=(n, 2, 3)) * 10.0 ** rng.integers(-300, 300, (n, 2, 3))
    numbers[::7, 0, 0], numbers[::11, 1, 2], numbers[::13, 1, 1] = np.nan, -np.inf, -0.0
    texts = np.array([f"cell {k}, \u03bc" for k in range(n)], dtype=object)
    values = {"numbers": numbers, "one": rng.normal(size=n), "text": texts}
    messages = {int(k): f"cell {k} failed" for k in range(0, n, 999)}
    return rng.permutation(n), Batch(values, rng.integers(-3, 9, n), messages)


def written_and_read(path, cells, batch):
    plan = as_plan({"x": np.arange(float(len(cells)))})
    with Journal(path, "study", plan, False) as journal:
        journal.write(cells, batch)
    with Journal(path, "study", plan, True) as journal:
        return list(journal.read())


@pytest.mark.parametrize("n", [63, 64, 4096, 4097, 10_000])
def test_blocks_and_lines_come_back_to_the_bit(tmp_path, n):
    cells, batch = batch_of_many(n)
    parts = written_and_read(tmp_path / "j.jsonl", cells, batch)
    assert np.concatenate([found for found, _ in parts]).tolist() == cells.tolist()
    assert np.concatenate([found.status for _, found in parts]).tolist() == batch.status.tolist()
    for name, values in batch.values.items():
        found = np.concatenate([part.values[name] for _, part in parts])
        same = found.tolist() == values.tolist() if values.dtype == object else found.tobytes() == values.tobytes()
        assert same and found.shape == values.shape, name
    starts = np.cumsum([0] + [len(found) for found, _ in parts])
    found = {
        k + start: text for start, (_, part) in zip(starts, parts, strict=False) for k, text in part.messages.items()
    }
    assert found == batch.messages
    lines = (tmp_path / "j.jsonl").read_text().splitlines()
    for line in lines:
        json.loads(line, parse_constant=pytest.fail)  # strict JSON: no NaN
    assert len(lines) == 1 + (n if n < 64 else -(-n // 4096))


@pytest.mark.parametrize("cut", [1, 40, 30_000])
def test_a_torn_last_block_is_computed_again_and_no_other(tasks, tmp_path, cut):
    journal = tmp_path / "j.jsonl"
    whole = ns.sweep(tasks.product, MANY | {"y": [2.0]}, journal=journal, batch=10_000, progress=False)
    lines = journal.read_bytes().splitlines(keepends=True)
    assert [line.startswith(b'{"cells": [') for line in lines] == [False, True, True, True]
    journal.write_bytes(b"".join(lines)[:-cut])
    again = ns.sweep(tasks.product, MANY | {"y": [2.0]}, journal=journal, progress=False)
    assert again.attrs["cells_from_journal"] == 2 * 4096
    xr.testing.assert_equal(whole, again)


def test_an_edited_block_is_named_and_its_cells_are_computed_again_where_it_is_deleted(tasks, tmp_path):
    journal, axes = tmp_path / "j.jsonl", MANY | {"y": [2.0]}
    whole = ns.sweep(tasks.product, axes, journal=journal, batch=10_000, progress=False)
    lines = journal.read_bytes().splitlines(keepends=True)
    edited = lines[2].replace(b'"cells": [4096, ', b'"cells": [4095, ')
    assert edited != lines[2]
    journal.write_bytes(b"".join([*lines[:2], edited, *lines[3:]]))
    with pytest.raises(ns.InvalidInput, match="line 3 of the journal .* is damaged; delete that line"):
        ns.sweep(tasks.product, axes, journal=journal, progress=False)
    journal.write_bytes(b"".join([*lines[:2], *lines[3:]]))
    again = ns.sweep(tasks.product, axes, journal=journal, progress=False)
    assert again.attrs["cells_from_journal"] == 10_000 - 4096
    xr.testing.assert_equal(whole, again)


def test_a_block_with_fewer_numbers_than_cells_is_damage_also_with_a_checksum_of_its_own(tmp_path):
    cells, batch = batch_of_many(100)
    plan = as_plan({"x": np.arange(100.0)})
    with Journal(tmp_path / "j.jsonl", "study", plan, False) as journal:
        journal.write(cells, batch)
        (tmp_path / "j.jsonl").write_bytes(journal._head)
        line = next(block_lines(cells, batch)).replace('"cells": [', '"cells": [0, ')
        journal._file.write(with_checksum(line, journal._start))
    with Journal(tmp_path / "j.jsonl", "study", plan, True) as journal:
        with pytest.raises(ns.InvalidInput, match="line 2 of the journal .* is damaged"):
            list(journal.read())


def test_lines_of_single_cells_and_blocks_stand_in_one_journal(tasks, tmp_path):
    """As where an earlier program wrote a line for each cell."""
    journal, axes = tmp_path / "j.jsonl", MANY | {"y": [2.0]}
    whole = ns.sweep(tasks.product, axes, journal=journal, batch=50, progress=False)
    lines = journal.read_bytes().splitlines(keepends=True)
    assert len(lines) == 10_001
    journal.write_bytes(b"".join(lines[:301]))
    ns.sweep(tasks.product, axes, journal=journal, batch=5000, progress=False)
    again = ns.sweep(tasks.product, axes, journal=journal, progress=False)
    assert again.attrs["cells_from_journal"] == 10_000 and len(journal.read_bytes().splitlines()) < 310
    xr.testing.assert_equal(whole, again)


def studies():
    belt, dt = BeltOscillator(), ns.MoreauJean(1e-2)
    axes = {"vb": [0.1, 0.2]}
    yield "the study itself", ns.RunTask(belt, t_span=(0, 1), integrator=dt), axes
    yield "another parameter", ns.RunTask(BeltOscillator(k=11.0), t_span=(0, 1), integrator=dt), axes
    yield "another step", ns.RunTask(belt, t_span=(0, 1), integrator=ns.MoreauJean(5e-3)), axes
    yield "another end", ns.RunTask(belt, t_span=(0, 2), integrator=dt), axes
    yield "another start", ns.RunTask(belt, t_span=(0, 1), integrator=dt, state={"x": 0.1}), axes
    yield "another measure", ns.RunTask(belt, "amplitude", t_span=(0, 1), integrator=dt), axes
    yield "another axis", ns.RunTask(belt, t_span=(0, 1), integrator=dt), {"vb": [0.1, 0.3]}
    yield "another name", ns.RunTask(belt, t_span=(0, 1), integrator=dt), {"N": [0.1, 0.2]}
    yield "a function", (lambda vb: vb), axes


def test_a_journal_of_another_study_is_refused(tmp_path):
    (_, task, axes), *others = studies()
    journal = tmp_path / "j.jsonl"
    ns.sweep(task, axes, journal=journal, progress=False)
    before = journal.read_bytes()
    for what, other, its_axes in others:
        with pytest.raises(ns.InvalidInput, match="belongs to another study"):
            ns.sweep(other, its_axes, journal=journal, progress=False)
            pytest.fail(what)
    assert journal.read_bytes() == before


def test_an_edited_function_is_another_study(tmp_path):
    journal = tmp_path / "j.jsonl"
    namespace = {}
    exec("def f(x): return x + 1\ndef g(x): return x + 2", namespace)
    namespace["g"].__qualname__ = namespace["f"].__qualname__
    ns.sweep(namespace["f"], {"x": [1]}, journal=journal, progress=False)
    with pytest.raises(ns.InvalidInput, match="belongs to another study"):
        ns.sweep(namespace["g"], {"x": [1]}, journal=journal, progress=False)


@pytest.mark.parametrize("content", ("hello\n", '{"cell": 1}\n', "\x00\x01binary", "[1, 2]\n"))
def test_a_file_that_is_no_journal_is_refused_and_left_alone(tasks, tmp_path, content):
    journal = tmp_path / "precious.txt"
    journal.write_text(content)
    with pytest.raises(ns.InvalidInput, match="no journal of a sweep"):
        ns.sweep(tasks.product, AXES, journal=journal, progress=False)
    assert journal.read_text() == content


def test_a_journal_that_cannot_be_written_is_refused_before_the_sweep(tasks, tmp_path):
    for path in (tmp_path, tmp_path / "no folder" / "j.jsonl"):
        with pytest.raises(ns.InvalidInput, match="cannot be used"):
            ns.sweep(tasks.product, AXES, journal=path, progress=False)


SCRIPT = """
import functools, sys
import nonsmooth as ns
module, folder, workers = sys.argv[1:]
task = functools.partial(__import__(module).counted, folder=folder, seconds=0.05)

if __name__ == "__main__":
    ns.sweep(task, {"x": range(1, 7), "y": range(10)}, journal=folder + "/j.jsonl", workers=int(workers), batch=2)
"""


@pytest.mark.parametrize("workers", (1, 2))
def test_a_program_killed_outright_resumes_where_it_was(tasks, tmp_path, entries, workers):
    script, journal = tmp_path / "script.py", tmp_path / "j.jsonl"
    script.write_text(SCRIPT)
    arguments = [sys.executable, str(script), tasks.__name__, str(tmp_path), str(workers)]
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join([str(tmp_path), *filter(None, sys.path)])}
    program = subprocess.Popen(arguments, env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    deadline = time.monotonic() + 60
    while time.monotonic() < deadline and (not journal.exists() or len(journal.read_bytes().splitlines()) < 10):
        time.sleep(0.02)
    program.send_signal(signal.SIGKILL)
    program.wait()
    time.sleep(0.5)  # its workers notice, and end after the batch they are in
    finished, called = len(entries(journal)), len(calls(tmp_path))
    assert 9 <= finished < 60
    task = functools.partial(tasks.counted, folder=str(tmp_path), seconds=0.05)
    axes = {"x": range(1, 7), "y": range(10)}
    found = ns.sweep(task, axes, journal=journal, progress=False)
    assert found.attrs["cells_from_journal"] == finished
    assert len(calls(tmp_path)) == called + 60 - finished
    xr.testing.assert_equal(found, ns.sweep(tasks.product, axes, progress=False))


INTERRUPTED = """
import functools, sys
import nonsmooth as ns
module, folder, workers = sys.argv[1:]
task = functools.partial(__import__(module).slow_product, seconds=0.2)

if __name__ == "__main__":
    found = ns.sweep(task, {"x": range(1000), "y": [1]}, journal=folder + "/j.jsonl", workers=int(workers), batch=1)
    print(found.attrs["interrupted"], int((found.status == ns.CellStatus.FINISHED).sum()), flush=True)
"""


@pytest.mark.parametrize("workers", (1, 2))
def test_control_c_returns_what_is_finished(tasks, tmp_path, entries, workers):
    script, journal = tmp_path / "script.py", tmp_path / "j.jsonl"
    script.write_text(INTERRUPTED)
    arguments = [sys.executable, str(script), tasks.__name__, str(tmp_path), str(workers)]
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join([str(tmp_path), *filter(None, sys.path)])}
    program = subprocess.Popen(arguments, env=environment, stdout=subprocess.PIPE, text=True, start_new_session=True)
    deadline = time.monotonic() + 60
    while time.monotonic() < deadline and (not journal.exists() or len(journal.read_bytes().splitlines()) < 4):
        time.sleep(0.02)
    os.killpg(program.pid, signal.SIGINT)  # a terminal sends it to the workers too
    printed, _ = program.communicate(timeout=60)
    interrupted, finished = map(int, printed.split())
    assert interrupted == 1 and 3 <= finished < 1000 and finished == len(entries(journal))


def test_a_refused_task_leaves_the_journal_alone(tasks, tmp_path):
    journal = tmp_path / "j.jsonl"
    ns.sweep(tasks.product, AXES, journal=journal, progress=False)
    before = journal.read_bytes()
    with pytest.raises(ns.InvalidInput, match="cannot be pickled"):
        ns.sweep(lambda x, y: x, AXES, journal=journal, resume=False, workers=2, progress=False)
    assert journal.read_bytes() == before
