"""A checkpoint goes on with the run that it is of, and with no other."""

import json
import os

import numpy as np
import pytest

import nonsmooth as ns
from models import BouncingBall
from nonsmooth.commands.cli import main
from nonsmooth.results import checkpoint as store

BALL = BouncingBall(e=0.8).system()
RUN = dict(
    system=BALL, t_span=(0, 0.1), q0=[0.1], u0=[0.0], integrator=ns.MoreauJean(1e-3), every=2, selection="lift-off"
)


@pytest.fixture
def path(tmp_path):
    """A checkpoint of a run that was stopped."""
    ns.simulate(**RUN, checkpoint=tmp_path / "run.ckpt", max_wall_time=1e-9, on_failure="return")
    return tmp_path / "run.ckpt"


def changed_force():
    def force(t, q, u, p, h):
        h[0] = -2 * p.m * p.g

    same = {
        name: getattr(BALL, name) for name in ("mass", "gap", "normal", "potential", "contacts", "parameters", "name")
    }
    return ns.System(n_q=1, force=force, **same)


OTHERS = {
    "parameters": ({"system": BALL.with_parameters(g=1.62)}, "its parameter g is 9.81, here it is 1.62"),
    "restitution": ({"system": BALL.with_parameters(e=0.9)}, "its parameter e is 0.8, here it is 0.9"),
    "code": ({"system": changed_force()}, "its code of force differs"),
    "integrator": ({"integrator": ns.EventDriven()}, "its code of the integrator differs"),
    "step": ({"integrator": ns.MoreauJean(2e-3)}, r"its integrator is MoreauJean\(dt=0.001.*here it is .*dt=0.002"),
    "span": ({"t_span": (0, 0.2)}, r"its t_span is \[0.0, 0.1\], here it is \[0.0, 0.2\]"),
    "start": ({"q0": [0.2]}, r"its q0 is \[0.1\], here it is \[0.2\]"),
    "velocity": ({"u0": [0.2]}, r"its u0 is \[0.0\], here it is \[0.2\]"),
    "records": ({"every": 3}, "its every is 2, here it is 3"),
    "times": ({"every": 1, "t_eval": [0.05]}, "its every is 2, here it is 1"),
    "selection": ({"selection": "impact"}, "its selection is 1, here it is 2"),
    "projection": ({"project": True}, "its project is False, here it is True"),
}


@pytest.mark.parametrize("what", OTHERS)
def test_the_checkpoint_of_another_run_is_refused_and_left_as_it_is(path, what):
    change, message = OTHERS[what]
    before = {file.name: file.read_bytes() for file in path.iterdir()}
    with pytest.raises(ns.InvalidInput, match=f"is of another run: {message}"):
        ns.simulate(**RUN | change, resume=path)
    assert {file.name: file.read_bytes() for file in path.iterdir()} == before


def test_another_version_is_another_run(path, monkeypatch):
    monkeypatch.setattr("nonsmooth.runs.identity.__version__", "99.0")
    with pytest.raises(ns.InvalidInput, match=f"its version is {ns.__version__}, here it is 99.0"):
        ns.simulate(**RUN, resume=path)


def test_another_schema_is_refused_by_name(path):
    with np.load(path / store.STATE) as file:
        arrays = dict(file)
    about = json.loads(str(arrays.pop("about"))) | {"schema": 99}
    np.savez(path / store.STATE, about=np.array(json.dumps(about)), **arrays)
    for read in (lambda: ns.simulate(**RUN, resume=path), lambda: ns.Solution.load(path)):
        with pytest.raises(ns.InvalidInput, match="has schema 99; this version reads 1"):
            read()


def test_an_older_checkpoint_is_never_written_over(path):
    with pytest.raises(ns.InvalidInput, match="there is a checkpoint .* already; resume= goes on with it"):
        ns.simulate(**RUN, checkpoint=path)


def test_there_must_be_something_to_resume(tmp_path):
    with pytest.raises(ns.InvalidInput, match="there is no checkpoint .*; checkpoint= begins one"):
        ns.simulate(**RUN, resume=tmp_path / "none.ckpt")


def test_two_different_places_are_refused(path, tmp_path):
    with pytest.raises(ns.InvalidInput, match="checkpoint and resume must be the same path, or one of them"):
        ns.simulate(**RUN, resume=path, checkpoint=tmp_path / "other.ckpt")


@pytest.mark.parametrize("content", [b"", b"PK\x03\x04", b"something else"])
@pytest.mark.parametrize("name", [store.STATE, "records.npy", "events.npy"])
def test_a_damaged_checkpoint_is_refused_in_one_sentence(path, name, content):
    (path / name).write_bytes(content)
    for read in (lambda: ns.simulate(**RUN, resume=path), lambda: ns.Solution.load(path)):
        with pytest.raises(ns.InvalidInput, match="damaged"):
            read()


def test_records_that_were_lost_are_noticed(path):
    os.truncate(path / "records.npy", (path / "records.npy").stat().st_size - 8)
    with pytest.raises(ns.InvalidInput, match=r"is damaged: records\.npy"):
        ns.simulate(**RUN, resume=path)


def test_a_folder_of_other_things_is_no_checkpoint(tmp_path):
    (tmp_path / "thesis.tex").write_text("work of years")
    for option in ("checkpoint", "resume"):
        with pytest.raises(ns.InvalidInput, match="is no checkpoint, it holds 'thesis.tex'; choose another path"):
            ns.simulate(**RUN, **{option: tmp_path})
    with pytest.raises(ns.InvalidInput, match="is no checkpoint: it has no state.npz"):
        ns.Solution.load(tmp_path)
    with pytest.raises(ns.InvalidInput, match="is no checkpoint, which is a folder"):
        ns.simulate(**RUN, checkpoint=tmp_path / "thesis.tex")
    assert [file.name for file in tmp_path.iterdir()] == ["thesis.tex"]


def test_a_place_that_cannot_be_written_is_refused_before_the_first_step(tmp_path):
    with pytest.raises(ns.InvalidInput, match="cannot be written: .*; choose another path"):
        ns.simulate(**RUN, checkpoint=tmp_path / "no" / "such" / "folder")


@pytest.mark.parametrize("seconds", [-1.0, np.nan, "soon"])
def test_the_time_between_two_states_is_no_negative_number(tmp_path, seconds):
    with pytest.raises(ns.InvalidInput, match="checkpoint_every must"):
        ns.simulate(**RUN, checkpoint=tmp_path / "run.ckpt", checkpoint_every=seconds)
    assert not list(tmp_path.iterdir())


def test_events_of_the_user_are_refused(tmp_path):
    with pytest.raises(ns.InvalidInput, match="a run with a checkpoint looks for no events"):
        ns.simulate(**RUN, checkpoint=tmp_path / "a.ckpt", events=[lambda t, q, u: q[0]])
    assert not list(tmp_path.iterdir())


def test_the_command_line_begins_goes_on_and_refuses(tmp_path, capsys):
    words = ["run", "bouncing-ball", "--t-end", "0.5", "--dt", "1e-3", "--no-plot"]
    place = str(tmp_path / "run.ckpt")
    assert main([*words, "--checkpoint", place]) == 0
    assert f"checkpoint: {place}" in capsys.readouterr().out
    assert main([*words, "--checkpoint", place]) == 2
    assert "already; --resume goes on with it" in capsys.readouterr().err
    assert main([*words, "--resume", place, "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["stats"]["steps"] == 500
    assert main([*words, "--set", "e=0.3", "--resume", place]) == 2
    assert "is of another run: its parameter e is" in capsys.readouterr().err
