"""What model functions see as ``p``: a NamedTuple of floats, arrays that cannot be written, and NamedTuples of such.

A layout says, field by field, (name, kind): None for a float, the shape of an array, or the layout of a part. The
numbers themselves stand in one vector, in the order of the layout.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

import numpy as np

Layout = tuple[tuple[str, Any], ...]


class Unpack:
    """Makes ``p`` of the numbers in their order; `unpack_of` has one for each layout.

    Attributes
    ----------
    cls : type
        The NamedTuple class of ``p``.
    identity : tuple
        What machine code depends on: the names of floats alone, or the layout.
    """

    def __init__(self, layout: Layout) -> None:
        self.layout = layout
        names = tuple(name for name, _ in layout)
        self.is_plain = all(kind is None for _, kind in layout)
        self.identity: tuple = names if self.is_plain else layout
        self.cls: Any = NamedTuple("Parameters", [(name, float) for name in names])  # type: ignore[misc]
        self._makers = [_maker(kind) for _, kind in layout]

    @property
    def size(self) -> int:
        """How many numbers it takes."""
        return sum(size for size, _ in self._makers)

    def __call__(self, *numbers: Any) -> Any:
        """``p`` of so many numbers."""
        return self.cls(*numbers) if self.is_plain else self.cls(*self._made(numbers))

    def _made(self, numbers: tuple) -> Iterator[Any]:
        at = 0
        for size, make in self._makers:
            yield make(numbers[at : at + size])
            at += size

    def source(self, scope: dict[str, Any], view: Callable, at: int = 0) -> str:
        """The expression that makes ``p`` of the pointer ``p_`` from its number ``at`` on; what it names is in scope.

        ``view(shape, at)`` sees the pointer as an array.
        """
        parts, cls = [], f"Parameters_{at}_{len(scope)}"
        scope[cls] = self.cls
        for (_, kind), (size, _) in zip(self.layout, self._makers, strict=True):
            if kind is None:
                parts.append(f"p_[{at}]")
            elif is_part(kind):
                parts.append(unpack_of(kind).source(scope, view, at))
            else:
                name = f"view_p_{at}_{len(scope)}"
                scope[name] = view(kind, at)
                parts.append(f"{name}(p_)")
            at += size
        return f"{cls}({', '.join(parts)})"


def is_part(kind: Any) -> bool:
    """Whether the kind of a field is a layout, and no shape."""
    return kind is not None and isinstance(kind[0], tuple)


def _maker(kind: Any) -> tuple[int, Callable[[tuple], Any]]:
    """How many numbers a field takes, and what makes it of them."""
    if kind is None:
        return 1, lambda numbers: numbers[0]
    if is_part(kind):
        inner = unpack_of(kind)
        return inner.size, lambda numbers: inner(*numbers)
    return math.prod(kind), functools.partial(_frozen_array, kind)


def _frozen_array(shape: tuple[int, ...], numbers: tuple) -> np.ndarray:
    array = np.array(numbers).reshape(shape)  # complex numbers in complex steps
    array.flags.writeable = False
    return array


@functools.cache
def unpack_of(layout: Layout) -> Unpack:
    """What makes ``p`` of its numbers, one for each layout."""
    return Unpack(layout)
