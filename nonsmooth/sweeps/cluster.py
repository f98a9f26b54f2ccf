"""Dask distributed as an executor: one address, and the batches go to its workers."""

from __future__ import annotations

from concurrent.futures import Executor
from typing import Any

from nonsmooth.errors import InvalidInput, MissingExtra

SCHEDULER_PATIENCE = 10.0  # chosen: s for the scheduler to answer


def connect(address: str) -> tuple[Executor, int, Any]:
    """An executor on a Dask cluster, its number of threads, and the client to close.

    Raises
    ------
    MissingExtra
        When distributed is not installed.
    InvalidInput
        When no scheduler answers at the address, or it has no worker.
    """
    try:
        from distributed import Client
    except ImportError:
        raise MissingExtra('a scheduler needs distributed; pip install "nonsmooth[cluster]" brings it') from None
    try:
        client = Client(address, timeout=SCHEDULER_PATIENCE, set_as_default=False)
    except (OSError, ValueError) as error:  # TimeoutError is an OSError
        raise InvalidInput(
            f"no Dask scheduler answers at {address!r} within {SCHEDULER_PATIENCE:g} s ({type(error).__name__}); start "
            "one with `dask scheduler`, and workers with `dask worker ADDRESS`"
        ) from None
    threads = sum(client.ncores().values())
    if threads == 0:
        client.close()
        raise InvalidInput(f"the Dask scheduler at {address!r} has no workers; start some with `dask worker {address}`")
    return client.get_executor(pure=False), threads, client
