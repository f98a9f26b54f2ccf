"""Records that steps write by themselves, one behind the other, without a way back to Python.

A step of one body takes 2 us, and a record of it that Python writes 60. Steps come back where that takes more than
their rows and those that sleep: of the parts of a divided step, of friction with a grain, and where there is no room.
"""

from __future__ import annotations

from typing import Annotated as Array

from nonsmooth.contact.network.problem import Network
from nonsmooth.integrators.assembly.bodies import Bodies
from nonsmooth.integrators.assembly.book import Ledger
from nonsmooth.integrators.assembly.contacts import Contacts
from nonsmooth.integrators.assembly.divided import Parts
from nonsmooth.integrators.assembly.joints import Reactions
from nonsmooth.integrators.assembly.progress import DONE, REBOUND, RECORD, Progress
from nonsmooth.integrators.assembly.sleep import Asleep
from nonsmooth.integrators.assembly.stages import take_steps
from nonsmooth.jit import in_dimensions, kernel
from nonsmooth.jit.blocks import Block, Floats, Ints, new, view
from nonsmooth.scenes.detection import FIRST_ROLLING, Found

NEVER = 2**62  # code: a number of steps that no run comes to


class Written(Block):
    """m records of n_b bodies and n_n joints, with r contacts in all."""

    n: int  # records that are written
    rows: int  # contacts of those that steps wrote by themselves
    due: int  # the number of steps at which the next record is
    stride: int  # steps between two of them
    has_contacts: int
    t: Array[Floats, "m"]  # [s]
    residual: Array[Floats, "m"]
    penetration: Array[Floats, "m"]  # [m]
    x: Array[Floats, "m", "n_b", "n_x"]
    v: Array[Floats, "m", "n_b", "n"]
    works: Array[Floats, "m", "n_w"]  # [J]
    joint_impulses: Array[Floats, "m", "n_n", "d"]  # [N s]
    joint_torques: Array[Floats, "m", "n_n", "2 * d - 3"]  # [N m s]
    contacts: Array[Ints, "m"]  # of each record
    is_mixed: int  # whether some of these sleep, which stand behind the others
    key: Array[Ints, "r"]
    i: Array[Ints, "r"]
    j: Array[Ints, "r"]
    mu: Array[Floats, "r"]
    gap: Array[Floats, "r"]  # [m]
    normal: Array[Floats, "r", "d"]
    point: Array[Floats, "r", "d"]  # [m]
    P: Array[Floats, "r", "d"]  # [N s]

    def begin_of_interval(self, first: int, t: float) -> tuple[int, float]:
        """The number of steps and the time [s] of the last record, or those given, where there is none behind them."""
        last = int(self.due - self.stride)
        return (last, float(self.t[self.n - 1])) if last > first else (first, t)


def no_records(dim: int) -> Written:
    """For steps none of which is recorded."""
    written = new(Written, m=0, r=0, n_b=0, n_n=0, n_x=0, n=0, n_w=0, d=dim)
    written.due = written.stride = NEVER
    return written


@in_dimensions("int64(int64, int64, int64)")
def take_recorded(progress_at, written_at, until, d):
    """Take steps until there are so many, with the records that fall due; how it comes back, DONE or why not."""
    progress, written = view(progress_at, Progress), view(written_at, Written)
    counts = progress.counts
    while True:
        most = min(until, written.due) - counts.steps
        if progress.stage >= REBOUND and progress.left == 0.0:
            most += 1  # the step is counted, and not at its end
        end = take_steps(progress_at, most, d)
        if end != DONE:
            return end
        if counts.steps == written.due and not write_record(progress, written, d):
            return RECORD
        if counts.steps >= until:
            return DONE


@kernel
def write_record(progress, written, d):
    """Write the state as the next record; False where that takes more than the rows of the step."""
    k, figures, places = written.n, progress.figures, progress.places
    if written.has_contacts == 1 and not write_contacts_of(progress, written, d):
        return False
    bodies, ledger = view(places.bodies, Bodies), view(places.ledger, Ledger)
    x, v, reactions = bodies.motion.x, bodies.motion.v, view(places.reactions, Reactions)
    written.residual[k], written.penetration[k] = figures.since_residual, figures.since_penetration
    figures.since_residual = figures.since_penetration = 0.0
    for b in range(x.shape[0]):
        for a in range(x.shape[1]):
            written.x[k, b, a] = x[b, a]
        for a in range(v.shape[1]):
            written.v[k, b, a] = v[b, a]
    for w in range(ledger.work.shape[0]):
        written.works[k, w] = ledger.work[w]
    for of in range(reactions.P.shape[0]):
        for a in range(d):
            written.joint_impulses[k, of, a] = reactions.P[of, a]
        for a in range(2 * d - 3):
            written.joint_torques[k, of, a] = reactions.torque[of, a]
    written.n, written.due = k + 1, written.due + written.stride
    return True


@kernel
def write_contacts_of(progress, written, d):
    """Write the contacts of the last step, those that sleep behind the others; False where there is no room, or they
    are more than its rows."""
    places, row = progress.places, written.rows
    found, network, contacts = view(places.found, Found), view(places.network, Network), view(places.contacts, Contacts)
    asleep = view(places.asleep, Asleep)
    if progress.has_grain == 1 or view(places.parts, Parts).n_c > 0:
        return False
    if row + network.n_c + asleep.n_c > written.i.shape[0]:
        return False
    c = 0
    while c < network.n_c and found.key[c] < FIRST_ROLLING:
        i, j = network.i[c], network.j[c]
        if asleep.count == 0 or (asleep.island[i] == 0 and asleep.island[j] == 0):
            written.key[row], written.i[row], written.j[row] = found.key[c], i, j
            written.mu[row], written.gap[row] = network.mu[c], found.gap[c]
            write_vectors(written, row, (found.normal, found.point, network.J_j, contacts.P), c, d)
            row += 1
        c += 1
    if asleep.count > 0:
        written.is_mixed = 1
        for c in range(asleep.n_c):
            if asleep.key[c] < FIRST_ROLLING:
                written.key[row], written.i[row], written.j[row] = asleep.key[c], asleep.i[c], asleep.j[c]
                written.mu[row], written.gap[row] = asleep.mu[c], asleep.gap[c]
                write_vectors(written, row, (asleep.normal, asleep.point, asleep.frame, asleep.own), c, d)
                row += 1
    written.contacts[written.n], written.rows = row - written.rows, row
    return True


@kernel
def write_vectors(written, row, of, c, d):
    """The normal, the point and the impulse of contact c."""
    normal, point, frame, own = of
    for a in range(d):
        written.normal[row, a], written.point[row, a] = normal[c, a], point[c, a]
        total = 0.0
        for k in range(d):
            total += frame[c, k, a] * own[c, k]
        written.P[row, a] = total
