"""Figures and summaries say what the run did, with names and units."""

import re

import numpy as np
import pytest

import nonsmooth as ns
from models import BeadChain, BeltOscillator, BouncingBall, InclinedBlock, SelfLockingRod, SpragSlip
from nonsmooth.drawing.plots import draw_strip, new_figure
from nonsmooth.drawing.scene import frames_of


@pytest.fixture(scope="module")
def seizing_rod():
    rod = SpragSlip()
    return ns.simulate(rod, (0, 0.5), *rod.state(), integrator=ns.MoreauJean(dt=1e-3))


@pytest.fixture(scope="module")
def ball():
    model = BouncingBall()
    return ns.simulate(model, (0, 2), *model.state(), integrator=ns.MoreauJean(dt=1e-3))


def texts(figure):
    axes = [a for part in (figure, *figure.subfigs) for a in part.axes]
    labels = [text for a in axes for text in (a.get_xlabel(), a.get_ylabel(), a.get_title("right"))]
    return labels + [text.get_text() for a in axes if a.get_legend() for text in a.get_legend().get_texts()]


def test_phase_plane_names_its_curves_and_regions(seizing_rod):
    shown = texts(seizing_rod.plot())
    assert {"$v_t = 0$", "$N = 0$", "$M = 0$", "th [rad]", "th' [rad/s]", "t [s]", "change [J]"} <= set(shown)
    assert {"no solution while it slides", "two solutions while it slides"} <= set(shown)  # at rest the counts differ


def test_a_cut_axis_says_how_far_the_impulses_reach(ball):
    peak = (ball.P_N[1:, 0] / np.diff(ball.t)).max()
    assert any(f"up to {peak:.3g} N" in text for text in texts(ball.plot()))


def test_a_loaded_solution_is_drawn_without_its_model(ball, tmp_path):
    figure = ns.Solution.load(ball.save(tmp_path / "ball.npz")).plot(tmp_path / "ball.pdf")
    assert "q[0]" in texts(figure)
    assert (tmp_path / "ball.pdf").read_bytes().startswith(b"%PDF")


def test_a_system_without_contacts_and_a_run_of_no_length_are_drawn(tmp_path):
    def mass(t, q, p, M):
        M[0, 0] = 1.0

    def force(t, q, u, p, h):
        h[0] = -q[0]

    oscillator = ns.System(n_q=1, mass=mass, force=force)
    for end in (0.0, 0.1):
        solution = ns.simulate(oscillator, (0, end), [1.0], [0.0], integrator=ns.MoreauJean(dt=1e-2))
        solution.plot(tmp_path / "oscillator.png")
        assert "no contacts" in solution.summary()


def test_friction_under_a_given_force_is_drawn():
    belt = BeltOscillator()
    solution = ns.simulate(belt, (0, 1), *belt.state(), integrator=ns.MoreauJean(dt=1e-2))
    assert "friction" in texts(solution.plot())


def test_mode_strip_covers_the_whole_run_once():
    axes = new_figure(3, 2).subplots()
    t, code = np.linspace(0, 1, 11), np.array([1, 1, 4, 4, 4, 1, 1, 1, 8, 8])
    draw_strip(axes, t, code, 0, 1)
    (bars,) = axes.collections
    extents = [path.get_extents() for path in bars.get_paths()]
    assert np.allclose([e.x0 for e in extents], [0.0, 0.2, 0.5, 0.8])
    assert np.allclose([e.x1 for e in extents], [0.2, 0.5, 0.8, 1.0])


def test_a_mode_that_lasts_one_step_is_seen_in_its_strip():
    axes = new_figure(3, 2).subplots()
    t, code = np.linspace(0, 1, 2001), np.ones(2000, int)
    code[700] = 10  # closed for one step of 2000
    draw_strip(axes, t, code, 0, 1)
    (bars,) = axes.collections
    hair = bars.get_paths()[-1].get_extents()
    assert np.isclose(hair.x0, 0.35) and np.isclose(hair.width, 5e-4)
    assert bars.get_linewidths()[-1] > 0 and not any(bars.get_linewidths()[:-1])


def test_a_force_that_is_constant_to_rounding_is_drawn_as_a_constant():
    rod = SelfLockingRod()
    solution = ns.simulate(rod, (0, 1), *rod.state(), integrator=ns.MoreauJean(dt=1e-3))
    forces = solution.plot().axes[3]
    assert np.ptp(solution.P_N[1:, 0] / np.diff(solution.t)) > 0  # the rounding that would fill the axis
    assert forces.get_ylim()[0] == 0.0 < solution.P_N[-1, 0] / 1e-3 < forces.get_ylim()[1]


def test_a_run_at_rest_says_that_nothing_changes():
    block = InclinedBlock()
    solution = ns.simulate(block, (0, 0.1), *block.state(), integrator=ns.MoreauJean(dt=1e-3))
    assert "no energy changes" in solution.plot().axes[2].texts[0].get_text()


def test_a_chain_is_drawn_from_its_first_bead_to_its_last():
    chain = BeadChain(n=30)
    solution = ns.simulate(chain, (0, 0.01), *chain.state(), integrator=ns.MoreauJean(dt=1e-3))
    shown = texts(solution.plot())
    assert "x_0 [m]" in shown and "x_29 [m]" in shown and "coordinates\n(8 of 30)" in shown


def test_frames_are_equally_spaced_in_time_and_title_says_how_slow(ball):
    shown, slow = frames_of(ball, 25)
    assert slow == "" and np.allclose(np.diff(ball.t[shown]), 2 / 49, atol=1.01e-3)
    assert frames_of(ball, 300)[1] == "  (time x 1.5)"


def test_a_picture_shows_the_scene_at_its_instants(ball, tmp_path):
    figure = ball.picture(tmp_path / "ball.png", n=3)
    (axes,) = figure.axes
    assert axes.get_title() == "t = 0, 1, 2 s, the later the darker"
    centres = sorted(line.get_ydata().mean() for line in axes.lines if line.get_alpha())
    at_instants = ball.q[np.searchsorted(ball.t, [0, 1 - 1e-9, 2 - 1e-9]), 0]
    radius = np.ptp(axes.lines[-1].get_ydata()) / 2
    assert np.allclose(np.diff(centres), np.diff(np.sort(at_instants)), atol=radius / 8)  # the mean of 17 points


def test_a_picture_needs_a_model_with_a_shape(ball, tmp_path):
    with pytest.raises(ns.InvalidInput, match="shape"):
        ns.Solution.load(ball.save(tmp_path / "ball.npz")).picture()


def test_an_animation_has_a_frame_for_each_instant_and_a_white_ground(ball, tmp_path):
    from PIL import Image

    with Image.open(ball.animate(tmp_path / "ball.gif", fps=10)) as gif:
        assert (gif.n_frames, gif.info["duration"]) == (25, 100)
        first = np.asarray(gif.convert("RGB"))
        gif.seek(12)
        assert (np.asarray(gif.convert("RGB")) != first).any()
    assert (first[0, 0] >= 254).all()


def test_animation_refuses_an_ending_it_cannot_write(ball, tmp_path):
    with pytest.raises(ns.InvalidInput, match=r"one of \.gif, \.webp"):
        ball.animate(tmp_path / "ball.avi")


def test_summary_counts_what_it_does_not_show(ball):
    text = ball.summary()
    changes = sum(event.kind.name in ("MODE_CHANGE", "IMPACT") for event in ball.events)
    assert f"modes: {changes} changes; at the end closed" in text
    assert f"... and {changes - 12} more" in text


def test_summary_names_the_impulses_of_an_impact_without_collision(seizing_rod):
    first = seizing_rod.paradoxes[0]
    assert f"then stick, P_N = {first.P_N:.6g} N s, P_F = {first.P_F:.6g} N s" in seizing_rod.summary()
    assert "3 solutions (stick | slide - | slide - (P_N < 0)): took slide -" in seizing_rod.summary()


def test_notebook_text_is_the_summary_with_names_that_cannot_become_markup():
    def mass(t, q, p, M):
        M[0, 0] = 1.0

    def force(t, q, u, p, h):
        h[0] = -q[0]

    system = ns.System(n_q=1, mass=mass, force=force, name="<b>x</b>")
    solution = ns.simulate(system, (0, 0.1), [1.0], [0.0], integrator=ns.MoreauJean(dt=1e-2))
    shown = solution._repr_html_()
    assert shown.startswith("<pre>&lt;b&gt;x&lt;/b&gt;: the end was reached") and shown.count("<") == 2


def test_energy_line_closes_to_rounding(seizing_rod):
    closure = float(re.search(r"surface .* J \(to (.*) J\)", seizing_rod.summary())[1])
    largest = max(np.abs(seizing_rod.ledger[name]).max() for name in ("force", "friction", "surface"))
    assert closure <= seizing_rod.stats.steps * np.finfo(float).eps * largest  # one rounding a step


def test_the_impulse_of_an_impact_is_no_force_of_the_figure():
    """Located impacts stand between two records of one instant; a ball in the air is touched by nothing."""
    model = BouncingBall(e=0.5)
    solution = ns.simulate(model, (0, 1), *model.state(height=1.0), integrator=ns.EventDriven(1e-8))
    assert (np.diff(solution.t) == 0).any()
    (forces,) = (axes for axes in solution.plot().axes if axes.get_ylabel().startswith("force"))
    assert forces.lines and not any(line.get_ydata().any() for line in forces.lines)
