"""``python -m benchmarks``: names, options, refusals; what a wheel holds."""

import importlib
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from benchmarks.command import NAMES, main

ROOT = Path(__file__).parents[2]


@pytest.mark.parametrize("name", NAMES)
def test_each_name_is_a_benchmark(name):
    assert callable(importlib.import_module(f"benchmarks.{name}").main)


def test_the_words_and_options_reach_the_benchmark(monkeypatch):
    given = []
    monkeypatch.setattr("benchmarks.accuracy.main", lambda words: given.append(words))
    assert main(["accuracy", "ball", "--peers", "--out", "page.md"]) == 0
    assert given == [["ball", "--peers", "--out", "page.md"]]


@pytest.mark.parametrize(("word", "named"), [("cor", ["'core'"]), ("nothing like it", NAMES)])
def test_a_misspelt_benchmark_is_refused_with_the_nearest_or_the_names_of_all(word, named, capsys):
    with pytest.raises(SystemExit) as stop:
        main([word])
    said = capsys.readouterr().err
    assert stop.value.code == 2 and "there is no benchmark" in said and all(name in said for name in named)


def test_python_runs_them_in_a_checkout_without_loading_a_library():
    code = (
        "import sys, benchmarks.command\nprint([name for name in ('numpy', 'numba', 'scipy') if name in sys.modules])"
    )
    for words in (["-m", "benchmarks", "--help"], ["-c", code]):
        ended = subprocess.run([sys.executable, *words], cwd=ROOT, capture_output=True, text=True, timeout=60)
        assert ended.returncode == 0 and ("core" in ended.stdout or ended.stdout == "[]\n"), ended


def test_a_wheel_holds_no_line_of_them_and_every_file_of_the_player(tmp_path):
    """Built by hatchling from a copy of what it reads."""
    wheel = pytest.importorskip("hatchling.builders.wheel")
    from zipfile import ZipFile

    for name in ("pyproject.toml", "README.md", "LICENSE"):
        shutil.copy(ROOT / name, tmp_path / name)
    for name in ("nonsmooth", "models", "benchmarks", "tests"):
        shutil.copytree(ROOT / name, tmp_path / name, ignore=shutil.ignore_patterns("__pycache__", "data"))
    (built,) = wheel.WheelBuilder(str(tmp_path)).build(directory=str(tmp_path / "dist"), versions=["standard"])
    names = set(ZipFile(built).namelist())
    sources = {path.relative_to(ROOT).as_posix() for path in (ROOT / "nonsmooth" / "drawing" / "player").glob("*.*")}
    assert sources <= names and any(name.endswith("three.module.min.js.gz") for name in sources)
    folders = {name.split("/")[0] for name in names}
    assert {"nonsmooth", "models"} == {folder for folder in folders if not folder.endswith(".dist-info")}


def test_the_wheel_is_of_the_package_and_the_models():
    import tomllib

    settings = tomllib.loads((ROOT / "pyproject.toml").read_text())
    assert settings["tool"]["hatch"]["build"]["targets"]["wheel"]["packages"] == ["nonsmooth", "models"]


def test_nothing_that_is_shipped_looks_for_tests_or_benchmarks():
    """Neither as an import nor as a folder; comments may say where a figure was measured."""
    for path in [*(ROOT / "nonsmooth").rglob("*.py"), *(ROOT / "models").rglob("*.py")]:
        for line in path.read_text().splitlines():
            code = line.partition("#")[0]
            assert not any(f"{quote}{folder}" in code for quote in "\"'" for folder in ("tests", "benchmarks")), path
            assert not code.lstrip().startswith(("import tests", "from tests", "import benchmarks", "from benchmarks"))
