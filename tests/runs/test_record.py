"""A run keeps what was asked for, to the bits of a run that keeps all; what was not asked for is refused by name."""

import copy
import json
import pickle
import tracemalloc
import warnings

import numpy as np
import pytest

import nonsmooth as ns
from models import BeadChain, BeltOscillator, BouncingBall, PainleveRod, SpragSlip
from nonsmooth.commands.cli import main
from nonsmooth.results.recorded import KINDS, KINDS_OF_SYSTEM
from nonsmooth.results.solution import KIND_OF
from nonsmooth.runs.recorder import Recorder
from nonsmooth.runs.simulate_system import new_run
from tests.systems import ball

STEP = ns.MoreauJean(dt=1e-3)
ARRAYS = ("q", "u", "g_N", "P_N", "P_F", "mode", "slip", "event_rows")
BALL, ROD = BouncingBall(e=0.5), PainleveRod(m=1.0, l=2.0, I=1 / 3, mu=1.0, e=0.9)
SCENES = {
    "ball": (BALL, BALL.state(height=0.05), 0.3),
    "belt": (BeltOscillator(), BeltOscillator().state(), 0.5),
    "sprag slip": (SpragSlip(), SpragSlip().state(), 0.2),
    "beads": (BeadChain(n=3), BeadChain(n=3).state(), 0.01),
}
WISHES = ("motion", "events", (), ("ledger",), ["modes", "impulses"], ("coordinates", "ledger", "gaps"))


def run(model, start, t_end, integrator=STEP, **options):
    return ns.simulate(model, (0.0, t_end), *start, integrator=integrator, **options)


def assert_is_part(part, whole, wish):
    """What is kept has the bits of the whole run, and the rest is refused by name."""
    assert part.recorded == KINDS_OF_SYSTEM.chosen(wish)
    assert part.t.tobytes() == whole.t.tobytes()
    for name in ARRAYS:
        kind = KIND_OF[name]
        if kind in part.recorded:
            assert np.asarray(getattr(part, name)).tobytes() == np.asarray(getattr(whole, name)).tobytes(), name
        else:
            with pytest.raises(ns.InvalidInput, match=rf'{name} was not recorded; .*record=\("{kind}", ...\)'):
                getattr(part, name)
    if "ledger" in part.recorded:
        for name, column in part.ledger.items():
            assert column.tobytes() == whole.ledger[name].tobytes()
        assert part.stats.ledger_error == whole.stats.ledger_error
    else:
        for ask in (lambda: part.ledger, lambda: part.stats.ledger_error):
            with pytest.raises(ns.InvalidInput, match=r'ledger\w* was not recorded; .*record=\("ledger", ...\)'):
                ask()


def told(stats):
    return {name: value for name, value in stats.as_dict().items() if not name.endswith(("_time", "ledger_error"))}


@pytest.mark.parametrize("scene", SCENES)
@pytest.mark.parametrize("wish", WISHES, ids=str)
def test_what_is_kept_has_the_bits_of_a_run_that_keeps_all(scene, wish):
    whole, part = run(*SCENES[scene]), run(*SCENES[scene], record=wish)
    assert_is_part(part, whole, wish)
    assert told(part.stats) == told(whole.stats) and part.success


def test_the_steps_book_nothing_that_nobody_asks_for():
    model, start, t_end = SCENES["sprag slip"]

    def went(wish):
        going = new_run(
            model.system(), STEP, (0.0, t_end), 1, None, *start, 0, False, Recorder(KINDS_OF_SYSTEM.chosen(wish))
        )
        going.advance(None, None, None)
        return going

    bare, whole = went("motion"), went(None)
    assert whole.state.ledger.any() and not bare.state.ledger.any() and not bare.state.P_sum.any()
    assert len(whole.recorder.event_rows()) > 0 == len(bare.recorder.event_rows())
    assert bare.record.q.size == whole.record.q.size and bare.record.P.size == bare.record.ledger.size == 0
    assert bare.record.words.size < 0.4 * whole.record.words.size


def test_contacts_that_gain_energy_are_told_of_without_a_ledger():
    start = {"q0": ROD.state(th=np.pi / 4)[0], "u0": [0.6, -1.0, 0.0]}
    found = []
    for wish in (None, "motion"):
        with pytest.warns(ns.EnergyGainWarning):
            stats = ns.simulate(ROD, (0, 0.05), **start, integrator=STEP, record=wish).stats
        found.append((stats.energy_gains, stats.worst_energy_gain))
    assert found[0] == found[1] and found[0][0] > 0


@pytest.mark.parametrize("integrator", [
    ns.EventDriven(), ns.Adaptive(rtol=1e-5), ns.Penalty(1e6, damping_ratio=0.2),
], ids=["events", "adaptive", "penalty"])  # fmt: skip
@pytest.mark.parametrize("wish", ["motion", ("events", "ledger"), ("impulses",)], ids=str)
def test_every_integrator_leaves_out_what_was_not_asked_for(integrator, wish):
    whole, part = (run(*SCENES["ball"], integrator=integrator, record=record) for record in (None, wish))
    assert_is_part(part, whole, wish)
    if "impulses" not in part.recorded:
        with pytest.raises(ns.InvalidInput, match="la was not recorded"):
            part.la  # noqa: B018
    elif whole.la is not None:
        assert part.la.tobytes() == whole.la.tobytes()
    if wish == "motion":
        assert part(0.005).q.tobytes() == whole(0.005).q.tobytes()


def test_the_motion_between_records_asks_for_what_it_is_found_with():
    part = run(*SCENES["ball"], record=("coordinates", "velocities", "modes"))
    with pytest.raises(ns.InvalidInput, match=r'it needs the events\) was not recorded; .*record=\("events", ...\)'):
        part(0.1)
    whole = run(*SCENES["ball"])
    kept = run(*SCENES["ball"], record=("motion", "modes", "events"))
    assert kept(0.1234).u.tobytes() == whole(0.1234).u.tobytes()


def test_events_of_the_user_are_found_whatever_is_recorded():
    def fallen(t, q, u):
        return q[0] - 0.02

    def bounced(t, q, u):
        return u[0] - 1e-9

    bounced.terminal, bounced.direction = True, 1
    whole, part = (run(*SCENES["ball"], events=[fallen, bounced], record=wish) for wish in (None, "motion"))
    assert_is_part(part, whole, "motion")
    assert [t.tolist() for t in part.t_events] == [t.tolist() for t in whole.t_events] and len(part.t_events[1]) == 1


@pytest.mark.parametrize("wish", WISHES, ids=str)
def test_files_and_copies_hold_what_was_recorded(tmp_path, wish):
    model, start, t_end = SCENES["belt"]
    whole, part = run(model, start, t_end), run(model, start, t_end, record=wish)
    part.save(tmp_path / "run.npz")
    for again in (ns.Solution.load(tmp_path / "run.npz", model), copy.copy(part), pickle.loads(pickle.dumps(part))):
        assert_is_part(again, whole, wish)
        assert again.summary() == part.summary()
    assert_is_part(run(model, start, t_end, record=wish, t_eval=[0.1, 0.3]),
                   run(model, start, t_end, t_eval=[0.1, 0.3]), wish)  # fmt: skip


@pytest.mark.parametrize("wish", WISHES, ids=str)
@pytest.mark.parametrize("integrator", [STEP, ns.EventDriven()], ids=["fixed step", "events"])
def test_a_checkpoint_holds_what_is_recorded_and_goes_on_to_the_same_bits(small, tmp_path, wish, integrator):
    scene, path = SCENES["sprag slip"], tmp_path / "run.nsc"
    whole = run(*scene, integrator=integrator)
    begun = run(*scene, integrator=integrator, record=wish, checkpoint=path, max_steps=50, on_failure="return")
    assert begun.status == ns.Status.BUDGET_SPENT and begun.recorded == KINDS_OF_SYSTEM.chosen(wish)
    other = "events" if wish == () else None
    with pytest.raises(ns.InvalidInput, match="is of another run: its record is"):
        run(*scene, integrator=integrator, record=other, resume=path)
    assert_is_part(run(*scene, integrator=integrator, record=wish, resume=path), whole, wish)
    loaded = ns.Solution.load(path)
    assert loaded.recorded == KINDS_OF_SYSTEM.chosen(wish) and "not recorded" in loaded.summary()


def test_a_checkpoint_read_without_its_model_tells_its_works(tmp_path):
    run(ball(), ([0.05], [0.0]), 0.3, checkpoint=tmp_path / "run.nsc")
    assert "energy: work of force" in ns.Solution.load(tmp_path / "run.nsc").summary()


@pytest.mark.parametrize("wish", WISHES, ids=str)
def test_tables_pictures_and_summaries_leave_out_what_was_not_recorded(tmp_path, wish):
    pytest.importorskip("xarray"), pytest.importorskip("pandas"), pytest.importorskip("matplotlib")
    model, start, t_end = SCENES["sprag slip"]
    part, kinds = run(model, start, t_end, record=wish), KINDS_OF_SYSTEM.chosen(wish)
    data, table = part.to_xarray(), part.to_dataframe()
    columns = {"q": "th", "u": "thdot", "g_N": "g_N[0]", "P_N": "P_N[0]", "mode": "mode[0]"}
    for name, of_table in columns.items():
        assert (name in data) == (KIND_OF[name] in kinds) == (of_table in table.columns)
    assert ("friction" in data) == ("friction [J]" in table) == ("ledger" in kinds)
    assert ("kinetic" in data) == ({"ledger", *KINDS_OF_SYSTEM.chosen("motion")} <= set(kinds))
    assert ("event_t" in data) == ("events" in kinds)
    assert part.summary().splitlines()[-1] == "not recorded: " + ", ".join(k for k in KINDS if k not in kinds)
    if {"coordinates", "velocities", "ledger"} & set(kinds):
        part.plot(tmp_path / "run.png")
    else:
        with pytest.raises(ns.InvalidInput, match="what a figure of the run shows was not recorded"):
            part.plot(tmp_path / "run.png")
    if "coordinates" in kinds:
        part.view(tmp_path / "run.html")
    else:
        with pytest.raises(ns.InvalidInput, match="q was not recorded"):
            part.view(tmp_path / "run.html")


def test_the_command_line_keeps_what_is_asked_for(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    words = ["run", "bouncing-ball", "--t-end", "0.1"]
    assert main([*words, "--record", "motion", "--out", "run.npz", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert {"q", "u", "stats"} <= found.keys() and not {"ledger", "mode", "g_N", "events"} & found.keys()
    assert "ledger_error" not in found["stats"]
    assert ns.Solution.load("run.npz").recorded == ("coordinates", "velocities")
    assert main([*words, "--record", "events"]) == 0 and "not recorded: coordinates" in capsys.readouterr().out
    assert not list(tmp_path.glob("bouncing-ball.png"))
    assert main([*words, "--record", "events", "--view"]) == 2
    assert "--view needs coordinates, which --record leaves out" in capsys.readouterr().err


def test_cells_of_functions_are_measured_on_what_is_recorded():
    def way(solution):
        return float(solution.q[-1, 0]), solution.recorded == ("coordinates",)

    def lost(solution):
        return solution.ledger["normal"][-1]

    axes = {"e": [0.2, 0.5]}
    task = ns.RunTask(BALL, way, t_span=(0, 0.1), integrator=STEP, record="coordinates")
    assert ns.sweep(task, axes, progress=False).way.values[:, 1].all()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        refused = ns.sweep(ns.RunTask(BALL, lost, t_span=(0, 0.1), integrator=STEP, record="motion"), axes,
                           progress=False)  # fmt: skip
    assert all("ledger was not recorded" in words for words in refused.message.values.tolist())


@pytest.mark.upkeep
def test_a_loop_of_its_own_skips_what_the_generic_one_skips():
    own = run(*SCENES["ball"], integrator=ns.MoreauJean(dt=1e-3, specialise=True), record="motion")
    assert_is_part(own, run(*SCENES["ball"]), "motion")


def test_memory_does_not_grow_with_the_steps_between_two_records():
    """A ball at rest has no events: 2 10^6 steps more take 8 kB at most, where a number a step would be 16 MB."""

    def peak(steps):
        tracemalloc.start()
        try:
            run(BALL, BALL.state(height=0.05), steps * STEP.dt, every=steps)
            return tracemalloc.get_traced_memory()[1]
        finally:
            tracemalloc.stop()

    peak(1000)  # makes what is made once in a process
    assert peak(2_000_000) < peak(10_000) + 8192


def test_a_scene_takes_the_same_short_word():
    def fall(record):
        scene = ns.Scene(gravity=(0, -10.0))
        scene.body(ns.Disc(0.1), mass=1.0, position=(0, 1.0), name="ball")
        return ns.simulate(scene, (0, 0.1), integrator=ns.MoreauJean(dt=1e-2), record=record)

    assert fall("motion").recorded == fall(("bodies",)).recorded == ("bodies",)
    assert fall(["motion", "ledger"]).recorded == ("bodies", "ledger")
