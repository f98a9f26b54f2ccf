"""docs/promises.md claims nothing that no test shows; and the promises that have no other home."""

import re
import signal
import time
from pathlib import Path

import numpy as np
import pytest

import nonsmooth as ns
from models import BouncingBall
from nonsmooth.cycles.flow_map import flow_curve, flow_map

ROOT = Path(__file__).parents[1]
PACKAGE = Path(ns.__file__).parent
BETWEEN_PROCESSES = {"sweeps/pool.py", "sweeps/batches.py", "sweeps/sweep.py", "sweeps/task.py"}
MACHINE_CODE = {"jit/internals.py"}  # whose files are verified before they are unpickled
# which compiles the adapter that it has written itself; the sizes that stand in the classes of blocks
OUR_OWN_CODE = {"jit/models.py", "jit/blocks.py", "jit/kernels.py"}
STEP = ns.MoreauJean(dt=1e-3)


def test_every_test_that_the_page_of_promises_names_is_there():
    named = set(re.findall(r"`(test_\w+)`", (ROOT / "docs" / "promises.md").read_text()))
    written = set()
    for path in (ROOT / "tests").rglob("test_*.py"):
        written |= set(re.findall(r"^def (test_\w+)", path.read_text(), re.MULTILINE))
    assert len(named) > 25
    assert not named - written


def test_every_row_of_promises_names_a_test():
    rows = re.findall(r"^\| (?!promise|---)(.*?) \| (.*?) \|$", (ROOT / "docs" / "promises.md").read_text(), re.M)
    assert len(rows) > 25
    assert not [promise for promise, tests in rows if "`test_" not in tests]


def test_no_module_unpickles_or_runs_what_it_reads():
    """No pickle but between our own processes and of machine code, no eval or exec but of the adapter that we write."""
    for path in sorted(PACKAGE.rglob("*.py")):
        name, text = path.relative_to(PACKAGE).as_posix(), path.read_text()
        may_unpickle = name in BETWEEN_PROCESSES | MACHINE_CODE
        assert may_unpickle or not re.search(r"\bpickle\.(load|dump)|allow_pickle=True", text), name
        assert name in OUR_OWN_CODE or not re.search(r"(?<![.\w])(eval|exec)\(|yaml|marshal|shelve", text), name
        assert all("allow_pickle=False" in call for call in re.findall(r"np\.load\([^)]*\)", text)), name


@pytest.mark.parametrize("integrator", [STEP, ns.EventDriven(), ns.Penalty(1e5, damping_ratio=0.1)])
def test_a_budget_of_wall_time_ends_a_run_with_what_was_computed(integrator):
    """A span of 1e4 s takes far more than 0.05 s; the clock is looked at between blocks."""
    ball = BouncingBall(e=0.9)
    found = ns.simulate(ball, (0, 1e4), *ball.state(height=1.0), integrator=integrator, every=1000,
                        max_wall_time=0.05, on_failure="return")  # fmt: skip
    if found.success:  # at rest an integrator that chooses its steps takes the rest of the span in a few
        assert found.t[-1] == 1e4 and not isinstance(integrator, ns.MoreauJean)
        return
    assert found.status == ns.Status.BUDGET_SPENT and found.message.startswith("max_wall_time = 0.05 s is used up")
    assert 0 < found.t[-1] < 1e4 and np.isfinite(found.q).all()


def test_a_guess_far_from_any_cycle_is_given_up(monkeypatch):
    """x' = -1e9 x over 1 s takes an explicit method 1e9 evaluations or so: its steps are bounded by stability."""
    monkeypatch.setattr("nonsmooth.cycles.flow_map.EVALUATIONS", 2000)

    class Stiff:
        def rate(self, x):
            return -1e9 * x

    for integrate in (flow_map, flow_curve):
        with pytest.raises(ns.InvalidInput, match="not integrated within 2000 evaluations of its rates; give a guess"):
            integrate(Stiff(), np.ones(1), 1.0, np.ones(1))


def test_ctrl_c_between_two_blocks_is_heard_by_integrators_that_choose_their_steps():
    """The interrupt is raised by the run itself, from its progress, so that no clock decides."""
    ball = BouncingBall(e=0.9)

    def interrupt(done):
        signal.raise_signal(signal.SIGINT)
        time.sleep(0)  # where Python looks for signals

    found = ns.simulate(ball, (0, 100), *ball.state(height=1.0), integrator=ns.EventDriven(), progress=interrupt)
    assert found.status == ns.Status.INTERRUPTED and np.isfinite(found.q).all()
