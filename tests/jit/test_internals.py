"""What is used of numba beside its public interface: each part still does what it is used for."""

import os
import re
import subprocess
import sys
import tomllib
from pathlib import Path
from typing import Annotated as Array

import numba
import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.jit import internals, kernel, surroundings
from nonsmooth.jit.blocks import Block, Floats, Handle, head_words, new, view
from nonsmooth.jit.fingerprint import COPIED
from nonsmooth.jit.internals import (
    KeptResults,
    OurCompiler,
    can_be_kept,
    extensions,
    finish_twin,
    source_of,
    stands_alone,
    twin_of,
)
from nonsmooth.jit.surroundings import require_tested

pytestmark = pytest.mark.upkeep

ROOT = Path(__file__).parents[2]
PACKAGE = Path(ns.__file__).parent

# versions


def test_the_bounds_are_those_of_the_project():
    (wanted,) = (line for line in dependencies() if line.startswith("numba"))
    lowest, untested = (".".join(map(str, bound)) for bound in (surroundings.LOWEST, surroundings.UNTESTED))
    assert wanted == f"numba>={lowest},<{untested}"


def dependencies():
    return tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["dependencies"]


@pytest.mark.parametrize("version", ["0.60.0", "0.61.0", "0.69.0", "0.69.0rc1", "0.70.0dev0+1.g1", "1.0.0"])
def test_a_numba_that_was_not_tested_is_refused_in_one_sentence(version):
    words = rf"^numba {re.escape(version)} was not tested with nonsmooth: pip install \"numba>=0\.61\.2,<0\.69\"$"
    with pytest.raises(ns.UnsupportedVersion, match=words):
        require_tested(version)


@pytest.mark.parametrize("version", ["0.61.2", "0.65.1", "0.68.1", "0.68.0rc1"])
def test_a_numba_that_was_tested_is_taken(version):
    require_tested(version)


@pytest.mark.parametrize(("change", "words"), [
    ("import numba; numba.__version__ = '0.99.0'", 'nonsmooth: numba 0.99.0 was not tested with nonsmooth: '),
    ("import sys; sys.modules['numba'] = None", "nonsmooth: numba cannot be imported: "),
])  # fmt: skip
def test_a_numba_that_does_not_fit_is_told_in_one_line_also_at_first_use(change, words, tmp_path):
    code = f"{change}; from nonsmooth.commands.cli import main; "
    code += "raise SystemExit(main(['run', 'bouncing-ball', '--no-plot']))"
    empty = {**os.environ, "NONSMOOTH_CACHE_DIR": str(tmp_path / "cache")}  # where "first use, compiling" would be told
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=120, env=empty)
    assert done.returncode == 2 and done.stderr.startswith(words) and done.stderr.count("\n") == 1


def test_no_other_file_uses_what_is_not_public():
    for path in PACKAGE.rglob("*.py"):
        if path.name not in ("internals.py", "surroundings.py"):  # which reads its options without importing it
            assert not re.search(
                r"numba\.(core|np|experimental|parfors)|\bllvmlite\.(?!ir\b|binding\b)", path.read_text()
            )


# what is kept


def text_of(dispatcher):
    (text,) = dispatcher.inspect_llvm().values()
    return text


class Memory:
    """In place of a file."""

    payload, path = None, "memory"

    def load(self, rebuild):
        return None if self.payload is None else rebuild(self.payload)

    def save(self, payload):
        self.payload = payload


def test_what_was_compiled_runs_from_its_bytes_alone():
    def f(x):
        return 7.0 * x

    memory, results = Memory(), []
    for _ in range(2):
        dispatcher = numba.njit(error_model="numpy")(f)
        dispatcher._cache = KeptResults(memory)
        dispatcher.compile("float64(float64)")
        results.append((dispatcher(3.0), sum(dispatcher.stats.cache_hits.values())))
        assert internals.machine_code_of(dispatcher) > 0
    assert results == [(21.0, 0), (21.0, 1)]


ALONE = {
    "numbers": (lambda x: np.sin(x) * np.sqrt(x) + x % 3.0 + np.exp(-x), True),
    "memory": (lambda x: np.zeros(3).sum() + x, False),
    "hashes": (lambda x: float(len({"a": x, str(x): x})), False),
}


@pytest.mark.parametrize("name", ALONE)
def test_code_that_needs_what_numba_makes_known_later_is_known(name):
    function, is_alone = ALONE[name]
    dispatcher = numba.njit("float64(float64)", pipeline_class=OurCompiler)(function)
    (result,) = dispatcher.overloads.values()
    assert stands_alone(result) == is_alone


def test_code_that_returns_nothing_stands_alone():
    def clear(x):
        x[0] = 0.0

    dispatcher = numba.njit("void(float64[::1])", _nrt=False, pipeline_class=OurCompiler)(clear)
    (result,) = dispatcher.overloads.values()
    assert "_Py_NoneStruct" in result.library.get_llvm_str() and stands_alone(result)


RUN = """
import math
import sys
import numpy as np
import nonsmooth as ns
from nonsmooth.jit.code_files import CodeFile
from nonsmooth.catalogue.entries import load

def mass(t, q, p, M):
    M[0, 0] = 1.0

def force(t, q, u, p, h):
    a, numbers = np.ones(3), {1: 2.0, int(q[0]) + 7: 3.0}
    h[0] = np.dot(a, a) + numbers[1] + hash((2.0, 3))

def simple(t, q, u, p, h):
    x = 0.1 * q[0]
    h[0] = -np.sin(q[0]) * 9.81 + math.acos(x) + math.asin(x) + math.atan(x) + math.atan2(x, 1.0) + math.hypot(x, 1.0)
    h[0] += math.sinh(x) + math.cosh(x) + math.tanh(x) + math.asinh(x) + math.acosh(1.0 + x) + math.atanh(x)
    h[0] += math.exp(x) + math.expm1(x) + math.log(x) + math.log1p(x) + math.sqrt(x) + math.erf(x) + math.erfc(x)

saved = []
save = CodeFile.save
CodeFile.save = lambda *given: (saved.append(given), save(*given))
for some in (simple, force):
    system = ns.System(n_q=1, n_u=1, mass=mass, force=some)
    run = ns.simulate(system, (0, 0.01), [1.0], [0.0], integrator=ns.MoreauJean(dt=1e-3))
    print(run.u[-1, 0].hex(), "numba" in sys.modules)
print(len(saved) > 0)
"""


def test_a_later_process_imports_numba_only_for_code_that_needs_it(tmp_path):
    environment = {**os.environ, "NONSMOOTH_CACHE_DIR": str(tmp_path / "cache"), "PYTHONHASHSEED": "0"}
    file = tmp_path / "run.py"
    file.write_text(RUN)
    command = [sys.executable, str(file)]
    first, later = (
        subprocess.run(command, env=environment, capture_output=True, text=True, timeout=300) for _ in range(2)
    )
    (simple, _, force, _, was_compiled), (simple_later, early, force_later, late, is_compiled) = (
        done.stdout.split() for done in (first, later)
    )
    assert (simple, force) == (simple_later, force_later) and (was_compiled, is_compiled) == ("True", "False")
    assert (early, late) == ("False", "True")


@pytest.mark.parametrize(("array", "is_copied"), [
    (np.ones(COPIED // 8), True), (np.ones(COPIED // 8 + 1), False), (np.ones((3, 4)).T, True),
    (np.ones(8)[::2], False),
])  # fmt: skip
def test_arrays_beyond_a_size_and_with_gaps_are_read_in_place_and_not_kept(array, is_copied):
    @numba.njit("float64()")
    def first():
        return array.flat[0]

    (result,) = first.overloads.values()
    assert can_be_kept(result) == is_copied
    array.flat[0] = 2.0
    assert first() == (1.0 if is_copied else 2.0)


def test_functions_that_call_each_other_are_not_kept():
    """Numba looks for them by their name as the code runs, and finds none in another process."""

    @numba.njit
    def even(n):
        return True if n == 0 else odd(n - 1)

    @numba.njit
    def odd(n):
        return False if n == 0 else even(n - 1)

    assert even(4)
    assert not all(can_be_kept(result) for f in (even, odd) for result in f.overloads.values())


def test_functions_of_a_model_are_its_own():
    """The linker takes the first of those that it may share, also that of another model with the same name."""

    @numba.njit
    def helper(x):
        return [2.0 * x for _ in range(2)][1]

    @numba.njit("float64(float64)", pipeline_class=OurCompiler)
    def f(x):
        return helper(x)

    defined = re.findall(r"^define (\w*).*@(\S*helper\S*?)\(", text_of(f), re.M)
    assert f(3.0) == 6.0 and all(linkage == "internal" for linkage, _ in defined)


# what users compile

TIMES = 2.0


def times(x):
    return TIMES * x


def times_each(x, y):
    for i in range(x.shape[0]):
        y[i] = TIMES * x[i]


def thrice(x):
    return 3.0 * x


def thrice_each(x, y):
    for i in range(x.shape[0]):
        y[i] = 3.0 * x[i]


MADE = {
    "njit": (numba.njit(times), thrice),
    "njit with a signature": (numba.njit("float64(float64)")(times), thrice),
    "vectorize": (numba.vectorize(times), thrice),
    "vectorize with a signature": (numba.vectorize(["float64(float64)"], identity=0)(times), thrice),
    "guvectorize": (numba.guvectorize("(n)->(n)")(times_each), thrice_each),
    "guvectorize with a signature": (
        numba.guvectorize(["void(float64[:], float64[:])"], "(n)->(n)")(times_each), thrice_each,
    ),
    "cfunc": (numba.cfunc("float64(float64)")(times), thrice),
}  # fmt: skip


@pytest.mark.parametrize("name", MADE)
def test_what_a_user_compiled_is_known_by_its_source_and_made_again_of_another(name):
    made, other = MADE[name]
    description, source = source_of(made)
    assert source in (times, times_each) and " at 0x" not in description
    twin = twin_of(made, other)
    finish_twin(twin, made)
    assert source_of(twin)[1] is other
    if name != "cfunc":  # a function in its place
        assert source_of(twin)[0] == description
    x, y = np.array([2.0]), np.zeros(1)
    value = twin(x, y) if name == "guvectorize" else twin(x[0] if "cfunc" in name or "njit" in name else x)
    assert (y if name == "guvectorize" else np.atleast_1d(value))[0] == 6.0
    if "signature" in name and "guvectorize" not in name:
        with pytest.raises(TypeError):
            twin("text")


def test_descriptions_tell_options_and_signatures_apart():
    made = [
        numba.njit(times), numba.njit(fastmath=True)(times), numba.njit("float64(float64)")(times),
        numba.njit("float32(float32)")(times), numba.vectorize(times), numba.vectorize(["float64(float64)"])(times),
        numba.cfunc("float64(float64)")(times), numba.cfunc("float32(float32)")(times),
    ]  # fmt: skip
    assert len({source_of(each)[0] for each in made}) == len(made)


def test_an_intrinsic_is_known_by_its_source_and_made_again():
    @numba.extending.intrinsic
    def four(context):
        def generate(context, builder, signature, args):
            return context.get_constant(numba.float64, 4.0)

        return numba.float64(), generate

    description, source = source_of(four)
    assert source is four._defn and "Intrinsic" in description
    twin = twin_of(four, source)
    assert twin is not four and numba.njit(lambda: twin())() == 4.0


def test_types_are_known_by_what_they_print_and_other_objects_are_not_known():
    assert source_of(numba.float64) != source_of(numba.float32)
    assert source_of(numba.types.Array(numba.float64, 2, "C"))[0] == "type array(float64, 2d, C)"
    assert source_of(times) is None and source_of(3.0) is None
    assert source_of(numba.njit(pipeline_class=type("Mine", (internals.Compiler,), {}))(times)) is None


def test_what_numba_teaches_itself_is_no_extension_of_others():
    assert extensions() == []  # tests/jit/test_changes.py has one, in a process that ends with it


# blocks


class Pair(Block):
    a: Array[Floats, "n"]
    B: Array[Floats, "n", "n"]


@kernel("float64(int64)")
def trace(address):
    """What blocks use: types of attributes, words of a head, arrays on memory that is not theirs."""
    pair = view(address, Pair)
    total = 0.0
    for i in range(pair.a.shape[0]):
        total += pair.a[i] * pair.B[i, i]
    return total


def test_blocks_are_read_through_their_head():
    block = new(Pair, n=3)
    block.a[:], block.B[:] = [1.0, 2.0, 3.0], np.arange(9.0).reshape(3, 3)
    assert trace(block.address) == 0.0 + 2.0 * 4.0 + 3.0 * 8.0


class Inner(Block):
    call: Handle
    n: int


class Outer(Block):
    x: Array[Floats, "n"]
    inner: Inner
    call: Handle
    t: float


def test_words_of_another_process_leave_the_handles_of_this_one():
    here, there = new(Outer, n=3), new(Outer, n=3)
    here.call, here.inner.call, there.call, there.inner.call = 1, 2, 3, 4
    there.x[:], there.inner.n, there.t = [1.0, 2.0, 3.0], 5, 0.5
    here.restore(there.words.view(np.int64))
    assert (here.call, here.inner.call) == (1, 2)
    assert (here.x.tolist(), here.inner.n, here.t) == ([1.0, 2.0, 3.0], 5, 0.5)


class Longer(Outer):
    last: int


def test_numbers_of_a_block_are_words_of_its_head_and_nothing_else_is_set():
    """Also of a block that begins as another one does, and of one in a block."""
    block = new(Longer, n=2)
    block.t, block.inner.n, block.last = 0.25, 7, -3
    block.t += 0.5
    head = block.words[: head_words(Longer)]
    assert 0.75 in head and {7, -3} <= set(head.view(np.int64).tolist())
    assert (block.t, block.inner.n, block.last) == (0.75, 7, -3) and new(Longer, n=2).t == 0.0
    for name in ("x", "inner", "unknown"):
        with pytest.raises(AttributeError, match="is no number that can be set"):
            setattr(block, name, 1.0)
    block.call = len  # of the interpreter
    assert block.call is len
