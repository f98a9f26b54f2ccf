"""Sphinx: ``sphinx-build -W docs docs/_build`` with the extra [docs]."""

project = "nonsmooth"
author = "nonsmooth developers"
extensions = ["myst_parser"]
myst_enable_extensions = ["dollarmath", "amsmath"]
exclude_patterns = ["_build"]
