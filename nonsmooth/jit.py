"""Compilation: the only file that touches numba.

Two kinds of function are compiled.

*Kernels* are ours. ``@kernel`` marks a plain function written for arrays and scalars; nothing happens, and numba is not
imported, until the kernel is first called. A kernel that carries a signature is an *entry point*: it is compiled once,
with the kernels it calls, and kept on disk under a hash of all that it depends on. An entry point calls another through
a slot that ``load`` fills: LLVM does not optimise the inner one again in each outer one, and what a scene does not need
is never compiled.
``interpreted(kernel)`` is the same source run by Python.

*Model functions* are the user's. ``compile_model`` binds them all into one function

    model(which, t, q*, u*, p*, out*)        which = MASS, FORCE, GAP, ...

and returns its machine address, an integer that the compiled loops receive as an argument and call through
``call_model``. So a loop is compiled once for every model, and a model once for every parameter value. A call costs
about 2 ns more than a C function pointer; handing dispatchers to the loop instead would compile the loop anew for every
model (2 s each) and never reach the disk cache.
"""

from __future__ import annotations

import contextlib
import ctypes
import enum
import functools
import hashlib
import math
import os
import sys
import types
import typing
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

PACKAGE = Path(__file__).parent
OPTIONS = {"nogil": True, "error_model": "numpy"}  # no fastmath: two runs agree bit for bit
# Kernels allocate nothing, so they need none of numba's reference counts.
KERNEL_OPTIONS = {**OPTIONS, "_nrt": False}


class Kernel:
    """A function of arrays and scalars, compiled on first call.

    Parameters
    ----------
    function : callable
        The source, in the subset of Python that numba compiles. It may call other kernels by their global name.
    signature : str, optional
        Numba signature such as ``"int64(float64[:, ::1], float64[::1])"``. Given for entry points only: they are
        compiled against it and cached on disk.
    short_loops : bool
        Compile the entry point without LLVM's loop vectorizer and unroller, whose prologues cost more than they save
        where loops run over two or three coordinates (a step of the rod: 470 ns with them, 410 ns without).
    is_rare : bool
        Called, not inlined: what few steps reach stays out of the instruction cache.
    """

    def __init__(
        self, function: Callable, signature: str | None = None, short_loops: bool = False, is_rare: bool = False
    ) -> None:
        self.function = function
        self.signature = signature
        self.short_loops = short_loops
        self.is_rare = is_rare
        self._slot = ctypes.c_size_t(0)
        functools.update_wrapper(self, function)

    @functools.cached_property
    def dispatcher(self) -> Any:
        """The numba dispatcher of this kernel."""
        import numba

        bound = rebind(self.function, lambda kernel: kernel.callee)
        if self.signature is None:
            return numba.njit(**KERNEL_OPTIONS)(bound)
        compiler = _compiler("entry", self.short_loops)
        return _compile(bound, self.signature, _kernel_stamp(self), **KERNEL_OPTIONS, pipeline_class=compiler)

    @functools.cached_property
    def inlined(self) -> Any:
        """The dispatcher that other kernels call."""
        import numba

        bound = rebind(self.function, lambda kernel: kernel.callee)
        wrappers = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}
        return numba.njit(**KERNEL_OPTIONS, **wrappers, pipeline_class=_compiler("rare" if self.is_rare else "inner"))(
            bound
        )

    @property
    def callee(self) -> Any:
        """What other kernels call: the dispatcher; of an entry point, a call through its slot."""
        return self.inlined if self.signature is None else _external(self)

    def slot_symbol(self) -> str:
        """The linker's name of the slot, which is made known to it here."""
        import llvmlite.binding as llvm

        symbol = f"nonsmooth.{self.function.__module__}.{self.function.__name__}"
        llvm.add_symbol(symbol, ctypes.addressof(self._slot))
        return symbol

    def load(self) -> None:
        """Compile an entry point, or read it from disk, and fill its slot.

        Whoever runs a loop loads the entry points that it may reach: what a scene does not need is not compiled.
        """
        if not self._slot.value:
            result = next(iter(self.dispatcher.overloads.values()))
            self._slot.value = result.library.get_pointer_to_function(result.fndesc.llvm_func_name)

    @property
    def address(self) -> int:
        """Where the machine code of an entry point begins: what a `Callback` calls."""
        self.load()
        return int(self._slot.value)

    def __call__(self, *args: Any) -> Any:
        return self.dispatcher(*args)


@functools.cache
def _compiler(kind: str, short_loops: bool = False) -> type:
    """The compiler class of inner kernels, of rare ones and of entry points.

    An inner kernel stops at LLVM's intermediate code: machine code for each of the fifty functions of a step would be
    made and never run. An entry point inlines them all: a call would hand arrays over word by word, and LLVM's own
    judgement spares it too few (a step of the rod: 620 ns, inlined 470).
    """
    import llvmlite.binding as llvm
    from numba.core.codegen import JITCodeLibrary
    from numba.core.compiler import Compiler

    class NoEnvironment:
        def set_env(self, name: str, env: Any) -> None:
            """Nothing to set: an inner kernel never runs by itself."""

    class InnerLibrary(JITCodeLibrary):
        codegen = NoEnvironment()

        def _optimize_final_module(self) -> None:
            """Left to the entry point."""

        def _finalize_final_module(self) -> None:
            self._finalize_dynamic_globals()
            self._finalized = True

        def get_pointer_to_function(self, name: str) -> int:
            return 0

    class RareLibrary(InnerLibrary):
        def add_llvm_module(self, module: Any) -> None:
            for function in module.functions:
                if not function.is_declaration:
                    function.add_function_attribute("noinline")
            super().add_llvm_module(module)

    class EntryLibrary(JITCodeLibrary):
        def _optimize_final_module(self) -> None:
            for function in self._final_module.functions:
                if not function.is_declaration and function.linkage == llvm.Linkage.linkonce_odr:
                    function.linkage = "internal"
                    if b"noinline" not in b" ".join(function.attributes):
                        function.add_function_attribute("alwaysinline")
            if not short_loops:
                return super()._optimize_final_module()
            tuning = llvm.create_pipeline_tuning_options(speed_level=3)
            tuning.loop_vectorization = tuning.slp_vectorization = tuning.loop_unrolling = False
            passes = llvm.create_pass_builder(self._codegen._tm, tuning)
            passes.getModulePassManager().run(self._final_module, passes)

    libraries: dict[str, Any] = {"inner": InnerLibrary, "rare": RareLibrary, "entry": EntryLibrary}

    class KernelCompiler(Compiler):
        def __init__(self, typingctx: Any, targetctx: Any, _: Any, *rest: Any) -> None:
            library = libraries[kind](targetctx.codegen(), "kernel")
            library.enable_object_caching()
            super().__init__(typingctx, targetctx, library, *rest)

        def compile_extra(self, function: Callable) -> Any:
            with _no_negative_indices(), _known_calls():
                return super().compile_extra(function)

    return KernelCompiler


@contextlib.contextmanager
def _no_negative_indices() -> Iterator[None]:
    """Compile without Python's negative indices: kernels use none, and the test for them costs as much as the sum it is
    in (a step of the rod: 410 ns with it)."""
    from numba import types as nb
    from numba.np import arrayobj

    before = arrayobj.fix_integer_index

    def index(context: Any, builder: Any, kind: Any, value: Any, size: Any) -> Any:
        return context.cast(builder, value, kind, nb.intp)

    arrayobj.fix_integer_index = index
    try:
        yield
    finally:
        arrayobj.fix_integer_index = before


@contextlib.contextmanager
def _known_calls() -> Iterator[None]:
    """Keep what an operation on given types resolves to: numba asks each of its dozen overloads of ``a + b`` anew for
    every ``+`` in the source (the first use of a scene: 13 s without)."""
    from numba.core.types import functions

    operation: Any = functions.Function
    before = operation.get_call_type

    def resolve(self: Any, context: Any, args: Any, keywords: Any) -> Any:
        if keywords:
            return before(self, context, args, keywords)
        if (self, args) not in _resolved_calls:
            _resolved_calls[self, args] = before(self, context, args, keywords)
        return _resolved_calls[self, args]

    operation.get_call_type = resolve
    try:
        yield
    finally:
        operation.get_call_type = before


_resolved_calls: dict[Any, Any] = {}


@functools.cache
def _external(kernel: Kernel) -> Any:
    """An intrinsic that calls an entry point through its slot: a word that holds its address once it is loaded."""
    from numba.core import cgutils, sigutils
    from numba.extending import intrinsic

    arguments, result = sigutils.normalize_signature(kernel.signature)
    symbol = kernel.slot_symbol()

    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        given = cgutils.unpack_tuple(builder, args[0])
        values = [
            context.cast(builder, value, kind, wanted)
            for value, kind, wanted in zip(given, signature.args[0].types, arguments, strict=True)
        ]
        convention = context.call_conv
        pointer_type = convention.get_function_type(result, arguments).as_pointer()
        slot = cgutils.add_global_variable(builder.module, pointer_type, symbol)
        slot.linkage = "external"
        _, value = convention.call_function(builder, builder.load(slot), result, arguments, values)
        return value

    @intrinsic
    def call(typing_context, *args):  # type: ignore[no-untyped-def]
        from numba import types as nb

        return result(nb.StarArgTuple.from_types(args)), generate

    return call


class Callback(Kernel):
    """``callback(address, *arguments)``: call an entry point of a fixed signature by its address.

    So a kernel that serves several problems (an integrator of differential equations) is compiled once. In the
    interpreter the address is a Python function.
    """

    def __init__(self, signature: str) -> None:
        super().__init__(_call_back_interpreted, signature)

    @functools.cached_property
    def callee(self) -> Any:  # type: ignore[override]
        from numba.core import cgutils, sigutils
        from numba.extending import intrinsic

        arguments, result = sigutils.normalize_signature(self.signature)

        def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
            pointer, *given = cgutils.unpack_tuple(builder, args[0])
            convention = context.call_conv
            function = builder.inttoptr(pointer, convention.get_function_type(result, arguments).as_pointer())
            _, value = convention.call_function(builder, function, result, arguments, given)
            return value

        @intrinsic
        def call(typing_context, *args):  # type: ignore[no-untyped-def]
            from numba import types as nb

            return result(nb.StarArgTuple.from_types(args)), generate

        return call


def _call_back_interpreted(function: Callable, *arguments: Any) -> Any:
    return function(*arguments)


def kernel(target: Callable | str, short_loops: bool = False) -> Any:
    """Mark a function as a kernel: ``@kernel`` for inner ones, ``@kernel("int64(float64[::1])")`` for entry points."""
    if isinstance(target, str):
        return lambda function: Kernel(function, target, short_loops)
    return Kernel(target)


def rare_kernel(function: Callable) -> Kernel:
    """Mark an inner kernel that few steps reach: it is called, not inlined."""
    return Kernel(function, is_rare=True)


@functools.cache
def interpreted(kernel: Kernel) -> Callable:
    """The source of a kernel, and of every kernel it calls, run by the Python interpreter."""
    return rebind(kernel.function, interpreted)


def rebind(function: Callable, replace: Callable[[Kernel], Callable]) -> Callable:
    """Copy a function with each kernel among the globals it reads replaced."""
    bound = dict(function.__globals__)
    for name in _names(function.__code__):
        if isinstance(bound.get(name), Kernel):
            bound[name] = replace(bound[name])
    return _with_globals(function, bound)


def _with_globals(function: Callable, scope: dict[str, Any]) -> Callable:
    copy = types.FunctionType(function.__code__, scope, function.__name__, function.__defaults__, function.__closure__)
    copy.__module__ = function.__module__
    copy.__qualname__ = function.__qualname__
    return copy


# ---------------------------------------------------------------------------------------------------------------
# The disk cache


def cache_directory() -> Path:
    """Where compiled code is kept: ``$NONSMOOTH_CACHE_DIR``, else ``nonsmooth`` under the user's cache directory."""
    if "NONSMOOTH_CACHE_DIR" in os.environ:
        return Path(os.environ["NONSMOOTH_CACHE_DIR"])
    if sys.platform == "win32":
        root = Path(os.environ.get("LOCALAPPDATA", "~"))
    else:
        root = Path(os.environ.get("XDG_CACHE_HOME", "~/.cache"))
    return (root / "nonsmooth").expanduser()


@functools.cache
def _runtime_stamp() -> str:
    """Hash of the sources that generate code themselves: they shape every compiled function."""
    return hashlib.sha256(b"".join((PACKAGE / name).read_bytes() for name in ("jit.py", "blocks.py"))).hexdigest()


@functools.cache
def _kernel_stamp(kernel: Kernel) -> str:
    """Hash of a kernel, of all it calls and of the constants and types they read.

    numba itself would miss an edit of an inlined kernel in another file, and a changed constant.
    """
    return hashlib.sha256(_runtime_stamp().encode() + _identity(kernel.function)).hexdigest()


def _compile(function: Callable, signature: Any, stamp: str, **options: Any) -> Any:
    """Compile for one signature, reading or filling the disk cache under the given stamp."""
    import numba

    dispatcher = numba.njit(**options)(function)
    if not numba.config.DISABLE_JIT:
        dispatcher._cache = _stamped_cache(function, stamp)
        dispatcher.compile(signature)
        dispatcher.disable_compile()
    return dispatcher


def _stamped_cache(function: Callable, stamp: str) -> Any:
    """A numba function cache whose freshness is our stamp, not the file's date, so that generated code is kept too."""
    from numba.core import caching

    directory = cache_directory() / stamp[:16]

    class Locator(caching._CacheLocator):
        def get_cache_path(self) -> str:
            return str(directory)

        def get_source_stamp(self) -> str:
            return stamp

        def get_disambiguator(self) -> str:
            return stamp[16:24]

        @classmethod
        def from_function(cls, py_func: Callable, py_file: str) -> Locator:
            return cls()

    class Implementation(caching.CompileResultCacheImpl):
        _locator_classes = [Locator]

    class Cache(caching.FunctionCache):
        _impl_class = Implementation

    try:
        directory.mkdir(parents=True, exist_ok=True)
    except OSError:
        return caching.NullCache()  # nowhere to write: compile in every process
    return Cache(function)


# ---------------------------------------------------------------------------------------------------------------
# Model functions


class CannotCompile(Exception):
    """Numba refused a model function; ``str`` says which and why."""


class CompiledModel:
    """The machine address of a model's functions.

    Attributes
    ----------
    address : int
        What the compiled loops take as ``model``.
    """

    def __init__(self, dispatcher: Any) -> None:
        self._dispatcher = dispatcher  # keeps the machine code alive
        result = next(iter(dispatcher.overloads.values()))
        self.address = int(result.library.get_pointer_to_function(result.fndesc.llvm_func_name))


MODEL_SIGNATURE = "void(int64, float64, CPointer(float64), CPointer(float64), CPointer(float64), CPointer(float64))"


def compile_model(functions: dict[int, tuple[Callable, bool, tuple[int, ...]]], n_q: int, n_u: int, unpack: Callable,
                  n_p: int) -> CompiledModel:  # fmt: skip
    """Compile a model's functions into one and return its address.

    Parameters
    ----------
    functions : dict
        ``which -> (function, takes_u, shape of out)``.
    n_q, n_u, n_p : int
        Numbers of coordinates, velocities and parameters.
    unpack : type
        The NamedTuple class that user functions see as ``p``; its fields are the parameters in order.

    Raises
    ------
    CannotCompile
        When numba refuses one of the functions; the message names it.
    """
    stamp = hashlib.sha256(
        repr((_runtime_stamp(), n_q, n_u, n_p, unpack._fields)).encode()  # type: ignore[attr-defined]
        + b"".join(
            repr((which, takes_u, shape)).encode() + _identity(function)
            for which, (function, takes_u, shape) in functions.items()
        )
    ).hexdigest()
    for inline in ("always", "never"):  # inlining halves the compile time; numba refuses it for a few constructs
        try:
            adapter = _adapter(functions, n_q, n_u, unpack, n_p, inline)
            return CompiledModel(_compile(adapter, MODEL_SIGNATURE, stamp, **OPTIONS))
        except Exception as error:  # numba raises many unrelated types
            reason = error
    if len(functions) > 1:
        for which, entry in functions.items():
            compile_model({which: entry}, n_q, n_u, unpack, n_p)
    (function, _, _), *_ = functions.values()
    raise CannotCompile(f"{function.__name__}: {_first_line(reason)}") from reason


def _adapter(functions: dict, n_q: int, n_u: int, unpack: Callable, n_p: int, inline: str) -> Callable:
    """Generate ``model(which, t, q, u, p, out)``: views on the raw pointers, then a branch for each function."""
    import numba

    scope: dict[str, Any] = {
        "__name__": __name__,
        "view_q": _view((n_q,)),
        "view_u": _view((n_u,)),
        "Parameters": unpack,
    }
    lines = [
        "def model(which, t, q_, u_, p_, out_):",
        "    q = view_q(q_)",
        "    u = view_u(u_)",
        f"    p = Parameters({', '.join(f'p_[{i}]' for i in range(n_p))})",
    ]
    for which, (function, takes_u, shape) in functions.items():
        scope[f"function_{which}"] = numba.njit(inline=inline, **OPTIONS)(_with_compiled_helpers(function))
        scope[f"view_{which}"] = _view(shape, cleared=True)
        arguments = "t, q, u, p" if takes_u else "t, q, p"
        lines += [f"    if which == {which}:", f"        function_{which}({arguments}, view_{which}(out_))"]
    exec(compile("\n".join(lines), "<nonsmooth model>", "exec"), scope)
    return scope["model"]


def _with_compiled_helpers(function: Callable) -> Callable:
    """Copy a user's function with the plain Python functions it calls marked for compilation."""
    import numba

    bound = dict(function.__globals__)
    for name in _names(function.__code__):
        helper = bound.get(name)
        if isinstance(helper, types.FunctionType) and helper is not function:
            bound[name] = numba.njit(**OPTIONS)(_with_compiled_helpers(helper))
    return _with_globals(function, bound)


def _identity(function: Callable) -> bytes:
    """What a compiled function depends on: its code, constants, defaults, closure and the globals it reads."""
    code = function.__code__
    parts: list[Any] = [code.co_code, code.co_names, function.__defaults__]
    parts += [repr(c) for c in code.co_consts if c != function.__doc__ and not isinstance(c, types.CodeType)]
    parts += [repr(cell.cell_contents) for cell in function.__closure__ or ()]
    identity = repr(parts).encode()
    for name in sorted(set(_names(code))):
        identity += _global_identity(function.__globals__.get(name), function)
    return identity


def _global_identity(value: Any, reader: Callable) -> bytes:
    """What a function depends on through one global that it reads."""
    if isinstance(value, Kernel):
        return repr((value.signature, value.short_loops, value.is_rare)).encode() + _digest(value.function)
    if isinstance(value, types.FunctionType):
        return b"" if value is reader else _identity(value)
    if hasattr(value, "py_func"):  # a helper the user compiled himself
        return _identity(value.py_func)
    if hasattr(value, "tobytes"):
        return bytes(value.tobytes())
    if isinstance(value, type):
        return _type_identity(value)
    return b"" if value is None or isinstance(value, types.ModuleType) else repr(value).encode()


@functools.cache
def _digest(function: Callable) -> bytes:
    return hashlib.sha256(_identity(function)).digest()


def _type_identity(cls: type) -> bytes:
    """The members of an enumeration, or the fields of a NamedTuple, however deep."""
    if issubclass(cls, enum.Enum):
        return repr(list(cls)).encode()
    hints = typing.get_type_hints(cls, include_extras=True) if hasattr(cls, "_fields") else {}
    return b"".join(
        name.encode() + (_type_identity(hint) if isinstance(hint, type) else repr(hint).encode())
        for name, hint in hints.items()
    )


def _names(code: types.CodeType) -> Iterator[str]:
    yield from code.co_names
    for constant in code.co_consts:
        if isinstance(constant, types.CodeType):
            yield from _names(constant)


def _first_line(error: Exception) -> str:
    lines = [line.strip() for line in str(error).splitlines() if line.strip()]
    useful = [line for line in lines if not line.startswith(("Failed in", "[1m", "During:"))]
    return (useful or lines or [type(error).__name__])[0]


def _view(shape: tuple[int, ...], cleared: bool = False) -> Any:
    """An intrinsic that sees a raw pointer as a C array of fixed shape (``numba.carray`` takes longer to compile).

    What a model function writes into is cleared first: ``h[0] += f``, or a branch that writes nothing, means what it
    says.
    """
    from numba import types as nb
    from numba.core import cgutils
    from numba.extending import intrinsic
    from numba.np.arrayobj import make_array, populate_array

    array = nb.Array(nb.float64, len(shape), "C")
    strides = [8] * len(shape)
    for axis in range(len(shape) - 2, -1, -1):
        strides[axis] = strides[axis + 1] * shape[axis + 1]

    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        view = make_array(array)(context, builder)
        if cleared:
            cgutils.memset(builder, args[0], context.get_constant(nb.intp, 8 * math.prod(shape)), 0)
        populate_array(
            view,
            data=builder.bitcast(args[0], view.data.type),
            shape=cgutils.pack_array(builder, [context.get_constant(nb.intp, n) for n in shape]),
            strides=cgutils.pack_array(builder, [context.get_constant(nb.intp, n) for n in strides]),
            itemsize=context.get_constant(nb.intp, 8),
            meminfo=None,
        )
        return view._getvalue()

    @intrinsic
    def view(typing_context, pointer):  # type: ignore[no-untyped-def]
        return array(pointer), generate

    return view


def _call_model_interpreted(model: Callable, which: int, t: float, q: Any, u: Any, p: Any, out: Any) -> bool:
    try:
        model(which, t, q, u, p, out)
    except Exception:  # the run ends, and then asks each function again to name the one that raised
        return False
    return True


class _CallModel(Kernel):
    """``call_model(model, which, t, q, u, p, out) -> bool``: call a model function by address; False if it raised."""

    @functools.cached_property
    def inlined(self) -> Any:
        from numba import types as nb
        from numba.core import cgutils
        from numba.extending import intrinsic

        pointer = nb.CPointer(nb.float64)
        argument_types = [nb.int64, nb.float64, pointer, pointer, pointer, pointer]

        def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
            address, which, t, *arrays = args
            data = [
                cgutils.create_struct_proxy(kind)(context, builder, value=array).data
                for kind, array in zip(signature.args[3:], arrays, strict=True)
            ]
            convention = context.call_conv
            function_type = convention.get_function_type(nb.none, argument_types)
            function = builder.inttoptr(address, function_type.as_pointer())
            status, _ = convention.call_function(builder, function, nb.none, argument_types, [which, t, *data])
            return status.is_ok

        @intrinsic
        def call_model(typing_context, model, which, t, q, u, p, out):  # type: ignore[no-untyped-def]
            return nb.boolean(nb.int64, nb.int64, nb.float64, q, u, p, out), generate

        return call_model


call_model = _CallModel(_call_model_interpreted)
