"""Redundant contacts: one acceleration, many loads. What holds is judged by the one, and the load is admissible."""

import numpy as np
import pytest

import nonsmooth as ns
from benchmarks.stress_scenes import box_in_corner, groove

G = 9.81
EXACT = ns.EventDriven(rtol=1e-10, atol=1e-12)
EPS = float(np.finfo(float).eps)


def run(system, t_end, integrator=EXACT, **options):
    return ns.simulate(
        system, (0.0, t_end), np.zeros(system.n_q), np.zeros(system.n_u), integrator=integrator, **options
    )


def still(system, t_end=0.1):
    """A plane_contacts system has the time as its last coordinate; the run from rest at t = 0."""
    start = np.zeros(system.n_q)
    return ns.simulate(system, (0.0, t_end), start, np.zeros(system.n_u), integrator=EXACT)


@pytest.mark.parametrize("angle", [1e-2, 1e-4, 1e-7, 1e-8, 3e-9, 1e-11])
def test_planes_that_are_nearly_one_share_the_weight(angle):
    solution = still(groove(angle))
    assert solution.success and np.abs(solution.g_N[:, :2]).max() <= 1e-15
    la_N = solution.la[-1, :2, 0]
    assert la_N.sum() * np.cos(angle) == pytest.approx(G, rel=1e-12)
    # told apart they differ by the horizontal force that rounding makes of the weight, over the angle: EPS G / angle^2
    # with rows that are rounded too; as one, from 1e-6 rad on, they are equal
    assert la_N == pytest.approx(G / (2 * np.cos(angle)), rel=10 * EPS / angle**2 if angle > 1e-6 else 1e-10)


@pytest.mark.parametrize("angle", [1e-2, 1e-4, 1e-6, 1e-8])
def test_planes_that_are_nearly_opposite_hold_a_particle_by_forces_of_the_inverse_angle(angle):
    solution = still(groove(np.pi / 2 - angle))
    assert solution.success and np.abs(solution.g_N[:, :2]).max() <= 1e-15
    la_N = solution.la[-1, :2, 0]
    assert la_N == pytest.approx(G / (2 * np.cos(np.pi / 2 - angle)), rel=max(1e-9, 10 * EPS / angle))
    assert abs(solution.u[-1, 1]) <= 10 * EPS * la_N.max() * 0.1  # m/s: what the rounding of such forces does in 0.1 s


@pytest.mark.parametrize("mu", [0.1, 1.0, 10.0, 1e3])
@pytest.mark.parametrize("push", [0.0, 1e-3, 1.0, 1e4])
def test_box_in_a_corner_stays_with_a_load_that_is_admissible(mu, push):
    """Eight unknown forces of four contacts, three equations; the least squares of all of them pull at the wall."""
    solution = still(box_in_corner(mu, push))
    assert solution.success and np.abs(solution.q[:, :3]).max() <= EPS * (G + push) * 0.1**2  # rounding of the forces
    la_N, la_F = solution.la[-1, :4, 0], solution.la[-1, :4, 1]
    size = G + push
    assert la_N.min() >= -1e-11 * size
    assert (np.abs(la_F) <= mu * la_N + 1e-11 * size * (1 + mu)).all()
    across, up = la_F[:2].sum() + la_N[2:].sum(), la_N[:2].sum() + la_F[2:].sum()
    turning = 0.1 * (la_N[1] - la_N[0] + la_F[:2].sum() + la_N[2] - la_N[3] - la_F[2:].sum())
    assert (across, up) == (pytest.approx(push, abs=1e-10 * size), pytest.approx(G, abs=1e-10 * size))
    assert turning == pytest.approx(0.0, abs=1e-10 * size)


def box(mu, pull, wall=False, half=0.1, height=0.02):
    """A flat box of 1 kg on the floor, both corners down, pulled to the right by ``pull`` t [N]; to its left a wall."""

    def mass(t, q, p, M):
        M[0, 0] = M[1, 1] = 1.0
        M[2, 2] = (half**2 + height**2) / 3

    def force(t, q, u, p, h):
        h[0], h[1] = pull * t, -G

    def gap(t, q, p, g_N):
        g_N[0], g_N[1] = q[1] - half * q[2], q[1] + half * q[2]
        if wall:
            g_N[2], g_N[3] = q[0] + height * q[2], q[0] - height * q[2]

    def normal(t, q, p, W_N):
        W_N[0, 1], W_N[0, 2] = 1.0, -half
        W_N[1, 1], W_N[1, 2] = 1.0, half
        if wall:
            W_N[2, 0], W_N[2, 2] = 1.0, height
            W_N[3, 0], W_N[3, 2] = 1.0, -height

    def tangent(t, q, p, W_F):
        W_F[0, 0, 0], W_F[0, 0, 2] = 1.0, height
        W_F[1, 0, 0], W_F[1, 0, 2] = 1.0, height
        if wall:
            W_F[2, 0, 1], W_F[2, 0, 2] = 1.0, -half
            W_F[3, 0, 1], W_F[3, 0, 2] = 1.0, -half

    contacts = [ns.Contact(mu=mu)] * (4 if wall else 2)
    return ns.System(n_q=3, mass=mass, force=force, gap=gap, normal=normal, tangent=tangent, contacts=contacts)


@pytest.mark.parametrize("wall", [False, True])
@pytest.mark.parametrize("mu", [0.2, 0.6])
def test_box_on_two_corners_slides_when_both_together_hold_it_no_more(mu, wall):
    """The pull turns the load to the front corner, which then holds the most; together they hold mu m g."""
    pull, t_end = 20.0, 1.0
    system = box(mu, pull, wall)
    solution = run(system, t_end)
    t_slide = mu * G / pull  # s
    slides = [event for event in solution.events if event.mode_after == ns.ContactMode.SLIDE]
    assert sorted(event.contact for event in slides) == [0, 1]
    assert [event.t for event in slides] == pytest.approx([t_slide] * 2, rel=1e-9)
    held = run(system, t_slide, t_eval=np.linspace(0.0, 0.99 * t_slide, 12))
    assert np.abs(held.q).max() <= EPS * G * t_slide**2
    la_N, la_F = held.la[:, :, 0], held.la[:, :, 1]
    assert la_N.min() >= -1e-10 * G and (np.abs(la_F) <= mu * la_N + 1e-9 * G).all()
    assert solution.q[-1, 0] == pytest.approx(pull * (t_end - t_slide) ** 3 / 6, rel=1e-8)
    if wall:
        assert {event.contact for event in solution.events if event.mode_after == ns.ContactMode.OPEN} >= {2, 3}
        assert solution.g_N[-1, 2:] == pytest.approx(solution.q[-1, 0], rel=1e-8)


def test_box_goes_over_its_front_corner_where_its_load_ends():
    """mu = 10: no sliding; the rear corner lifts when the pull at the height h = 0.02 m, F h = m g a, a = 0.1 m."""
    pull = 100.0
    solution = run(box(10.0, pull), 0.55)
    opens = [event for event in solution.events if event.mode_after == ns.ContactMode.OPEN]
    assert [event.contact for event in opens] == [0]
    assert opens[0].t == pytest.approx(G * 0.1 / 0.02 / pull, rel=1e-9)


def test_steps_are_few_where_a_load_is_only_shared():
    """Nothing happens in the corner: one step, no event, whatever the start of the run."""
    solution = still(box_in_corner(1.0, 0.0), t_end=10.0)
    assert solution.stats.steps <= 12 and solution.events == []
