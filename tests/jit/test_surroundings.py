"""What machine code depends on beside its source is told by a process without numba as by one that has it."""

import os
import subprocess
import sys
from pathlib import Path

import numba
import pytest
from numba.core import config

from nonsmooth.jit import cache
from nonsmooth.jit.surroundings import CHOSEN, has_svml, surroundings, version_of_numba

TELL = """
import sys
from nonsmooth.jit.surroundings import surroundings
alone = surroundings()
assert "numba" not in sys.modules
from nonsmooth.jit import internals
assert surroundings() == alone
print(*alone, sep="\\n")
"""
ROOT = Path(__file__).parents[2]


def told(folder, code=TELL, **options):
    environment = {**os.environ, "PYTHONPATH": str(ROOT), **options}
    command = [sys.executable, "-c", code]
    done = subprocess.run(command, env=environment, cwd=folder, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_processes_with_and_without_numba_have_one_key(tmp_path):
    assert told(tmp_path).strip().split("\n") == list(surroundings())


@pytest.mark.upkeep
@pytest.mark.parametrize(("option", "value"), [
    ("NUMBA_OPT", "1"), ("NUMBA_BOUNDSCHECK", "1"), ("NUMBA_ENABLE_AVX", "0"), ("NUMBA_CPU_NAME", "generic"),
    ("NUMBA_DISABLE_INTEL_SVML", "1"), ("NUMBA_SLP_VECTORIZE", "1"),
])  # fmt: skip
def test_an_option_of_the_environment_belongs_to_the_key(option, value, tmp_path):
    assert told(tmp_path, **{option: value}) != told(tmp_path)


def test_an_option_of_numbas_file_belongs_to_the_key(tmp_path):
    pytest.importorskip("yaml", reason="numba reads its file by PyYAML")
    before = told(tmp_path)
    (tmp_path / ".numba_config.yaml").write_text("boundscheck: 1\n")
    assert told(tmp_path) != before


@pytest.mark.parametrize("option", ["BOUNDSCHECK", "OPT"])
def test_an_option_that_is_set_within_the_process_belongs_to_the_key(option, monkeypatch):
    assert option in CHOSEN
    before = cache.key_of(b"")
    assert cache.key_of(b"") == before
    monkeypatch.setattr(config, option, 1)
    assert cache.key_of(b"") != before


def test_the_version_and_the_vector_functions_are_those_that_numba_finds():
    assert version_of_numba() == numba.__version__
    assert has_svml() or not config.USING_SVML


def test_the_reader_of_the_file_of_options_is_loaded_where_there_is_one(tmp_path):
    """As is whatever a version of numba may need to tell its options."""
    code = (
        "import sys; from nonsmooth.jit.surroundings import surroundings; surroundings(); print('yaml' in sys.modules)"
    )
    assert told(tmp_path, code) == "False\n"
    pytest.importorskip("yaml", reason="numba reads its file by PyYAML")
    (tmp_path / ".numba_config.yaml").write_text("boundscheck: 0\n")
    assert told(tmp_path, code) == "True\n"
