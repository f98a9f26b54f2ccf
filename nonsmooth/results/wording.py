"""A result in a few lines: its fields by name, arrays by their shape and range, what it holds many of by their number.

A notebook shows the same as a table. Nothing is left out in silence: what is not written out is counted.
"""

from __future__ import annotations

import html
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from enum import Enum
from typing import Any

import numpy as np

LINE = 100  # chosen: letters of a result on one line
LONGEST_WORD = 76  # chosen: letters of a field
WRITTEN_OUT = 6  # chosen: numbers of an array that are written out; of more the range is
MOST_FIELDS = 16  # chosen: lines of a result; the rest is counted
DIGITS = 6  # chosen: of a number in a text


def as_text(result: Any) -> str:
    """The result on one line, or a field on each."""
    words = [f"{name}={word(value)}" for name, value in fields_of(result)]
    kind = type(result).__name__
    line = f"{kind}({', '.join(words)})"
    if len(line) <= LINE:
        return line
    return "\n".join([f"{kind}(", *(f"  {text}," for text in within(words)), ")"])


def as_html(result: Any) -> str:
    """The result as a table for a notebook."""
    rows = [
        f'<tr><th style="text-align:left">{html.escape(name)}</th>'
        f'<td style="text-align:left"><code>{html.escape(word(value))}</code></td></tr>'
        for name, value in fields_of(result)
    ]
    return f"<table><caption>{html.escape(type(result).__name__)}</caption>{''.join(within(rows))}</table>"


def as_lines(text: str) -> str:
    """A text that has its own lines, for a notebook."""
    return f"<pre>{html.escape(text)}</pre>"


def fields_of(result: Any) -> list[tuple[str, Any]]:
    """Names and values of a dataclass, before them the properties that it names in ``first``, or of a named tuple."""
    own = [f.name for f in fields(result) if f.repr] if is_dataclass(result) else result._fields
    names = [*getattr(type(result), "first", ()), *own]
    return [(name, getattr(result, name)) for name in names]


def within(lines: list[str]) -> list[str]:
    """As many as fit; the rest is counted."""
    if len(lines) <= MOST_FIELDS:
        return lines
    return [*lines[: MOST_FIELDS - 1], f"... and {len(lines) - MOST_FIELDS + 1} more"]


def word(value: Any) -> str:
    """A value on one line."""
    if isinstance(value, Enum):
        return value.name or str(value)
    if isinstance(value, float | np.floating):
        return f"{value:.{DIGITS}g}"
    if isinstance(value, np.ndarray):
        return word_of_array(value)
    if isinstance(value, Mapping):
        return shortest(repr(dict(value)), f"{len(value)} by name: {', '.join(map(str, value))}")
    if isinstance(value, list | tuple):
        return shortest(f"({', '.join(map(word, value))})" if len(value) <= WRITTEN_OUT else "", counted(value))
    return shortest(repr(value), f"a {type(value).__name__}")


def word_of_array(values: np.ndarray) -> str:
    """A few numbers, or the shape and the range of those that are finite."""
    if values.size <= WRITTEN_OUT:
        text = np.array2string(values, precision=DIGITS, separator=", ", max_line_width=10 * LINE)
        return "".join(line.strip() + " " * line.endswith(",") for line in text.splitlines())
    shape = " x ".join(map(str, values.shape))
    if values.dtype == bool:
        return f"array {shape}, {int(values.sum())} of them True"
    if values.dtype.kind not in "iuf" or not np.isfinite(values).any():
        return f"array {shape} of {values.dtype}"
    known = values[np.isfinite(values)]
    missing = f", {values.size - known.size} not finite" if known.size < values.size else ""
    return f"array {shape} in [{known.min():.{DIGITS}g}, {known.max():.{DIGITS}g}]{missing}"


def counted(values: Any) -> str:
    """How many of what."""
    kinds = sorted({type(value).__name__ for value in values})
    return f"{len(values)} of {' or '.join(kinds)}" if kinds else "none"


def shortest(text: str, instead: str) -> str:
    """The text on one line where it is short, else what is said instead."""
    line = " ".join(text.split())
    if 0 < len(line) <= LONGEST_WORD:
        return line
    return instead if len(instead) <= LONGEST_WORD else instead[: LONGEST_WORD - 3] + "..."
