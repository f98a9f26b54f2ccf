"""Studies of the penalty limit and of the step: laws found, branches told, errors hidden by the reference left out."""

import dataclasses
import math
from typing import NamedTuple

import numpy as np
import pytest

import nonsmooth as ns
from models import BeadChain, BouncingBall, PainleveRod, SpragSlip, WallPendulum
from nonsmooth.studies.laws_of_convergence import fit_laws, observed_orders
from tests.drawing.looks import faults

pytest.importorskip("xarray")


@pytest.mark.parametrize("law", ["k^-1", "ln k/k", "k^-1/2", "k^-1/2 ln k"])
def test_each_law_is_told_from_the_others(law):
    k = np.logspace(4, 12, 9)
    shapes = {"k^-1": 1 / k, "ln k/k": np.log(k) / k, "k^-1/2": k**-0.5, "k^-1/2 ln k": k**-0.5 * np.log(k)}
    fits = fit_laws("stiffness", k, 3.0 * shapes[law])
    assert fits[0].law == law
    assert abs(fits[0].constant - 3.0) < 1e-12 and fits[0].spread < 1e-12


def test_unknown_errors_take_no_part_in_orders_and_laws():
    dt = np.array([1e-1, 1e-2, 1e-3, 1e-4])
    errors = np.array([1e-1, 1e-2, np.nan, 1e-4])
    assert observed_orders(dt, errors)[0] == pytest.approx(1.0)
    assert np.isnan(observed_orders(dt, errors)[1:]).all()
    assert fit_laws("dt", dt, errors)[0].law == "dt"
    assert fit_laws("dt", dt[:2], errors[:2]) == []


def test_seizure_costs_a_logarithm():
    """After a seizure th(t) - limit = O(ln k/k); c/k = 1 s, against the rigid rod with a million steps."""
    rod = SpragSlip()
    study = ns.penalty_study(
        rod, (0, 0.1), *rod.state(th=0.78, thdot=1.0), stiffness=[1e4, 1e5, 1e6, 1e7], damping=lambda k: k, beside=[]
    )
    assert study.fits("error_q")[0].law == "ln k/k"
    assert (np.diff(study.orders("error_q")) > 0).all() and 0.8 < study.orders("error_q")[0] < 1
    P_N = rod.seizure(0.78, 1.0).P_N
    assert abs(study.data.P_N.values[-1] - P_N) < 0.01 * P_N  # the episode ends at a hundredth of the peak force


def test_impact_without_collision_converges_to_another_solution_than_the_plastic_one():
    rod = PainleveRod(mu=2.0)
    limit = rod.impact_without_collision(e=1.0, law="energetic").gamma_N
    study = ns.penalty_study(
        rod,
        (0, 0.01),
        *rod.state(slip=-1.0),
        stiffness=np.logspace(8, 12, 5),
        limit=limit,
        restitution="own",
        beside=[ns.MoreauJean(1e-5)],
    )
    assert study.fits("error_gamma_N")[0].law == "k^-1/2 ln k"
    assert np.allclose(study.data.restitution.values, 1.0, atol=1e-6)  # an undamped contact gives its work back
    assert abs(study.orders("error_u")[-1]) < 0.01  # the distance to the plastic impact does not fall
    assert float(study.data.beside_error_u[0]) < 1e-3 * study.errors("error_u")[-1]
    assert set(study.data.branch.values) == {"open, slide -, stick, slide +, open"}


def test_undamped_bounces_are_late_by_the_contacts_and_right_after_them():
    """A ball that meets its spring with the velocity v leaves it with v at zero gap, T later than the rigid ball:
    d = g/omega^2 (1 - cos omega t) + v/omega sin omega t vanishes at T = (pi + 2 atan(g/(omega v)))/omega. So the
    n-th bounce is n T late, of the law k^-1/2 with the constant n pi sqrt(m), and the motion after it has no error."""
    ball, g = BouncingBall(e=1.0), 9.81
    study = ns.penalty_study(ball, (0, 2), *ball.state(height=1.0), stiffness=np.logspace(5, 9, 5), beside=[])
    v, omega = math.sqrt(2 * g), np.sqrt(study.x)
    T = (math.pi + 2 * np.arctan(g / (omega * v))) / omega
    assert study.data.event_mode.values.tolist() == ["open", "open"]
    assert np.allclose(study.data.event_time, [v / g, 3 * v / g], rtol=1e-11)
    for n in (1, 2):
        assert np.allclose(study.errors("error_event_t", n - 1), n * T, rtol=1e-6)  # rtol 1e-8 of each step
        fit = study.fits("error_event_t", n - 1)[0]
        assert fit.law == "k^-1/2" and abs(fit.constant / (n * math.pi) - 1) < 0.01  # g/(omega v) is 0.7 % at 1e5
    assert np.isnan(study.errors("error_after_q")).all()  # below the floor
    assert study.data.error_after_u.max() < 1e-8 * v * 10 and study.data.error_u.min() > 1e-3
    assert "error_event_t of 'open' at 1.35457 s, event 2" in study.table()


def test_bounce_of_a_damped_contact_leaves_with_the_closed_restitution():
    """Against the rigid ball with e(zeta): after the bounce only gravity's part during the contact is wrong."""
    zeta, g = 0.3, 9.81
    e = math.exp(-2 * zeta * math.acos(zeta) / math.sqrt(1 - zeta**2))
    ball, delay = BouncingBall(e=e), 0.1
    study = ns.penalty_study(
        ball, (0, 0.8), *ball.state(height=1.0), stiffness=np.logspace(6, 10, 5), damping_ratio=zeta, delay=delay,
        beside=[],
    )  # fmt: skip
    assert study.data.delay.values.tolist() == [delay]
    contact = 2 * math.acos(zeta) / math.sqrt(1 - zeta**2) / np.sqrt(study.x)  # its duration
    assert np.allclose(study.errors("error_event_t", 0), contact, rtol=0.01)
    assert (study.errors("error_after_u", 0) < 2 * g * contact).all()
    assert np.allclose(study.orders("error_after_u", 0), 0.5, atol=0.05)


def test_rigid_solution_is_matched_at_its_seizure_and_its_slip():
    """The seized tip slips again when the friction suffices no more; both are late by O(ln k/k), the motions after them
    differ by O(1/k): what was wrong is the time."""
    rod = SpragSlip()
    study = ns.penalty_study(
        rod, (0, 0.2), *rod.state(th=0.78, thdot=1.0), stiffness=[1e4, 1e5, 1e6, 1e7], damping=lambda k: k, beside=[]
    )
    assert study.data.event_mode.values.tolist() == ["stick", "slide -"] and study.data.event_time.values[0] == 0
    np.testing.assert_array_equal(study.errors("error_event_t", 0), study.data.stop_time)
    assert study.fits("error_event_t", 0)[0].law == "ln k/k"
    assert study.fits("error_after_q")[0].law == "k^-1"


def test_event_that_a_run_does_not_have_is_unknown():
    """An overdamped contact does not bounce; the elastic rigid ball does."""
    ball = BouncingBall(e=1.0)
    options = {"stiffness": [1e6], "damping_ratio": 20.0, "restitution": "own", "beside": []}
    study = ns.penalty_study(ball, (0, 1.5), *ball.state(height=1.0), times=[0.4], **options)
    assert "event" not in study.data.dims  # nothing happens before 0.4 s
    study = ns.penalty_study(ball, (0, 1.5), *ball.state(height=1.0), **options)
    assert study.data.event_mode.values.tolist() == ["open", "open"]
    assert np.isnan(study.data.error_event_t).all() and np.isnan(study.data.error_after_q).all()
    assert "-" in study.table().splitlines()[2].split()


@pytest.mark.parametrize("integrator", [ns.EventDriven, ns.Penalty(1e6, damping_ratio=1.0)])
def test_error_controlled_integrators_follow_their_tolerance(integrator):
    """Radau IIA of order 5 with an estimate of order 4: the errors go as rtol^(5/4), some by chance."""
    rod = PainleveRod(mu=1.0)
    study = ns.convergence_study(
        rod, (0, 0.7), *rod.state(slip=1.0), integrator=integrator, rtol=[1e-5, 1e-6, 1e-7, 1e-8]
    )
    assert study.of == "rtol" and study.data.sizes["event"] > 2
    for name in ("error_q", "error_u"):
        known = np.isfinite(study.errors(name))
        power = np.polyfit(np.log(study.x[known]), np.log(study.errors(name)[known]), 1)[0]
        assert known.sum() >= 3 and 0.9 < power < 1.6


def test_moreau_jean_is_of_first_order_across_events_of_the_event_driven_run():
    rod = PainleveRod(mu=1.0)
    exact = ns.EventDriven(rtol=1e-12, atol=1e-14)
    study = ns.convergence_study(
        rod, (0, 0.7), *rod.state(slip=1.0), dt=[4e-4, 2e-4, 1e-4], reference=exact, integrator=ns.MoreauJean(1.0, 1.0)
    )
    assert study.data.event_mode.values.tolist() == ["stick", "slide +", "stick"]
    assert (
        study.errors("error_event_t") < 4 * study.x
    ).all()  # an event is known to a step, slip may wait for the next


@pytest.mark.upkeep
def test_studies_are_sweeps_with_workers_and_a_journal(tmp_path):
    rod, book = SpragSlip(), tmp_path / "study.jsonl"

    def study(**options):
        start = rod.state(th=0.78, thdot=1.0)
        return ns.penalty_study(
            rod, (0, 0.1), *start, stiffness=[1e5, 1e6, 1e7], damping=lambda k: k, beside=[], **options
        )

    here, there = study(), study(workers=2, journal=book)
    for name in (*here.kinds, "own_q", "steps", "branch", "peak_force"):
        np.testing.assert_array_equal(here.data[name], there.data[name])
    again = study(journal=book)
    assert again.data.attrs["cells_from_journal"] == 3
    np.testing.assert_array_equal(again.data.wall_time, there.data.wall_time)  # not run again


def test_damping_ratio_fixes_the_restitution_of_a_bounce():
    ball, zeta = BouncingBall(), 0.5
    study = ns.penalty_study(
        ball, (0, 0.5), *ball.state(height=1.0), stiffness=[1e8, 1e10], damping_ratio=zeta,
        reference=([[0.0]], [[0.0]]), beside=[],
    )  # fmt: skip
    e = math.exp(-2 * zeta * math.acos(zeta) / math.sqrt(1 - zeta**2))
    assert np.allclose(study.data.restitution.values, e, atol=1e-3)  # gravity over the contact, 1e-4 at k = 1e8


def test_moreau_jean_is_of_second_order_in_smooth_motion():
    pendulum = WallPendulum(th_w=-1.5)  # the wall is out of reach
    study = ns.convergence_study(pendulum, (0, 1), *pendulum.state(th=1.0), dt=[1e-2, 5e-3, 2.5e-3])
    assert study.fits("error_q")[0].law == "dt^2"


def test_moreau_jean_finds_an_impact_within_a_step():
    ball, t, e = BouncingBall(e=0.5), 0.6, 0.5
    t_1 = math.sqrt(2 / 9.81)
    v = e * 9.81 * t_1  # upwards, after the impact at t_1
    exact = ([[v * (t - t_1) - 0.5 * 9.81 * (t - t_1) ** 2]], [[v - 9.81 * (t - t_1)]])
    study = ns.convergence_study(ball, (0, t), *ball.state(height=1.0), dt=np.logspace(-3, -5, 9), reference=exact)
    shift = (1 + e) * 9.81 * t_1  # of the position, times the delay of the impact
    assert (study.errors("error_q") < 1.5 * shift * study.x).all()
    assert (
        study.errors("error_q").max() > 0.1 * shift * study.x.min()
    )  # and not closer than some of them come by chance


def test_errors_within_the_error_of_the_reference_are_unknown():
    pendulum = WallPendulum(th_w=-1.5)
    study = ns.convergence_study(
        pendulum, (0, 1), *pendulum.state(th=1.0), dt=[1e-2, 1e-3, 1e-4], reference=ns.MoreauJean(dt=1e-3)
    )
    errors = study.errors("error_q")
    assert np.isfinite(errors[0]) and np.isnan(errors[1:]).all()
    assert "below the floor" in study.table()


def test_run_that_fails_is_a_row_with_its_reason():
    ball = BouncingBall()
    study = ns.penalty_study(
        ball, (0, 0.6), *ball.state(height=1.0), stiffness=[1e8, 1e26], reference=([[0.0]], [[0.0]]), beside=[]
    )
    assert study.data.status.values.tolist() == [ns.CellStatus.FINISHED, ns.CellStatus.FAILED]
    assert "cannot be met in double precision" in study.table()


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"dt": [1e-3], "rtol": [1e-6]}, "either dt or rtol"),
        ({"rtol": [1e-6]}, "MoreauJean has no rtol: its steps have a fixed length; vary dt"),
        ({"dt": [1e-3], "integrator": ns.EventDriven}, "EventDriven has no dt: it controls its error; vary rtol"),
        ({"dt": [1e-3], "integrator": ns.Penalty(1e6)}, "Penalty has no dt"),
        ({"rtol": [1e-6], "integrator": ns.Penalty}, "Penalty needs further options"),
        ({"dt": [1e-3], "integrator": 3.0}, "must be an integrator, or make one of dt"),
        ({"dt": [1e-3], "integrator": lambda dt: dt}, "must be an integrator, or make one of dt"),
        ({"dt": []}, "dt must have at least one value"),
        ({"dt": [1e-3, -1e-3]}, "dt must be positive"),
        ({"dt": [1e-3], "delay": 0.1}, "needs a reference that locates its events"),
        ({"dt": [1e-3], "reference": ([[0.0]], [[0.0]]), "delay": 0.1}, "needs the events of a reference"),
        ({"integrator": ns.EventDriven, "delay": -0.1}, "delay must be positive"),
    ],
)
def test_integrator_and_what_is_varied_must_fit(options, words):
    ball = BouncingBall()
    with pytest.raises(ns.InvalidInput, match=words):
        ns.convergence_study(ball, (0, 0.1), *ball.state(height=1.0), **options)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"stiffness": [1e6, 1e5]}, "stiffness must increase"),
        ({"stiffness": [-1.0, 1e5]}, "stiffness must be positive"),
        ({"damping": 1.0, "damping_ratio": 0.1}, "either damping or damping_ratio"),
        ({"times": [2.0]}, "times must increase within"),
        ({"reference": ([0.0, 1.0], [0.0])}, "reference must be a pair of arrays"),
        ({"reference": 3.0}, "reference must be an integrator"),
    ],
)
def test_bad_input_is_refused_in_a_sentence(options, words):
    ball = BouncingBall()
    with pytest.raises(ns.InvalidInput, match=words):
        ns.penalty_study(ball, (0, 0.1), *ball.state(height=1.0), **{"stiffness": [1e6], "beside": [], **options})


def test_force_episode_needs_forces_and_a_contact_that_closes():
    ball = BouncingBall()
    rigid = ns.simulate(ball, (0, 0.1), *ball.state(height=1.0), integrator=ns.MoreauJean(1e-3))
    with pytest.raises(ns.InvalidInput, match="holds no contact forces"):
        ns.force_episode(rigid)
    flying = ns.simulate(ball, (0, 0.1), *ball.state(height=1.0), integrator=ns.Penalty(1e6))
    with pytest.raises(ns.InvalidInput, match="contact 0 never closes"):
        ns.force_episode(flying)


def test_force_episode_of_an_elastic_bounce():
    """Peak m v omega, duration pi/omega, impulse 2 m v and that of gravity, which changes the rest by g/(omega v)."""
    ball, k = BouncingBall(), 1e8
    run = ns.simulate(ball, (0, 0.6), *ball.state(height=1.0), integrator=ns.Penalty(k, rtol=1e-10))
    bounce = ns.force_episode(run)
    v, omega = math.sqrt(2 * 9.81), math.sqrt(k)
    assert abs(bounce.end - bounce.start - math.pi / omega) < 1e-3 * math.pi / omega
    assert abs(bounce.P_N - 2 * v - 9.81 * (bounce.end - bounce.start)) < 1e-7
    assert abs(bounce.restitution - 1) < 1e-6
    assert 0.99 * v * omega < bounce.peak_force < 1.001 * v * omega  # the highest of a few dozen recorded steps


@pytest.mark.upkeep
def test_figures_are_drawn(tmp_path):
    pytest.importorskip("matplotlib")
    ball = BouncingBall()
    limit = ns.penalty_study(ball, (0, 0.6), *ball.state(height=1.0), stiffness=[1e5, 1e6, 1e7], beside=[])
    step = ns.convergence_study(ball, (0, 0.4), *ball.state(height=1.0), dt=[1e-2, 1e-3])
    tolerance = ns.convergence_study(
        ball, (0, 0.6), *ball.state(height=1.0), integrator=ns.EventDriven, rtol=[1e-4, 1e-6]
    )
    decades = ns.penalty_study(ball, (0, 0.6), *ball.state(height=1.0), stiffness=np.logspace(4, 12, 9))
    for study, panels in ((limit, 3), (decades, 4), (step, 1), (tolerance, 2)):
        figure = study.plot(tmp_path / f"{study.of}.png")
        assert len(figure.axes) == panels and faults(figure) == []
        assert all(axes.lines for axes in figure.axes)
        assert (tmp_path / f"{study.of}.png").stat().st_size > 10_000


def test_errors_that_follow_no_power_have_no_law():
    k = np.logspace(4, 9, 6)
    scattered = np.array([1.0, 1e-3, 2.0, 1e-4, 0.5, 1e-2]) / k
    assert fit_laws("stiffness", k, scattered) == []
    misses = 1 / k * np.array([1, 1.2, 0.9, 1.1, 1.0, 0.95])
    assert fit_laws("stiffness", k, misses)[0].law == "k^-1"


def test_springs_that_give_back_more_than_the_rigid_contact_are_told():
    """A ball with e = 0 stays on the ground, an undamped spring throws it back; damped for the e that is meant, the
    limits are the same."""
    options = {"stiffness": [1e5, 1e6, 1e7], "beside": [], "progress": False, "restitution": "own"}
    span = (0, 0.6)
    ball = BouncingBall(e=0.0)
    study = ns.penalty_study(ball, span, *ball.state(height=1.0), **options)
    assert any("the limits differ: the springs give back e = 1" in note and "e_N = 0" in note for note in study.notes())
    assert "springs e = 1 (closed form); rigid contact e_N = 0\n" in study.table()
    ball = BouncingBall(e=1.0)
    assert ns.penalty_study(ball, span, *ball.state(height=1.0), **options).notes() == []


@pytest.mark.parametrize("law", ["clipped", "kelvin-voigt"])
@pytest.mark.parametrize("e", [0.9, 0.5, 0.3])
def test_springs_are_damped_for_the_restitution_of_the_rigid_contact(law, e):
    """The zeta of the closed form gives back e of a run as stiff as can be: gravity adds g pi/omega over the contact of
    velocity v, some 1e-4 of it at k = 1e10."""
    ball = BouncingBall(e=e)
    study = ns.penalty_study(
        ball, (0, 0.6), *ball.state(height=1.0), stiffness=[1e8, 1e10], penalty=ns.Penalty(1.0, law=law), beside=[]
    )
    assert np.allclose(study.data.e_springs, e, rtol=1e-9) and study.data.attrs["e_N"] == e
    assert abs(float(study.data.restitution[-1]) - e) < 1e-3
    assert study.orders("error_u")[-1] > 0.45 and study.notes() == []


def test_the_rigid_contact_takes_the_restitution_of_springs_whose_damping_is_given():
    """e = exp(-2 zeta arccos zeta/sqrt(1 - zeta^2)) in place of the model's 0.5; each keeps its own if asked to."""
    ball, zeta = BouncingBall(e=0.5), 0.3
    e = math.exp(-2 * zeta * math.acos(zeta) / math.sqrt(1 - zeta**2))
    options = {"stiffness": [1e8, 1e9, 1e10], "damping_ratio": zeta, "progress": False}
    equal = ns.penalty_study(ball, (0, 0.8), *ball.state(height=1.0), **options)
    assert abs(equal.data.attrs["e_N"] - e) < 1e-12 and equal.data.attrs["e_N_of_model"] == 0.5
    assert np.allclose(equal.orders("error_u"), 0.5, atol=0.02)
    assert (equal.data.beside_error_u[-1] < 1e-3).all()  # the rigid runs beside are those of the same contact
    assert (
        f"springs e = {e:.3g} (closed form); rigid contact e_N = {e:.3g}, in place of the model's 0.5" in equal.table()
    )
    own = ns.penalty_study(ball, (0, 0.8), *ball.state(height=1.0), restitution="own", beside=[], **options)
    v = math.sqrt(2 * 9.81)
    assert np.allclose(own.errors("error_u")[-1], abs(e - 0.5) * v, rtol=0.01) and len(own.notes()) == 1


def test_a_restitution_without_closed_form_is_measured():
    """Hunt-Crossley springs keep r v - ln(1 + r v) over the contact, r = c/k: the rigid ball takes the e that they
    have at the velocity of the first impact."""
    from scipy.optimize import brentq

    ball, k, r, v = BouncingBall(e=0.5), 1e10, 0.1, math.sqrt(2 * 9.81)
    integral = lambda w: r * w - math.log1p(r * w)
    e = brentq(lambda e: integral(-e * v) - integral(v), 0.0, 1.0)
    study = ns.penalty_study(
        ball, (0, 0.6), *ball.state(height=1.0), stiffness=[k], damping=r * k, beside=[],
        penalty=ns.Penalty(1.0, law="hunt-crossley"),
    )  # fmt: skip
    assert abs(study.data.attrs["e_N"] - e) < 1e-3 and "measured at the stiffest" in study.table()


def test_a_contact_that_gives_back_nothing_is_met_by_the_least_that_a_damper_gives():
    ball = BouncingBall(e=0.0)
    study = ns.penalty_study(ball, (0, 1.0), *ball.state(height=1.0), stiffness=[1e6, 1e8], beside=[])
    assert np.allclose(study.data.e_springs, 0.01) and study.data.attrs["e_N"] == 0.0
    assert "springs e = 0.01" in study.table() and study.orders("error_q")[0] > 0.9  # at rest: g/k


def test_a_bilateral_contact_has_no_restitution():
    rod = SpragSlip()
    study = ns.penalty_study(rod, (0, 0.05), *rod.state(th=0.78, thdot=1.0), stiffness=[1e6], beside=[])
    assert "restitution" not in study.data.attrs and "e_springs" not in study.data


def test_a_motion_of_too_many_events_for_its_reference_is_refused_where_nothing_was_chosen():
    """Forty beads collide 11 000 times in the first second; a study that is asked for its stiffness does begin."""
    beads = BeadChain(n=40)
    with pytest.raises(ns.InvalidInput, match="needs more than .* steps: it came to t = .* end the motion earlier"):
        ns.penalty_study(beads, (0, 2.0), *beads.state(), progress=False)


def test_errors_have_the_units_of_the_coordinates_in_data_and_on_axes():
    """Metres alone where there are no radians; both of a rod; where nobody named them, none."""
    ball, rod = BouncingBall(), PainleveRod(mu=0.3)
    for model, of_q, of_u in ((ball, "m", "m/s"), (rod, "m, rad", "m/s, rad/s")):
        study = ns.convergence_study(model, (0, 0.05), *model.state(), dt=[1e-2, 5e-3], progress=False)
        assert (study.data.error_q.units, study.data.error_u.units) == (of_q, of_u)
        assert f"[{of_q}; {of_u}]" in study.plot().axes[0].get_ylabel()
    bare = dataclasses.replace(ball.system(), parameters=ParametersAlone())
    study = ns.convergence_study(bare, (0, 0.05), [1.0], [0.0], dt=[1e-2, 5e-3], progress=False)
    assert "units" not in study.data.error_q.attrs and "[units of the coord" in study.plot().axes[0].get_ylabel()


class ParametersAlone(NamedTuple):
    """Of the ball, which name no coordinates."""

    m: float = 1.0
    g: float = 9.81
    e: float = 0.5


def test_a_figure_tells_kinds_of_error_apart_in_grey_and_gives_no_space_to_what_is_below_the_floor():
    """Velocities of a ball on springs of its own restitution are those of the rigid one: errors of rounding alone."""
    ball = BouncingBall()
    study = ns.penalty_study(ball, (0, 2.0), *ball.state(), stiffness=[1e4, 1e6, 1e8], progress=False)
    hidden = study.data.error_u.values[:, -1][np.isnan(study.errors("error_u"))]
    figure = study.plot()
    assert figure.get_suptitle().startswith("bouncing-ball: the penalty limit\nm = 1  g = 9.81  e = 0.5\n")
    axes = figure.axes[0]
    kinds = {line.get_label().split(",")[0]: line.get_linestyle() for line in axes.lines if "t=2" in line.get_label()}
    assert kinds["coordinates"] != kinds["velocities"] and faults(figure) == []
    least = min(np.nanmin(study.errors(name)) for name in ("error_q", "error_u"))
    assert 0 < hidden.min() < 1e-4 * least and axes.get_ylim()[0] > 1e-4 * least


def wall_pendulum(impact):
    """A pendulum that strikes a rough wall: the rebound turns its slide along the wall round."""

    class Parameters(NamedTuple):
        l: float = 0.5
        a: float = 0.2
        mu: float = 0.3
        e: float = 0.6

    def mass(t, q, p, M):
        M[0, 0] = p.l**2

    def force(t, q, u, p, h):
        h[0] = -9.81 * p.l * math.sin(q[0])

    def gap(t, q, p, g_N):
        g_N[0] = p.a - p.l * math.sin(q[0])

    def tangent(t, q, p, W_F):
        W_F[0, 0, 0] = p.l * math.sin(q[0])

    return ns.System(
        coordinates=[("th", "rad")], mass=mass, force=force, gap=gap, tangent=tangent, parameters=Parameters(),
        contacts=[ns.Contact(mu="mu", e_N="e", impact=impact, name="wall")],
    )  # fmt: skip


@pytest.mark.filterwarnings("ignore::nonsmooth.FrictionGainWarning")
def test_a_study_says_that_friction_drives_its_rigid_reference():
    options = {"state": {"th": -0.9}, "stiffness": [1e6, 1e8, 1e10], "progress": False, "beside": []}
    driven = ns.penalty_study(wall_pendulum("newton"), (0, 1), **options)
    (note,) = driven.notes()
    assert "rigid reference friction did work in" in note and "impact='energetic'" in note.replace('"', "'")
    assert note in driven.table() and driven.data.error_q.values[-1, -1] > 0.01  # they part
    followed = ns.penalty_study(wall_pendulum("energetic"), (0, 1), **options)
    assert not any("friction" in note for note in followed.notes())
    assert followed.data.error_q.values[-1, -1] < 1e-3


def test_a_study_says_that_springs_of_bilateral_contacts_have_no_damper():
    rod = SpragSlip()
    options = {"stiffness": [1e5, 1e6, 1e7], "progress": False, "beside": []}
    rings = ns.penalty_study(rod, (0, 0.1), *rod.state(), **options)
    assert any("have no damper and vibrate" in note and "damping_ratio=1" in note for note in rings.notes())
    damped = ns.penalty_study(rod, (0, 0.1), *rod.state(), damping_ratio=1.0, **options)
    assert not any("damper" in note for note in damped.notes())
    assert (damped.data.error_u.values[-1] < rings.data.error_u.values[-1]).all()
