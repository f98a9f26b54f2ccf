"""Entry points that no process has compiled yet: processes share them, and one does where others cannot."""

import gc
import os
import subprocess
import sys
import weakref

import pytest

import nonsmooth as ns
from models import BilliardBall, BouncingBall, SlidingBlock
from nonsmooth.contact.blocks.interior import direction, longest_step
from nonsmooth.integrators.assembly.step import stages_of
from nonsmooth.integrators.rigid.hold import hold_constraints
from nonsmooth.integrators.rigid.rates import rigid_forces
from nonsmooth.jit import cache, turns
from nonsmooth.jit.cache import no_collection
from nonsmooth.jit.loading import STARTUP_CODE, kernel_at, kernels_of, shares, size_of, work_of

LOAD = """
import sys
from nonsmooth.jit import loading
from nonsmooth.jit.turns import in_turn
from nonsmooth.contact.blocks.interior import direction, longest_step
if sys.argv[1] == "alone":
    loading.may_start_process = lambda: False
elif sys.argv[1] == "broken":
    loading.COMPILE = "raise SystemExit(1)"
else:
    loading.may_start_process = lambda: True
    loading.in_turn = lambda pipes, kernels: in_turn(pipes[:1], kernels)  # and helps nobody
assert not direction.is_on_disk and not longest_step.is_on_disk
loading.load_all([direction, longest_step])
for kernel in (direction, longest_step):
    assert kernel.is_loaded and kernel.is_on_disk
    print(sum(kernel.dispatcher.stats.cache_hits.values()))
"""


@pytest.mark.upkeep
@pytest.mark.parametrize(("case", "read_from_disk"), [("two", [0, 1]), ("alone", [0, 0]), ("broken", [0, 0])])
def test_what_the_other_process_compiled_is_read_from_disk(tmp_path, case, read_from_disk):
    environment = {**os.environ, "NONSMOOTH_CACHE_DIR": str(tmp_path)}
    command = [sys.executable, "-c", LOAD, case]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr
    assert [int(hits) for hits in done.stdout.split()] == read_from_disk


@pytest.mark.parametrize("processes", [2, 3, 4])
@pytest.mark.parametrize("dim", [2, 3])
def test_processes_have_about_as_much_to_compile(dim, processes):
    stages = stages_of(dim, has_restitution=True)
    kernels = [stages.take, stages.find, *stages.others]
    here, *elsewhere = shares(kernels, processes)
    assert here[0] is stages.take and len(elsewhere) == processes - 1
    assert sorted(map(id, kernels)) == sorted(id(kernel) for part in (here, *elsewhere) for kernel in part)
    sizes = [work_of(here), *(STARTUP_CODE + work_of(part) for part in elsewhere)]
    even = sum(sizes) / processes
    assert max(sizes) <= max(1.2 * even, STARTUP_CODE + max(map(size_of, kernels)))


@pytest.mark.parametrize("dim", [2, 3])
def test_another_process_finds_each_entry_point_of_a_scene_by_its_place(dim):
    """A process that did not would end without a word, and leave all to this one."""
    stages = stages_of(dim, has_restitution=True)
    kernels = [stages.take, stages.find, *stages.others]
    assert [kernel_at(kernel.place) for kernel in kernels] == kernels
    assert len({kernel.place for kernel in kernels}) == len(kernels)


@pytest.mark.parametrize("integrator", [ns.MoreauJean(1e-3), ns.Adaptive(), ns.EventDriven(), ns.Penalty(1e6)])
@pytest.mark.parametrize("model", [BouncingBall(), SlidingBlock(mu=0.3), BilliardBall()])
def test_another_process_finds_each_entry_point_of_a_system_by_its_place(integrator, model):
    kernels = integrator.entry_points(model.system())
    assert [kernel_at(kernel.place) for kernel in kernels] == kernels


@pytest.mark.skipif(not turns.CAN_HAND_ON, reason="each keeps to its share there")
def test_who_is_done_early_helps_the_others_and_nothing_is_done_twice():
    shared = turns.Turns(["abc", "de", "fg"])
    first = turns.in_turn(*shared.of(1))
    assert [next(first), next(first)] == ["d", "e"]  # its own
    assert "".join(turns.in_turn(*shared.of(0))) == "abcfg"
    assert not list(first) and not list(turns.in_turn(*shared.of(2)))
    shared.close()


def test_where_pipes_cannot_be_handed_on_each_keeps_to_its_share(monkeypatch):
    monkeypatch.setattr(turns, "CAN_HAND_ON", False)
    shared = turns.Turns(["abc", "de"])
    assert ["".join(turns.in_turn(*shared.of(k))) for k in (1, 0, 1)] == ["de", "abc", "de"]
    shared.close()


def test_one_process_has_all():
    kernels = [direction, longest_step]
    assert shares(kernels, 1) == [kernels]


def test_what_two_entry_points_share_is_counted_once_but_for_llvm():
    shared = kernels_of(rigid_forces) & kernels_of(hold_constraints)
    alone = size_of(rigid_forces) + size_of(hold_constraints)
    assert len(shared) > 5 and work_of([rigid_forces]) == pytest.approx(size_of(rigid_forces))
    assert 0.65 * alone < work_of([rigid_forces, hold_constraints]) < alone


# what is left after a compilation


class Ring:
    """Garbage that only the collector finds."""

    def __init__(self):
        self.me = self


def leave_a_ring():
    with no_collection():
        return weakref.ref(Ring())


@pytest.mark.upkeep
def test_garbage_of_a_compilation_is_left_to_the_next_collection(monkeypatch):
    monkeypatch.setattr(cache, "_count_aside", 0)
    ring = leave_a_ring()
    assert ring() is not None and gc.isenabled() and gc.get_freeze_count() == 0
    gc.collect()
    assert ring() is None


def test_much_garbage_is_collected_at_once(monkeypatch):
    monkeypatch.setattr(cache, "_count_aside", cache._most_aside)
    assert leave_a_ring()() is None and cache._count_aside == 0


def test_what_somebody_froze_stays_frozen():
    gc.freeze()
    try:
        count = gc.get_freeze_count()
        assert leave_a_ring()() is None and 2 * gc.get_freeze_count() > count > 0  # some go by themselves
    finally:
        gc.unfreeze()


def test_a_collector_that_is_off_stays_off():
    gc.disable()
    try:
        leave_a_ring()
        assert not gc.isenabled()
    finally:
        gc.enable()
