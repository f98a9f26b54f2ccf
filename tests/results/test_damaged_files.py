"""Thousands of damaged files: each is refused by an `InvalidInput`, or read to the very numbers that were written.

Files of every kind are damaged by a seeded mutator and read by a process of their own, which can crash, hang or ask
for gigabytes without taking the tests with it. The readers' process also writes the files, and remembers the bytes of
all that they hold.
"""

import io
import os
import random
import re
import shutil
import subprocess
import sys
import threading
import zipfile
from pathlib import Path

import numpy as np
import pytest

TIMEOUT = 60.0  # s: a reader that takes longer hangs; the slowest, a process for HDF5, takes 0.3
GIGABYTE = 2**30
DATA = Path(__file__).parents[1] / "data"


# The process of the readers: makes the files, and says of each damaged one what became of it -------------------------


def rod_run(**options):
    """A slide of the rod with impacts: records, events and ledger."""
    import nonsmooth as ns
    from models import PainleveRod

    rod = PainleveRod(mu=1.6)
    start = rod.state(th=0.8, thdot=-1.0, slip=1.0)
    return ns.simulate(rod, (0, 0.2), *start, integrator=ns.MoreauJean(1e-3), **options)


def solution(path):
    """With all that one may hold: forces, and events of the user."""
    import nonsmooth as ns
    from models import BouncingBall

    ball = BouncingBall(e=0.5)
    found = ns.simulate(
        ball, (0, 1), *ball.state(height=0.3), integrator=ns.EventDriven(), events=[lambda t, q, u: q[0] - 0.1]
    )
    found.save(path)


def product(x, y):
    """A task with a number, a vector and a text in each cell."""
    return {"product": x * y, "pair": [x, -y], "word": "even" if x % 2 == 0 else "odd"}


AXES = {"x": np.arange(1.0, 9.0), "y": np.linspace(0.1, 0.7, 5)}


def swept(**options):
    import nonsmooth as ns

    return ns.sweep(product, AXES, progress=False, **options)


def step_problem(path):
    import nonsmooth as ns
    from models import SelfLockingRod

    rod = SelfLockingRod(mu=1.0, th0=0.9)
    try:
        ns.simulate(rod, (0, 0.1), *rod.state(th=0.9), integrator=ns.MoreauJean(dt=1e-3))
    except ns.StepFailure as failure:
        failure.dump(path)


def fclib(path):
    import nonsmooth as ns

    G = np.diag(np.arange(1.0, 13.0)) + 0.01
    ns.write_fclib(path, ns.ContactProblem(G, np.linspace(-1, 1, 12), np.full(4, 0.3), 3, np.ones(12), about="made"))


def foreign_fclib(path):
    """As another program writes it: no seal, no checksum; compressed."""
    import h5py

    fclib(path)
    with h5py.File(path) as file:
        arrays = {}
        file.visititems(lambda name, it: arrays.update({name: it[()]}) if hasattr(it, "dtype") else None)
    with h5py.File(path, "w") as file:
        for name, array in arrays.items():
            options = {"compression": "gzip", "shuffle": True} if getattr(array, "size", 0) > 4 else {}
            file.create_dataset(name, data=array, **options)


def copied(name):
    return lambda path: shutil.copyfile(DATA / name, path)


def checkpoint(path):
    rod_run(checkpoint=path, max_steps=120, on_failure="return")


def all_of(value):
    """Everything in a value, as bytes and texts in a list."""
    if isinstance(value, np.ndarray):
        return [value.dtype.str, value.shape, value.tolist() if value.dtype == object else value.tobytes()]
    if hasattr(value, "tocsr"):
        return [value.shape, all_of(value.toarray())]
    if isinstance(value, dict):
        return [[str(name), all_of(entry)] for name, entry in sorted(value.items())]
    if isinstance(value, list | tuple):
        return [all_of(entry) for entry in value]
    return repr(value)


def all_of_solution(path):
    import nonsmooth as ns

    found = ns.Solution.load(path)
    hidden = ("find_ledger", "find_motion", "system")
    return all_of({name: value for name, value in vars(found).items() if name not in hidden} | {"ledger": found.ledger})


def all_of_sweep(found):
    return [
        [[name, variable.dims, all_of(variable.values), all_of(variable.attrs)]
         for name, variable in sorted(found.variables.items())],
        all_of({name: value for name, value in found.attrs.items() if name != "cells_from_journal"}),
    ]  # fmt: skip


def loaded_sweep(path):
    import nonsmooth as ns

    return all_of_sweep(ns.load_sweep(path))


def resumed_sweep(path):
    return all_of_sweep(swept(journal=path))


def resumed_run(path):
    """What the checkpoint shows, and what the run is that goes on from it."""
    shown = all_of_solution(path)
    whole = rod_run(resume=path)
    return [shown, [all_of(getattr(whole, name)) for name in ("t", "q", "u", "P_N", "P_F", "mode", "event_rows")]]


def loaded_problem(path):
    from nonsmooth.commands.solve_files import load_problem

    kind, matrix, arguments = load_problem(Path(path))
    return all_of([kind, matrix, [vars(entry) if kind == "step" else entry for entry in arguments]])


def loaded_fclib(path):
    import nonsmooth as ns

    return all_of(vars(ns.read_fclib(path)))


KINDS = {  # name of the file: (writer, reader)
    "run.h5": (solution, all_of_solution),
    "run.npz": (solution, all_of_solution),
    "sweep.npz": (lambda path: swept(out=path), loaded_sweep),
    "sweep.nc": (lambda path: swept(out=path), loaded_sweep),
    "journal.jsonl": (lambda path: swept(journal=path), resumed_sweep),
    "run.ckpt": (checkpoint, resumed_run),
    "step.npz": (step_problem, loaded_problem),
    "lcp.npz": (copied("lcp/lcp_mmc.npz"), loaded_problem),
    "mlcp.npz": (copied("mlcp/diodeBridge20_mlcp.npz"), loaded_problem),
    "friction.npz": (copied("fc3d/NESpheres_10_1.npz"), loaded_problem),
    "fclib.hdf5": (fclib, loaded_fclib),
    "foreign.hdf5": (foreign_fclib, loaded_fclib),
}
UNSEALED = {"foreign.hdf5"}  # without any checksum: another number in it is another problem


def virtual_peak():
    """The most address space that this process has had [bytes]."""
    found = re.search(r"VmPeak:\s+(\d+) kB", Path("/proc/self/status").read_text())
    return 1024 * int(found[1])


def outcome(name, path, truth):
    import nonsmooth as ns

    try:
        found = KINDS[name][1](path)
    except ns.InvalidInput as refusal:
        said = str(refusal)
        return "refused" if said.count("\n") == 0 and name.partition(".")[0] in said else f"unclear: {said!r}"
    except Exception as error:
        return f"foreign exception: {type(error).__name__}: {error}"
    return "read" if found == truth or name in UNSEALED else "wrong"


def readers(folder):
    """Write the files, then read the damaged one of each line of the standard input."""
    os.chdir(folder)
    truth = {}
    for name, (write, read) in KINDS.items():
        original = Path(name)
        remove(original)
        remove(Path(f"original-{name}"))
        write(name)
        (shutil.copytree if original.is_dir() else shutil.copyfile)(original, f"original-{name}")
        truth[name] = read(name)
        if original.is_dir():
            shutil.rmtree(original)
    virtual = virtual_peak()
    print("ready", flush=True)
    for line in sys.stdin:
        name = line.strip()
        became = outcome(name, name, truth[name])
        grown, virtual = virtual_peak() - virtual, max(virtual, virtual_peak())
        print(f"gigabytes: {grown / GIGABYTE:.3g}" if grown > GIGABYTE else became, flush=True)


# The mutator ----------------------------------------------------------------------------------------------------


def place(rng, data):
    """Somewhere in a file: its ends, where the headers stand, more often than their share of bytes."""
    if rng.random() < 0.5:
        return rng.randrange(len(data))
    near = rng.randrange(min(len(data), 600))
    return near if rng.random() < 0.5 else len(data) - 1 - near


def block(rng, data):
    start = place(rng, data)
    return slice(start, min(len(data), start + rng.choice((1, 8, 64, 512, 4096))))


def flipped_bit(rng, data):
    k = place(rng, data)
    data[k] ^= 1 << rng.randrange(8)
    return data


def other_byte(rng, data):
    data[place(rng, data)] = rng.randrange(256)
    return data


def cut_short(rng, data):
    return data[: place(rng, data)]


def without_a_block(rng, data):
    del data[block(rng, data)]
    return data


def zeroed_block(rng, data):
    where = block(rng, data)
    data[where] = bytes(where.stop - where.start)
    return data


def noisy_block(rng, data):
    where = block(rng, data)
    data[where] = rng.randbytes(where.stop - where.start)
    return data


def doubled_block(rng, data):
    where = block(rng, data)
    data[where] = data[where] * 2
    return data


def swapped_blocks(rng, data):
    size = rng.choice((1, 8, 64, 512))
    a, b = sorted(rng.randrange(max(1, len(data) - size)) for _ in range(2))
    if b - a >= size:
        data[a : a + size], data[b : b + size] = data[b : b + size], data[a : a + size]
    return data


def longer(rng, data):
    return data + rng.randbytes(rng.choice((1, 100, 5000)))


def behind_something(rng, data):
    return rng.randbytes(rng.choice((1, 512))) + data


def another_file(rng, data):
    signatures = (b"", b"\x89HDF\r\n\x1a\n", b"PK\x03\x04", b"CDF\x02", b"\x93NUMPY", b'{"journal": "nonsmooth sweep"')
    contents = (b"", b"t,q\n0,1\n", b"[" * 100_000, b"\0" * 5000, b"\xff" * 300, rng.randbytes(2000))
    return bytearray(rng.choice(signatures) + rng.choice(contents))


BYTES = (
    flipped_bit, flipped_bit, other_byte, cut_short, without_a_block, zeroed_block, noisy_block, doubled_block,
    swapped_blocks, longer, behind_something, another_file,
)  # fmt: skip


def lines_of(data):
    return bytes(data).splitlines(keepends=True)


def doubled_line(rng, data):
    lines = lines_of(data)
    lines.insert(rng.randrange(len(lines) + 1), rng.choice(lines))
    return bytearray(b"".join(lines))


def edited_number(rng, data):
    digits = [found.start() for found in re.finditer(rb"\d", data)]
    k = rng.choice(digits)
    data[k] = ord(str((data[k] - ord("0") + rng.randint(1, 9)) % 10))
    return data


def other_order(rng, data):
    head, *lines = lines_of(data)
    rng.shuffle(lines)
    return bytearray(b"".join([head, *lines]))


def lost_line(rng, data):
    lines = lines_of(data)
    del lines[rng.randrange(len(lines))]
    return bytearray(b"".join(lines))


JOURNAL = (doubled_line, edited_number, edited_number, other_order, lost_line)


def repacked(data, change, compression=zipfile.ZIP_DEFLATED):
    """An archive whose members were changed: what its own checksums then hold."""
    out = io.BytesIO()
    with zipfile.ZipFile(io.BytesIO(data)) as old, zipfile.ZipFile(out, "w", compression) as new:
        members = {info.filename: old.read(info) for info in old.infolist()}
        for name, content in change(members).items():
            new.writestr(name, content)
    return bytearray(out.getvalue())


def other_header(rng, data):
    """A header that claims another dtype, order or shape for the same bytes."""
    edits = (
        (rb"<f8", rng.choice((b">f8", b"<i8", b"<f4", b"<c16", b"|O", b"<U2"))),
        (rb"<i8", rng.choice((b"<f8", b"<u8"))),
        (rb"<i4", rng.choice((b"<f4", b"<u4"))), (rb"False", b"True "),
        (rb"\((\d+)", rng.choice((rb"(\g<1>0", rb"(1\g<1>", b"(1000000000000", b"(-1", b"(2**40", b"(0"))),
        (rb"'shape'", b"'shade'"),
    )  # fmt: skip

    def change(members):
        name = rng.choice(sorted(members))
        pattern, words = rng.choice(edits)
        members[name] = re.sub(pattern, words, members[name][:128], count=1) + members[name][128:]
        return members

    return repacked(data, change)


def other_members(rng, data):
    """An array that is missing, renamed, twice there, or not an array."""

    def change(members):
        name = rng.choice(sorted(members))
        way = rng.randrange(3)
        content = members.pop(name) if way < 2 else members[name]
        return members | ({f"x{name}": content} if way == 1 else {"notes.txt": b"hello"} if way == 2 else {})

    return repacked(data, change)


def rewritten(rng, data):
    """An array as NumPy writes it, of another dtype or shape, or of objects that would run code."""
    with np.load(io.BytesIO(data), allow_pickle=False) as file:
        arrays = dict(file)
    name = rng.choice(sorted(name for name, array in arrays.items() if array.dtype.kind != "U"))
    array, way = arrays[name], rng.randrange(6)
    with np.errstate(all="ignore"):
        arrays[name] = (
            array.astype(np.float32), array.astype(complex), array.astype(str), array.reshape(-1)[:-1],
            np.array([Trap()], dtype=object), np.append(array.reshape(-1), array.reshape(-1)[:1]),
        )[way]  # fmt: skip
    out = io.BytesIO()
    np.savez(out, **arrays)
    return bytearray(out.getvalue())


class Trap:
    """Unpickled, it would leave a mark."""

    def __reduce__(self):
        return (open, ("it-was-run", "w"))


def bomb(rng, data):
    """Zeros that inflate to a thousand times their size."""
    zeros = np.lib.format.magic(1, 0) + (118).to_bytes(2, "little")
    zeros += (
        b"{'descr': '<f8', 'fortran_order': False, 'shape': (3000, 3000), }".ljust(117) + b"\n" + bytes(8 * 3000**2)
    )
    return repacked(data, lambda members: members | {rng.choice(sorted(members)): zeros})


def huge_claim(rng, data):
    """A header of an array, and the size of its member, of 7 TiB."""
    size = 7 * 2**40
    zipped = bytearray(repacked(data, lambda members: members, zipfile.ZIP_STORED))
    start = zipped.index(b"PK\x01\x02")  # the first member's entry in the directory
    zipped[start + 20 : start + 28] = (2**32 - 2).to_bytes(4, "little") * 2
    return re.sub(rb"\((\d+),", b"(%d," % (size // 8), zipped, count=1)


ARCHIVE = (other_header, other_header, other_header, other_members, rewritten, rewritten, huge_claim, bomb)


def in_hdf5(change):
    def mutate(rng, data):
        import h5py

        memory = io.BytesIO(bytes(data))
        with h5py.File(memory, "a") as file:
            names = []
            file.visititems(lambda name, it: names.append(name) if hasattr(it, "dtype") and it.size else None)
            change(rng, file, rng.choice(names))
        return bytearray(memory.getvalue())

    mutate.__name__ = change.__name__
    return mutate


@in_hdf5
def claimed_dataset(rng, file, name):
    dtype = file[name].dtype
    del file[name]
    file.create_dataset(name, (2 ** rng.randrange(20, 45),), dtype, **rng.choice(({}, {"chunks": (2**16,)})))


@in_hdf5
def inflated_dataset(rng, file, name):
    dtype = file[name].dtype
    del file[name]
    file.create_dataset(name, data=np.zeros(2**24, dtype), chunks=(2**20,), compression="gzip")


@in_hdf5
def other_dtype(rng, file, name):
    import h5py

    array = np.atleast_1d(file[name][()])
    del file[name]
    if array.dtype.kind in "OS" or rng.random() < 0.3:
        file.create_dataset(name, data=["text"] * 3, dtype=h5py.string_dtype())
    else:
        file[name] = array.astype(rng.choice(("f4", "i2", "c16", ">f8", "u8", "f2")))


@in_hdf5
def other_length(rng, file, name):
    array = np.atleast_1d(file[name][()])
    del file[name]
    file[name] = array[:-1] if rng.random() < 0.5 else np.append(array, array)


@in_hdf5
def link_to_elsewhere(rng, file, name):
    import h5py

    del file[name]
    way = rng.randrange(3)
    if way == 2:
        layout = h5py.VirtualLayout((4,), "f8")
        layout[:] = h5py.VirtualSource("original-fclib.hdf5", "fclib_local/vectors/q", (4,))
        file.create_virtual_dataset(name, layout)
    else:
        file[name] = h5py.SoftLink("/") if way else h5py.ExternalLink("original-fclib.hdf5", f"/{name}")


@in_hdf5
def other_number(rng, file, name):
    """In an index or a size: what would lead compiled code astray."""
    name = rng.choice([f"fclib_local/W/{part}" for part in "mnpi"] + ["fclib_local/W/nz", "fclib_local/spacedim"])
    file[name][rng.randrange(len(file[name]))] = rng.choice((-1, 0, 7, 2**31 - 1, -(2**31)))


CONTAINER = (claimed_dataset, inflated_dataset, other_dtype, other_length, link_to_elsewhere, other_number)


def mutators_of(name):
    """Those that fit a kind of file."""
    if name.endswith(".npz"):
        return (*BYTES, *ARCHIVE)
    return BYTES + {"journal.jsonl": JOURNAL, "foreign.hdf5": 2 * CONTAINER}.get(name, ())


def damage(rng, folder, name):
    """Put a damaged file in its place; says what was done to it."""
    original, there = folder / f"original-{name}", folder / name
    remove(there)
    if rng.random() < 0.01:
        there.mkdir() if not original.is_dir() else there.write_text("a text")
        return "a folder in place of a file"
    if original.is_dir():
        shutil.copytree(original, there)
        part = rng.choice(sorted(there.iterdir()))
        return f"{part.name}: {damage_content(rng, part, part, BYTES)}"
    return damage_content(rng, original, there, mutators_of(name))


def damage_content(rng, original, there, mutators):
    data = original.read_bytes()
    mutate = rng.choice(mutators)
    changed = bytes(mutate(rng, bytearray(data)))
    there.write_bytes(changed)
    return mutate.__name__ if changed != data else f"{mutate.__name__}, without effect"


def remove(path):
    if path.is_dir():
        shutil.rmtree(path)
    else:
        path.unlink(missing_ok=True)


class Readers:
    """The process of the readers, started again when it has died."""

    def __init__(self, folder):
        self.folder = folder
        self.start()

    def start(self):
        places = os.pathsep.join(filter(None, sys.path))
        self.process = subprocess.Popen(
            [sys.executable, __file__, str(self.folder)], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
            stderr=subprocess.DEVNULL, env={**os.environ, "PYTHONPATH": places}, cwd=self.folder,
        )  # fmt: skip
        while (line := self.process.stdout.readline()) != "ready\n":
            assert line, "the readers did not start"

    def read(self, name):
        alarm = threading.Timer(TIMEOUT, self.process.kill)
        alarm.start()
        self.process.stdin.write(f"{name}\n")
        self.process.stdin.flush()
        became = self.process.stdout.readline().strip()
        hung = not alarm.is_alive()
        alarm.cancel()
        if not became:
            code = self.process.wait()
            self.start()
            became = "hung" if hung else f"crashed: {code}"
        return became

    def close(self):
        self.process.stdin.close()
        self.process.stdout.close()
        self.process.wait()


def trial(folder, names, count, seed):
    """Damage and read so many files; what became of them, and which did not end well."""
    rng, tally, bad = random.Random(seed), {}, []
    readers_of_damage = Readers(folder)
    try:
        for k in range(count):
            name = names[k % len(names)]
            done = damage(rng, folder, name)
            became = readers_of_damage.read(name)
            tally[name, became] = tally.get((name, became), 0) + 1
            if became not in ("refused", "read"):
                bad.append(f"{k}: {name}, {done}: {became}")
    finally:
        readers_of_damage.close()
    return tally, bad


needs_linux = pytest.mark.skipif(not sys.platform.startswith("linux"), reason="reads /proc/self/status")


@pytest.mark.upkeep
@needs_linux
@pytest.mark.parametrize("seed", [0])
def test_no_damaged_file_is_read_to_other_numbers_crashes_hangs_or_takes_gigabytes(tmp_path, seed):
    names = [*KINDS, *(name for name in KINDS if name not in UNSEALED)]  # which take a process each: every second time
    tally, bad = trial(tmp_path, names, 207, seed)
    assert not bad, "\n".join(bad)
    for name in KINDS:
        assert tally[name, "refused"] >= 5
    assert not (tmp_path / "it-was-run").exists()


@needs_linux
@pytest.mark.slow
@pytest.mark.parametrize("name", KINDS)
def test_none_of_thousands_of_damaged_files_is(tmp_path, name):
    tally, bad = trial(tmp_path, [name], 300, 1 + list(KINDS).index(name))
    print(tally)
    assert not bad, "\n".join(bad)


if __name__ == "__main__":
    readers(sys.argv[1])
