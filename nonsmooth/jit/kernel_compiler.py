"""How kernels are compiled: numba's compiler, without what it does over again and kernels do not need.

A kernel that carries a signature, an entry point, becomes one module of LLVM's code with all the kernels that it calls.
Each of these goes through numba once (source, types, code of LLVM), and through LLVM as a part of the entry point.
Most of the time is numba's, in Python. Left out are, with their part of the time that the entry points of a step took:

    passes that look for what no kernel has, and lists of the variables alive, made again after each pass     7 %
    `del` of a variable, since kernels count no references                                                    6 %
    LLVM's passes on a function by itself, before it is inlined and goes through them again, and those on a
    module that numba takes twice, to find counted references between                                        10 %
    linking of each function into each that calls it                                                          5 %
    imports and registries looked through for each operation, and who listens to LLVM's lock                  5 %
    items of arrays and loops as numba writes them (`kernel_lowering`)                                       13 %
    two rewrites that ask each statement what it reads, and warnings collected for each type                  4 %
"""

from __future__ import annotations

import contextlib
import functools
from collections.abc import Callable, Iterator
from typing import Any

import llvmlite.binding as llvm
import numba

from nonsmooth.jit.beside import go_on
from nonsmooth.jit.internals import (
    FixupArgs,
    JITCodeLibrary,
    NoEnvironment,
    NoPythonBackend,
    NopythonTypeInference,
    OurCompiler,
    PreLowerStripPhis,
    RewriteSemanticConstants,
    TranslateByteCode,
    TypingContext,
    WarningsFixer,
    arrayobj,
    base,
    build_definitions,
    cpu_target,
    functions,
    interpreter,
    is_shared,
    llvm_lock,
    reconstruct_ssa,
    rewrite_registry,
)
from nonsmooth.jit.kernel_lowering import KernelLowering

# Libraries: kernels are inlined in the entry points that call them.


class InnerLibrary(JITCodeLibrary):
    """Intermediate code only, to be inlined in the entry points that call it.

    Machine code for each of the fifty functions of a step would be made and never run.
    """

    codegen = NoEnvironment()
    inlining: tuple[str, ...] = ("alwaysinline",)

    def add_ir_module(self, ir_module: Any) -> None:
        """Mark the functions of a module, and take it in; the entry point is verified as a whole."""
        for function in ir_module.functions:
            if not function.is_declaration:
                for each in self.inlining:
                    function.attributes.add(each)
        module = llvm.parse_assembly(str(ir_module))
        module.name, module.data_layout = ir_module.name, self._codegen._data_layout
        self._final_module.link_in(module)
        for function in self._final_module.functions:
            if not function.is_declaration:
                function.linkage = "linkonce_odr"  # a part of each that calls it

    def finalize(self) -> None:
        """Left to the entry point: neither linked nor optimised."""
        self._finalized = True

    def get_pointer_to_function(self, name: str) -> int:
        """There is no machine code to point to."""
        return 0

    def _get_module_for_linking(self) -> Any:
        """For libraries of numba's own, which link what they call and not what that calls."""
        module = self._final_module.clone()
        for part in parts_of(self)[1:]:
            module.link_in(own_module(part), preserve=True)
        return module


class RareLibrary(InnerLibrary):
    """Intermediate code that is never inlined."""

    inlining = ("noinline",)


class HelperLibrary(InnerLibrary):
    """Intermediate code that is inlined where LLVM finds that worth it."""

    inlining = ()


def parts_of(library: Any) -> list[Any]:
    """A library with those that it calls, and what inner ones call, each once and after all that call it.

    Those of numba's own are the last: every library names numba's counted memory, and the linker leaves out what nobody
    has called so far. Who calls it later would take any function of that name in the process.
    """
    found, open_ends = {library: None}, [library]
    while open_ends:
        each = open_ends.pop()
        if each is library or isinstance(each, InnerLibrary):
            new = [part for part in each._linking_libraries if part not in found]
            found.update(dict.fromkeys(new))
            open_ends += new
    return sorted(found, key=lambda part: part is not library and not isinstance(part, InnerLibrary))


def own_module(library: Any) -> Any:
    """The code of a library; of an inner one without what it calls."""
    is_inner = isinstance(library, InnerLibrary)
    return library._final_module if is_inner else library._get_module_for_linking()


class EntryLibrary(JITCodeLibrary):
    """Machine code in which all but the rare kernels are inlined.

    A call would hand arrays over word by word, and LLVM's own judgement spares it too few (a step of the rod: 620 ns,
    inlined 470).
    """

    has_short_loops, unrolls, level = False, False, 3

    def finalize(self) -> None:
        """Link all that is called, each part once, and make machine code."""
        for part in parts_of(self)[1:]:
            self._final_module.link_in(own_module(part), preserve=True)
        self._linking_libraries.clear()
        call_c_library(self._final_module)
        super().finalize()

    def _optimize_final_module(self) -> None:
        self._run_passes(self.level)

    def _run_passes(self, level: int) -> None:
        """LLVM's passes of a level on the module; those of level 0 inline what is marked so, and no more."""
        for function in self._final_module.functions:
            if is_shared(function):
                function.linkage = "internal"
        tuning = llvm.create_pipeline_tuning_options(speed_level=level)
        tuning.slp_vectorization = False
        tuning.loop_vectorization = not self.has_short_loops
        tuning.loop_unrolling = self.unrolls or not self.has_short_loops
        passes = llvm.create_pass_builder(self._codegen._tm, tuning)
        passes.getModulePassManager().run(self._final_module, passes)


def call_c_library(module: Any) -> None:
    """Let functions that numba has in its own library, of finite numbers the same, be those of C: a later process links
    them without numba."""
    for function in module.functions:
        name = function.name.removeprefix("numba_")
        if name in OF_C_LIBRARY and name != function.name and llvm.address_of_symbol(name):
            function.name = name


OF_C_LIBRARY = ("frexp", "ldexp")


class ShortLoopLibrary(EntryLibrary):
    """The same without LLVM's vectorizer and unroller of loops."""

    has_short_loops = True


class RareEntryLibrary(ShortLoopLibrary):
    """Machine code that few steps reach, by LLVM's first level: half of its time, a third of which is GVN's, and the
    same bits (measured: with it for all entry points runs of `python -m benchmarks accuracy` take 4 % longer)."""

    level = 1

    def _optimize_functions(self, module: Any) -> None:
        """Left to the whole: LLVM unrolls a loop of two or four calls, which are inlined so many times then."""
        module.data_layout = self._codegen._data_layout


def library_of(has_short_loops: bool, is_rare: bool) -> Any:
    """The library of an entry point."""
    if is_rare:
        return RareEntryLibrary
    return ShortLoopLibrary if has_short_loops else EntryLibrary


class OneSystemLibrary(ShortLoopLibrary):
    """The same with the unroller: where sizes are known loops end as straight lines (measured: 4 to 9 % of a step).

    LLVM finds what is constant in a function before it inlines it (measured: half of a step of the ball without), and
    in the whole once before the passes of its level: loops whose ends are found there are unrolled early enough for
    what they store to be followed (measured: 9 % of a step of the rod).
    """

    unrolls = True

    def _optimize_final_module(self) -> None:
        self._optimize_functions(self._final_module)
        self._run_passes(0)
        self._optimize_functions(self._final_module)
        super()._optimize_final_module()


# Compilers.


class KernelPasses:
    """Numba's passes, in its order.

    Left out are those that look for closures, generators of loops over tuples, lists, contexts, functions to be inlined
    by numba, and sums of whole arrays: there are none in kernels. Nor are variables listed that are alive, nor deleted
    where they are not: kernels own no memory.
    """

    pipeline_name = "kernel"

    def __init__(self) -> None:
        self.exec_times: dict[str, Any] = {}  # which numba asks for

    def run(self, state: Any) -> None:
        """From the source to a library."""
        TranslateByteCode().run_pass(state)
        FixupArgs().run_pass(state)
        RewriteSemanticConstants().run_pass(state)
        rewrite(state)
        state.func_ir = defined(reconstruct_ssa(state.func_ir))
        NopythonTypeInference().run_pass(state)
        state.func_ir = defined(PreLowerStripPhis()._strip_phi_nodes(state.func_ir))
        KernelLowering().run_pass(state)
        NoPythonBackend().run_pass(state)


def rewrite(state: Any) -> None:
    """Numba's rewriting before types are known, as of constant indices."""
    blocks = state.func_ir.blocks
    for rule in rewrite_registry.rewrites["before-inference"]:
        each = rule(state)
        for place in list(blocks):
            while each.match(state.func_ir, blocks[place], state.typemap, state.calltypes):
                blocks[place] = each.apply()


def defined(source: Any) -> Any:
    """Numba's form of a source, after variables were renamed, with the places where they are assigned."""
    source._definitions = build_definitions(source.blocks)
    return source


class KernelCompiler(OurCompiler):
    """Numba's compiler with these passes, and with the shortcuts below."""

    def define_pipelines(self) -> list[Any]:
        """The passes that kernels need."""
        return [KernelPasses()]

    def compile_extra(self, function: Callable) -> Any:
        """Compile with the shortcuts, unless nobody waits for it any more."""
        go_on()
        constants = plain_arguments() if self.library is RareEntryLibrary else contextlib.nullcontext()
        with contextlib.ExitStack() as shortcuts:
            for shortcut in SHORTCUTS:
                shortcuts.enter_context(shortcut())
            shortcuts.enter_context(constants)
            return super().compile_extra(function)


@functools.cache
def compiler_of(library: type) -> type:
    """The compiler class of kernels that makes this kind of library."""
    return type("KernelCompiler", (KernelCompiler,), {"library": library})


class InlinedCompiler(OurCompiler):
    """The compiler of model functions that become a part of the entry point that calls them."""

    library = InnerLibrary


class HelperCompiler(OurCompiler):
    """The compiler of functions that model functions call, which become a part of the model."""

    library = HelperLibrary


# Shortcuts, while a kernel is compiled.


@contextlib.contextmanager
def replaced(owner: Any, name: str, value: Any) -> Iterator[None]:
    """Put another value in the place of an attribute for a while."""
    before = getattr(owner, name)
    setattr(owner, name, value)
    try:
        yield
    finally:
        setattr(owner, name, before)


def no_negative_indices() -> Any:
    """Compile without Python's negative indices: kernels use none, and the test for them costs as much as the sum it is
    in (a step of the rod: 410 ns with it)."""

    def index(context: Any, builder: Any, kind: Any, value: Any, size: Any) -> Any:
        """The index as it is."""
        return context.cast(builder, value, kind, numba.types.intp)

    return replaced(arrayobj, "fix_integer_index", index)


def known_calls() -> Any:
    """Keep what an operation on given types resolves to: numba asks each of its dozen overloads of ``a + b`` again for
    every ``+`` in the source (the first use of a scene: 13 s without)."""
    before = functions.Function.get_call_type

    def resolve(self: Any, context: Any, args: Any, keywords: Any) -> Any:
        """What is known, else numba's own answer."""
        if keywords:
            return before(self, context, args, keywords)
        if (self, args) not in _resolved_calls:
            _resolved_calls[self, args] = before(self, context, args, keywords)
        return _resolved_calls[self, args]

    return replaced(functions.Function, "get_call_type", resolve)


_resolved_calls: dict[Any, Any] = {}


def known_attributes() -> Any:
    """Keep the type of an attribute of a type in the same way; that of a module's is the type of its value."""
    before = TypingContext.resolve_getattr

    def resolve(self: Any, kind: Any, name: str) -> Any:
        """What is known, else numba's own answer."""
        if isinstance(kind, numba.types.Module):
            return before(self, kind, name)
        if (kind, name) not in _resolved_attributes:
            _resolved_attributes[kind, name] = before(self, kind, name)
        return _resolved_attributes[kind, name]

    return replaced(TypingContext, "resolve_getattr", resolve)


_resolved_attributes: dict[Any, Any] = {}


def no_listeners() -> Any:
    """Call LLVM without calling those who measure its time: numba does so twice at each of some thousand calls."""
    return replaced(llvm_lock, "_cblist", [])


@contextlib.contextmanager
def no_contexts_and_dictionaries() -> Iterator[None]:
    """Leave out two rewrites of what no kernel has, each of which asks every statement what it reads."""
    with (
        replaced(interpreter, "peep_hole_delete_with_exit", _as_it_is),
        replaced(interpreter, "peep_hole_fuse_dict_add_updates", _as_it_is),
    ):
        yield


def _as_it_is(source: Any) -> Any:
    return source


def no_collected_warnings() -> Any:
    """Issue warnings of numba's as they come: to collect them it sets up Python's filters for each of some thousand
    types that it looks for."""
    return replaced(WarningsFixer, "catch_warnings", lambda *_, **__: _nothing)


_nothing = contextlib.nullcontext()


def plain_arguments() -> Any:
    """Compile what is called with a constant here and with a variable there once: to numba each constant is a type of
    its own (a fifth of the functions of an event-driven run). For rare entry points, with what is compiled for them:
    LLVM finds it where it inlines the call, but steps of Moreau–Jean took 4 to 6 % longer so."""
    before = functions.Dispatcher.get_call_type

    def resolve(self: Any, context: Any, args: Any, keywords: Any) -> Any:
        """Numba's answer for the types of the constants."""
        return before(self, context, tuple(map(numba.types.unliteral, args)), keywords)

    return replaced(functions.Dispatcher, "get_call_type", resolve)


@contextlib.contextmanager
def known_registries() -> Iterator[None]:
    """Look for new overloads in the registries that are known: numba goes through the imports of all its modules that
    have some, for each operation that it does not find at once. And ask each implementation for its arguments once."""

    def load(self: Any) -> None:
        """What is new in those that were loaded as the compiler was made."""
        for registry in list(self._registries):
            self.install_registry(registry)

    with (
        replaced(type(cpu_target.target_context), "load_additional_registries", load),
        replaced(base, "_has_loc", _has_loc),
    ):
        yield


_has_loc = functools.cache(base._has_loc)

SHORTCUTS = (
    no_negative_indices, known_calls, known_attributes, known_registries, no_listeners, no_contexts_and_dictionaries,
    no_collected_warnings,
)  # fmt: skip
