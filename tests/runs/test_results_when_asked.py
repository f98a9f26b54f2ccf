"""What a short run says when it is first asked is of that run, whatever was run in its memory since."""

from __future__ import annotations

import copy
import pickle
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import nonsmooth as ns
from models import BouncingBall, PainleveRod
from tests.systems import ball, ball_gap

BALL, STEP, SPAN = BouncingBall(e=0.5), ns.MoreauJean(dt=1e-2), (0.0, 0.05)
HEIGHTS = np.linspace(0.001, 1.0, 12)


def run(height, span=SPAN, **options):
    return ns.simulate(BALL, span, *BALL.state(height=height), integrator=STEP, **options)


def said(solution):
    """All columns and counts of a run, to the last bit."""
    columns = [getattr(solution, name) for name in ("t", "q", "u", "g_N", "P_N", "P_F", "mode", "slip", "event_rows")]
    columns += list(solution.ledger.values())
    stats = [value for name, value in vars(solution.stats).items() if not name.endswith("_time")]
    return [column.tobytes() for column in columns], stats, solution.about, solution.message


def test_runs_in_between_do_not_change_what_a_run_says_late():
    at_once = [said(run(height)) for height in HEIGHTS]
    late = [run(height) for height in HEIGHTS]
    assert [said(solution) for solution in late] == at_once
    assert len({repr(columns) for columns, *_ in at_once}) == len(HEIGHTS)


def test_motion_asked_late_is_that_of_the_run():
    first, again = run(1.0), run(1.0)
    run(0.5)
    assert first(0.025).q.tobytes() == again(0.025).q.tobytes()
    other_times = run(1.0, (0.0, 0.1))  # the schedule of the first one is not that of the last
    assert len(first.t) == 6 and len(other_times.t) == 11


def test_threads_do_not_write_into_the_rows_of_one_another():
    at_once = [said(run(height)) for height in HEIGHTS]
    with ThreadPoolExecutor(4) as pool:
        late = list(pool.map(run, list(HEIGHTS) * 6))
    assert [said(solution) for solution in late] == at_once * 6


@pytest.mark.parametrize("duplicate", [copy.copy, copy.deepcopy, lambda one: pickle.loads(pickle.dumps(one))])
def test_a_copy_of_a_solution_that_nobody_asked_says_the_same(duplicate):
    assert said(duplicate(run(0.3))) == said(run(0.3))


def test_a_gain_of_energy_is_told_although_nobody_asks_for_the_figures():
    rod = PainleveRod(m=1.0, l=2.0, I=1 / 3, mu=1.0, e=0.9)
    q0, _ = rod.state(th=np.pi / 4)
    with pytest.warns(ns.EnergyGainWarning):
        ns.simulate(rod, (0, 0.05), q0, [0.6, -1.0, 0.0], integrator=ns.MoreauJean(1e-3))


def test_a_start_at_which_a_function_fails_is_refused_by_its_name_after_many_that_were_good():
    """The machine code of the functions is asked first, their source says what is wrong."""

    def gap(t, q, p, g_N):
        ball_gap(t, q, p, g_N)
        if q[0] > 1.5:
            raise ValueError("beyond the table")

    system = ball(gap=gap)
    for _ in range(5):
        ns.simulate(system, SPAN, [1.0], [0.0], integrator=STEP)
    with pytest.raises(ns.InvalidInput, match="gap raised ValueError: beyond the table"):
        ns.simulate(system, SPAN, [2.0], [0.0], integrator=STEP)


def test_a_body_of_the_scene_names_itself_and_one_of_another_does_not():
    scene, other = ns.Scene(gravity=(0, -9.81)), ns.Scene(gravity=(0, -9.81))
    falls = [each.body(ns.Disc(0.1), mass=1.0, position=(0.0, 1.0), name="disc") for each in (scene, other)]
    motion = ns.simulate(scene, (0, 0.01), integrator=ns.MoreauJean(dt=1e-3))
    late = scene.body(ns.Disc(0.1), mass=1.0, position=(5.0, 1.0), name="late")
    np.testing.assert_array_equal(motion[falls[0]].position, motion["disc"].position)
    for stranger in (falls[1], late, 0):
        with pytest.raises(ns.InvalidInput, match="there is no body"):
            motion[stranger]
