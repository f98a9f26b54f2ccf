"""A run of a ready scene, and how far its residuals may let bodies at rest move."""

import numpy as np
import pytest

import nonsmooth as ns

TOL = 1e-8


def run(model, t_end=None, dt=None, tol=TOL, **options):
    integrator = ns.MoreauJean(dt=dt or model.dt, contacts=ns.ContactSolver(tol=tol))
    return ns.simulate(model, (0, t_end or model.t_end), integrator=integrator, **options)


def creep(solution):
    """A bound of the way that bodies at rest may go [m].

    A residual tol |P| of impulses is a velocity W tol |P| of the least mass m, W of the order of (1 + r^2 m/I)/m, 4/m
    for a slender box; it lasts for a step, and the next may add to it: t W tol |P| in all.
    """
    masses = [body.mass or body.density * volume(body.shape) for body in solution.scene.bodies if body.kind == 0]
    P = np.linalg.norm(solution.contacts(solution.t[1]).P)
    return (solution.t[-1] - solution.t[0]) * 4 / min(masses) * TOL * P


def volume(shape):
    if isinstance(shape, ns.Polygon):
        x, y = shape.vertices.T
        return 0.5 * abs(x @ np.roll(y, -1) - y @ np.roll(x, -1))
    return np.prod(shape.lengths)


@pytest.fixture
def simulate():
    return run


@pytest.fixture
def most_creep():
    return creep
