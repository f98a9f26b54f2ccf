"""A user's model functions as one machine address, and the call through it."""

from __future__ import annotations

import functools
import linecache
import math
import os
import re
import sys
import types
from collections.abc import Callable
from importlib.metadata import entry_points
from typing import Any, TypeVar

from nonsmooth.jit.cache import MachineCode, cache_directory, is_cached, is_usable, key_of, machine_code
from nonsmooth.jit.content import Content
from nonsmooth.jit.fingerprint import Survey, Unidentified, python_function
from nonsmooth.jit.kernels import INNER, OPTIONS, Kernel
from nonsmooth.jit.parameters import Unpack
from nonsmooth.jit.twins import Twins
from nonsmooth.jit.waiting import sentence, waiting

START_TIME, FUNCTION_TIME = 1.0, 0.3  # measured: s that the first model of a process compiles, and each function of it


class CannotCompile(Exception):
    """A model function cannot be compiled; ``str`` is a clause that says which and why."""

    cure = (
        "Write the function with numbers, math and loops only; sympy.lambdify does, of lists in the place of matrices "
        'and with modules="math".'
    )


class CannotIdentify(CannotCompile):
    """A model function reads something that cannot be distinguished from another one."""

    cure = "Read numbers, arrays, tuples, functions, or attributes of a module only."


MODEL_SIGNATURE = "void(int64, float64, CPointer(float64), CPointer(float64), CPointer(float64), CPointer(float64))"


Made = TypeVar("Made")
Functions = dict[int, tuple[Callable, bool, tuple[int, ...]]]  # which -> (function, takes_u, shape of out)
Source = tuple[Functions, int, int, Unpack, int]  # arguments of ``compile_model``


def survey_of(functions: Functions, n_q: int, n_u: int, unpack: Unpack, n_p: int) -> Survey:
    """All that the machine code of a model is made from; arguments as for `compile_model`.

    Raises
    ------
    CannotIdentify
        Where a function reads something without an identity; the message names it.
    """
    survey = Survey()
    survey.put(repr((n_q, n_u, n_p, unpack.identity)).encode())
    for which, (function, takes_u, shape) in functions.items():
        name = getattr(function, "__name__", type(function).__name__)
        if not isinstance(function, types.FunctionType) and python_function(function) is None:
            raise CannotIdentify(f"the model function {name} is no function but a {type(function).__name__}")
        survey.put(repr((which, takes_u, shape)).encode())
        try:
            survey.value(function, name)
        except Unidentified as reason:
            raise CannotIdentify(f"the model function {name} reads {reason}: whether that changed cannot be known, so "
                                 "nothing is compiled") from None  # fmt: skip
    _add_extensions(survey)
    return survey


def _add_extensions(survey: Survey) -> None:
    """Add what others than numba taught it of functions and types that are not theirs.

    Where it is not imported nobody has, and who would as it is imported is announced among the installed packages.

    Raises
    ------
    CannotIdentify
        Where such an extension has changed: numba goes on with what it made of it first.
    """
    if "numba" not in sys.modules and not entry_points(group="numba_extensions"):
        return
    from nonsmooth.jit.internals import extensions

    for function in extensions():
        found = Content()
        try:
            found.value(function, function.__qualname__)
        except Unidentified as reason:
            raise CannotIdentify(f"what {function.__qualname__} taught numba reads {reason}") from None
        content = found.digest()
        if _extensions.setdefault(function, content) != content:
            raise CannotIdentify(f"what {function.__qualname__} taught numba has changed; a new process sees it")
        survey.put(content)


_extensions: dict[Callable, bytes] = {}  # as they were when first met


def compile_model(functions: Functions, n_q: int, n_u: int, unpack: Unpack, n_p: int,
                  survey: Survey | None = None) -> MachineCode:  # fmt: skip
    """Compile a model's functions into one and return its address.

    Parameters
    ----------
    functions : dict
        ``which -> (function, takes_u, shape of out)``.
    n_q, n_u, n_p : int
        Numbers of coordinates, velocities and parameters.
    unpack : Unpack
        What makes ``p`` of the parameters in their order.
    survey : Survey, optional
        That of `survey_of`, where it is known.

    Raises
    ------
    CannotCompile
        When numba refuses one of the functions; the message names it.
    """
    survey = survey or survey_of(functions, n_q, n_u, unpack, n_p)
    key = key_of(survey.digest())
    if is_cached("model", key):
        return _compile(functions, n_q, n_u, unpack, n_p, key)
    with waiting(lambda: words_about(functions)):
        return _compile(functions, n_q, n_u, unpack, n_p, key)


def words_about(functions: Functions) -> str:
    """What is said while the functions of a model are compiled."""
    names = [getattr(function, "__name__", type(function).__name__) for function, _, _ in functions.values()]
    seconds = START_TIME + FUNCTION_TIME * len(names)
    folder = cache_directory() if is_usable() else None
    return sentence(f"the model functions {', '.join(names)}", "new, or changed", seconds, folder)


def _compile(functions: Functions, n_q: int, n_u: int, unpack: Unpack, n_p: int, key: str) -> MachineCode:
    """The machine code, from disk if it is there."""

    def options() -> dict[str, Any]:
        from nonsmooth.jit.internals import ApartCompiler

        return {**OPTIONS, "pipeline_class": ApartCompiler}

    def compiled(adapter: Callable[[], Callable]) -> MachineCode:
        return machine_code(adapter, MODEL_SIGNATURE, "model", key, options)

    try:
        return _first_compiled((functions, n_q, n_u, unpack, n_p), key, compiled)
    except Exception as error:  # numba raises many unrelated types
        reason = error
    if len(functions) > 1:
        for which, entry in functions.items():
            compile_model({which: entry}, n_q, n_u, unpack, n_p)
    (function, _, _), *_ = functions.values()
    name = getattr(function, "__name__", "")
    raise CannotCompile(
        f"numba cannot compile the model function {name}: {_first_line(reason)}{_place_in(reason)}"
    ) from reason


def _first_compiled(source: Source, key: str, compiled: Callable[[Callable[[], Callable]], Made]) -> Made:
    """What is made of the adapter: functions inlined halve the compile time; numba refuses it for a few constructs."""
    try:
        return compiled(lambda: _adapter(*source, "always", key))
    except Exception:  # numba raises many unrelated types
        return compiled(lambda: _adapter(*source, "never", key))


def inlined_model(source: Source, survey: str) -> Any:
    """Numba's type of a model whose functions become a part of what calls them.

    Parameters
    ----------
    source : tuple
        Arguments of `compile_model`.
    survey : str
        What distinguishes these functions from others.
    """
    from nonsmooth.jit.internals import ModelType, numba
    from nonsmooth.jit.kernel_compiler import InlinedCompiler

    def compiled(adapter: Callable[[], Callable]) -> Any:
        dispatcher = numba.njit(**OPTIONS, pipeline_class=InlinedCompiler)(adapter())
        dispatcher.compile(MODEL_SIGNATURE)
        return ModelType(survey, next(iter(dispatcher.overloads.values())))

    return _first_compiled(source, survey, compiled)


def _adapter(functions: Functions, n_q: int, n_u: int, unpack: Unpack, n_p: int, inline: str, key: str) -> Callable:
    """Generate ``model(which, t, q, u, p, out)``: views on the raw pointers, then a branch for each function."""
    from nonsmooth.jit.internals import numba

    twins = Twins(key)
    scope: dict[str, Any] = {
        "__name__": __name__,
        "view_q": _view((n_q,)),
        "view_u": _view((n_u,)),
    }
    p = unpack.source(scope, _frozen_view)
    lines = [
        "def model(which, t, q_, u_, p_, out_):",
        "    q = view_q(q_)",
        "    u = view_u(u_)",
        f"    p = {p}",
    ]
    for which, (function, takes_u, shape) in functions.items():
        scope[f"function_{which}"] = numba.njit(inline=inline, **OPTIONS, **INNER)(twins.copy(function))
        scope[f"view_{which}"] = _view(shape, cleared=True)
        arguments = "t, q, u, p" if takes_u else "t, q, p"
        lines += [f"    if which == {which}:", f"        function_{which}({arguments}, view_{which}(out_))"]
    exec(compile("\n".join(lines), "<nonsmooth model>", "exec"), scope)
    scope["model"].__qualname__ = f"model.{key}"
    return scope["model"]


def _first_line(error: Exception) -> str:
    lines = [line.strip() for line in str(error).splitlines() if line.strip()]
    useful = [line for line in lines if not line.startswith(("Failed in", "[1m", "During:"))]
    return (useful or lines or [type(error).__name__])[0]


def _place_in(error: Exception) -> str:
    """The line of a source that numba refuses, as ", at line 7 of my.py, ``return select(...)``"; "" if it has none."""
    found = re.search(r'File "(.+?)", line (\d+)', str(error))
    if found is None:
        return ""
    line = linecache.getline(os.path.abspath(found[1]), int(found[2])) or linecache.getline(found[1], int(found[2]))
    said = f", ``{line.strip()}``" if line.strip() else ""
    return f", at line {found[2]} of {os.path.basename(found[1])}{said}"


def _frozen_view(shape: tuple[int, ...], at: int) -> Any:
    """An intrinsic that sees a raw pointer, from a number on, as an array that cannot be written."""
    return _view(shape, at=at, frozen=True)


@functools.cache
def _view(shape: tuple[int, ...], cleared: bool = False, at: int = 0, frozen: bool = False) -> Any:
    """An intrinsic that sees a raw pointer as a C array of fixed shape (``numba.carray`` takes longer to compile).

    What a model function writes into is cleared first: ``h[0] += f``, or a branch that writes nothing, means what it
    says.
    """
    from numba import types as nb
    from numba.extending import intrinsic

    from nonsmooth.jit.internals import cgutils
    from nonsmooth.jit.kernel_lowering import array_value

    array = nb.Array(nb.float64, len(shape), "C", readonly=frozen)

    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        """The machine code: an array without an owner on the pointer's memory, which is cleared where it is written."""
        if cleared:
            cgutils.memset(builder, args[0], context.get_constant(nb.intp, 8 * math.prod(shape)), 0)
        start = builder.gep(args[0], [context.get_constant(nb.intp, at)]) if at else args[0]
        lengths = [context.get_constant(nb.intp, length) for length in shape]
        return array_value(context, builder, array, start, lengths)

    @intrinsic
    def view(typing_context, pointer):  # type: ignore[no-untyped-def]
        """The typing of the view: a C array of the fixed number of axes."""
        return array(pointer), generate

    return view


def _call_model_interpreted(model: Callable, which: int, t: float, q: Any, u: Any, p: Any, out: Any) -> bool:
    try:
        model(which, t, q, u, p, out)
    except KeyboardInterrupt:
        raise
    except BaseException:  # the run ends, and then asks each function again to name the one that raised
        return False
    return True


class _CallModel(Kernel):
    """``call_model(model, which, t, q, u, p, out) -> bool``: call a model function by address; False if it raised."""

    @functools.cached_property
    def inlined(self) -> Any:
        """What kernels call: a call of the model's address, whose status becomes the answer."""
        from numba import types as nb
        from numba.extending import intrinsic

        from nonsmooth.jit.internals import ModelType, cgutils

        pointer = nb.CPointer(nb.float64)
        argument_types = [nb.int64, nb.float64, pointer, pointer, pointer, pointer]

        def data_of(context: Any, builder: Any, signature: Any, arrays: Any) -> list[Any]:
            """The address of the data of each array."""
            return [
                cgutils.create_struct_proxy(kind)(context, builder, value=array).data
                for kind, array in zip(signature.args[3:], arrays, strict=True)
            ]

        def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
            """The machine code: a call of the address, and whether the function raised."""
            address, which, t, *arrays = args
            given = [which, t, *data_of(context, builder, signature, arrays)]
            convention = context.call_conv
            function_type = convention.get_function_type(nb.none, argument_types)
            function = builder.inttoptr(address, function_type.as_pointer())
            status, _ = convention.call_function(builder, function, nb.none, argument_types, given)
            return status.is_ok

        def generate_inlined(context: Any, builder: Any, signature: Any, args: Any) -> Any:
            """The machine code of the functions themselves, and whether one raised."""
            _, which, t, *arrays = args
            given = [which, t, *data_of(context, builder, signature, arrays)]
            made = signature.args[0].result
            context.active_code_library.add_linking_library(made.library)
            status, _ = context.call_internal_no_propagate(builder, made.fndesc, made.signature, given)
            return status.is_ok

        @intrinsic
        def call_model(typing_context, model, which, t, q, u, p, out):  # type: ignore[no-untyped-def]
            """The typing of the call."""
            if isinstance(model, ModelType):
                return nb.boolean(model, nb.int64, nb.float64, q, u, p, out), generate_inlined
            return nb.boolean(nb.int64, nb.int64, nb.float64, q, u, p, out), generate

        return call_model


call_model = _CallModel(_call_model_interpreted)
