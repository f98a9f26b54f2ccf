"""Eigenvalues along parameters: tracking of modes, slopes, maps."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import nonsmooth as ns
from models import BeltOscillator, FollowerForceArm, ModeCoupling, SpragSlip
from nonsmooth.drawing.labels import spelt


def test_uncoupled_modes_keep_their_names_where_their_frequencies_cross():
    # Without the oblique spring and friction, x has the frequency sqrt(kx/m) and z sqrt(kz/m): they cross at kx = kz.
    path = ns.eigen_path(ModeCoupling(k=0.0, mu=0.0, cx=0.0, cz=0.0), "kx", np.linspace(100.0, 301.0, 24))
    for k in range(4):
        shape = np.abs(path.mode_shapes[:, :, k])
        assert np.abs(np.diff(shape, axis=0)).max() < 1e-9  # a mode that swapped would turn from x to z
        moves = shape[0, 0] > 0.5
        expected = np.sqrt(path.values) if moves else np.sqrt(200.0) + 0 * path.values
        np.testing.assert_allclose(np.abs(path.eigenvalues[:, k].imag), expected, rtol=1e-12)


def test_frequencies_of_the_arm_meet_and_part_into_growth_and_decay():
    path = ns.eigen_path(FollowerForceArm(), "P", np.linspace(0.0, 1200.0, 61))
    ((before, after, was, became),) = path.changes
    assert before < 948.126555160 < after
    assert (was, became) == (ns.Verdict.MARGINAL, ns.Verdict.FLUTTER)
    stable = path.values < 948.0
    assert np.abs(path.growth[stable]).max() < 1e-9
    for P, s in zip(path.values, path.eigenvalues, strict=True):
        exact = FollowerForceArm(P=P).eigenvalues()
        assert max(np.abs(exact - x).min() for x in s) < 1e-9 * 60
    assert np.abs(np.diff(path.eigenvalues[stable].imag, axis=0)).max() < 3.0  # no curve jumps to another


def test_path_backwards_finds_the_same_eigenvalues():
    values = np.linspace(0.3, 0.7, 9)
    forth, back = (ns.eigen_path(ModeCoupling(), "mu", v) for v in (values, values[::-1]))
    np.testing.assert_allclose(
        np.sort_complex(forth.eigenvalues), np.sort_complex(back.eigenvalues[::-1]), rtol=1e-11, atol=1e-11
    )


def test_path_through_an_equilibrium_that_becomes_virtual_says_so():
    path = ns.eigen_path(ModeCoupling(), "R", np.linspace(500.0, -100.0, 7))
    np.testing.assert_array_equal(path.is_virtual, path.values <= 0)


@pytest.mark.parametrize("values, message", [([0.3, 0.3], "order"), ([0.3, 0.5, 0.4], "order"), ([], "at least one")])
def test_values_out_of_order_are_refused(values, message):
    with pytest.raises(ns.InvalidInput, match=message):
        ns.eigen_path(ModeCoupling(), "mu", values)


def test_path_names_the_value_at_which_no_equilibrium_is_left():
    with pytest.raises(ns.InvalidInput, match=r"at kx = 0.*not isolated"):
        ns.eigen_path(ModeCoupling(k=0.0), "kx", [10.0, 5.0, 0.0])


@pytest.mark.parametrize("name, slope", [
    ("c", lambda b: -0.5 / b.m),
    ("N", lambda b: -0.5 * b.slope() / b.m),
    ("vb", lambda b: -0.5 * b.N * 6 * b.m3 * b.vb / b.m),
    ("m", lambda b: 0.5 * (b.c + b.N * b.slope()) / b.m**2),
])  # fmt: skip
def test_slope_of_the_belts_growth_is_that_of_its_closed_form(name, slope):
    belt = BeltOscillator(vb=0.3)
    assert ns.eigenvalue_sensitivity(belt, name).real == pytest.approx(2 * [slope(belt)], rel=1e-8)


@pytest.mark.parametrize("model, name", [
    (ModeCoupling(), "mu"), (ModeCoupling(), "cz"), (FollowerForceArm(P=1000.0), "P"), (SpragSlip.set_1(), "cth"),
    (SpragSlip.set_1(), "th0"),
])  # fmt: skip
def test_slopes_are_those_of_the_eigenvalues_themselves(model, name):
    p = getattr(model, name)
    h = 1e-4 * p  # a fourth-order difference: truncation (1e-4)^4 of a scale of 100 p, rounding 1e-11 of the slope
    s = [ns.linearise(replace(model, **{name: p + k * h})).eigenvalues for k in (-2, -1, 0, 1, 2)]
    s = [np.array([row[np.abs(row - x).argmin()] for x in s[2]]) for row in s]
    slope = (s[0] - 8 * s[1] + 8 * s[3] - s[4]) / (12 * h)
    exact = ns.eigenvalue_sensitivity(model, name)
    np.testing.assert_allclose(exact, slope, rtol=1e-7, atol=1e-7 * np.abs(slope).max())


def test_slope_at_the_end_of_a_parameters_range_is_taken_to_one_side():
    slopes = ns.eigenvalue_sensitivity(ModeCoupling(cz=0.0, mu=0.0), "cz")
    ahead = (
        ns.linearise(ModeCoupling(cz=1e-6, mu=0.0)).eigenvalues - ns.linearise(ModeCoupling(cz=0.0, mu=0.0)).eigenvalues
    )
    np.testing.assert_allclose(slopes, ahead / 1e-6, rtol=1e-5, atol=1e-7)


def test_unknown_parameter_of_a_slope_is_refused():
    with pytest.raises(ns.UnknownName, match="vb"):
        ns.eigenvalue_sensitivity(BeltOscillator(), "vbb")


def test_map_agrees_with_single_points_and_its_slopes_with_its_own_differences():
    mu, cz = np.linspace(0.4, 0.7, 4), np.linspace(0.5, 3.0, 3)
    chart = ns.stability_map(ModeCoupling(), {"mu": mu, "cz": cz})
    assert chart.growth.dims == ("mu", "cz")
    for i, j in np.ndindex(4, 3):
        small = ns.linearise(ModeCoupling(mu=mu[i], cz=cz[j]))
        assert chart.growth.values[i, j] == pytest.approx(small.growth, rel=1e-10)
        assert chart.verdict.values[i, j] == small.verdict
    fine = ns.stability_map(ModeCoupling(), {"mu": [0.6, 0.6 + 1e-6], "cz": [1.0, 1.0 + 1e-6]})
    g = fine.growth.values
    assert fine.d_growth_d_mu.values[0, 0] == pytest.approx((g[1, 0] - g[0, 0]) / 1e-6, rel=1e-5)
    assert fine.d_growth_d_cz.values[0, 0] == pytest.approx((g[0, 1] - g[0, 0]) / 1e-6, rel=1e-4)


def test_map_without_slopes_has_none_and_marks_what_has_no_equilibrium():
    chart = ns.stability_map(ModeCoupling(k=0.0), {"kx": [100.0, 0.0], "cx": [1.0]}, sensitivities=False)
    assert np.isfinite(chart.growth.values[0, 0]) and np.isnan(chart.growth.values[1, 0])
    assert "d_growth_d_kx" not in chart


def test_map_needs_two_parameters():
    with pytest.raises(ns.InvalidInput, match="two parameters"):
        ns.stability_map(ModeCoupling(), {"mu": [0.5]})


@pytest.mark.parametrize(
    ("model", "name", "low", "high"),
    [(FollowerForceArm(), "P", 0.0, 1200.0), (BeltOscillator(m1=0.0, c=10.0), "k", 5.0, 60.0)],
)
def test_names_of_modes_do_not_depend_on_the_values_chosen(model, name, low, high):
    """Two frequencies of the arm meet at P = 948 N; the mass on the belt is overdamped below k = c^2/4m = 25 N/m."""
    paths = [ns.eigen_path(model, name, np.linspace(low, high, n)) for n in (7, 13, 25, 73)]
    for path in paths[1:]:
        every = (len(path.values) - 1) // 6
        scale = np.abs(path.eigenvalues).max()
        assert np.abs(path.eigenvalues[::every] - paths[0].eigenvalues).max() < 1e-6 * scale


@pytest.mark.parametrize("n", [7, 25])
def test_names_of_modes_behind_flutter_do_not_depend_on_rounding(n):
    """What the two ways through the branch point of the arm cost differs by rounding alone."""
    values = np.linspace(0.0, 1200.0, n)
    for k in range(12):
        path = ns.eigen_path(FollowerForceArm(k1=1000.0 * (1 + k * 2e-16)), "P", values)
        behind = path.eigenvalues[values > 948.0]
        assert (behind[:, 0].real > 1.0).all() and (np.diff(np.abs(path.eigenvalues[0])) >= -1e-9).all()
        assert (behind[:, 1] == behind[:, 0].conj()).all() and (behind[:, 2:].real < -1.0).all()


@pytest.mark.parametrize(("model", "parameter", "values"), [
    (ModeCoupling(), "mu", np.linspace(0, 1, 5)), (ModeCoupling(), "mu", np.linspace(0.9, 0.1, 12)),
    (FollowerForceArm(), "P", np.linspace(0, 2000, 4)),
])  # fmt: skip
def test_the_figure_says_where_stability_is_lost_as_the_solver_does_however_few_values_there_are(
    model, parameter, values
):
    path = ns.eigen_path(model, parameter, values)
    (before, after, was, becomes), *_ = path.changes
    exact = ns.flutter_boundary(model, parameter, (min(before, after), max(before, after))).value
    said = "\n".join(axes.get_title(loc="left") for axes in path.plot().axes)
    assert f"{spelt(parameter)} = {exact:.9g}" in said
    assert path.boundary(before, after).value == pytest.approx(exact, rel=1e-11)
    lines = [line for axes in path.plot().axes[:2] for line in axes.lines if len(set(line.get_xdata())) == 1]
    assert any(line.get_xdata()[0] == pytest.approx(exact, rel=1e-11) for line in lines)


def test_a_change_that_is_no_loss_of_stability_is_given_between_its_two_values():
    """Two unstable verdicts follow each other: nothing is solved, and no digits are made up."""
    path = ns.eigen_path(ModeCoupling(), "mu", np.linspace(0, 1, 5))
    unstable = [
        point for point, verdict in zip(path.points, path.verdicts, strict=True) if verdict > ns.Verdict.MARGINAL
    ]
    verdicts = np.array([ns.Verdict.FLUTTER, ns.Verdict.DIVERGENCE])
    two = replace(
        path, values=path.values[-2:], eigenvalues=path.eigenvalues[-2:], mode_shapes=path.mode_shapes[-2:],
        verdicts=verdicts, is_virtual=path.is_virtual[-2:], points=tuple(unstable[-2:]),
    )  # fmt: skip
    assert two.boundary(0.75, 1.0) is None
    assert "divergence from between μ = 0.75 and 1" in two.plot().axes[1].get_title(loc="left")
