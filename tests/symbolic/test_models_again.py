"""Every system of `models` once more from its positions and energies: an independent proof of both.

The functions of the two are compared at random states, with the parameters of the hand-written model. Entries differ by
roundings alone: 1e-13 of the largest term of an array, which the largest entry over all states stands for.
"""

from __future__ import annotations

import numpy as np
import pytest

sp = pytest.importorskip("sympy", reason="energies need SymPy, the extra [symbolic]")

import models  # noqa: E402
import nonsmooth as ns  # noqa: E402
from models import (  # noqa: E402
    BeadChain,
    BeltOscillator,
    BilateralRod,
    BouncingBall,
    FollowerForceArm,
    InclinedBlock,
    LeadScrew,
    ModeCoupling,
    PainleveRod,
    RockingBlock,
    SelfLockingRod,
    SliderCrank,
    SlidingBlock,
    SpragSlip,
    WallPendulum,
    Woodpecker,
)
from nonsmooth.mechanics.system import FUNCTION_NAMES, TAKES_U  # noqa: E402

STATES = 100
LARGEST_ERROR = 1e-13


def declared(model, names, units=""):
    """A declaration with the coordinates and the numeric parameters of a hand-written model."""
    l = ns.lagrangian(f"{model.name} once more")
    q = l.coordinates(names)
    l.parameters(**{name: value for name, value in model.system().parameter_values.items()})
    by_name = {str(symbol): symbol for symbol in l.symbols}
    return l, q, lambda words: [by_name[word] for word in words.split()]


def bouncing_ball(model):
    l, (y,), of = declared(model, "y")
    m, g, e = of("m g e")
    l.point_mass(m, at=(0, y))
    l.gravity(g)
    l.contact(gap=y, e=e)
    return l


def sliding_block(model):
    l, (x, y), of = declared(model, "x y")
    m, g, mu, e = of("m g mu e")
    l.point_mass(m, at=(x, y))
    l.gravity(g)
    l.contact(point=(x, y), normal=(0, 1), mu=mu, e=e)
    return l


def inclined_block(model):
    l, (x, y), of = declared(model, "x y")
    m, g, mu, alpha, F, e = of("m g mu alpha F e")
    l.point_mass(m, at=(x, y))
    l.gravity(g)
    l.potential(-F * x)
    l.contact(point=(x, y), normal=(-sp.sin(alpha), sp.cos(alpha)), mu=mu, e=e)
    return l


def belt_oscillator(model):
    l, (x,), of = declared(model, "x")
    m, k, c, N, vb = of("m k c N vb")
    l.point_mass(m, at=(x,))
    l.potential(k * x**2 / 2)
    l.dissipation(c * l.rate(x) ** 2 / 2)
    l.contact(point=(x,), tangent=(1,), surface=(vb,), normal_force=N, mu=ns.Polynomial("m0", "m1", "m3"))
    return l


def mode_coupling(model):
    l, (x, z), of = declared(model, "x z")
    m, k, kx, kz, cx, cz, mu, R, vb = of("m k kx kz cx cz mu R vb")
    l.point_mass(m, at=(x, z))
    spring = sp.Min(z, 0)
    l.potential(kx * x**2 / 2 + k / 2 * ((x - z) / sp.sqrt(2)) ** 2 + kz * spring**2 / 2 + R * z)
    l.dissipation(cx * l.rate(x) ** 2 / 2 + cz * l.rate(z) ** 2 / 2)
    l.contact(point=(x, z), tangent=(1, 0), surface=(vb, 0), normal_force=-kz * spring, mu=mu)
    return l


def follower_force_arm(model):
    l, (th1, th2), of = declared(model, "th1 th2")
    m1, m2, length, k1, k2, th0, P = of("m1 m2 l k1 k2 th0 P")
    elbow = (length * sp.cos(th1), length * sp.sin(th1))
    tip = (elbow[0] + length * sp.cos(th2), elbow[1] + length * sp.sin(th2))
    l.point_mass(m1, at=elbow)
    l.point_mass(m2, at=tip)
    l.potential(k1 * th1**2 / 2 + k2 * (th2 - th1 - th0) ** 2 / 2)
    l.force((-P * sp.cos(th2), -P * sp.sin(th2)), at=tip)
    return l


def rod(model):
    l, (x, y, th), of = declared(model, "x y th")
    m, length, I, mu, g = of("m l I mu g")
    l.rigid_body(m, I, at=(x, y), angle=th)
    l.gravity(g)
    tip = (x - length / 2 * sp.cos(th), y - length / 2 * sp.sin(th))
    bilateral = isinstance(model, BilateralRod)
    l.contact(point=tip, normal=(0, 1), mu=mu, bilateral=bilateral, e=0 if bilateral else of("e")[0])
    return l


def self_locking_rod(model):
    l, (th,), of = declared(model, "th")
    length, I, mu, R, vb, th0, e = of("l I mu R vb th0 e")
    l.kinetic(I * l.rate(th) ** 2 / 2)
    l.start(th=0.5)
    tip = (-length * sp.cos(th), -length * sp.sin(th))
    l.potential(R * tip[1])
    l.contact(point=tip, normal=(0, 1), offset=length * sp.sin(th0), surface=(vb, 0), mu=mu, e=e)
    return l


def sprag_slip(model):
    l, (y, th), of = declared(model, "y th")
    m, I, ky, kth, R, mu, cy, cth, vb, th0, length = of("m I ky kth R mu cy cth vb th0 l")
    l.point_mass(m, at=(0, y))
    l.kinetic(I * l.rate(th) ** 2 / 2)
    l.potential(ky * y**2 / 2 + kth * (th - th0) ** 2 / 2)
    l.dissipation(cy * l.rate(y) ** 2 / 2 + cth * l.rate(th) ** 2 / 2)
    tip = (-length * sp.cos(th), y - length * sp.sin(th))
    l.potential(R * tip[1])
    l.contact(point=tip, normal=(0, 1), surface=(vb, 0), mu=mu, bilateral=True)
    return l


def lead_screw(model):
    l, (x, th), of = declared(model, "x th")
    m, I, r, lam, k, c, cx, R, mu, thi, omega = of("m I r lam k c cx R mu thi omega")
    l.point_mass(m, at=(x,))
    l.kinetic(I * l.rate(th) ** 2 / 2)
    l.potential(k * (thi + omega * l.t - th) ** 2 / 2 + R * x)
    l.dissipation(c * l.rate(th) ** 2 / 2 + cx * l.rate(x) ** 2 / 2)
    # the thread of the nut against that of the screw, unrolled: x along the axis, r th around it
    l.contact(point=(r * th, x), normal=(-sp.sin(lam), sp.cos(lam)), tangent=(sp.cos(lam), sp.sin(lam)), mu=mu,
              bilateral=True)  # fmt: skip
    return l


def rocking_block(model):
    l, (x, y, th), of = declared(model, "x y th")
    m, width, height, g = of("m width height g")
    l.rigid_body(m, m * (width**2 + height**2) / 12, at=(x, y), angle=th)
    l.gravity(g)
    for side in (-1, 1):
        a, b = side * width / 2, -height / 2
        corner = (x + a * sp.cos(th) - b * sp.sin(th), y + a * sp.sin(th) + b * sp.cos(th))
        l.contact(point=corner, normal=(0, 1), mu=of("mu")[0], e=of("e")[0])
    return l


def wall_pendulum(model):
    l, (th,), of = declared(model, "th")
    m, length, g, th_w, e = of("m l g th_w e")
    bob = (length * sp.sin(th), -length * sp.cos(th))
    l.point_mass(m, at=bob)
    l.gravity(g)
    l.contact(point=bob, normal=(1, 0), offset=-length * sp.sin(th_w), e=e)
    return l


def slider_crank(model):
    l, (th1, th2, th3), of = declared(model, "th1 th2 th3")
    l1, l2, a, b, c, m1, m2, m3, J1, J2, J3, g, mu, e = of("l1 l2 a b c m1 m2 m3 J1 J2 J3 g mu e")
    A = sp.Matrix([l1 * sp.cos(th1), l1 * sp.sin(th1)])
    B = A + sp.Matrix([l2 * sp.cos(th2), l2 * sp.sin(th2)])
    l.rigid_body(m1, J1, at=A / 2, angle=th1)
    l.rigid_body(m2, J2, at=(A + B) / 2, angle=th2)
    l.rigid_body(m3, J3, at=B, angle=th3)
    l.gravity(g)
    for i, j in ((-1, 1), (1, 1), (-1, -1), (1, -1)):
        corner = B + sp.Matrix([i * a * sp.cos(th3) - j * b * sp.sin(th3), i * a * sp.sin(th3) + j * b * sp.cos(th3)])
        l.contact(point=corner, normal=(0, -j), offset=b + c, tangent=(1, 0), mu=mu, e=e)
    return l


def woodpecker(model):
    l, (y, phi_M, phi_S), of = declared(model, "y phi_M phi_S")
    mM, mS, JM, JS, lM, lG, lS, hS, hM, rM, r0, cphi, g, mu = of("mM mS JM JS lM lG lS hS hM rM r0 cphi g mu")
    l.rigid_body(mM, JM, at=(0, y), angle=phi_M)
    l.rigid_body(mS, JS, at=(0, y + lM * phi_M + lG * phi_S), angle=phi_S)
    l.gravity(g)
    l.potential(cphi * (phi_S - phi_M) ** 2 / 2)
    e1, e2 = of("e1 e2")
    beak = (lM + lG - lS - hS * phi_S, y + lM * phi_M + hS + (lG - lS) * phi_S)
    l.contact(point=beak, normal=(1, 0), offset=-r0, tangent=(0, 1), mu=mu, e=e1)
    for side in (1, -1):
        edge = (rM + side * hM * phi_M, y + rM * phi_M - side * hM)
        l.contact(point=edge, normal=(1, 0), offset=-r0, tangent=(0, 1), mu=mu, e=e2)
    return l


def bead_chain(model):
    l, x, of = declared(model, " ".join(f"x_{i}" for i in range(model.n)))
    m, gap, e = of("m gap e")
    for i in range(model.n):
        l.point_mass(m, at=(x[i],))
        l.contact(gap=gap + (x[i + 1] if i + 1 < model.n else 0) - x[i], e=e, impact="sequential")
    return l


AGAIN = {
    BeadChain(n=3): bead_chain,
    BeltOscillator(m=1.3, k=7.0): belt_oscillator,
    BilateralRod(l=1.4, m=0.7, I=0.2): rod,
    BouncingBall(m=1.7): bouncing_ball,
    FollowerForceArm(P=300.0): follower_force_arm,
    InclinedBlock(alpha=0.4, F=0.7, m=1.2): inclined_block,
    ModeCoupling(m=1.2, R=30.0): mode_coupling,
    LeadScrew(m=1.3, I=0.7, r=0.8, lam=0.4, mu=0.5, R=2.0, cx=0.3, omega=0.4): lead_screw,
    PainleveRod(l=1.4, m=0.7, I=0.2): rod,
    RockingBlock(): rocking_block,
    SelfLockingRod(l=1.4, vb=-0.6): self_locking_rod,
    SliderCrank(): slider_crank,
    SlidingBlock(m=1.3): sliding_block,
    SpragSlip(R=3.0): sprag_slip,
    WallPendulum(l=1.4, th_w=0.2): wall_pendulum,
    Woodpecker(): woodpecker,
}
PAIRS = [pytest.param(model, again, id=model.name) for model, again in AGAIN.items()]


def written(system, which, states, p):
    """What a function writes at each state, called in Python."""
    arrays = []
    for t, q, u in states:
        out = np.zeros(system.shape_of(which))
        function = system.functions.get(which)
        if function is not None:
            function(t, q, u, p, out) if which in TAKES_U else function(t, q, p, out)
        arrays.append(out)
    return np.array(arrays)


def test_every_model_is_derived_again():
    """But for ball and top, whose velocities are not the rates of their coordinates, and the rod and the finger in
    space: their own tests derive them."""
    others = ["BilliardBall", "RobotFinger", "SpatialPainleveRod", "SpinningTop"]
    assert sorted([*(type(model).__name__ for model in AGAIN), *others]) == sorted(models.__all__)


@pytest.mark.parametrize(("model", "again"), PAIRS)
def test_lagrange_gives_the_functions_that_were_written_by_hand(model, again):
    by_hand, derived = model.system(), again(model).model().system()
    rng = np.random.default_rng(11)
    states = [
        (rng.uniform(0, 2), rng.uniform(-1.2, 1.2, by_hand.n_q), rng.uniform(-2, 2, by_hand.n_q)) for _ in range(STATES)
    ]
    for name, which in FUNCTION_NAMES.items():
        if which not in by_hand.functions:
            continue
        one, other = (written(system, which, states, by_hand.unpacked) for system in (by_hand, derived))
        if name == "potential":  # up to a constant
            one, other = one - one[0], other - other[0]
        assert np.abs(one - other).max() <= LARGEST_ERROR * np.abs(one).max(), name


@pytest.mark.parametrize(
    ("model", "again"), [(SpragSlip.set_1(cth=5.0), sprag_slip), (ModeCoupling(mu=0.45), mode_coupling)]
)
def test_stability_of_sliding_is_that_of_the_hand_written_model(model, again):
    """Which differentiates the functions by complex steps, as they were written."""
    at = ns.equilibrium(model)
    derived = ns.linearise(again(model).model(), at=ns.equilibrium(again(model).model(), guess=at.q))
    np.testing.assert_allclose(derived.eigenvalues, ns.linearise(model, at=at).eigenvalues, rtol=1e-9)


def test_the_limit_cycle_is_that_of_the_hand_written_model():
    model = BeltOscillator()
    one, two = (ns.limit_cycle(system.system()) for system in (model, belt_oscillator(model).model()))
    assert one.period == pytest.approx(two.period, rel=1e-9)


@pytest.mark.parametrize(("model", "again"), PAIRS)
def test_the_contacts_have_the_same_laws_and_kinds(model, again):
    by_hand, derived = model.system(), again(model).model().system()
    np.testing.assert_array_equal(by_hand.kinds, derived.kinds)
    np.testing.assert_array_equal(by_hand.laws, derived.laws)


@pytest.mark.parametrize(("model", "again"), PAIRS)
def test_what_is_constant_is_known_to_be(model, again):
    by_hand, derived = model.system(), again(model).model().system()
    for which in derived.functions:
        for argument in ("t", "q", "u")[: 3 if which in TAKES_U else 2]:
            known = which not in by_hand.functions or not by_hand.reads(which, argument)
            assert not (derived.reads(which, argument) and known) or which not in by_hand.functions, (which, argument)
