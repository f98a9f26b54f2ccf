"""What a file of a scene may hold, as a JSON schema: editors complete names by it, and mark those that are none.

It is made from the methods that the tables call (scene_files.py): their arguments, those without a default required.
Source: JSON Schema, draft 2020-12.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable
from typing import Any

from nonsmooth.scenes.materials import Material
from nonsmooth.scenes.scene import Scene
from nonsmooth.scenes.scene_files import BUILT, DIRECTED, KINDS, LAWS, OF_JOINTS, PINS, SHAPES, TEXTS

Schema = dict[str, Any]

NUMBER: Schema = {"type": ["number", "string"], "description": "a number, or a text that is a formula"}
NAMES: Schema = {"type": "array", "items": {"type": "string"}}
COUNTS: Schema = {"type": "object", "additionalProperties": NUMBER, "description": 'k = "n": for k = 0, ..., n - 1'}
ANY_NUMBERS: Schema = {"type": ["number", "string", "array"], "description": "numbers, or texts that are formulas"}


def schema() -> Schema:
    """The schema of scene files."""
    lists = {name: {"type": "array", "items": _of_list(name, methods)} for name, methods in KINDS.items()}
    lists["ignored"]["items"] = {**_closed({"bodies": NAMES, "repeat": COUNTS}), "required": ["bodies"]}
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "A scene of nonsmooth",
        **_closed({
            "include": {"type": "array", "items": {"type": "string"}},
            "values": {"type": "object", "additionalProperties": NUMBER},
            "materials": {"type": "array", "items": _of_call(Material)},
            **lists, **_arguments(Scene),
        }),
    }  # fmt: skip


def _of_list(name: str, methods: tuple[str, ...]) -> Schema:
    """A table of a list: one of its kinds, the first where it names none."""
    kinds = []
    for method in methods:
        call = _of_call(getattr(Scene, method), {"repeat": COUNTS, "kind": {"const": method}})
        if name == "joints":
            call["properties"] |= {part: {"type": "array", "items": {"type": "object"}} for part in OF_JOINTS}
        if method != methods[0]:
            call["required"] = ["kind", *call["required"]]
        kinds.append(call)
    return {"anyOf": kinds} if len(kinds) > 1 else kinds[0]


def _of_call(act: Callable[..., Any], more: Schema | None = None) -> Schema:
    """A table with the arguments of a function."""
    taken = {name: one for name, one in inspect.signature(act).parameters.items() if name != "self"}
    needed = [name for name, one in taken.items() if one.default is inspect.Parameter.empty]
    return {**_closed({**_arguments(act), **(more or {})}), "required": needed}


def _arguments(act: Callable[..., Any]) -> Schema:
    return {name: _of_argument(name) for name in inspect.signature(act).parameters if name != "self"}


def _of_argument(name: str) -> Schema:
    """What an argument may be, by its name."""
    if name == "material":
        return {"anyOf": [{"type": "string"}, _of_call(Material)]}
    if name in TEXTS:
        return {"type": "string"}
    if name == "shape":
        return _one_of(SHAPES)
    if name == "friction":
        return _one_of(PINS)
    if name == "mu":
        return {"anyOf": [NUMBER, _one_of(LAWS | DIRECTED)]}
    return ANY_NUMBERS


def _one_of(names: dict[str, Any]) -> Schema:
    """A table {Name = arguments}."""
    known: Schema = {name: {} for name in names if name in BUILT and not inspect.isabstract(names[name])}
    return {**_closed(known), "minProperties": 1, "maxProperties": 1}


def _closed(properties: Schema) -> Schema:
    """A table without other names."""
    return {"type": "object", "properties": properties, "additionalProperties": False}
