"""Solutions survive the disk; what is no solution is refused."""

import dataclasses
import inspect
import sys

import numpy as np
import pytest

import nonsmooth as ns
from models import BouncingBall, SpragSlip


@pytest.fixture(scope="module")
def solution():
    rod = SpragSlip()
    return ns.simulate(rod, (0, 0.05), *rod.state(), integrator=ns.MoreauJean(dt=1e-3))


@pytest.mark.parametrize("name", ["run.npz", "run.h5"])
def test_a_solution_read_back_equals_the_one_written(solution, tmp_path, name):
    read = ns.Solution.load(solution.save(tmp_path / name))
    for array in ("t", "q", "u", "g_N", "P_N", "P_F", "mode", "slip", "event_rows"):
        assert (getattr(read, array) == getattr(solution, array)).all()
    assert read.ledger.keys() == solution.ledger.keys()
    assert (read.stats, read.status, read.about) == (solution.stats, solution.status, solution.about)
    assert read.summary() == solution.summary()
    assert not (tmp_path / f"{name}.part").exists()


def run_with_forces_and_events():
    """With everything that a solution may have; the second function never reaches zero."""
    ball = BouncingBall(e=0.8)
    reached = [lambda t, q, u: q[0] - 0.1, lambda t, q, u: 1.0]
    return ns.simulate(ball, (0, 1), *ball.state(height=0.3), integrator=ns.EventDriven(), events=reached)


# what a file cannot hold without unpickling functions, and what stands for it
NOT_STORED = {"system", "described", "find_ledger", "find_motion", "motion", "names", "named_model", "gamma_F"}


def public_values(solution):
    """Every attribute that is no method, with the arrays as dtype, shape and bytes."""
    names = {name for name, it in inspect.getmembers(type(solution)) if not callable(it)}
    names |= {field.name for field in dataclasses.fields(solution)}
    names = {name for name in names if not name.startswith("_")} - NOT_STORED
    assert {"t", "events", "paradoxes", "ledger", "la", "stats", "success", "u_events"} <= names
    return {name: plain(getattr(solution, name)) for name in names}


def plain(value):
    if isinstance(value, np.ndarray):
        return value.dtype.str, value.shape, value.tobytes()
    if isinstance(value, dict):
        return {name: plain(entry) for name, entry in value.items()}
    return [plain(entry) for entry in value] if isinstance(value, list) else value


@pytest.mark.parametrize("name", ["run.npz", "run.h5", "run.nc"])
def test_a_solution_read_back_has_everything_that_the_fresh_one_had(tmp_path, name):
    fresh = run_with_forces_and_events()
    assert fresh.la is not None and len(fresh.t_events[0]) > 3 and len(fresh.t_events[1]) == 0
    read = ns.Solution.load(fresh.save(tmp_path / name))
    assert public_values(read) == public_values(fresh)
    times = np.linspace(0.0, 1.0, 101)
    assert read(times).q.tobytes() == fresh(times).q.tobytes() and read(times).u.tobytes() == fresh(times).u.tobytes()
    assert read.described.coordinates == fresh.described.coordinates and read.system.parameters == BouncingBall(e=0.8)


def test_every_dataset_of_an_h5_file_has_a_checksum_that_other_programs_verify(tmp_path):
    h5py = pytest.importorskip("h5py")
    path = run_with_forces_and_events().save(tmp_path / "run.h5")
    with h5py.File(path) as file:
        datasets = []
        file.visititems(lambda name, it: datasets.append(it) if hasattr(it, "dtype") else None)
        assert len(datasets) > 15 and all(it.fletcher32 for it in datasets if it.size)
        place = file["q"].id.get_chunk_info(0).byte_offset
    content = bytearray(path.read_bytes())
    content[place] ^= 1
    path.write_bytes(content)
    with h5py.File(path) as file, pytest.raises(OSError, match="checksum|filter"):
        file["q"][()]


def test_a_dataset_of_many_chunks_is_read_to_the_last_row(tmp_path):
    """Rows of 24 bytes in chunks of 1 MiB: the last chunk is not full."""
    h5py = pytest.importorskip("h5py")
    from nonsmooth.results.hdf5 import CHUNK_BYTES, put_array, take

    array = np.random.default_rng(0).normal(size=(CHUNK_BYTES // 8, 3))
    with h5py.File(tmp_path / "a.h5", "w") as file:
        put_array(file, "a", array)
        assert file["a"].chunks[0] < len(array) < 4 * file["a"].chunks[0]
        assert (take(file["a"]) == array).all()


@pytest.mark.parametrize("name", ["run.npz", "run.h5"])
def test_a_solution_that_another_program_changed_is_refused(solution, tmp_path, name):
    path = solution.save(tmp_path / name)
    if name.endswith("npz"):
        with np.load(path) as file:
            arrays = dict(file)
        np.savez(path, **arrays)
    else:
        h5py = pytest.importorskip("h5py")
        with h5py.File(path, "a") as file:
            file["q"][0] = 7.0
    with pytest.raises(ns.InvalidInput, match=f"{name} is not a saved solution, or is damaged: it has no seal"):
        ns.Solution.load(path)


def test_without_h5py_an_h5_file_is_not_called_damaged(solution, tmp_path, monkeypatch):
    path = solution.save(tmp_path / "run.h5")
    monkeypatch.setitem(sys.modules, "h5py", None)
    with pytest.raises(ns.MissingExtra, match=r"nonsmooth\[io\]"):
        ns.Solution.load(path)


@pytest.mark.parametrize("content", [b"", b"not a solution", b"PK\x03\x04damaged"])
def test_foreign_and_damaged_files_are_refused_in_one_sentence(tmp_path, content):
    path = tmp_path / "run.npz"
    path.write_bytes(content)
    with pytest.raises(ns.InvalidInput, match=r"run\.npz is not a saved solution"):
        ns.Solution.load(path)


def test_arrays_of_another_program_are_refused(tmp_path):
    np.savez(tmp_path / "run.npz", q=np.zeros(3))
    with pytest.raises(ns.InvalidInput, match="is not a saved solution"):
        ns.Solution.load(tmp_path / "run.npz")


class Trap:
    """Unpickled, it would leave a mark."""

    def __init__(self, mark):
        self.mark = mark

    def __reduce__(self):
        return (open, (str(self.mark), "w"))


def test_a_file_with_a_pickled_object_is_refused_and_the_object_is_not_made(solution, tmp_path):
    mark = tmp_path / "mark"
    with np.load(solution.save(tmp_path / "run.npz")) as file:
        arrays = dict(file)
    arrays["t"] = np.array([Trap(mark)], dtype=object)
    np.savez(tmp_path / "trap.npz", **arrays)
    with pytest.raises(ns.InvalidInput, match="is not a saved solution"):
        ns.Solution.load(tmp_path / "trap.npz")
    assert not mark.exists()


@pytest.mark.parametrize("name", ["run.npz", "run.h5"])
def test_files_hold_numbers_and_one_text_and_nothing_else(solution, tmp_path, name):
    path = solution.save(tmp_path / name)
    if name.endswith("npz"):
        with np.load(path, allow_pickle=False) as file:
            kinds = {entry: file[entry].dtype.kind for entry in file.files}
    else:
        h5py = pytest.importorskip("h5py")
        kinds = {"about": "U"}
        with h5py.File(path) as file:
            file.visititems(lambda entry, it: kinds.update({entry: it.dtype.kind} if hasattr(it, "dtype") else {}))
    assert kinds.pop("about") == "U" and set(kinds.values()) <= {"f", "i"}


def test_a_save_that_fails_leaves_the_older_file_as_it_was(solution, tmp_path, monkeypatch):
    path = solution.save(tmp_path / "run.npz")
    before = path.read_bytes()

    def full(file, *_, **__):
        file.write(b"half")
        raise OSError("no space left on device")

    monkeypatch.setattr(np, "savez_compressed", full)
    with pytest.raises(OSError, match="no space"):
        solution.save(path)
    assert path.read_bytes() == before and [entry.name for entry in tmp_path.iterdir()] == ["run.npz"]


def test_an_unknown_ending_is_refused(solution, tmp_path):
    with pytest.raises(ns.InvalidInput, match=r"must end in one of \.npz, \.h5"):
        solution.save(tmp_path / "run.csv")


def test_figure_animation_and_notebook_text_are_made(solution, tmp_path):
    solution.plot(tmp_path / "run.png")
    assert (tmp_path / "run.png").read_bytes().startswith(b"\x89PNG")
    assert solution.animate(tmp_path / "run.gif").read_bytes().startswith(b"GIF8")
    assert "inconsistent" in solution._repr_html_()
