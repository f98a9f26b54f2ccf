"""Functions of a model that cannot be right are refused by name at the start, where machine code would say nothing."""

import math
import random
from typing import NamedTuple

import numba
import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.mechanics.compiled import model_of
from nonsmooth.mechanics.inspection import inspect_start


class P(NamedTuple):
    m: float = 1.0  # mass [kg]
    n: float = 2.0  # a number that counts


def mass(t, q, p, M):
    M[0, 0] = M[1, 1] = p.m


def force(t, q, u, p, h):
    h[1] = -9.81 * p.m


def gap(t, q, p, g_N):
    g_N[0] = q[1]


def normal(t, q, p, W_N):
    W_N[0, 1] = 1.0


def ball(**changes):
    functions = {"mass": mass, "force": force, "gap": gap, "normal": normal} | changes
    return ns.System(n_q=2, contacts=[ns.Contact()], parameters=P(), **functions)


def refused(message, t=0.0, **changes):
    with pytest.raises(ns.InvalidInput, match=message) as refusal:
        inspect_start(ball(**changes), t, np.array([0.3, 1.0]), np.array([0.1, 0.2]))
    assert "\n" not in str(refusal.value)


def test_a_function_that_writes_into_the_coordinates_is_refused():
    def push(t, q, u, p, h):
        q[1] += 1e-3
        h[1] = -9.81

    def brake(t, q, u, p, h):
        u[:] = 0.0

    refused("the model function force writes into q, which it may only read", force=push)
    refused("the model function force writes into u, which it may only read", force=brake)


def test_a_function_that_writes_beyond_its_array_is_refused_also_where_it_is_compiled():
    @numba.njit
    def compiled(t, q, p, W_N):
        W_N[0, 1] = 1.0
        W_N[1, 0] = 1.0

    @numba.njit
    def helper(values):
        for i in range(3):
            values[i] = 1.0

    def by_helper(t, q, u, p, h):
        helper(h)

    def by_parameter(t, q, u, p, h):
        h[int(p.n)] = 1.0

    refused(r"normal raised IndexError.*writes an array of shape \(1, 2\)", normal=compiled)
    refused(r"force writes beyond its array of shape \(2,\)", force=by_helper)
    refused(r"force raised IndexError.*writes an array of shape \(2,\)", force=by_parameter)


def test_a_function_that_writes_something_else_when_it_is_called_again_is_refused():
    calls = []

    def counting(t, q, u, p, h):
        calls.append(t)
        h[1] = -9.81 + 0.1 * len(calls)

    def drawn(t, q, u, p, h):
        h[1] = -9.81 + random.random()

    refused("force writes -9.[0-9]* when it is called first and -9.[0-9]* when it is called again", force=counting)
    refused("it must keep no state and draw no random numbers", force=drawn)


def test_a_function_that_writes_nothing_of_what_it_found_is_refused():
    def returns(t, q, u, p, h):
        return [0.0, -9.81 * p.m]

    def assigns(t, q, u, p, h):
        h = np.array([0.0, -9.81 * p.m])  # noqa: F841

    refused(r"force returns its values; it must write them into its last argument, an array of shape \(2,\)",
            force=returns)  # fmt: skip
    refused(r"force assigns h anew, which leaves the array as it was; write into it, as h\[:\] = ...", force=assigns)


def test_a_contact_that_no_function_writes_for_is_refused():
    def tangent(t, q, p, W_F):
        W_F[0, 0, 0] = 1.0

    def both(t, q, p, g_N):
        g_N[0] = g_N[1] = 0.0 * q[1]

    def rows(t, q, p, W_N):
        W_N[0, 1] = W_N[1, 1] = 0.0

    two = {"mass": mass, "force": force, "normal": rows, "n_q": 2, "parameters": P()}
    state = np.array([0.3, 0.0]), np.array([0.1, 0.0])
    with pytest.raises(ns.InvalidInput, match="gap writes nothing for contact 1; the system has 2 contacts"):
        inspect_start(ns.System(gap=gap, contacts=[ns.Contact()] * 2, **two), 0.0, *state)
    with pytest.raises(ns.InvalidInput, match="tangent writes nothing for tip; the system has 2 contacts"):
        contacts = [ns.Contact(mu=0.3), ns.Contact(mu=0.3, name="tip")]
        inspect_start(ns.System(gap=both, tangent=tangent, contacts=contacts, **two), 0.0, *state)
    inspect_start(ns.System(gap=both, tangent=tangent, contacts=[ns.Contact(mu=0.3), ns.Contact()], **two), 0.0, *state)


def test_no_force_at_all_and_results_that_are_handed_back_are_taken():
    def nothing(t, q, u, p, h):
        pass

    def adds(t, q, u, p, h):
        h[1] += -9.81
        return h

    def of_another_shape(t, q, p, W_N):
        W_N = W_N.reshape(2)
        W_N[1] = 1.0

    for changes in ({"force": nothing}, {"force": adds}, {"normal": of_another_shape}, {"gap": numba.njit(gap)}):
        inspect_start(ball(**changes), 0.0, np.array([0.3, 1.0]), np.array([0.1, 0.2]))


def test_a_refused_function_is_refused_every_time_and_by_every_entry(monkeypatch):
    monkeypatch.setenv("NONSMOOTH_INTERPRET", "1")  # spares the compilation of what is refused

    def push(t, q, u, p, h):
        q[1] += 1e-3

    system, state = ball(force=push), ([0.3, 1.0], [0.1, 0.2])
    for _ in range(5):
        with pytest.raises(ns.InvalidInput, match="force writes into q"):
            ns.simulate(system, (0, 1), *state, integrator=ns.MoreauJean(1e-3))
    for call in (
        lambda: ns.simulate(system, (0, 1), *state, integrator=ns.Penalty(1e4, damping_ratio=0.1)),
        lambda: ns.simulate(system, (0, 1), *state, integrator=ns.EventDriven()),
        lambda: ns.classify(system, 0.0, *state),
    ):
        with pytest.raises(ns.InvalidInput, match="force writes into q"):
            call()


def test_the_state_that_was_given_is_not_touched_by_a_function_that_writes_into_it():
    def push(t, q, u, p, h):
        q[1] += 1e-3

    q, u = np.array([0.3, 1.0]), np.array([0.1, 0.2])
    with pytest.raises(ns.InvalidInput):
        inspect_start(ball(force=push), 0.0, q, u)
    assert q.tolist() == [0.3, 1.0] and math.isclose(u[0], 0.1)


def test_machine_code_that_is_not_that_of_its_source_is_refused():
    def heavier(t, q, u, p, h):
        h[1] = -9.82 * p.m

    def turning(t, q, u, p, h):
        h[1] = -9.81 * p.m
        h[0] = 1e-3 * math.sin(q[0])

    state = np.array([0.3, 1.0]), np.array([0.1, 0.2])
    right = model_of(ball())
    inspect_start(ball(), 0.0, *state, right)
    for force, entry in (
        (heavier, "-9.81 where its source writes -9.82"),
        (turning, "0 where its source writes 0.000"),
    ):
        with pytest.raises(ns.InvalidInput, match=f"machine code of the model function force writes {entry}"):
            inspect_start(ball(force=force), 0.0, *state, right)
