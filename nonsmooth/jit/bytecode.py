"""What a code object reads: constants, names, and the attributes that are read from a name at once.

    hh.k(x)                LOAD_GLOBAL hh, LOAD_ATTR k         reads ("hh", "k")
    run.slope_weights[i]   LOAD_FAST run, LOAD_ATTR ...        reads no name: ``run`` is a local variable

An attribute that follows its name at once takes what the name stands for, whatever the branches around it. Functions
within a function (lambdas, inner ``def``, comprehensions) are read with it.

An instruction is two bytes, opcode and argument, and its inline caches follow as zeros (Python's documentation of
``dis``). The 195 kernels of Adaptive are read in 10 ms, by ``dis.get_instructions`` in 90 ms, which every start would
pay. What is read from a probe is compared with its source once a process.
"""

from __future__ import annotations

import dis
import functools
import hashlib
import re
import struct
import sys
import types
from collections.abc import Callable
from typing import Any, NamedTuple

from nonsmooth.errors import UnsupportedVersion


class Reading(NamedTuple):
    """What one code object reads, the code objects within it included."""

    code: bytes  # hash of its instructions, names and constants; not of docstrings, lines and file names
    names: tuple[tuple[str, ...], ...]  # globals, each with the attributes that are read from it at once
    free: tuple[tuple[str, ...], ...]  # likewise variables of enclosing functions
    imports: tuple[str, ...]  # modules that it imports as it runs
    refusal: str  # what it does that cannot be followed, "" for nothing


def scalar(value: Any) -> bytes:
    """The bytes of a value that has no parts, its type included: 1, 1.0 and True differ, 0.0 and -0.0, two NaNs."""
    content = SCALARS[type(value)](value)
    return f"{type(value).__name__} {len(content)} ".encode() + content


SCALARS: dict[type, Callable[[Any], bytes]] = {
    type(None): lambda value: b"",
    type(...): lambda value: b"",
    bool: lambda value: b"1" if value else b"0",
    int: lambda value: hex(value).encode(),  # the decimal form of a large one is refused
    float: lambda value: struct.pack("<d", value),
    complex: lambda value: struct.pack("<dd", value.real, value.imag),
    str: lambda value: value.encode("utf-8", "surrogatepass"),
    bytes: lambda value: value,
}


def constant(value: Any) -> bytes:
    """The bytes of a constant of a code object; code stands for itself by what it reads."""
    if isinstance(value, types.CodeType):
        return b"code " + reading(value).code
    if type(value) is tuple:
        return f"tuple {len(value)} ".encode() + b"".join(map(constant, value))
    if type(value) is frozenset:
        return f"frozenset {len(value)} ".encode() + b"".join(sorted(map(constant, value)))
    if type(value) is slice:
        return b"slice " + constant((value.start, value.stop, value.step))
    return scalar(value)


@functools.lru_cache(maxsize=8192)
def reading(code: types.CodeType) -> Reading:
    """Walk the instructions of a code object.

    Raises
    ------
    UnsupportedVersion
        Where Python's instructions are not those that are known here.
    """
    _require_known_instructions()
    return _Walk(code).reading()


# What an instruction does, as a letter; the letters of a code object are searched for what matters.
READS_NAME, READS_FREE, READS_ATTRIBUTE, STORES_FREE, EXTENDS, CACHES, READS_CONSTANT, IS_REFUSED, IS_OTHER = (
    b"NFASE.KR-"
)
ACTS = {
    "LOAD_GLOBAL": READS_NAME, "LOAD_DEREF": READS_FREE, "LOAD_ATTR": READS_ATTRIBUTE, "LOAD_METHOD": READS_ATTRIBUTE,
    "STORE_DEREF": STORES_FREE, "EXTENDED_ARG": EXTENDS, "CACHE": CACHES,
}  # fmt: skip
# A name or a free variable with the attributes that follow it, a constant, and what may be refused; an argument above
# 255 is extended by instructions before its own.
SEARCH = re.compile(rb"E*[NF]\.*(?:E*A\.*)*|E*[KSR]")
ATTRIBUTES = re.compile(rb"E*A")
HARMLESS = {"STORE_ATTR", "DELETE_ATTR", "MAKE_CELL", "LOAD_CLOSURE"}  # they name something that was read before
IMPORT_NAME, IMPORT_FROM = (dis.opmap[name] for name in ("IMPORT_NAME", "IMPORT_FROM"))  # code: of instructions
REFUSALS = {
    "STORE_GLOBAL": "assigns to a global", "DELETE_GLOBAL": "deletes a global",
}  # fmt: skip
# Bits of the argument below the index of the name: they tell a call from a mere reading.
FLAG_BITS = {"LOAD_GLOBAL": 1, "LOAD_ATTR": 1 if sys.version_info >= (3, 12) else 0}
MADE_BY = 0x3FF  # defined: bits of co_flags that change what a call does; the others tell of docstrings and __future__


def _act(name: str, opcode: int) -> int:
    """What an instruction does. One that names something in a way not known here is refused."""
    if name in ACTS:
        return ACTS[name]
    if opcode in dis.hasconst:
        return READS_CONSTANT
    is_naming = opcode in dis.hasname or opcode in dis.hasfree
    return IS_REFUSED if is_naming and name not in HARMLESS else IS_OTHER


OPCODES = {name: opcode for name, opcode in dis.opmap.items() if opcode < 256}  # those above are the compiler's own
LETTERS = bytearray([IS_OTHER]) * 256
for _name, _opcode in OPCODES.items():
    LETTERS[_opcode] = _act(_name, _opcode)
SHIFTS = {_opcode: FLAG_BITS.get(_name, 0) for _name, _opcode in OPCODES.items()}


class _Walk:
    """One pass over the instructions of a code object."""

    def __init__(self, code: types.CodeType) -> None:
        self.code = code
        inner_cells = [name for name in code.co_cellvars if name not in code.co_varnames]
        self.variables = [*code.co_varnames, *inner_cells, *code.co_freevars]
        self.first_free = len(self.variables) - len(code.co_freevars)
        self.names: dict[tuple[str, ...], None] = {}  # in the order of their first reading
        self.free: dict[tuple[str, ...], None] = {}
        self.constants: list[Any] = []
        self.imports: dict[str, None] = {}
        self.refusal = ""
        self.instructions = bytearray(code.co_code)
        self.acts = bytes(self.instructions[::2]).translate(LETTERS)
        self._walk()

    def _walk(self) -> None:
        constants, instructions = self.code.co_consts, self.instructions
        for match in SEARCH.finditer(self.acts):
            first, end = match.span()
            place = first if end == first + 1 else self.acts.index(match[0].lstrip(b"E")[:1], first)
            act, argument = self.acts[place], self._argument(first, place)
            if act == READS_CONSTANT:
                self.constants.append(constants[argument])
                instructions[2 * place + 1] = 0  # its place shifts where a docstring is added
            elif act == READS_NAME:
                name = self.code.co_names[argument >> SHIFTS[instructions[2 * place]]]
                self.names[name, *self._attributes(place + 1, end)] = None
            elif instructions[2 * place] == IMPORT_NAME:
                self._import(self.code.co_names[argument], place)
            elif act == IS_REFUSED and instructions[2 * place] != IMPORT_FROM:
                self._refuse(instructions[2 * place])
            elif act in (READS_FREE, STORES_FREE) and argument < self.first_free:
                pass
            elif act == READS_FREE:
                self.free[self.variables[argument], *self._attributes(place + 1, end)] = None
            elif act == STORES_FREE:
                self._refuse(dis.opmap["STORE_DEREF"])

    def _argument(self, first: int, last: int) -> int:
        """The argument of the instruction ``last``, extended by those from ``first`` on."""
        return int.from_bytes(self.instructions[2 * first + 1 : 2 * last + 2 : 2], "big")

    def _attributes(self, first: int, end: int) -> list[str]:
        """The names of the attributes that are read by the instructions from ``first`` on."""
        if first == end:
            return []
        places = [(step.start(), step.end() - 1) for step in ATTRIBUTES.finditer(self.acts, first, end)]
        shift = FLAG_BITS["LOAD_ATTR"]
        return [self.code.co_names[self._argument(*place) >> shift] for place in places]

    def _import(self, name: str, place: int) -> None:
        """A module that is imported; one that is named from where the function stands cannot be followed."""
        level = self.instructions[2 * place - 3]  # of LOAD_SMALL_INT, before the list of names
        if self.acts[place - 2] == READS_CONSTANT:
            level = self.constants[-2]
        if level == 0:
            self.imports[name] = None
        else:
            self.refusal = self.refusal or "imports a module relative to its own"

    def _refuse(self, opcode: int) -> None:
        words = "assigns to a variable of the function around it" if opcode in dis.hasfree else ""
        name = dis.opname[opcode]
        self.refusal = self.refusal or REFUSALS.get(name) or words or f"holds the instruction {name}"

    def reading(self) -> Reading:
        """What was found, with what the functions within read."""
        for inner in self.constants:
            if isinstance(inner, types.CodeType):
                found = reading(inner)
                self.names.update(dict.fromkeys(found.names))
                self.free.update(dict.fromkeys(c for c in found.free if c[0] in self.code.co_freevars))
                self.imports.update(dict.fromkeys(found.imports))
                self.refusal = self.refusal or found.refusal
        return Reading(self._hash(), tuple(self.names), tuple(self.free), tuple(self.imports), self.refusal)

    def _hash(self) -> bytes:
        code = self.code
        counts = code.co_argcount, code.co_posonlyargcount, code.co_kwonlyargcount, code.co_flags & MADE_BY
        names = code.co_varnames, code.co_cellvars, code.co_freevars, code.co_names
        parts = repr((counts, names, bytes(self.instructions), code.co_exceptiontable)).encode(
            "utf-8", "backslashreplace"
        )
        return hashlib.sha256(parts + b"".join(map(constant, self.constants))).digest()


@functools.lru_cache(maxsize=8192)
def mentioned(code: types.CodeType) -> frozenset[str]:
    """The attributes that a code object and those within it read, and their texts: what they may ask for is among them.

    Of files that are opened, one that is not only written to is mentioned as ``read``.
    """
    texts = {constant for constant in code.co_consts if isinstance(constant, str)}
    names, is_open = set(), False
    for step in dis.get_instructions(code):
        if step.opname == "LOAD_GLOBAL":
            names |= {"read"} if is_open and step.argval == "open" else set()
            is_open = is_open or step.argval == "open"
        elif step.opcode in dis.hasname and step.opname not in HARMLESS:
            names.add(step.argval)
        elif step.opcode in dis.hasconst and step.argval in TO_WRITE:
            is_open = False
    names |= {"read"} if is_open else set()
    inner = (constant for constant in code.co_consts if isinstance(constant, types.CodeType))
    return frozenset(texts.union(names, *map(mentioned, inner)))


TO_WRITE = {mode + kind for mode in "awx" for kind in ("", "b", "t")}  # defined: modes of open


PROBE = """
def around(local, free):
    def probe(x, y=2.5):
        return free.K * hh.k(x) + pk.c.K + abs(y) + local.run.K + x.K
    return probe
"""
READ_BY_PROBE = (("hh", "k"), ("pk", "c", "K"), ("abs",)), (("free", "K"), ("local", "run", "K"))


@functools.cache
def _require_known_instructions() -> None:
    """The walk finds in a probe what stands there in its source."""
    (around,) = (c for c in compile(PROBE, "<probe>", "exec").co_consts if isinstance(c, types.CodeType))
    (probe,) = (c for c in around.co_consts if isinstance(c, types.CodeType) and c.co_name == "probe")
    walk = _Walk(probe)
    if (tuple(walk.names), tuple(walk.free)) != READ_BY_PROBE or walk.refusal:
        version = ".".join(map(str, sys.version_info[:2]))
        raise UnsupportedVersion(f"the instructions of Python {version} are not known here; use Python 3.11 to 3.14")
