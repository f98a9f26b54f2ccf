"""The object code of a function, as it is kept on the disk: a line of its name and of what it needs, then the code."""

from __future__ import annotations

import json
from typing import NamedTuple

HEAD = b"object code\n"  # code: of what is kept


class ObjectCode(NamedTuple):
    """The object code of one function.

    Attributes
    ----------
    symbol : str
        Its name to the linker.
    needed : tuple of str
        The names of what it calls and reads elsewhere.
    code : bytes
    """

    symbol: str
    needed: tuple[str, ...]
    code: bytes

    def to_bytes(self) -> bytes:
        """As it is kept in a file."""
        return HEAD + json.dumps([self.symbol, self.needed]).encode() + b"\n" + self.code


def object_code(payload: bytes) -> ObjectCode | None:
    """What `ObjectCode.to_bytes` wrote; None of something else."""
    if not payload.startswith(HEAD):
        return None
    line, code = payload[len(HEAD) :].split(b"\n", 1)
    symbol, needed = json.loads(line)
    return ObjectCode(symbol, tuple(needed), code)
