"""Figures and summaries say what the run did, with names and units."""

import itertools
import re
from dataclasses import replace

import numpy as np
import pytest
from matplotlib.text import Text

import nonsmooth as ns
from models import (
    BeadChain,
    BeltOscillator,
    BouncingBall,
    InclinedBlock,
    LeadScrew,
    RockingBlock,
    SelfLockingRod,
    SpragSlip,
)
from nonsmooth.catalogue import BoxStack
from nonsmooth.catalogue import load as load_model
from nonsmooth.catalogue.entries import model_entries
from nonsmooth.drawing.colours import CYCLE, ENERGIES, STRIPS
from nonsmooth.drawing.forces import is_lonely, loads_of
from nonsmooth.drawing.labels import spelt, with_spelt_names
from nonsmooth.drawing.player.solution_film import film_of_solution
from nonsmooth.drawing.plots import draw_strip, new_figure
from nonsmooth.drawing.scene import MAX_FRAMES, frames_of, periods_of, with_surroundings
from tests.drawing.looks import faults


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
    assert {"$v_t = 0$", "$N = 0$", "$M = 0$", "θ [rad]", "θ' [rad/s]", "t [s]", "change of\nenergy [J]"} <= set(shown)
    assert {"no solution while it slides", "two solutions while it slides"} <= set(shown)  # at rest the counts differ


def test_impulses_of_impacts_are_no_forces_of_the_step(ball):
    """A ball of 1 kg that falls 1 m brings 6.6 N s: 6600 N over a step of 1 ms, 1000 times that over one of 1 us."""
    figure = ball.plot()
    (forces,), (impulses,) = (
        [a for a in figure.axes if a.get_ylabel().startswith(name)] for name in ("force", "impulse")
    )
    largest = max(np.nanmax(patch.get_data().values) for patch in forces.patches)
    assert largest < 2 * 9.81  # the weight, and what is left of the last bounces
    (stems,) = (line.get_ydata() for line in impulses.lines if line.get_marker() == "o")
    assert stems.max() == pytest.approx(1.5 * np.sqrt(2 * 9.81), abs=2.5 * 9.81e-3)  # (1 + e) m v, a step


def test_force_and_impulse_together_are_all_that_the_contact_carried(ball):
    loads = loads_of(ball)
    span = np.where(loads.is_impulse[:, 0], 1.0, np.diff(ball.t))
    np.testing.assert_allclose((loads.normal[:, 0] * span).sum(), ball.P_N.sum(), rtol=1e-12)


def test_a_load_between_two_records_alone_is_an_impulse():
    loaded = np.array([[1, 0, 1, 1, 0, 1]], bool).T
    assert is_lonely(loaded)[:, 0].tolist() == [False] * 6  # the first and the last may go on
    assert is_lonely(np.array([[0, 1, 0, 1, 1, 0]], bool).T)[:, 0].tolist() == [False, True, False, False, False, False]


def without_model(solution):
    """As it is read where nothing is known of the model."""
    return replace(solution, system=None, names=None, named_model=None)


def test_a_loaded_solution_is_drawn_without_its_model(ball, tmp_path):
    loaded = ns.Solution.load(ball.save(tmp_path / "ball.npz"))
    assert "y\n[m]" in texts(loaded.plot())
    figure = without_model(loaded).plot(tmp_path / "ball.pdf")
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
    solution = ns.simulate(rod, (0, 1), *rod.state(th=rod.th0), integrator=ns.MoreauJean(dt=1e-3))
    (forces,) = (axes for axes in solution.plot().axes if axes.get_ylabel().startswith("force"))
    assert np.ptp(solution.P_N[1:, 0] / np.diff(solution.t)) > 0  # the rounding that would fill the axis
    low, high = forces.get_ylim()
    assert high - low > 0.1 * solution.P_N[-1, 0] / 1e-3


def test_a_run_at_rest_says_that_nothing_changes():
    block = InclinedBlock()
    solution = ns.simulate(block, (0, 0.1), *block.state(slip=0.0, distance=0.0), integrator=ns.MoreauJean(dt=1e-3))
    assert any("no energy changes" in text.get_text() for axes in solution.plot().axes for text in axes.texts)


def test_a_chain_is_drawn_over_space_and_time_with_the_contacts_that_carry_most():
    chain = BeadChain(n=30)
    solution = ns.simulate(chain, (0, 0.01), *chain.state(), integrator=ns.MoreauJean(dt=1e-3))
    figure = solution.plot()
    shown = texts(figure)
    assert "coordinate [m]" in shown and "velocity [m/s]" in shown and "number of the\ncoordinate" in shown
    carried = solution.P_N.sum(axis=0)
    assert set(loads_of(solution).contacts) == set(np.flatnonzero(carried))  # five or six of 30
    assert faults(figure) == []


def test_coordinates_of_metres_and_of_radians_have_axes_of_their_own(seizing_rod):
    shown = texts(seizing_rod.plot())
    assert {"y\n[m]", "θ\n[rad]", "y'\n[m/s]", "θ'\n[rad/s]"} <= set(shown)


def test_a_seized_screw_stands_still_in_its_figure():
    screw = LeadScrew()
    solution = ns.simulate(screw, (0, 1e-3), *screw.state(th=0.0, thdot=-1.0), integrator=ns.MoreauJean(dt=1e-5))
    assert 0 < np.ptp(solution.q[:, 1]) < 1e-15  # rounding, which would fill the axis
    (angle,) = (axes for axes in solution.plot().axes if axes.get_ylabel() == "θ\n[rad]")
    assert np.ptp(angle.get_ylim()) > 1e-5 * np.abs(solution.u[:, 1]).max()


@pytest.mark.parametrize("model", [InclinedBlock(), LeadScrew(), SelfLockingRod()], ids=lambda model: model.name)
def test_a_default_run_moves_and_changes_its_mode(model):
    solution = ns.simulate(model, (0, model.t_end), *model.state(), integrator=ns.MoreauJean(dt=model.dt))
    assert np.ptp(solution.q, axis=0).max() > 0.1 and len(np.unique(solution.mode[1:])) > 1


@pytest.mark.upkeep
@pytest.mark.filterwarnings("ignore::nonsmooth.SimultaneousImpactWarning")  # of the slider-crank
@pytest.mark.parametrize("name", sorted(model_entries()))
def test_no_letter_of_a_run_stands_outside_or_over_another_and_every_axis_has_a_unit(name):
    model = load_model(name)()
    t_end = min(model.t_end, 1.0)
    solution = ns.simulate(model, (0, t_end), *model.state(), integrator=ns.MoreauJean(dt=max(model.dt, t_end / 1000)))
    assert faults(solution.plot()) == []
    if hasattr(model, "shape"):
        assert faults(solution.picture(n=3)) == []


def test_a_fast_motion_has_twenty_five_frames_a_period_and_its_title_says_how_slow():
    def mass(t, q, p, M):
        M[0, 0] = 1.0

    def force(t, q, u, p, h):
        h[0] = -((2 * np.pi * 20) ** 2) * q[0]

    system = ns.System(n_q=1, mass=mass, force=force)
    solution = ns.simulate(system, (0, 1), [1.0], [0.0], integrator=ns.MoreauJean(dt=1e-3))
    shown, slow = frames_of(solution, 25, periods=periods_of(solution))
    assert len(shown) >= 25 * 19.5 and "times slower" in slow  # 20 periods, the last reversal at the end
    np.testing.assert_allclose(np.diff(solution.t[shown]), 1 / (len(shown) - 1), atol=1.01e-3)


def test_a_motion_of_too_many_periods_is_shown_in_part_and_says_so(ball):
    t = np.linspace(0, 10, 20_001)
    fast = replace(ball, t=t, u=np.cos(2 * np.pi * 100 * t)[:, None])
    shown, slow = frames_of(fast, 25, periods=periods_of(fast))
    assert len(shown) == MAX_FRAMES and "the first 0.4 s of 10 s" in slow
    assert t[shown[-1]] == pytest.approx(0.4, rel=1e-2)


def test_frames_are_equally_spaced_in_time_and_title_says_how_slow(ball):
    shown, slow = frames_of(ball, 25)
    n = len(shown)
    assert n >= 50 and np.allclose(np.diff(ball.t[shown]), 2 / (n - 1), atol=1.01e-3)
    assert slow == "" and frames_of(ball, 600)[1] == ", 1.2 times faster"  # 1000 frames at 600 a second for 2 s


def test_the_one_instant_of_a_picture_is_the_last(ball):
    (axes,) = ball.picture(n=1).axes
    assert axes.get_title() == "t = 2 s"


def test_a_picture_shows_the_scene_at_its_instants(ball, tmp_path):
    figure = ball.picture(tmp_path / "ball.png", n=3)
    (axes,) = figure.axes
    assert axes.get_title() == "t = 0, 1, 2 s, the later the darker"
    centres = sorted(line.get_ydata().mean() for line in axes.lines if line.get_alpha())
    at_instants = ball.q[np.searchsorted(ball.t, [0, 1 - 1e-9, 2 - 1e-9]), 0]
    radius = np.ptp(axes.lines[-1].get_ydata()) / 2
    assert np.allclose(np.diff(centres), np.diff(np.sort(at_instants)), atol=radius / 8)  # the mean of 17 points


def test_a_picture_needs_a_model_with_a_shape(ball, tmp_path):
    loaded = ns.Solution.load(ball.save(tmp_path / "ball.npz"))
    assert loaded.picture() is not None
    with pytest.raises(ns.InvalidInput, match="shape"):
        without_model(loaded).picture()


@pytest.mark.upkeep
def test_an_animation_has_a_frame_for_each_instant_and_a_white_ground(ball, tmp_path):
    from PIL import Image

    with Image.open(ball.animate(tmp_path / "ball.gif", fps=10)) as gif:
        assert gif.n_frames >= 25 and gif.info["duration"] == 100
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
    labels = [axes.get_ylabel() for axes in solution.plot().axes]
    assert not any("force" in label for label in labels) and any("impulse" in label for label in labels)


def lightness(colour):
    """CIE L* of a colour #rrggbb."""
    channels = np.array([int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5)])
    linear = np.where(channels <= 0.04045, channels / 12.92, ((channels + 0.055) / 1.055) ** 2.4)
    Y = linear @ [0.2126, 0.7152, 0.0722]
    return 116 * np.cbrt(Y) - 16 if Y > 0.008856 else 903.3 * Y


def test_modes_are_told_apart_in_grey():
    steps = np.diff(sorted(lightness(colour) for colour in STRIPS.values()))
    assert steps.min() > 6  # some three times the least difference that is seen


def test_terms_of_the_energy_are_told_apart_in_grey():
    for (one, a), (other, b) in itertools.combinations(ENERGIES.values(), 2):
        assert a != b or abs(lightness(one) - lightness(other)) > 20  # of CIE L*: a third of what black on white has


def test_curves_of_several_contacts_are_told_apart_in_grey():
    block = RockingBlock()
    solution = ns.simulate(block, (0, 1), *block.state(), integrator=ns.MoreauJean(block.dt))
    panels = {axes.get_ylabel(): axes for axes in solution.plot().axes}
    for kind in ("normal [N]", "friction [N]"):
        curves = [patch for patch in panels[kind].patches if patch.get_label().startswith("contact")]
        assert len(curves) == len({patch.get_linestyle() for patch in curves}) == 2
    dots = [line for line in panels["impulse of\nshocks [N s]"].lines if "contact" in line.get_label()]
    filled = {line.get_label(): line.get_markerfacecolor() != "none" for line in dots}
    assert len(filled) == 4 and all(is_filled == name.startswith("normal") for name, is_filled in filled.items())
    assert len({line.get_marker() for line in dots}) == 2


# Machado, Oliveira and Fernandes, A physiologically-based model for simulation of color vision deficiency (2009)
BLINDNESS = {
    "protanopia": [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]],
    "deuteranopia": [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]],
    "tritanopia": [[1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602], [0.004733, 0.691367, 0.303900]],
}


@pytest.mark.parametrize("blindness", BLINDNESS)
@pytest.mark.parametrize("colours", [CYCLE, tuple(STRIPS.values())], ids=["cycle", "modes"])
def test_colours_are_told_apart_without_one_kind_of_cones(blindness, colours):
    seen = [lab_without(BLINDNESS[blindness], colour) for colour in colours]
    differences = [np.linalg.norm(a - b) for a, b in itertools.combinations(seen, 2)]
    assert min(differences) > 8  # of CIE L*a*b*, where 2.3 is just noticeable


def lab_without(matrix, colour):
    """CIE L*a*b* of a colour as it is seen with a deficiency."""
    channels = np.array([int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5)])
    linear = np.where(channels <= 0.04045, channels / 12.92, ((channels + 0.055) / 1.055) ** 2.4)
    linear = np.clip(np.array(matrix) @ linear, 0, 1)
    to_xyz = np.array([[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]])
    f = np.cbrt(np.maximum(to_xyz @ linear / [0.9505, 1.0, 1.089], 1e-6))
    return np.array([116 * f[1] - 16, 500 * (f[0] - f[1]), 200 * (f[1] - f[2])])


def test_an_energy_has_its_colour_whatever_other_terms_there_are(ball, seizing_rod):
    def colours(solution):
        rows = [axes for axes in axes_of(solution.plot()) if "[J]" in axes.get_ylabel()]
        return {line.get_label(): (line.get_color(), line.get_linestyle()) for axes in rows for line in axes.lines}

    one, other = colours(ball), colours(seizing_rod)
    shared = one.keys() & other.keys()
    assert len(shared) >= 3 and all(one[name] == other[name] for name in shared)


@pytest.mark.upkeep
def test_works_that_grow_do_not_flatten_the_energies(ball):
    """A belt works as long as it runs while the oscillator keeps its energy: each has axes; those of a ball are one."""
    belt = BeltOscillator(vb=0.2)
    sol = ns.simulate(belt, (0, 20), *belt.state(), integrator=ns.MoreauJean(dt=1e-3))
    energies, works = [axes for axes in axes_of(sol.plot()) if "[J]" in axes.get_ylabel()]
    assert {line.get_label() for line in energies.lines} == {"kinetic energy", "potential energy"}
    assert {line.get_label() for line in works.lines} == {"work: force", "work: friction", "work: surface"}
    assert energies.get_ylim()[1] < 0.1 * works.get_ylim()[1] and faults(sol.plot()) == []
    assert len([axes for axes in axes_of(ball.plot()) if "[J]" in axes.get_ylabel()]) == 1


def test_some_panels_make_a_figure_of_their_own(ball, seizing_rod, tmp_path):
    figure = ball.plot(tmp_path / "some.png", panels=["modes", "energy"])
    assert [axes.get_ylabel() for axes in figure.axes] == ["change of\nenergy [J]", "mode"]
    assert faults(figure) == []
    assert figure.get_figheight() < 0.5 * ball.plot().get_figheight()
    assert any("rad/s" in axes.get_ylabel() for axes in axes_of(seizing_rod.plot(panels=["phase plane", "modes"])))
    stack = BoxStack(n=2, dim=2)
    run = ns.simulate(stack, (0, 0.01), integrator=ns.MoreauJean(dt=stack.dt))
    assert [axes.get_xlabel() for axes in axes_of(run.plot(panels=["bodies", "energy"]))] == ["x [m]", "x [m]", "t [s]"]
    for sol, panels, said in (
        (ball, ["enrgy"], "did you mean 'energy'"), (run, ["modes"], "there is no panel 'modes'"),
        (ball, [], "must name one at least; there are coordinates"), (ball, "energy", "must be a list of names"),
        (seizing_rod, ["phase plane"], "must name a history"), (run, ["bodies"], "must name a history"),
    ):  # fmt: skip
        with pytest.raises(ns.InvalidInput, match=said):
            sol.plot(panels=panels)


def test_a_picture_reaches_to_what_stands_near_and_no_farther():
    low, high = with_surroundings(np.zeros(2), np.ones(2), [
        np.array([[-5.0, -0.2], [5.0, -0.2]]),  # the ground: passes below, and is longer than the motion
        np.array([[1.8, 0.0], [1.8, 9.0]]),  # a wall
        np.array([[4.0, 0.0], [4.0, 9.0]]),  # another, farther away than the motion is large
    ])  # fmt: skip
    assert low.tolist() == [0.0, -0.2] and high.tolist() == [1.8, 1.0]


def axes_of(figure):
    return list(dict.fromkeys(axes for part in (figure, *figure.subfigs) for axes in part.axes))


def test_a_figure_is_laid_out_and_drawn_once_where_it_is_saved_and_looks_as_matplotlib_saves_it(
    seizing_rod, tmp_path, monkeypatch
):
    from matplotlib.figure import Figure
    from matplotlib.layout_engine import ConstrainedLayoutEngine
    from PIL import Image

    counts = {"draw": 0, "execute": 0}

    def counted(kind, name):
        plain = getattr(kind, name)

        def counting(*arguments):
            counts[name] += 1
            return plain(*arguments)

        monkeypatch.setattr(kind, name, counting)

    counted(Figure, "draw")
    counted(ConstrainedLayoutEngine, "execute")
    figure = seizing_rod.plot(tmp_path / "once.png")
    assert counts == {"draw": 1, "execute": 1}
    assert isinstance(figure.get_layout_engine(), ConstrainedLayoutEngine) and figure.dpi != 150  # as it was before
    seizing_rod.plot().savefig(tmp_path / "twice.png", dpi=150)
    once, twice = (np.asarray(Image.open(tmp_path / f"{name}.png").convert("RGB")) for name in ("once", "twice"))
    assert once.shape == twice.shape and (once == twice).all()


@pytest.mark.parametrize("ending", ["pdf", "svg", "jpg", "webp"])
def test_every_format_is_saved_at_its_size(ball, tmp_path, ending):
    assert ball.plot(tmp_path / f"ball.{ending}").get_layout_engine() is not None
    assert (tmp_path / f"ball.{ending}").stat().st_size > 5_000


@pytest.mark.parametrize(("typed", "drawn"), [
    ("th", "θ"), ("thdot", "θ'"), ("th0", "θ0"), ("th1dot", "θ1'"), ("mu", "μ"), ("mu_k", "μ_k"), ("xdot", "x'"),
    ("vb", "vb"), ("kth", "kth"), ("thick", "thick"), ("dot", "dot"), ("q[0]", "q[0]"), ("θ", "θ"), ("tilt_rate",) * 2,
])  # fmt: skip
def test_a_name_has_one_spelling_in_every_figure(typed, drawn):
    assert spelt(typed) == drawn == spelt(drawn)


def test_names_within_a_title_are_spelt_so_and_its_words_are_not():
    said = with_spelt_names("m = 2  mu = 1.3  th0 = 0.78; e_N = 1 (zeta = 0 chosen, not of mu)")
    assert said == "m = 2  \u03bc = 1.3  \u03b80 = 0.78; e_N = 1 (\u03b6 = 0 chosen, not of mu)"


def test_axes_titles_and_the_player_spell_a_name_alike(seizing_rod):
    """Angle and friction of the same rod, in a run, a map and a sweep."""
    chart = ns.paradox_map(SpragSlip(), th=[0.7, 0.8], mu=[0.5, 1.5], thdot=0.0)
    found = ns.sweep(ns.RunTask(SpragSlip(), "final_state", t_span=(0, 0.01), integrator=ns.MoreauJean(1e-3)),
                     {"mu": [0.5, 0.6], "th": [0.7, 0.8]}, progress=False)  # fmt: skip
    for figure in (ns.plot_map(chart), ns.plot_sweep(found), seizing_rod.plot()):
        words = " ".join(text.get_text() for text in figure.findobj(Text))
        assert "θ" in words and "μ" in words and not re.search(r"\b(th|thdot|mu)\b|theta(?! *=)|\\mu\b", words)
    assert {curve.name for curve in film_of_solution(seizing_rod).curves if curve.group == "coordinates"} == {"y", "θ"}
