"""Rough contacts that carry nothing: a slide without load has the force zero, which is a solution and no paradox."""

import math
from typing import NamedTuple

import numpy as np
import pytest

import nonsmooth as ns

G = 9.81
METHODS = [ns.EventDriven(), ns.Adaptive(), ns.MoreauJean(1e-3)]
NAMES = [type(method).__name__ for method in METHODS]


class Wire(NamedTuple):
    """A straight rough wire at an angle to the vertical, with a row of friction that is tilted to it."""

    tilt: float = 0.0  # [rad]
    coupling: float = 0.0  # tangential row over the normal one
    load: float = 0.0  # [m/s^2] across the wire
    g: float = G  # [m/s^2] along it
    mu: float = 0.3


def mass(t, q, p, M):
    M[0, 0] = M[1, 1] = 1.0


def force(t, q, u, p, h):
    h[0] = p.load * math.cos(p.tilt) + p.g * math.sin(p.tilt)
    h[1] = p.load * math.sin(p.tilt) - p.g * math.cos(p.tilt)


def gap(t, q, p, g_N):
    g_N[0] = q[0] * math.cos(p.tilt) + q[1] * math.sin(p.tilt)


def tangent(t, q, p, W_F):
    W_F[0, 0, 0] = -math.sin(p.tilt) + p.coupling * math.cos(p.tilt)
    W_F[0, 0, 1] = math.cos(p.tilt) + p.coupling * math.sin(p.tilt)


def bead(wire):
    contact = ns.Contact(mu="mu", bilateral=True)
    return ns.System(
        coordinates=["x", "y"], mass=mass, force=force, gap=gap, tangent=tangent, contacts=[contact], parameters=wire
    )


WIRES = {
    "upright": Wire(),
    "tilted, so that the load is rounding": Wire(tilt=0.7),
    "without any force": Wire(g=0.0),
}
SELF_LOCKING = {
    "D < 0 for one sign of the force": Wire(tilt=-1.1, coupling=2.0, mu=0.8),
    "D = 0": Wire(coupling=1.0, mu=1.0),
}


@pytest.mark.parametrize("v", [0.0, -0.1, 0.1])  # [m/s] along the wire: at rest, downwards, thrown up
@pytest.mark.parametrize("integrator", METHODS, ids=NAMES)
@pytest.mark.parametrize("name", WIRES)
def test_a_bead_falls_freely_along_a_rough_wire(name, integrator, v):
    falls_freely(WIRES[name], integrator, v)


@pytest.mark.parametrize("integrator", METHODS[:2], ids=NAMES[:2])
@pytest.mark.parametrize("name", SELF_LOCKING)
def test_it_slides_on_where_it_might_jam_at_rest(name, integrator):
    """mu |G_NF| >= G_NN: at rest impulses of friction hold it as well; rounding of the load must not make it jam."""
    falls_freely(SELF_LOCKING[name], integrator, -0.1)


def falls_freely(wire, integrator, v):
    along = np.array([-math.sin(wire.tilt), math.cos(wire.tilt)])
    state = ns.classify(bead(wire), 0.0, [0.0, 0.0], v * along)
    assert state.n_solutions == 1 and state.kind == ns.ParadoxKind.REGULAR
    t = np.linspace(0.0, 0.3, 7)
    sol = ns.simulate(bead(wire), (0.0, 0.3), [0.0, 0.0], v * along, integrator=integrator, t_eval=t[1:])
    assert sol.success and not sol.paradoxes
    np.testing.assert_allclose(sol.q[-6:] @ along, v * t[1:] - wire.g * t[1:] ** 2 / 2, rtol=0, atol=1e-12)
    np.testing.assert_allclose(np.ptp(sol.P_N), 0.0, atol=1e-12)


@pytest.mark.parametrize("integrator", METHODS, ids=NAMES)
def test_friction_begins_with_the_load(integrator):
    """A load that changes its sign at t = 0.1 s: |N| = |a (t - 0.1)|, the friction takes mu times its integral."""
    rate, mu = 40.0, 0.3

    def pull(t, q, u, p, h):
        h[0] = rate * (t - 0.1)
        h[1] = -G

    system = ns.System(
        coordinates=["x", "y"], mass=mass, force=pull, gap=gap, tangent=tangent, parameters=Wire(mu=mu),
        contacts=[ns.Contact(mu="mu", bilateral=True)],
    )  # fmt: skip
    sol = ns.simulate(system, (0.0, 0.3), [0.0, 0.0], [0.0, -1.0], integrator=integrator)
    taken = mu * rate * (0.1**2 + 0.2**2) / 2
    assert sol.success and sol.u[-1, 1] == pytest.approx(
        -1.0 - G * 0.3 + taken, abs=1e-3 if sol.stats.steps > 200 else 1e-6
    )


def guided_rod(t, q, p, g_N):
    g_N[0] = q[0] + 0.4 * math.sin(q[2])


def rod_tangent(t, q, p, W_F):
    W_F[0, 0, 1] = 1.0
    W_F[0, 0, 2] = -0.4 * math.sin(q[2])


@pytest.mark.parametrize("integrator", METHODS, ids=NAMES)
def test_a_rod_hangs_from_a_wire_and_falls_with_it(integrator):
    def rod_mass(t, q, p, M):
        M[0, 0] = M[1, 1] = 1.2
        M[2, 2] = 0.064

    def weight(t, q, u, p, h):
        h[1] = -1.2 * G

    system = ns.System(
        coordinates=["x", "y", "th"], mass=rod_mass, force=weight, gap=guided_rod, tangent=rod_tangent,
        contacts=[ns.Contact(mu=0.5, bilateral=True)],
    )  # fmt: skip
    sol = ns.simulate(system, (0.0, 0.2), np.zeros(3), np.zeros(3), integrator=integrator)
    assert sol.success and sol.q[-1] == pytest.approx([0.0, -G * 0.02, 0.0], abs=1e-12)


class Wedge(NamedTuple):
    """A particle between two rough lines at right angles, one of which may hold it on both sides."""

    a: float = 0.0  # [m/s^2]


@pytest.mark.upkeep
@pytest.mark.parametrize("integrator", METHODS, ids=NAMES)
@pytest.mark.parametrize("kinds", [(True, True), (True, False), (False, False)])
def test_two_rough_contacts_without_load_hold_a_particle_at_rest(kinds, integrator):
    def free(t, q, u, p, h):
        h[0] = h[1] = p.a

    def gaps(t, q, p, g_N):
        g_N[0], g_N[1] = q[0], q[1]

    def tangents(t, q, p, W_F):
        W_F[0, 0, 1] = W_F[1, 0, 0] = 1.0

    contacts = [ns.Contact(mu=0.5, bilateral=is_bilateral) for is_bilateral in kinds]
    system = ns.System(
        coordinates=["x", "y"], mass=mass, force=free, gap=gaps, tangent=tangents, contacts=contacts, parameters=Wedge()
    )
    state = ns.classify(system, 0.0, np.zeros(2), np.zeros(2))
    assert state.n_solutions == 1 and state.is_complete
    sol = ns.simulate(system, (0.0, 0.1), np.zeros(2), np.zeros(2), integrator=integrator)
    assert sol.success and not sol.q.any() and not sol.u.any()
