"""Whether another force fits the slide that goes on: of a contact that no other is coupled to, one equation.

    gamma_N' = p_sigma la_N + b,    p_sigma = G_NN - s mu sigma G_NF,    sigma the sign of la_N

A unilateral contact (sigma = 1) that slides with la_N = -b/p > 0 may open as well where b > 0, and then p < 0. A
bilateral one has a second force -b/p', p' = p_(-sigma), of the other sign where p p' < 0: p' falls through zero where
it appears. Of contacts that are coupled the solutions are counted where their modes are decided
(event_driven/switching.py).

Source: Génot, Brogliato, *Eur. J. Mech. A/Solids* 18 (1999) 653.
"""

from __future__ import annotations

import math

from nonsmooth.contact.planar.single import FREE, PULL_MINUS, PULL_PLUS, SLIDE_MINUS, SLIDE_PLUS
from nonsmooth.integrators.records import (
    INDETERMINATE,
    N_FUNCTIONS,
    append_event,
)
from nonsmooth.integrators.rigid.modes import UNIQUE
from nonsmooth.jit import kernel
from nonsmooth.mechanics.system import BILATERAL, GIVEN_FORCE, ContactMode


@kernel
def slides(sys, i, contacts):
    """Whether contact i slides by its own normal force."""
    return contacts.mode[i] == ContactMode.SLIDE and sys.kinds[i, 0] != GIVEN_FORCE


@kernel
def slides_alone(sys, i, contacts):
    """Whether contact i slides by its own normal force, and no other is coupled to it."""
    return slides(sys, i, contacts) and contacts.is_alone[i] == 1


@kernel
def uniqueness(i, contacts):
    """p'/G_NN with the sign of p, of the bilateral contact that slides alone: positive where no other force fits."""
    work = contacts.work
    a = work.start[contacts.place[i]]
    friction = contacts.ratio[i] * work.G[a, a + 1] / work.G[a, a]
    return math.copysign(1.0, 1.0 + friction) * (1.0 - friction)


@kernel
def several_fit(sys, i, contacts):
    """Whether another force fits the contact that slides alone, at the state whose forces are in ``contacts``."""
    if sys.kinds[i, 0] == BILATERAL:
        return contacts.la[i, 0] != 0.0 and uniqueness(i, contacts) < 0.0
    a, G = contacts.work.start[contacts.place[i]], contacts.work.G
    return contacts.la[i, 0] > 0.0 and G[a, a] + contacts.ratio[i] * G[a, a + 1] < 0.0


@kernel
def count_step(sys, state, contacts):
    """Count a step at whose end several forces fit; where they do not, the next region is another one."""
    is_counted = False
    for i in range(sys.n_c):
        if not slides_alone(sys, i, contacts) or not several_fit(sys, i, contacts):
            contacts.several[i] = 0
        elif not is_counted:
            state.counters.several += 1
            is_counted = True


@kernel
def enters_region(sys, event, contacts):
    """Whether an event is that a second force begins to fit: the slide goes on, and no mode is decided."""
    i = event // N_FUNCTIONS
    return 0 <= event < N_FUNCTIONS * sys.n_c and event % N_FUNCTIONS == UNIQUE and sys.kinds[i, 0] == BILATERAL


@kernel
def note_several(sys, t, i, enters, state, contacts):
    """Note that several forces fit the slide of contact i, unless that was noted when its mode was decided."""
    if contacts.several[i] == 1 or not (enters or several_fit(sys, i, contacts)):
        return
    contacts.several[i] = 1
    event = state.event
    event.gamma_F, event.solutions, event.found = contacts.gamma[i, 1], 2, modes_that_fit(sys, i, contacts)
    mode, slip = contacts.mode[i], contacts.slip[i]
    append_event(t, INDETERMINATE, i, mode, slip, mode, slip, state)


@kernel
def modes_that_fit(sys, i, contacts):
    """The two modes as bits."""
    slide, pull = SLIDE_PLUS, PULL_PLUS
    if contacts.slip[i] < 0:
        slide, pull = SLIDE_MINUS, PULL_MINUS
    return 1 << slide | (1 << pull if sys.kinds[i, 0] == BILATERAL else 1 << FREE)
