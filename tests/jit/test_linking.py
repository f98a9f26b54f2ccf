"""Object code is linked and called without numba, and does the same."""

import os
import re
import subprocess
import sys

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.jit import cache, interpreted, kernel, kernels
from nonsmooth.jit.linking import Linked, function_at, linked
from nonsmooth.jit.object_code import ObjectCode, object_code
from nonsmooth.mechanics.compiled import model_of
from nonsmooth.mechanics.system import FORCE

pytestmark = pytest.mark.upkeep


@kernel("float64(int64, float64, boolean, float64[::1])")
def weighted(n, a, is_twice, x):
    """(2) a sum of the first n."""
    total = 0.0
    for i in range(n):
        total += x[i]
    return 2.0 * a * total if is_twice else a * total


@kernel("Tuple((int64, float64, boolean))(float64[::1], float64[::1])")
def compared(x, y):
    """Where they differ most, by how much, and whether they do."""
    k, most = 0, 0.0
    for i in range(x.shape[0]):
        if abs(x[i] - y[i]) > most:
            k, most = i, abs(x[i] - y[i])
    return k, most, most > 0.0


@kernel("float64(float64[:, ::1], int64, float64[::1])")
def product(A, i, x):
    """Row i of A x."""
    total = 0.0
    for k in range(A.shape[1]):
        total += A[i, k] * x[k]
    return total


@kernel("void(float64[::1])")
def halve(x):
    """x / 2, in place."""
    for i in range(x.shape[0]):
        x[i] *= 0.5


@kernel("int64(int64)")
def called_through_its_slot(n):
    """A call of another entry point."""
    return squared(n) + 1


@kernel("int64(int64)")
def squared(n):
    """n^2."""
    return n * n


X, Y = np.linspace(-1.0, 2.0, 7), np.array([-1.0, -0.5, 0.0, 0.5, 1.0, 1.5, 5.0])


@pytest.mark.parametrize(("entry", "given"), [
    (weighted, (5, 0.3, True, X)), (weighted, (np.int64(7), np.float64(0.3), False, Y)), (compared, (X, Y)),
    (compared, (X, X)), (product, (np.arange(21.0).reshape(3, 7), 2, X)), (called_through_its_slot, (-7,)),
])  # fmt: skip
def test_calls_by_address_return_what_the_source_does(entry, given):
    squared.load()
    expected = interpreted(entry)(*given)
    assert entry(*given) == expected and type(entry(*given)) is type(expected if isinstance(expected, tuple) else 1.0 if
                                                                     isinstance(expected, float) else 1)  # fmt: skip


def test_what_is_written_in_place_is_written():
    x = X.copy()
    assert halve(x) is None
    np.testing.assert_array_equal(x, 0.5 * X)


@pytest.mark.parametrize("wrong", [X.astype(np.float32), X[::2], X.reshape(1, 7), np.arange(3)])
def test_what_is_no_vector_of_float64_without_gaps_is_refused(wrong):
    with pytest.raises(TypeError, match="takes an array of float64 without gaps and with 1 axes, not "):
        halve(wrong)


@pytest.mark.parametrize("signature", [
    "void(int64[::1])", "int32(int64)", "float64(float32)", "Tuple((int64, int8))(int64)", "UniTuple(int64, 2)(int64)",
    "int64(Tuple((int64, int64)))", "void(float64[:, :])",
])  # fmt: skip
def test_what_cannot_be_called_by_address_is_refused(signature):
    """A result of another type would be other bits, read as a number."""
    with pytest.raises(TypeError, match=f"^Python calls no entry point {re.escape(signature)} by its address: mark it"):
        function_at(0, signature)


def kept(entry):
    """What stands on the disk of an entry point."""
    entry.load()
    return cache.code_file(entry.kept_name, kernels.kernel_stamp(entry)).load(lambda payload: payload)


def test_code_from_the_disk_does_the_same_at_another_address():
    payload = kept(weighted)
    assert object_code(payload).to_bytes() == payload
    again = linked(payload)
    assert again.address not in (0, weighted.address)
    assert function_at(again.address, weighted.signature)(5, 0.3, True, X) == weighted(5, 0.3, True, X)


def test_a_slot_is_found_by_code_from_the_disk():
    squared.load()
    kernels.make_slots_known([called_through_its_slot])
    again = linked(kept(called_through_its_slot))
    assert function_at(again.address, "int64(int64)")(12) == 145


def test_what_numba_pickled_is_no_object_code():
    assert linked(b"\x80\x04") is None


def test_a_symbol_that_nobody_knows_is_an_exception_and_not_the_end_of_the_process():
    part = object_code(kept(squared))
    with pytest.raises(LookupError, match="does not know no_such_function"):
        Linked(ObjectCode(part.symbol, ("no_such_function",), part.code))


RAISES = """
import numpy as np
from nonsmooth.jit import kernel
@kernel("float64(float64[::1], int64)")
def item(x, k):
    return x[k]
print(item(np.ones(3), 2))
try:
    item(np.ones(3), 3)
except IndexError as error:
    print(error)
"""


def test_what_compiled_code_raises_is_raised(tmp_path):
    environment = {**os.environ, "NUMBA_BOUNDSCHECK": "1", "NONSMOOTH_CACHE_DIR": str(tmp_path)}
    for _ in range(2):  # compiled, and from the disk
        done = subprocess.run(
            [sys.executable, "-c", RAISES], env=environment, capture_output=True, text=True, timeout=120
        )
        assert done.stdout == "1.0\nindex is out of bounds\n", done.stderr


# what a process keeps of its models

MODELS = """
import dataclasses, gc, sys
import nonsmooth as ns
from models import PainleveRod
from nonsmooth.jit import CannotCompile
from nonsmooth.mechanics import compiled

rod = PainleveRod().system()

def other(k):
    force = rod.force
    def pushed(t, q, u, p, h):
        force(t, q, u, p, h)
        h[0] += k
    return dataclasses.replace(rod, force=pushed)

def memory():
    with open("/proc/self/statm") as file:
        return int(file.read().split()[1]) * 4096 / 2**20

def compile_models(first, number):
    for k in range(first, first + number):
        assert compiled.model_of(other(float(k))).is_compiled
        compiled._shelf.cache_clear()  # nobody has use for the model any more
        gc.collect()

compile_models(0, 4)
before = memory()
compile_models(4, 8)
print((memory() - before) / 8)
"""


def test_models_are_linked_by_themselves_in_the_process_that_compiled_them(monkeypatch, tmp_path):
    """Also those that take memory, call LAPACK or raise: they do what their sources do."""
    monkeypatch.setenv("NONSMOOTH_CACHE_DIR", str(tmp_path))
    big = np.zeros(200_000)

    def mass(t, q, p, M):
        M[0, 0] = 1.0

    def takes_memory(t, q, u, p, h):
        h[0] = np.ones(3)[1] + np.array([q[0], 2.0]).sum()

    def solves(t, q, u, p, h):
        h[0] = np.linalg.solve(np.array([[2.0, 0.0], [0.0, 4.0]]), np.ones(2))[1]

    def raises(t, q, u, p, h):
        if q[0] > 0.0:
            raise ValueError("above")

    def reads_in_place(t, q, u, p, h):
        h[0] = big[7] + 2.0

    def written(force, is_linked):
        model = model_of(ns.System(n_q=1, mass=mass, force=force))
        assert isinstance(model._keep, Linked) == is_linked
        q, out = np.array([1.0]), np.array([9.0])
        is_done = model.call(FORCE, 0.0, *(each.ctypes.data for each in (q, q, q)), out.ctypes.data)
        return out[0] if is_done else None

    assert written(takes_memory, True) == 4.0 and written(solves, True) == 0.25 and written(raises, True) is None
    assert written(reads_in_place, False) == 2.0  # numba's linker: the address belongs to this process


@pytest.mark.skipif(not os.path.exists("/proc/self/statm"), reason="the system does not tell the memory of a process")
def test_models_that_nobody_has_use_for_are_given_back(tmp_path):
    """Of 2 MB that numba takes for each, a tenth is left: its notes on types."""
    environment = {**os.environ, "NONSMOOTH_CACHE_DIR": str(tmp_path), "NONSMOOTH_QUIET": "1"}
    done = subprocess.run([sys.executable, "-c", MODELS], env=environment, capture_output=True, text=True, timeout=280)
    assert done.returncode == 0, done.stderr
    assert float(done.stdout) < 0.5
