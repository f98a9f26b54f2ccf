"""Blocks: the arrays of a run, seen by kernels as one pointer.

A block is a NamedTuple of arrays (and of other blocks). In the interpreter it is that tuple. To compiled code it is the
address of a table with four words a field, (data, n_0, n_1, n_2), and ``block.M`` loads the view when it is needed.
Handing tuples of arrays down by value instead made the step loop compile for 110 s and a step cost 900 ns.

    class Work(NamedTuple):
        h: Vector
        M: Matrix

    block = new_block(Work, {"h": (n,), "M": (n, n)})     # Python: block.address, block.arrays.h
    work = view(address, Work)                            # kernel: work.h[0]
"""

from __future__ import annotations

import functools
import math
import typing
from collections.abc import Callable, Iterator
from typing import Annotated, Any, NamedTuple

import numpy as np

from nonsmooth.jit import Kernel

Vector = Annotated[np.ndarray, "float64", 1]
Matrix = Annotated[np.ndarray, "float64", 2]
Cube = Annotated[np.ndarray, "float64", 3]
Integers = Annotated[np.ndarray, "int64", 1]
IntegerTable = Annotated[np.ndarray, "int64", 2]

WORD = 8  # bytes of every entry
FIELD_WORDS = 4  # data address and three lengths

Shapes = typing.Mapping[str, typing.Any] | tuple  # field -> shape, or the shapes of a nested block


@functools.cache
def field_types(cls: type) -> dict[str, Any]:
    """``field -> (dtype, axes)``, or the class of a nested block."""
    hints = typing.get_type_hints(cls, include_extras=True)
    return {name: hint.__metadata__ if hasattr(hint, "__metadata__") else hint for name, hint in hints.items()}


class Layout(NamedTuple):
    """Where the arrays of a block stand: the same for every block of a class with the same shapes."""

    fields: tuple[tuple[str, Any, Any], ...]  # name, (dtype, shape) or the nested class, start or the nested layout
    size: int  # entries of the memory
    table: np.ndarray  # the table with addresses counted from the beginnings of memory and table
    in_memory: np.ndarray  # 1 for words of the table that are data addresses, else 0
    in_table: np.ndarray  # 1 for words that are addresses of nested tables


@functools.lru_cache(maxsize=256)
def layout(cls: type, shapes: tuple) -> Layout:
    """The layout of a class for ``((field, shape), ...)``; a nested block has such a tuple in place of its shape."""
    given = dict(shapes)
    kinds = field_types(cls)
    fields: list[tuple[str, Any, Any]] = []
    own: list[tuple[int, int, int]] = []  # word, whether it is in memory, whether it is in the table
    nested: list[tuple[int, int, int]] = []
    size = 0
    for name, kind in kinds.items():
        shape = given[name]
        if isinstance(kind, tuple):
            fields.append((name, (kind[0], shape), size))
            own += [(WORD * size, 1, 0), *((n, 0, 0) for n in (*shape, *(1,) * (3 - len(shape))))]
            size += math.prod(shape)
            continue
        inner = layout(kind, shape)
        first = FIELD_WORDS * len(kinds) + len(nested)
        fields.append((name, kind, (inner, size)))
        own += [(WORD * first, 0, 1), *[(0, 0, 0)] * 3]
        moved = inner.table + WORD * size * inner.in_memory + WORD * first * inner.in_table
        nested += zip(moved.tolist(), inner.in_memory.tolist(), inner.in_table.tolist(), strict=True)
        size += inner.size
    return Layout(tuple(fields), size, *np.array(own + nested, dtype=np.int64).reshape(-1, 3).T.copy())


class Block:
    """Memory of a block; alive as long as this object is.

    Attributes
    ----------
    address : int
        What ``view`` takes.
    memory : (m,)
        All entries of all arrays, to clear them at once; integers stand in it by their bits.
    """

    def __init__(self, cls: type, plan: Layout) -> None:
        self._cls, self._plan = cls, plan
        whole = np.zeros(plan.size + 1 + len(plan.table))  # the arrays, and behind them the table
        start = whole.ctypes.data
        self.memory, table = whole[: plan.size + 1], whole[plan.size + 1 :].view(np.int64)
        self.address: int = start + WORD * len(self.memory)
        np.add(plan.table, start * plan.in_memory + self.address * plan.in_table, out=table)

    @functools.cached_property
    def arrays(self) -> Any:
        """The NamedTuple of arrays on the same memory."""
        return _arrays(self._cls, self._plan, self.memory, 0)


def _arrays(cls: type, plan: Layout, memory: np.ndarray, first: int) -> Any:
    values: list[Any] = []
    for _, kind, place in plan.fields:
        if isinstance(kind, tuple):
            dtype, shape = kind
            values.append(np.ndarray(shape, dtype, memory, WORD * (first + place)))  # type: ignore[arg-type]
        else:
            inner, start = place
            values.append(_Nested(functools.partial(_arrays, kind, inner, memory, first + start)))
    return cls(*values)


class _Nested:
    """The NamedTuple of a nested block, made where something in it is asked for: a run in compiled code asks for little
    of it."""

    def __init__(self, make: Callable[[], Any]) -> None:
        self._make = make

    @functools.cached_property
    def _made(self) -> Any:
        return self._make()

    def __getattr__(self, name: str) -> Any:
        value = getattr(self._made, name)
        setattr(self, name, value)  # from now on an attribute like others
        return value

    def __iter__(self) -> Iterator[Any]:
        return iter(self._made)


def new_block(cls: type, shapes: Shapes) -> Block:
    """Allocate a block of zeros.

    Parameters
    ----------
    cls : type
        The NamedTuple class.
    shapes : mapping
        Shape of each field; for a nested block, the mapping of its own shapes.
    """
    return Block(cls, layout(cls, frozen(shapes)))


def frozen(shapes: Shapes) -> tuple:
    """Shapes as the tuple that layouts are kept by; a function that returns this spares each new block the search."""
    if isinstance(shapes, tuple):
        return shapes
    return tuple((name, frozen(shape) if isinstance(shape, dict) else shape) for name, shape in shapes.items())


def _view_interpreted(block: Any, cls: type) -> Any:
    return block


class _View(Kernel):
    """``view(address, cls)``: the block of a class at an address."""

    @functools.cached_property
    def inlined(self) -> Any:
        """What kernels call: the integer as a pointer of the block's type."""
        from numba.extending import intrinsic

        _numba_block_class()  # known to numba before it types the first kernel that views a block

        @intrinsic
        def view(typing_context, address, cls):  # type: ignore[no-untyped-def]
            """The typing of ``view``: the class, a constant, decides the block."""
            block = _block_type(cls.instance_class)

            def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
                """The machine code: no instruction, a change of type."""
                return builder.inttoptr(args[0], context.get_value_type(block))

            return block(address, cls), generate

        return view


view = _View(_view_interpreted)


def _address_interpreted(block: Any) -> Any:
    return block


class _Address(Kernel):
    """``address(block)``: the integer that ``view`` takes, to hand a block to another entry point."""

    @functools.cached_property
    def inlined(self) -> Any:
        """What kernels call: the pointer as an integer."""
        from numba import types as nb
        from numba.extending import intrinsic

        def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
            """The machine code: no instruction, a change of type."""
            return builder.ptrtoint(args[0], context.get_value_type(nb.int64))

        @intrinsic
        def address(typing_context, block):  # type: ignore[no-untyped-def]
            """The typing of ``address``."""
            return nb.int64(block), generate

        return address


address = _Address(_address_interpreted)


@functools.cache
def _block_type(cls: type) -> Any:
    """The numba type of a block's address."""
    return _numba_block_class()(cls)


@functools.cache
def _numba_block_class() -> type:
    """Define numba's view of blocks: a pointer, and attributes loaded from its table."""
    from llvmlite import ir
    from numba import types as nb
    from numba.extending import infer_getattr, lower_getattr_generic, models, register_model

    from nonsmooth.jit.internals import AttributeTemplate, cgutils, make_array, populate_array

    class BlockType(nb.Type):
        """The numba type of the blocks of one class."""

        def __init__(self, cls: type) -> None:
            self.cls = cls
            super().__init__(name=f"Block({cls.__module__}.{cls.__qualname__})")

        def field(self, name: str) -> Any:
            """The numba type of a field: an array, or the type of a nested block."""
            kind = field_types(self.cls)[name]
            if isinstance(kind, tuple):
                return nb.Array(getattr(nb, kind[0]), kind[1], "C")
            return _block_type(kind)

    @register_model(BlockType)
    class BlockModel(models.PrimitiveModel):
        """In machine code a block is the address of its table."""

        def __init__(self, manager: Any, block: Any) -> None:
            super().__init__(manager, block, ir.IntType(64).as_pointer())

    @infer_getattr
    class BlockAttribute(AttributeTemplate):
        """The typing of ``block.field``."""

        key = BlockType

        def generic_resolve(self, block: Any, name: str) -> Any:
            """The type of a field, or None for a name that the class does not have."""
            return block.field(name) if name in field_types(block.cls) else None

    @lower_getattr_generic(BlockType)
    def load_field(context: Any, builder: Any, block: Any, table: Any, name: str) -> Any:
        """The machine code of ``block.field``: its words loaded from the table, as an array or as a nested block.

        The table never changes, so a load may be moved out of a loop (``invariant.load``).
        """
        field = block.field(name)
        first = FIELD_WORDS * list(field_types(block.cls)).index(name)
        words = [
            builder.load(builder.gep(table, [context.get_constant(nb.intp, first + k)]))
            for k in range(1 + getattr(field, "ndim", 0))
        ]
        for word in words:
            word.set_metadata("invariant.load", builder.module.add_metadata([]))
        if isinstance(field, BlockType):
            return builder.inttoptr(words[0], context.get_value_type(field))
        size = context.get_constant(nb.intp, WORD)
        strides = [size]
        for length in reversed(words[2:]):
            strides.insert(0, builder.mul(strides[0], length))
        array = make_array(field)(context, builder)
        populate_array(
            array,
            data=builder.inttoptr(words[0], array.data.type),
            shape=cgutils.pack_array(builder, words[1:]),
            strides=cgutils.pack_array(builder, strides),
            itemsize=size,
            meminfo=None,
        )
        return array._getvalue()

    return BlockType
