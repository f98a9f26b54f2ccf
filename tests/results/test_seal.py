"""The seal: no bit of a sealed file can change unnoticed, and no other reader is disturbed by it."""

import io
import zipfile

import numpy as np
import pytest

from nonsmooth.results.seal import seal, sealed_kind


def sealed(content, kind="solution"):
    file = io.BytesIO(content)
    seal(file, kind)
    return file.getvalue()


def archive():
    file = io.BytesIO()
    np.savez(file, a=np.arange(5.0), text=np.array("about"))
    return file.getvalue()


def kind_of(content):
    """The kind, "" without a seal, "changed" where the content is not what was sealed."""
    try:
        return sealed_kind(io.BytesIO(content))
    except ValueError:
        return "changed"


@pytest.mark.parametrize("content", [b"", b"x", b"content\nin lines\n", bytes(500), archive()])
def test_what_was_sealed_is_known_and_any_single_bit_that_flips_is_noticed(content):
    whole = sealed(content)
    assert kind_of(whole) == "solution" and kind_of(content) == ""
    for k in range(8 * len(whole)):
        flipped = bytearray(whole)
        flipped[k // 8] ^= 1 << k % 8
        assert kind_of(flipped) in ("", "changed"), k


def test_blocks_that_change_places_and_a_file_behind_itself_are_noticed():
    """Sums would not notice the first."""
    content = np.random.default_rng(0).bytes(4096)
    whole = sealed(content)
    assert kind_of(content[1024:2048] + content[:1024] + whole[2048:]) == "changed"
    assert kind_of(whole + whole) == "changed"
    assert kind_of(whole[:-1]) == kind_of(whole + b"\n") == ""


def test_a_seal_of_a_later_version_is_refused_with_both_numbers():
    later = sealed(b"content").replace(b" seal 1 ", b" seal 2 ")
    with pytest.raises(ValueError, match="its seal has version 2; this version reads 1"):
        sealed_kind(io.BytesIO(later))


def test_the_seal_of_an_archive_is_its_comment():
    file = io.BytesIO(sealed(archive()))
    with zipfile.ZipFile(file) as read:
        assert read.comment.startswith(b"\nnonsmooth solution seal 1 crc32 ") and read.testzip() is None
    file.seek(0)
    with np.load(file, allow_pickle=False) as read:
        assert (read["a"] == np.arange(5.0)).all()


def test_readers_of_hdf5_and_netcdf_look_for_nothing_behind_their_own_end(tmp_path):
    h5py, xarray = pytest.importorskip("h5py"), pytest.importorskip("xarray")
    chart = xarray.Dataset({"a": (("x",), np.arange(5.0))})
    with h5py.File(tmp_path / "a.h5", "w") as file:
        file["a"] = np.arange(5.0)
    chart.to_netcdf(tmp_path / "a.nc", engine="netcdf4")
    chart.to_netcdf(tmp_path / "b.nc", engine="scipy")
    for path in tmp_path.iterdir():
        with path.open("r+b") as file:
            seal(file, "map")
    with h5py.File(tmp_path / "a.h5") as file:
        assert (file["a"][()] == np.arange(5.0)).all()
    for name, engine in (("a.nc", "netcdf4"), ("b.nc", "netcdf4"), ("b.nc", "scipy")):
        with xarray.open_dataset(tmp_path / name, engine=engine) as read:
            assert (read["a"].values == np.arange(5.0)).all()
