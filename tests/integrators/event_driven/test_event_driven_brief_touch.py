"""A contact that touches and parts again within one step is found by located events."""

from typing import NamedTuple

import numpy as np
import pytest

import nonsmooth as ns


class Throw(NamedTuple):
    g: float = 9.81  # gravity [m/s^2]
    ceiling: float = 1.0  # height [m]
    e: float = 0.5  # restitution


def mass(t, q, p, M):
    M[0, 0] = 1.0


def force(t, q, u, p, h):
    h[0] = -p.g


def gap(t, q, p, g_N):
    g_N[0] = p.ceiling - q[0]


def normal(t, q, p, W_N):
    W_N[0, 0] = -1.0


@pytest.mark.parametrize("above", [1e-1, 1e-3, 1e-6])
@pytest.mark.parametrize("span", [0.6, 0.8, 0.9])
def test_ball_that_would_rise_a_little_above_the_ceiling_hits_it(above, span):
    p = Throw()
    contacts = [ns.Contact(e_N="e")]
    ball = ns.System(n_q=1, mass=mass, force=force, gap=gap, normal=normal, contacts=contacts, parameters=p)
    v = np.sqrt(2 * p.g * (p.ceiling + above))
    sol = ns.simulate(ball, (0, span), [0.0], [v], integrator=ns.EventDriven())
    speed = np.sqrt(2 * p.g * above)  # at the ceiling
    t_hit = (v - speed) / p.g
    rest = span - t_hit
    # sqrt: the time of a graze is known to eps v^2/(g speed), its speed to eps v^2/speed
    rounding = 1e-14 * v**2 / speed
    assert [event.kind.name for event in sol.events] == ["IMPACT"]
    assert np.isclose(sol.u[-1, 0], -p.e * speed - p.g * rest, rtol=0, atol=rounding)
    assert np.isclose(sol.q[-1, 0], p.ceiling - p.e * speed * rest - p.g * rest**2 / 2, rtol=0, atol=rounding)
