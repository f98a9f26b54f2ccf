"""Random command lines: each ends with a code of ours, in words of ours, and within half a second of Ctrl-C."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

LINES = Path(__file__).with_name("random_commands.py")
PROMPT = 0.5  # s
SLOW_MACHINE = 2.0  # s, where others share the machine


@pytest.mark.upkeep
@pytest.mark.skipif(sys.platform == "win32", reason="forks")
@pytest.mark.parametrize(
    ("seed", "n"), [(1, 40), pytest.param(2, 1000, marks=pytest.mark.slow)], ids=["40", "1000"]
)  # fmt: skip
def test_no_random_command_line_ends_in_foreign_words(tmp_path, seed, n):
    run = subprocess.run(
        [sys.executable, str(LINES), str(seed), str(n), str(tmp_path)], capture_output=True, text=True, check=True
    )
    *foreign, counts = map(json.loads, run.stdout.splitlines())
    assert foreign == []
    assert sum(counts["codes"].values()) == n and min(counts["codes"]["0"], counts["codes"]["2"]) > 0.1 * n
    assert counts["after_ctrl_c"] < (PROMPT if n < 100 else SLOW_MACHINE)
