"""Sphinx: ``sphinx-build -W docs docs/_build`` with the extra [docs].

The page of the public names and the page of the command line are written from the package itself, so that they are
complete: every name of ``nonsmooth.__all__``, ``models.__all__`` and ``models.scenes.__all__``, all help texts.
"""

import argparse
import importlib
import inspect
import os
import sys
from collections.abc import Iterator
from pathlib import Path

from sphinx.application import Sphinx

import models
import models.scenes
import nonsmooth
from nonsmooth.commands.cli import build_parser

sys.path.insert(0, str(Path(__file__).parent))  # the scraper of the gallery

project = "nonsmooth"
author = "nonsmooth developers"
version = release = nonsmooth.__version__
extensions = [
    "myst_parser", "sphinx.ext.autodoc", "sphinx.ext.viewcode", "numpydoc", "sphinx_design", "sphinx_copybutton",
    "sphinx_gallery.gen_gallery", "sphinx-mathjax-offline",
]  # fmt: skip
myst_enable_extensions = ["dollarmath", "amsmath", "colon_fence"]
myst_heading_anchors = 3
exclude_patterns = ["_build", "generated/commands.md", "examples"]
numpydoc_show_class_members = False
autodoc_member_order = "bysource"
autodoc_typehints = "none"  # the docstrings give types with shapes and units
mathjax3_config = {"chtml": {"scale": 0.92}}
html_theme = "furo"
html_show_copyright = False
html_title = f"{project} {release}"
html_static_path = ["_static"]
html_css_files = ["site.css"]
copybutton_prompt_text = r">>> |\.\.\. |\$ "
copybutton_prompt_is_regexp = True
THEMES = (
    "friction", "exact_friction", "impact", "paradox", "scenes", "penalty_limits", "vibration", "energies", "sweeps",
    "contact_problems",
)  # fmt: skip
sphinx_gallery_conf = {
    "examples_dirs": "examples",
    "gallery_dirs": "generated/gallery",
    "filename_pattern": r"\.py$",
    "backreferences_dir": "generated/backreferences",
    "doc_module": ("nonsmooth",),
    "subsection_order": [f"examples/{theme}" for theme in THEMES],
    "within_subsection_order": "FileNameSortKey",
    "show_memory": False,
    "write_computation_times": False,
    "show_signature": False,
    "remove_config_comments": True,
    "download_all_examples": False,
    "image_scrapers": ("gallery",),
    "abort_on_example_error": True,
}

GENERATED = Path(__file__).parent / "generated"


def directive(path: str, value: object) -> str:
    """The autodoc directive of a public name."""
    if isinstance(value, type):
        members = "" if issubclass(value, Exception) else "\n   :members:"
        return f".. autoclass:: {path}{members}"
    return f".. autofunction:: {path}" if callable(value) else f".. autodata:: {path}"


def first_sentence(value: object) -> str:
    """What a public name is for, for the table that leads to its page."""
    paragraph = (inspect.getdoc(value) or "").split("\n\n")[0]
    return " ".join(paragraph.split()).replace("``", "`").replace("|", "\\|")


def page_of(path: str, value: object) -> str:
    """The page of a public name: its docstring, and the examples of the gallery that use it."""
    name = path.split(".")[-1]
    lines = [f"# {name}", "", "```{eval-rst}", directive(path, value), ""]
    lines += [f".. minigallery:: {path}", "```"]
    return "\n".join(lines) + "\n"


def sections() -> Iterator[tuple[str, str, dict[str, object]]]:
    """Title, introduction and public names by their paths, in the order of ``nonsmooth.__all__``, then the models."""
    for home in dict.fromkeys(nonsmooth._HOME.values()):
        module = importlib.import_module(f"nonsmooth.{home}")
        title = home.removesuffix(".options").split(".")[-1]  # the options of an integrator have its name
        names = [name for name, of in nonsmooth._HOME.items() if of == home]
        says = (module.__doc__ or "").strip().splitlines()[0]
        named = {f"nonsmooth.{name}": getattr(nonsmooth, name) for name in names}
        yield title.replace("_", " ").capitalize(), f"`{module.__name__}`: {says}", named
    of_models = {f"models.{name}": getattr(models, name) for name in models.__all__}
    yield "Models", "`from nonsmooth.catalogue import ...`; [their physics](../models.md).", of_models
    of_scenes = {f"models.scenes.{name}": getattr(models.scenes, name) for name in models.scenes.__all__}
    yield "Ready scenes", "`from nonsmooth.catalogue import ...`; [what is known of them](../scenes.md).", of_scenes


def write_api() -> None:
    """A page for each public name, and the table of all."""
    lines = ["# Public names", "", "`import nonsmooth as ns` loads each of these when it is first used."]
    pages = []
    for title, says, named in sections():
        lines += ["", f"## {title}", "", says, "", "| name | |", "|---|---|"]
        for path, value in named.items():
            pages.append(f"api/{path}")
            write(GENERATED / f"api/{path}.md", page_of(path, value))
            lines.append(f"| [`{path.split('.')[-1]}`](api/{path}.md) | {first_sentence(value)} |")
    lines += ["", "```{toctree}", ":hidden:", "", *pages, "```"]
    write(GENERATED / "api.md", "\n".join(lines) + "\n")


def write(path: Path, text: str) -> None:
    """Write a page where it differs from the one that is there: Sphinx reads again only what changed."""
    path.parent.mkdir(parents=True, exist_ok=True)
    if not path.exists() or path.read_text() != text:
        path.write_text(text)


def commands_page() -> str:
    """The help text of every command, as a terminal of 100 columns shows it."""
    os.environ["COLUMNS"] = "100"
    return "\n".join(help_texts(build_parser()))


def help_texts(parser: argparse.ArgumentParser) -> list[str]:
    """The help of a command, or of the commands that it has."""
    groups = [action for action in parser._actions if isinstance(action, argparse._SubParsersAction)]
    if groups:
        return [text for command in groups[0].choices.values() for text in help_texts(command)]
    return [f"## {parser.prog}", "", "```text", parser.format_help().rstrip(), "```", ""]


def keep_bars(app: Sphinx, what: str, name: str, value: object, options: object, lines: list[str]) -> None:
    """|x| in a docstring is an absolute value, not a substitution of reStructuredText."""
    for k, line in enumerate(lines):
        if not line.lstrip().startswith((">>>", "...")):
            parts = line.split("``")
            lines[k] = "``".join(part if i % 2 else part.replace("|", "\\|") for i, part in enumerate(parts))


def setup(app: Sphinx) -> None:
    app.connect("autodoc-process-docstring", keep_bars, priority=900)
    write_api()
    write(GENERATED / "commands.md", commands_page())
