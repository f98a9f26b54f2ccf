"""The scenes of exact friction beside MuJoCo: residuals are what they say, and rows come for every step."""

import numpy as np
import pytest

from benchmarks import exact
from benchmarks.exact_scenes import CASES


class Cube:
    """A contact problem of one contact, whose impulse and velocities a test chooses."""

    n_c, mu = 1, np.array([0.5])
    b, i, j = np.zeros((1, 3)), np.array([0]), np.array([1])
    J_i, J_j = np.zeros((1, 3, 3)), np.eye(3)[None]

    def __init__(self, P, gamma):
        self.P, self.v = np.array([P]), np.array([np.zeros(3), gamma])
        self.v_free = np.array([np.zeros(3), [-1.0, 0.0, 0.0]])


@pytest.mark.parametrize(("P", "gamma", "residual"), [
    ([2.0, 0.5, 0.0], [0.0, 0.0, 0.0], 0.0),  # sticks
    ([2.0, -1.0, 0.0], [0.0, 0.3, 0.0], 0.0),  # slides against friction
    ([2.0, 1.5, 0.0], [0.0, 0.0, 0.0], 0.5 * np.cos(np.arctan(0.5)) / 2),  # outside the cone of friction
    ([2.0, 0.0, 0.0], [-0.25, 0.0, 0.0], 0.25),  # approaches
    ([2.0, 0.0, 0.0], [0.0, 0.3, 0.0], 0.15),  # slides without friction
])  # fmt: skip
def test_the_residual_of_the_cones_is_how_far_a_law_is_missed(P, gamma, residual):
    assert abs(exact.cone_residual(Cube(P, gamma)) - residual) < 1e-15


def test_a_scene_has_rows_at_three_steps_without_missed_ones_and_with_its_closed_form():
    rows = [exact.ours(CASES["backspin"], 1 / rate) for rate in exact.STEPS]
    for found, rate in zip(rows, exact.STEPS, strict=True):
        assert found.missed == f"0 of {4 * rate}" and found.natural < 1e-8 and found.cones < 1e-8
        assert CASES["backspin"].error(found.places, 1 / rate) < 1e-10


def test_a_scene_in_mujoco_falls_and_slides_as_ours():
    pytest.importorskip("mujoco")
    case, dt = CASES["slope, μ = 0.3"], 1e-3
    assert case.error(exact.mujoco(case, dt).places, dt) < 0.05  # of a way of 3.5 m


def test_a_name_that_is_none_is_refused(capsys):
    assert exact.main(["S99"]) == 2
    assert "'S99'" in capsys.readouterr().err
