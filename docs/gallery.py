"""What a page of the gallery shows of a block of its script: each figure made in it, and each player written by it."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure
from sphinx_gallery.scrapers import figure_rst

DPI = 110  # chosen: of the pictures of the gallery
PLAYERS = "_static/players"


def scrape(block: Any, block_vars: dict[str, Any], gallery_conf: dict[str, Any]) -> str:
    """Return the reStructuredText of the figures and players that the names of a script hold since this block."""
    seen = block_vars["example_globals"].setdefault("_shown", set())
    paths, text = [], ""
    for name, value in list(block_vars["example_globals"].items()):
        if name.startswith("_") or id(value) in seen:
            continue
        if isinstance(value, Figure):
            seen.add(id(value))
            paths.append(next(block_vars["image_path_iterator"]))
            value.savefig(paths[-1], dpi=DPI)
        elif isinstance(value, Path) and value.suffix == ".html":
            seen.add(id(value))
            text += player(value, Path(gallery_conf["src_dir"]))
    return figure_rst(paths, gallery_conf["src_dir"]) + text


def player(page: Path, source: Path) -> str:
    """Keep a player with the pages, and return the frame that shows it."""
    kept = source / PLAYERS / page.name
    kept.parent.mkdir(parents=True, exist_ok=True)
    shutil.move(page, kept)
    frame = f'<iframe class="player" src="../../../{PLAYERS}/{page.name}" title="player" loading="lazy"></iframe>'
    return f"\n.. raw:: html\n\n    {frame}\n\n"


def _get_sg_image_scraper() -> Any:
    return scrape
