"""Entry points that no process has compiled yet: processes share them, and one does where others cannot."""

import os
import subprocess
import sys

import pytest

from nonsmooth.contact.blocks.interior import direction, longest_step
from nonsmooth.integrators.assembly.step import stages_of
from nonsmooth.jit.loading import STARTUP_CODE, shares, size_of

LOAD = """
import sys
from nonsmooth.jit import loading
from nonsmooth.contact.blocks.interior import direction, longest_step
if sys.argv[1] == "alone":
    loading.may_start_process = lambda: False
elif sys.argv[1] == "broken":
    loading.COMPILE = "raise SystemExit(1)"
else:
    loading.may_start_process = lambda: True
assert not direction.is_on_disk and not longest_step.is_on_disk
loading.load_all([direction, longest_step])
for kernel in (direction, longest_step):
    assert kernel.is_loaded and kernel.is_on_disk
    print(sum(kernel.dispatcher.stats.cache_hits.values()))
"""


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
    sizes = [sum(map(size_of, here)), *(STARTUP_CODE + sum(map(size_of, part)) for part in elsewhere)]
    even = sum(sizes) / processes
    assert max(sizes) <= max(1.2 * even, STARTUP_CODE + max(map(size_of, kernels)))


def test_one_process_has_all():
    kernels = [direction, longest_step]
    assert shares(kernels, 1) == [kernels]
