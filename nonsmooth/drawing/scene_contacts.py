"""Contacts in an animation of a scene: dots in the colour of what they do, lines along what they exert on a body."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from nonsmooth.drawing.colours import RED, STRIPS
from nonsmooth.drawing.labels import LETTER
from nonsmooth.drawing.scene import ARROW, LARGE
from nonsmooth.mechanics.system import ContactMode
from nonsmooth.results.recorded import CONTACTS
from nonsmooth.scenes.elements import Kind

if TYPE_CHECKING:
    from nonsmooth.results.scene_solution import SceneSolution

LARGEST_DOT, LEAST_DOT, DOTS_AREA = 28.0, 3.0, 600.0  # chosen: points^2: of a dot, and of all of them together
SHOWN = {ContactMode.STICK: "stick", ContactMode.SLIDE: "slide"}  # what a loaded contact does


def scene_contact_marks(axes: Any, solution: SceneSolution, view: np.ndarray) -> Callable[[int], list[Any]]:
    """What draws the loaded contacts of a record, seen along the rows of ``view`` (2, dim).

    The lines are impulses of a step, on the body that is free to move; of compliant contacts forces.
    """
    from matplotlib.collections import LineCollection
    from matplotlib.lines import Line2D

    sizes = np.linalg.norm(solution.all_contacts.P, axis=1) if CONTACTS in solution.recorded else np.zeros(0)
    if not (sizes > 0).any():
        return lambda k: []
    large = float(np.quantile(sizes[sizes > 0], LARGE))
    length = ARROW * float(np.ptp(axes.get_ylim()))
    most = int(np.diff(solution.all_contacts.offsets).max())
    area = float(np.clip(DOTS_AREA / most, LEAST_DOT, LARGEST_DOT))
    lines = axes.add_collection(LineCollection([], colors=RED, linewidths=1.2, zorder=4))
    dots = axes.scatter([0.0], [0.0], s=area, zorder=5, edgecolors="black", linewidths=0.4)
    for artist in (lines, dots):
        artist.set_animated(True)
    what, unit = ("force", "N") if solution.about["contacts"].startswith("forces") else ("impulse of a step", "N s")
    handles = [Line2D([], [], marker="o", ls="", color=STRIPS[loaded_look(mode)], mec="black", mew=0.4, label=word)
               for mode, word in SHOWN.items()]  # fmt: skip
    handles.append(Line2D([], [], color=RED, lw=1.2, label=f"{what}, full length {large:.3g} {unit}"))
    axes.figure.legend(handles=handles, loc="outside lower center", ncols=3, fontsize=LETTER, frameon=False)
    free = np.array([body.kind is Kind.DYNAMIC for body in solution.bodies])

    def marks(k: int) -> list[Any]:
        """Move the marks to a record."""
        contacts = solution.contacts(float(solution.t[k]))
        loaded = np.flatnonzero(np.linalg.norm(contacts.P, axis=1) > 0)
        point = contacts.point[loaded] @ view.T
        P = np.where(free[contacts.j[loaded]], 1.0, -1.0)[:, None] * contacts.P[loaded] / large
        P *= length / np.maximum(1.0, np.linalg.norm(P, axis=1))[:, None]
        lines.set_segments(np.stack([point, point + P @ view.T], axis=1))
        dots.set_offsets(point)
        dots.set_facecolors([STRIPS[loaded_look(ContactMode(int(mode)))] for mode in contacts.mode[loaded]])
        return [lines, dots]

    return marks


def loaded_look(mode: ContactMode) -> tuple[ContactMode, int]:
    """What the colour of a loaded contact is named by: of sliding no sign is known, in space there is none."""
    return (ContactMode.STICK, 0) if mode == ContactMode.STICK else (ContactMode.SLIDE, 0)
