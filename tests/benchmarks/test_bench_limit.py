"""The parts that ``benchmarks limit`` removes are parts: without them the rod moves the same, and they are gone."""

from __future__ import annotations

import math
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

import nonsmooth as ns
from benchmarks import limit
from benchmarks.core_scenes import sliding_rod
from benchmarks.limit import PART_NAMES, Without
from models import BeltOscillator

TH = math.pi / 3
BOOKS = [part for part in PART_NAMES if "rounding" not in part]  # the parts that change no number of the motion


def slid(*parts):
    start = [0, math.sin(TH), TH], [1, 0, 0]
    return ns.simulate(sliding_rod(), (0, 0.02), *start, integrator=Without(dt=1e-3, parts=parts))


@pytest.fixture(autouse=True)
def _interpreted(monkeypatch):
    """The source: no variant is compiled here."""
    monkeypatch.setenv("NONSMOOTH_INTERPRET", "1")


@pytest.mark.skipif(shutil.which("gcc") is None, reason="no GCC")
def test_belts_side_by_side_end_where_each_of_them_ends(tmp_path, monkeypatch):
    """At eight speeds, among them such that stick and such that slip at one time."""
    monkeypatch.delenv("NONSMOOTH_INTERPRET")
    source, program = Path(limit.__file__).with_name("belt_lanes.c"), tmp_path / "lanes"
    subprocess.run(["gcc", "-O2", "-DLANES=8", str(source), "-o", str(program), "-lm"], check=True)
    printed = subprocess.run([program, "20000", "1e-3"], capture_output=True, text=True, check=True).stdout
    for speed, x in zip(limit.BELT_SPEEDS, map(float, printed.split()[1:]), strict=True):
        belt = BeltOscillator(vb=speed)
        run = ns.simulate(belt, (0, 20), [0.0], [0.0], integrator=ns.MoreauJean(1e-3), every=20_000)
        assert abs(run.q[-1, 0] - x) < 1e-11, speed


def test_a_rod_slides_to_the_same_bits_without_its_books():
    whole = slid()
    for part in BOOKS:
        assert slid(part).q.tobytes() == whole.q.tobytes(), part
    assert np.abs(slid(*PART_NAMES).q - whole.q).max() < 1e-14


def test_a_part_that_is_removed_is_not_done():
    assert slid().ledger["friction"][-1] < 0.0
    assert not slid("energy ledger").ledger["friction"].any()


def test_parts_that_are_not_removed_are_those_of_the_step():
    without = slid("look for NaN")
    assert without.ledger["friction"].tobytes() == slid().ledger["friction"].tobytes()
