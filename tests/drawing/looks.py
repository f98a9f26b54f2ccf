"""What can be tested of the looks of any figure: where its letters stand and how large they are, units of its axes."""

from __future__ import annotations

import itertools
import re
from unittest import mock

PRINTED = 80.0 / 25.4  # in: the width of a figure in a column
LEAST_SPACE = 2.0  # points between the labels of axes that stand over one another
LEAST_LETTER = 5.0  # points in print: what publishers ask for
NO_QUANTITY = re.compile(r"^$|number of|mode|solutions?$|contacts$")


def drawn_texts(figure):
    """The texts that were drawn, and the boxes (pixels) that they fill."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.text import Text

    canvas, seen = FigureCanvasAgg(figure), []
    canvas.draw()  # the layout is found
    draw = Text.draw

    def recording(text, renderer):
        seen.append(text)
        return draw(text, renderer)

    with mock.patch.object(Text, "draw", recording):
        canvas.draw()
    shown = {id(text): text for text in seen if text.get_visible() and text.get_text().strip()}
    return [(text, text.get_window_extent(canvas.get_renderer())) for text in shown.values()]


def faults(figure):
    """Texts outside the figure, over one another, or too small to read 80 mm wide; axes without a unit."""
    boxes = drawn_texts(figure)
    whole, found = figure.bbox, []
    for text, box in boxes:
        if box.x0 < -1 or box.y0 < -1 or box.x1 > whole.x1 + 1 or box.y1 > whole.y1 + 1:
            found.append(f"outside: {text.get_text()!r}")
        if text.get_fontsize() * PRINTED / figure.get_figwidth() < LEAST_LETTER - 0.05 and "$" not in text.get_text():
            found.append(f"small: {text.get_text()!r}")
    for (one, a), (other, b) in itertools.combinations(boxes, 2):
        if min(a.x1, b.x1) - max(a.x0, b.x0) > 1 and min(a.y1, b.y1) - max(a.y0, b.y0) > 1:
            found.append(f"over one another: {one.get_text()!r} and {other.get_text()!r}")
    found += touching(figure, boxes)
    return found + [f"no unit: {label!r}" for label in labels(figure) if not has_unit(label)]


def touching(figure, boxes):
    """Labels of two vertical axes, one over the other, without a space between them."""
    shown = {id(a.yaxis.label) for part in (figure, *figure.subfigs) for a in part.axes}
    space = LEAST_SPACE * figure.dpi / 72.0
    for (one, a), (other, b) in itertools.combinations([pair for pair in boxes if id(pair[0]) in shown], 2):
        if min(a.x1, b.x1) > max(a.x0, b.x0) and max(a.y0, b.y0) - min(a.y1, b.y1) < space:
            yield f"touching: {one.get_text()!r} and {other.get_text()!r}"


def labels(figure):
    """The labels of the axes that are shown."""
    parts = [figure, *figure.subfigs]
    axes = [a for part in parts for a in part.axes if a.axison and a.get_visible()]
    return [label for a in dict.fromkeys(axes) for label in (a.get_xlabel(), a.get_ylabel())]


def has_unit(label):
    """Whether a label names a unit, or is of nothing that has one."""
    return bool(re.search(r"\[.+\]", label) or NO_QUANTITY.search(label))
