"""What the tests of checkpoints share."""

import os
from dataclasses import asdict

import numpy as np
import pytest

from nonsmooth.runs import streaming
from nonsmooth.runs.system_run import SystemRun

COLUMNS = ("t", "q", "u", "g_N", "P_N", "P_F", "mode", "slip", "event_rows")


def all_bits(solution):
    """All that a run computed, as bytes."""
    arrays = {name: np.ascontiguousarray(getattr(solution, name)).tobytes() for name in COLUMNS}
    if solution.la is not None:
        arrays["la"] = np.ascontiguousarray(solution.la).tobytes()
    ledger = {name: np.ascontiguousarray(column).tobytes() for name, column in solution.ledger.items()}
    stats = {name: value for name, value in asdict(solution.stats).items() if not name.endswith("_time")}
    return arrays | ledger | stats | {"message": solution.message, "about": solution.about}


@pytest.fixture
def bits():
    """``bits(solution)``: all that a run computed."""
    return all_bits


@pytest.fixture
def small(monkeypatch):
    """Windows of some 20 records, and stops after 19 steps: between two records, too; nothing waits for the disk."""
    monkeypatch.setattr(streaming, "WINDOW", 4096)
    monkeypatch.setattr(SystemRun, "first_block", 19)
    monkeypatch.setattr(os, "fsync", lambda file: None)
