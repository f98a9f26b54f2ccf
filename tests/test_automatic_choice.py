"""``integrator="auto"``: the rules, the reason, and the motion."""

import numpy as np
import pytest

import nonsmooth as ns
from models import BeadChain, BouncingBall, FollowerForceArm, PainleveRod, RockingBlock
from nonsmooth.bench.scenes import row_of_blocks
from nonsmooth.cli import main
from nonsmooth.commands.terminal import FAILED


def run(model, t_end, state, **options):
    return ns.simulate(model, (0, t_end), *state, integrator="auto", **options)


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
    """With the model's own step, or a part of the span; the block stops after v^2/(2 mu g)."""
    u0 = np.zeros(16)
    u0[0] = 1.0
    sol = run(row_of_blocks(8, k=0.0), 1.0, (np.zeros(16), u0))
    assert "MoreauJean(dt=0.0001," in sol.about["integrator"] and sol.stats.steps == 10_000
    assert "8 contacts, 8 with friction" in sol.about["chosen"]
    assert abs(sol.q[-1, 0] - 1 / (2 * 0.3 * 9.81)) < 1e-6

    class Model:
        dt = 1e-3

        def system(self):
            return row_of_blocks(8, k=0.0)

    own = run(Model(), 0.1, (np.zeros(16), u0))
    assert "dt=0.001," in own.about["integrator"] and "the model's own" in own.about["chosen"]


def test_dense_events_are_handed_to_an_integrator_with_the_same_tolerances():
    ball = BouncingBall()
    sol = run(ball, 0.1, ball.state(height=1.0))
    assert "hand_over=Adaptive(rtol=1e-08, atol=1e-10" in sol.about["integrator"]


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
