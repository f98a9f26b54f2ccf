"""Compilation: the only package that touches numba, and only where something is compiled.

Two kinds of function are compiled.

*Kernels* are ours. ``@kernel`` marks a plain function written for arrays and scalars; nothing happens, and numba is not
imported, until the kernel is first called. A kernel that carries a signature is an *entry point*: it is compiled once,
with the kernels it calls, and kept on disk under a hash of all that it is made from. An entry point calls another
through a slot that ``load`` fills: LLVM does not optimise the inner one again in each outer one, and what a scene does
not need is never compiled.
``interpreted(kernel)`` is the same source run by Python.

*Model functions* are the user's. ``compile_model`` binds them all into one function

    model(which, t, q*, u*, p*, out*)        which = MASS, FORCE, GAP, ...

and returns its machine address, an integer that the compiled loops receive as an argument and call through
``call_model``. So a loop is compiled once for every model, and a model once for every parameter value. A call costs
about 2 ns more than a C function pointer; handing dispatchers to the loop instead would compile the loop again for
every model (2 s each) and never reach the disk cache.

A loop that takes very many steps of one system is compiled once more for it alone, with all that it calls inlined and
sizes and options built in (``specialised``).

``kernels`` marks them, ``models`` binds a user's functions, whose helpers ``twins`` compiles with them and whose ``p``
``parameters`` makes; ``own_law`` is a friction law of the user's; ``internals`` has what is used of numba that is not
its public interface, of which ``kernel_compiler`` and ``kernel_lowering`` make what compiles kernels. ``late`` loads
what few runs reach when it is first called. ``fingerprint`` says what code is made from, by what ``bytecode`` finds
that it reads and ``libraries`` know by name, ``content`` what else is known again; ``watch`` whether that is still so,
``surroundings`` on what else it depends; ``cache`` under which key it is kept, ``code_files`` in which form;
``linking`` calls it in a later process, without numba; ``loading`` shares the work between processes, which take
``turns``; ``elsewhere`` leaves all of it to others.
"""

from nonsmooth.jit.cache import MachineCode, cache_directory, key_of
from nonsmooth.jit.content import identity
from nonsmooth.jit.kernels import (
    Callback,
    InDimensions,
    Kernel,
    handle_of,
    in_dimensions,
    interpreted,
    kernel,
    late_kernel,
    rare_kernel,
)
from nonsmooth.jit.late import running_time, waited
from nonsmooth.jit.loading import load_all
from nonsmooth.jit.models import CannotCompile, call_model, compile_model, survey_of
from nonsmooth.jit.own_law import call_law
from nonsmooth.jit.parameters import Unpack, unpack_of

__all__ = [
    "Callback", "CannotCompile", "InDimensions", "Kernel", "MachineCode", "Unpack", "cache_directory", "call_law",
    "call_model", "compile_model", "handle_of", "identity", "in_dimensions", "interpreted", "kernel", "key_of",
    "late_kernel", "load_all", "rare_kernel", "running_time", "survey_of", "unpack_of", "waited",
]  # fmt: skip
