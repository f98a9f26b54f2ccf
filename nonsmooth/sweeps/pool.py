"""Worker processes of this machine that are replaced when they die.

A thread for each worker hands it one call after another. When the process dies, only the call that it ran fails, with
`WorkerDied`; the thread starts another process for the next call. (A pool of `concurrent.futures` breaks as a whole.)
"""

from __future__ import annotations

import contextlib
import functools
import multiprocessing
import os
import pickle
import queue
import signal
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, Future
from typing import Any

from nonsmooth.checks.arrays import as_count
from nonsmooth.errors import InvalidInput, NonsmoothError

MOST_WORKERS = 1024  # chosen: more processes than this are a slip of the pen
WORKER_START_TIME = 60.0  # chosen: s for a fresh interpreter to answer
READY, BEGUN = b"ready", b"begun"
SAFE_PATH = "PYTHONSAFEPATH"  # defined: by Python, whose option -P it is


class WorkerDied(NonsmoothError, RuntimeError):
    """The process that ran a call ended before the call did."""


class WorkerTimedOut(NonsmoothError, TimeoutError):
    """A call took longer than it was given; its process was ended."""


def as_workers(workers: Any) -> int:
    """A number of processes or threads that a machine can run, or `InvalidInput`."""
    if as_count("workers", workers) > MOST_WORKERS:
        raise InvalidInput(f"workers must be a whole number of at most {MOST_WORKERS}; got {workers}")
    return int(workers)


class LocalPool(Executor):
    """Processes on this machine.

    Parameters
    ----------
    workers : int
        Their number.

    Raises
    ------
    InvalidInput
        Unless ``workers`` is a whole number of at least 1.
    """

    def __init__(self, workers: int) -> None:
        self._max_workers = as_workers(workers)
        self._calls: queue.SimpleQueue[Any] = queue.SimpleQueue()
        self._workers = [_Worker() for _ in range(self._max_workers)]
        self._is_closed = False
        self._threads = [threading.Thread(target=self._serve, args=(w,), daemon=True) for w in self._workers]
        for thread in self._threads:
            thread.start()

    @property
    def pids(self) -> list[int]:
        """Process numbers of the workers that run."""
        processes = [worker.process for worker in self._workers]
        return [process.pid for process in processes if process and process.pid and process.is_alive()]

    def submit(self, function: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        """Call ``function(*args, **kwargs)`` in a worker."""
        return self.submit_within(None, function, *args, **kwargs)

    def submit_within(
        self, seconds: float | None, function: Callable[..., Any], /, *args: Any, **kwargs: Any
    ) -> Future[Any]:
        """The same with an end: the worker is killed when the call takes longer than this, once its code is loaded."""
        if self._is_closed:
            raise RuntimeError("the pool is closed")
        future: Future[Any] = Future()
        self._calls.put((future, seconds, pickle.dumps((function, args, kwargs))))
        return future

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """End the workers; with ``cancel_futures`` at once, whatever they run."""
        self._is_closed = True
        if cancel_futures:
            while not self._calls.empty():
                self._calls.get()[0].cancel()
        for _ in self._threads:
            self._calls.put(None)
        if cancel_futures:
            for worker in self._workers:
                worker.end()
        for thread in self._threads if wait else ():
            thread.join()

    def _serve(self, worker: _Worker) -> None:
        if hasattr(signal, "pthread_sigmask"):  # a process that is starting gets no Ctrl-C either, which goes to all
            signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
        while (call := self._calls.get()) is not None:
            future, seconds, payload = call
            if not future.set_running_or_notify_cancel():
                continue
            try:
                is_good, result = worker.call(payload, seconds)
            except BaseException as error:
                future.set_exception(error)
            else:
                (future.set_result if is_good else future.set_exception)(result)
        worker.close()


class _Worker:
    """One process and the pipe to it. Its own thread does everything but `end`."""

    def __init__(self) -> None:
        self.process: Any = None
        self.pipe: Any = None
        self._starting = threading.Lock()
        self._is_ended = False

    def call(self, payload: bytes, seconds: float | None) -> tuple[bool, Any]:
        """(True, result) or (False, exception) of the call."""
        if self.process is None or not self.process.is_alive():
            self._start()
        try:
            self.pipe.send_bytes(payload)
            self.pipe.recv_bytes()  # BEGUN: what the call imports and compiles is there, now its time runs
            answer = self.pipe.recv_bytes() if self.pipe.poll(seconds) else None
        except (EOFError, OSError):
            self.process.join()
            raise WorkerDied(f"the worker process ended {_how(self.process.exitcode)}") from None
        if answer is None:
            self.kill()
            raise WorkerTimedOut(f"not done within {seconds:g} s")
        return pickle.loads(answer)

    def _start(self) -> None:
        self._spawn()
        try:
            if self.pipe.poll(WORKER_START_TIME) and self.pipe.recv_bytes() == READY:
                return
        except (EOFError, OSError):
            self.process.join()
            if self.process.exitcode < 0:
                raise WorkerDied(f"the worker process ended {_how(self.process.exitcode)} while it started") from None
        self.kill()
        raise InvalidInput(
            "the worker processes could not start; a script that uses them must guard its own start with "
            "`if __name__ == '__main__':`"
        )

    def _spawn(self) -> None:
        context = multiprocessing.get_context("spawn")
        pipe, theirs = context.Pipe()
        with self._starting:  # a process half started can be neither killed nor left behind
            if self._is_ended:
                raise WorkerDied("the pool was closed before the worker process started")
            with _safe_path() as before:
                process = context.Process(target=_work, args=(theirs, before), daemon=True)
                process.start()
            self.process, self.pipe = process, pipe
        theirs.close()

    def end(self) -> None:
        """From another thread: the process dies at once and no other is started."""
        with self._starting:
            self._is_ended = True
            if self.process is not None:
                self.process.kill()

    def kill(self) -> None:
        """End the process at once."""
        if self.process is not None:
            self.process.kill()
            self.process.join()

    def close(self) -> None:
        """Let the process go: it ends when its pipe does."""
        if self.process is not None:
            self.pipe.close()
            self.process.join()


@contextlib.contextmanager
def _safe_path() -> Iterator[str | None]:
    """Processes that are started here do not search the working folder: what they import before they have the path of
    this one would be taken from there. What the option was before is handed on."""
    with _path_lock:
        before = os.environ.get(SAFE_PATH)
        os.environ[SAFE_PATH] = "1"
        try:
            yield before
        finally:
            _set_safe_path(before)


_path_lock = threading.Lock()


def _set_safe_path(value: str | None) -> None:
    """Set the option, or remove it."""
    os.environ.pop(SAFE_PATH, None)
    if value is not None:
        os.environ[SAFE_PATH] = value


def _how(exit_code: int) -> str:
    return f"by the signal {signal.Signals(-exit_code).name}" if exit_code < 0 else f"with the exit code {exit_code}"


def _work(pipe: Any, safe_path: str | None) -> None:
    """The life of a worker process: calls in, results out, until the pipe ends."""
    _set_safe_path(safe_path)
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is the parent's to handle
    pipe.send_bytes(READY)
    while True:
        try:
            payload = pipe.recv_bytes()
        except (EOFError, OSError):
            return
        call = _loaded(payload)
        pipe.send_bytes(BEGUN)
        pipe.send_bytes(_answer(call))


def _loaded(payload: bytes) -> Callable[[], Any]:
    """The call, or one that raises why it could not be loaded."""
    try:
        function, args, kwargs = pickle.loads(payload)
        return functools.partial(function, *args, **kwargs)
    except Exception as error:
        return functools.partial(_raise, error)


def _raise(error: Exception) -> None:
    raise error


def _answer(call: Callable[[], Any]) -> bytes:
    try:
        return pickle.dumps((True, call()))
    except Exception as error:
        try:
            pickle.loads(pickle.dumps(error))
            return pickle.dumps((False, error))
        except Exception:
            return pickle.dumps((False, RuntimeError(f"{type(error).__name__}: {error}")))
