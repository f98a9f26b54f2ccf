"""Nothing heavy is imported before it is needed: each check runs in an interpreter of its own."""

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
