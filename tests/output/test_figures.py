"""Figures and summaries say what the run did, with names and units."""

import re

import numpy as np
import pytest

import nonsmooth as ns
from models import BeltOscillator, BouncingBall, SpragSlip
from nonsmooth.output.plots import draw_strip, new_figure
from nonsmooth.output.scene import frames_of, still


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
    assert any("no solution" in text for text in shown) and any("two solutions" in text for text in shown)


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


def test_frames_are_equally_spaced_in_time_and_title_says_how_slow(ball):
    shown, slow = frames_of(ball, 25)
    assert slow == "" and np.allclose(np.diff(ball.t[shown]), 2 / 49, atol=1.01e-3)
    assert frames_of(ball, 100)[1] == "  (time x 1.3)"


def test_still_needs_a_model_with_a_shape(ball, tmp_path):
    still(ball, tmp_path / "still.png", n=3)
    with pytest.raises(ns.InvalidInput, match="shape"):
        still(ns.Solution.load(ball.save(tmp_path / "ball.npz")))


def test_animation_refuses_an_ending_it_cannot_write(ball, tmp_path):
    with pytest.raises(ns.InvalidInput, match=r"\.gif or \.webp"):
        ball.animate(tmp_path / "ball.mp4")


def test_summary_counts_what_it_does_not_show(ball):
    text = ball.summary()
    changes = sum(event.kind.name in ("MODE_CHANGE", "IMPACT") for event in ball.events)
    assert f"modes: {changes} changes; at the end locked" in text
    assert f"... and {changes - 12} more" in text


def test_summary_names_the_impulses_of_an_impact_without_collision(seizing_rod):
    first = seizing_rod.paradoxes[0]
    assert f"then stick, P_N = {first.P_N:.6g} N s, P_F = {first.P_F:.6g} N s" in seizing_rod.summary()
    assert "3 solutions (stick | slide - | slide - (P_N < 0)): took slide -" in seizing_rod.summary()


def test_energy_line_closes_to_rounding(seizing_rod):
    closure = float(re.search(r"surface .* J \(to (.*) J\)", seizing_rod.summary())[1])
    largest = max(np.abs(seizing_rod.ledger[name]).max() for name in ("force", "friction", "surface"))
    assert closure <= seizing_rod.stats.steps * np.finfo(float).eps * largest  # one rounding a step
