"""Solutions survive the disk; what is no solution is refused."""

import numpy as np
import pytest

import nonsmooth as ns
from models import SpragSlip


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
