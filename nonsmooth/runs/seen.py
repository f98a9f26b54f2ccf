"""Who looks at a run while it goes on: a progress function, a bar, a browser that shows its bodies."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager
from importlib.util import find_spec
from typing import Any

from nonsmooth.errors import MissingExtra
from nonsmooth.signals.bar import heard
from nonsmooth.views import view

Hear = Callable[[float], None]


@contextmanager
def looked_at(run: Any, progress: Hear | bool | None, is_live: bool) -> Iterator[Hear | None]:
    """What a run calls with the fraction done; nothing where nobody looks."""
    with heard(progress) as hear:
        if not is_live:
            yield hear
            return
        with closing(view(run, "live")(run)) as window:
            yield lambda part: tell_both(window, hear, part)


def tell_both(window: Any, hear: Hear | None, part: float) -> None:
    """The browser first, then who hears."""
    window.look()
    if hear is not None:
        hear(part)


def require_live() -> None:
    """Raise `MissingExtra` where the library of the live view is not installed, before anything is compiled."""
    if find_spec("viser") is None:
        raise MissingExtra('a live view needs viser; install it with pip install "nonsmooth[live]"')
