"""``nonsmooth``, and ``python -m nonsmooth``, as a program of its own."""

from __future__ import annotations

import importlib
import os
import signal
import sys
from typing import NoReturn

from nonsmooth.errors import INTERRUPTED


def nonsmooth() -> NoReturn:
    """``nonsmooth``, with BLAS on one thread unless the environment says otherwise: a process that soon ends spends
    0.1 s of the processor on threads that wait for one another."""
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # read as numpy is imported
    program("nonsmooth.commands.cli")


def program(home: str) -> NoReturn:
    """Run the command line whose ``main`` is in a module. After Ctrl-C the process ends at once: taking compiled code
    down takes some 0.3 s. It may come as early as among the imports, or when all is done and said: then it is ignored,
    as the system would end the process without a word or its code."""
    try:
        code = importlib.import_module(home).main()
    except KeyboardInterrupt:
        print("nonsmooth: interrupted", file=sys.stderr)
        code = INTERRUPTED
    if code == INTERRUPTED:
        end_at_once()
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    raise SystemExit(code)


def end_at_once() -> NoReturn:
    """Without taking anything down."""
    try:
        sys.stdout.flush()
    finally:
        os._exit(INTERRUPTED)


if __name__ == "__main__":
    nonsmooth()
