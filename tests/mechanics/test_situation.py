"""One rule says of every contact whether it is open, lands, rests or slides, whoever asks."""

import itertools

import numpy as np
import pytest

import nonsmooth as ns
from models import BilateralRod, InclinedBlock, PainleveRod, RockingBlock
from nonsmooth.jit import interpreted
from nonsmooth.mechanics.initial_state import examine_state
from nonsmooth.mechanics.situation import (
    STATE_ACCURACY,
    Situation,
    find_situation,
    largest_closed_gap,
    mode_of_situation,
)
from nonsmooth.mechanics.system import BILATERAL, GIVEN_FORCE, UNILATERAL, ContactMode
from tests.systems import block

NEAR, SLOW, STILL = 1e-3, 1e-2, 1e-1


def at(kind, g_N, gamma_N, gamma_F, goes_on=False):
    return Situation(interpreted(find_situation)(kind, g_N, gamma_N, gamma_F, NEAR, SLOW, STILL, goes_on))


@pytest.mark.parametrize(
    ("g_N", "gamma_N", "gamma_F", "expected"),
    [
        (2 * NEAR, -1.0, 0.0, Situation.OPEN),  # on its way
        (0.0, 2 * SLOW, 0.0, Situation.OPEN),  # parting
        (0.0, -2 * SLOW, 0.0, Situation.LANDING),
        (NEAR, SLOW, STILL, Situation.RESTING),  # as large as counts as zero
        (-NEAR, -SLOW, -STILL, Situation.RESTING),
        (0.0, 0.0, 2 * STILL, Situation.SLIDING),
        (0.0, 0.0, -2 * STILL, Situation.SLIDING),
        (-2 * NEAR, 0.0, 0.0, Situation.PENETRATING),
    ],
)
def test_a_unilateral_contact_is_what_its_gap_and_its_velocities_say(g_N, gamma_N, gamma_F, expected):
    assert at(UNILATERAL, g_N, gamma_N, gamma_F) == expected


def test_a_bilateral_contact_has_neither_gap_nor_normal_velocity():
    for sign in (-1.0, 1.0):
        assert at(BILATERAL, 2 * NEAR * sign, 0.0, 0.0) == Situation.VIOLATED
        assert at(BILATERAL, 0.0, 2 * STILL * sign, 0.0) == Situation.MOVING_APART
        assert at(BILATERAL, NEAR * sign, STILL * sign, 0.0) == Situation.RESTING


def test_a_contact_with_a_given_normal_force_is_always_closed():
    assert at(GIVEN_FORCE, 1.0, 1.0, 0.0) == Situation.RESTING
    assert at(GIVEN_FORCE, 1.0, 1.0, 1.0) == Situation.SLIDING


def test_a_run_that_goes_on_takes_contradictions_as_zero():
    assert at(UNILATERAL, -1.0, 0.0, 1.0, goes_on=True) == Situation.SLIDING
    assert at(UNILATERAL, -1.0, 1.0, 1.0, goes_on=True) == Situation.OPEN
    assert at(BILATERAL, 1.0, 1.0, 0.0, goes_on=True) == Situation.RESTING


def test_compiled_and_interpreted_rules_agree():
    values = (-1.0, -0.05, -5e-3, 0.0, 5e-4, 0.5)
    for kind, *velocities in itertools.product((UNILATERAL, BILATERAL, GIVEN_FORCE), values, values, values):
        for goes_on in (False, True):
            arguments = (kind, *velocities, NEAR, SLOW, STILL, goes_on)
            assert find_situation(*arguments) == interpreted(find_situation)(*arguments)
    for situation, d in itertools.product(Situation, (0, 1)):
        assert mode_of_situation(situation.value, d) == interpreted(mode_of_situation)(situation.value, d)


def test_a_contact_without_friction_is_locked_when_closed():
    modes = [
        ContactMode(interpreted(mode_of_situation)(situation, 0))
        for situation in (Situation.RESTING, Situation.SLIDING)
    ]
    assert modes == [ContactMode.LOCKED, ContactMode.LOCKED]
    assert interpreted(mode_of_situation)(Situation.LANDING, 1) == ContactMode.OPEN


@pytest.mark.parametrize(
    "model", [PainleveRod(), BilateralRod(), RockingBlock(), InclinedBlock()], ids=lambda m: m.name
)
def test_a_start_and_its_classification_agree_on_the_border_of_a_closed_gap_and_of_a_slide(model):
    """Lifted, or pushed, by a little less and a little more than what counts as zero of the state."""
    system, (q, u) = model.system(), model.state(**({"slip": 0.0} if isinstance(model, InclinedBlock) else {}))
    for part, direction in itertools.product((0.5, 2.0), np.eye(system.n_u)):
        for q_1, u_1 in ((q + part * largest_closed_gap(q) * direction, u), (q, u + part * STATE_ACCURACY * direction)):
            start = examine_state(system, 0.0, q_1, u_1)
            try:
                found = ns.classify(system, 0.0, q_1, u_1)
            except ns.InvalidInput as error:
                assert not start.is_admissible or "approaches" in str(error)
                continue
            assert start.is_admissible
            words = {ContactMode.OPEN: "open", ContactMode.STICK: "resting", ContactMode.SLIDE: "sliding"}
            assert [mode.split()[0] for mode in found.mode] == [words[ContactMode(mode)] for mode in start.mode]


@pytest.mark.parametrize("method", [ns.Adaptive, ns.EventDriven])
@pytest.mark.parametrize(
    ("height", "velocity", "expected"),
    [
        (0.0, (0.0, 0.0), ContactMode.STICK),
        (0.0, (0.2, 0.0), ContactMode.SLIDE),
        (0.0, (-0.2, 0.0), ContactMode.SLIDE),
        (0.0, (0.2, 0.4), ContactMode.OPEN),  # thrown up
        (0.1, (0.2, -0.4), ContactMode.OPEN),  # on its way down
    ],
    ids=["rest", "forward", "backward", "parting", "above"],
)
def test_methods_that_decide_within_tolerances_begin_with_the_modes_of_the_situation(
    method, height, velocity, expected
):
    """Adaptive decides by the impulse of a plain step, events by velocities: of states far from a border both say
    what the situation does, through the first moments of the motion."""
    system = block(ns.Contact(mu=0.3, e_N=0.5))
    q, u = np.array([0.0, height]), np.array(velocity)
    start = examine_state(system, 0.0, q, u)
    motion = ns.simulate(system, (0.0, 0.02), q, u, integrator=method(1e-6, 1e-8))
    assert start.mode[0] == expected and len(motion.events) == 0
    assert (motion.mode[:, 0] == expected).all()
    assert (motion.slip[:, 0] == start.slip[0]).all() and start.slip[0] == (
        np.sign(velocity[0]) if expected == ContactMode.SLIDE else 0
    )
