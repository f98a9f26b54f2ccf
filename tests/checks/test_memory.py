"""What does not fit into memory is refused before it is allocated."""

import math
import os
from pathlib import Path

import pytest

import nonsmooth as ns
from nonsmooth.checks.memory import GIB, free_memory, require_memory


def test_free_memory_is_positive_and_below_an_exbibyte():
    assert 0 < free_memory() < 2**60


def test_more_than_is_free_is_refused_with_both_figures_and_the_cure():
    with pytest.raises(ns.InvalidInput, match=r"the rows need \S+ GiB and \S+ GiB are free; write less"):
        require_memory(free_memory() + 2 * GIB, "the rows", "write less")


def test_little_is_granted_without_asking(monkeypatch):
    monkeypatch.setattr("nonsmooth.checks.memory.free_memory", lambda: 0.0)
    require_memory(1e6, "the rows", "write less")


def test_without_the_files_of_linux_the_memory_of_the_machine_counts(monkeypatch):
    def refuse(path):
        raise FileNotFoundError(path)

    monkeypatch.setattr(Path, "read_text", refuse)
    monkeypatch.setattr(os, "sysconf", {"SC_PHYS_PAGES": 1000, "SC_PAGE_SIZE": 4096}.__getitem__)
    assert free_memory() == 4096e3
    monkeypatch.setattr(os, "sysconf", refuse)
    assert free_memory() == math.inf
