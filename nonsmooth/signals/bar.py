"""A bar that grows while a calculation goes on: in a terminal and in a notebook, by tqdm; nothing in a pipe."""

from __future__ import annotations

import contextlib
import math
import shutil
import sys
import time
import warnings
from collections.abc import Callable, Iterator
from typing import Any, TextIO

from nonsmooth.signals.pace import Pace, duration

BAR_PERIOD = 0.2  # chosen: s between two looks of a bar
LAYOUT = "{percentage:3.0f}%|{bar}| {desc}"  # defined: of tqdm; how long is left we say ourselves


class Bar:
    """A bar from 0 to 1 with some words behind it; nothing where nobody would see it.

    Parameters
    ----------
    stream : file, optional
        The standard error when left out. In a notebook the bar is a widget of the cell, or a line where ipywidgets is
        not there.
    """

    def __init__(self, stream: TextIO | None = None) -> None:
        self.stream = sys.stderr if stream is None else stream
        self.is_seen = is_watched(self.stream)
        self._bar: Any = None

    def show(self, part: float, words: str) -> None:
        """The part that is done, and what is said of it."""
        if not self.is_seen:
            return
        if self._bar is None:
            self._bar = bar_class()(total=1.0, file=self.stream, bar_format=LAYOUT, leave=False, **room())
        self._bar.n = min(1.0, max(0.0, part))
        self._bar.set_description_str(words, refresh=True)

    def close(self) -> None:
        """Take it away."""
        if self._bar is not None:
            self._bar.close()
            self._bar = None


def is_watched(stream: TextIO) -> bool:
    """Whether a person looks at the stream: in a terminal, or below the cell of a notebook."""
    return stream.isatty() or (stream is sys.stderr and in_notebook())


def in_notebook() -> bool:
    """Whether this process is the kernel of a notebook."""
    ipython = sys.modules.get("IPython")
    shell = None if ipython is None else ipython.get_ipython()
    return shell is not None and hasattr(shell, "kernel")


def room() -> dict[str, int]:
    """Columns and lines for a bar: as usual where a terminal does not say how many it has; a widget knows by itself."""
    columns, lines = shutil.get_terminal_size()
    return {} if in_notebook() else {"ncols": columns - 1, "nrows": lines}


def bar_class() -> Any:
    """The bar for this place."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # where ipywidgets is not there, the bar is a line
        from tqdm.auto import tqdm
    return tqdm


@contextlib.contextmanager
def heard(progress: Callable[[float], None] | bool | None) -> Iterator[Callable[[float], None] | None]:
    """Give the function that hears the progress of a run: one of the user, a bar, or none."""
    if not isinstance(progress, bool):
        yield progress
    elif progress:
        with bar_of("the run") as hear:
            yield hear
    else:
        yield None


@contextlib.contextmanager
def bar_of(what: str, stream: TextIO | None = None) -> Iterator[Callable[[float], None]]:
    """A function of the part that is done, which shows it as "what, 12 s left" behind a bar."""
    bar, pace, shown_at = Bar(stream), Pace(), -math.inf

    def hear(part: float) -> None:
        nonlocal shown_at
        now = time.perf_counter()
        left = pace.left(part, now)
        if now - shown_at >= BAR_PERIOD:
            shown_at = now
            bar.show(part, f"{what}, {duration(left)} left" if math.isfinite(left) else what)

    try:
        yield hear
    finally:
        bar.close()
