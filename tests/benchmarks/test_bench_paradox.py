"""The benchmark of paradoxes times what it says."""

from benchmarks import paradox
from nonsmooth.paradox.classify import classify


def test_blocks_in_a_row_rest_in_one_way(monkeypatch, capsys):
    system = paradox.row_of_blocks(3)
    found = classify(system, 0.0, [0.0] * system.n_q, [0.0] * system.n_u)
    assert found.is_complete and [s.modes for s in found.solutions] == [("stick",) * 3]
    monkeypatch.setattr(paradox, "SIDE", 10)
    monkeypatch.setattr(paradox, "BLOCKS", (1, 2))
    assert paradox.main([]) == 0
    assert capsys.readouterr().out.count("map of 100 states") == 4
