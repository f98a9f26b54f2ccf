"""Mass, centroid and inertia against closed forms and against points counted inside."""

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.numerics.rounding import EPS
from nonsmooth.scenes.mass_properties import combined, mass_of
from nonsmooth.scenes.shape_rows import BOX, CAPSULE, HULL, SPHERE, ShapeRow

HERE2, HERE3 = (0, 0, 0), (0, 0, 0, 1, 0, 0, 0)
L_SHAPE = [(0.0, 0.0), (2.0, 0.3), (2.4, 1.0), (0.7, 1.5)]


def hull(vertices, r=0.0, place=HERE2):
    return ShapeRow(0, HULL, place, r, vertices=vertices)


def close(found, mass, centroid, inertia):
    assert found.mass == pytest.approx(mass, rel=16 * EPS)
    assert np.abs(found.centroid - centroid).max() < 16 * EPS
    assert np.abs(found.inertia - inertia).max() < 32 * EPS * np.abs(inertia).max()


def test_the_figures_of_every_table():
    r, m = 0.3, 700 * np.pi * 0.3**2
    close(mass_of(hull([(0, 0)], r), 700.0), m, [0, 0], np.full((1, 1), m * r**2 / 2))
    m = 700 * 0.6 * 1.0
    close(mass_of(hull([(0, 0), (0.6, 0), (0.6, 1), (0, 1)]), 700.0), m, [0.3, 0.5],
          np.full((1, 1), m * (0.6**2 + 1) / 12))  # fmt: skip
    m = 500 * 4 / 3 * np.pi * r**3
    close(mass_of(ShapeRow(0, SPHERE, HERE3, r), 500.0), m, [0, 0, 0], 0.4 * m * r**2 * np.eye(3))
    m = 500 * 0.4 * 0.6 * 1.0
    close(mass_of(ShapeRow(0, BOX, HERE3, 0.0, (0.2, 0.3, 0.5)), 500.0), m, [0, 0, 0],
          m / 12 * np.diag([0.36 + 1, 0.16 + 1, 0.16 + 0.36]))  # fmt: skip
    h, tube, ball = 0.5, 500 * np.pi * r**2, 500 * 4 / 3 * np.pi * r**3
    across = tube * 2 * h * (r**2 / 4 + h**2 / 3) + ball * (0.4 * r**2 + h**2 + 0.75 * h * r)
    along = tube * 2 * h * r**2 / 2 + 0.4 * ball * r**2
    close(mass_of(ShapeRow(0, CAPSULE, HERE3, r, (0, 0, h)), 500.0), tube * 2 * h + ball, [0, 0, 0],
          np.diag([across, across, along]))  # fmt: skip


def gauss(f, a, b):
    """The integral of f from a to b, smooth there."""
    x, w = np.polynomial.legendre.leggauss(40)
    return 0.5 * (b - a) * (w @ f(0.5 * (a + b) + 0.5 * (b - a) * x))


@pytest.mark.parametrize("vertices", [[(0.1, 0.2)], [(-0.5, 0.1), (0.4, 0.3)], L_SHAPE, L_SHAPE[:3]])
@pytest.mark.parametrize("r", [0.0, 0.2])
def test_a_rounded_hull_against_its_area_in_polar_angle(vertices, r):
    """Green: area, moments and inertia from the border x(phi) = vertex + r n(phi), and the edges, as line integrals."""
    if len(vertices) < 3 and r == 0:
        return
    p = np.array(vertices)
    edges = np.roll(p, -1, axis=0) - p
    nodes, weights = np.polynomial.legendre.leggauss(20)
    s = 0.5 * (nodes + 1)
    area, first, polar = 0.0, np.zeros(2), 0.0

    def add(x, dx, w):
        nonlocal area, first, polar
        flux = x[:, 0] * dx[:, 1] - x[:, 1] * dx[:, 0]
        area += (w * flux).sum() / 2
        first += (w[:, None] * x * flux[:, None]).sum(0) / 3
        polar += (w * (x * x).sum(1) * flux).sum() / 4

    for k in range(len(p)):
        n0 = np.arctan2(-edges[k - 1][0], edges[k - 1][1])
        turn = 2 * np.pi
        if len(p) > 1:
            n = edges[k] / np.hypot(*edges[k])
            add(p[k] + s[:, None] * edges[k] + r * np.array([n[1], -n[0]]), np.tile(edges[k], (20, 1)), weights / 2)
            turn = (np.arctan2(-edges[k][0], edges[k][1]) - n0) % (2 * np.pi)
        phi = n0 + s * turn
        e = np.stack([np.cos(phi), np.sin(phi)], axis=1)
        add(p[k] + r * e, r * turn * np.stack([-e[:, 1], e[:, 0]], axis=1), weights / 2)
    c = first / area
    found = mass_of(hull(vertices, r), 1.0)
    assert found.mass == pytest.approx(area, rel=1e-13) and np.abs(found.centroid - c).max() < 1e-13
    assert found.inertia == pytest.approx(polar - area * c @ c, rel=1e-12)


@pytest.mark.parametrize(("size", "r"), [((0.2, 0.3, 0.5), 0.1), ((0, 0, 0.5), 0.2), ((0.3, 0.2, 0.4), 0.0)])
def test_a_rounded_box_against_its_sections(size, r):
    """int x^2 A(x) dx with the area A(x) of a section, a rectangle rounded by what the ball has there; beyond the core
    x = a + r sin t."""
    found = mass_of(ShapeRow(0, BOX, HERE3, r, size), 1.0)
    moment = []
    for k in range(3):
        a, b, c = np.roll(size, -k)

        def area(rho, b=b, c=c):
            return 4 * b * c + 4 * (b + c) * rho + np.pi * rho**2

        def integral(f, a=a, area=area):
            return 2 * (
                gauss(lambda x: f(x) * area(r), 0, a)
                + gauss(lambda t: f(a + r * np.sin(t)) * area(r * np.cos(t)) * r * np.cos(t), 0, np.pi / 2)
            )

        moment.append(integral(lambda x: x * x))
        assert found.mass == pytest.approx(integral(np.ones_like), rel=1e-13)
    x, y, z = moment
    assert np.diag(found.inertia) == pytest.approx([y + z, z + x, x + y], rel=1e-13)


def test_a_box_cut_in_two_and_put_together_is_that_box():
    whole = mass_of(ShapeRow(0, BOX, HERE3, 0.0, (0.4, 0.3, 0.2)), 800.0)
    s = np.sqrt(0.5)
    halves = [mass_of(ShapeRow(0, BOX, (x, 0, 0, s, 0, 0, s), 0.0, (0.3, 0.2, 0.2)), 800.0) for x in (-0.2, 0.2)]
    close(combined(halves), whole.mass, whole.centroid, whole.inertia)
    whole = mass_of(hull([(0, 0), (2, 0), (2, 1), (0, 1)]), 3.0)
    halves = [mass_of(hull([(0, 0), (1, 0), (1, 1), (0, 1)], place=place), 3.0) for place in (HERE2, (2, 0, np.pi / 2))]
    close(combined(halves), whole.mass, whole.centroid, whole.inertia)


def test_solids_weigh_what_their_closed_forms_say():
    """A cylinder about x, an ellipsoid, a cube of points like a box, and a tetrahedron."""
    from nonsmooth.scenes.parts import parts_of
    from nonsmooth.scenes.places import ORIGIN

    def mass(shape):
        return mass_of(parts_of(shape, 3)[0].row(0, ORIGIN[3]), 3.0)

    r, h = 0.3, 0.8
    m = 3 * np.pi * r**2 * h
    cylinder = mass(ns.Cylinder(r, h))
    assert cylinder.mass == pytest.approx(m, rel=1e-14)
    across = m * (3 * r**2 + h**2) / 12
    np.testing.assert_allclose(cylinder.inertia, np.diag([m * r**2 / 2, across, across]), rtol=1e-13, atol=1e-15)
    m = 3 * 4 / 3 * np.pi * 0.1 * 0.2 * 0.3
    ellipsoid = mass(ns.Ellipsoid(0.1, 0.2, 0.3))
    np.testing.assert_allclose(ellipsoid.inertia, m / 5 * np.diag([0.13, 0.1, 0.05]), rtol=1e-13, atol=1e-16)
    corners = np.array([[x, y, z] for x in (0, 0.2) for y in (0, 0.4) for z in (0, 0.6)])
    cube, box = mass(ns.Polyhedron(corners)), mass(ns.Box(0.2, 0.4, 0.6))
    np.testing.assert_allclose(cube.inertia, box.inertia, rtol=1e-12, atol=1e-15)
    np.testing.assert_allclose(cube.centroid, [0.1, 0.2, 0.3], rtol=1e-13)
    tetrahedron = mass(
        ns.Polyhedron([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)])
    )  # int x^2 dV = 1/60, int x y dV = 1/120
    assert tetrahedron.mass == pytest.approx(0.5, rel=1e-14)
    about = 3 * (np.eye(3) / 30 + (np.eye(3) - 1) / 120) - 0.5 * (3 / 16 * np.eye(3) - 1 / 16)
    np.testing.assert_allclose(tetrahedron.inertia, about, rtol=1e-12)
