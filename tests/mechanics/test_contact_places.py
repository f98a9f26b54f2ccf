"""Where contacts are drawn: ``Contact(at=...)``."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import pytest
import sympy as sp

import nonsmooth as ns
from nonsmooth.drawing.player.solution_film import film_of_solution


class Block(NamedTuple):
    m: float = 2.0  # mass [kg]
    a: float = 0.3  # half of its width [m]
    g: float = 9.81  # gravity [m/s^2]
    mu: float = 0.4  # friction coefficient


def mass(t, q, p, M):
    M[0, 0] = M[1, 1] = p.m


def force(t, q, u, p, h):
    h[1] = -p.m * p.g


def gap(t, q, p, g_N):
    g_N[0] = g_N[1] = q[1]


def normal(t, q, p, W_N):
    W_N[0, 1] = W_N[1, 1] = 1.0


def tangent(t, q, p, W_F):
    W_F[0, 0, 0] = W_F[1, 0, 0] = 1.0


def right_foot(q, p):
    return (q[0] + p.a, q[1]), (0.0, 1.0)


def shape(q, p):
    return [np.array([[q[0] - p.a, q[1]], [q[0] + p.a, q[1]]])]


def block(at=right_foot, **parameters) -> ns.System:
    """A block on two feet, of which the right one is drawn."""
    contacts = [ns.Contact(mu="mu"), ns.Contact(mu="mu", name="right", at=at)]
    return ns.System(
        coordinates=[("x", "m"), ("y", "m")], mass=mass, force=force, gap=gap, normal=normal, tangent=tangent,
        contacts=contacts, parameters=Block(**parameters), shape=shape,
    )  # fmt: skip


def slide(system: ns.System) -> ns.Solution:
    return ns.simulate(system, (0, 0.1), [0.0, 0.0], [1.0, 0.0], integrator=ns.MoreauJean(dt=1e-2))


def test_a_contact_without_a_place_has_none_and_the_other_follows_the_parameters():
    frames = block(a=0.5).described.contact_frames([1.0, 0.2])
    np.testing.assert_array_equal(frames[0], [[np.nan, np.nan], [1.5, 0.2]])
    np.testing.assert_array_equal([frames[1][1], frames[2][1]], [[0.0, 1.0], [1.0, 0.0]])
    other = block(a=0.5).with_parameters(a=0.7).described.contact_frames([1.0, 0.2])
    assert other[0][1].tolist() == [1.7, 0.2]


def test_no_place_no_frames():
    assert ns.System(n_q=2, mass=mass, force=force, gap=gap, normal=normal, parameters=Block(),
                     contacts=[ns.Contact()] * 2).described.contact_frames is None  # fmt: skip


def test_a_film_has_the_contacts_that_have_a_place_with_their_names_and_forces():
    sol = slide(block())
    film = film_of_solution(sol)
    contacts, frames = film.contacts, len(film.times)
    assert film.contact_names == ("", "right")
    assert contacts.start.tolist() == list(range(frames + 1)) and set(contacts.number.tolist()) == {1}
    np.testing.assert_allclose(contacts.point, sol.q + [0.3, 0.0], atol=1e-12)
    P = contacts.P_N.sum(), contacts.P_F.sum(axis=0)
    assert P[0] == pytest.approx(sol.P_N[:, 1].sum(), rel=1e-12) and P[0] > 0
    np.testing.assert_allclose(P[1], [-0.4 * P[0], 0.0], rtol=1e-12, atol=1e-15)  # friction at its limit, against x


def test_places_change_no_bit_of_a_motion():
    assert slide(block()).q.tobytes() == slide(block(at=None)).q.tobytes()


@pytest.mark.parametrize("returned", [1.0, (1.0, 2.0), ((0.0, 0.0, 0.0), (0.0, 0.0, 1.0)), "here", None])
def test_what_is_no_place_is_refused_with_its_contact(returned):
    with pytest.raises(ns.InvalidInput, match=r"at\(q\) of 'right' must return its point and its normal"):
        block(at=lambda q: returned).described.contact_frames([0.0, 0.0])


@pytest.mark.parametrize("at", [3.0, lambda: 0, lambda a, b, c: 0])
def test_what_is_no_function_of_the_coordinates_is_refused(at):
    with pytest.raises(ns.InvalidInput, match="at of a contact must be a function"):
        ns.Contact(at=at)


def arm() -> ns.Lagrangian:
    """A rod that turns about the origin; its tip slides on a floor below, and a wall moves in time."""
    l = ns.lagrangian("arm")
    th = l.coordinates("th", unit="rad")
    m, a, w = l.parameters(m=(1.0, "kg"), a=(0.5, "m"), w=(1.0, "rad/s"))
    tip = a * sp.Matrix([sp.sin(th), -sp.cos(th)])
    l.rigid_body(m, m * a**2 / 12, at=tip / 2, angle=th)
    l.gravity(9.81)
    l.contact(point=tip, normal=(0, 1), offset=0.9 * a, mu=0.2, name="floor")
    l.contact(point=tip, normal=(-1, 0), offset=2 * a + a * sp.sin(w * l.t), name="wall")
    l.contact(point=tip, normal=(sp.cos(w * l.t), sp.sin(w * l.t)), offset=2 * a, name="turning wall")
    l.contact(gap=th + 2, name="stop")
    l.line((0, 0), tip)
    return l


def test_a_model_from_energies_has_the_places_that_were_declared():
    model = arm().model()
    frames = model.system().described.contact_frames([0.3])
    tip = [0.5 * math.sin(0.3), -0.5 * math.cos(0.3)]
    np.testing.assert_allclose(frames[0][:2], [tip, tip], atol=1e-15)
    np.testing.assert_array_equal(frames[1][:2], [[0.0, 1.0], [-1.0, 0.0]])
    np.testing.assert_array_equal(frames[2][:2], [[1.0, 0.0], [0.0, 1.0]])
    assert np.isnan(frames[0][2:]).all()  # a direction that turns by itself, and a gap without a point


def test_a_tangent_of_its_own_is_the_direction_of_friction():
    l = ns.lagrangian("slider")
    x, y = l.coordinates("x y", unit="m")
    l.point_mass(1.0, at=(x, y))
    l.contact(point=(x, y), normal=(0, 1), tangent=(-1, 0), mu=0.3)
    l.contact(gap=y, point=(x, y), tangent=(-1, 0), mu=0.3)  # on which side the obstacle is, is not said
    frames = np.array(l.model().system().described.contact_frames([0.2, 0.0]))
    np.testing.assert_array_equal(frames[:, 0], [[0.2, 0.0], [0.0, 1.0], [-1.0, 0.0]])
    assert np.isnan(frames[:, 1]).all()
