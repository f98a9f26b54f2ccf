"""What a package index, a citation and a conda recipe say of the package agrees with pyproject.toml."""

import re
import tomllib
from pathlib import Path

import yaml

import nonsmooth

ROOT = Path(__file__).parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]


def recipe():
    """The recipe as YAML, its two expressions of Jinja replaced."""
    text = (ROOT / "packaging/conda/meta.yaml").read_text()
    (version,) = re.findall(r'^{% set version = "(.*)" %}$', text, re.MULTILINE)
    text = re.sub(r"^{%.*$", "", text, flags=re.MULTILINE).replace("{{ version }}", version)
    return yaml.safe_load(text.replace("{{ PYTHON }}", "python"))


def test_the_version_is_one():
    cited = yaml.safe_load((ROOT / "CITATION.cff").read_text())
    assert nonsmooth.__version__ == PROJECT["version"] == cited["version"] == recipe()["package"]["version"]
    assert cited["license"] == PROJECT["license"] == recipe()["about"]["license"]
    assert recipe()["about"]["summary"] == PROJECT["description"]


def test_the_recipe_has_the_dependencies_of_the_package():
    """An extra of a dependency, qpsolvers[osqp], is a package of its own there."""
    needed = {re.sub(r"\[.*\]", "", text) for text in PROJECT["dependencies"]}
    run = [text.replace(" ", "") for text in recipe()["requirements"]["run"]]
    assert {text for text in run if not text.startswith("python")} == needed
    assert f"python{PROJECT['requires-python']}" in run
    (script,) = recipe()["build"]["entry_points"]
    assert script == f"nonsmooth = {PROJECT['scripts']['nonsmooth']}"
