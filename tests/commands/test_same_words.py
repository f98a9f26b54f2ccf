"""Options are the same words in every command that has a use for them, mean the same, and are told alike."""

import argparse
import json

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.commands.cli import build_parser, main

PRINTED, DRAWN = {"--json", "--quiet"}, {"--plot", "--no-plot"}
EVERYWHERE = PRINTED | DRAWN | {"--out"}
MANY = {"--progress", "--workers", "--resume"}  # of what makes many runs
WORDS = {
    "run": EVERYWHERE | {"--progress", "--resume", "--record"},  # one run in one process
    "scene": EVERYWHERE | {"--progress", "--resume", "--record"},
    "classify": EVERYWHERE,  # one state, in milliseconds
    "map": EVERYWHERE | MANY | {"--axis"},
    "sweep": EVERYWHERE | MANY | {"--axis"},
    "study penalty": EVERYWHERE | MANY,
    "study convergence": EVERYWHERE | MANY,
    "study stability": EVERYWHERE | {"--progress", "--axis"},  # one path, in this process
    "study cycle": EVERYWHERE | {"--progress", "--axis"},
    "study bifurcation": EVERYWHERE | {"--progress", "--workers", "--axis"},
}
SHARED = {word for words in WORDS.values() for word in words}
WITHOUT = {"list", "solve", "show", "new", "completion"}  # that run no model; the first three have PRINTED
FOLDER = {"run", "scene"}  # whose --resume is the folder of a checkpoint


def leaves(parser, name=""):
    """Every command that does something, by its words."""
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            for word, command in action.choices.items():
                yield from leaves(command, f"{name} {word}".strip())
            return
    yield name, parser


COMMANDS = dict(leaves(build_parser()))


def test_every_command_is_in_the_table():
    assert set(COMMANDS) - WITHOUT == set(WORDS)


@pytest.mark.parametrize("name", WORDS)
def test_a_command_has_the_shared_options_that_mean_something_for_it(name):
    assert set(COMMANDS[name]._option_string_actions) & SHARED == WORDS[name]


@pytest.mark.parametrize("name", ["list", "solve", "show"])
def test_what_runs_no_model_prints_alike(name):
    assert PRINTED <= set(COMMANDS[name]._option_string_actions)


@pytest.mark.parametrize("word", sorted(SHARED))
def test_an_option_is_typed_alike_wherever_it_stands(word):
    """The number of values, their type, the place of the value: equal in all commands."""
    found = {name: COMMANDS[name]._option_string_actions[word] for name, words in WORDS.items() if word in words}
    forms = {
        (a.nargs, getattr(a.type, "__name__", None), type(a).__name__, tuple(a.choices or ())) for a in found.values()
    }
    assert len(forms) == 1
    assert len({a.metavar for name, a in found.items() if not (word == "--resume" and name in FOLDER)}) == 1
    if word in PRINTED | {"--no-plot", "--progress"}:
        assert len({(a.help, a.default) for a in found.values()}) == 1


@pytest.mark.parametrize("name", [name for name, words in WORDS.items() if "--axis" in words])
def test_axes_take_log_and_units_everywhere(name):
    assert "[:log][:UNIT]" in COMMANDS[name]._option_string_actions["--axis"].help


ROD = ["painleve-rod", "--set", "mu=2"]
BALL = ["bouncing-ball", "--state", "height=1"]
COMMAND_LINES = {
    "run": [*BALL, "--t-end", "0.1"],
    "scene": ["box-stack", "--set", "n=2", "dim=2", "--t-end", "0.01"],
    "classify": ROD,
    "map": [*ROD, "--axis", "th=0.1:1.5:4:rad", "thdot=1:10:3:log:rad/s", "--workers", "1"],
    "sweep": [*BALL, "--axis", "e=0.1:0.9:3:log:-", "--t-end", "0.1"],
    "study penalty": [*BALL, "--t-end", "0.5", "--stiffness", "1e6", "1e7"],
    "study convergence": [*BALL, "--t-end", "0.5", "--dt", "1e-2", "1e-3"],
    "study stability": ["belt-oscillator", "--axis", "vb=0.1:0.6:4:log:m/s"],
    "study cycle": ["belt-oscillator", "--axis", "vb=0.2:0.21:2:m/s"],
    "study bifurcation": ["belt-oscillator", "--axis", "vb=0.2:0.6:2:m/s", "--duration", "20", "--dt", "1e-2"],
}


@pytest.mark.filterwarnings("ignore::nonsmooth.UnsettledWarning")
@pytest.mark.parametrize("name", WORDS)
def test_json_is_one_object_with_units_and_quiet_is_silent(name, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    words = [*name.split(), *COMMAND_LINES[name]]
    assert main([*words, "--json"]) == 0
    printed = capsys.readouterr().out
    found = json.loads(printed)
    assert (
        printed.count("\n") == 1 and "units" in printed and not list(tmp_path.iterdir())
    )  # nothing that was not asked for
    assert numbers_in(found) >= 3
    assert main([*words, "--quiet", "--no-plot"]) == 0
    assert capsys.readouterr().out == ""


def numbers_in(value):
    """How many numbers a JSON value holds that are not whole."""
    if isinstance(value, dict | list):
        return sum(map(numbers_in, value.values() if isinstance(value, dict) else value))
    return isinstance(value, float) and value != int(value)


def test_json_of_studies_holds_what_the_library_finds(tmp_path, capsys):
    """The same numbers as in Python: errors and orders, eigenvalues, period and multipliers, map."""
    from nonsmooth.catalogue import BeltOscillator, BouncingBall, PainleveRod

    def told(*words):
        assert main([*words, "--json"]) == 0
        return json.loads(capsys.readouterr().out)

    ball = BouncingBall()
    limit = told("study", "penalty", *COMMAND_LINES["study penalty"])
    study = ns.penalty_study(ball, (0, 0.5), *ball.state(height=1.0), stiffness=[1e6, 1e7], progress=False)
    np.testing.assert_array_equal(np.ravel(limit["results"]["error_u"]["values"]), np.ravel(study.data.error_u))
    np.testing.assert_array_equal(limit["orders"]["error_u"], study.orders("error_u"))
    assert limit["about"]["e_N"] == 0.5 and limit["coordinate_units"]["stiffness"] == "N/m"
    cycle = told("study", "cycle", "belt-oscillator", "--set", "vb=0.2")["cycle"]
    exact = ns.limit_cycle(BeltOscillator(vb=0.2))
    assert cycle["period"] == exact.period and cycle["units"]["period"] == "s"
    np.testing.assert_array_equal(cycle["multipliers"], exact.multipliers)
    sliding = told("study", "stability", "belt-oscillator")["sliding"]
    s = ns.linearise(BeltOscillator(), ns.equilibrium(BeltOscillator())).eigenvalues
    np.testing.assert_array_equal(
        np.array(sliding["eigenvalues"]["re"]) + 1j * np.array(sliding["eigenvalues"]["im"]), s
    )
    chart = told("map", *COMMAND_LINES["map"])
    same = ns.paradox_map(
        PainleveRod(mu=2.0), th=np.linspace(0.1, 1.5, 4), thdot=np.geomspace(1, 10, 3), progress=False
    )
    assert chart["results"]["n_solutions"]["values"] == same.n_solutions.values.tolist()
    assert chart["coordinate_units"]["thdot"] == "rad/s"


def test_records_at_chosen_times_are_in_the_json_of_a_run(capsys):
    """A ball in free fall: 1 - g t^2/2, to rounding at the ends of steps of the midpoint rule."""
    words = ["run", *BALL, "--t-end", "0.2", "--dt", "1e-2", "--t-eval", "0.1", "0.2", "--json"]
    assert main(words) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["units"]["q"] == ["m"] and found["coordinates"] == ["y"] and found["mode"] == ["OPEN"]
    t = np.array(found["records"]["t"])
    np.testing.assert_allclose(np.ravel(found["records"]["q"]), 1 - 9.81 * t**2 / 2, rtol=1e-12)


def test_results_are_saved_as_they_are_printed(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    for words in (["classify", *ROD], ["study", "convergence", *COMMAND_LINES["study convergence"]]):
        assert main([*words, "--json", "--out", "result.json"]) == 0
        printed, saved = json.loads(capsys.readouterr().out), json.loads((tmp_path / "result.json").read_text())
        assert printed.keys() == saved.keys() and printed.get("p") == saved.get("p")
    assert main(["study", "cycle", "belt-oscillator", "--out", "cycle.npz"]) == 2
    assert "must end in one of .json" in capsys.readouterr().err


@pytest.mark.parametrize(("words", "dims"), [
    ([*BALL, "--t-end", "0.1"], {"t": None}), (["box-stack", "--set", "n=2", "dim=2", "--t-end", "0.02"], {"t": None}),
])  # fmt: skip
def test_a_run_is_saved_as_netcdf(words, dims, tmp_path, monkeypatch):
    xarray = pytest.importorskip("xarray")
    pytest.importorskip("netCDF4")
    monkeypatch.chdir(tmp_path)
    assert main(["run", *words, "--out", "run.nc", "--no-plot", "--quiet"]) == 0
    with xarray.open_dataset(tmp_path / "run.nc", engine="netcdf4") as found:
        assert found.sizes and all(
            "units" in found[name].attrs for name in found.data_vars if found[name].dtype == float
        )


def test_a_scene_records_what_was_asked_for(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    words = ["run", "box-stack", "--set", "n=2", "dim=2", "--t-end", "0.02"]
    assert main([*words, "--record", "bodies", "events", "--out", "run.npz", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert set(found["bodies"]) and "ledger" not in found and "contacts" not in found
    assert ns.SceneSolution.load("run.npz").recorded == ("bodies", "events")
    assert main([*words, "--json"]) == 0
    both = json.loads(capsys.readouterr().out)
    weight = sum(contact["P"][1] for contact in both["contacts"] if "ground" in contact["bodies"][0])
    assert len(both["contacts"]) == 4 and weight > 0.0
    assert main([*words, "--record", "body"]) == 2 and "record must be some of" in capsys.readouterr().err
    assert main(["run", *BALL, "--record", "bodies"]) == 2
    assert "record must be some of 'coordinates', 'velocities'" in capsys.readouterr().err
    assert main([*words, "--record", "contacts", "--plot", "a.png"]) == 2
    assert "--plot needs bodies, which --record leaves out" in capsys.readouterr().err


def test_progress_of_a_run_as_json(capsys):
    assert main(["run", *BALL, "--t-end", "0.2", "--progress", "json", "--json"]) == 0
    lines = [json.loads(line) for line in capsys.readouterr().err.splitlines() if line.startswith("{")]
    assert lines and all(0 <= line["part"] <= 1 for line in lines)


def test_a_map_goes_on_from_its_journal(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    words = ["map", *COMMAND_LINES["map"], "--resume", "map.jsonl", "--json"]
    assert main(words) == 0
    first = capsys.readouterr().out
    lines = (tmp_path / "map.jsonl").read_text().splitlines(keepends=True)
    (tmp_path / "map.jsonl").write_text("".join(lines[:-5]))
    assert main(words) == 0
    assert json.loads(capsys.readouterr().out)["results"] == json.loads(first)["results"]
