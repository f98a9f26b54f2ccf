"""A Matplotlib figure that a notebook's cell shows by itself, with neither pyplot nor a magic line."""

from __future__ import annotations

import io

from matplotlib.figure import Figure

SCREEN_DPI = 110  # chosen: at which a figure is as large as it was meant on a usual screen
SHARPNESS = 2  # chosen: pixels of the image for one of a usual screen


class NotebookFigure(Figure):
    """A figure with the representation that notebooks ask for."""

    def _repr_png_(self) -> tuple[bytes, dict[str, int]]:
        """The image, and how many pixels wide and high it is shown."""
        image = io.BytesIO()
        self.savefig(image, format="png", dpi=SHARPNESS * SCREEN_DPI)
        width, height = self.get_size_inches() * SCREEN_DPI
        return image.getvalue(), {"width": round(width), "height": round(height)}
