"""Matrices of some hundred rows on one thread of BLAS.

The threads of OpenBLAS wait for one another in a loop. At these sizes they save little, and where other work runs on
the machine they cost much: a friction problem with 52 contacts (14 factors of 156 rows) takes 2.4 ms of the processor
on one thread, 15 on two, and 30 to 1100 on two that others use too. Rounding depends on their number.
"""

from __future__ import annotations

import functools
from contextlib import AbstractContextManager
from typing import Any


def one_blas_thread() -> AbstractContextManager[Any]:
    """A context in which BLAS runs on one thread; afterwards on as many as before. It takes 20 us.

    Where several threads ask at once the first one decides for all, and the others change nothing.
    """
    limit: AbstractContextManager[Any] = _controller().limit(limits=1, user_api="blas")
    return limit


@functools.cache
def _controller() -> Any:
    """What knows the libraries of this process; LAPACK is loaded first."""
    import scipy.linalg  # noqa: F401
    from threadpoolctl import ThreadpoolController

    return ThreadpoolController()
