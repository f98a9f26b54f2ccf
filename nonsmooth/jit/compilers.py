"""How numba compiles kernels: pipelines, libraries, and what it is spared."""

from __future__ import annotations

import contextlib
import functools
from collections.abc import Callable, Iterator
from typing import Any

OPTIONS = {"nogil": True, "error_model": "numpy"}  # no fastmath: two runs agree bit for bit
# Kernels allocate nothing, so they need none of numba's reference counts.
KERNEL_OPTIONS = {**OPTIONS, "_nrt": False}


@functools.cache
def compiler(kind: str, short_loops: bool = False) -> type:
    """The compiler class of inner kernels, of rare ones and of entry points.

    An inner kernel stops at LLVM's intermediate code: machine code for each of the fifty functions of a step would be
    made and never run. An entry point inlines them all: a call would hand arrays over word by word, and LLVM's own
    judgement spares it too few (a step of the rod: 620 ns, inlined 470).
    """
    import llvmlite.binding as llvm
    from numba.core.codegen import JITCodeLibrary
    from numba.core.compiler import Compiler

    class NoEnvironment:
        """In place of numba's environments, the globals of functions that run by themselves."""

        def set_env(self, name: str, env: Any) -> None:
            """Nothing to set: an inner kernel never runs by itself."""

    class InnerLibrary(JITCodeLibrary):
        """Intermediate code only, to be inlined in the entry points that call it."""

        codegen = NoEnvironment()
        inlining = "alwaysinline"

        def add_ir_module(self, ir_module: Any) -> None:
            """Mark the functions of a module, and take it in."""
            for function in ir_module.functions:
                if not function.is_declaration:
                    function.attributes.add(self.inlining)
            super().add_ir_module(ir_module)

        def _optimize_final_module(self) -> None:
            """Left to the entry point."""

        def _finalize_final_module(self) -> None:
            self._finalize_dynamic_globals()
            self._finalized = True

        def get_pointer_to_function(self, name: str) -> int:
            """There is no machine code to point to."""
            return 0

    class RareLibrary(InnerLibrary):
        """Intermediate code that is never inlined."""

        inlining = "noinline"

    class EntryLibrary(JITCodeLibrary):
        """Machine code in which all but the rare kernels are inlined."""

        def _optimize_final_module(self) -> None:
            for function in self._final_module.functions:
                if not function.is_declaration and function.linkage == llvm.Linkage.linkonce_odr:
                    function.linkage = "internal"
            if not short_loops:
                return super()._optimize_final_module()
            tuning = llvm.create_pipeline_tuning_options(speed_level=3)
            tuning.loop_vectorization = tuning.slp_vectorization = tuning.loop_unrolling = False
            passes = llvm.create_pass_builder(self._codegen._tm, tuning)
            passes.getModulePassManager().run(self._final_module, passes)

    libraries: dict[str, Any] = {"inner": InnerLibrary, "rare": RareLibrary, "entry": EntryLibrary}

    class KernelCompiler(Compiler):
        """Numba's compiler with the library of this kind."""

        def __init__(self, typingctx: Any, targetctx: Any, _: Any, *rest: Any) -> None:
            library = libraries[kind](targetctx.codegen(), "kernel")
            library.enable_object_caching()
            super().__init__(typingctx, targetctx, library, *rest)

        def compile_extra(self, function: Callable) -> Any:
            """Compile with the two shortcuts below."""
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
        """The index as it is."""
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
        """What is known, else numba's own answer."""
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
