"""BLAS on one thread while somebody asks for it, and as before when the last one has left."""

from __future__ import annotations

import threading

import pytest
import scipy.linalg  # noqa: F401  the library whose threads are looked at
from threadpoolctl import threadpool_info, threadpool_limits

from nonsmooth.numerics.one_blas_thread import one_blas_thread


def numbers() -> list[int]:
    return [library["num_threads"] for library in threadpool_info() if library["user_api"] == "blas"]


@pytest.fixture(autouse=True)
def two_threads():
    with threadpool_limits(limits=2, user_api="blas"):
        if set(numbers()) != {2}:
            pytest.skip("this BLAS has one thread")
        yield


def test_it_is_one_inside_and_what_it_was_outside():
    with one_blas_thread():
        assert set(numbers()) == {1}
        with one_blas_thread():
            assert set(numbers()) == {1}
        assert set(numbers()) == {1}
    assert set(numbers()) == {2}


def test_an_exception_restores_it():
    with pytest.raises(ValueError, match="on purpose"), one_blas_thread():
        raise ValueError("on purpose")
    assert set(numbers()) == {2}


def test_threads_that_leave_in_the_order_in_which_they_came():
    """Each restoring what it found would leave one thread for ever."""
    first_left, second_in = threading.Event(), threading.Event()

    def second() -> None:
        with one_blas_thread():
            second_in.set()
            assert first_left.wait(10)

    thread = threading.Thread(target=second)
    with one_blas_thread():
        thread.start()
        assert second_in.wait(10)
        assert set(numbers()) == {1}
    first_left.set()
    thread.join(10)
    assert not thread.is_alive()
    assert set(numbers()) == {2}
