"""Sphinx: ``sphinx-build -W docs docs/_build`` with the extra [docs].

The page of the public names and the page of the command line are written from the package itself, so that they are
complete: every name of ``nonsmooth.__all__``, ``models.__all__`` and ``models.scenes.__all__``, all help texts.
"""

import argparse
import importlib
import os
from pathlib import Path

from sphinx.application import Sphinx

import models
import models.scenes
import nonsmooth
from nonsmooth.commands.cli import build_parser

project = "nonsmooth"
author = "nonsmooth developers"
version = release = nonsmooth.__version__
extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.viewcode", "numpydoc"]
myst_enable_extensions = ["dollarmath", "amsmath"]
myst_heading_anchors = 3
exclude_patterns = ["_build", "generated/commands.md"]
numpydoc_show_class_members = False
autodoc_member_order = "bysource"
autodoc_typehints = "none"  # the docstrings give types with shapes and units
html_theme = "alabaster"

GENERATED = Path(__file__).parent / "generated"


def directive(path: str, value: object) -> str:
    """The autodoc directive of a public name."""
    if isinstance(value, type):
        members = "" if issubclass(value, Exception) else "\n   :members:"
        return f".. autoclass:: {path}{members}"
    return f".. autofunction:: {path}" if callable(value) else f".. autodata:: {path}"


def api_page() -> str:
    """The public names under the module that holds them, in the order of ``nonsmooth.__all__``."""
    lines = ["# Public names", "", "`import nonsmooth as ns` loads each of these when it is first used."]
    homes = dict.fromkeys(nonsmooth._HOME.values())
    for home in homes:
        module = importlib.import_module(f"nonsmooth.{home}")
        title = home.removesuffix(".options").split(".")[-1]  # the options of an integrator have its name
        lines += ["", f"## {title.replace('_', ' ').capitalize()}", "", f"`{module.__name__}`: "]
        lines[-1] += (module.__doc__ or "").strip().splitlines()[0]
        for name in (name for name, of in nonsmooth._HOME.items() if of == home):
            lines += ["", "```{eval-rst}", directive(f"nonsmooth.{name}", getattr(nonsmooth, name)), "```"]
    lines += ["", "## Models", "", "`from nonsmooth.catalogue import ...`; [their physics](../models.md)."]
    for name in models.__all__:
        path = f"models.{name}"
        lines += ["", "```{eval-rst}", directive(path, getattr(models, name)), "```"]
    lines += [
        "",
        "## Ready scenes",
        "",
        "`from nonsmooth.catalogue import ...`; [what is known of them](../scenes.md).",
    ]
    for name in models.scenes.__all__:
        path = f"models.scenes.{name}"
        lines += ["", "```{eval-rst}", directive(path, getattr(models.scenes, name)), "```"]
    return "\n".join(lines) + "\n"


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
    GENERATED.mkdir(exist_ok=True)
    (GENERATED / "api.md").write_text(api_page())
    (GENERATED / "commands.md").write_text(commands_page())
