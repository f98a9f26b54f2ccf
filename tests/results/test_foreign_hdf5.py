"""HDF5 files of others: read in a process of their own, within bounds; what they claim is weighed first."""

import stat
import subprocess
import sys

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.results import foreign_hdf5
from nonsmooth.results.seal import sealed_kind

h5py = pytest.importorskip("h5py")
NAMES = ["a", "group/b", "text", "none/at/all"]


@pytest.fixture
def path(tmp_path):
    with h5py.File(tmp_path / "a.hdf5", "w") as file:
        file["a"], file["group/b"], file["text"] = np.arange(4.0), np.array([7]), "Painlevé"
    return tmp_path / "a.hdf5"


def read(path):
    return foreign_hdf5.read_foreign(path, NAMES)


def test_the_datasets_of_these_names_are_read_with_their_dtypes(path):
    found = read(path)
    assert found.keys() == {"/", "a", "group/b", "text"} and found["/"].tolist() == ["a", "group", "text"]
    assert found["a"].dtype == np.float64 and found["a"].tolist() == [0.0, 1.0, 2.0, 3.0]
    assert found["group/b"].dtype == np.int64 and str(found["text"]) == "Painlevé"


def other_reader(tmp_path, monkeypatch, script):
    """Another program in the place of the Python that reads."""
    program = tmp_path / "reader"
    program.write_text(f"#!/bin/sh\n{script}\n")
    program.chmod(program.stat().st_mode | stat.S_IXUSR)
    monkeypatch.setattr(sys, "executable", str(program))


@pytest.mark.skipif(sys.platform == "win32", reason="needs a shell")
def test_a_library_that_crashes_or_never_ends_is_a_sentence(path, tmp_path, monkeypatch):
    other_reader(tmp_path, monkeypatch, "kill -SEGV $$")
    with pytest.raises(ValueError, match=r"the HDF5 library ended its process on it \(exit code -11\)"):
        read(path)
    monkeypatch.setattr(foreign_hdf5, "READER_START_TIME", 0.2)
    other_reader(tmp_path, monkeypatch, "exec sleep 60")
    with pytest.raises(ValueError, match="was still at work on it after 0 s"):
        read(path)
    other_reader(tmp_path, monkeypatch, "echo half of an archive")
    with pytest.raises(ValueError, match="it is no archive of arrays"):
        read(path)


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="needs RLIMIT_AS")
def test_the_process_that_reads_has_a_bound_of_memory():
    script = "import numpy; from nonsmooth.results import foreign_hdf5 as h; h._bound_memory(2**28); numpy.ones(2**27)"
    ended = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
    assert ended.returncode == 1 and "MemoryError" in ended.stderr


def claims(file):
    file.create_dataset("a", (2**40,), "f8", chunks=(2**16,))


def was_never_written(file):
    file.create_dataset("a", (1000,), "f8")


def inflates(file):
    file.create_dataset("a", data=np.zeros(2**24), chunks=(2**20,), compression="gzip")


def is_a_soft_link(file):
    file["a"] = h5py.SoftLink("/group/b")


def is_an_external_link(file):
    file["a"] = h5py.ExternalLink("other.hdf5", "/a")


def is_virtual(file):
    layout = h5py.VirtualLayout((4,), "f8")
    layout[:] = h5py.VirtualSource("other.hdf5", "a", (4,))
    file.create_virtual_dataset("a", layout)


def is_external(file):
    file.create_dataset("a", (4,), "f8", external=[("other.bin", 0, 32)])


def is_a_group(file):
    file.create_group("a/b")


def is_objects(file):
    file.create_dataset("a", (2,), h5py.vlen_dtype(np.float64))
    file["a"][0] = [1.0]


def is_big_endian(file):
    file["a"] = np.arange(4.0).astype(">f8")


@pytest.mark.parametrize(("change", "words"), [
    (claims, "a claims 8796093022208 bytes, of which 0 are in the file"),
    (was_never_written, "a claims 8000 bytes, of which 0 are in the file"),
    (inflates, "its arrays claim 0.125 GiB in a file of .* more than 100 times"),
    (is_a_soft_link, "a is a link to elsewhere"), (is_an_external_link, "a is a link to elsewhere"),
    (is_virtual, "a stands in other files"), (is_external, "a stands in other files"),
    (is_a_group, "a is no array"), (is_objects, "a.npy' is no plain array|pickled|objects"),
    (is_big_endian, "big-endian numbers are not read"),
])  # fmt: skip
def test_what_is_no_array_in_the_file_itself_is_refused(path, change, words):
    with h5py.File(path, "a") as file:
        del file["a"]
        change(file)
    with pytest.raises(ValueError, match=words):
        read(path)


def test_bytes_behind_the_end_are_a_seal_that_is_damaged(path):
    """Ours carry their seal there; HDF5 itself leaves nothing behind the end that it states."""
    with path.open("ab") as file:
        file.write(b"\nnonsmooth fclib seal 1 crc32 0123abc?\n")
    with pytest.raises(ValueError, match="39 bytes stand behind its end"):
        read(path)


def test_a_contact_problem_of_ours_is_read_here_and_a_changed_one_as_a_file_of_others(tmp_path, monkeypatch):
    path = tmp_path / "problem.hdf5"
    ns.write_fclib(path, ns.ContactProblem(np.eye(2), np.array([-1.0, 0.5]), np.ones(1), 2))
    with path.open("rb") as file:
        assert sealed_kind(file) == "fclib"
    asked = []
    monkeypatch.setattr("nonsmooth.results.fclib.read_foreign", lambda *given: asked.append(given))
    assert ns.read_fclib(path).c.tolist() == [-1.0, 0.5] and not asked
    monkeypatch.undo()
    with h5py.File(path, "a") as file:
        file["fclib_local/vectors/q"][1] = 0.75
    assert ns.read_fclib(path).c.tolist() == [-1.0, 0.75]
    content = bytearray(path.read_bytes())
    content[content.index(np.float64(0.75).tobytes())] ^= 1
    path.write_bytes(content)
    with pytest.raises(ns.InvalidInput, match="problem.hdf5 is damaged: .*(checksum|filter)"):
        ns.read_fclib(path)


@pytest.mark.parametrize(("part", "value", "words"), [
    ("i", 2, "an index of a matrix must lie in 0 ... 1; one is 2"), ("i", -1, "one is -1"),
    ("p", 3, "the starts of 2 rows must be 3 numbers that grow from 0 to at most 2"),
    ("p", -1, "the starts of 2 rows"), ("m", 2**31 - 1, r"W must be a matrix of shape \(2, 2\); the file says"),
    ("n", 0, r"the file says \(2, 0\)"), ("nz", 7, "nz of an FCLIB matrix must be -2, -1 or a number of its triplets"),
])  # fmt: skip
def test_an_index_that_would_lead_out_of_the_matrix_is_refused(tmp_path, part, value, words):
    path = tmp_path / "problem.hdf5"
    ns.write_fclib(path, ns.ContactProblem(np.eye(2), np.array([-1.0, 0.5]), np.ones(1), 2))
    with h5py.File(path, "a") as file:
        file[f"fclib_local/W/{part}"][0] = value
    with pytest.raises(ns.InvalidInput, match=words):
        ns.read_fclib(path)


@pytest.mark.parametrize(("name", "dtype"), [("W/x", "f4"), ("W/i", "f8"), ("vectors/q", "c16"), ("vectors/mu", "i8")])
def test_numbers_of_another_dtype_are_not_cast(tmp_path, name, dtype):
    path = tmp_path / "problem.hdf5"
    ns.write_fclib(path, ns.ContactProblem(np.eye(2), np.array([-1.0, 0.5]), np.ones(1), 2))
    with h5py.File(path, "a") as file:
        array = file[f"fclib_local/{name}"][()]
        del file[f"fclib_local/{name}"]
        file[f"fclib_local/{name}"] = array.astype(dtype)
    with pytest.raises(ns.InvalidInput, match=f"fclib_local/{name}.*(must be|no plain array)"):
        ns.read_fclib(path)
