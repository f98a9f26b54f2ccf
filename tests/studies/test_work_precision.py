"""Run time against error: what is measured, what costs at equal error, and what a reference does not tell."""

from __future__ import annotations

import numpy as np
import pytest

import nonsmooth as ns
from models import BouncingBall, WallPendulum
from nonsmooth.errors import InvalidInput, UnknownName
from nonsmooth.results.failures import StepFailure
from nonsmooth.studies.work_precision import Trial, distance
from nonsmooth.studies.work_precision_result import WorkPrecision, joined
from tests.drawing.looks import faults

xarray = pytest.importorskip("xarray")

BALL = BouncingBall(e=0.5)
MOTION = ns.TimedMotion(BALL, (0.0, 2.0), *BALL.state(height=1.0), reference=lambda t: [BALL.height(t)])


class Clock:
    """A method whose answers and times are known: error h^2 and time 1 ms/h, in the order in which it is asked."""

    def __init__(self, fails=()):
        self.fails, self.asked = fails, []

    def settings(self, name, problem):
        return (1e-1, 1e-2, 1e-3)

    def run(self, name, problem, setting):
        self.asked.append(setting)
        if setting in self.fails:
            raise StepFailure("no such step", None, 0.0)
        exact = np.array([[BALL.height(t)] for t in problem.times])
        wrong = setting**2 * exact.max() * np.ones_like(exact)
        return Trial(exact + wrong, 1e-3 / setting, 1 / setting, 1 / setting)


def test_error_is_the_mean_distance_over_the_largest_position():
    q_ref = np.array([[3.0, 4.0], [0.0, 0.0]])
    assert distance(q_ref + [[0.0, 1.0], [1.0, 0.0]], q_ref) == pytest.approx(1.0 / 5.0)
    assert distance(np.ones((2, 1)), np.zeros((2, 1))) == 1.0  # absolute where nothing moves


def test_costs_at_equal_error_are_read_log_log_between_runs():
    study = ns.work_precision({"ball": MOTION}, {"clock": Clock()}, repeats=1)
    errors, walls = study.curve("ball", "clock")
    np.testing.assert_allclose(errors, [1e-2, 1e-4, 1e-6], rtol=1e-9)
    np.testing.assert_allclose(walls, [1e-2, 1e-1, 1.0])
    assert study.cost_at(1e-3, "ball", "clock") == pytest.approx(10**-1.5)  # time ~ error^(-1/2)
    assert study.cost_at(1e-5, "ball", "clock", "evaluations") == pytest.approx(10**2.5)
    assert study.cost_at(0.5, "ball", "clock") == pytest.approx(1e-2)  # the cheapest run does
    assert np.isnan(study.cost_at(1e-7, "ball", "clock"))


def test_repeats_are_interleaved():
    one, other = Clock(), Clock()
    order = []
    for clock in (one, other):
        clock.run = lambda name, problem, setting, clock=clock, run=clock.run: (
            order.append((clock is one, setting)) or run(name, problem, setting)
        )
    ns.work_precision({"ball": MOTION}, {"one": one, "other": other}, repeats=2)
    settings = (1e-1, 1e-2)  # the slowest takes a second and is not repeated
    assert order[6:] == [(is_one, s) for is_one in (True, False) for s in settings] * 2


def test_a_luckily_small_error_of_a_coarse_run_does_not_count():
    rows = {"error": [1e-7, 1e-3, 1e-6], "wall_time": [1.0, 2.0, 4.0], "evaluations": [1.0, 2.0, 4.0]}
    data = xarray.Dataset(
        {key: (("scene", "integrator", "level"), [[values]]) for key, values in rows.items()}
        | {"disagreement": ("scene", [0.0])},
        {"scene": ["s"], "integrator": ["m"], "level": [0, 1, 2]},
    )
    assert 2.0 < WorkPrecision("level", data, "t").cost_at(1e-5, "s", "m") < 4.0


def test_failed_runs_are_told_with_their_messages():
    study = ns.work_precision({"ball": MOTION}, {"clock": Clock(fails=(1e-2,))}, repeats=1)
    assert len(study.curve("ball", "clock")[0]) == 2
    assert "clock at 0.01: no such step" in study.table()


def test_disagreement_of_the_two_references_is_reported_and_hides_what_is_below():
    pendulum = WallPendulum()
    pair = (ns.EventDriven(rtol=1e-9, atol=1e-11), ns.EventDriven(rtol=1e-5, atol=1e-7))
    study = ns.work_precision([pendulum], {"EventDriven": ns.OwnMethod(ns.EventDriven, (1e-4, 1e-8))}, pair, repeats=1)
    disagreement = study.data.disagreement.item()
    assert 1e-8 < disagreement < 1e-4
    assert study.floor_of("wall-pendulum") == 10 * disagreement
    assert f"{disagreement:.1e}" in study.table()
    assert np.isnan(study.cost_at(disagreement, "wall-pendulum", "EventDriven"))


def test_tolerance_buys_accuracy_on_the_ball_through_zeno():
    study = ns.work_precision(
        {"ball": MOTION}, {"fixed": ns.OwnMethod(ns.MoreauJean, (1e-2, 1e-3)), "events": ns.EventDriven()}, repeats=1
    )
    errors, _ = study.curve("ball", "fixed")
    assert errors[1] < errors[0]
    assert study.best_error("ball", "events") < 1e-12
    assert study.data["steps"].sel(scene="ball", integrator="fixed").values[:2].tolist() == [208.0, 2000.0]


def test_figure_has_a_curve_for_each_method_and_cost(tmp_path):
    pytest.importorskip("matplotlib")
    study = ns.work_precision({"ball": MOTION}, {"one": Clock(), "other": Clock()}, repeats=1)
    figure = study.plot(tmp_path / "study.png")
    wall, evaluations = figure.axes
    assert [len(axes.get_lines()) for axes in (wall, evaluations)] == [2, 2]
    assert wall.get_xlabel() == "wall time [ms]" and evaluations.get_xlabel() == "force evaluations [-]"
    assert (tmp_path / "study.png").stat().st_size > 0


@pytest.mark.upkeep
def test_several_scenes_have_a_panel_each_of_the_cost_that_is_asked_for():
    pytest.importorskip("matplotlib")
    study = ns.work_precision({name: MOTION for name in ("one", "two", "three")}, {"clock": Clock()}, repeats=1)
    for cost, label in ((None, "wall time [ms]"), ("evaluations", "force evaluations [-]")):
        figure = study.plot(cost=cost)
        assert [axes.get_title(loc="left") for axes in figure.axes] == ["one", "two", "three"]
        assert {axes.get_xlabel() for axes in figure.axes} == {label} and faults(figure) == []
    with pytest.raises(ns.InvalidInput, match="cost must be one of 'wall_time', 'evaluations'; got 'steps'"):
        study.plot(cost="steps")


@pytest.mark.parametrize(
    "call",
    [
        lambda: ns.work_precision({}, {"m": ns.MoreauJean}),
        lambda: ns.work_precision([BALL], {}),
        lambda: ns.work_precision([BALL], {"m": 3}),
        lambda: ns.work_precision({"ball": BALL}, {"m": ns.MoreauJean}),
        lambda: ns.work_precision([BALL], {"m": ns.MoreauJean}, repeats=0),
        lambda: ns.work_precision([BALL], {"m": ns.MoreauJean}, reference=np.zeros((3, 1))),
        lambda: ns.work_precision([BALL], {"m": ns.MoreauJean}, reference=lambda t: [np.nan]),
    ],
)
def test_input_that_breaks_a_rule_is_refused(call):
    with pytest.raises(InvalidInput):
        call()


def test_unknown_scenes_and_methods_are_refused_with_the_nearest():
    study = ns.work_precision({"ball": MOTION}, {"clock": Clock()}, repeats=1)
    with pytest.raises(UnknownName, match="clock"):
        study.curve("ball", "clok")


def test_studies_of_different_scenes_are_joined():
    one = ns.work_precision({"one": MOTION}, {"clock": Clock()}, repeats=1)
    other = ns.work_precision({"other": MOTION}, {"clock": Clock(fails=(1e-2,))}, repeats=1)
    study = joined([one, other])
    assert study.scenes == ["one", "other"]
    for part in (one, other):
        for mine, its in zip(part.curve(part.scenes[0], "clock"), study.curve(part.scenes[0], "clock"), strict=True):
            np.testing.assert_array_equal(mine, its)
    assert study.failures("one") == [] and study.failures("other") == other.failures("other")
