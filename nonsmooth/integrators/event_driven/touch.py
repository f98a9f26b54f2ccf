"""The contacts at the instant of an event: which touch, with which velocities, and what becomes of them.

A contact touches where its mode is not open, where its gap has just closed, and where the gap is zero to rounding;
unless it parts, gamma_N > 0. It rests where gamma_F = 0: to rounding and atol, or because that is the event.
"""

from __future__ import annotations

from typing import Annotated as Array

from nonsmooth.contact.planar.problem import Planar
from nonsmooth.integrators.radau.located import AT_START
from nonsmooth.integrators.records import FRICTION, N_FUNCTIONS, N_LEDGER, N_WORKS
from nonsmooth.integrators.rigid.modes import RigidContacts, rounded_length, small_speed
from nonsmooth.jit import rare_kernel
from nonsmooth.jit.blocks import Block, Floats, Ints, view
from nonsmooth.mechanics.contact_problem import evaluate_rows, row_velocities
from nonsmooth.mechanics.situation import Situation, find_situation, is_still
from nonsmooth.mechanics.sys import Sys, evaluate
from nonsmooth.mechanics.system import GAP, GIVEN_FORCE, ContactMode

# code: of an impact: by Newton's law; without restitution, the end of a series; without collision, which must stick
COLLISION, END_OF_SERIES, WITHOUT_COLLISION = range(3)


class Touch(Block, r="max(1, n_c * (1 + d))", row=f"2 * n + 3 * n_c + {N_WORKS}"):
    """What is known of the contacts at the instant of an event."""

    impact: int  # how it is resolved: COLLISION, ...
    ahead: float  # [s] how far from the instant modes are decided, on the motion that the old ones would go on with
    is_touching: Array[Ints, "n_c"]  # closed, and gamma_N = 0 once impacts are over
    is_resting: Array[Ints, "n_c"]  # gamma_F = 0
    held: Array[Ints, "n_c", 3]  # modes before the event: mode, sign of sliding, sign of la_N
    gamma: Array[Floats, "n_c", 2]  # contact velocities
    before: Array[Floats, "n_c", 2]  # those before the impacts
    P: Array[Floats, "n_c", 2]  # impulses of the event
    kind: Array[Ints, "n_c"]  # kind of the event
    strikes: Array[Ints, "n_c"]  # 1 where impulses are asked for
    spread: Array[Ints, "n_c"]  # the same of the contacts that touch, one after the other
    number: Array[Ints, "n_c"]  # island of a contact that strikes, -1 of others
    is_lost: Array[Ints, "n_c"]  # 1 where a slide has lost its force
    accumulates: Array[Floats, "n_c"]  # time that the bounces still take, which are given up; 0 where there are none
    none: Array[Floats, "n_c", "1 + d"]  # zero impulses
    ledger: Array[Floats, N_LEDGER]
    q: Array[Floats, "n"]  # the change of the state until then
    u: Array[Floats, "n"]
    u_0: Array[Floats, "n"]  # velocities before the event
    x: Array[Floats, "row"]  # a state that is tried, and its rates
    rates: Array[Floats, "row"]
    flight: Array[Floats, "row"]  # rates before a contact whose bounces are given up was closed
    found: Array[Ints, "n_c", 2]  # number of solutions of its island, bits of the modes of a single contact
    impacts: Array[Ints, "n_c", 2]  # the same of the impact of the event that had most
    planar: Array[Planar, "n = max(1, n_c)"]


@rare_kernel("boolean(int64, float64, float64[::1], int64, int64, int64)", short_loops=True)
def find_touching(sys_at, t, x, event, contacts_at, touch_at):
    """Which contacts touch and rest, and their velocities; False if a model function raised."""
    sys, contacts, touch = view(sys_at, Sys), view(contacts_at, RigidContacts), view(touch_at, Touch)
    work, kinds = contacts.work, sys.kinds
    n, n_c = sys.n, sys.n_c
    for j in range(n):
        contacts.q[j], contacts.u[j] = x[j], x[n + j]
        work.q_mid[j] = x[j]
    for i in range(n_c):
        work.closed[i] = i
    if sys.has & (1 << GAP) and not evaluate(sys, GAP, t, contacts.q, contacts.u, work.g_N):
        return False
    if not evaluate_rows(sys, True, t, contacts.u, work):
        return False
    row_velocities(sys, n_c, contacts.u, work)
    r = 0
    for i in range(n_c):
        touch.gamma[i, 0], touch.gamma[i, 1] = 0.0, 0.0
        if kinds[i, 0] != GIVEN_FORCE:
            touch.gamma[i, 0] = work.gamma_0[r]
            r += 1
        if kinds[i, 1] > 0:
            touch.gamma[i, 1] = work.gamma_0[r]
            r += 1
        contacts.gamma[i, 0], contacts.gamma[i, 1] = touch.gamma[i, 0], touch.gamma[i, 1]
    speed, length = small_speed(sys, contacts), rounded_length(n, contacts)
    still = speed + contacts.numbers.atol
    for i in range(n_c):
        is_closing = event >= 0 and event // N_FUNCTIONS == i
        is_held = contacts.mode[i] != ContactMode.OPEN or is_closing
        gap, gamma_N, gamma_F = 0.0 if is_held else work.g_N[i], touch.gamma[i, 0], touch.gamma[i, 1]
        situation = find_situation(kinds[i, 0], gap, gamma_N, gamma_F, length, speed, still, True)
        touch.is_touching[i] = 1 if situation != Situation.OPEN else 0
        is_arrested = is_closing and contacts.mode[i] == ContactMode.SLIDE and event % N_FUNCTIONS == FRICTION
        is_slow = is_still(gamma_F, still)
        if event == AT_START and contacts.mode[i] != ContactMode.OPEN:  # it says what rests
            is_slow = contacts.mode[i] == ContactMode.STICK
        touch.is_resting[i] = 1 if is_slow or is_arrested else 0
    return True
