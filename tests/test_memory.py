"""What does not fit into memory is refused before it is allocated."""

import pytest

import nonsmooth as ns
from nonsmooth.memory import GIB, free_memory, require_memory


def test_free_memory_is_positive_and_below_an_exbibyte():
    assert 0 < free_memory() < 2**60


def test_more_than_is_free_is_refused_with_both_figures_and_the_cure():
    with pytest.raises(ns.InvalidInput, match=r"the rows need \S+ GiB and \S+ GiB are free; write less"):
        require_memory(free_memory() + 2 * GIB, "the rows", "write less")


def test_little_is_granted_without_asking(monkeypatch):
    monkeypatch.setattr("nonsmooth.memory.free_memory", lambda: 0.0)
    require_memory(1e6, "the rows", "write less")
