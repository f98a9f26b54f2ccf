"""Kernels are compiled with less of numba than numba itself takes, and do the same."""

import os
import re
import subprocess
import sys

import numba
import numpy as np
import pytest

from nonsmooth.jit import internals, kernel, kernel_compiler, rare_kernel
from nonsmooth.jit.kernel_compiler import (
    EntryLibrary,
    KernelCompiler,
    RareEntryLibrary,
    ShortLoopLibrary,
    compiler_of,
    no_negative_indices,
)
from nonsmooth.jit.kernel_lowering import ARRAY_PARTS, KernelLower

pytestmark = pytest.mark.upkeep


@kernel
def doubled(x):
    """Inlined."""
    return 2.0 * x


@rare_kernel
def tripled(x):
    """Called."""
    return 3.0 * x


@kernel
def picked(x, k, is_half):
    """An item, or half of it."""
    return x[k] * (0.5 if is_half else 1.0)


def summed(x):
    """Of the sixfold entries."""
    total = 0.0
    for i in range(x.shape[0]):
        total += tripled(doubled(x[i]))
    return total


def scaled(x, y):
    """A loop that LLVM turns into instructions for several numbers, if it may."""
    for i in range(x.shape[0]):
        y[i] = 3.0 * x[i]


def compiled(function, signature, library):
    options = {"nogil": True, "error_model": "numpy", "_nrt": False, "pipeline_class": compiler_of(library)}
    dispatcher = numba.njit(signature, **options)(function)
    (result,) = dispatcher.overloads.values()
    return dispatcher, result


def text_of(dispatcher):
    (text,) = dispatcher.inspect_llvm().values()
    return text


def test_inner_kernels_are_inlined_and_rare_ones_are_called():
    scope = {"tripled": tripled.callee, "doubled": doubled.callee}
    bound = type(summed)(summed.__code__, scope, "summed")
    dispatcher, _ = compiled(bound, "float64(float64[::1])", EntryLibrary)
    defined = re.findall(r"^define .*@(\S+?)\(", text_of(dispatcher), re.M)
    assert any("tripled" in name for name in defined) and not any("doubled" in name for name in defined)
    assert dispatcher(np.arange(4.0)) == 36.0


def test_short_loops_are_not_vectorised():
    wide = r"<\d+ x double>"
    for library, is_wide in ((EntryLibrary, True), (ShortLoopLibrary, False)):
        dispatcher, _ = compiled(scaled, "void(float64[::1], float64[::1])", library)
        assert bool(re.search(wide, text_of(dispatcher))) == is_wide
        y = np.zeros(9)
        dispatcher(np.arange(9.0), y)
        assert (y == 3.0 * np.arange(9.0)).all()


def test_in_rare_entry_points_a_constant_argument_makes_no_second_function():
    def entry(x, k):
        return picked(x, 0, True) + 10.0 * picked(x, 1, False) + 100.0 * picked(x, k, k > 0)

    bound = type(entry)(entry.__code__, {"picked": picked.callee}, "entry")
    dispatcher, _ = compiled(bound, "float64(float64[::1], int64)", RareEntryLibrary)
    assert len(picked.callee.overloads) == 1
    assert dispatcher(np.array([2.0, 3.0, 4.0]), 2) == 231.0


def test_rare_entry_points_do_the_same_with_a_loop_over_calls_left_as_it_is():
    def entry(x):
        for _ in range(4):
            x = tripled(x) / 7.0
        return x

    bound = type(entry)(entry.__code__, {"tripled": tripled.callee}, "entry")
    rare, often = (compiled(bound, "float64(float64)", library)[0] for library in (RareEntryLibrary, ShortLoopLibrary))
    assert len(re.findall(r"call .*tripled", text_of(rare))) == 1  # four, where LLVM unrolls it first
    assert rare(0.1).hex() == often(0.1).hex()


def test_kernels_are_compiled_without_the_test_for_negative_indices():
    def entry(x, i):
        return x[i]

    signature = "float64(float64[::1], int64)"
    plain = text_of(numba.njit(signature, error_model="numpy")(entry))
    before = kernel_compiler.arrayobj.fix_integer_index
    dispatcher, _ = compiled(entry, signature, EntryLibrary)
    assert kernel_compiler.arrayobj.fix_integer_index is before  # back in its place
    # a negative index is told by its sign: moved over the word (ashr) or compared
    sign = r"icmp slt i64 .*, 0|ashr i64 .*, 63"
    assert re.search(sign, plain) and not re.search(sign, text_of(dispatcher))
    with no_negative_indices():
        assert kernel_compiler.arrayobj.fix_integer_index is not before


def test_what_an_operation_resolves_to_is_asked_once(monkeypatch):
    monkeypatch.setattr(kernel_compiler, "_resolved_calls", {})
    operation, asked = kernel_compiler.functions.Function, []
    before = operation.get_call_type

    def count(self, context, args, keywords):
        asked.append(args)
        return before(self, context, args, keywords)

    monkeypatch.setattr(operation, "get_call_type", count)

    def polynomial(x):
        return x + x * (x + x * (x + x * (x + x * x)))

    assert compiled(polynomial, "float64(float64)", EntryLibrary)[0](2.0) == 62.0
    assert 0 < len(asked) <= 2 and operation.get_call_type is count


def test_passes_that_are_left_out_change_no_machine_code(monkeypatch):
    def entry(x, n):
        total, pair, is_odd = 0.0, (1.0, 2), False
        for k in range(n):
            a, e = pair
            is_odd = not is_odd
            if is_odd and x[k, 0] > a:
                total += x[k, e - 1] * max(a, x[k, 0])
            while total > 10.0:
                total *= 0.5
        return total, n if is_odd else -1

    texts = []
    monkeypatch.setattr(internals.NativeLowering, "lowering_class", property(lambda _: KernelLower))
    for pipeline in (KernelCompiler.define_pipelines, internals.Compiler.define_pipelines):
        monkeypatch.setattr(KernelCompiler, "define_pipelines", pipeline)
        dispatcher, _ = compiled(entry, "UniTuple(float64, 2)(float64[:, ::1], int64)", EntryLibrary)
        (ours,) = re.findall(r"^define [^\n]*?@(_ZN[^\n(]*)\([^\n]*\n(.*?)^}", text_of(dispatcher), re.M | re.S)[:1]
        texts.append(with_values_counted(ours[1].replace(ours[0], "entry")))
    assert len(texts[0]) > 1000 and texts[0] == texts[1]


@kernel
def sixfold(x):
    """Calls two kernels, one of which calls what the other is."""
    return tripled(doubled(x)) + 0.0 * max(x, doubled(x))


def test_what_is_called_from_several_kernels_is_linked_once():
    def entry(x):
        return sixfold(x) + doubled(x) + sixfold(tripled(x))

    scope = {"tripled": tripled.callee, "doubled": doubled.callee, "sixfold": sixfold.callee}
    dispatcher, result = compiled(type(entry)(entry.__code__, scope, "entry"), "float64(float64)", EntryLibrary)
    assert dispatcher(0.5) == 13.0
    assert sum("tripled" in name for name in re.findall(r"^define .*@(\S+?)\(", text_of(dispatcher), re.M)) == 1
    assert len(set(map(id, kernel_compiler.parts_of(result.library)))) == len(kernel_compiler.parts_of(result.library))


OWN_LOOP = """
import nonsmooth as ns
from nonsmooth.catalogue import load
from nonsmooth.runs import specialise
from numba.core.runtime import rtsys

ball = load("bouncing-ball")()
ns.simulate(ball.system(), (0, 0.01), *ball.state(), integrator=ns.MoreauJean(dt=1e-3, specialise=True))
(own,) = specialise._made.values()
(result,) = own.code.dispatcher.overloads.values()
defined = {each.name for each in rtsys.library._get_module_for_linking().functions if not each.is_declaration}
assert "NRT_decref" in defined
print(*[each.name for each in result.library._final_module.functions if each.is_declaration and each.name in defined])
"""


def test_numbas_counted_memory_is_linked_after_those_who_call_it(tmp_path):
    """What numba defines is no symbol that is looked for in the process, where any module may have one of that name:
    with numba 0.61 loops of one system released null pointers by a function of another that does not look at them."""
    environment = {**os.environ, "NONSMOOTH_CACHE_DIR": str(tmp_path), "NONSMOOTH_QUIET": "1"}
    done = subprocess.run(
        [sys.executable, "-c", OWN_LOOP], capture_output=True, text=True, env=environment, timeout=300
    )
    assert done.returncode == 0 and done.stdout.strip() == "", done.stdout + done.stderr


@kernel
def fourfold(x):
    """Called by the next one."""
    return doubled(doubled(x))


@kernel
def twelvefold(x):
    """Called from Python, as a function of numba's own library."""
    return 2.0 * fourfold(x) + max(fourfold(x), x)


def test_a_kernel_called_from_python_has_all_that_is_called_below_it():
    assert twelvefold(0.5) == 6.0


EXTENDED = """
import numba
from tests.jit.test_kernel_compiler import EntryLibrary, compiled, scaled
compiled(scaled, "void(float64[::1], float64[::1])", EntryLibrary)
def fourfold(x):
    pass
@numba.extending.overload(fourfold)
def typed(x):
    return lambda x: 4.0 * x
print(compiled(lambda x: fourfold(x), "float64(float64)", EntryLibrary)[0](2.0))
"""


def test_an_overload_that_was_registered_after_the_first_kernel_is_found(tmp_path):
    environment = {**os.environ, "NONSMOOTH_CACHE_DIR": str(tmp_path)}
    done = subprocess.run(
        [sys.executable, "-c", EXTENDED], env=environment, capture_output=True, text=True, timeout=120
    )
    assert done.stdout == "8.0\n", done.stderr


def with_values_counted(text):
    """Intermediate code with its values named by the order in which they are met."""
    names = {}
    return re.sub(r"%[\w.]+", lambda found: names.setdefault(found[0], f"%{len(names)}"), text)


# items of arrays and loops


def items(x, M, W, k, flags):
    """Items by variables, constants and both."""
    x[0] = M[1, k] + W[k, 1, 2] * x[k]
    M[k, 0] = W[1, k, 0] - x[1] + len(x) + M.shape[1]
    W[1, 0, k] = x.shape[0] * 0.5 + (1.0 if flags[k] else 2.0)
    flags[0] = not flags[1]
    count = 0
    for i in range(M.shape[0]):
        for j in range(M.shape[1]):
            M[i, j] += 0.25 * count
            count += 1
    return count


@pytest.mark.parametrize("dtype", ["float64", "int64", "int32"])
def test_items_of_arrays_are_those_of_python(dtype):
    arrays = [np.arange(1, 1 + np.prod(shape)).reshape(shape).astype(dtype) for shape in ((4,), (2, 3), (2, 2, 3))]
    flags = np.array([False, True])
    signature = f"int64({dtype}[::1], {dtype}[:, ::1], {dtype}[:, :, ::1], int64, boolean[::1])"
    dispatcher, _ = compiled(items, signature, EntryLibrary)
    there, here = ([each.copy() for each in arrays] for _ in range(2))
    there_flags, here_flags = flags.copy(), flags.copy()
    for k in (1, 0):
        assert dispatcher(*there, k, there_flags) == items(*here, k, here_flags)
    for a, b in zip((*there, there_flags), (*here, here_flags), strict=True):
        assert a.tobytes() == b.tobytes() and (a is there_flags or (a != arrays[len(a.shape) - 1]).any())


def loops(a, b, s, out):
    """All that ``range`` and ``for`` do in kernels: which indices, in which order."""
    n = 0
    for k in range(a):
        n = note(out, n, k)
    for k in range(a, b):
        if k == 2:
            continue
        n = note(out, n, k)
        if k == 5:
            break
    for k in range(b, a, -1):
        n = note(out, n, k)
        k = 77  # noqa: PLW2901 of no effect on the next one
    for k in range(a, b, 2):
        for j in range(k, b - 1):
            n = note(out, n, j - 100)
    for k in range(a, b, s):
        n = note(out, n, k)
    for _ in range(3):
        n = note(out, n, b)
    return n


@kernel
def note(out, n, k):
    """One more index."""
    out[n] = k
    return n + 1


@pytest.mark.parametrize(("a", "b", "s"), [
    (0, 0, 1), (3, 7, 2), (7, 3, -2), (-4, 4, 3), (4, -4, 1), (1, 2, -1), (2**62, 2**62 + 3, 1),
])  # fmt: skip
def test_loops_go_through_the_indices_of_python(a, b, s):
    a_start = a if abs(a) < 100 else 5  # range(a) itself is for small ones
    bound = type(loops)(loops.__code__, {"note": note.callee}, "loops")
    dispatcher, _ = compiled(bound, "int64(int64, int64, int64, int64[::1])", ShortLoopLibrary)
    there, here = np.zeros(300, dtype=np.int64), np.zeros(300, dtype=np.int64)
    plain = type(loops)(loops.__code__, {"note": note.function}, "loops")
    b_end = b - a + a_start
    assert dispatcher(a_start, b_end, s, there) == plain(a_start, b_end, s, here) > 0
    assert (there == here).all()


def test_a_range_over_large_numbers_and_one_that_steps_by_zero():
    def count(a, b, s):
        n = 0
        for k in range(a, b):
            n += k - a + 1
        for _ in range(0, 2, s):
            n += 1
        return n

    dispatcher, _ = compiled(count, "int64(int64, int64, int64)", EntryLibrary)
    top = 2**63 - 1
    assert dispatcher(top - 3, top, 1) == 8 and dispatcher(-top, 3 - top, 2) == 7
    with pytest.raises(ValueError, match="must not be zero"):
        dispatcher(0, 1, 0)


def test_arrays_consist_of_what_numbas_consist_of():
    for axes in (1, 2, 3):
        model = internals.cpu_target.target_context.data_model_manager[numba.types.Array(numba.float64, axes, "C")]
        assert model._fields == ARRAY_PARTS


CHECKED = """
import numba, numpy as np
from tests.jit.test_kernel_compiler import EntryLibrary, compiled
def entry(x, M, k):
    M[k, 0] = x[k]
    return x[k + 1]
dispatcher, _ = compiled(entry, "float64(float64[::1], float64[:, ::1], int64)", EntryLibrary)
for x, M in ((np.ones(2), np.ones((3, 1))), (np.ones(5), np.ones((1, 1)))):
    try:
        dispatcher(x, M, 1)
    except IndexError as error:
        print(error)
"""


def test_indices_are_checked_where_numba_is_asked_to(tmp_path):
    environment = {**os.environ, "NUMBA_BOUNDSCHECK": "1", "NONSMOOTH_CACHE_DIR": str(tmp_path)}
    done = subprocess.run([sys.executable, "-c", CHECKED], env=environment, capture_output=True, text=True, timeout=120)
    assert done.stdout == 2 * "index is out of bounds\n", done.stderr
