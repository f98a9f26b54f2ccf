"""Kernels: the interpreted twin, what the disk cache depends on, and Python's indices in model functions."""

from typing import NamedTuple

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.integrators.moreau_jean import step
from nonsmooth.jit import fingerprint, interpreted, kernel, kernels
from nonsmooth.jit.linking import function_at
from nonsmooth.numerics import rounding
from nonsmooth.numerics.rounding import rounded_sum

FACTOR = 3.0


@kernel
def scaled(x):
    """FACTOR x."""
    return FACTOR * x


@kernel("float64(float64[::1])")
def scaled_sum(x):
    """The sum of FACTOR x."""
    total = 0.0
    for i in range(x.shape[0]):
        total += scaled(x[i])
    return total


def test_an_entry_point_agrees_with_its_source_run_by_python():
    x = np.linspace(0.0, 1.0, 7)
    assert scaled_sum(x) == interpreted(scaled_sum)(x) == pytest.approx(3.0 * x.sum(), rel=1e-15)


def test_an_entry_point_that_was_called_from_python_has_its_address():
    """Looked up later it may be that of another function, which was loaded meanwhile and has the same name."""

    @kernel("float64(float64)")
    def halved(x):
        return 0.5 * x

    assert not halved.is_loaded
    assert halved(3.0) == 1.5 and halved.is_loaded
    assert function_at(halved.address, halved.signature)(5.0) == 2.5


def test_the_stamp_of_an_entry_point_follows_the_constants_of_the_kernels_it_calls(monkeypatch):
    before = stamp(scaled_sum)
    assert stamp(scaled_sum) == before
    monkeypatch.setitem(scaled.function.__globals__, "FACTOR", 4.0)
    assert stamp(scaled_sum) != before


def stamp(entry_point):
    fingerprint.digest.cache_clear()
    kernels.kernel_stamp.cache_clear()
    return kernels.kernel_stamp(entry_point)


def test_the_stamp_follows_an_entry_point_that_moved_to_another_module():
    """It is called through a slot that bears the name of its module: code in the cache would look for the old one."""
    signature = "float64(float64)"

    def half(x):
        return 0.5 * x

    here, there = kernels.Kernel(half, signature), kernels.Kernel(half, signature)
    assert here.call_identity() == there.call_identity()
    half.__module__ = "another.module"
    assert here.slot_name == "nonsmooth.another.module.half"
    elsewhere = here.call_identity()
    half.__module__ = "a.third.one"
    assert elsewhere != here.call_identity()
    inner = kernels.Kernel(half)  # inlined: it has no slot
    moved = inner.call_identity()
    half.__module__ = "another.module"
    assert moved == inner.call_identity()


def test_a_docstring_is_no_reason_to_compile_again():
    def documented(x):
        """One."""
        return 2.0 * x

    def redocumented(x):
        """Another."""
        return 2.0 * x

    assert fingerprint.digest(documented) == fingerprint.digest(redocumented)


class P(NamedTuple):
    m: float = 2.0


def mass(t, q, p, M):
    M[0, 0] = p.m
    M[1, 1] = p.m


def force(t, q, u, p, h):
    h[-1] = -p.m * q[-1]


def test_a_model_function_may_count_from_the_end():
    system = ns.System(n_q=2, mass=mass, force=force, parameters=P())
    sol = ns.simulate(system, (0, np.pi), [1.0, 1.0], [0.0, 0.0], integrator=ns.MoreauJean(dt=np.pi / 2000))
    # theta = 1/2 on a unit oscillator: phase error dt^2 pi / 24 at most, so q_1 = -1 + O(1e-12) and q_0 untouched
    assert sol.q[-1] == pytest.approx([1.0, -1.0], abs=1e-6)


@kernel("float64(float64)")
def rounding_of_ten(x):
    """Ten roundings of x."""
    return rounded_sum(10, x)


@pytest.mark.parametrize("entry_point", [rounding_of_ten, step.step], ids=["one call away", "of a step"])
def test_the_stamp_follows_a_constant_of_another_module_however_far_below_it_is_read(entry_point, monkeypatch):
    before = stamp(entry_point)
    with monkeypatch.context() as change:
        change.setattr(rounding, "UNIT_ROUNDOFF", 2.0**-24)
        assert stamp(entry_point) != before
    assert stamp(entry_point) == before


def test_a_kernel_reads_the_constant_of_the_module_that_it_stands_in():
    assert rounding_of_ten(1.0) == 10 * rounding.UNIT_ROUNDOFF
