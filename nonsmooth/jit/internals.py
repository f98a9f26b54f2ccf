"""All that is used of numba that is not its public interface: the only file that a new version of numba can break.

Each part has a test in ``tests/jit/test_internals.py``. Imported where something is compiled; a numba outside of the
tested versions is refused then, since a part that means something else there would give wrong numbers in silence.
"""

from __future__ import annotations

import ctypes
import pickle
import re
from collections.abc import Callable
from typing import Any

from nonsmooth.jit.object_code import ObjectCode, object_code
from nonsmooth.jit.surroundings import imported_numba, require_tested

require_tested(imported_numba().__version__)

import llvmlite.binding as llvm
import numba
from llvmlite.binding.ffi import lib as llvm_library
from numba import _helperlib
from numba.core import base as base
from numba.core import ccallback, dispatcher, entrypoints, errors, extending, serialize
from numba.core import cgutils as cgutils
from numba.core import interpreter as interpreter
from numba.core import ir as ir
from numba.core import sigutils as sigutils
from numba.core.codegen import JITCodeLibrary as JITCodeLibrary
from numba.core.compiler import Compiler, CompileResult
from numba.core.datamodel.models import OpaqueModel
from numba.core.datamodel.registry import register_default
from numba.core.imputils import lower_setattr_generic as lower_setattr_generic
from numba.core.ir_utils import build_definitions as build_definitions
from numba.core.lowering import Lower as Lower
from numba.core.registry import cpu_target as cpu_target
from numba.core.rewrites import rewrite_registry as rewrite_registry
from numba.core.ssa import reconstruct_ssa as reconstruct_ssa
from numba.core.typed_passes import NativeLowering as NativeLowering
from numba.core.typed_passes import NoPythonBackend as NoPythonBackend
from numba.core.typed_passes import NopythonTypeInference as NopythonTypeInference
from numba.core.typed_passes import PreLowerStripPhis as PreLowerStripPhis
from numba.core.types import functions as functions
from numba.core.typing import context, templates
from numba.core.typing.templates import AttributeTemplate as AttributeTemplate
from numba.core.untyped_passes import FixupArgs as FixupArgs
from numba.core.untyped_passes import RewriteSemanticConstants as RewriteSemanticConstants
from numba.core.untyped_passes import TranslateByteCode as TranslateByteCode
from numba.np import arrayobj as arrayobj
from numba.np.ufunc import dufunc, gufunc

TypingContext: Any = context.BaseContext
WarningsFixer: Any = errors.WarningsFixer  # type: ignore[attr-defined]
llvm_lock: Any = llvm_library._lock  # of LLVM, with those who listen when it is taken
Dispatcher: Any = dispatcher.Dispatcher
DUFunc: Any = dufunc.DUFunc
GUFunc: Any = gufunc.GUFunc
CFunc: Any = ccallback.CFunc
Intrinsic: Any = extending._Intrinsic


class NoEnvironment:
    """In place of numba's environments, the globals of functions that run by themselves."""

    def set_env(self, name: str, env: Any) -> None:
        """Nothing to set: the function never runs by itself."""


class ModelLibrary(JITCodeLibrary):
    """Machine code whose functions are its own.

    Numba leaves those that were called, not inlined, to the linker, which takes the first one of a name in the process;
    names are counted up, so that two models from the disk may each have a ``helper`` of the same name.
    """

    def _optimize_final_module(self) -> None:
        symbols = {symbol.name for symbol in self._final_module.global_variables}
        for function in self._final_module.functions:
            if is_shared(function) and UNRESOLVED + function.name not in symbols:
                function.linkage = "internal"
        super()._optimize_final_module()


class ApartLibrary(ModelLibrary):
    """The same, called by its address alone, and not linked by numba where it can do without."""

    is_apart = False

    def _finalize_final_module(self) -> None:
        """Make object code, which is linked by itself (`linking`) and goes with its model.

        What numba links stays as long as the process; only code that needs its linker goes there.
        """
        self._finalize_dynamic_globals()
        self.is_apart = is_linked_alone(self)
        if not self.is_apart:
            self._dynamic_globals.clear()  # which are looked for again
            super()._finalize_final_module()
            return
        self._verify_declare_only_symbols()
        self._compiled_object = self._codegen._tm.emit_object(self._final_module)
        self._compiled = self._finalized = True

    @property
    def codegen(self) -> Any:
        """Where numba puts the globals of a function; nowhere for what it does not link."""
        return NoEnvironment() if self.is_apart else self._codegen

    def get_pointer_to_function(self, name: str) -> int:
        """There is none in what is not linked yet."""
        return 0 if self.is_apart else int(super().get_pointer_to_function(name))


class OurCompiler(Compiler):
    """Numba's compiler with a library of ours."""

    library: type = ModelLibrary

    def __init__(self, typingctx: Any, targetctx: Any, _: Any, *rest: Any) -> None:
        library = self.library(targetctx.codegen(), "code")
        library.enable_object_caching()
        super().__init__(typingctx, targetctx, library, *rest)


class ApartCompiler(OurCompiler):
    """Numba's compiler of what is linked by itself."""

    library = ApartLibrary


class ModelType(numba.types.Dummy):  # type: ignore[misc]
    """Numba's type of the functions of a model that are inlined; a value of it has no content."""

    def __init__(self, name: str, result: Any) -> None:
        self.result = result  # of their compilation
        super().__init__(name=f"Model({name})")


register_default(ModelType)(OpaqueModel)


def is_shared(function: Any) -> bool:
    """Whether the linker takes one function for all of its name."""
    return not function.is_declaration and function.linkage == llvm.Linkage.linkonce_odr


UNRESOLVED = ".numba.unresolved$"  # before the name of a function that is looked for as the code runs


# What is kept on disk of a compiled function.


class KeptResults:
    """What a dispatcher asks before it compiles, and hands its result to: numba's interface of a disk cache.

    Parameters
    ----------
    cache_file : CodeFile
    by_address : bool
        Whether the function is called by its address alone, not by the dispatcher.
    """

    def __init__(self, cache_file: Any, by_address: bool = False) -> None:
        self._cache_file, self._by_address = cache_file, by_address

    def load_overload(self, signature: Any, target: Any) -> Any:
        """The compiled function as it was kept, or None."""

        def rebuild(payload: bytes) -> CompileResult | None:
            """The function; what numba implements is made known to the linker where that is needed (0.2 s)."""
            if object_code(payload) is not None:  # which did not link
                return None
            stands_alone, parts = pickle.loads(payload)
            if not stands_alone:
                target.refresh()
            return CompileResult._rebuild(target, *parts)

        return self._cache_file.load(rebuild)

    def save_overload(self, signature: Any, result: CompileResult) -> None:
        """Keep a compiled function, if it can run in another process: its object code alone where that is enough."""
        if not can_be_kept(result):
            return
        is_alone = stands_alone(result)
        if is_alone and self._by_address:
            self._cache_file.save(object_code_of(result).to_bytes())
        else:
            self._cache_file.save(serialize.dumps((is_alone, result._reduce())))

    @property
    def cache_path(self) -> str:
        """The file."""
        return str(self._cache_file.path)


# defined: what the linker knows without numba: LLVM's own operations, Python, our slots, the C library
KNOWN_SYMBOLS = re.compile(
    r"llvm\.|_?Py|nonsmooth\.|(a?(sin|cos|tan)h?|atan2|exp(m1)?|log(1p)?|pow|sqrt|hypot|erfc?|fmod|frexp|ldexp)$"
)
HELPERS = {f"numba_{name}" for name in vars(_helperlib)["c_helpers"]}  # defined: numba's own, known as well


def stands_alone(result: Any) -> bool:
    """Whether compiled code calls nothing that numba makes known to the linker as it loads its registries (counted
    memory, hashes), or as a function is initialised."""
    return not result.reload_init and all(
        name in HELPERS or KNOWN_SYMBOLS.match(name) for name in declared(result.library)
    )


def declared(library: Any) -> list[str]:
    """The names of what compiled code calls or reads and does not have itself."""
    module = library._final_module
    return [each.name for each in (*module.functions, *module.global_variables) if each.is_declaration]


def is_linked_alone(library: Any) -> bool:
    """Whether compiled code calls nothing but what the linker knows in this process, and reads no array in place."""
    symbols = library._final_module.global_variables
    is_resolved = not any(symbol.name.startswith(UNRESOLVED) for symbol in symbols)
    # numba has _reload_init, of what runs in parallel, from 0.62 on
    is_free = is_resolved and not library._dynamic_globals and not getattr(library, "_reload_init", None)
    return is_free and all(KNOWN_SYMBOLS.match(name) or llvm.address_of_symbol(name) for name in declared(library))


def can_be_kept(result: Any) -> bool:
    """Whether compiled code holds no address of this process, as of an array that it reads in place, no loop that runs
    in the interpreter, and no call that is resolved as it runs: of functions that call each other, which end a later
    process by a signal (numba's own cache keeps them)."""
    symbols = result.library._final_module.global_variables
    return (
        not result.library.has_dynamic_globals
        and all(loop.can_cache for loop in result.lifted)
        and not any(symbol.name.startswith(UNRESOLVED) for symbol in symbols)
    )


def object_code_of(result: Any) -> ObjectCode:
    """The object code of a function that was just compiled."""
    needed = tuple(name for name in declared(result.library) if not name.startswith("llvm."))
    return ObjectCode(result.fndesc.llvm_func_name, needed, result.library._get_compiled_object())


def keep_results(dispatcher: Any, cache_file: Any, by_address: bool) -> None:
    """Let a dispatcher read and fill a file of machine code."""
    dispatcher._cache = KeptResults(cache_file, by_address)


class Raised(ctypes.Structure):
    """What a function hands back of an exception: the class, the arguments and the place, pickled."""

    _fields_ = [("pickled", ctypes.c_void_p), ("size", ctypes.c_int32)]  # noqa: RUF012


def exception_at(address: Any) -> BaseException:
    """The exception that compiled code raised, by where it says which."""
    raised = Raised.from_address(address)
    kind, arguments, *_ = pickle.loads(ctypes.string_at(raised.pickled, raised.size))
    return kind(*arguments or ())  # type: ignore[no-any-return]


def unlinked_code(dispatcher: Any) -> bytes:
    """The object code of the one function that a dispatcher has compiled, where numba did not link it; else nothing."""
    result = next(iter(dispatcher.overloads.values()))
    return object_code_of(result).to_bytes() if getattr(result.library, "is_apart", False) else b""


def machine_code_of(dispatcher: Any) -> int:
    """The address of the one function that a dispatcher has compiled, without numba's wrapper for Python."""
    result = next(iter(dispatcher.overloads.values()))
    return int(result.library.get_pointer_to_function(result.fndesc.llvm_func_name))


# What users compile with numba: its source, and the same compiled afresh.


def source_of(value: Any) -> tuple[str, Any] | None:
    """A description and the Python function of what numba compiled, or of a type; None for anything else."""
    if isinstance(value, numba.types.Type):
        text = str(value)
        return None if " at 0x" in text else (f"type {text}", None)
    found = _facts_of(value)
    if found is None or " at 0x" in repr(found[0]):  # an option that is an object of this process
        return None
    return f"{type(value).__name__} {found[0]!r}", found[1]


def _facts_of(value: Any) -> tuple[Any, Any] | None:
    """The options and the Python function of an object that numba compiled for this processor."""
    if isinstance(value, Dispatcher):
        if value.targetdescr is not cpu_target or value._compiler.pipeline_class is not Compiler:
            return None
        return (sorted(value.targetoptions.items()), sorted(value.locals.items()), _fixed(value)), value.py_func
    if isinstance(value, DUFunc):
        return (sorted(value.targetoptions.items()), value.identity, _signatures(value)), value._dispatcher.py_func
    if isinstance(value, GUFunc):
        made = value.gufunc_builder
        facts = sorted(made.targetoptions.items()), made.signature, made.writable_args, _signatures(value)
        return facts, made.py_func
    if isinstance(value, CFunc):
        return (sorted(value._compiler.targetoptions.items()), str(value._sig)), value._pyfunc
    if isinstance(value, Intrinsic):
        return (sorted(value._ctor_kwargs.items()), value._prefer_literal), value._defn
    return None


def _fixed(dispatcher: Any) -> list[Any] | None:
    """The signatures that a dispatcher was given, None for one that compiles for any."""
    return None if dispatcher._can_compile else [result.signature for result in dispatcher.overloads.values()]


def _signatures(ufunc: Any) -> list[Any]:
    """The signatures that a ufunc was given, none for one that compiles for any."""
    if not ufunc._frozen:
        return []
    if isinstance(ufunc, GUFunc):
        return list(ufunc.gufunc_builder._sigs)
    return [result.signature for result in ufunc._dispatcher.overloads.values()]


def twin_of(value: Any, function: Callable) -> Any:
    """A compiled object like this one, of another Python function; nothing is compiled before `finish_twin`."""
    if isinstance(value, Dispatcher):
        return type(value)(function, value.locals, value.targetoptions)
    if isinstance(value, DUFunc):
        return numba.vectorize((), identity=value.identity, **value.targetoptions)(function)
    if isinstance(value, GUFunc):
        made = value.gufunc_builder
        types = () if value._is_dynamic else ((),)
        return numba.guvectorize(*types, made.signature, writable_args=made.writable_args, **made.targetoptions)(
            function
        )
    if isinstance(value, CFunc):  # as a function: the address of a callback is another one in each process
        return numba.njit(**value._compiler.targetoptions)(function)
    return numba.extending.intrinsic(prefer_literal=value._prefer_literal, **value._ctor_kwargs)(function)


def finish_twin(twin: Any, value: Any) -> None:
    """Compile it for the signatures that the other one was given, if any, and for these alone."""
    if isinstance(value, CFunc):
        twin.compile(value._sig)
        twin.disable_compile()
    elif isinstance(value, Dispatcher) and not value._can_compile:
        for signature in _fixed(value) or ():
            twin.compile(signature)
        twin.disable_compile()
    elif isinstance(value, DUFunc | GUFunc) and value._frozen:
        for signature in _signatures(value):
            twin.add(signature)
        twin.disable_compile()
        twin.build_ufunc()


def extensions() -> list[Callable]:
    """The Python functions by which others than numba extended it, for functions and types that are not theirs."""
    entrypoints.init_all()  # as numba does before it compiles: the packages that announce themselves
    registry = templates.builtin_registry
    found = [*registry.functions, *registry.attributes]
    own = [getattr(template, "_overload_func", None) for template in found]
    # what numba itself writes as text and executes belongs to no module
    return [f for f in own if f is not None and f.__module__ and not f.__module__.startswith("numba.")]
