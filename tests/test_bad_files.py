"""Files: those of others and damaged ones are refused; a write that fails half way leaves what was there."""

import contextlib
import json
import resource
from pathlib import Path

import numpy as np
import pytest

import nonsmooth as ns
from models import BouncingBall, PainleveRod
from nonsmooth.commands.cli import main
from nonsmooth.commands.solve_files import solve_files
from nonsmooth.sweeps.maps import save_map

STEP = ns.MoreauJean(dt=1e-3)
BALL = BouncingBall(e=0.5)
PROBLEM = ns.ContactProblem(np.eye(400), np.linspace(-1.0, 1.0, 400), np.full(200, 0.3), 2)


def solution():
    return ns.simulate(BALL, (0, 1), [1.0], [0.3], integrator=STEP)


def swept():
    task = ns.RunTask(BALL, t_span=(0, 0.01), integrator=STEP)
    return ns.sweep(task, {"e": np.linspace(0.1, 0.9, 300)}, progress=False)


def chart():
    return ns.paradox_map(PainleveRod(), th=np.linspace(0.2, 1.2, 20), mu=np.linspace(0.5, 2.0, 20))


def failed_step():
    from models import SelfLockingRod

    rod = SelfLockingRod(mu=1.0, th0=0.9)
    with pytest.raises(ns.StepFailure) as failure:
        ns.simulate(rod, (0, 0.1), *rod.state(th=0.9), integrator=STEP)
    return failure.value


WRITERS = {
    "run.npz": lambda path: solution().save(path),
    "run.h5": lambda path: solution().save(path),
    "run.png": lambda path: solution().plot(path),
    "run.gif": lambda path: solution().animate(path),
    "run.html": lambda path: solution().view(path),
    "sweep.npz": lambda path: ns.save_sweep(swept(), path),
    "sweep.nc": lambda path: ns.save_sweep(swept(), path),
    "map.npz": lambda path: save_map(chart(), path),
    "map.nc": lambda path: save_map(chart(), path),
    "problem.hdf5": lambda path: ns.write_fclib(path, PROBLEM),
    "step.npz": lambda path: failed_step().dump(path),
}
READERS = {
    "run.npz": ns.Solution.load,
    "run.h5": ns.Solution.load,
    "sweep.npz": ns.load_sweep,
    "sweep.nc": ns.load_sweep,
    "problem.hdf5": ns.read_fclib,
}


@pytest.fixture(autouse=True)
def in_a_folder_of_its_own(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


@contextlib.contextmanager
def full_disk():
    """Files may not grow beyond 700 bytes, as on a disk that is nearly full: for the write, not for its report."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (700, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


@pytest.mark.upkeep
@pytest.mark.parametrize("name", WRITERS)
def test_a_write_that_fails_half_way_leaves_the_old_file_and_nothing_beside_it(name, tmp_path):
    path = tmp_path / name
    path.write_bytes(b"what was there")
    WRITERS[name](tmp_path / f"warm-{name}")  # what is compiled or imported once is not written under the limit
    (tmp_path / f"warm-{name}").unlink()
    words = f"{name}' could not be written: .*; what was there before is unchanged"
    with pytest.raises(ns.FileFailure, match=words), full_disk():
        WRITERS[name](path)
    assert path.read_bytes() == b"what was there"
    assert [file.name for file in tmp_path.iterdir()] == [name]


@pytest.mark.parametrize("name", [name for name in WRITERS if not name.endswith(("png", "gif", "html"))])
def test_every_file_of_numbers_is_sealed_as_what_it_is(name):
    from nonsmooth.results.hdf5 import seal_of

    WRITERS[name](name)
    what = {"run": "solution", "step": "problem", "problem": "fclib"}
    assert seal_of(Path(name)) == what.get(name.partition(".")[0], name.partition(".")[0])


@pytest.mark.parametrize("name", WRITERS)
@pytest.mark.parametrize("place", ["nowhere/{}", "{}/"])
def test_a_place_that_takes_no_file_is_refused_before_anything_is_written(name, place, tmp_path):
    if place == "{}/":
        (tmp_path / name).mkdir()
    with pytest.raises(ns.InvalidInput, match="cannot be written: (there is no folder|it is a folder).*choose another"):
        WRITERS[name](place.format(name))


def damaged(name):
    """The file cut short, overwritten in its middle, empty, of random bytes, and other people's."""
    WRITERS[name](name)
    whole = Path(name).read_bytes()
    noise = np.random.default_rng(0).bytes(500)
    yield whole[: len(whole) // 2]
    yield whole[:100]
    yield whole[:200] + noise[:40] + whole[240:] if name.endswith("npz") else noise
    yield b""
    yield noise
    yield b"PK\x03\x04" + noise
    yield b"\x89HDF\r\n\x1a\n" + noise
    yield json.dumps({"t": [0, 1]}).encode()


@pytest.mark.parametrize("name", READERS)
def test_damaged_files_are_refused_with_their_name(name, tmp_path):
    for content in damaged(name):
        (tmp_path / name).write_bytes(content)
        with pytest.raises(ns.InvalidInput, match=name.partition(".")[0]) as refusal:
            READERS[name](name)
        assert len(str(refusal.value).splitlines()) == 1


@pytest.mark.parametrize("name", ["run.npz", "sweep.npz"])
def test_foreign_archives_are_refused_and_nothing_in_them_is_run(name, tmp_path):
    class Bomb:
        def __reduce__(self):
            return (open, (str(tmp_path / "it-was-run"), "w"))

    np.savez(name, about=np.array([Bomb()], dtype=object), t=np.array([Bomb()], dtype=object))
    with pytest.raises(ns.InvalidInput):
        READERS[name](name)
    (row,) = solve_files([tmp_path / name], "auto", 1e-8)
    assert row["status"] == "ERROR"
    np.savez(name, x=np.arange(3))
    with pytest.raises(ns.InvalidInput):
        READERS[name](name)
    assert not (tmp_path / "it-was-run").exists()


def test_a_foreign_hdf5_file_is_refused():
    import h5py

    with h5py.File("run.h5", "w") as file:
        file["x"] = np.arange(3)
    with pytest.raises(ns.InvalidInput, match="run.h5 is not a saved solution"):
        ns.Solution.load("run.h5")
    with pytest.raises(ns.InvalidInput, match="run.h5 must hold /fclib_local or /fclib_global"):
        ns.read_fclib("run.h5")


def test_a_solution_of_a_later_schema_is_refused_with_both_numbers(tmp_path):
    solution().save("run.npz")
    with np.load("run.npz") as file:
        entries = dict(file)
    about = json.loads(str(entries["about"]))
    entries["about"] = np.array(json.dumps(about | {"schema": 99}))
    np.savez("run.npz", **entries)
    with pytest.raises(ns.InvalidInput, match="run.npz has schema 99; this version reads 1"):
        ns.Solution.load("run.npz")


def test_what_a_contact_problem_file_says_is_checked_as_if_it_was_typed():
    import h5py

    ns.write_fclib("problem.hdf5", PROBLEM)
    for name, value, words in (("mu", -0.3, "mu must not be negative"), ("q", np.nan, "c must be finite")):
        with h5py.File("problem.hdf5", "a") as file:
            old = file[f"fclib_local/vectors/{name}"][0]
            file[f"fclib_local/vectors/{name}"][0] = value
        with pytest.raises(ns.InvalidInput, match=words):
            ns.read_fclib("problem.hdf5")
        with h5py.File("problem.hdf5", "a") as file:
            file[f"fclib_local/vectors/{name}"][0] = old


@pytest.mark.parametrize("content", [b"", b"\0" * 50, b"{}\n", b'{"journal": "other"}\n', b"cell,value\n1,2\n"])
def test_a_file_that_is_no_journal_is_not_written_over(content, tmp_path):
    path = tmp_path / "sweep.jsonl"
    path.write_bytes(content)
    task = ns.RunTask(BALL, t_span=(0, 0.01), integrator=STEP)
    if not content:  # an empty file is a journal that has not begun
        ns.sweep(task, {"e": [0.1]}, journal=path, progress=False)
        return
    with pytest.raises(ns.InvalidInput, match="is no journal of a sweep; choose another path"):
        ns.sweep(task, {"e": [0.1]}, journal=path, progress=False)
    assert path.read_bytes() == content


def test_the_command_line_tells_a_failed_write_by_its_own_code(tmp_path, capsys):
    run = ["run", "bouncing-ball", "--no-plot", "--quiet", "--out", str(tmp_path / "run.npz")]
    assert main(run) == 0
    (tmp_path / "run.npz").unlink()
    capsys.readouterr()
    with full_disk():
        assert main(run) == 4
    said = capsys.readouterr().err
    assert said.startswith("nonsmooth: '") and "could not be written: File too large" in said and said.count("\n") == 1
    assert list(tmp_path.iterdir()) == []


def test_results_are_read_by_one_line_of_h5py_or_numpy():
    import h5py

    run = solution()
    run.save("run.h5")
    run.save("run.npz")
    assert (h5py.File("run.h5")["q"][:, 0] == run.q[:, 0]).all()  # the line of docs/promises.md
    assert (np.load("run.npz")["q"][:, 0] == run.q[:, 0]).all()
    assert json.loads(h5py.File("run.h5").attrs["about"])["schema"] == 1
