"""What a colour means, in every figure: modes of contacts, terms of the energy, directions of force, curves.

Blue and orange are told apart with every kind of colour blindness; the lightness of the modes differs as well (CIE L*
from 94 to 16), so that a grey print keeps their order. Curves also differ by their dashes, points by markers.
Source of the cycle: Okabe and Ito, *Color Universal Design* (2008), without its yellow, which is lost on white.
"""

from __future__ import annotations

from nonsmooth.mechanics.system import ContactMode

BLUE, RED = "#08306b", "#b2182b"  # the one curve of a figure; what is marked in it
BLACK, GREY, PALE, WASHED = "#000000", "#7f7f7f", "#bdbdbd", "#e6e6e6"
CYCLE = ("#0072b2", "#d55e00", "#009e73", "#000000", "#cc79a7", "#56b4e9", "#e69f00", "#7f7f7f")
STYLES = ("-", "--", ":", "-.")
MARKERS = "os^Dv<>P"

STRIPS = {  # (mode, sign of sliding): colour
    (ContactMode.OPEN, 0): "#ededed",
    (ContactMode.SLIDE, 1): "#f5cf6e",
    (ContactMode.SLIDE, 0): "#e69f00",
    (ContactMode.SLIDE, -1): "#cc5500",
    (ContactMode.STICK, 0): "#1f5fa8",
    (ContactMode.LOCKED, 0): "#3b0f5c",
}
REGIONS = (("no solution", "#f4a6a0", "//"), ("one solution", "#ffffff", ""), ("two solutions", "#d3e3f3", ".."))
NORMAL, FRICTION = "#0072b2", "#d55e00"  # directions of a force or an impulse
Dashes = str | tuple[int, tuple[float, ...]]
# chosen: dashes and gaps, in widths of the line: terms of like lightness differ by them, for prints in grey
SOLID, DOTS, SPARSE, SHORT, DASHES, LONG = "-", ":", (0, (1, 3)), (0, (2, 1.2)), (0, (4, 1.5)), (0, (9, 2))
LINKED, BROKEN = (0, (7, 1.2, 1.2, 1.2)), (0, (3, 1.2, 1.2, 1.2, 1.2, 1.2))  # chosen: dashes with one dot, with two
ENERGIES: dict[str, tuple[str, Dashes]] = {  # term of the ledger: colour, dashes
    "kinetic": ("#0072b2", SOLID),
    "potential": ("#d55e00", LINKED),
    "force": ("#009e73", DASHES),
    "force, changing mass": ("#009e73", DOTS),
    "friction": ("#000000", DASHES),
    "normal": ("#cc79a7", SHORT),
    "surface": ("#e69f00", LONG),
    "projection": ("#7f7f7f", SPARSE),
    "step": ("#543005", DOTS),
    "elastic": ("#56b4e9", SOLID),
    "damping": ("#56b4e9", BROKEN),
}
STORED = ("kinetic", "potential", "elastic")  # defined: terms that are energies; the others are works


def cycled(k: int) -> tuple[str, str, str]:
    """Colour, dashes and marker of the k-th curve of a figure."""
    return CYCLE[k % len(CYCLE)], STYLES[k % len(STYLES)], MARKERS[k % len(MARKERS)]
