"""Nothing heavy is imported before it is needed: each check runs in an interpreter of its own."""

import os
import subprocess
import sys

import pytest

HEAVY = ("numpy", "numba", "scipy", "matplotlib", "qpsolvers", "osqp", "xarray", "h5py", "models")
PATIENCE = 120  # s: on a new machine a run compiles the loop first


def imported_by(code):
    check = f"import sys\n{code}\nprint('imported:', *[name for name in {HEAVY} if name in sys.modules])"
    ended = subprocess.run(
        [sys.executable, "-c", check], stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=PATIENCE
    )
    assert ended.returncode == 0, ended.stderr
    return set(ended.stdout.splitlines()[-1].split()[1:])


@pytest.mark.parametrize("arguments", [["--help"], ["run", "--help"], ["--version"]])
def test_help_imports_nothing_heavy(arguments):
    code = f"from nonsmooth.commands.cli import main\ntry: main({arguments})\nexcept SystemExit as stop: "
    code += "assert stop.code == 0"
    assert imported_by(code) == set()


def test_the_package_imports_nothing_heavy():
    assert imported_by("import nonsmooth; dir(nonsmooth)") == set()


def test_bad_input_is_refused_before_the_loop_is_loaded():
    assert "numba" not in imported_by(
        "from nonsmooth.commands.cli import main\nassert main(['run', 'no-such-model']) == 2"
    )


def test_a_run_draws_and_stores_only_with_what_it_needs():
    code = (
        "from nonsmooth.commands.cli import main\n"
        "assert main(['run', 'bouncing-ball', '--t-end', '0.01', '--no-plot', '--quiet']) == 0"
    )
    assert not imported_by(code) & {"matplotlib", "qpsolvers", "osqp", "xarray", "h5py"}


def test_every_public_name_is_found():
    code = "import nonsmooth as ns\nfor name in ns.__all__: getattr(ns, name)"
    assert not imported_by(code) & {"matplotlib", "xarray", "h5py"}


@pytest.mark.parametrize(("given", "expected"), [({}, 1), ({"OPENBLAS_NUM_THREADS": "2"}, 2)])
def test_a_command_runs_blas_on_one_thread_unless_it_is_told_otherwise(given, expected, tmp_path):
    threadpoolctl = pytest.importorskip("threadpoolctl")
    if not any(library["internal_api"] == "openblas" for library in threadpoolctl.threadpool_info()):
        pytest.skip("numpy has another BLAS here")
    if (os.cpu_count() or 1) < expected:
        pytest.skip("OpenBLAS takes no more threads than there are processors")
    code = """
import atexit, sys
def tell():
    from threadpoolctl import threadpool_info
    print(*(each["num_threads"] for each in threadpool_info() if each["internal_api"] == "openblas"), file=sys.stderr)
atexit.register(tell)
sys.argv = ["nonsmooth", "classify", "sprag-slip"]
from nonsmooth.__main__ import nonsmooth
nonsmooth()
"""
    environment = {name: value for name, value in os.environ.items() if name != "OPENBLAS_NUM_THREADS"} | given
    ended = subprocess.run([sys.executable, "-c", code], env=environment, cwd=tmp_path, capture_output=True, text=True,
                           timeout=120)  # fmt: skip
    assert ended.returncode == 0 and set(map(int, ended.stderr.split("\n")[-2].split())) == {expected}, ended
