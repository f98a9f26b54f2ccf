"""A scene that goes on as it is asked to: the bits of `simulate`, a controller that is sampled, failures."""

import math

import numpy as np
import pytest
from scipy.linalg import expm

import nonsmooth as ns
from models.scenes import BoxStack

G = 9.81


def cart(push):
    """A pole on a cart without friction; the force on the cart is what stands in a list."""
    scene = ns.Scene(gravity=(0, -G))
    scene.fixed(ns.Disc(0.01), name="ground")
    scene.body(ns.Box(0.4, 0.1), mass=1.0, name="cart")
    scene.body(ns.Box(0.02, 1.0), mass=0.2, inertia=0.2 / 12, position=(0, 0.5), turn=0.0, spin=0.3, name="pole",
               velocity=(-0.15, 0))  # fmt: skip
    scene.slider("ground", "cart", at=(0, 0), axis=(1, 0), name="rail")
    scene.hinge("cart", "pole", at=(0, 0), name="pivot")
    scene.ignore("ground", "cart", "pole")
    scene.force("cart", lambda t, bodies: (push[0], 0.0))
    return scene


def test_steps_by_hand_have_the_bits_of_a_run():
    model = BoxStack(n=4)
    whole = ns.simulate(model, (0, 0.1), integrator=ns.MoreauJean(2e-3), every=5)
    stepper = ns.Stepper(model, ns.MoreauJean(2e-3))
    for _ in range(10):
        bodies = stepper.step(5)
    assert len(stepper.solution().t) == len(stepper.solution().t) == 11  # asked for twice
    sol = stepper.solution()
    for name in ("position", "turn", "velocity", "spin", "residual", "penetration"):
        assert getattr(sol, name).tobytes() == getattr(whole, name).tobytes(), name
    np.testing.assert_allclose(sol.t, whole.t, rtol=1e-14)
    assert bodies["box 3"].position.tobytes() == sol["box 3"].position[-1].tobytes()
    assert sol.status == ns.Status.FINISHED and sol.stats.steps == 50


def test_a_sampled_controller_holds_a_pole_upright():
    """Its poles are those of the linear system that is sampled: z = exp(s T), all inside the unit circle."""
    push, T = [0.0], 0.02
    stepper = ns.Stepper(cart(push), ns.MoreauJean(1e-3))
    M, m, l = 1.0, 0.2, 0.5
    gains = np.array([-3.0, -5.0, -45.0, -11.0])  # x, x', lean, lean'
    angles = []
    for _ in range(400):
        bodies = stepper.step(20)
        pole, base = bodies["pole"], bodies["cart"]
        lean = -pole.turn  # to the right
        push[0] = -float(gains @ [base.position[0], base.velocity[0], lean, -pole.spin])
        angles.append(lean)
    J = m / 12 + m * l * l
    mass = np.array([[M + m, m * l], [m * l, J]])
    A = np.zeros((4, 4))
    A[0, 1] = A[2, 3] = 1.0
    A[[1, 3], 2] = np.linalg.solve(mass, [0.0, m * G * l])
    b = np.zeros(4)
    b[[1, 3]] = np.linalg.solve(mass, [1.0, 0.0])
    whole = expm(np.block([[A, b[:, None]], [np.zeros((1, 5))]]) * T)
    closed = whole[:4, :4] - np.outer(whole[:4, 4], gains)
    assert np.abs(np.linalg.eigvals(closed)).max() < 1  # the linear one comes to rest, and so does this
    assert max(map(abs, angles)) < 0.5 and abs(angles[-1]) < 1e-3


def test_a_step_that_fails_keeps_what_was_recorded_and_the_stepper_goes_no_further():
    scene = ns.Scene(gravity=(0, 0))
    scene.body(ns.Disc(0.1), mass=1.0, velocity=(1.0, 0), name="b")
    scene.force("b", lambda t, bodies: (0.0, 0.0) if t < 0.05 else math.nan)
    stepper = ns.Stepper(scene, ns.MoreauJean(0.01))
    stepper.step(3)
    with pytest.raises(ns.StepFailure, match="the force on b at t = 0.05") as caught:
        stepper.step(5)
    kept = caught.value.solution
    assert len(kept.t) == 3 and kept.t[-1] == pytest.approx(0.05, abs=0.011)
    assert kept["b"].position[-1, 0] == pytest.approx(kept.t[-1], abs=1e-12)
    with pytest.raises(ns.StepFailure) as again:
        stepper.step()
    assert len(again.value.solution.t) == 3  # no record is written twice


@pytest.mark.parametrize("make, message", [
    (lambda scene: ns.Stepper(3), "goes on with an ns.Scene, or a ready scene; got 3"),
    (lambda scene: ns.Stepper(scene), r"the scene has no dt; give integrator=ns.MoreauJean\(dt\)"),
    (lambda scene: ns.Stepper(scene, ns.Adaptive()), "whose steps are of one length"),
    (lambda scene: ns.Stepper(scene, ns.MoreauJean(1e-3)).step(0), "n must be a whole number"),
    (lambda scene: ns.Stepper(scene, ns.MoreauJean(1e-3), t_0=math.nan), "t_0"),
    (lambda scene: ns.Stepper(scene, ns.MoreauJean(1e-3), record="all"), "record"),
])  # fmt: skip
def test_what_a_stepper_does_not_take_is_refused(make, message):
    scene = ns.Scene()
    scene.body(ns.Disc(0.1), mass=1.0)
    with pytest.raises(ns.InvalidInput, match=message):
        make(scene)
