"""What a series of bounces does that a landing leaves out, beside a rough guide.

The plain step of a landing drops bounces lower than the tolerance (adaptive/substep.py, 5): it stops the contact. The
bounces would have begun with e v, v the velocity of the landing, and ended where the motion does that is held closed
and begins with

    du = 2 e/(1 - e) (M^-1 W^T P + (v/a) (u'_flight - u'_closed)),    P that of the landing, a = -gamma_N' in flight

more (rigid/series.py). Without friction in a guide that is zero.
"""

from __future__ import annotations

from nonsmooth.errors import Status
from nonsmooth.integrators.adaptive.events import event_values, set_bands
from nonsmooth.integrators.records import FRICTION_WORK
from nonsmooth.integrators.rigid.series import find_landing, has_rough_guide, push, slides_by
from nonsmooth.jit import kernel
from nonsmooth.jit.blocks import address
from nonsmooth.mechanics.laws import LAW_E_N
from nonsmooth.mechanics.system import BILATERAL, ContactMode


@kernel
def landed(run):
    """The only contact that has landed and whose bounces were left out; -1 if there is none, or more than one."""
    found, contacts = -1, run.contacts
    for i in range(contacts.mode.shape[0]):
        if run.dropped[i] > 0.0 and run.mode[i] == ContactMode.OPEN and contacts.mode[i] != ContactMode.OPEN:
            if found >= 0:
                return -1
            found = i
    return found


@kernel
def add_series(sys, t, state, run):
    """Give run.x the velocity from which the contact that has landed comes to that after its bounces; a Status."""
    contacts, work, x, n = run.contacts, run.contacts.work, run.x, state.q.shape[0]
    i = landed(run)
    if i < 0 or not has_rough_guide(sys, contacts):
        return Status.RUNNING.value
    e, v, mode = sys.laws[i, LAW_E_N], run.dropped[i], contacts.mode[i]
    status = event_values(sys, t, x, run, run.f_in)
    if status != Status.RUNNING:
        return status
    change = run.jump
    for j in range(n):
        change[0, j] = -work.du[j]
    contacts.mode[i] = ContactMode.OPEN.value
    status = event_values(sys, t, x, run, run.f_in)
    if status == Status.RUNNING and turn_signs(sys, contacts):
        status = event_values(sys, t, x, run, run.f_in)
    contacts.mode[i] = mode
    if status != Status.RUNNING:
        return status
    a = 0.0
    for j in range(n):
        change[0, j] += work.du[j]
        a -= work.W_N[i, j] * change[0, j]
    if not (a > 0.0 and e < 1.0):
        return Status.RUNNING.value
    times = 2.0 * e / (1.0 - e)
    book_forces(times * v / a, state, run)
    status, m = find_landing(address(sys), t, i, v, x, address(contacts))
    if status != Status.RUNNING:
        return status
    for j in range(n):
        x[n + j] += times * v / a * change[0, j]
    push(n, m, times, x, contacts)
    book_landing(m, times, state, run)
    status = event_values(sys, t, x, run, run.f_0)
    if status == Status.RUNNING and turn_signs(sys, contacts):
        status = event_values(sys, t, x, run, run.f_0)
    book_forces(-times * v / a, state, run)
    set_bands(sys, run)
    for j in range(n):
        run.force_0[j] = work.du[j]
    return status


@kernel
def turn_signs(sys, contacts):
    """Give the guides that slide the signs of their present forces; whether any had another."""
    turned = False
    for k in range(contacts.mode.shape[0]):
        is_guide = sys.kinds[k, 0] == BILATERAL and contacts.mode[k] == ContactMode.SLIDE
        if is_guide and contacts.sign[k] * contacts.la[k, 0] < 0.0:
            contacts.sign[k], turned = -contacts.sign[k], True
    return turned


@kernel
def book_forces(time, state, run):
    """Add the impulses of the present forces over a time, and the work of their friction."""
    contacts = run.contacts
    for k in range(state.mode.shape[0]):
        for axis in range(state.P_sum.shape[1]):
            state.P_sum[k, axis] += time * contacts.la[k, axis]
        state.ledger[FRICTION_WORK] += time * contacts.la[k, 1] * contacts.gamma[k, 1]


@kernel
def book_landing(m, times, state, run):
    """Add so many times the impulses in contacts.z, and the work of their friction."""
    contacts = run.contacts
    for e in range(m):
        k, P = contacts.contact[e], times * contacts.z[e]
        state.P_sum[k, contacts.part[e]] += P
        if slides_by(e, contacts):
            state.P_sum[k, 1] += contacts.ratio[k] * P
            state.ledger[FRICTION_WORK] += contacts.ratio[k] * P * contacts.gamma[k, 1]
