"""Ladders of contact solvers are compared on the same problems, and who leaves one is named."""

import numpy as np
import pytest

from benchmarks import ladder
from benchmarks.problems import assembly, packing, uneven
from nonsmooth.contact.blocks.ladder import from_inside
from nonsmooth.contact.blocks.nsgs import NSGS


def test_a_table_has_a_row_for_each_ladder_and_names_what_one_of_them_leaves():
    cases = [
        ("loose", assembly(np.random.default_rng(3), 6, 2)),
        ("pile", packing(np.random.default_rng([7, 80, 3]), 80, 3)),
    ]
    ladders = {"sweeps": lambda problem: [NSGS(max_sweeps=100)], "inside": lambda problem: from_inside(0.3)}
    lines = list(ladder.section("two", cases, ladders))
    rows = [[cell.strip() for cell in line.split("|")[1:3]] for line in lines if line.startswith("| ")]
    assert rows == [["ladder", "solved"], ["sweeps", "1"], ["inside", "2"]]
    (left,) = [line for line in lines if "left at" in line]
    assert left.startswith("\npile: left at") and "by sweeps" in left and "by inside" not in left


@pytest.mark.parametrize("case", [
    uneven(np.random.default_rng([11, 20, 2]), 20, 2), uneven(np.random.default_rng([15, 40, 3]), 40, 3),
])  # fmt: skip
def test_pivoting_is_on_the_ladder_for_what_sweeps_and_interior_points_leave(case):
    ends = {name: ladder.ascend(case, ladder.LADDERS[name]) for name in ("inside", "auto")}
    assert ends["inside"].error > 1e-3 and ends["auto"].error <= ladder.TOLERANCE


def test_every_set_gives_the_same_problems_again():
    for name in ("random", "heavy"):
        first, second = (next(iter(ladder.SETS[name]([]))) for _ in range(2))
        assert first[0] == second[0] and (first[1].c == second[1].c).all()
    assert sum(1 for _ in ladder.random([])) == 240 and len(ladder.LARGE) * len(ladder.LARGE_KINDS) == 35
