"""What is refused, in one sentence; and what a declaration means, against other derivations."""

from __future__ import annotations

import numpy as np
import pytest

sp = pytest.importorskip("sympy", reason="energies need SymPy, the extra [symbolic]")

import nonsmooth as ns  # noqa: E402
from models import PainleveRod, SpragSlip  # noqa: E402
from nonsmooth.mechanics.system import FORCE, FUNCTION_NAMES, MASS, NORMAL, TANGENT  # noqa: E402


def block():
    """A block on the ground, and its coordinates and parameters."""
    l = ns.lagrangian("block")
    x, y = l.coordinates("x y", unit="m")
    m, g, k, mu, e = l.parameters(m=(1.3, "kg", "mass"), g=(9.81, "m/s^2"), k=(4.0, "N/m"), mu=0.3, e=0.5)
    return l, (x, y), (m, g, k, mu, e)


def states(n, number=20):
    rng = np.random.default_rng(3)
    return [(rng.uniform(0.2, 1.3, n), rng.uniform(-2, 2, n)) for _ in range(number)]


# refusals ------------------------------------------------------------------------------------------------------------


def refused(act, words):
    with pytest.raises(ns.InvalidInput, match=words) as refusal:
        act()
    assert "\n" not in str(refusal.value)


REFUSALS = {
    "a symbol that was not declared": (lambda l, q, p: l.potential(sp.Symbol("z")), "z is none of them: declare it"),
    "a symbol of the same name": (lambda l, q, p: l.potential(sp.Symbol("x")), "take the symbol that was returned"),
    "rates in a potential": (lambda l, q, p: l.potential(p[0] * l.rates[0] ** 2), "xdot is none of them"),
    "an imaginary expression": (lambda l, q, p: l.potential(sp.I * p[0]), "must be real"),
    "the root of what is negative": (lambda l, q, p: l.potential(sp.sqrt(-1 - q[0] ** 2) * sp.I**2), "must be real"),
    "an infinite expression": (lambda l, q, p: l.potential(q[0] / sp.S.Zero), "must be finite"),
    "a text": (lambda l, q, p: l.potential("m*g*y"), "must be a number or an expression"),
    "a function of nobody's": (lambda l, q, p: l.potential(sp.Function("f")(q[0])), "no compiled code is known"),
    "a special function": (lambda l, q, p: l.potential(p[2] * sp.besselj(0, q[0])), "no compiled code is known"),
    "units that do not fit": (lambda l, q, p: l.potential(p[0] * p[1]), "must have the unit J; .* has N"),
    "units that are added": (lambda l, q, p: l.potential(p[0] * p[1] * q[1] + p[2] * q[0]), "different units"),
    "the sine of a length": (lambda l, q, p: l.contact(gap=sp.sin(q[0]), mu=p[3], slip=l.rates[0]), "sin is taken of"),
    "an unknown unit": (lambda l, q, p: l.coordinates("z", unit="furlong"), "product of kg, m, s"),
    "a force of the wrong unit": (lambda l, q, p: l.force((p[0], 0), at=q), "work of a force must have the unit J"),
    "a name twice": (lambda l, q, p: l.parameters(x=1.0), "x is declared twice"),
    "the name of a rate": (lambda l, q, p: l.parameters(xdot=1.0), "is the rate of a coordinate"),
    "a name of the model's": (lambda l, q, p: l.parameters(state=1.0), "a model has it already"),
    "a word of Python's": (lambda l, q, p: l.coordinates("lambda"), "a name must be one that Python can read"),
    "time as a name": (lambda l, q, p: l.parameters(t=1.0), "a model has it already"),
    "a value that is no number": (lambda l, q, p: l.parameters(c="stiff"), "the parameter c must be a number"),
    "a coordinate without energy": (lambda l, q, p: (l.kinetic(p[0] * l.rates[0] ** 2 / 2), l.model()),
                                    "the coordinate y has no kinetic energy"),
    "two that move as one": (lambda l, q, p: (l.kinetic(p[0] * (l.rates[0] + l.rates[1]) ** 2 / 2), l.model()),
                             "x and y move together without kinetic energy"),
    "no energy at all": (lambda l, q, p: l.model(), "a system needs masses"),
    "an energy that is not quadratic": (lambda l, q, p: (l.kinetic(p[0] * l.rates[0] ** 4), l.model()),
                                        "must have the unit J"),
    "a gap without coordinates": (lambda l, q, p: (l.point_mass(p[0], q), l.contact(gap=p[3]), l.model()),
                                  "the gap of contact 0 depends on no coordinate"),
    "a slip that is not linear": (lambda l, q, p: (l.point_mass(p[0], q), l.contact(
        gap=q[1], mu=p[3], slip=l.rates[0] ** 3 / l.rates[1] ** 2), l.model()), "must be linear in the rates"),
    "division by zero at the start": (lambda l, q, p: (l.point_mass(p[0], q), l.potential(p[2] * q[0] ** 3 / q[1]),
                                      l.model()), "force is not finite, as after a division by zero, at the start"),
    "redundant constraints": (lambda l, q, p: (l.point_mass(p[0], q), l.constraint(q[0]), l.constraint(2 * q[0]),
                              l.model()), "bilateral contacts 0, 1 are redundant"),
    "a constraint without slope": (lambda l, q, p: (l.point_mass(p[0], q), l.constraint(q[0] ** 2), l.model()),
                                   "bilateral contact 0 has no slope"),
    "a normal that is not 1": (lambda l, q, p: l.contact(point=q, normal=(1, 1)), "must have length 1; got 1.41421"),
    "a normal whose symbols are not 1": (lambda l, q, p: l.contact(point=q, normal=(0, p[3])), "length 1; got 0.3"),
    "a tangent that is not 1": (lambda l, q, p: l.contact(point=q, normal=(0, 1), tangent=(2, 0), mu=p[3]), "got 2"),
    "an oblique tangent": (lambda l, q, p: l.contact(point=q, normal=(0, 1), tangent=(sp.Rational(3, 5), sp.Rational(
        4, 5)), mu=p[3]), "must be perpendicular to its normal; n.tau = 0.8"),
    "an offset of a gap": (lambda l, q, p: l.contact(gap=q[0], offset=1), "add it to the gap instead"),
    "a slip and a surface": (lambda l, q, p: l.contact(gap=q[1], slip=l.rates[0], surface=(1, 0), mu=p[3]), "leave"),
    "a point without use": (lambda l, q, p: l.contact(gap=q[1], point=q), "has no use without a normal or a tangent"),
    "a normal without a point": (lambda l, q, p: l.contact(normal=(0, 1)), "needs the point that touches"),
    "a contact nowhere": (lambda l, q, p: l.contact(mu=p[3]), "one of the three"),
    "friction without a direction": (lambda l, q, p: l.contact(gap=q[1], mu=p[3]), "needs a sliding velocity"),
    "friction in space": (lambda l, q, p: l.contact(point=(*q, 0), normal=(0, 0, 1), mu=p[3]), "two directions"),
    "an expression for mu": (lambda l, q, p: l.contact(point=q, normal=(0, 1), mu=2 * p[3]), "a number, a parameter"),
    "a restitution of 2": (lambda l, q, p: l.contact(gap=q[1], e=2.0), r"must lie in \[0, 1\]"),
    "a given force without friction": (lambda l, q, p: l.contact(normal_force=1), "give it mu > 0"),
    "a body without an angle": (lambda l, q, p: l.rigid_body(p[0], 1, at=q), "angle=, in the plane"),
    "gravity twice": (lambda l, q, p: (l.gravity(p[1]), l.gravity(p[1])), "declared already"),
    "axes that repeat": (lambda l, q, p: l.rotation("zz", (0, 0)), "must differ"),
    "an unknown coordinate at the start": (lambda l, q, p: l.start(z=1.0), "no coordinate or rate 'z'"),
    "a line of one point": (lambda l, q, p: l.line(q), "at least two points"),
}  # fmt: skip


@pytest.mark.parametrize("case", REFUSALS)
def test_what_cannot_be_a_system_is_refused_in_one_sentence(case):
    act, words = REFUSALS[case]
    refused(lambda: act(*block()), words)


class Nothing:
    """Fits nowhere, and raises wherever it is asked what it is."""

    def _raise(self, *_):
        raise RuntimeError("two\nlines")

    __len__ = __float__ = __iter__ = __bool__ = __getitem__ = __repr__ = __str__ = _raise
    __array__ = _sympy_ = _raise


NOWHERE = [
    None, Nothing(), 1 + 2j, np.full((2, 2), np.nan), 10**400, [[1], [1, 2]], b"x", "\0", "x", {1.5}, float("nan"),
    {1: 2}, (), [None], sp.true, sp.Eq(1, sp.Symbol("x")), sp.Matrix([[1, 2], [3, 4]]), np.array([None]), sp.oo,
    (1, 2, 3, 4), [Nothing()], lambda: 0,
]  # fmt: skip
METHODS = {
    "coordinates": {"names": "z", "unit": "m"}, "parameters": {"c": 1.0}, "rate": {"of": 1}, "start": {"x": 0.0},
    "point_mass": {"m": 1, "at": (0, 1)}, "rigid_body": {"m": 1, "I": 1, "at": (0, 0), "angle": 0, "rotation": None},
    "rotation": {"axes": "x", "angles": (0,)}, "kinetic": {"energy": 0}, "potential": {"energy": 0},
    "gravity": {"g": 1, "direction": (0, 1)}, "dissipation": {"power": 0}, "force": {"vector": (0, 0), "at": (0, 0)},
    "contact": {"point": (0, 0), "normal": (0, 1), "offset": 0, "gap": None, "tangent": (1, 0), "surface": (0, 0),
                "slip": None, "normal_force": None, "bilateral": False, "mu": 0.3, "e": 0, "e_F": 0,
                "impact": "newton"},
    "constraint": {"of": 0}, "line": {}, "equations": {"jacobians": True},
    "model": {"jacobians": True, "t_end": 1.0, "dt": 0.1},
}  # fmt: skip


@pytest.mark.parametrize("name", METHODS)
def test_what_fits_nowhere_is_refused_in_one_sentence_by_every_argument_of_a_declaration(name):
    for argument in METHODS[name]:
        for value in NOWHERE:
            l, q, p = block()
            l.point_mass(p[0], at=q)
            try:
                getattr(l, name)(**METHODS[name] | {argument: value})
            except ns.NonsmoothError as refusal:
                assert "\n" not in str(refusal) and len(str(refusal)) > 15


def test_names_that_the_functions_use_are_free_for_the_user():
    l = ns.lagrangian("System")
    q, M, M_ = l.coordinates("q M M_", unit="m")
    p, h, x0, K = l.parameters(p=(1.0, "kg"), h=(9.81, "m/s^2"), x0=(2.0, "N/m"), K=0.3)
    l.point_mass(p, at=(q, M, M_))
    l.gravity(h)
    l.potential(x0 * (q - M) ** 2 / 2)
    l.contact(point=(q, M, M_), normal=(0, 0, 1), tangent=(1, 0, 0), mu=K)
    model = l.model()
    force = model.system().evaluate(FORCE, 0.0, np.array([1.0, 2.0, 3.0]), np.zeros(3))
    np.testing.assert_array_equal(force, [2.0, -2.0, -9.81])


def test_a_kinetic_energy_that_is_not_quadratic_is_refused():
    l = ns.lagrangian("relativistic")
    (x,) = l.coordinates("x")
    l.kinetic(-sp.sqrt(1 - l.rate(x) ** 2))
    refused(l.model, "quadratic in the velocities")


def test_texts_of_the_user_never_become_code():
    l = ns.lagrangian('block """\nimport os  # \\')
    (x,) = l.coordinates("x", unit="m")
    (m,) = l.parameters(m=(1.0, "kg", 'mass"""\nraise SystemExit'))
    l.point_mass(m, at=(x,))
    assert l.model().m == 1.0


# what a declaration means --------------------------------------------------------------------------------------------


def double_pendulum():
    l = ns.lagrangian("double pendulum")
    th = l.coordinates("th1 th2", unit="rad")
    m, a, g = l.parameters(m=(1.2, "kg"), a=(0.7, "m"), g=(9.81, "m/s^2"))
    knee = (a * sp.sin(th[0]), -a * sp.cos(th[0]))
    foot = (knee[0] + a * sp.sin(th[0] + th[1]), knee[1] - a * sp.cos(th[0] + th[1]))
    return l, th, (m, a, g), knee, foot


def test_bodies_and_typed_energies_give_the_same_equations():
    l, th, (m, a, g), knee, foot = double_pendulum()
    l.point_mass(m, at=knee)
    l.point_mass(m, at=foot)
    l.gravity(g)
    other, th, (m, a, g), knee, foot = double_pendulum()
    for point in (knee, foot):
        other.kinetic(m * sum(v**2 for v in other.rate(point)) / 2)
        other.potential(m * g * point[1])
    one, two = l.model().system(), other.model().system()
    assert one.functions.keys() == two.functions.keys()
    for q, u in states(2):
        for which in one.functions:
            np.testing.assert_allclose(
                one.evaluate(which, 0.0, q, u), two.evaluate(which, 0.0, q, u), rtol=0, atol=1e-13 * 50
            )


def test_sympys_own_lagranges_method_agrees():
    from sympy.physics.mechanics import LagrangesMethod, dynamicsymbols

    l, th, (m, a, g), knee, foot = double_pendulum()
    l.point_mass(m, at=knee)
    l.point_mass(m, at=foot)
    l.gravity(g)
    q = dynamicsymbols("th1 th2")
    back = dict(zip(th, q, strict=True))
    T = sum(m * sum(sp.diff(c.subs(back), dynamicsymbols._t) ** 2 for c in point) / 2 for point in (knee, foot))
    V = sum(m * g * point[1].subs(back) for point in (knee, foot))
    method = LagrangesMethod(T - V, q)
    method.form_lagranges_equations()
    handed_in = ns.lagrangian_of(method, {m: 1.2, a: 0.7, g: 9.81}, name="the same")
    one, two = l.model().system(), handed_in.model().system()
    for q_, u in states(2):
        for which in (MASS, FORCE):
            np.testing.assert_allclose(
                one.evaluate(which, 0.0, q_, u), two.evaluate(which, 0.0, q_, u), rtol=0, atol=1e-12
            )


def top(as_body):
    """A heavy top about a fixed point, by its body or by its kinetic energy in Euler's angles."""
    l = ns.lagrangian("top")
    phi, th, psi = angles = l.coordinates("phi th psi", unit="rad")
    m, A, C, s, g = l.parameters(m=(1.0, "kg"), A=(0.3, "kg m^2"), C=(0.1, "kg m^2"), s=(0.5, "m"), g=(9.81, "m/s^2"))
    turn = l.rotation("zxz", angles)
    centre = tuple(turn.matrix * sp.Matrix([0, 0, s]))
    if as_body:
        l.rigid_body(m, (A, A, C), at=centre, rotation=turn)
        l.gravity(g)
    else:
        phidot, thdot, psidot = l.rates
        about = A + m * s**2
        l.kinetic(about * (thdot**2 + phidot**2 * sp.sin(th) ** 2) / 2 + C * (psidot + phidot * sp.cos(th)) ** 2 / 2)
        l.potential(m * g * s * sp.cos(th))
    l.start(th=0.6, phidot=1.0, psidot=40.0)
    return l


def test_a_spatial_body_has_the_equations_of_the_heavy_top():
    one, two = top(True).model().system(), top(False).model().system()
    for q, u in states(3):
        for which in one.functions:
            np.testing.assert_allclose(
                one.evaluate(which, 0.0, q, u), two.evaluate(which, 0.0, q, u), rtol=0, atol=2e-12
            )


@pytest.mark.upkeep
def test_a_spinning_top_keeps_its_momenta_and_its_energy():
    model = top(True).model()
    q0, u0 = model.state()
    sol = ns.simulate(model, (0, 1), q0, u0, integrator=ns.EventDriven(1e-11, 1e-12))
    A, C, about = model.A, model.C, model.A + model.m * model.s**2
    (th, (phidot, thdot, psidot)) = sol.q[:, 1], sol.u.T
    spin = C * (psidot + phidot * np.cos(th))
    upright = about * phidot * np.sin(th) ** 2 + spin * np.cos(th)
    energy = (
        about * (thdot**2 + (phidot * np.sin(th)) ** 2) / 2 + spin**2 / (2 * C) + model.m * 9.81 * model.s * np.cos(th)
    )
    assert A > C and np.ptp(th) > 0.01  # it nutates
    for kept in (spin, upright, energy):
        assert np.ptp(kept) < 1e-8 * np.abs(kept).max()


def test_a_pendulum_in_dependent_coordinates_swings_as_in_its_angle():
    held = ns.lagrangian("held pendulum")
    x, y = held.coordinates("x y", unit="m")
    m, a, g = held.parameters(m=(1.3, "kg"), a=(0.7, "m"), g=(9.81, "m/s^2"))
    held.point_mass(m, at=(x, y))
    held.gravity(g)
    held.constraint(sp.sqrt(x**2 + y**2) - a)
    held.start(x=0.7 * np.sin(1.0), y=-0.7 * np.cos(1.0))
    free = ns.lagrangian("free pendulum")
    (th,) = free.coordinates("th", unit="rad")
    m, a, g = free.parameters(m=1.3, a=0.7, g=9.81)
    free.point_mass(m, at=(a * sp.sin(th), -a * sp.cos(th)))
    free.gravity(g)
    ends = []
    for l, start in ((held, {}), (free, {"th": 1.0})):
        model = l.model()
        ends.append(ns.simulate(model, (0, 1.2), *model.state(**start), integrator=ns.EventDriven(1e-11, 1e-12)).q[-1])
    np.testing.assert_allclose(ends[0], [0.7 * np.sin(ends[1][0]), -0.7 * np.cos(ends[1][0])], atol=1e-9)


def test_a_moving_floor_and_surface_have_their_velocities():
    l, (x, y), (m, g, _, mu, e) = block()
    l.parameters(A=(0.1, "m"), w=(3.0, "Hz"), v=(0.7, "m/s"))
    A, w, v = (s for s in l.parameter_fields if str(s) in "Awv")
    l.point_mass(m, at=(x, y))
    l.contact(point=(x, y), normal=(0, 1), offset=-A * sp.sin(w * l.t), surface=(v, 0), mu=mu, e=e)
    system = l.model().system()
    q, u = np.array([0.2, 0.3]), np.array([1.0, -0.5])
    names = ("gap", "gap_rate", "surface_velocity", "row_rates")
    found = {name: system.evaluate(FUNCTION_NAMES[name], 0.4, q, u).ravel() for name in names}
    np.testing.assert_allclose(found["gap"], 0.3 - 0.1 * np.sin(1.2), atol=1e-15)
    np.testing.assert_allclose(found["gap_rate"], -0.3 * np.cos(1.2), atol=1e-15)
    np.testing.assert_allclose(found["surface_velocity"], -0.7)
    np.testing.assert_allclose(found["row_rates"], [0.9 * np.sin(1.2), 0.0], atol=1e-15)


def test_a_rolling_point_of_contact_slides_with_the_material_under_it():
    """A disc on the ground: the point of contact wanders on it, so that gamma_F = x' + r th'."""
    l = ns.lagrangian("disc")
    x, y = l.coordinates("x y", unit="m")
    (th,) = l.coordinates("th", unit="rad")
    m, r, g, mu = l.parameters(m=(2.0, "kg"), r=(0.3, "m"), g=(9.81, "m/s^2"), mu=0.4)
    l.rigid_body(m, m * r**2 / 2, at=(x, y), angle=th)
    l.gravity(g)
    l.contact(gap=y - r, slip=l.rate(x) + r * l.rate(th), mu=mu)
    disc = l.model()
    sol = ns.simulate(disc, (0, 1), *disc.state(y=0.3, xdot=3.0), integrator=ns.EventDriven())
    rolls = 3.0 / (3 * 0.4 * 9.81)  # s: mu g t = v - ... the disc slides until v = 2 v_0/3
    assert sol.events[0].t == pytest.approx(rolls, rel=1e-9)
    np.testing.assert_allclose(sol.u[-1], [2.0, 0.0, -2.0 / 0.3], atol=1e-9)


def test_derived_matrices_are_at_hand_with_their_derivatives():
    l, (th1, th2), (m, a, g), knee, foot = double_pendulum()
    l.point_mass(m, at=foot)
    l.point_mass(m, at=knee)
    l.gravity(g)
    l.contact(point=foot, normal=(0, 1), offset=2, mu=0.3)
    found = l.equations()
    height = foot[1]
    assert sp.simplify(found.W_N - sp.Matrix([[height.diff(th1), height.diff(th2)]])) == sp.zeros(1, 2)
    assert sp.simplify(found.dW_N[1][0, 0] - height.diff(th1, th2)) == 0
    assert sp.simplify(found.dW_F[0] - found.W_F.diff(th1)) == sp.zeros(1, 2)
    assert sp.simplify(found.K + found.h.jacobian((th1, th2))) == sp.zeros(2)
    assert sp.simplify(found.V - m * g * (knee[1] + foot[1])) == 0
    assert "\\theta" in found.latex() or "th_{1}" in found.latex()


# closed forms --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("length", [0.3, 0.5, 1.0, 2.0, 7.25])
@pytest.mark.parametrize("rate", [61.3, 60.0, 0.5])
def test_every_decimal_number_may_have_a_unit_of_its_own(length, rate):
    """A pendulum on a shaken pivot, its length and the rate of the shaking typed as numbers, has the equation of the
    one whose parameters have units."""
    found = []
    for is_typed in (True, False):
        l = ns.lagrangian("shaken pendulum")
        th = l.coordinates("th", unit="rad")
        a, w = (length, rate) if is_typed else l.parameters(a=(length, "m"), w=(rate, "1/s"))
        pivot = 0.02 * sp.cos(w * l.t)
        l.rigid_body(1.2, 0.1, at=(a * sp.sin(th), pivot - a * sp.cos(th)), angle=th)
        l.gravity(9.81)
        found.append(l.model().system().evaluate(FUNCTION_NAMES["force"], 0.1, np.array([0.4]), np.array([0.7])))
    np.testing.assert_allclose(found[0], found[1], rtol=1e-13)


@pytest.mark.parametrize("length", [1, sp.Rational(1, 2), sp.pi])
def test_whole_numbers_and_fractions_have_no_unit(length):
    l = ns.lagrangian("pendulum")
    th = l.coordinates("th", unit="rad")
    with pytest.raises(ns.InvalidInput, match="at must have the unit m"):
        l.point_mass(1.0, at=(length * sp.sin(th), length * sp.cos(th)))


def test_a_coordinate_that_is_declared_alone_is_a_symbol_and_unpacks_as_one():
    l = ns.lagrangian("mass on a spring")
    x = l.coordinates("x", unit="m")
    (y,) = l.coordinates("y", unit="m")
    several = l.coordinates("a, b")
    assert isinstance(x, sp.Symbol) and isinstance(y, sp.Symbol) and isinstance(several, tuple)
    assert list(x) == [x] and l.declared.q == [x, y, *several]
    own = sp.Symbol("x", real=True)
    assert x == own and own == x and hash(x) == hash(own) and x != sp.Symbol("x") and x != y
    assert (2 * x + x**2).subs(x, 3) == 15 and sp.sin(x).diff(x) == sp.cos(x) and not sp.utilities.iterables.iterable(x)


def test_the_critical_friction_of_the_rod_is_the_literatures():
    l = ns.lagrangian("rod")
    x, y = l.coordinates("x y", unit="m")
    (th,) = l.coordinates("th", unit="rad")
    m, length, I, mu, g = l.parameters(m=1.0, l=1.0, I=1 / 12, mu=2.0, g=9.81)
    l.rigid_body(m, I, at=(x, y), angle=th)
    l.gravity(g)
    l.contact(point=(x - length / 2 * sp.cos(th), y - length / 2 * sp.sin(th)), normal=(0, 1), mu=mu)
    found = l.model().critical_friction()
    kappa = m * length**2 / (4 * I)
    literature = (1 + kappa * sp.cos(th) ** 2) / (kappa * sp.Abs(sp.sin(th) * sp.cos(th)))
    values = {m: 0.7, length: 1.4, I: 0.2, th: 1.1}
    assert float(found.expression.subs(values)) == pytest.approx(float(literature.subs(values)), rel=1e-14)
    assert r"\left|" in found.latex and found._repr_latex_().startswith(r"$\mu_P = ")
    values = {str(symbol): value for symbol, value in values.items()}
    rod = PainleveRod(m=values["m"], l=values["l"], I=values["I"])
    assert rod.critical_friction(1.1) == pytest.approx(
        float(literature.subs({m: 0.7, length: 1.4, I: 0.2, th: 1.1})), rel=1e-14
    )


def test_closed_forms_come_from_functions_written_by_hand_too():
    from nonsmooth.symbolic.critical import critical_friction

    rod = SpragSlip()
    values = {name: getattr(rod, name) for name in rod.system().parameter_values}
    form = critical_friction(rod).expression
    number = float(form.subs({symbol: values.get(str(symbol), 0.8) for symbol in form.free_symbols}))
    assert number == pytest.approx(rod.critical_friction(0.8), rel=1e-13)


def test_without_friction_there_is_no_critical_one():
    l, (x, y), (m, g, _, mu, e) = block()
    l.point_mass(m, at=(x, y))
    l.contact(gap=y, e=e)
    refused(l.model().critical_friction, "no gap or no friction")
    l.contact(point=(x, y), normal=(1, 0), mu=mu)
    assert l.model().critical_friction(1).expression == sp.oo  # the rows do not couple


# what SymPy derived --------------------------------------------------------------------------------------------------


def test_the_mass_spring_damper_of_lagranges_method():
    """The example of the documentation of LagrangesMethod, typed anew: m q'' + b q' + k q = 0."""
    from sympy.physics.mechanics import LagrangesMethod, Particle, Point, ReferenceFrame, dynamicsymbols
    from sympy.physics.mechanics import Lagrangian as lagrangian_in

    q, m, k, b = dynamicsymbols("q1"), *sp.symbols("m k b")
    frame, point = ReferenceFrame("N"), Point("P")
    point.set_vel(frame, q.diff() * frame.x)
    mass = Particle("Pa", point, m)
    mass.potential_energy = k * q**2 / 2
    method = LagrangesMethod(lagrangian_in(frame, mass), [q], forcelist=[(point, -b * q.diff() * frame.x)], frame=frame)
    method.form_lagranges_equations()
    l = ns.lagrangian_of(method, {m: (2.0, "kg"), k: (50.0, "N/m"), b: (0.4, "N s/m")}, name="spring and damper")
    l.contact(gap=q, e=0.5)
    model = l.model()
    sol = ns.simulate(model, (0, 0.2), *model.state(q1=1.0), integrator=ns.EventDriven(1e-11, 1e-12))
    delta, omega = 0.1, np.sqrt(25.0 - 0.01)
    exact = np.exp(-delta * 0.2) * (np.cos(omega * 0.2) + delta / omega * np.sin(omega * 0.2))
    assert sol.q[-1, 0] == pytest.approx(exact, abs=1e-10)


def test_the_mass_spring_damper_of_kanes_method_with_another_speed():
    """The example of the documentation of KanesMethod, typed anew, with the speed 2 q' - sin q instead of q'."""
    from sympy.physics.mechanics import KanesMethod, Particle, Point, ReferenceFrame, dynamicsymbols

    q, v = dynamicsymbols("q v")
    m, c, k = sp.symbols("m c k")
    frame, point = ReferenceFrame("N"), Point("P")
    rate = (v + sp.sin(q)) / 2
    point.set_vel(frame, rate * frame.x)
    method = KanesMethod(frame, q_ind=[q], u_ind=[v], kd_eqs=[q.diff() - rate])
    refused(lambda: ns.lagrangian_of(method, {}), "are not formed")
    method.kanes_equations([Particle("pa", point, m)], [(point, (-k * q - c * rate) * frame.x)])
    l = ns.lagrangian_of(method, {m: 2.0, c: 0.4, k: 50.0}, name="kane")
    system = l.model().system()
    q0, u0 = np.array([0.3]), np.array([0.7])
    assert system.potential is None  # nobody told it, and the energy is not booked with a wrong one
    M, h = system.evaluate(MASS, 0.0, q0, u0)[0, 0], system.evaluate(FORCE, 0.0, q0, u0)[0]
    assert h / M == pytest.approx((-50.0 * 0.3 - 0.4 * 0.7) / 2.0, rel=1e-14)


def test_constraints_of_a_method_are_refused_with_what_to_do():
    from sympy.physics.mechanics import LagrangesMethod, dynamicsymbols

    x, y = dynamicsymbols("x y")
    method = LagrangesMethod((x.diff() ** 2 + y.diff() ** 2) / 2, [x, y], hol_coneqs=[x - y])
    method.form_lagranges_equations()
    refused(lambda: ns.lagrangian_of(method, {}), "as constraint")
    refused(lambda: ns.lagrangian_of(object(), {}), "must be a LagrangesMethod or KanesMethod")


def kinks():
    """Functions with kinks and jumps, and elementary ones, in one potential and one force."""
    l = ns.lagrangian("kinks")
    x, y = l.coordinates("x y")
    m, k, a = l.parameters(m=1.0, k=3.0, a=0.2)
    xdot, ydot = l.rates
    l.point_mass(m, at=(x, y))
    l.potential(k * sp.Max(0, x - a) ** 2 / 2 + k * sp.Abs(y) ** 3 / 3 + sp.Min(x, y) ** 3)
    l.potential(sp.Piecewise((k * (x - y) ** 2, x > y), (0, True)) + k * sp.atan2(y + 3, x + 4) + x**5)
    l.potential(sp.sqrt(1 + x**2) + sp.exp(-x) * sp.cosh(y) + sp.log(2 + x**2) + sp.tanh(x * y) + sp.asin(x / 4))
    l.force((-a * sp.sign(xdot), -a * sp.Abs(ydot) * ydot), at=(x, y))
    l.contact(gap=y + 5)
    return l.model()


def test_functions_with_kinks_have_the_derivatives_of_their_branch():
    system = kinks().system()
    h, step = FUNCTION_NAMES["force"], 1e-5
    for q, u in [((0.7, 0.3), (1.0, -2.0)), ((-0.6, 0.4), (-1.0, 2.0)), ((0.1, -0.9), (0.5, 0.5))]:
        q, u = np.array(q), np.array(u)
        for j, e in enumerate(np.eye(2)):
            by_q = (system.evaluate(h, 0.0, q + step * e, u) - system.evaluate(h, 0.0, q - step * e, u)) / (2 * step)
            by_u = (system.evaluate(h, 0.0, q, u + step * e) - system.evaluate(h, 0.0, q, u - step * e)) / (2 * step)
            V = [system.evaluate(FUNCTION_NAMES["potential"], 0.0, q + s * e, u)[0] for s in (step, -step)]
            K, C = (system.evaluate(FUNCTION_NAMES[name], 0.0, q, u)[:, j] for name in ("stiffness", "damping"))
            np.testing.assert_allclose(K, -by_q, rtol=1e-6, atol=1e-7)
            np.testing.assert_allclose(C, -by_u, rtol=1e-6, atol=1e-7)
            at_rest = system.evaluate(h, 0.0, q, 0 * u)[j]
            assert (V[1] - V[0]) / (2 * step) == pytest.approx(at_rest, rel=1e-6, abs=1e-7)


@pytest.mark.upkeep
def test_functions_with_kinks_compile_and_run():
    for integrator in (ns.MoreauJean(dt=1e-3), ns.EventDriven()):
        assert ns.simulate(kinks(), (0, 0.5), [0.5, 0.2], [-2.0, 1.0], integrator=integrator).success


def test_a_point_in_space_meets_a_plane_without_friction():
    l = ns.lagrangian("drop")
    x = l.coordinates("x y z", unit="m")
    m, g, e = l.parameters(m=(0.2, "kg"), g=(9.81, "m/s^2"), e=0.5)
    l.point_mass(m, at=x)
    l.gravity(g)
    l.contact(point=x, normal=(0, sp.Rational(3, 5), sp.Rational(4, 5)), offset=1, e=e)
    system = l.model().system()
    q = np.array([1.0, 2.0, 3.0])
    assert system.evaluate(FUNCTION_NAMES["gap"], 0.0, q, q)[0] == pytest.approx(1 + 1.2 + 2.4, rel=1e-15)
    np.testing.assert_array_equal(system.evaluate(NORMAL, 0.0, q, q), [[0.0, 0.6, 0.8]])
    np.testing.assert_allclose(system.evaluate(FORCE, 0.0, q, q), [0.0, 0.0, -0.2 * 9.81])


def test_numbers_keep_all_their_digits():
    l, (x, y), (m, g, _, mu, e) = block()
    l.point_mass(m, at=(x, y))
    l.contact(gap=x - 0.12345678901234567)
    assert l.model().system().evaluate(FUNCTION_NAMES["gap"], 0.0, np.zeros(2), np.zeros(2))[0] == -0.12345678901234567


def test_normal_and_tangential_rows_of_an_oblique_plane():
    l, (x, y), (m, g, _, mu, e) = block()
    l.point_mass(m, at=(x, y))
    l.contact(point=(x, y), normal=(sp.Rational(-3, 5), sp.Rational(4, 5)), mu=mu)
    system = l.model().system()
    q = np.zeros(2)
    np.testing.assert_array_equal(system.evaluate(NORMAL, 0.0, q, q), [[-0.6, 0.8]])
    np.testing.assert_array_equal(system.evaluate(TANGENT, 0.0, q, q), [[[0.8, 0.6]]])
