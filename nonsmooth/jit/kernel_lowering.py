"""The machine code of items of arrays and of loops over ``range``, written for kernels.

    x[i, j]                 numba puts the array into memory, asks an overload, and goes through shapes and strides;
                            here the address is data + 8 (i lengths[1] + j), of an array that stands in a register
    for k in range(a, b)    numba divides by the step, and raises where that is 0; here a counter runs from b - a to 0
    x = y                   numba reads the old value, which might have to be freed, and asks LLVM for the size of
                            each variable, for debuggers; here it is stored

So a kernel takes a tenth less time to compile. The arithmetic is the same, and so are the bits of a result. All else is
left to numba, and so are all indices where it is asked to check them (``NUMBA_BOUNDSCHECK``).
"""

from __future__ import annotations

from typing import Any

import numba
from llvmlite import ir as llvm_ir

from nonsmooth.jit.internals import Lower, NativeLowering, cgutils, ir

nb: Any = numba.types
# defined: what numba's arrays consist of
ARRAY_PARTS = ("meminfo", "parent", "nitems", "itemsize", "data", "shape", "strides")
INDEX = llvm_ir.IntType(64)  # defined: the type of an index


class KernelLowering(NativeLowering):
    """Numba's pass, with the lowering of kernels."""

    @property
    def lowering_class(self) -> type:
        """What lowers a function."""
        return KernelLower


class KernelLower(Lower):
    """Numba's lowering but for what stands above."""

    def init(self) -> None:
        """The ranges that were met: by the identity of the value, the value, start, stop and step."""
        super().init()
        self._ranges: dict[int, tuple[Any, ...]] = {}

    def lower_inst(self, inst: Any) -> Any:
        """A statement; numba looks for another way for constant indices, and arrays have none."""
        if isinstance(inst, ir.StaticSetItem) and isinstance(self.typeof(inst.target.name), nb.Array):
            return self.lower_setitem(inst.target, inst.index_var, inst.value, self.fndesc.calltypes[inst])
        return super().lower_inst(inst)

    def alloca_lltype(self, name: str, lltype: Any, datamodel: Any = None) -> Any:
        """The place of a variable on the stack."""
        return cgutils.alloca_once(self.builder, lltype, name=name, zfill=False)

    def storevar(self, value: Any, name: str, argidx: int | None = None) -> None:
        """Give a variable its value: one that is assigned once is the value itself."""
        if name in self._singly_assigned_vars:
            self._blk_local_varmap[name] = value
        else:
            self.builder.store(value, self.getvar(name))

    def loadvar(self, name: str) -> Any:
        """The value of a variable."""
        value = self._blk_local_varmap.get(name)
        return self.builder.load(self.getvar(name)) if value is None else value

    def lower_expr(self, kind: Any, expr: Any) -> Any:
        """An expression, as a value of a type."""
        match expr.op:
            case "static_getitem" if isinstance(self.typeof(expr.value.name), nb.Array):
                return self.lower_getitem(kind, expr, expr.value, expr.index_var, self.fndesc.calltypes[expr])
            case "getattr" if expr.attr == "shape" and isinstance(self.typeof(expr.value.name), nb.Array):
                return self.builder.extract_value(self.loadvar(expr.value.name), ARRAY_PARTS.index("shape"))
            case "call" if kind == nb.range_state64_type and not expr.kws:
                given = self._steps_by_one(expr)
                if given is not None:
                    return self._range(kind, given)
            case "getiter":
                found = self._ranges.get(id(self.loadvar(expr.value.name)))
                if found is not None:
                    return self._begin(kind, *found[1:])
            case "iternext" if self.typeof(expr.value.name) == nb.range_iter64_type:
                return self._next(kind, self.loadvar(expr.value.name))
        return super().lower_expr(kind, expr)

    def lower_getitem(self, kind: Any, expr: Any, value: Any, index: Any, signature: Any) -> Any:
        """``value[index]``."""
        array = self.typeof(value.name)
        pointer = self._item(array, self.loadvar(value.name), self.typeof(index.name), self.loadvar(index.name))
        if pointer is None:
            return super().lower_getitem(kind, expr, value, index, signature)
        item = self.context.unpack_value(self.builder, array.dtype, pointer)
        return self.context.cast(self.builder, item, array.dtype, kind)

    def lower_setitem(self, target: Any, index: Any, value: Any, signature: Any) -> Any:
        """``target[index] = value``."""
        array = self.typeof(target.name)
        pointer = self._item(array, self.loadvar(target.name), self.typeof(index.name), self.loadvar(index.name))
        if pointer is None:
            return super().lower_setitem(target, index, value, signature)
        item = self.context.cast(self.builder, self.loadvar(value.name), self.typeof(value.name), array.dtype)
        return self.context.pack_value(self.builder, array.dtype, item, pointer)

    def _item(self, kind: Any, array: Any, index_kind: Any, index: Any) -> Any:
        """The pointer to one item of a contiguous array, or None for anything else."""
        if not isinstance(kind, nb.Array) or kind.layout != "C" or not kind.aligned or self.context.enable_boundscheck:
            return None
        is_tuple = isinstance(index_kind, nb.BaseTuple)
        kinds = index_kind.types if is_tuple else (index_kind,)
        if len(kinds) != kind.ndim or not all(isinstance(each, nb.Integer) for each in kinds):
            return None
        builder = self.builder
        values = [builder.extract_value(index, k) for k in range(kind.ndim)] if is_tuple else [index]
        *outer, place = (self.context.cast(builder, *pair, nb.intp) for pair in zip(values, kinds, strict=True))
        items = None  # from one index of an axis to the next
        for axis in reversed(range(len(outer))):
            length = builder.extract_value(array, [ARRAY_PARTS.index("shape"), axis + 1])
            items = length if items is None else builder.mul(length, items)
            place = builder.add(builder.mul(outer[axis], items), place)
        return builder.gep(builder.extract_value(array, ARRAY_PARTS.index("data")), [place])

    def _steps_by_one(self, expr: Any) -> tuple[Any, Any, Any] | None:
        """Start, stop and step of a call of ``range``, or None where the step is not known to be 1 or -1."""
        if getattr(self.typeof(expr.func.name), "typing_key", None) is not range or expr.vararg:
            return None
        arguments = [(self.loadvar(each.name), self.typeof(each.name)) for each in expr.args]
        given = [self.context.cast(self.builder, *each, nb.int64) for each in arguments]
        start, stop, step = ([INDEX(0), *given] if len(given) == 1 else given) + [INDEX(1)] * (len(given) < 3)
        return (start, stop, step) if getattr(step, "constant", None) in (1, -1) else None

    def _range(self, kind: Any, given: tuple[Any, Any, Any]) -> Any:
        value = self._struct(kind, given)
        self._ranges[id(value)] = value, *given
        return value

    def _begin(self, kind: Any, start: Any, stop: Any, step: Any) -> Any:
        """The iterator: the next index, and how many are left (none, where that is negative)."""
        index, left = (cgutils.alloca_once(self.builder, INDEX) for _ in range(2))
        self.builder.store(start, index)
        first, last = (start, stop) if step.constant > 0 else (stop, start)
        self.builder.store(self.builder.sub(last, first), left)
        return self._struct(kind, (index, stop, step, left))

    def _next(self, kind: Any, iterator: Any) -> Any:
        """The next index, and whether there was one."""
        builder = self.builder
        index, _, step, left = (builder.extract_value(iterator, k) for k in range(4))
        now, count = builder.load(index), builder.load(left)
        is_valid = builder.icmp_signed(">", count, INDEX(0))
        builder.store(builder.add(now, step), index)
        builder.store(builder.sub(count, INDEX(1), flags=["nsw"]), left)
        return self._struct(kind, (now, is_valid))

    def _struct(self, kind: Any, parts: tuple[Any, ...]) -> Any:
        return struct(self.builder, self.context.get_value_type(kind), parts)


def struct(builder: Any, kind: Any, parts: tuple[Any, ...]) -> Any:
    """A structure of LLVM in a register."""
    value = llvm_ir.Constant(kind, llvm_ir.Undefined)
    for k, part in enumerate(parts):
        value = builder.insert_value(value, part, k)
    return value


def array_value(context: Any, builder: Any, kind: Any, data: Any, shape: list[Any]) -> Any:
    """A contiguous array of eight-byte numbers in a register: on memory that nobody frees."""
    length = INDEX(8)
    strides = [length]
    for axis in reversed(shape[1:]):
        strides.insert(0, builder.mul(strides[0], axis))
    count = shape[0]
    for axis in shape[1:]:
        count = builder.mul(count, axis)
    value_type = context.get_value_type(kind)
    nothing = [llvm_ir.Constant(value_type.elements[k], None) for k in range(2)]
    data = builder.bitcast(data, value_type.elements[ARRAY_PARTS.index("data")])
    lengths = (cgutils.pack_array(builder, each, INDEX) for each in (shape, strides))
    return struct(builder, value_type, (*nothing, count, length, data, *lengths))
