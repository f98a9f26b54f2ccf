"""What a series of bounces does that is given up, beside a rough guide: a bilateral contact that slides.

A contact leaves with v, comes back with gamma_N' = -a, and keeps the part e of its velocity at each impact. Its flights
last T = 2 v/(a (1 - e)) in all, and its impacts add up to (1 + e)/(1 - e) times one that stops v. The motion that is
held closed from the beginning has the velocity of this one at the end if it starts with

    du = T (u'_flight - u'_closed) + (1 + e)/(1 - e) M^-1 W^T P,    P that of a landing with v, which it stops

What is left of the place is of the height of the flights. Without friction that is M^-1 W^T (-v/G), the impulse which
takes v off at once. The friction of a guide goes with |N|: in flight its force may have the other sign than its impulse
at an impact, and their sizes add up where the forces would cancel.

Source: the geometric series of docs/theory/event_driven.md, (2).
"""

from __future__ import annotations

from nonsmooth.errors import Status
from nonsmooth.integrators.rigid.modes import (
    RigidContacts,
    closed_constraints,
    factorise,
    find_ratios,
    list_equations,
    solve_equations,
)
from nonsmooth.jit import kernel, rare_kernel
from nonsmooth.jit.blocks import view
from nonsmooth.mechanics.sys import Sys
from nonsmooth.mechanics.system import BILATERAL, ContactMode


@kernel
def has_rough_guide(sys, contacts):
    """Whether a bilateral contact with friction slides."""
    for i in range(sys.n_c):
        if sys.kinds[i, 0] == BILATERAL and contacts.mode[i] == ContactMode.SLIDE:
            return True
    return False


@rare_kernel("Tuple((int64, int64))(int64, float64, int64, float64, float64[::1], int64)", short_loops=True)
def find_landing(sys_at, t, i, v, x, contacts_at):
    """The impulses contacts.z of the impact of contact i that stops its velocity -v, the others in their modes:
    (Status, how many).

    The friction of a guide has the direction of its slide and the size of its impulse, whatever the sign of that.
    """
    sys, contacts = view(sys_at, Sys), view(contacts_at, RigidContacts)
    status, n_k = closed_constraints(sys, t, x, contacts)
    if status != Status.RUNNING:
        return status, 0
    if not find_ratios(sys, n_k, contacts):
        return Status.NEGATIVE_FRICTION.value, 0
    m = list_equations(sys, n_k, contacts)
    for _ in range(sys.n_c + 1):
        factorise(m, True, contacts)
        for e in range(m):
            contacts.b[e] = v if contacts.contact[e] == i and contacts.part[e] == 0 else 0.0
        solve_equations(m, contacts)
        if not turn_friction(sys, m, contacts):
            break
    return Status.RUNNING.value, m


@kernel
def slides_by(e, contacts):
    """Whether equation e is that of the normal impulse of a contact that slides by it."""
    return contacts.part[e] == 0 and contacts.mode[contacts.contact[e]] == ContactMode.SLIDE


@kernel
def push(n, m, times, x, contacts):
    """Add so many times the impulses contacts.z to the velocities of x."""
    work = contacts.work
    for e in range(m):
        a, P = contacts.row[e], times * contacts.z[e]
        for j in range(n):
            x[n + j] += work.X[a, j] * P
            if slides_by(e, contacts):
                x[n + j] += work.X[a + 1, j] * contacts.ratio[contacts.contact[e]] * P


@kernel
def turn_friction(sys, m, contacts):
    """Turn la_F/la_N of the guides whose impulse has not the sign that it was taken for; whether there are any."""
    turned = False
    for e in range(m):
        k = contacts.contact[e]
        if contacts.part[e] == 0 and sys.kinds[k, 0] == BILATERAL and contacts.mode[k] == ContactMode.SLIDE:
            is_right = contacts.slip[k] * contacts.ratio[k] * contacts.z[e] <= 0.0
            contacts.ratio[k] *= 1.0 if is_right else -1.0
            turned = turned or not is_right
    return turned
