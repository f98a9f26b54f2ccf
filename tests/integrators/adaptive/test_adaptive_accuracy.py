"""Adaptive Moreau–Jean: what its tolerance promises over the scenes, and random starts.

The table of docs/theory/adaptive.md is made by docs/figures/adaptive.py, with the same error.
"""

import numpy as np
import pytest

import nonsmooth as ns
from benchmarks.motions import bilateral_motions, motions, random_motion
from models import SliderCrank, SpragSlip

pytestmark = pytest.mark.filterwarnings("ignore::nonsmooth.SimultaneousImpactWarning")  # of the slider-crank

SCENES = motions() | bilateral_motions()
MOST = 10.0  # tolerances; a step is held to one, and what events leave grows on the way: 6.5 is the largest measured
TOLERANCES = 10.0 ** -np.arange(4.0, 10.5, 0.5)


@pytest.fixture(scope="module", params=SCENES)
def known(request):
    """A scene, 101 times, and the positions there: closed forms, else events at 1e-12, which agree with an explicit
    method and modes by hand (tests/integrators/event_driven/test_event_driven_by_hand.py)."""
    model, start, t_end = SCENES[request.param]
    t = np.linspace(0.0, t_end, 101)
    exact = {
        "ball through Zeno": lambda t: [model.height(t)],
        "sliding block": lambda t: [model.position(t), 0.0],
        "bead chain": lambda t: model.exact(t)[0],
    }.get(request.param)
    state = model.state(**start)
    if exact is not None:
        return model, state, t, np.array([exact(moment) for moment in t])
    return (
        model,
        state,
        t,
        ns.simulate(model, (0.0, t_end), *state, integrator=ns.EventDriven(1e-12, 1e-14), t_eval=t).q,
    )


@pytest.mark.parametrize("method", [ns.Adaptive, ns.EventDriven])
def test_error_follows_the_tolerance(known, method):
    """Largest error of the coordinates, in rtol (1e-2 + max |q|): at every tolerance, since impacts that follow one
    another closely are met at some of them."""
    model, state, t, exact = known
    scale = 1e-2 + np.abs(exact).max(axis=0)
    errors = {}
    for rtol in TOLERANCES:
        sol = ns.simulate(model, (0.0, t[-1]), *state, integrator=method(rtol, 1e-2 * rtol), t_eval=t)
        errors[rtol] = (np.abs(sol.q - exact) / scale).max() / rtol
    assert {rtol: error for rtol, error in errors.items() if not error < MOST} == {}


@pytest.mark.parametrize(
    ("model", "period", "transient"),
    [(SpragSlip.set_1(cth=0.5), 0.377442788, 6.0), (SpragSlip(), 0.460134276, 2.0)],
    ids=["limit cycle", "seizure orbit"],
)
def test_sprag_slip_orbits_return_after_their_printed_period(model, period, transient):
    """A period known to 5e-10 s moves the state by 5e-10 s times the velocity; the transient has died out by then."""
    t = [transient, transient + period]
    sol = ns.simulate(
        model, (0.0, t[1]), *model.state(th=0.8, thdot=0.0), integrator=ns.Adaptive(1e-10, 1e-12), t_eval=t
    )
    assert np.abs(sol.q[-1] - sol.q[-2]).max() < 1e-9 * np.abs(sol.u[-1]).max() + 50e-10 * np.abs(sol.q[-1]).max()


# Newton's law of impact may gain energy where e_N > 0 beside friction, as of some of the random rods and blocks
GAINING = pytest.mark.filterwarnings("ignore::nonsmooth.EnergyGainWarning")


def reaches_its_end(seed):
    """One random run; no unilateral gap is deeper than the tolerance."""
    rng = np.random.default_rng(seed)
    model, start, t_end = random_motion(rng)
    rtol = 10.0 ** rng.uniform(-10, -3)
    sol = ns.simulate(model, (0.0, t_end), *start, integrator=ns.Adaptive(rtol, 1e-2 * rtol), on_failure="return",
                      max_wall_time=60.0)  # fmt: skip
    deepest = rtol * (1e-2 + np.abs(sol.q).max()) * 2.0  # |W_N| is at most 2 in these models
    return sol.success and np.isfinite(sol.q).all() and sol.g_N.min() > -deepest


@pytest.mark.upkeep
@GAINING
def test_random_starts_reach_their_end():
    assert [seed for seed in range(60) if not reaches_its_end(seed)] == []


@GAINING
@pytest.mark.stress
def test_many_random_starts_reach_their_end():
    assert [seed for seed in range(100, 1100) if not reaches_its_end(seed)] == []


def test_slider_crank_is_no_chaotic_problem():
    """Over its whole span, 3 turns with 167 impacts, errors of the start grow by a factor: 100 that of the tilt, less
    than 30 any other, whether they are 1e-7 or 1e-8. Coordinates in 1e-2 + max |q|."""
    crank = SliderCrank()
    q0, u0 = crank.state()
    start, t = np.concatenate((q0, u0)), np.linspace(0.0, 0.2, 401)

    def motion(x):
        sol = ns.simulate(crank, (0.0, 0.2), x[:3], x[3:], integrator=ns.EventDriven(1e-11, 1e-13), t_eval=t)
        return sol.q

    exact = motion(start)
    scale = 1e-2 + np.abs(exact).max(axis=0)
    for k in range(6):
        size = max(1.0, abs(start[k]))
        growth = [
            np.abs((motion(start + eps * size * np.eye(6)[k]) - exact) / scale).max() / eps for eps in (1e-7, 1e-8)
        ]
        assert growth[0] == pytest.approx(growth[1], rel=0.02, abs=0.1) and growth[0] < (110.0 if k == 2 else 30.0)
