"""Who of several processes compiles which entry point: each its own share first, and then what is left of the others'.

    share k  ->  pipe k, a byte an entry point:  whoever reads the byte compiles it, and nobody else does

So a process that is done early helps the others. Where handles cannot be handed on (Windows) each keeps to its share.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator, Sequence
from typing import Generic, TypeVar

CAN_HAND_ON = sys.platform != "win32"  # code: handles to another process
T = TypeVar("T")


class Turns(Generic[T]):
    """The shares of some processes, and the pipes that say what is left of them.

    Parameters
    ----------
    shares : sequence of sequences
        255 things in all, at most.
    """

    def __init__(self, shares: Sequence[Sequence[T]]) -> None:
        self.shares = shares
        self.pipes = tuple(_full_pipe(numbers) for numbers in _numbered(shares)) if CAN_HAND_ON else ()

    def of(self, k: int) -> tuple[tuple[int, ...], list[T]]:
        """The arguments of `in_turn` for process k: its own pipe is the first."""
        things = [thing for share in self.shares for thing in share] if self.pipes else list(self.shares[k])
        return (*self.pipes[k:], *self.pipes[:k]), things

    def close(self) -> None:
        """Close the pipes in this process."""
        for pipe in self.pipes:
            os.close(pipe)


def in_turn(pipes: Sequence[int], things: Sequence[T]) -> Iterator[T]:
    """What is this process's turn, one after the other, until nothing is left."""
    if not pipes:
        yield from things
    for pipe in pipes:
        while number := os.read(pipe, 1):
            yield things[number[0]]


def _numbered(shares: Sequence[Sequence[T]]) -> list[bytes]:
    """Each share as numbers of its things in the list of all."""
    ends = [sum(map(len, shares[: k + 1])) for k in range(len(shares))]
    return [bytes(range(end - len(share), end)) for share, end in zip(shares, ends, strict=True)]


def _full_pipe(content: bytes) -> int:
    """A pipe from which these bytes can be read, and then its end."""
    read, write = os.pipe()
    os.write(write, content)
    os.close(write)
    return read
