"""Axes: names and units of coordinates, velocities and parameters, legends above them, and how near they look."""

from __future__ import annotations

import re
from typing import Any

from nonsmooth.mechanics.units import unit_of_parameter

FLAT = 1e-6  # chosen: of its size: a curve that varies less is drawn as the constant it is
LETTER = 8  # chosen: points of the smallest letters: 5 in print where a figure is 80 mm wide
LEGEND_WIDTH, LETTER_WIDTH, HANDLE_WIDTH = 290.0, 4.6, 32.0  # measured: points of the axes, of a letter, of a handle
LEGEND_GAP = 0.1  # chosen: between a legend and its axes, in its letters
LETTERS_OF = {  # defined: the Greek letters by the names that are typed for them
    "alpha": "α", "beta": "β", "gamma": "γ", "delta": "δ", "eps": "ε", "epsilon": "ε", "zeta": "ζ", "eta": "η",
    "th": "θ", "theta": "θ", "kappa": "κ", "lam": "λ", "mu": "μ", "nu": "ν", "xi": "ξ", "rho": "ρ", "sigma": "σ",
    "tau": "τ", "phi": "φ", "psi": "ψ", "omega": "ω", "Omega": "Ω",
}  # fmt: skip
NAMED = re.compile(r"([A-Za-z]+?)((?:\d|_).*?)?(dot)?")  # defined: a name, its index, the sign of a rate


def coordinates_of(described: Any) -> list[tuple[str, str]]:
    """Name and unit of each coordinate of a system or a solution; q[k], without a unit, where nobody named them."""
    return list(described.described.coordinates)


def spelt(name: str) -> str:
    """A name as every figure has it: Greek letters for their names, and an apostrophe for a rate: th0 θ0, thdot θ'."""
    found = NAMED.fullmatch(name)
    if found is None:
        return name
    word, index, rate = found.groups(default="")
    return LETTERS_OF.get(word, word) + index + ("'" if rate else "")


def with_spelt_names(text: str) -> str:
    """A text in which each name before an equals sign is spelt so."""
    return re.sub(r"\w+(?= = )", lambda found: spelt(found[0]), text)


def coordinate_label(name: str, unit: str) -> str:
    """A coordinate on an axis."""
    return with_unit(name, unit)


def velocity_label(name: str, unit: str) -> str:
    """The rate of a coordinate on an axis."""
    return with_unit(f"{spelt(name)}'", f"{unit}/s" if unit else "")


def parameter_label(name: str, model: Any = None, unit: str = "") -> str:
    """A parameter on an axis, with the unit that was given or that its docstring names."""
    return with_unit(name, unit or unit_of_parameter(model, name))


def with_unit(name: str, unit: str) -> str:
    """The name, and the unit in brackets."""
    return f"{spelt(name)} [{unit}]" if unit else spelt(name)


def legend_above(axes: Any) -> None:
    """The legend in rows above the axes, as many entries a row as fit."""
    handles, _ = axes.get_legend_handles_labels()
    if handles:
        axes.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=columns_for(handles), fontsize=LETTER,
                    frameon=False, borderaxespad=LEGEND_GAP, handlelength=2.0, columnspacing=1.0)  # fmt: skip


def columns_for(handles: list[Any]) -> int:
    """How many entries of a legend fit in a row."""
    widest = max((len(handle.get_label()) for handle in handles), default=0)
    return max(1, min(len(handles), int(LEGEND_WIDTH / (LETTER_WIDTH * widest + HANDLE_WIDTH))))


def show_no_rounding(axes: Any, scale: float = 0.0) -> None:
    """Widen an axis whose curves are constant to rounding, of their size or of that of the motion, to that size."""
    low, high = axes.dataLim.intervaly
    size = max(abs(low), abs(high), scale)
    if high - low < FLAT * size:
        axes.set_ylim(min(-0.1 * size, 1.2 * low), max(0.1 * size, 1.2 * high))
