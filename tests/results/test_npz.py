"""Archives of arrays: read to NumPy's own numbers, and weighed before anything is allocated."""

import os
import zipfile

import numpy as np
import pytest

from nonsmooth.checks import memory
from nonsmooth.results.npz import read_npz

ARRAYS = {
    "number": np.array(0.1), "flag": np.array(True), "text": np.array("Painlevé"), "empty": np.empty((0, 3)),
    "vector": np.arange(7), "matrix": np.arange(12.0).reshape(3, 4), "columns": np.asfortranarray(np.eye(3, 5)),
    "texts": np.array(["a", "bcd"]), "small": np.arange(3, dtype=np.int8), "single": np.ones(3, np.float32),
}  # fmt: skip


@pytest.mark.parametrize("write", [np.savez, np.savez_compressed])
def test_arrays_are_those_that_numpy_reads_and_may_be_written_to(tmp_path, write):
    write(tmp_path / "a.npz", **ARRAYS)
    read = read_npz(tmp_path / "a.npz").arrays
    assert read.keys() == ARRAYS.keys()
    for name, array in ARRAYS.items():
        assert read[name].dtype == array.dtype and read[name].shape == array.shape
        assert (read[name] == array).all() and read[name].flags.writeable
    assert read["columns"].flags.f_contiguous


def header(descr="'<f8'", order="False", shape="(3,)"):
    text = f"{{'descr': {descr}, 'fortran_order': {order}, 'shape': {shape}, }}".encode().ljust(117) + b"\n"
    return np.lib.format.magic(1, 0) + len(text).to_bytes(2, "little") + text


def packed(tmp_path, members, compression=zipfile.ZIP_DEFLATED):
    path = tmp_path / "a.npz"
    with zipfile.ZipFile(path, "w", compression) as archive:
        for name, content in members:
            archive.writestr(name, content)
    return path


@pytest.mark.parametrize(("content", "words"), [
    (header() + bytes(16), "claims 24 bytes in its header; it has 16"),
    (header() + bytes(32), "claims 24 bytes in its header; it has 32"),
    (header(shape="(1000000000000,)") + bytes(24), "claims 8000000000000 bytes"),
    (header(shape="(-3,)") + bytes(24), "claims -24 bytes"),
    (header(shape="(1+2,)") + bytes(24), "is no plain array"),
    (header(shape="(__import__('os').getpid(),)") + bytes(24), "is no plain array"),
    (header(descr="'|O'") + bytes(24), "it holds pickled objects"),
    (header(order="'False'") + bytes(24), "is no plain array"),
    (b"\x93NUMPY\x03\x00" + header()[8:] + bytes(24), "is no plain array"),
    (b"\x93NUMPX" + header()[6:] + bytes(24), "is no plain array"),
    (b"", "is no plain array"),
])  # fmt: skip
def test_a_header_that_is_no_plain_array_or_lies_is_refused(tmp_path, content, words):
    with pytest.raises(ValueError, match=words):
        read_npz(packed(tmp_path, [("x.npy", content)]))


@pytest.mark.filterwarnings("ignore:Duplicate name")
@pytest.mark.parametrize(("names", "words"), [
    (["x.npy", "notes.txt"], "holds 'notes.txt', which is no array"), (["x.npy", "x.npy"], "two arrays of one name"),
])  # fmt: skip
def test_what_is_no_archive_of_arrays_is_refused(tmp_path, names, words):
    path = packed(tmp_path, [(name, header() + bytes(24)) for name in names])
    with pytest.raises(ValueError, match=words):
        read_npz(path)


def test_a_number_that_changed_is_noticed_by_the_checksum_of_its_member(tmp_path):
    np.savez(tmp_path / "a.npz", x=np.full(1000, np.pi))
    content = bytearray((tmp_path / "a.npz").read_bytes())
    content[content.index(np.float64(np.pi).tobytes()) + 3] ^= 1
    (tmp_path / "a.npz").write_bytes(content)
    with pytest.raises(zipfile.BadZipFile, match="CRC"):
        read_npz(tmp_path / "a.npz")


def test_headers_are_shown_before_anything_is_allocated(tmp_path, monkeypatch):
    np.savez(tmp_path / "a.npz", x=np.ones(4))

    def refuse(forms):
        assert forms["x"] == ("<f8", (4,)) and forms["x"].size == 32
        raise ValueError("not these")

    monkeypatch.setattr(np, "load", pytest.fail)
    with pytest.raises(ValueError, match="not these"):
        read_npz(tmp_path / "a.npz", refuse)


def test_zeros_that_inflate_are_refused_beyond_a_hundred_times_the_file_and_never_made(tmp_path, monkeypatch):
    """80 MB of zeros take 80 kB; not compressed they are read."""
    content = header(shape="(10000000,)") + bytes(80_000_000)
    path = packed(tmp_path, [("x.npy", content)])
    assert path.stat().st_size < 100_000
    with monkeypatch.context() as patch, pytest.raises(ValueError, match="claim 0.0745 GiB .* more than 100 times"):
        patch.setattr(np, "load", pytest.fail)
        read_npz(path)
    assert len(read_npz(packed(tmp_path, [("x.npy", content)], zipfile.ZIP_STORED)).arrays["x"]) == 10_000_000


def test_an_archive_larger_than_the_memory_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(memory, "free_memory", lambda: 1e6)
    monkeypatch.setattr(memory, "UNASKED_BYTES", 1000)
    np.savez(tmp_path / "a.npz", x=np.zeros(200_000))
    with pytest.raises(ValueError, match="its arrays need 0.00149 GiB and 0.000931 GiB are free"):
        read_npz(tmp_path / "a.npz")


def test_a_pipe_is_not_waited_for(tmp_path):
    if not hasattr(os, "mkfifo"):
        pytest.skip("there are no pipes in this file system")
    os.mkfifo(tmp_path / "a.npz")
    with pytest.raises(ValueError, match="it is no ordinary file"):
        read_npz(tmp_path / "a.npz")


@pytest.mark.parametrize("claimed", [16, 32])
def test_a_directory_that_says_fewer_or_more_bytes_than_a_member_has_is_noticed(tmp_path, claimed):
    """The header agrees with the directory; of fewer the checksum of the member tells, of more its end."""
    start = header(shape=f"({claimed // 8},)")
    path = packed(tmp_path, [("x.npy", start + bytes(24))], zipfile.ZIP_STORED)
    content = bytearray(path.read_bytes())
    entry = content.index(b"PK\x01\x02")
    content[entry + 24 : entry + 28] = (len(start) + claimed).to_bytes(4, "little")
    path.write_bytes(content)
    with pytest.raises((ValueError, zipfile.BadZipFile), match="Bad CRC-32|expected 32 bytes got 24"):
        read_npz(path)
