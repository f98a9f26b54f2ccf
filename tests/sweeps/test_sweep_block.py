"""Runs in compiled blocks: the same bits as `simulate`, whatever the block, the worker and the order."""

from __future__ import annotations

import math
import pickle
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
import pytest
import xarray as xr

import nonsmooth as ns
from models.bead_chain import BeadChain
from models.belt_oscillator import BeltOscillator
from models.bilateral_rod import BilateralRod
from models.bouncing_ball import BouncingBall
from models.painleve_rod import PainleveRod
from models.pendulum import WallPendulum
from models.rocking_block import RockingBlock
from models.spatial_painleve_rod import SpatialPainleveRod
from models.sprag_slip import SpragSlip
from nonsmooth.integrators.records import Counters, State, Worst
from nonsmooth.jit import interpreted
from nonsmooth.jit.blocks import fields_of, new
from nonsmooth.mechanics.contact_problem import Work, model_facts
from nonsmooth.mechanics.initial_modes import ADMISSIBLE, initial_modes
from nonsmooth.mechanics.initial_state import examine_state
from nonsmooth.mechanics.sys import new_sys
from nonsmooth.mechanics.system import Contact, System
from nonsmooth.results.stats import Stats
from nonsmooth.sweeps import block_engine
from nonsmooth.sweeps.block_engine import BlockEngine
from nonsmooth.sweeps.run_rows import RowBuilder

pytestmark = pytest.mark.filterwarnings("ignore::nonsmooth.UnsettledWarning")  # runs are short: their bits are compared
STARTED = {"q0": [0.3], "u0": [0.0]}
EVERYTHING = ["final_state", "amplitude", "period", "modes", "paradoxes", "impacts", "mode_changes", "residual"]
SCENES = {
    "belt": (BeltOscillator(), 4.0, 1e-2, {"vb": [0.1, 0.42], "m1": [0.0, 0.45], "x": [0.0, 0.05]}),
    "rod": (PainleveRod(), 0.3, 1e-3, {"mu": [0.5, 1.8], "l": [1.0, 2.0], "th": [0.5, 1.0]}),
    "sprag-slip": (SpragSlip(), 0.4, 1e-3, {"mu": [0.5, 1.5], "th": [0.6, 0.78], "dt": [1e-3, 5e-4]}),
    "bilateral rod": (BilateralRod(), 0.2, 1e-3, {"mu": [0.3, 0.8], "slip": [-1.0, 1.0]}),
    "rocking block": (RockingBlock(), 0.5, 1e-3, {"e": [0.0, 0.5], "tilt": [0.05, 0.1]}),
}


ADAPTED = (ns.Adaptive(1e-6, 1e-8), ns.EventDriven(1e-6, 1e-8), ns.Penalty(1e5, damping_ratio=0.5, rtol=1e-5))


@pytest.mark.parametrize("name", SCENES)
def test_a_cell_has_the_bits_of_a_run_by_itself(name):
    model, t_end, dt, axes = SCENES[name]
    require_equal_runs(model, t_end, ns.MoreauJean(dt), axes)


@pytest.mark.parametrize("integrator", ADAPTED, ids=lambda integrator: type(integrator).__name__)
@pytest.mark.parametrize("name", ["belt", "sprag-slip", "rocking block"])
def test_a_cell_of_steps_of_chosen_length_has_the_bits_of_a_run_by_itself(name, integrator, monkeypatch):
    """The rows of the runs do not fit into the first record: it grows."""
    monkeypatch.setattr(block_engine, "ROW_CAPACITY", 16)
    model, t_end, _, axes = SCENES[name]
    require_equal_runs(model, t_end, integrator, {key: values for key, values in axes.items() if key != "dt"})


def require_equal_runs(model, t_end, given, axes):
    """Every cell of a sweep is the run of its values, by all measures."""
    task = ns.RunTask(model, EVERYTHING, t_span=(0, t_end), integrator=given)
    assert task.is_block
    found = ns.sweep(task, axes, progress=False)
    assert (found.status == ns.Status.FINISHED).all()
    for cell in np.ndindex(*found.status.shape):
        values = {axis: axes[axis][k] for axis, k in zip(axes, cell, strict=True)}
        fields = {key: value for key, value in values.items() if hasattr(model, key) and key != "dt"}
        state = {key: value for key, value in values.items() if key not in fields and key != "dt"}
        varied = type(model)(**fields)
        integrator = replace(given, dt=values["dt"]) if "dt" in values else given
        alone = ns.simulate(varied, (0, t_end), *varied.state(**state), integrator=integrator)
        expected = {}
        for measure in task.measures.values():
            expected |= measure.of_solution(alone, int(np.searchsorted(alone.t, t_end / 2)))
        for key, value in expected.items():
            here = found[key].values[cell]
            assert here == value if isinstance(value, str) else np.array_equal(here, value, equal_nan=True), (key, cell)


def test_cells_depend_on_no_block_worker_or_order():
    """A row of contacts whose solver begins from the step before: what a cell leaves behind must not reach the next."""
    axes = {"mu": np.linspace(0.1, 1.5, 7), "tilt": np.linspace(0.02, 0.2, 5)}
    task = ns.RunTask(RockingBlock(), EVERYTHING, t_span=(0, 0.4), integrator=ns.MoreauJean(1e-3))
    whole = ns.sweep(task, axes, progress=False, batch=35)
    for options in ({"batch": 1}, {"batch": 4}, {"workers": 2}, {"workers": 2, "batch": 3}):
        xr.testing.assert_identical(whole, ns.sweep(task, axes, progress=False, **options))
    backwards = ns.sweep(task, {name: values[::-1] for name, values in axes.items()}, progress=False)
    xr.testing.assert_equal(whole, backwards.isel(mu=slice(None, None, -1), tilt=slice(None, None, -1)))


def test_compiled_block_and_its_source_agree(monkeypatch):
    axes = {"mu": [0.5, 1.8], "th": [0.5, 1.0]}
    task = ns.RunTask(PainleveRod(), EVERYTHING, t_span=(0, 0.05), integrator=ns.MoreauJean(1e-3))
    compiled = ns.sweep(task, axes, progress=False)
    monkeypatch.setenv("NONSMOOTH_INTERPRET", "1")
    task = ns.RunTask(PainleveRod(), EVERYTHING, t_span=(0, 0.05), integrator=ns.MoreauJean(1e-3))
    source = ns.sweep(task, axes, progress=False)
    for name in ("modes", "paradoxes", "impacts", "status"):
        assert (compiled[name] == source[name]).all()
    np.testing.assert_allclose(compiled.q, source.q, rtol=1e-12, atol=1e-14)


MODELS = (BeltOscillator(), PainleveRod(), BilateralRod(), RockingBlock(), WallPendulum(), BeadChain())


@pytest.mark.parametrize("model", MODELS, ids=lambda model: model.name)
def test_modes_at_a_start_are_those_that_simulate_finds(model):
    system = model.system()
    rng = np.random.default_rng(3)
    n, n_c, d = system.n_u, system.n_c, system.d
    q_0, u_0 = model.state()
    for trial in range(40):
        q = q_0 + (0 if trial % 2 else 0.1) * rng.standard_normal(n)
        u = u_0 * (trial % 3) + (trial % 5 == 0) * rng.standard_normal(n)
        expected = examine_state(system, 0.0, q, u)
        state = new(State, n=n, n_c=n_c, d=d, capacity=1)
        work = new(Work, n=n, n_c=n_c, d=d)
        state.q[:], state.u[:] = q, u
        sys = new_sys(system, in_python(system), model_facts(system))
        verdict = interpreted(initial_modes)(sys, 0.0, state, work)
        assert (verdict == ADMISSIBLE) == expected.is_admissible
        assert state.mode.tolist() == expected.mode.tolist() and state.slip.tolist() == expected.slip.tolist()


def in_python(system):
    def model(which, t, q, u, p, out):
        out[...] = system.evaluate(which, t, q, u)

    return model


class Guides(NamedTuple):
    """A bar held by three guides in a line, pulled sideways above them: their forces are not determined."""

    mu: float = 0.5
    pull: float = 20.0  # N/s
    height: float = 1.4  # m of the rails above the centre
    lever: float = -0.33  # m of the pull


def guided_bar():
    def mass(t, q, p, M):
        M[0, 0] = M[1, 1] = 1.0
        M[2, 2] = 0.3

    def force(t, q, u, p, h):
        h[0] = p.pull * t
        h[1] = -9.81
        h[2] = -p.pull * t * p.lever

    def gap(t, q, p, g_N):
        for i in range(3):
            g_N[i] = q[1] + (i - 1.0) * q[2]

    def normal(t, q, p, W_N):
        for i in range(3):
            W_N[i, 1] = 1.0
            W_N[i, 2] = i - 1.0

    def tangent(t, q, p, W_F):
        for i in range(3):
            W_F[i, 0, 0] = 1.0
            W_F[i, 0, 2] = p.height

    contacts = [Contact(mu="mu", bilateral=True)] * 3
    return System(n_q=3, mass=mass, force=force, gap=gap, normal=normal, tangent=tangent, contacts=contacts,
                  parameters=Guides())  # fmt: skip


def test_a_run_that_needs_what_redundant_contacts_need_gets_it(monkeypatch):
    asked = []
    load = ns.MoreauJean.load_for_retry
    monkeypatch.setattr(ns.MoreauJean, "load_for_retry", lambda *args: asked.append(args) or load(*args))
    system, integrator = guided_bar(), ns.MoreauJean(1e-2)
    task = ns.RunTask(system, ["final_state", "modes"], t_span=(0, 1), integrator=integrator,
                      state={"q0": np.zeros(3), "u0": [-0.4, 0, 0]})  # fmt: skip
    found = ns.sweep(task, {"mu": [0.2, 0.5], "pull": [5.0, 20.0]}, progress=False)
    assert asked
    for i, mu in enumerate((0.2, 0.5)):
        for k, pull in enumerate((5.0, 20.0)):
            varied = system.with_parameters(mu=mu, pull=pull)
            alone = ns.simulate(varied, (0, 1), np.zeros(3), [-0.4, 0, 0], integrator=integrator)
            assert np.array_equal(found.u.values[i, k], alone.u[-1]) and alone.success
            assert found.modes.values[i, k] == task.measures["modes"].of_solution(alone, 0)["modes"]


@dataclass(frozen=True)
class Sledge:
    """A block whose contact has no friction at all where mu = 0: the shape of its system depends on a field."""

    mu: float = 0.2
    n: int = 1

    t_end, dt = 0.1, 1e-3

    def system(self):
        def mass(t, q, p, M):
            M[0, 0] = 1.0
            M[1, 1] = 1.0

        def force(t, q, u, p, h):
            h[1] = -9.81

        def gap(t, q, p, g_N):
            g_N[0] = q[1]

        def normal(t, q, p, W_N):
            W_N[0, 1] = 1.0

        def tangent(t, q, p, W_F):
            W_F[0, 0, 0] = 1.0

        friction = {"tangent": tangent} if self.mu else {}
        return System(n_q=2, mass=mass, force=force, gap=gap, normal=normal, contacts=[Contact(mu=self.mu)],
                      parameters=self, **friction)  # fmt: skip

    def state(self, speed=1.0):
        return np.zeros(2), np.array([speed * self.n, 0.0])


def test_a_model_whose_system_reads_a_swept_field_is_built_for_each_value():
    sledge = Sledge()
    assert not RowBuilder(sledge, {}).is_direct({"mu": np.array([0.1, 0.2])})
    found = ns.sweep(ns.RunTask(sledge), {"mu": [0.0, 0.2, 0.5], "speed": [1.0, 2.0]}, progress=False)
    mu, speed = np.array([0.0, 0.2, 0.5])[:, None], np.array([1.0, 2.0])
    # constant deceleration is integrated exactly by the mid-point rule; 100 sums of order 1 round by 100 eps
    np.testing.assert_allclose(found.u.values[..., 0], speed - mu * 9.81 * 0.1, atol=100 * np.finfo(float).eps * 2)


def test_a_whole_field_takes_whole_numbers_and_sets_the_size():
    chain = BeadChain()
    task = ns.RunTask(chain, "impacts", t_span=(0, 0.5), integrator=ns.MoreauJean(1e-3))
    found = ns.sweep(task, {"n": [2, 3, 4]}, progress=False)
    for n, impacts in zip((2, 3, 4), found.impacts.values, strict=True):
        alone = BeadChain(n=n)
        run = ns.simulate(alone, (0, 0.5), *alone.state(), integrator=ns.MoreauJean(1e-3))
        assert impacts == sum(event.kind == ns.EventKind.IMPACT for event in run.events)
    listed = ns.sweep(ns.RunTask(chain, t_span=(0, 0.1)), {"n": [chain.n, chain.n + 1]}, progress=False)
    assert listed.status.values.tolist() == [ns.CellStatus.FINISHED, ns.CellStatus.FAILED]
    assert "coordinates" in str(listed.message.values[1])
    halves = ns.sweep(task, {"n": [2.0, 2.5]}, progress=False)
    assert halves.status.values.tolist() == [ns.CellStatus.FINISHED, ns.CellStatus.FAILED]


def test_amplitude_and_period_of_a_free_oscillator():
    """Without friction and damping the step is the trapezoidal rule: w_dt = (2/dt) atan(w dt/2), amplitude kept."""
    dt, amplitude = 1e-2, 0.3
    belt = BeltOscillator(c=0.0, m0=0.0, m1=0.0, m3=0.0)
    task = ns.RunTask(belt, ["amplitude", "period"], t_span=(0, 30), integrator=ns.MoreauJean(dt), state={"x": 0.3})
    found = ns.sweep(task, {"k": [5.0, 10.0, 40.0], "m": [1.0, 2.0]}, progress=False)
    omega = np.sqrt(np.array([5.0, 10.0, 40.0])[:, None] / np.array([1.0, 2.0]))
    period = math.pi * dt / np.arctan(omega * dt / 2)
    # the extremes stand between two records: (1 - cos(w dt/2)) of the amplitude is missed at most
    missed = amplitude * (1 - np.cos(omega * dt / 2))
    assert (np.abs(found.amplitude.values[..., 0] - amplitude) <= missed + 1e-12).all()
    # a crossing is interpolated linearly, off by at most (w dt)^2 / 8 of a step, and by the shift of the middle
    error = 2 * ((omega * dt) ** 2 / 8 * dt + missed / (amplitude * omega))
    assert (np.abs(found.period.values[..., 0] - period) <= error).all()


class Damped(NamedTuple):
    c: float = 1.0  # damping of a unit mass, of either sign [N s/m]
    k: float = 400.0  # stiffness [N/m]


def damped_oscillator():
    def mass(t, q, p, M):
        M[0, 0] = 1.0

    def force(t, q, u, p, h):
        h[0] = -p.k * q[0] - p.c * u[0]

    return System(n_q=1, mass=mass, force=force, parameters=Damped())


@pytest.mark.filterwarnings("error::nonsmooth.UnsettledWarning")
@pytest.mark.parametrize("integrator", [ns.MoreauJean(1e-2), ns.EventDriven()], ids=["fixed", "chosen"])
@pytest.mark.parametrize("c", [0.0, 1.0, -0.5])
def test_an_amplitude_of_a_motion_that_has_not_settled_is_told(c, integrator):
    """Extremes of x go as exp(-c t/2): the range over the later half of a window of length T is smaller by
    1 - exp(-c T/4), that of a growing motion over the earlier one; which extremes fall into it adds half a period."""
    task = ns.RunTask(damped_oscillator(), "amplitude", t_span=(0, 4), integrator=integrator, state=STARTED)
    if c == 0.0:  # the records miss less than (w dt)^2/8 = 0.005 of an extreme
        assert (ns.sweep(task, {"c": [c]}, progress=False).amplitude_change < 0.005).all()
        return
    with pytest.warns(ns.UnsettledWarning, match="the amplitude still changes in 1 of 1 cells, by up to"):
        found = ns.sweep(task, {"c": [c]}, progress=False)
    period, T = 2 * math.pi / 20, 2.0
    assert found.amplitude_change.item() == pytest.approx(1 - math.exp(-abs(c) * T / 4), abs=abs(c) * period / 2)


def test_a_window_shorter_than_the_period_shows_no_amplitude():
    task = ns.RunTask(damped_oscillator(), "amplitude", t_span=(0, 4), integrator=ns.MoreauJean(1e-2), state=STARTED,
                      window=0.97)  # fmt: skip
    with pytest.warns(ns.UnsettledWarning, match="repeat more slowly"):
        ns.sweep(task, {"c": [0.0]}, progress=False)


class Driven(NamedTuple):
    c: float = 0.5  # damping of a unit mass [N s/m]
    F: float = 1.0  # of cos 2 t [N]


def driven_oscillator():
    def mass(t, q, p, M):
        M[0, 0] = 1.0

    def force(t, q, u, p, h):
        h[0] = p.F * math.cos(2.0 * t) - q[0] - p.c * u[0]

    return System(n_q=1, mass=mass, force=force, parameters=Driven())


@pytest.mark.parametrize("measures", [["amplitude", "period"], ["amplitude", "period", lambda sol: sol.t[-1]]],
                         ids=["blocks", "one by one"])  # fmt: skip
def test_runs_are_made_longer_until_they_have_settled(measures):
    """x = F cos(2 t - phi)/sqrt(9 + 4 c^2) + exp(-c t/2) ...: the amplitude to about the part that was asked for;
    damping of 0.01 1/s has not done its work by 200 s, and the cell says so."""
    task = ns.RunTask(driven_oscillator(), measures, t_span=(0, 25), integrator=ns.MoreauJean(1e-2), settle=0.01,
                      settle_by=200.0, state={"q0": [3.0], "u0": [0.0]})  # fmt: skip
    c = np.array([1.0, 0.3, 0.2, 0.01])
    with pytest.warns(ns.UnsettledWarning, match=r"these motions have not settled to 0.01"):
        found = ns.sweep(task, {"c": c}, progress=False)
    assert found.settled.values.tolist() == [1, 1, 1, 0] and found.attrs["cells_unsettled"] == 1
    exact = 1 / np.sqrt(9 + 4 * c**2)
    ends = found.end_time.values
    assert ends[-1] == 200.0 and ends[0] < 200.0 and (np.diff(ends) >= 0).all()
    np.testing.assert_allclose(found.amplitude.values[:3, 0], exact[:3], rtol=0.02)
    np.testing.assert_allclose(found.period.values[:3, 0], math.pi, rtol=0.01)
    if len(measures) == 2:  # the last of them alone, that long: the same bits
        alone = ns.RunTask(driven_oscillator(), measures, t_span=(0, ends[2]), integrator=ns.MoreauJean(1e-2),
                           state={"q0": [3.0], "u0": [0.0]})  # fmt: skip
        np.testing.assert_array_equal(ns.sweep(alone, {"c": c[2:3]}, progress=False).amplitude, found.amplitude[2:3])


@pytest.mark.parametrize("integrator", [ns.MoreauJean(1e-2), ns.Adaptive(1e-7), ns.EventDriven(1e-6)],
                         ids=lambda one: type(one).__name__)  # fmt: skip
def test_a_run_that_goes_on_takes_no_step_twice_and_has_the_bits_of_one_long_run(integrator, monkeypatch):
    """The state is that of one run as long as the longest, in the record of the time where the motion has settled."""
    counted, run = [], BlockEngine.run

    def counting(engine, cells):
        refused = run(engine, cells)
        counted.append(cells.counters[:, list(fields_of(Counters)).index("steps")].copy())
        return refused

    monkeypatch.setattr(BlockEngine, "run", counting)
    start, c = {"q0": [3.0], "u0": [0.0]}, [1.0, 0.3, 0.2]
    measures = ["amplitude", "period", "final_state"]
    task = ns.RunTask(
        driven_oscillator(), measures, t_span=(0, 25), integrator=integrator, settle_by=200.0, state=start
    )
    found = ns.sweep(task, {"c": c}, progress=False)
    ends = found.end_time.values
    assert found.settled.values.tolist() == [1, 1, 1] and ends[0] < ends[-1]
    steps = np.concatenate(counted)
    for k, value in enumerate(c):
        system = driven_oscillator().with_parameters(c=value)
        alone = ns.simulate(system, (0, 200.0), state=start, integrator=integrator)
        m = int(np.searchsorted(alone.t, ends[k] * (1 - 1e-12)))
        assert steps[k] == m  # a record a step
        np.testing.assert_array_equal(found.q.values[k], alone.q[m])
        np.testing.assert_array_equal(found.u.values[k], alone.u[m])
        assert ends[k] == pytest.approx(alone.t[m], rel=1e-12)


def test_runs_that_go_on_are_those_made_again_longer_to_the_bit():
    """In blocks and one by one, of a motion with sticking; the second of them starts each longer run anew."""
    found = []
    for more in ([], [lambda sol: sol.t[-1]]):
        task = ns.RunTask(BeltOscillator(), ["amplitude", "period", "modes", "impacts", "final_state", *more],
                          t_span=(0, 20), integrator=ns.MoreauJean(1e-2), settle_by=300.0)  # fmt: skip
        found.append(ns.sweep(task, {"vb": [0.1, 0.2, 0.3]}, progress=False))
    assert (found[0].settled == 1).all() and len(set(found[0].end_time.values.tolist())) > 1
    for name in ("amplitude", "period", "q", "u", "modes", "impacts", "end_time"):
        np.testing.assert_array_equal(found[0][name].values, found[1][name].values)


def test_a_period_that_grows_has_not_settled():
    """A damped oscillator of constant period but growing amplitude settles in its period alone; one crossing in the
    window tells no period."""
    task = ns.RunTask(damped_oscillator(), "period", t_span=(0, 4), integrator=ns.MoreauJean(1e-3), state=STARTED)
    found = ns.sweep(task, {"c": [0.0]}, progress=False)
    assert found.settled.values.tolist() == [1] and found.period_change.values.max() < 1e-3
    short = ns.RunTask(damped_oscillator(), "period", t_span=(0, 0.7), integrator=ns.MoreauJean(1e-3), state=STARTED)
    with pytest.warns(ns.UnsettledWarning, match="the period still changes in 1 of 1 cells"):
        found = ns.sweep(short, {"c": [0.0]}, progress=False)
    assert found.settled.values.tolist() == [0]


def test_a_mass_at_rest_has_no_period():
    task = ns.RunTask(BeltOscillator(vb=0.0), ["amplitude", "period"], t_span=(0, 1), integrator=ns.MoreauJean(1e-2))
    found = ns.sweep(task, {"x": [0.0]}, progress=False)
    assert found.amplitude.item() == 0.0 and np.isnan(found.period.item())


def test_the_state_may_be_varied_entry_by_entry():
    belt = BeltOscillator()
    task = ns.RunTask(belt, t_span=(0, 0.5), integrator=ns.MoreauJean(1e-2))
    by_name = ns.sweep(task, {"x": [0.0, 0.1], "velocity": [0.0, 0.2]}, progress=False)
    by_entry = ns.sweep(task, {"q0[0]": [0.0, 0.1], "u0[0]": [0.0, 0.2]}, progress=False)
    np.testing.assert_array_equal(by_name.q.values, by_entry.q.values)
    whole = ns.RunTask(belt.system(), t_span=(0, 0.5), integrator=ns.MoreauJean(1e-2), state={"q0": [0.1], "u0": [0.2]})
    np.testing.assert_array_equal(ns.sweep(whole, {"vb": [0.2]}, progress=False).q.values[0], by_name.q.values[1, 1])


def test_a_cell_out_of_range_fails_alone():
    task = ns.RunTask(PainleveRod(), ["paradoxes", "final_state"], t_span=(0, 0.01))
    found = ns.sweep(task, {"mu": [-0.5, 0.5], "th": [0.5, 1.0]}, progress=False)
    assert found.status.values.tolist() == [[ns.CellStatus.FAILED] * 2, [ns.CellStatus.FINISHED] * 2]
    assert "mu must not be negative" in str(found.message.values[0, 0])
    assert np.isnan(found.q.values[0]).all() and np.isfinite(found.q.values[1]).all()
    assert found.attrs["cells_failed"] == 2


def test_rules_between_two_fields_hold_cell_by_cell():
    """Stribeck's law asks for m0 >= mu_k: neither axis alone breaks the rule."""
    task = ns.RunTask(BeltOscillator(law="stribeck"), t_span=(0, 0.1), integrator=ns.MoreauJean(1e-2))
    m0, mu_k = np.array([0.2, 0.3, 0.4]), np.array([0.1, 0.25, 0.35])
    found = ns.sweep(task, {"m0": m0, "mu_k": mu_k}, progress=False)
    np.testing.assert_array_equal(found.status == ns.CellStatus.FAILED, m0[:, None] < mu_k)
    assert "m0 - mu_k must not be negative" in str(found.message.values[0, 1])


def test_a_run_that_stops_says_where():
    """mu(v) = m0 - m1 v becomes negative above v = m0/m1: the law of a cell, not of the sweep."""
    task = ns.RunTask(BeltOscillator(m3=0.0), "end_time", t_span=(0, 1), integrator=ns.MoreauJean(1e-3))
    found = ns.sweep(task, {"vb": [0.2, 2.0]}, progress=False)
    assert found.status.values.tolist() == [ns.CellStatus.FINISHED, ns.CellStatus.NEGATIVE_FRICTION]
    assert found.end_time.values[1] == 0.0 and "t = 0 s" in str(found.message.values[1])


def test_a_function_of_the_solution_is_a_measure():
    def top_speed(solution):
        return abs(solution.u).max()

    task = ns.RunTask(BeltOscillator(), [top_speed, "amplitude"], t_span=(0, 3), integrator=ns.MoreauJean(1e-2))
    found = ns.sweep(task, {"vb": [0.1, 0.3]}, progress=False)
    named = ns.RunTask(BeltOscillator(), "amplitude", t_span=(0, 3), integrator=ns.MoreauJean(1e-2))
    np.testing.assert_array_equal(
        found.amplitude.values, ns.sweep(named, {"vb": [0.1, 0.3]}, progress=False).amplitude.values
    )
    for vb, speed in zip((0.1, 0.3), found.top_speed.values, strict=True):
        belt = BeltOscillator(vb=vb)
        assert speed == abs(ns.simulate(belt, (0, 3), *belt.state(), integrator=ns.MoreauJean(1e-2)).u).max()


def test_springs_whose_frequency_follows_the_masses_at_the_start_are_prepared_cell_by_cell():
    ball = BouncingBall()
    measures = ["final_state", "impacts", "modes", "penetration", "amplitude"]
    task = ns.RunTask(ball, measures, t_span=(0, 0.6), integrator=ns.Penalty(stiffness=1e5))
    found = ns.sweep(task, {"stiffness": [1e4, 1e6], "height": [0.5, 1.0]}, progress=False)
    for i, stiffness in enumerate((1e4, 1e6)):
        for k, height in enumerate((0.5, 1.0)):
            alone = ns.simulate(ball, (0, 0.6), *ball.state(height=height), integrator=ns.Penalty(stiffness=stiffness))
            assert found.q.values[i, k] == alone.q[-1]
            assert found.penetration.values[i, k] == alone.stats.worst_penetration
            assert found.impacts.values[i, k] == 1 and found.modes.values[i, k] == "open, closed, open"


def test_inadmissible_starts_are_counted_once():
    task = ns.RunTask(BilateralRod(), t_span=(0, 0.01), state={"q0": [0, 3.0, 1.0], "u0": [0, 0, 0]})
    with pytest.warns(ns.InitialStateWarning, match="in 3 of the cells") as caught:
        ns.sweep(task, {"mu": [0.1, 0.2, 0.3]}, progress=False)
    assert [warning.filename for warning in caught] == [__file__]


def test_every_worst_figure_of_a_cell_is_that_of_its_run(monkeypatch):
    """A rod that falls on its tip gains energy by Newton's law: all five figures are other numbers than zero. Those of
    the ledger, which a sweep has no name for, are not looked for in cells."""
    cells, runs = [], []
    run, of_numbers = BlockEngine.run, Stats.of_numbers
    monkeypatch.setattr(BlockEngine, "run", lambda engine, block: (cells.append(block), run(engine, block))[1])
    monkeypatch.setattr(Stats, "of_numbers", lambda counters, worst, *more: (
        runs.append(worst), of_numbers(counters, worst, *more))[1])  # fmt: skip
    rod, integrator = PainleveRod(m=1.0, l=2.0, I=1 / 3, mu=1.0), ns.MoreauJean(1e-3)
    q0, _ = rod.state(th=math.pi / 4)
    start, restitutions = {"q0": q0, "u0": [0.6, -1.0, 0.0]}, [0.7, 0.9]
    ns.sweep(ns.RunTask(rod, t_span=(0, 0.05), integrator=integrator, state=start), {"e": restitutions}, progress=False)
    with pytest.warns(ns.EnergyGainWarning):
        for e in restitutions:
            assert ns.simulate(replace(rod, e=e), (0, 0.05), **start, integrator=integrator).stats
    assert [len(figures) for figures in runs] == 2 * [len(fields_of(Worst))]
    assert (np.array(runs) != 0.0).any(axis=0).all(), runs
    of_ledger = np.array([name.startswith("ledger") for name in fields_of(Worst)])
    assert (np.concatenate([block.worst for block in cells]) == np.array(runs))[:, ~of_ledger].all()


def test_every_end_of_a_run_is_an_end_of_a_cell():
    ends = {status.name: status.value for status in ns.Status if status.name != "RUNNING"}
    assert {name: ns.CellStatus[name].value for name in ends} == ends


def test_a_run_inside_a_function_gives_its_status_to_the_cell():
    """mu(v) = m0 - m1 v becomes negative above v = m0/m1."""

    def end(vb):
        belt = BeltOscillator(m3=0.0, vb=vb)
        return ns.simulate(belt, (0, 1), *belt.state(), integrator=ns.MoreauJean(1e-3)).t[-1]

    found = ns.sweep(end, {"vb": [0.2, 2.0]}, progress=False)
    assert found.status.values.tolist() == [ns.CellStatus.FINISHED, ns.CellStatus.NEGATIVE_FRICTION]
    assert found.value.values[0] == 1.0 and "friction" in found.message.values[1]


def test_a_system_that_has_run_goes_to_other_processes():
    rod = PainleveRod(mu=0.5).system()
    q0, u0 = PainleveRod(mu=0.5).state(slip=1.0)
    task = ns.RunTask(rod, t_span=(0, 0.1), state={"q0": q0, "u0": u0}, integrator=ns.MoreauJean(1e-3))
    ns.simulate(rod, (0, 0.1), q0, u0, integrator=ns.Penalty(1e6))
    there = pickle.loads(pickle.dumps(task))
    axes = {"mu": [0.3, 0.5]}
    xr.testing.assert_identical(ns.sweep(task, axes, progress=False), ns.sweep(there, axes, progress=False))


@pytest.mark.parametrize("integrator", [
    ns.EventDriven(1e-8, 1e-10), ns.Adaptive(1e-6), ns.MoreauJean(1e-5), ns.Penalty(1e6, damping_ratio=0.5, rtol=1e-5),
], ids=["events", "chosen", "fixed", "springs"])  # fmt: skip
def test_cells_in_space_have_the_bits_of_their_simulation(integrator):
    rod, axes = SpatialPainleveRod(e=0.5), {"mu": [0.4, 1.2, 2.0], "phi": [0.5, -2.0]}
    task = ns.RunTask(rod, ["final_state", "paradoxes"], integrator=integrator, t_span=(0, 0.02))
    found = ns.sweep(task, axes)
    for mu in axes["mu"]:
        for phi in axes["phi"]:
            cell = found.sel(mu=mu, phi=phi)
            sol = ns.simulate(replace(rod, mu=mu), (0, 0.02), *rod.state(phi=phi), integrator=integrator)
            assert (cell.q.values == sol.q[-1]).all() and (cell.u.values == sol.u[-1]).all()
            assert cell.paradoxes == len(sol.paradoxes)
    assert integrator.is_rigid == (found.paradoxes.sum() > 0)
