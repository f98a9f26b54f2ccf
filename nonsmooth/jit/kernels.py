"""Kernels: plain functions of arrays and scalars, compiled on first use or run by the interpreter."""

from __future__ import annotations

import ctypes
import functools
import types
from collections.abc import Callable, Iterable
from typing import Any

from nonsmooth.jit import late
from nonsmooth.jit.bytecode import reading
from nonsmooth.jit.cache import MachineCode, compile_cached, is_cached, key_of, machine_code
from nonsmooth.jit.fingerprint import digest
from nonsmooth.jit.linking import function_at

OPTIONS = {"nogil": True, "error_model": "numpy"}  # no fastmath: two runs agree bit for bit
# Kernels allocate nothing, so they need none of numba's reference counts.
INNER = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}  # of what compiled code alone calls
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
        What few steps reach. An inner kernel is called, not inlined, and stays out of the instruction cache; an entry
        point is optimised less, in half of LLVM's time.
    takes_arrays : bool
        An entry point that Python hands arrays to, often or of other kinds than float64. Numba makes a wrapper for it,
        and is imported where it is called; those that are called by compiled code, or by Python with numbers, need
        neither.
    is_late : bool
        What few runs reach: such an entry point is loaded when it is first called (late.py).
    """

    def __init__(
        self,
        function: Callable,
        signature: str | None = None,
        short_loops: bool = False,
        is_rare: bool = False,
        takes_arrays: bool = False,
        is_late: bool = False,
    ) -> None:
        self.function = function
        self.signature = signature
        self.short_loops = short_loops
        self.is_rare = is_rare
        self.takes_arrays = takes_arrays
        self.is_late = is_late
        self._slot = ctypes.c_size_t(0)
        functools.update_wrapper(self, function)
        self.place = f"{function.__module__}:{function.__name__}"  # where another process finds it

    @functools.cached_property
    def dispatcher(self) -> Any:
        """The numba dispatcher of an inner kernel, or of one that ``takes_arrays``.

        That of an entry point fills its slot at once: the linker knows code by names that numba counts up in each
        process, so a later one from the disk may have the same, and is found from then on.
        """
        from nonsmooth.jit.internals import machine_code_of, numba

        if self.signature is None:
            return numba.njit(**KERNEL_OPTIONS)(self._bound())
        dispatcher = compile_cached(self._bound(), *self._kept_as(), **self._options())
        if dispatcher.overloads:  # none where numba is switched off
            self._slot.value = machine_code_of(dispatcher)
        return dispatcher

    def _bound(self) -> Callable:
        return rebind(self.function, lambda kernel: kernel.callee)

    def _kept_as(self) -> tuple[str, str, str]:
        return self.signature or "", self.kept_name, kernel_stamp(self)

    def _options(self) -> dict[str, Any]:
        from nonsmooth.jit.kernel_compiler import compiler_of, library_of

        return {**KERNEL_OPTIONS, "pipeline_class": compiler_of(library_of(self.short_loops, self.is_rare))}

    @functools.cached_property
    def inlined(self) -> Any:
        """The dispatcher that other kernels call."""
        return inner_dispatcher(rebind(self.function, lambda kernel: kernel.callee), self.is_rare)

    @property
    def callee(self) -> Any:
        """What other kernels call: the dispatcher; of an entry point, a call through its slot."""
        return self.inlined if self.signature is None else _external(self)

    def call_identity(self) -> bytes:
        """What a kernel that calls this one depends on: its code, and the slot that it is called through."""
        slot = self.slot_name if self.signature else None
        facts = (self.signature, self.short_loops, self.is_rare, self.takes_arrays, self.is_late, slot)
        return repr(facts).encode() + digest(self.function)

    @property
    def slot_name(self) -> str:
        """The linker's name of the slot of an entry point."""
        return f"nonsmooth.{self.function.__module__}.{self.function.__name__}"

    @property
    def kept_name(self) -> str:
        """The name of its file, with the room: two rooms may have functions of one name."""
        return f"{self.function.__module__.removeprefix('nonsmooth.')}.{self.function.__name__}"

    def slot_symbol(self) -> str:
        """The name of the slot, which is made known to the linker here."""
        import llvmlite.binding as llvm

        slot = ctypes.addressof(self._slot)
        llvm.add_symbol(self.slot_name, slot)
        if self.is_late:
            late.know(slot, self.function.__name__, self.load)
        return self.slot_name

    def load(self) -> None:
        """Compile an entry point, or read it from disk, and fill its slot.

        Whoever runs a loop loads the entry points that it may reach, but for those that are loaded late: what a scene
        does not need is not compiled.
        """
        if self.is_loaded:
            return
        if not self.takes_arrays:
            make_slots_known([self])
            code = machine_code(self._bound, *self._kept_as(), self._options)
            _machine_code.append(code)
            self._slot.value = code.address
        else:
            assert self.dispatcher is not None  # which fills it

    @functools.cached_property
    def compiled(self) -> Callable:
        """What Python calls: numba's dispatcher for one that ``takes_arrays``, else the address."""
        if self.takes_arrays or self.signature is None:
            return self.dispatcher  # type: ignore[no-any-return]
        return function_at(self.address, self.signature)

    @property
    def is_loaded(self) -> bool:
        """Whether its slot is filled."""
        return bool(self._slot.value)

    @property
    def is_on_disk(self) -> bool:
        """Whether an earlier process compiled it."""
        return is_cached(self.kept_name, kernel_stamp(self))

    @property
    def address(self) -> int:
        """Where the machine code of an entry point begins: what a `Callback` calls."""
        self.load()
        return int(self._slot.value)

    def __call__(self, *args: Any) -> Any:
        return self.compiled(*args)


_machine_code: list[MachineCode] = []  # entry points stay as long as the process


def make_slots_known(kernels: Iterable[Kernel]) -> None:
    """Tell the linker the slots that these look for, and what is inlined in them."""
    open_ends, met = list(kernels), set[Kernel]()
    while open_ends:
        new = {each for each in called_by(open_ends.pop()) if not isinstance(each, Callback)} - met
        met |= new
        for each in new:
            if each.signature is None:
                open_ends.append(each)
            else:
                each.slot_symbol()


def inner_dispatcher(function: Callable, is_rare: bool = False) -> Any:
    """The dispatcher of a function that becomes a part of the entry points that call it."""
    from nonsmooth.jit.internals import numba
    from nonsmooth.jit.kernel_compiler import InnerLibrary, RareLibrary, compiler_of

    pipeline = compiler_of(RareLibrary if is_rare else InnerLibrary)
    return numba.njit(**KERNEL_OPTIONS, **INNER, pipeline_class=pipeline)(function)


@functools.cache
def kernel_stamp(kernel: Kernel) -> str:
    """The key of a kernel: of all it calls and of the constants and types they read."""
    return key_of(kernel.call_identity())


@functools.cache
def _external(kernel: Kernel) -> Any:
    """An intrinsic that calls an entry point through its slot: a word that holds its address once it is loaded."""
    from numba.extending import intrinsic

    from nonsmooth.jit.internals import cgutils, sigutils

    arguments, result = sigutils.normalize_signature(kernel.signature)
    symbol = kernel.slot_symbol()

    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        """The machine code: load the slot, and call what it points to."""
        given = cgutils.unpack_tuple(builder, args[0])
        values = [
            context.cast(builder, value, kind, wanted)
            for value, kind, wanted in zip(given, signature.args[0].types, arguments, strict=True)
        ]
        convention = context.call_conv
        pointer_type = convention.get_function_type(result, arguments).as_pointer()
        slot = builder.module.globals.get(symbol)  # a second call in one function finds the declaration of the first
        if slot is None:
            slot = cgutils.add_global_variable(builder.module, pointer_type, symbol)
            slot.linkage = "external"
        if kernel.is_late:
            late.generate_fetch(context, builder, slot)
        return call_through(context, builder, builder.load(slot), result, arguments, values, reaches_late(kernel))

    @intrinsic
    def call(typing_context, *args):  # type: ignore[no-untyped-def]
        """The typing of the call: that of the entry point's signature."""
        from numba import types as nb

        return result(nb.StarArgTuple.from_types(args)), generate

    return call


def call_through(
    context: Any, builder: Any, function: Any, result: Any, arguments: Any, values: list[Any], may_fail: bool
) -> Any:
    """The machine code of a call of an entry point; one that may come to code that cannot be loaded hands on what that
    raises."""
    convention = context.call_conv
    status, value = convention.call_function(builder, function, result, arguments, values)
    if may_fail:
        with builder.if_then(status.is_error, likely=False):
            convention.return_status_propagate(builder, status)
    return value


def called_by(kernel: Kernel) -> set[Kernel]:
    """The kernels that the source of a kernel names."""
    read = (kernel.function.__globals__.get(name) for name, *_ in reading(kernel.function.__code__).names)
    return {other for other in read if isinstance(other, Kernel)}


@functools.cache
def reaches_late(kernel: Kernel) -> bool:
    """Whether a call of a kernel may come to one that is loaded late; one by an address may."""
    found, open_ends = {kernel}, [kernel]
    while open_ends:
        new = called_by(open_ends.pop()) - found
        found |= new
        open_ends += new
    return any(other.may_fail if isinstance(other, Callback) else other.is_late for other in found)


class Callback(Kernel):
    """``callback(address, *arguments)``: call an entry point of a fixed signature by its address.

    So a kernel that serves several problems (an integrator of differential equations) is compiled once. In the
    interpreter the address is a Python function.

    Parameters
    ----------
    signature : str
    may_fail : bool
        Whether what is called may come to an entry point that is loaded late, whose failure is then handed on.
    """

    def __init__(self, signature: str, may_fail: bool = True) -> None:
        super().__init__(_call_back_interpreted, signature)
        self.may_fail = may_fail

    def call_identity(self) -> bytes:
        """What a kernel that calls an address depends on."""
        return super().call_identity() + repr(self.may_fail).encode()

    @functools.cached_property
    def callee(self) -> Any:  # type: ignore[override]
        """What other kernels call: a call of the address, by the fixed signature."""
        from numba.extending import intrinsic

        from nonsmooth.jit.internals import cgutils, sigutils

        arguments, result = sigutils.normalize_signature(self.signature)

        def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
            """The machine code: the integer as a pointer to a function, and its call."""
            pointer, *given = cgutils.unpack_tuple(builder, args[0])
            convention = context.call_conv
            function = builder.inttoptr(pointer, convention.get_function_type(result, arguments).as_pointer())
            return call_through(context, builder, function, result, arguments, given, self.may_fail)

        @intrinsic
        def call(typing_context, *args):  # type: ignore[no-untyped-def]
            """The typing of the call: an address, then the arguments of the signature."""
            from numba import types as nb

            return result(nb.StarArgTuple.from_types(args)), generate

        return call


def _call_back_interpreted(function: Callable, *arguments: Any) -> Any:
    return function(*arguments)


class InDimensions(Kernel):
    """Two entry points, of the plane and of space; a call has d, 2 or 3, as its last argument, ``[d]`` is one of them.

    In compiled code d is a constant, and the other entry point is not loaded.
    """

    def __init__(self, source: Callable, planar: Kernel, spatial: Kernel) -> None:
        self.of = {2: planar, 3: spatial}
        body = "return planar({given}) if d == 2 else spatial({given})"
        super().__init__(_handing_on(source, "{given}, d", body, {"planar": planar, "spatial": spatial}))

    def __getitem__(self, d: int) -> Kernel:
        return self.of[d]

    def __call__(self, *args: Any) -> Any:
        return self.of[args[-1]](*args[:-1])


def in_dimensions(signature: str) -> Callable[[Callable], InDimensions]:
    """Mark a function whose last argument is d as the source of two entry points, of the plane and of space.

    The signature has no d: ``@in_dimensions("void(int64, float64)")`` stands before ``def predict(bodies_at, dt, d)``.
    """

    def entry_points(function: Callable) -> InDimensions:
        source, name = {"source": Kernel(function)}, function.__name__
        planar = _handing_on(function, "{given}", "return source({given}, 2)", source, f"{name}_planar")
        spatial = _handing_on(function, "{given}", "return source({given}, 3)", source, f"{name}_spatial")
        found = InDimensions(function, Kernel(planar, signature), Kernel(spatial, signature))
        for d, entry_point in found.of.items():
            entry_point.place = f"{function.__module__}:{name}[{d}]"
        return found

    return entry_points


def _handing_on(function: Callable, taken: str, body: str, kernels: dict[str, Kernel], name: str = "") -> Callable:
    """A function that hands the arguments of another one, those ``given`` without d, to kernels that its body names."""
    code = function.__code__
    given = ", ".join(argument for argument in code.co_varnames[: code.co_argcount] if argument != "d")
    scope: dict[str, Any] = dict(kernels)
    exec(f"def made({taken}): {body}".format(given=given), scope)
    made: Callable = scope["made"]
    made.__name__ = made.__qualname__ = name or function.__name__
    made.__module__, made.__doc__ = function.__module__, function.__doc__
    return made


def kernel(target: Callable | str, short_loops: bool = False, takes_arrays: bool = False) -> Any:
    """Mark a function as a kernel: ``@kernel`` for inner ones, ``@kernel("int64(float64[::1])")`` for entry points."""
    if isinstance(target, str):
        return lambda function: Kernel(function, target, short_loops, takes_arrays=takes_arrays)
    return Kernel(target)


def rare_kernel(target: Callable | str, short_loops: bool = False) -> Any:
    """Mark a kernel that few steps reach in the same way: an inner one is called, not inlined."""
    if isinstance(target, str):
        return lambda function: Kernel(function, target, short_loops, is_rare=True)
    return Kernel(target, is_rare=True)


def late_kernel(signature: str, short_loops: bool = False) -> Any:
    """Mark an entry point that few runs reach: it is loaded when it is first called."""
    return lambda function: Kernel(function, signature, short_loops, is_rare=True, is_late=True)


@functools.cache
def interpreted(kernel: Kernel) -> Callable:
    """The source of a kernel, and of every kernel it calls, run by the Python interpreter."""
    return rebind(kernel.function, interpreted)


def handle_of(kernel: Kernel, is_compiled: bool) -> Any:
    """What a `Callback` calls an entry point by: its address, or its source for the interpreter."""
    return kernel.address if is_compiled else interpreted(kernel)


def rebind(function: Callable, replace: Callable[[Kernel], Callable]) -> Callable:
    """Copy a function with each kernel among the globals it reads replaced."""
    bound = dict(function.__globals__)
    for name, *_ in reading(function.__code__).names:
        if isinstance(bound.get(name), Kernel):
            bound[name] = replace(bound[name])
    copy = types.FunctionType(function.__code__, bound, function.__name__, function.__defaults__, function.__closure__)
    copy.__module__, copy.__qualname__ = function.__module__, function.__qualname__
    return copy
