"""Studies, figures and brute-force diagrams of cycles; the flow of a mode against closed forms."""

from __future__ import annotations

import itertools
import json
import math
from types import SimpleNamespace
from typing import NamedTuple

import numpy as np
import pytest

import nonsmooth as ns
from models import BeltOscillator, FollowerForceArm, ModeCoupling, SpragSlip
from nonsmooth.commands.cli import main
from nonsmooth.cycles.cycle_branch import crossing
from nonsmooth.cycles.flow_map import flow_map
from nonsmooth.cycles.mode_flow import ContactState, mode_flow
from nonsmooth.drawing.cycle_plots import look, plot_branch, plot_cycle, plot_waterfall
from nonsmooth.mechanics.system import ContactMode
from nonsmooth.studies.bifurcation import table
from nonsmooth.studies.bifurcation_diagram import maxima
from nonsmooth.studies.cycle import study_cycle
from tests.drawing.looks import faults

SLIDE, STICK = ContactMode.SLIDE, ContactMode.STICK


@pytest.fixture(scope="module")
def branch():
    start = ns.limit_cycle(BeltOscillator(vb=0.2))
    return ns.continue_cycle(BeltOscillator(), "vb", [0.2, 0.25], start)


def test_cycle_is_drawn_with_a_colour_for_every_mode(branch, tmp_path):
    figure = plot_cycle(branch.cycles[0], tmp_path / "cycle.png")
    labels = [text.get_text() for text in figure.legends[0].get_texts()]
    assert sorted(labels) == ["slide -", "stick"]
    assert (tmp_path / "cycle.png").stat().st_size > 10_000


def test_the_legend_of_a_cycle_has_the_colours_and_dashes_of_its_phases():
    cycle = ns.limit_cycle(SpragSlip.set_1(cth=0.5))
    figure = plot_cycle(cycle)
    drawn = {(line.get_color(), line.get_linestyle()) for line in figure.axes[0].lines if line.get_marker() == "None"}
    legend = [(line.get_color(), line.get_linestyle()) for line in figure.legends[0].get_lines()]
    assert len(set(legend)) == len(legend) == 3 and set(legend) == drawn


def test_phases_of_several_contacts_have_a_look_each():
    """One colour of one contact's mode would stand for several phases."""
    states = [tuple(ContactState(mode, slip, 1) for mode, slip in modes)
              for modes in itertools.product(((SLIDE, 1), (SLIDE, -1), (STICK, 0)), repeat=2)][:8]  # fmt: skip
    labels = [str(number) for number in range(len(states))]
    looks = {look(SimpleNamespace(states=s, label=name), labels) for s, name in zip(states, labels, strict=True)}
    assert len(looks) == len(states) == 8


def test_titles_have_the_system_and_what_was_held_fixed(branch):
    diagram = ns.bifurcation_diagram(BeltOscillator(), "vb", [0.2, 0.25], duration=20.0)
    for figure in (plot_branch(branch), plot_waterfall(branch), diagram.plot()):
        title = figure.get_suptitle()
        assert title.startswith("belt-oscillator\n") and "m1 = 0.45" in title and "vb" not in title
        assert faults(figure) == []
    assert "vb = 0.2" in plot_cycle(branch.cycles[0]).get_suptitle()


def test_branch_and_waterfall_show_the_cycles_that_were_computed(branch):
    axes = plot_branch(branch).axes
    np.testing.assert_allclose(axes[1].lines[0].get_ydata(), branch.periods)
    assert len(plot_waterfall(branch).axes[0].lines) == 2


def test_study_prints_the_phases_and_draws(tmp_path):
    study = study_cycle(BeltOscillator(vb=0.2), {})
    assert "period 2.0203482" in study.text and "stick" in study.text and "0.2501476" in study.text
    study.draw(tmp_path / "cycle.png")
    with pytest.raises(ns.InvalidInput, match="one parameter"):
        study_cycle(BeltOscillator(), {"vb": [0.2], "c": [0.1]})


def test_command_follows_the_cycle_along_an_axis(capsys, tmp_path):
    figure = tmp_path / "branch.png"
    assert main(["study", "cycle", "belt-oscillator", "--axis", "vb=0.2:0.3:3", "--plot", str(figure)]) == 0
    out = capsys.readouterr().out
    assert "2.020348258" in out and "1.999912298" in out and figure.stat().st_size > 10_000


def test_command_says_why_there_is_no_cycle(capsys):
    assert main(["study", "cycle", "belt-oscillator", "--set", "vb=0.6", "--no-plot"]) == 2
    assert "come to rest" in capsys.readouterr().err


def test_diagram_shows_the_maxima_of_the_cycles_and_rest_beyond_them(tmp_path):
    diagram = ns.bifurcation_diagram(BeltOscillator(), "vb", [0.2, 0.3, 0.6], duration=150.0, dt=2e-3)
    for k, high in ((0, 0.068330977), (1, 0.101641330)):
        rest = BeltOscillator(vb=float(diagram.values[k])).equilibrium()
        for maxima_ in (diagram.upwards[k], diagram.downwards[k]):
            assert maxima_ - rest == pytest.approx([high], abs=2e-4)  # of sticking steps dt: amplitude error 1e-3
    assert diagram.upwards[2] == pytest.approx([BeltOscillator(vb=0.6).equilibrium()], abs=1e-3)
    assert not diagram.opens.any()
    diagram.plot(tmp_path / "diagram.png")
    assert (tmp_path / "diagram.png").stat().st_size > 10_000


@pytest.mark.parametrize("values, options, message", [
    ([0.3, 0.2], {}, "increase"), ([0.2], {"coordinate": 1}, "from 0 to 0"),
    ([0.2], {"duration": -1.0}, "positive"),
])  # fmt: skip
def test_diagram_refuses_bad_input(values, options, message):
    with pytest.raises(ns.InvalidInput, match=message):
        ns.bifurcation_diagram(BeltOscillator(), "vb", values, **options)


def test_motions_that_have_not_settled_are_marked_where_they_are_drawn_and_printed(recwarn):
    """x'' + x = a x' - x'^3: |x| grows to sqrt(4 a/3) as exp(a t/2), and decays to it from above."""

    class Fed(NamedTuple):
        a: float = 0.1

    def mass(t, q, p, M):
        M[0, 0] = 1.0

    def force(t, q, u, p, h):
        h[0] = -q[0] + p.a * u[0] - u[0] ** 3

    fed = ns.System(coordinates=[("x", "m")], mass=mass, force=force, parameters=Fed())
    options = {"state": {"x": 0.05}, "dt": 1e-2, "progress": False}
    long = ns.bifurcation_diagram(fed, "a", [0.1, 0.15, 0.2], duration=400.0, **options)
    assert not recwarn.list and long.settled.all() and (long.change >= 0).all()
    for a, found in zip(long.values, long.upwards, strict=True):
        np.testing.assert_allclose(found, math.sqrt(4 * a / 3), rtol=0.02)  # averaging errs in the order of a
    with pytest.warns(ns.UnsettledWarning, match=r"at 1 values \(0.1\) the motion has not settled to 0.01"):
        short = ns.bifurcation_diagram(fed, "a", [0.1, 0.15, 0.2], duration=60.0, **options)
    assert not short.settled[0, 0] and short.settled[:, 1:].all()
    assert short.change[0, 0] > 0.05 and "not settled, " in table(short).splitlines()[2]
    axes = short.plot().axes[0]
    crosses = [line for line in axes.lines if line.get_marker() == "x"]
    assert sum(len(line.get_xdata()) for line in crosses) == sum(
        len(points) for way, points in zip(short.settled[:, 0], (short.upwards[0], short.downwards[0]), strict=True)
        if not way
    )  # fmt: skip
    assert any("not settled" in text.get_text() for text in axes.get_legend().get_texts())


def test_a_rest_that_is_left_slowly_is_not_taken_for_rest():
    """x'' = 0.02 x' - x from 1e-3: after 100 s it is 2.7e-3, far below the other motions of the diagram."""

    class Left(NamedTuple):
        a: float = 0.02
        x: float = 0.0

    def mass(t, q, p, M):
        M[0, 0] = 1.0

    def force(t, q, u, p, h):
        h[0] = p.x - q[0] + p.a * u[0]

    leaving = ns.System(coordinates=[("x", "m")], mass=mass, force=force, parameters=Left())
    with pytest.warns(ns.UnsettledWarning):
        grows = ns.bifurcation_diagram(leaving, "x", [0.0, 1.0], state={"x": 1e-3}, duration=100.0, dt=1e-2)
    assert not grows.settled[0].any()


class Well(NamedTuple):
    c: float = 1.0  # damping [1/s]


def well_mass(t, q, p, M):
    M[0, 0] = 1.0


def well_force(t, q, u, p, h):
    h[0] = q[0] - q[0] ** 3 - p.c * u[0]


def test_chains_from_several_starts_find_several_attractors():
    """x'' = x - x^3 - c x' comes to rest at 1 and at -1."""
    well = ns.System(n_q=1, mass=well_mass, force=well_force, parameters=Well())
    right, left = ([0.5], [0.0]), ([-0.5], [0.0])
    options = {"duration": 60.0, "dt": 1e-2}
    one = ns.bifurcation_diagram(well, "c", [1.0, 1.5], start=right, **options)
    both = ns.bifurcation_diagram(well, "c", [1.0, 1.5], start=[right, left], **options)
    for k in (0, 1):
        for there, back in ((one, [1.0]), (both, [-1.0, 1.0])):
            np.testing.assert_allclose(there.upwards[k], back, atol=1e-6)  # exp(-c t/2) is 1e-10 at 48 s
            np.testing.assert_allclose(there.downwards[k], back, atol=1e-6)
    with pytest.raises(ns.InvalidInput, match="a pair"):
        ns.bifurcation_diagram(well, "c", [1.0], start=[([0.5], [0.0], 0.0)], **options)


def test_maxima_are_told_apart_and_rest_is_its_position():
    t = np.linspace(0, 8 * np.pi, 4001)
    size = np.where(t % (4 * np.pi) < 2 * np.pi, 1.0, 2.0)
    np.testing.assert_allclose(maxima(size * np.sin(t), 1e-3), [1.0, 2.0], rtol=1e-12)
    assert maxima(np.full(10, 2.0), 1e-3).tolist() == [2.0]


def test_a_motion_slower_than_the_late_part_has_no_point_there_and_it_is_said(recwarn):
    """x = cos t has its maxima at whole turns: none from 8 to 10 s, where its last sample is no maximum either."""

    class Free(NamedTuple):
        k: float = 1.0

    def mass(t, q, p, M):
        M[0, 0] = 1.0

    def force(t, q, u, p, h):
        h[0] = -p.k * q[0]

    swinging = ns.System(coordinates=[("x", "m")], mass=mass, force=force, parameters=Free())
    options = {"state": {"x": 1.0}, "dt": 1e-3, "progress": False}
    enough = ns.bifurcation_diagram(swinging, "k", [1.0], duration=50.0, **options)
    np.testing.assert_allclose(enough.upwards[0], [1.0], rtol=1e-5)
    assert not recwarn.list
    with pytest.warns(ns.UnsettledWarning, match=r"at 1 values \(1\) .* without a maximum in the last fifth .*, 2 s"):
        short = ns.bifurcation_diagram(swinging, "k", [1.0], duration=10.0, **options)
    assert not short.upwards[0].size and "none" in table(short)
    short.plot()


@pytest.mark.parametrize("before, after, kind", [
    ([0.9], [0.95], ""), ([0.9], [1.1], "fold"), ([-0.9], [-1.1], "period doubling"),
    ([0.9 + 0.3j, 0.9 - 0.3j], [1.0 + 0.3j, 1.0 - 0.3j], "torus"), ([1.1], [0.9], "fold"),
])  # fmt: skip
def test_multipliers_that_cross_the_unit_circle_name_the_bifurcation(before, after, kind):
    assert crossing(np.array(before), np.array(after)) == kind


@pytest.mark.parametrize("branch_sign", [1, -1])
def test_flow_of_the_sliding_rod_has_the_force_and_acceleration_of_its_closed_form(branch_sign):
    rod = SpragSlip()
    th, thdot = 0.85, 0.0
    force = rod.normal_forces(th, thdot)[1 if branch_sign > 0 else 0]
    q, u = rod.state(th=th, thdot=thdot)
    flow = mode_flow(rod.system(), (ContactState(SLIDE, -1, branch_sign),))
    now = flow.instant(np.concatenate([q, u]))
    assert now.la_N[0].real == pytest.approx(force, rel=1e-12)
    assert now.acceleration[1].real == pytest.approx(rod.angular_acceleration(th, thdot, force), rel=1e-12)
    np.testing.assert_allclose(flow.holds(np.concatenate([q, u])), 0, atol=1e-14)


def test_flow_of_the_sticking_rod_has_the_forces_of_its_closed_form():
    rod = SpragSlip.set_1()
    th = 0.81
    q, u = rod.state(th=th, thdot=rod.stick_rate(th))
    flow = mode_flow(rod.system(), (ContactState(STICK, 0, 1),))
    now = flow.instant(np.concatenate([q, u]))
    assert (now.la_N[0].real, now.la_F[0].real) == pytest.approx(rod.stick_forces(th), rel=1e-12)
    margins = flow.margins(np.concatenate([q, u]))
    assert margins[0, "friction +"] + margins[0, "friction -"] == pytest.approx(
        2 * rod.mu * abs(now.la_N[0]), rel=1e-12
    )


def test_flow_without_row_rates_of_the_model_finds_them_by_differences():
    from dataclasses import replace

    rod = SpragSlip()
    x = np.concatenate(rod.state(th=0.7, thdot=1.3))
    states = (ContactState(SLIDE, -1, 1),)
    with_rates, without = (
        mode_flow(system, states).rate(x) for system in (rod.system(), replace(rod.system(), row_rates=None))
    )
    np.testing.assert_allclose(with_rates, without, rtol=1e-9)


@pytest.mark.parametrize("model, states", [
    (FollowerForceArm(P=1000.0), ()), (ModeCoupling(), (ContactState(SLIDE, -1, 1),)),
    (SpragSlip.set_1(), (ContactState(STICK, 0, 1),)),
], ids=["arm", "coupling", "sprag"])  # fmt: skip
def test_derivative_of_a_flow_is_that_of_its_differences(model, states):
    flow = mode_flow(model.system(), states)
    x = np.concatenate(model.state() if states else model.state(phi1=0.1))
    if isinstance(model, SpragSlip):
        x = np.concatenate(model.state(th=0.81, thdot=model.stick_rate(0.81)))
    scale, T = np.ones(4), 0.05
    _, Phi = flow_map(flow, x, T, scale)
    h = 1e-5  # central difference: truncation 1e-10 times third derivatives of order 1e2
    columns = [
        (flow_map(flow, x + h * e, T, scale)[0] - flow_map(flow, x - h * e, T, scale)[0]) / (2 * h) for e in np.eye(4)
    ]
    np.testing.assert_allclose(Phi, np.column_stack(columns), atol=3e-7 * max(1.0, np.abs(Phi).max()))


def test_no_letter_stands_over_another_in_figures_of_cycles(branch):
    for figure in (plot_cycle(branch.cycles[0]), plot_branch(branch), plot_waterfall(branch)):
        assert faults(figure) == []


def test_the_jump_of_a_seizure_is_drawn_in_every_phase_plane():
    rod = SpragSlip()
    cycle = ns.limit_cycle(rod, rod.state(th=0.78, thdot=1.0), duration=6.0)
    jumps = [phase for phase in cycle.phases if phase.jump is not None]
    figure = plot_cycle(cycle)
    for axes in figure.axes:
        drawn = [line.get_ydata() for line in axes.lines if line.get_gid() == "jump"]
        assert len(drawn) == len(jumps) > 0 and all(before != after for before, after in drawn)
    assert faults(figure) == []


@pytest.mark.upkeep
def test_stick_time_is_zero_where_sticking_ends():
    start = ns.limit_cycle(BeltOscillator(vb=0.36))
    found = ns.continue_cycle(BeltOscillator(), "vb", [0.36, 0.38, 0.42], start)
    (end,) = (change.value for change in found.changes if change.kind == "stick ends")
    (line,) = plot_branch(found).axes[2].lines[:1]
    assert np.interp(end, *line.get_data()) == 0.0 < np.interp(end - 1e-3, *line.get_data())


@pytest.mark.upkeep
def test_a_change_that_is_not_located_has_no_value_of_its_own(capsys):
    """Beyond 0.4472 m/s there is no cycle: the end lies between two values; the end of stick was solved."""
    assert main("study cycle belt-oscillator --axis vb=0.35:0.5:4 --no-plot --json".split()) == 0
    ends, end = json.loads(capsys.readouterr().out)["branch"]["changes"]
    assert ends["kind"] == "stick ends" and ends["value"] == pytest.approx(0.3945445849, rel=1e-9)
    assert end["kind"] == "end" and end["value"] is None and end["between"] == pytest.approx([0.4, 0.45])
    assert main("study cycle belt-oscillator --axis vb=0.35:0.5:4 --no-plot".split()) == 0
    said = capsys.readouterr().out
    assert "stick ends at vb = 0.39454458" in said and "end of vb between 0.4 and 0.45" in said
