"""``integrator="auto"``: the rules, the reason, and the motion."""

import numpy as np
import pytest

import nonsmooth as ns
from models import BeadChain, BouncingBall, FollowerForceArm, PainleveRod, RockingBlock
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


def test_many_contacts_are_stepped():
    chain = BeadChain(n=20, e=0.8)
    sol = run(chain, 1.0, chain.state(velocity=1.0))
    assert sol.about["integrator"].startswith("MoreauJean(") and "20 contacts" in sol.about["chosen"]


def test_step_is_the_models_own_or_a_part_of_the_span():
    chain = BeadChain(n=20)
    own = run(chain, 1.0, chain.state(velocity=1.0))
    part = run(chain.system(), 1.0, chain.state(velocity=1.0))
    assert f"dt={chain.dt}" in own.about["integrator"] and "the model's own" in own.about["chosen"]
    assert "dt=0.0001," in part.about["integrator"] and part.stats.steps == 10_000


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
