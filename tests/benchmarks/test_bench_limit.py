"""The parts that ``benchmarks limit`` removes are parts: without them the rod moves the same, and they are gone."""

from __future__ import annotations

import math

import numpy as np
import pytest

import nonsmooth as ns
from benchmarks.core_scenes import sliding_rod
from benchmarks.limit import PART_NAMES, Without

TH = math.pi / 3
BOOKS = [part for part in PART_NAMES if "rounding" not in part]  # the parts that change no number of the motion


def slid(*parts):
    start = [0, math.sin(TH), TH], [1, 0, 0]
    return ns.simulate(sliding_rod(), (0, 0.02), *start, integrator=Without(dt=1e-3, parts=parts))


@pytest.fixture(autouse=True)
def _interpreted(monkeypatch):
    """The source: no variant is compiled here."""
    monkeypatch.setenv("NONSMOOTH_INTERPRET", "1")


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
