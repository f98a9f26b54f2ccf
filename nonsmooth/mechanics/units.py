"""Units of the parameters of a model, from the docstring of its class, where NumPy's style has them in brackets."""

from __future__ import annotations

import inspect
import re
from typing import Any

DESCRIBED = re.compile(r"^(\w+(?:, \w+)*) :.*\n((?:    .*\n?)+)", re.MULTILINE)  # defined: numpydoc
UNIT = re.compile(r"\[([^\]]+)\]")


def unit_of_parameter(model: Any, name: str) -> str:
    """The unit in brackets of the parameter's description in the docstring of its class, as ``Mass [kg].``; "-" of one
    that is described without, nothing where it is not described. Of several described together, each its own or one."""
    text = inspect.getdoc(type(model)) if model is not None else None
    for names, words in DESCRIBED.findall(text or ""):
        listed = names.split(", ")
        if name in listed:
            units = UNIT.findall(words) or ["-"]
            return units[listed.index(name)] if len(units) == len(listed) else units[0]
    return ""
