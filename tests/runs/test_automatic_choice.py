"""``integrator="auto"``: the rules, the reason, and the motion."""

import math
import re

import numpy as np
import pytest

import nonsmooth as ns
from benchmarks.core_scenes import row_of_blocks
from benchmarks.stress_scenes import Tower, tower
from models import BeadChain, BouncingBall, FollowerForceArm, PainleveRod, RockingBlock
from nonsmooth.commands.cli import main
from nonsmooth.commands.terminal import FAILED


def run(model, t_end, state, **options):
    return ns.simulate(model, (0, t_end), *state, integrator="auto", **options)


def test_the_choice_is_automatic_where_no_integrator_is_given():
    ball = BouncingBall(e=0.8)
    told = ns.simulate(ball, (0, 0.5), *ball.state(height=1.0), integrator="auto")
    left_out = ns.simulate(ball, (0, 0.5), state={"height": 1.0})
    assert left_out.about["chosen"] == told.about["chosen"] and (left_out.q == told.q).all()


def test_the_choice_is_automatic_for_a_scene_too():
    scene = ns.Scene(gravity=(0, -9.81))
    scene.body(ns.Disc(0.1), density=1000, position=(0, 0.5), name="disc")
    sol = ns.simulate(scene, (0, 1))
    assert "there are no contacts" in sol.about["chosen"]
    assert sol["disc"].position[-1, 1] == pytest.approx(0.5 - 9.81 / 2, rel=1e-12)


def test_smooth_motion_is_integrated_with_order_5():
    arm = FollowerForceArm(P=500.0)
    rest = arm.equilibrium()
    sol = run(arm, 1.0, (rest + [0.05, 0.0], np.zeros(2)))
    assert sol.about["integrator"].startswith("EventDriven(") and "no contacts" in sol.about["chosen"]
    assert np.abs(sol.q[-1] - rest - [-0.021525545, 0.013952941]).max() < 1e-7  # SYSTEMS section B, rtol = 1e-8


@pytest.mark.parametrize("model, state", [
    (BouncingBall(e=0.8), {"height": 1.0}), (RockingBlock(), {"tilt": 0.1}),
    (PainleveRod(mu=2.0), {"th": 1.0, "thdot": 0.0, "slip": -1.0}),
])  # fmt: skip
def test_events_of_few_contacts_are_located(model, state):
    chosen = run(model, 0.3, model.state(**state))
    told = ns.simulate(model, (0, 0.3), *model.state(**state), integrator=ns.EventDriven())
    assert "can be located" in chosen.about["chosen"]
    assert (chosen.t == told.t).all() and (chosen.q == told.q).all()


def test_many_contacts_without_friction_are_refined_to_a_tolerance():
    """Twenty beads and a wall, against the impacts one by one."""
    chain = BeadChain(n=20, e=0.9)
    sol = run(chain, 0.5, chain.state(velocity=1.0))
    exact, _ = chain.exact(0.5, velocity=1.0)
    assert sol.about["integrator"].startswith("Adaptive(rtol=1e-06") and "20 contacts" in sol.about["chosen"]
    assert np.abs(sol.q[-1] - exact).max() < 1e-5


def test_many_contacts_with_friction_are_stepped():
    """Eight masses upon each other that slide as one, with the model's own step, or a part of the span: they stop after
    v^2/(2 mu g)."""
    rests, slides = (np.zeros(16), np.zeros(16)), (np.zeros(16), np.array([1.0, 0.0] * 8))
    sol = run(tower(8, Tower()), 1.0, rests)
    assert "MoreauJean(dt=0.0001," in sol.about["integrator"] and sol.stats.steps == 10_000
    assert "8 contacts, 8 with friction" in sol.about["chosen"] and np.abs(sol.q).max() == 0.0

    class Model:
        dt = 5e-3

        def system(self):
            return tower(8, Tower())

    own = run(Model(), 0.4, slides)
    assert "dt=0.005," in own.about["integrator"] and "the model's own" in own.about["chosen"]
    assert np.abs(own.q[-1, ::2] - 1 / (2 * 0.3 * 9.81)).max() < 0.3 * 9.81 * Model.dt**2  # of the step it stops in
    asked = ns.simulate(tower(8, Tower()), (0, 0.1), *rests, integrator=ns.Auto(rtol=1e-4))
    assert asked.about["integrator"].startswith("Adaptive(rtol=0.0001, atol=1e-06")
    assert "the tolerance asked for" in asked.about["chosen"]


def wheel(n=8, l=1.0, I=0.5, slope=0.2):
    """A rimless wheel of 1 kg with n spokes on a slope: q = (x, y, th), one or two of n contacts are closed."""
    tau = 2 * math.pi / n

    def mass(t, q, p, M):
        M[0, 0] = M[1, 1] = 1.0
        M[2, 2] = I

    def force(t, q, u, p, h):
        h[0], h[1] = 9.81 * math.sin(slope), -9.81 * math.cos(slope)

    def gap(t, q, p, g_N):
        for i in range(n):
            g_N[i] = q[1] - l * math.cos(q[2] + i * tau)

    def normal(t, q, p, W_N):
        for i in range(n):
            W_N[i, 1] = 1.0
            W_N[i, 2] = l * math.sin(q[2] + i * tau)

    def tangent(t, q, p, W_F):
        for i in range(n):
            W_F[i, 0, 0] = 1.0
            W_F[i, 0, 2] = -l * math.cos(q[2] + i * tau)

    return ns.System(n_q=3, mass=mass, force=force, gap=gap, normal=normal, tangent=tangent,
                     contacts=[ns.Contact(mu=0.8)] * n)  # fmt: skip


@pytest.mark.parametrize("integrator, tolerance", [("auto", 1e-8), (ns.Auto(rtol=1e-6), 1e-6), (ns.Auto(1e-10), 1e-10)])
def test_what_counts_is_what_touches_at_once(integrator, tolerance):
    """A wheel of eight spokes, of which one or two touch, rolls down from foot to foot.

    About a foot Theta = I + l^2 and om^2/2 + (g l/Theta) cos(th + slope) is constant while th goes from -tau/2 to
    tau/2; an impact leaves om (I + l^2 cos tau)/Theta.
    """
    l, I, slope, tau, om = 1.0, 0.5, 0.2, 2 * math.pi / 8, 1.5
    start = [0.0, l * math.cos(0.1), 0.1], [l * math.cos(0.1) * om, -l * math.sin(0.1) * om, om]
    sol = ns.simulate(wheel(), (0, 2), *start, integrator=integrator)
    assert sol.about["integrator"].startswith("EventDriven") and "8 contacts at most 1" in sol.about["chosen"]
    impacts = [e.t for e in sol.events if e.kind == ns.EventKind.IMPACT and e.P_N > 0.1]  # N s, not the foot settling
    lean, pull = 0.1, 2 * 9.81 * l / (I + l * l)
    for t in impacts:
        om = math.sqrt(om**2 + pull * (math.cos(lean + slope) - math.cos(tau / 2 + slope)))
        assert sol(t, "left").u[2] == pytest.approx(om, abs=30 * tolerance)
        om *= (I + l * l * math.cos(tau)) / (I + l * l)
        assert sol(t).u[2] == pytest.approx(om, abs=30 * tolerance)
        lean = -tau / 2
    assert len(impacts) == 5


@pytest.mark.upkeep
def test_contacts_that_share_nothing_are_decided_apart():
    """Sixteen blocks side by side, at rest: one at once."""
    u0 = np.zeros(32)
    u0[0] = 1.0
    sol = run(row_of_blocks(16, k=0.0), 1.0, (np.zeros(32), u0))
    assert "of 16 contacts at most 1 are decided" in sol.about["chosen"]
    assert abs(sol.q[-1, 0] - 1 / (2 * 0.3 * 9.81)) < 1e-9


def let_go(n):
    """Masses let go a little apart from each other, with e = 0: at the end they rest upon each other as one."""
    q0 = np.zeros(2 * n)
    q0[1::2] = 1e-3 * np.arange(1, n + 1)
    return tower(n, Tower()), (q0, np.zeros(2 * n))


@pytest.mark.parametrize(
    "n, integrator, taken",
    [
        (10, "auto", "Adaptive(rtol=1e-08, atol=1e-10"),
        (13, "auto", "MoreauJean(dt=2e-05"),
        (13, ns.Auto(1e-6), "Adaptive(rtol=1e-06, atol=1e-08"),
    ],
)
def test_a_run_that_meets_more_than_can_be_decided_is_taken_again_and_says_so(n, integrator, taken):
    masses, start = let_go(n)
    options = {"max_steps": 20_000, "max_wall_time": 500.0, "t_eval": [0.0, 0.2]}
    sol = ns.simulate(masses, (0, 0.2), *start, integrator=integrator, **options)
    assert sol.success and sol.about["integrator"].startswith(taken)
    assert re.search(r"can be located, but not from t = 0\.0\d+ s on: the run was taken again", sol.summary())
    # each of n contacts is closed at most a step dt too late, at the speed of the highest mass
    late = 13 * math.sqrt(2 * 9.81 * 13e-3) * 2e-5 if taken.startswith("MoreauJean") else 1e-6
    assert np.abs(sol.q[-1]).max() < late and np.abs(sol.u[-1]).max() < 1e-6


def test_a_run_whose_budget_is_spent_is_not_taken_again():
    masses, start = let_go(10)
    with pytest.raises(ns.BudgetSpent, match="max_steps = 5"):
        run(masses, 0.2, start, max_steps=5)


def test_summary_says_what_was_chosen_and_why():
    ball = BouncingBall()
    sol = run(ball, 0.1, ball.state(height=1.0))
    line = sol.summary().splitlines()[1]
    assert line.startswith("EventDriven(rtol=1e-08")
    assert line.endswith("because every event of 1 contact can be located")


def test_span_without_length_needs_no_step():
    ball = BouncingBall()
    assert run(ball, 0.0, ball.state(height=1.0)).success


def test_command_line_takes_auto_and_budgets(capsys):
    assert main(["run", "bouncing-ball", "--t-end", "0.5", "--integrator", "auto", "--no-plot"]) == 0
    assert "because every event of 1 contact" in capsys.readouterr().out
    arguments = ["run", "bouncing-ball", "--t-end", "0.5", "--integrator", "auto", "--no-plot", "--max-steps", "2"]
    assert main(arguments) == FAILED
    assert "max_steps = 2 is used up after 2 steps" in capsys.readouterr().out
    assert main(["run", "bouncing-ball", "--integrator", "auto", "--dt", "0.1", "--no-plot"]) == 2
    assert "--dt is no option of --integrator auto" in capsys.readouterr().err
    arguments = ["run", "bouncing-ball", "--t-end", "0.5", "--integrator", "auto", "--rtol", "1e-5", "--no-plot"]
    assert main(arguments) == 0 and "EventDriven(rtol=1e-05, " in capsys.readouterr().out
