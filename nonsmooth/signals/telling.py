"""The progress of a long calculation: reported where it is known, heard where somebody shows it.

Between the two may stand many calls that know of neither: a study listens, and the loops of the runs and searches
within it report. Where nobody listens nothing is done.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator
from contextvars import ContextVar

Hear = Callable[[float], None]
_hear: ContextVar[Hear | None] = ContextVar("hear", default=None)


@contextlib.contextmanager
def listening(hear: Hear | None) -> Iterator[None]:
    """Have ``hear`` called with the part done, in [0, 1], of what is calculated in the block, in this thread."""
    token = _hear.set(hear)
    try:
        yield
    finally:
        _hear.reset(token)


def listener() -> Hear | None:
    """Who listens."""
    return _hear.get()


def tell(part: float) -> None:
    """Say which part is done."""
    hear = _hear.get()
    if hear is not None:
        hear(part)


@contextlib.contextmanager
def tell_in_parts(n: int) -> Iterator[None]:
    """Hand on as one whole what is reported in the block from 0 to 1, n times over."""
    hear, done, before = _hear.get(), 0, 0.0

    def hear_part(part: float) -> None:
        nonlocal done, before
        done, before = done + (part < before), part
        if hear is not None:
            hear(min(1.0, (done + part) / n))

    with listening(None if hear is None else hear_part):
        yield
