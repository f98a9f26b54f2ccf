"""A loop compiled once more for one system: what it calls is a part of it, and what is constant in its blocks is known.

    generic      loop -> step by its address -> the functions by their address; places and lengths are read from blocks
    specialised  one function: callbacks, slots and the functions of the model inlined; places, lengths, options and
                 kinds of contact are constants of the code

The arithmetic is the same in the same order, and so are the bits. Measured, ns a step, generic and specialised, and a
loop in C that has everything built in: ball 36, 12; belt oscillator 148, 98; rod that slides 169, 84, C 52. It takes
some 3 s to compile, and is kept on disk for this system (docs/benchmarks/core.md).
"""

from __future__ import annotations

import contextlib
from typing import Any, NamedTuple

from nonsmooth.jit.beside import begin
from nonsmooth.jit.blocks import Known, view, view_with
from nonsmooth.jit.cache import cache_directory, is_cached, is_usable, key_of, machine_code
from nonsmooth.jit.kernels import KERNEL_OPTIONS, Callback, Kernel, inner_dispatcher, make_slots_known, rebind
from nonsmooth.jit.linking import function_at
from nonsmooth.jit.models import Source, inlined_model
from nonsmooth.jit.waiting import sentence, silent, waiting

COMPILE_TIME = 4.0  # measured: s


class Parts(NamedTuple):
    """What a loop is made specially from."""

    loop: Kernel
    step_at: Callback  # which the loop calls its step by
    step: Kernel
    inlined: tuple[Kernel, ...]  # entry points that are called through their slots elsewhere
    known: tuple[tuple[type, Known], ...]  # constants of blocks by their class, without the model
    model_of: type  # the block whose handle is the model
    survey: str  # what distinguishes the functions of the model from others


class Specialised:
    """The loop of one system; called, and addressed, as the generic one is.

    Parameters
    ----------
    parts : Parts
    source : tuple
        Arguments of `compile_model`.

    Attributes
    ----------
    compiled : callable
        What Python calls, once it is loaded.
    address : int
        Where its machine code begins: what a `Callback` calls; 0 before it is loaded.
    """

    compiled: Any = None
    address = 0
    is_begun = False  # whether a thread compiles it
    refusal: BaseException | None = None  # why that could not

    def __init__(self, parts: Parts, source: Source) -> None:
        self.parts, self.source = parts, source
        kernels = (parts.loop, parts.step, *parts.inlined)
        identities = b"".join(kernel.call_identity() for kernel in kernels)
        facts = repr([(cls.__qualname__, known) for cls, known in parts.known])
        self.key = key_of(identities + facts.encode() + parts.survey.encode())
        self.name = f"{parts.loop.function.__name__}-of-one-system"

    @property
    def is_on_disk(self) -> bool:
        """Whether an earlier process compiled it."""
        return is_cached(self.name, self.key)

    def time_to_load(self) -> float:
        """About how long it takes until it can be called, where it has to be compiled [s]."""
        return 0.0 if self.address or self.is_on_disk else COMPILE_TIME

    def load(self) -> None:
        """Compile it, or read it from disk, unless this process has it."""
        if self.address:
            return
        loop = self.parts.loop
        signature = loop.signature or ""
        make_slots_known([loop, self.parts.step, *self.parts.inlined])
        with contextlib.nullcontext() if self.is_on_disk else waiting(words):
            self.code = machine_code(self._bound, signature, self.name, self.key, self._options)
        self.compiled = function_at(self.code.address, signature)
        self.address = self.code.address

    def _options(self) -> dict[str, Any]:
        from nonsmooth.jit.kernel_compiler import EntryLibrary, OneSystemLibrary, compiler_of

        library = OneSystemLibrary if self.parts.loop.short_loops else EntryLibrary
        return {**KERNEL_OPTIONS, "pipeline_class": compiler_of(library)}

    def load_beside(self) -> None:
        """Begin to compile it in a thread of its own; it can be called once ``address`` is known."""
        if self.is_begun:
            return
        self.is_begun = True

        def work() -> None:
            try:
                with silent():
                    self.load()
            except Exception as reason:
                self.refusal = reason
            finally:
                self.is_begun = False

        begin(work)

    def _bound(self) -> Any:
        """The source of the loop with what it calls in its place."""
        parts = self.parts
        model = inlined_model(self.source, parts.survey)
        known = {cls: facts._replace(model=model) if cls is parts.model_of else facts for cls, facts in parts.known}
        return rebind(parts.loop.function, Callees(parts, view_with(known)).of)


def words() -> str:
    """What is said while one is compiled."""
    folder = cache_directory() if is_usable() else None
    return sentence("a loop for this system alone", "its steps pay for it, or specialise=True", COMPILE_TIME, folder)


class Callees:
    """What the kernels of a loop call in the place of one another.

    Parameters
    ----------
    parts : Parts
    view : intrinsic
        That of `view_with`.
    """

    def __init__(self, parts: Parts, view: Any) -> None:
        self.parts, self.view = parts, view
        self._made: dict[Kernel, Any] = {}

    def of(self, kernel: Kernel) -> Any:
        """What is called for a kernel."""
        if kernel is view:
            return self.view
        if kernel is self.parts.step_at:
            return self._without_address(self._inner(self.parts.step))
        return self._inner(kernel) if kernel in self.parts.inlined else kernel.callee

    def _inner(self, entry: Kernel) -> Any:
        """An entry point as a part of the loop."""
        if entry not in self._made:
            self._made[entry] = inner_dispatcher(rebind(entry.function, self.of))
        return self._made[entry]

    def _without_address(self, step: Any) -> Any:
        """The step as it is called by its address, which is not asked for."""

        def call(address, sys, t, dt, state, memory):  # type: ignore[no-untyped-def]
            return step(sys, t, dt, state, memory)

        return inner_dispatcher(call)
