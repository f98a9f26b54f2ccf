"""The ready models and scenes, by name: ``load("sprag-slip")``, or ``from nonsmooth.catalogue import SpragSlip``.

These are the objects of the package ``models``, wherever that is not hidden by a file of the user's; here they are
found whatever stands in its way. Models that other packages register are loaded by ``load`` as well.
"""

from __future__ import annotations

from typing import Any

from nonsmooth.catalogue.entries import entries_by_class, load, load_entry, names

__all__ = ["load", "names"]


def __getattr__(name: str) -> Any:
    if name.startswith("_") or name in ("shipped", "files"):
        raise AttributeError(f"module 'nonsmooth.catalogue' has no attribute {name!r}")
    found = entries_by_class()
    if name not in found:
        from nonsmooth.errors import nearest

        raise AttributeError(f"there is no model {name!r}; {nearest(name, found)}")
    globals()[name] = load_entry(found[name])
    return globals()[name]


def __dir__() -> list[str]:
    return sorted({*__all__, *entries_by_class()})
