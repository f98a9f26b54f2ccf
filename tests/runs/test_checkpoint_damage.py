"""Damage in a checkpoint: rows of its state are refused by name; rows behind it, which a power failure takes, are not
shown and computed again."""

import os
import re

import numpy as np
import pytest

import nonsmooth as ns
from models import BouncingBall
from nonsmooth.results import checkpoint as store
from nonsmooth.results.checked_array import BLOCK, CheckedArray, checksums_of, verified_rows
from nonsmooth.results.growing_array import GrowingArray, map_rows, rows_at

BALL = BouncingBall(e=0.8)
RUN = (BALL, (0, 1), *BALL.state(height=0.1))
STEP = dict(integrator=ns.MoreauJean(1e-3), every=3)
ROW = np.dtype([("t", "<f8"), ("mode", "<i8")])


@pytest.fixture
def path(small, tmp_path):
    """A checkpoint of a run that was stopped between two records, after some events."""
    ns.simulate(*RUN, **STEP, checkpoint=tmp_path / "run.ckpt", max_steps=500, on_failure="return")
    return tmp_path / "run.ckpt"


def readers(path):
    return (lambda: ns.Solution.load(path), lambda: ns.simulate(*RUN, **STEP, resume=path))


def change(file, place, by=1):
    content = bytearray(file.read_bytes())
    content[place] ^= by
    file.write_bytes(content)


def refusals(path):
    for read in readers(path):
        with pytest.raises(ns.InvalidInput, match="damaged") as refusal:
            read()
        yield str(refusal.value)


ROWS = store.layout_of(store.Shape(1, 1, 1, 0, False)).rows


@pytest.mark.parametrize(("name", "row"), [(f"{name}.npy", row) for name, row in ROWS.items()])
@pytest.mark.parametrize("part", [0.0, 0.3, 0.99])
def test_an_edited_number_is_refused_wherever_it_stands(path, name, row, part):
    start, size = rows_at(row), (path / name).stat().st_size
    change(path / name, int(start + part * (size - start)))
    for said in refusals(path):
        assert re.search(rf"{name}: of its first \d+ rows \d+ are not what was written", said)


@pytest.mark.parametrize("name", ["records.npy", "events.npy", "records.crc.npy", "events.crc.npy"])
def test_a_header_that_changed_and_a_file_that_is_lost_are_refused(path, name):
    whole = (path / name).read_bytes()
    names = whole.index(b"descr") + 12
    change(path / name, names)
    assert all(name.partition(".")[0] in said for said in refusals(path))
    (path / name).unlink()
    assert all(name in said for said in refusals(path))


def test_a_number_of_rows_that_was_lowered_is_noticed_to_the_row_at_which_the_run_stopped(path):
    """That row belongs to no record yet, but to what the run said when it stopped."""
    shown = len(ns.Solution.load(path).t)
    content = (path / "records.npy").read_bytes()
    (path / "records.npy").write_bytes(content.replace(b"(%d,)" % shown, b"(%d,)" % (shown - 1)))
    assert all("are not what was written, or are not there" in said for said in refusals(path))


def test_a_state_that_changed_is_refused(path):
    size = (path / store.STATE).stat().st_size
    for place in range(40, size, size // 20):
        change(path / store.STATE, place)
        assert all("checksum" in said or "no seal" in said for said in refusals(path))
        change(path / store.STATE, place)
    assert not ns.Solution.load(path).success


def running(path, monkeypatch):
    """A checkpoint whose last state was kept after some records, and which has more of them, as after a kill."""
    keep, calls = store.Checkpoint.keep, []

    def killed(self, *given):
        calls.append(1)
        if len(calls) == 12:
            raise MemoryError
        if len(calls) < 8:
            keep(self, *given)

    with monkeypatch.context() as patch, pytest.raises(MemoryError):
        patch.setattr(store.Checkpoint, "keep", killed)
        ns.simulate(*RUN, **STEP, checkpoint=path, checkpoint_every=0)
    return store.read_state(path)[0]["records"]


def test_rows_that_a_power_failure_took_are_not_shown_and_computed_again(small, tmp_path, monkeypatch, bits):
    """The number of rows reached the disk and the rows did not: zeros stand in their place."""
    path = tmp_path / "run.ckpt"
    kept = running(path, monkeypatch)
    whole = ns.simulate(*RUN, **STEP)
    rows = len(ns.Solution.load(path).t)
    assert rows > kept + 5
    content = bytearray((path / "records.npy").read_bytes())
    row = store.layout_of(store.Shape(1, 1, 1, 0, False)).rows["records"]
    start = rows_at(row) + (rows - 3) * row.itemsize
    content[start:] = bytes(len(content) - start)
    (path / "records.npy").write_bytes(content)
    shown = ns.Solution.load(path)
    assert kept <= len(shown.t) <= rows - 3 and (shown.q == whole.q[: len(shown.q)]).all()
    assert bits(ns.simulate(*RUN, **STEP, resume=path)) == bits(whole)


@pytest.mark.parametrize(("place", "act"), [(os, "replace"), (GrowingArray, "cut"), (store.Checkpoint, "write")])
def test_a_program_that_dies_where_a_stopped_run_is_taken_up_leaves_a_whole_checkpoint(
    path, monkeypatch, bits, place, act
):
    """The row at which it stopped is forgotten in two writes: that of the state, and that of the number of rows."""
    stopped = ns.Solution.load(path)

    def dies(*_, **__):
        raise MemoryError

    with monkeypatch.context() as patch, pytest.raises(MemoryError):
        patch.setattr(place, act, dies)
        ns.simulate(*RUN, **STEP, resume=path)
    read = ns.Solution.load(path)
    assert len(read.t) == len(stopped.t) - (act == "write") and (read.q == stopped.q[: len(read.q)]).all()
    assert bits(ns.simulate(*RUN, **STEP, resume=path)) == bits(ns.simulate(*RUN, **STEP))


def rows_from(first, count):
    return np.array([(0.1 * k, k % 3) for k in range(first, first + count)], ROW)


@pytest.fixture
def grown(tmp_path):
    """Blocks of 3, 1 and 5 rows, of which the last is one that will be written over."""
    array = CheckedArray(tmp_path / "rows.npy", ROW, 0)
    for first, count in ((0, 3), (3, 1)):
        array.append(rows_from(first, count))
    array.show(rows_from(4, 5))
    array.close()
    return tmp_path / "rows.npy"


def test_rows_are_verified_block_by_block_to_the_first_that_does_not_fit(grown):
    assert verified_rows(grown, ROW) == 9
    for row, verified in ((8, 4), (3, 3), (0, 0)):
        change(grown, rows_at(ROW) + row * ROW.itemsize)
        assert verified_rows(grown, ROW) == verified
    assert map_rows(checksums_of(grown), BLOCK)["end"].tolist() == [3, 4, 9]


def test_a_block_that_is_shown_is_written_over_by_the_next_one(grown):
    array = CheckedArray(grown, ROW, 4)
    assert len(map_rows(grown, ROW)) == verified_rows(grown, ROW) == 4
    array.append(rows_from(4, 2))
    array.append(rows_from(6, 1))
    array.close()
    assert verified_rows(grown, ROW) == 7 and (np.load(grown) == rows_from(0, 7)).all()


def test_a_file_with_fewer_bytes_than_its_header_says_is_refused(grown):
    os.truncate(grown, grown.stat().st_size - 1)
    with pytest.raises(ValueError, match="it says that it has 9 rows, which is more than its .* bytes hold"):
        map_rows(grown, ROW)
