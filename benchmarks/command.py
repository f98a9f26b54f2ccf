"""``python -m benchmarks accuracy | bits | bodies | contacts | core | ladder | paradox | penalty | solvers | ...``.

Each is a module with ``main(words) -> exit code``; exit codes and lines on stderr are those of ``nonsmooth``.
"""

from __future__ import annotations

import argparse
import importlib
import sys

from nonsmooth.commands.cli import perform
from nonsmooth.commands.typed_input import Parser
from nonsmooth.errors import InvalidInput

NAMES = (
    "accuracy", "bits", "bodies", "calls", "chain", "contacts", "core", "exact", "ladder", "limit", "others", "paradox",
    "penalty", "piles", "player", "precision", "published", "robots", "scenes", "solvers", "space", "stability",
    "stress", "sweep", "symbolic", "work",
)  # fmt: skip


def main(argv: list[str] | None = None) -> int:
    """Run a benchmark; returns the exit code."""
    return perform(build_parser(), sys.argv[1:] if argv is None else argv)


def build_parser() -> argparse.ArgumentParser:
    """The benchmarks with their options."""
    parser = Parser(prog="python -m benchmarks", description="measure run times and errors")
    parser.set_defaults(act=act)
    parser.add_argument("what", choices=NAMES, metavar="benchmark", help=", ".join(NAMES))
    parser.add_argument(
        "files", nargs="*",
        help="solvers: more problems to time; accuracy: words that the scenes' names hold; stress: the page to write, "
        "and the folder of its pictures; contacts: the folder of its picture; ladder: folders of published problems, "
        "names of ladders and sets; others: folders of problems; published: names of its sections; scenes: their "
        "names, `quick` for small ones; exact: names of its scenes; precision, space: the file of their picture, and "
        "names; robots: folders of .xml and .urdf files; piles: the folder of Kleinert's; "
        "bits: the file of hashes to write, and one to compare with",
    )  # fmt: skip
    parser.add_argument("--peers", action="store_true", help="accuracy: other programs too, where they are installed")
    parser.add_argument("--out", metavar="FILE", help="accuracy: write the page and its figure")
    return parser


def act(arguments: argparse.Namespace) -> int:
    """Run what was asked for, with the options that it knows."""
    options = [*(["--peers"] if arguments.peers else []), *(["--out", arguments.out] if arguments.out else [])]
    if options and arguments.what != "accuracy":
        raise InvalidInput(f"{options[0]} belongs to `accuracy`; leave it out of `{arguments.what}`")
    return importlib.import_module(f"benchmarks.{arguments.what}").main([*arguments.files, *options]) or 0
