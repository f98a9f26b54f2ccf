"""Files of machine code: what is damaged, foreign or not to be trusted is compiled again, never run."""

import hashlib
import os
import random
import resource
import shutil
import signal
import subprocess
import sys
import time
from contextlib import contextmanager

import pytest

import nonsmooth as ns
from nonsmooth.jit import code_files
from nonsmooth.jit.code_files import DAY, LONGEST_UNUSED, CodeFile, remove_old, usable

pytestmark = pytest.mark.upkeep

KEY, OTHER_KEY = "0123456789abcdef" * 4, "fedcba9876543210" * 4
CODE = bytes(range(256)) * 20


@pytest.fixture
def folder(tmp_path):
    place = tmp_path / "cache"
    assert usable(place)
    return place


@pytest.fixture(autouse=True)
def nothing_said_yet(monkeypatch):
    monkeypatch.setattr(code_files, "_noted", set())


def file_in(folder, name="force", key=KEY, description="numba 1"):
    return CodeFile(folder, name, key, description)


def test_what_was_written_is_read_by_the_same_key_and_description(folder, capsys):
    file = file_in(folder)
    assert not file.exists and file.load(bytes) is None
    file.save(CODE)
    assert file.exists and file.load(bytes) == CODE
    assert file_in(folder, key=OTHER_KEY).load(bytes) is None
    assert [path.name for path in folder.iterdir()] == [f"force-{KEY[:32]}.code"]
    assert capsys.readouterr().err == ""


def cut(content, rng):
    return content[: rng.randrange(len(content))]


def zeroed(content, rng):
    start = rng.randrange(len(content) - 1)
    return content[:start] + bytes(len(content[start : start + rng.randrange(1, 600)])) + content[start + 600 :]


def flipped(content, rng):
    changed = bytearray(content)
    for _ in range(rng.randrange(1, 4)):
        changed[rng.randrange(len(changed))] ^= 1 << rng.randrange(8)
    return bytes(changed)


def text(content, rng):
    return "".join(rng.choices("abc \n", k=rng.randrange(5000))).encode()


def doubled(content, rng):
    return content + content[rng.randrange(len(content)) :]


def moved(content, rng):
    place = rng.randrange(1, len(content))
    return content[place:] + content[:place]


DAMAGES = [cut, zeroed, flipped, text, doubled, moved]


@pytest.mark.parametrize("damage", DAMAGES)
def test_damaged_files_are_never_unpickled_and_are_written_anew(damage, folder, capsys):
    """Fifty of each kind; a zeroed block that was zero already, or two bits that cancel, are no damage."""
    rng = random.Random(damage.__name__)
    file = file_in(folder)
    file.save(CODE)
    whole = file.path.read_bytes()
    for _ in range(50):
        content = damage(whole, rng)
        if content == whole:
            continue
        file.path.write_bytes(content)
        assert file.load(never) is None
        file.save(CODE)
        assert file.load(bytes) == CODE
    assert capsys.readouterr().err.count("\n") == 1


def never(code):
    pytest.fail("this code must not be looked at")


def in_place_of(path, what):
    path.unlink()
    if what == "a folder":
        path.mkdir()
    elif what == "a folder with files":
        path.mkdir()
        (path / "file").write_text("text")
    elif what == "a link to nowhere":
        path.symlink_to(path.with_name("nowhere"))
    elif what == "a link to itself":
        path.symlink_to(path)
    elif what == "a pipe":
        os.mkfifo(path)
    else:
        file_in(path.parent, key=OTHER_KEY).save(CODE)
        path.symlink_to(file_in(path.parent, key=OTHER_KEY).path)


PLACES = [
    "a folder",
    "a folder with files",
    "a link to nowhere",
    "a link to itself",
    "a pipe",
    "a link to another file",
]


@pytest.mark.parametrize("what", PLACES)
def test_what_stands_in_place_of_a_file_gives_way_to_it(what, folder, capsys):
    file = file_in(folder)
    file.save(CODE)
    in_place_of(file.path, what)
    assert file.load(never) is None
    file.save(CODE)
    assert file.load(bytes) == CODE and file.path.is_file() and not file.path.is_symlink()
    assert "it is compiled again" in capsys.readouterr().err


@pytest.mark.parametrize("change", [{"name": "other"}, {"key": OTHER_KEY}, {"description": "numba 2"}])
def test_the_file_of_another_function_or_version_is_not_taken(change, folder, capsys):
    file, other = file_in(folder), file_in(folder, **change)
    other.save(CODE)
    shutil.move(other.path, file.path)
    assert file.load(never) is None
    assert "of another function, or of another version" in capsys.readouterr().err


def test_two_files_that_are_swapped_are_not_taken(folder):
    file, other = file_in(folder), file_in(folder, key=OTHER_KEY)
    file.save(CODE)
    other.save(CODE[::-1])
    first, second = file.path.read_bytes(), other.path.read_bytes()
    file.path.write_bytes(second)
    other.path.write_bytes(first)
    assert file.load(never) is None and other.load(never) is None


def test_code_that_cannot_be_rebuilt_is_compiled_anew(folder, capsys):
    file = file_in(folder)
    file.save(CODE)

    def rebuild(code):
        raise AttributeError("no such class")

    assert file.load(rebuild) is None
    assert "does not fit (AttributeError); it is compiled again" in capsys.readouterr().err


@pytest.mark.parametrize("mode", [0o666, 0o620, 0o602])
def test_a_file_that_others_may_write_is_passed_over(mode, folder, capsys):
    file = file_in(folder)
    file.save(CODE)
    file.path.chmod(mode)
    assert file.load(never) is None
    assert "others may write it" in capsys.readouterr().err


@pytest.mark.parametrize("mode", [0o777, 0o770, 0o703, 0o1777])
def test_a_folder_in_which_others_may_write_is_passed_over(mode, folder, capsys):
    folder.chmod(mode)
    assert not usable(folder) and not usable(folder)
    said = capsys.readouterr().err
    assert said.count("\n") == 1 and "is passed over, as others may write there: chmod go-w" in said


def test_a_folder_of_another_user_is_passed_over(folder, monkeypatch, capsys):
    monkeypatch.setattr(os, "getuid", lambda: 12345)
    facts = os.stat_result((0o100600, 0, 0, 1, 4321, 0, 0, 0, 0, 0))
    assert code_files.others_may_write(facts)
    for own in (12345, 0):
        assert not code_files.others_may_write(os.stat_result((0o100600, 0, 0, 1, own, 0, 0, 0, 0, 0)))


def test_a_folder_that_cannot_be_made_is_passed_over_with_a_note(tmp_path, capsys):
    (tmp_path / "file").write_text("text")
    for place in (tmp_path / "file", tmp_path / "file" / "cache"):
        assert not usable(place)
    assert capsys.readouterr().err.count("\n") == 1
    nowhere = CodeFile(None, "force", KEY, "")
    nowhere.save(CODE)
    assert nowhere.load(never) is None and not nowhere.exists


def test_a_new_folder_is_the_users_own(tmp_path):
    before = os.umask(0)
    try:
        assert usable(tmp_path / "a" / "cache")
    finally:
        os.umask(before)
    assert (tmp_path / "a" / "cache").stat().st_mode & 0o777 == 0o700


@contextmanager
def full_disk():
    """No file grows beyond 1 kB."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (1000, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


def test_a_full_disk_leaves_what_was_there_and_is_said_once(folder, capsys):
    file = file_in(folder)
    file.save(CODE)
    with full_disk():
        for code in (CODE * 2, CODE * 3):
            file.save(code)
    assert file.load(bytes) == CODE and len(list(folder.iterdir())) == 1
    said = capsys.readouterr().err
    assert said.count("\n") == 1 and "keeps no compiled code: File too large" in said


@pytest.mark.parametrize("error", [OSError(28, "No space left on device"), OSError(30, "Read-only file system")])
def test_a_write_that_fails_is_said_once_and_leaves_nothing(error, folder, monkeypatch, capsys):
    def refuse(*_):
        raise error

    monkeypatch.setattr(os, "replace", refuse)
    file = file_in(folder)
    file.save(CODE)
    file.save(CODE)
    assert list(folder.iterdir()) == [] and file.load(never) is None
    assert capsys.readouterr().err == f"nonsmooth: {folder} keeps no compiled code: {error.strerror}\n"


SCENE = """
def mass(t, q, p, M):
    M[0, 0] = 1.0
def force(t, q, u, p, h):
    h[0] = -4.0 * q[0]
"""


def speed():
    """Of a model that no one knows yet, after one second from q = 0.75."""
    scene = {"__name__": "scene"}
    exec(SCENE, scene)
    system = ns.System(n_q=1, mass=scene["mass"], force=scene["force"])
    return ns.simulate(system, (0, 1), [0.75], [0.0], integrator=ns.MoreauJean(dt=1.0)).u[-1, 0]


@pytest.mark.parametrize("damage", DAMAGES)
def test_a_run_whose_machine_code_is_damaged_gives_the_right_answer(damage, tmp_path, monkeypatch, capsys):
    right = speed()
    monkeypatch.setenv("NONSMOOTH_CACHE_DIR", str(tmp_path / "cache"))
    assert speed() == right
    (file,) = (tmp_path / "cache").iterdir()
    whole = file.read_bytes()
    capsys.readouterr()
    file.write_bytes(damage(whole, random.Random(damage.__name__)))
    assert speed() == right
    head, content = len(code_files.MAGIC), file.read_bytes()  # not the same bytes: numba's text counts its variables
    assert content[head : head + 32] == hashlib.sha256(content[head + 32 :]).digest()
    assert capsys.readouterr().err.endswith("it is compiled again\n")


# old files


def aged(path, seconds):
    then = time.time() - seconds
    os.utime(path, (then, then))


def test_files_that_were_unused_for_long_are_removed_and_others_stay(folder):
    ages = {"used": DAY, "old": LONGEST_UNUSED + DAY}
    for name, age in ages.items():
        file_in(folder, name).save(CODE)
        aged(file_in(folder, name).path, age)
    for name, age in (("left.part", 2 * DAY), ("growing.part", 60.0), ("notes.txt", 2 * LONGEST_UNUSED)):
        (folder / name).write_text("text")
        aged(folder / name, age)
    remove_old(folder)
    left = {path.name.partition("-")[0] for path in folder.iterdir()}
    assert left == {"used", "growing.part", "notes.txt"}


def test_the_cache_is_bounded_and_what_was_unused_longest_goes_first(folder, monkeypatch):
    for age, name in enumerate(["new", "second", "third", "oldest"]):
        file_in(folder, name).save(CODE)
        aged(file_in(folder, name).path, 100.0 * age)
    size = file_in(folder, "new").path.stat().st_size
    monkeypatch.setattr(code_files, "LARGEST_CACHE", 2.5 * (size + 10))
    remove_old(folder)
    assert {path.name.partition("-")[0] for path in folder.iterdir()} == {"new", "second"}


def test_what_is_read_is_known_to_be_in_use(folder):
    file = file_in(folder)
    file.save(CODE)
    aged(file.path, 2 * DAY)
    assert file.load(bytes) == CODE
    assert time.time() - file.path.stat().st_mtime < DAY


# processes

COMPILE = """
import os, sys, time
from nonsmooth.contact.blocks.interior import longest_step
if sys.argv[1] == "slowly":
    replace = os.replace
    def slow(*paths):
        print("writing", flush=True)
        time.sleep(60)
    os.replace = slow
elif sys.argv[1] == "full":
    import resource
    resource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000))
longest_step.load()
print(longest_step.is_loaded, sum(longest_step.dispatcher.stats.cache_hits.values()))
"""


def compiling(folder, how="", **options):
    environment = {**os.environ, "NONSMOOTH_CACHE_DIR": str(folder)}
    command = [sys.executable, "-c", COMPILE, how]
    return subprocess.Popen(command, env=environment, text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE)


def ended(process):
    said, complaints = process.communicate(timeout=120)
    assert process.returncode == 0, complaints
    return said.strip(), complaints


def test_a_process_killed_while_it_writes_leaves_nothing_that_is_read(folder):
    process = compiling(folder, "slowly")
    assert process.stdout.readline() == "writing\n"
    process.send_signal(signal.SIGKILL)
    process.communicate()
    (left,) = folder.iterdir()
    assert left.name.endswith(".part")
    assert ended(compiling(folder)) == ("True 0", "")
    assert ended(compiling(folder)) == ("True 1", "")
    aged(left, 2 * DAY)
    remove_old(folder)
    assert not left.exists()


def test_processes_that_compile_the_same_at_once_leave_one_whole_file(folder):
    for said in [ended(process) for process in [compiling(folder) for _ in range(3)]]:
        assert said[0].startswith("True") and said[1] == ""
    assert len(list(folder.iterdir())) == 1
    assert ended(compiling(folder)) == ("True 1", "")


def test_a_process_on_a_full_disk_computes_and_says_so_once(folder):
    said, complaints = ended(compiling(folder, "full"))
    assert said == "True 0" and list(folder.iterdir()) == []
    assert complaints == f"nonsmooth: {folder} keeps no compiled code: File too large\n"
