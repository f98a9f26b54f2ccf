"""A film as one HTML file: the page, its style, its scripts and the data, with nothing to be fetched.

The scripts are the package's own ``*.js`` files, one behind the other. A spatial film brings three.js with it, which is
kept as ``three.module.min.js.gz`` from its npm package (MIT, its licence beside it).
"""

from __future__ import annotations

import base64
import html
import json
from dataclasses import dataclass, fields
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np

from nonsmooth.checks.files import PAGE_ENDINGS, as_place, whole_file
from nonsmooth.drawing.colours import CYCLE, RED, STRIPS
from nonsmooth.drawing.player.film import Body, Contacts, Film, MarkKind, Shape
from nonsmooth.drawing.player.packing import LEVELS, packed, quantised, rounded
from nonsmooth.results.events import mode_name
from nonsmooth.views import view

SCRIPTS = ("unpack.js", "colours.js", "camera.js", "contacts.js", "plane.js", "space.js", "charts.js", "player.js")
EXACT_NUMBERS = 3_000_000  # chosen: of poses and contacts that are kept in float32, 12 MB; of more, 16 bits each
CONTACTS_KEPT = 600_000  # chosen: in all frames, which make some 8 MB; each frame keeps its share of the strongest
IN_NOTEBOOK = 720  # chosen: height of the player in a notebook [pixels]


@dataclass(frozen=True)
class Page:
    """The player as HTML; a notebook shows it."""

    text: str
    title: str

    def _repr_html_(self) -> str:
        return (
            f'<iframe title="{html.escape(self.title)}" style="width:100%;height:{IN_NOTEBOOK}px;border:0" '
            f'srcdoc="{html.escape(self.text)}"></iframe>'
        )

    def __repr__(self) -> str:
        return f"Page({self.title!r}, {len(self.text) / 1e6:.2g} MB): shown in a notebook; give a path to write it"


def show(result: Any, path: str | Path | None = None) -> Path | Page:
    """The player of a result: written to a file that any browser opens offline, or shown in a notebook.

    Parameters
    ----------
    result : Solution, SceneSolution, or another result that has a film
    path : path-like, optional
        An .html file; without it the player is shown inline in a notebook.

    Returns
    -------
    Path or Page

    Raises
    ------
    InvalidInput
        When the model has no ``shape(q)``, the result has no model, or the path cannot be written.
    """
    if path is not None:
        path = as_place("path", path, PAGE_ENDINGS)
    film = view(result, "film")(result)
    text = page_of(film)
    if path is None:
        return Page(text, film.title)
    with whole_file(path) as part:
        part.write_text(text, encoding="utf-8")
    return path


def page_of(film: Film) -> str:
    """The whole page of a film."""
    parts = {
        "title": html.escape(film.title or "motion"),
        "style": asset("player.css"),
        "data": json.dumps(as_json(film), allow_nan=False, separators=(",", ":")).replace("<", "\\u003c"),
        "three": "" if film.is_planar else three(),
        "script": "\n".join(asset(name) for name in SCRIPTS),
    }
    pieces = asset("page.html").split("%%")  # %%name%% stands for a part
    return "".join(parts[piece] if k % 2 else piece for k, piece in enumerate(pieces))


def asset(name: str) -> str:
    """A text file of this folder."""
    return (resources.files(__package__) / name).read_text(encoding="utf-8")


def three() -> str:
    """three.js, compressed, as base64."""
    return base64.b64encode((resources.files(__package__) / "three.module.min.js.gz").read_bytes()).decode()


def as_json(film: Film) -> dict[str, Any]:
    """What the page reads."""
    contacts, d = strongest(film.contacts, CONTACTS_KEPT // len(film.times)), film.position.shape[-1]
    is_exact = film.position.size + film.turn.size + contacts.point.size + contacts.P_F.size <= EXACT_NUMBERS
    place, impulse = (packed, packed) if is_exact else (quantised, lambda P: packed(rounded(P)))
    return {
        "title": film.title, "dimension": d, "about": dict(film.about),
        "detail": "; ".join(filter(None, (film.detail, accuracy(film, is_exact), lost(film.contacts, contacts)))),
        "times": packed(film.times, "<f8"),
        "bodies": [body_as_json(body) for body in film.bodies],
        "position": place(film.position),
        "turn": place(film.turn if d == 3 else film.turn[..., None]),
        "contacts": {
            "start": packed(contacts.start, "<i4"), "number": packed(contacts.number, "<i4"),
            "mode": packed(contacts.mode, "<i1"), "slip": packed(contacts.slip, "<i1"),
            "point": place(contacts.point), "normal": place(contacts.normal),
            "P_N": impulse(contacts.P_N), "P_F": impulse(contacts.P_F), "mu": packed(contacts.mu),
        },
        "contactNames": film.contact_names, "isOfLastStep": film.is_of_last_step,
        "marks": [[mark.t, mark.frame, mark.kind, mark.text, mark.choice] for mark in film.marks],
        "curves": [
            [c.group, c.name, c.unit, packed(c.values), c.scale, c.colour, list(c.dashes)] for c in film.curves
        ],
        "cycle": list(CYCLE),
        "modes": [[int(mode), slip, mode_name(mode, slip), colour] for (mode, slip), colour in STRIPS.items()],
        "paradox": {"colour": RED, "kinds": [MarkKind.INCONSISTENT, MarkKind.INDETERMINATE]},
    }  # fmt: skip


def strongest(contacts: Contacts, most: int) -> Contacts:
    """At most so many contacts of each frame: those with the largest impulses."""
    counts = np.diff(contacts.start)
    if counts.max(initial=0) <= most:
        return contacts
    size = np.hypot(contacts.P_N, np.linalg.norm(contacts.P_F, axis=1))
    spans = zip(contacts.start[:-1], contacts.start[1:], strict=True)
    kept = [np.sort(a + np.argsort(-size[a:b], kind="stable")[:most]) for a, b in spans]
    start = np.concatenate([[0], np.cumsum(np.minimum(counts, most))])
    columns = {f.name: getattr(contacts, f.name)[np.concatenate(kept)] for f in fields(contacts) if f.name != "start"}
    return Contacts(start=start, **columns)


def lost(all_of_them: Contacts, kept: Contacts) -> str:
    """How many contacts are left out."""
    n, m = len(all_of_them.number), len(kept.number)
    return "" if n == m else f"of {n} contacts in all frames the {m} strongest"


def body_as_json(body: Body) -> dict[str, Any]:
    """A body with its shapes."""
    return {"name": body.name, "fixed": body.is_fixed, "guided": body.is_guided, "material": body.material,
            "shapes": [shape_as_json(shape) for shape in body.shapes]}  # fmt: skip


def shape_as_json(shape: Shape) -> dict[str, Any]:
    """A shape with its place in its body, if it has one."""
    place = None if shape.place is None else shape.place.tolist()
    shade = None if shape.shade is None else shape.shade.tolist()
    return {"kind": shape.kind, "points": packed(shape.points), "radius": float(shape.radius), "place": place,
            "shade": shade}  # fmt: skip


def accuracy(film: Film, is_exact: bool) -> str:
    """How exactly the poses are kept."""
    if is_exact:
        return "poses in float32"
    size = float(np.ptp(film.position, axis=(0, 1)).max())
    return f"positions to {size / (2 * LEVELS):.1g} m (16 bits), impulses to 0.05 %"
