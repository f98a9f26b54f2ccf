"""Blocks: the memory of a run, with fields by name, seen by kernels as one pointer.

    class Clock(Block):
        now: float                                  # a number: clock.now += clock.dt in kernels and in Python
        steps: int

    class Rows(Block, r="n_c * (1 + d)"):           # a size that is made from others
        clock: Clock                                # a block in a block
        G: Array[Floats, "r", "r"]                  # an array, and its shape; Array is typing.Annotated
        inner: Array[Other, "n = 2 * n_c"]          # a block with sizes of its own

    rows = new(Rows, n_c=2, d=1)                    # Python: rows.G, rows.clock.steps, rows.address
    rows = view(address, Rows)                      # kernel: rows.G[0, 0], rows.clock.steps += 1

To the interpreter a block is an object with these attributes. To compiled code it is the address of its head: one word
a number, place and lengths of an array, and the heads of the blocks in it, so that ``rows.clock`` costs nothing.
Places are counted from the head: the words of a block can be copied, kept in a file and put back elsewhere. Handing
tuples of arrays down by value instead made the step loop compile for 110 s and a step cost 900 ns.
"""

from __future__ import annotations

import functools
import hashlib
import math
import types
import typing
from collections.abc import Iterable, Iterator
from typing import Any, ClassVar, NamedTuple, TypeVar

import numpy as np
import numpy.typing as npt

from nonsmooth.jit import Kernel

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]
DTYPES = {Floats: "float64", Ints: "int64"}
Handle = typing.NewType("Handle", int)  # an address of machine code; in the interpreter a Python function
NUMBERS = {float: "float64", int: "int64", Handle: "int64"}

WORD = 8  # defined: bytes of every entry

Expressions = dict[str, types.CodeType]  # of sizes, by name


class BlockClass(type):
    """The type of block classes, by which numba knows one among the globals of a kernel."""


class Block(metaclass=BlockClass):
    """Base class of blocks; ``new`` makes them.

    Class keywords are sizes made from others, such as ``r="n_c * (1 + d)"``, or numbers, which ``new`` may be given
    instead. A block in a block has the sizes of the outer one, but for those that it makes itself.

    Attributes
    ----------
    address : int
        What ``view`` takes.
    words : (m,)
        All that ``new`` allocated; integers stand in it by their bits.
    """

    address: int
    words: np.ndarray
    _bits: np.ndarray
    _at: int
    _sizes: ClassVar[Expressions] = {}

    def __init_subclass__(cls, **sizes: int | str) -> None:
        cls._sizes = {name: _compiled(size) for name, size in sizes.items()}

    def __init__(self, words: np.ndarray) -> None:
        self._become(words, words.view(np.int64), 0, words.ctypes.data)

    def _become(self, words: np.ndarray, bits: np.ndarray, at: int, address: int) -> None:
        """The block whose head begins at a word of the memory that an outer one has, seen as numbers and as bits."""
        self.__dict__.update(words=words, _bits=bits, _at=at, address=address)

    @classmethod
    def _fields(cls) -> dict[str, Field]:
        return fields_of(typing.cast(Any, cls))

    @classmethod
    def layout_identity(cls) -> bytes:
        """What compiled code depends on: the fields in their order, with those of the blocks in it."""
        parts = [(name, field.dtype, field.axes) for name, field in cls._fields().items()]
        inner = [field.block.layout_identity() for field in cls._fields().values() if field.block is not None]
        return b"".join((repr((cls.__qualname__, parts)).encode(), *inner))

    def __getattr__(self, name: str) -> Any:
        field = fields_of(type(self)).get(name)
        if field is None:
            raise AttributeError(f"{type(self).__name__} has no field {name}")
        at = self._at + field.at
        if field.is_handle:
            return self._bits[at]
        if field.block is not None:
            value: Any = object.__new__(field.block)
            value._become(self.words, self._bits, at, self.__dict__["address"] + WORD * field.at)
        else:
            place, *shape = self._bits[at : at + 1 + field.axes].tolist()
            value = np.ndarray(shape, field.dtype, self.words, WORD * self._at + place)
        self.__dict__[name] = value
        return value

    def __setattr__(self, name: str, value: Any) -> None:
        if isinstance(getattr(type(self), name, None), property):
            object.__setattr__(self, name, value)
            return
        field = fields_of(type(self)).get(name)
        if field is None or not field.is_handle:
            raise AttributeError(f"{type(self).__name__}.{name} is no number that can be set; fill arrays by [:]")
        if callable(value) or isinstance(value, Block):  # of the interpreter
            self.__dict__[name] = value
        else:
            self.__dict__.pop(name, None)
            self._bits[self._at + field.at] = value

    def restore(self, words: np.ndarray) -> None:
        """Take the words of such a block, (m,) as bits, that may be of another process: all but its handles."""
        handles = [self._at + place for place in handles_of(type(self))]
        kept = self._bits[handles]
        self._bits[:] = words
        self._bits[handles] = kept

    def __iter__(self) -> Iterator[Any]:
        """Its fields, in their order."""
        return (getattr(self, name) for name in self._fields())


B = TypeVar("B", bound=Block)


class Field(NamedTuple):
    """A field of a block class, and where its words stand in the head."""

    at: int
    dtype: str  # "" for a block
    is_handle: bool
    axes: int  # 0 for a number
    shape: tuple[types.CodeType, ...]
    block: Any  # its class
    sizes: Expressions  # of a block: sizes of its own

    @property
    def is_whole(self) -> bool:
        """Whether it is a whole number, or an array of these."""
        return self.dtype == "int64"

    @property
    def words(self) -> int:
        """Its length in the head."""
        return head_words(self.block) if self.block is not None else 1 + self.axes


@functools.cache
def fields_of(cls: Any) -> dict[str, Field]:
    """The fields of a block class, in their order."""
    fields: dict[str, Field] = {}
    at = 0
    for name, hint in typing.get_type_hints(cls, include_extras=True).items():
        if name not in Block.__annotations__:  # those of the base class
            fields[name] = field = _field(at, hint)
            at += field.words
            if field.axes == 0 and field.block is None and not field.is_handle:
                setattr(cls, name, _number(field))
    return fields


def _number(field: Field) -> property:
    """What reads and writes a number of a block: found by the interpreter at once, without ``__getattr__``."""
    place = field.at
    if field.is_whole:
        return property(
            lambda block: block._bits[block._at + place],
            lambda block, value: block._bits.__setitem__(block._at + place, value),
        )
    return property(
        lambda block: block.words[block._at + place],
        lambda block, value: block.words.__setitem__(block._at + place, value),
    )


def _field(at: int, hint: Any) -> Field:
    """What an annotation says."""
    parts = getattr(hint, "__metadata__", ())
    kind = hint.__origin__ if parts else hint
    if isinstance(kind, type) and issubclass(kind, Block):
        own = (part.split("=", 1) for part in parts)
        return Field(at, "", False, 0, (), kind, {name.strip(): _compiled(text) for name, text in own})
    if kind in NUMBERS:
        return Field(at, NUMBERS[kind], kind is Handle, 0, (), None, {})
    return Field(at, DTYPES[kind], False, len(parts), tuple(map(_compiled, parts)), None, {})


def _compiled(text: Any) -> types.CodeType:
    return compile(str(text).strip(), "<size>", "eval")


@functools.cache
def head_words(cls: Any) -> int:
    """Length of the head of a block class."""
    return sum(field.words for field in fields_of(cls).values())


@functools.cache
def handles_of(cls: Any) -> list[int]:
    """The words of its head that are handles, those of the blocks in it among them."""
    places: list[int] = []
    for field in fields_of(cls).values():
        if field.block is not None:
            places += [field.at + place for place in handles_of(field.block)]
        elif field.is_handle:
            places.append(field.at)
    return places


@functools.lru_cache(maxsize=512)
def head_of(cls: Any, sizes: tuple[tuple[str, int], ...]) -> tuple[np.ndarray, int]:
    """The head of a class with given sizes, and the number of all words."""
    head: list[int] = []
    end = head_words(cls)
    for start, shape in _shapes(cls, dict(sizes), 0):
        if shape is None:
            head.append(0)
        else:
            head += [WORD * (end - start), *shape]
            end += math.prod(shape)
    return np.array(head, dtype=np.int64), end


def _shapes(cls: Any, given: dict[str, int], at: int) -> Iterator[tuple[int, tuple[int, ...] | None]]:
    """Of each array of a block at a word, and of the blocks in it: where its own block begins, and its shape; of each
    number, None."""
    sizes = dict(given)
    for name, code in cls._sizes.items():
        if name not in given:
            sizes[name] = eval(code, {}, sizes)
    for field in fields_of(cls).values():
        if field.block is not None:
            own = {name: eval(code, {}, sizes) for name, code in field.sizes.items()}
            handed = {name: size for name, size in sizes.items() if name not in field.block._sizes}
            yield from _shapes(field.block, handed | own, at + field.at)
        elif field.axes == 0:
            yield at, None
        else:
            yield at, tuple(int(eval(code, {}, sizes)) for code in field.shape)


def count_words(cls: type, **sizes: int) -> int:
    """How many words ``new`` would allocate."""
    return head_of(cls, tuple(sizes.items()))[1]


def new(cls: type[B], **sizes: int) -> B:
    """Allocate a block of zeros; alive as long as it, or a block in it, is.

    Parameters
    ----------
    cls : type
        The class.
    **sizes : int
        What the shapes in its annotations are made from.
    """
    head, size = head_of(typing.cast(Any, cls), tuple(sizes.items()))
    words = np.zeros(size)
    words[: len(head)].view(np.int64)[:] = head
    return cls(words)


def keep_rows(before: Block, after: Block) -> None:
    """Put all that a block has into one of its class that has more rows."""
    for name in before._fields():
        value = getattr(before, name)
        if isinstance(value, Block):
            keep_rows(value, getattr(after, name))
        elif isinstance(value, np.ndarray):
            getattr(after, name)[: len(value)] = value
        else:
            setattr(after, name, value)


def _view_interpreted(block: Any, cls: type) -> Any:
    return block


class _View(Kernel):
    """``view(address, cls)``: the block of a class at an address."""

    @functools.cached_property
    def inlined(self) -> Any:
        """What kernels call: the integer as a pointer of the block's type."""
        return view_with({})


view = _View(_view_interpreted)


def view_with(known: dict[type, Known]) -> Any:
    """``view`` in code that is made for one run: what is constant in the blocks of each class."""
    from numba.extending import intrinsic

    _numba_block_class()  # known to numba before it types the first kernel that views a block

    @intrinsic
    def view(typing_context, address, cls):  # type: ignore[no-untyped-def]
        """The typing of ``view``: the class, a constant, decides the block."""
        block = block_type(cls.instance_class, known.get(cls.instance_class))

        def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
            """The machine code: no instruction, a change of type."""
            return builder.inttoptr(args[0], context.get_value_type(block))

        return block(address, cls), generate

    return view


def _numbers_interpreted(block: Any) -> np.ndarray:
    known = block.__dict__.get("_numbers")
    if known is None:
        fields = block._fields()
        words = block.words.view(next(iter(fields.values())).dtype)
        known = block.__dict__["_numbers"] = words[block._at : block._at + len(fields)]
    return known  # type: ignore[no-any-return]


class _Numbers(Kernel):
    """``numbers(block)``: a block that has nothing but numbers of one type, as an array; for Python too."""

    def __call__(self, block: Block) -> np.ndarray:
        return _numbers_interpreted(block)

    @functools.cached_property
    def inlined(self) -> Any:
        """What kernels call: an array on the words of the head."""
        from numba import types as nb
        from numba.extending import intrinsic

        from nonsmooth.jit.kernel_lowering import array_value

        def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
            """The machine code: no instruction, an array of known length."""
            fields = fields_of(signature.args[0].cls)
            length = context.get_constant(nb.intp, len(fields))
            return array_value(context, builder, signature.return_type, args[0], [length])

        @intrinsic
        def numbers(typing_context, block):  # type: ignore[no-untyped-def]
            """The typing of ``numbers``."""
            dtype = next(iter(fields_of(block.cls).values())).dtype
            return nb.Array(getattr(nb, dtype), 1, "C")(block), generate

        return numbers


numbers = _Numbers(_numbers_interpreted)


def named_numbers(block: Block) -> dict[str, Any]:
    """Those numbers by name, as Python has them."""
    return dict(zip(block._fields(), numbers(block).tolist(), strict=True))


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


class Known(NamedTuple):
    """What is constant in the blocks of a class, for code that is made for one run (specialised.py)."""

    head: tuple[int, ...]  # of the outermost block, as bits: places and lengths of its arrays
    at: int  # where the block's own head begins in it
    numbers: tuple[str, ...]  # names of the classes whose numbers are constant
    arrays: tuple[tuple[tuple[str, str], bytes], ...]  # constant arrays, by class and field, and their content
    model: Any  # numba's type of the functions of the system, or None

    @property
    def name(self) -> str:
        """The same for equal facts only, in every process."""
        return hashlib.sha256(repr(self).encode()).hexdigest()[:32]


def known_of(block: Block, numbers: Iterable[type], arrays: Iterable[str] = (), model: Any = None) -> Known:
    """Places and lengths in a block; the numbers of some classes in it, and some arrays of its own."""
    cls, names = type(block), tuple(sorted(each.__name__ for each in numbers))
    head = block._bits[: head_words(cls)].copy()
    head[changing_words(cls, names)] = 0
    kept = tuple(((cls.__name__, name), getattr(block, name).tobytes()) for name in arrays)
    return Known(tuple(head.tolist()), 0, names, kept, model)


def changing_words(cls: Any, constant: tuple[str, ...]) -> list[int]:
    """The words of a head that are handles, or numbers of other classes than the constant ones."""
    places: list[int] = []
    for field in fields_of(cls).values():
        if field.block is not None:
            places += [field.at + place for place in changing_words(field.block, constant)]
        elif field.axes == 0 and (field.is_handle or cls.__name__ not in constant):
            places.append(field.at)
    return places


@functools.cache
def block_type(cls: Any, known: Known | None = None) -> Any:
    """The numba type of a block's address."""
    return _numba_block_class()(cls, known)


@functools.cache
def _numba_block_class() -> type:
    """Define numba's view of blocks: a pointer, and attributes loaded from and stored to its head."""
    from llvmlite import ir
    from numba import types as nb
    from numba.extending import infer_getattr, lower_getattr_generic, models, register_model, typeof_impl

    from nonsmooth.jit.internals import AttributeTemplate, lower_setattr_generic
    from nonsmooth.jit.kernel_lowering import array_value

    class ClassType(nb.Dummy):  # type: ignore[misc]
        """The numba type of a block class."""

        def __init__(self, cls: type) -> None:
            self.instance_class = cls
            super().__init__(name=f"BlockClass({cls.__module__}.{cls.__qualname__})")

    register_model(ClassType)(models.OpaqueModel)

    @typeof_impl.register(BlockClass)
    def typeof_class(cls: type, context: Any) -> Any:
        """A block class among the globals of a kernel."""
        return ClassType(cls)

    class BlockType(nb.Type):
        """The numba type of the blocks of one class."""

        def __init__(self, cls: type, known: Known | None) -> None:
            self.cls, self.known = cls, known
            facts = f", {known.name}" if known else ""
            super().__init__(name=f"Block({cls.__module__}.{cls.__qualname__}{facts})")

        def type_of(self, field: Field) -> Any:
            """The numba type of a field: a number, an array, or the type of a block."""
            if field.block is not None:
                return block_type(field.block, self.known and self.known._replace(at=self.known.at + field.at))
            if field.is_handle and self.known and self.known.model is not None:
                return self.known.model
            dtype = getattr(nb, field.dtype)
            return nb.Array(dtype, field.axes, "C") if field.axes > 0 else dtype

    @register_model(BlockType)
    class BlockModel(models.PrimitiveModel):
        """In machine code a block is the address of its head."""

        def __init__(self, manager: Any, block: Any) -> None:
            super().__init__(manager, block, ir.IntType(64).as_pointer())

    @infer_getattr
    class BlockAttribute(AttributeTemplate):
        """The typing of ``block.field``."""

        key = BlockType

        def generic_resolve(self, block: Any, name: str) -> Any:
            """The type of a field, or None for a name that the class does not have."""
            field = fields_of(block.cls).get(name)
            return None if field is None else block.type_of(field)

    def word(context: Any, builder: Any, head: Any, k: int) -> Any:
        """A pointer to word k of the head."""
        return builder.gep(head, [context.get_constant(nb.intp, k)])

    def number(context: Any, builder: Any, head: Any, field: Field) -> Any:
        """A pointer to a number."""
        kind = context.get_value_type(getattr(nb, field.dtype))
        return builder.bitcast(word(context, builder, head, field.at), kind.as_pointer())

    @lower_getattr_generic(BlockType)
    def load_field(context: Any, builder: Any, block: Any, head: Any, name: str) -> Any:
        """The machine code of ``block.field``.

        Places and lengths never change, so their loads may be moved out of a loop (``invariant.load``).
        """
        field = fields_of(block.cls)[name]
        if field.block is not None:
            return word(context, builder, head, field.at)
        if block.known is not None:
            return known_field(context, builder, block, head, name)
        if field.axes == 0:
            return builder.load(number(context, builder, head, field))
        words = [builder.load(word(context, builder, head, field.at + k)) for k in range(1 + field.axes)]
        for loaded in words:
            loaded.set_metadata("invariant.load", builder.module.add_metadata([]))
        place, *shape = words
        data = builder.inttoptr(builder.add(builder.ptrtoint(head, place.type), place), head.type)
        return array_value(context, builder, block.type_of(field), data, shape)

    def known_field(context: Any, builder: Any, block: Any, head: Any, name: str) -> Any:
        """The machine code of ``block.field`` where places and lengths, and some values, are constants."""
        known, field, kind = block.known, fields_of(block.cls)[name], block.type_of(fields_of(block.cls)[name])
        place, *shape = known.head[known.at + field.at : known.at + field.at + 1 + field.axes]
        if field.is_handle and known.model is not None:
            return context.get_dummy_value()
        if field.axes == 0:
            if block.cls.__name__ not in known.numbers or field.is_handle:
                return builder.load(number(context, builder, head, field))
            return context.get_constant(kind, place if field.is_whole else float(np.int64(place).view(np.float64)))
        content = dict(known.arrays).get((block.cls.__name__, name))
        if content is not None:
            return context.make_constant_array(builder, kind, np.frombuffer(content, field.dtype).reshape(shape))
        lengths = [context.get_constant(nb.intp, length) for length in shape]
        return array_value(context, builder, kind, word(context, builder, head, place // WORD), lengths)

    @lower_setattr_generic(BlockType)
    def store_number(context: Any, builder: Any, signature: Any, args: Any, name: str) -> None:
        """The machine code of ``block.field = value`` for a number."""
        block, value = signature.args
        field = fields_of(block.cls)[name]
        if field.axes > 0 or field.block is not None:
            raise TypeError(f"{block.cls.__name__}.{name} is no number that can be set")
        builder.store(context.cast(builder, args[1], value, getattr(nb, field.dtype)),
                      number(context, builder, args[0], field))  # fmt: skip

    return BlockType
