"""The benchmark of stability follows the branch that it times."""

import pytest

from benchmarks import stability
from benchmarks.command import main


@pytest.mark.upkeep
def test_branch_that_is_timed_ends_its_stick_once(monkeypatch, capsys):
    monkeypatch.setattr(stability, "REPEATS", 1)
    monkeypatch.setattr(stability, "VALUES", 2)
    monkeypatch.setattr(stability, "SPEEDS", (0.39, 0.398))
    assert main(["stability"]) == 0
    out = capsys.readouterr().out
    assert "cycles found: 2" in out and out.count("stick ends at vb = 0.394544584") == 1
    assert out.count("mode coupling") == 2 and out.count("belt oscillator") == 2


def test_shown_call_returns_its_result(capsys):
    assert stability.show("nothing", lambda: 3) == 3
    cpu, wall = map(float, capsys.readouterr().out.split()[-2:])
    assert cpu == pytest.approx(0, abs=1e-3) and wall == pytest.approx(0, abs=1e-2)
