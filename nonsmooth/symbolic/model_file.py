"""From a declaration to a model: derive it and write its source, or find what was written, import it, check it."""

from __future__ import annotations

import functools
import hashlib
import re
from pathlib import Path
from typing import Any

import sympy as sp

import nonsmooth
from nonsmooth.symbolic.generated import module_of
from nonsmooth.symbolic.model_source import Writer, class_name
from nonsmooth.symbolic.refusals import require_possible, require_regular_start

GENERATORS = sorted(Path(__file__).parent.glob("*.py"))


def derived_model(declaration: Any, jacobians: bool, t_end: float, dt: float) -> Any:
    """The model of a declaration, an instance of a dataclass of its own."""
    require_possible(declaration)
    key = key_of(declaration, jacobians, t_end, dt)
    stem = re.sub(r"[^a-z0-9]+", "_", declaration.name.lower()).strip("_")[:40]
    module = module_of(f"{stem}_{key[:24]}", lambda: Writer(declaration, jacobians, t_end, dt).text())
    model = getattr(module, class_name(declaration.name))()
    require_regular_start(model)
    return model


def key_of(declaration: Any, jacobians: bool, t_end: float, dt: float) -> str:
    """A hash of all that the source is made from: what was typed, and the programs that derive and write it."""
    declared = declaration.complete()
    facts = (
        (nonsmooth.__version__, sp.__version__, generators_hash()),
        (declaration.name, jacobians, t_end, dt, sorted(declaration.starts.items())),
        (list(declaration.parameter_fields.values()), [*declaration.coordinate_units.values()]),
        (repr(declared), [sp.srepr(expression) for expression in declared.expressions()]),  # with all digits
    )
    return hashlib.sha256(repr(facts).encode()).hexdigest()


@functools.cache
def generators_hash() -> str:
    """Hash of the sources that derive and write."""
    return hashlib.sha256(b"".join(path.read_bytes() for path in GENERATORS)).hexdigest()
