"""Units of the parameters of a model, as its class says them in brackets: in its docstring of NumPy's style, or in the
comment beside a field, ``k: float = 40.0  # stiffness [N/m]``.
"""

from __future__ import annotations

import functools
import inspect
import re
from typing import Any

DESCRIBED = re.compile(r"^(\w+(?:, \w+)*) :.*\n((?:    .*\n?)+)", re.MULTILINE)  # defined: numpydoc
UNIT = re.compile(r"\[([^\]]+)\]")
FIELD = re.compile(r"^\s+(\w+)\s*:[^#\n]*#(.*)$", re.MULTILINE)  # a field of a class, and the comment beside it


def unit_of_parameter(model: Any, name: str) -> str:
    """The unit in brackets of a parameter's description; "-" of one that is described without in a docstring, nothing
    where it is not described. Of ``spring.k`` it is that of k in the class of the spring, of ``m[0]`` that of m.

    Of several that are described together, each its own or all the same one; where neither fits, none is known.
    """
    *path, last = name.partition("[")[0].split(".")
    for part in path:
        model = getattr(model, part, None)
    cls: Any = type(model)
    return "" if model is None else units_of_class(cls).get(last, "")


def meaning_of_parameter(model: Any, name: str) -> str:
    """What the docstring or the comment says of a parameter, without its unit; nothing where it says nothing."""
    cls: Any = type(model)
    words = words_of_class(cls).get(name, "")
    return re.sub(r"\s+([.,;:])", r"\1", " ".join(UNIT.sub("", words).split())).strip(" .,;") if words else ""


@functools.lru_cache(maxsize=1000)
def units_of_class(cls: Any) -> dict[str, str]:
    """Of each field that the docstring or a comment describes; the docstring comes first."""
    found = {name: UNIT.findall(words)[0] for name, words in FIELD.findall(source_of(cls)) if UNIT.search(words)}
    for names, words in DESCRIBED.findall(inspect.getdoc(cls) or ""):
        listed = names.split(", ")
        units = UNIT.findall(words) or ["-"]
        units = units[:1] * len(listed) if 1 in (len(units), len(listed)) else units
        found |= dict(zip(listed, units, strict=True)) if len(units) == len(listed) else dict.fromkeys(listed, "")
    return found


@functools.lru_cache(maxsize=1000)
def words_of_class(cls: Any) -> dict[str, str]:
    """The words of each of them."""
    found = dict(FIELD.findall(source_of(cls)))
    for names, words in DESCRIBED.findall(inspect.getdoc(cls) or ""):
        found |= dict.fromkeys(names.split(", "), words)
    return found


def source_of(cls: type) -> str:
    """The text of a class, or nothing where there is none, as of one typed into a shell."""
    try:
        return inspect.getsource(cls)
    except (OSError, TypeError):
        return ""
