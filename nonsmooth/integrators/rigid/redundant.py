"""The forces of redundant contacts: what the modes leave open is shared with the least squares that is admissible.

The forces z cause the accelerations a = sum_f M^-1 w_f z_f, w_f the row of a force and, where its contact slides, that
of its friction; the modes ask for W a = b. Rows that depend on one another leave z open, but not a:

    W = R^T Q,   Q M^-1 Q^T = 1       modified Gram-Schmidt with pivoting, which reveals the rank
    R^T y = b                         the part of a that the contacts see
    (Q M^-1 w_f) z = y                as many equations as the rank, with a null space where contacts share a load

It never forms G, which squares the condition: planes 1e-8 rad apart or opposite are two rows, not one. Of the z with
normal forces that push and friction in its cone the one of least |z|^2 is taken, by the complementarity problem of
contact/planar/redundant.py. Modes that no such z goes with hold no longer.

Source: Golub, Van Loan, *Matrix Computations*, section 5.2; Pfeiffer, Glocker (1996), section 5.4.
"""

from __future__ import annotations

import math

from nonsmooth.contact.planar.least_share import find_least
from nonsmooth.contact.planar.redundant import eliminate_completely, impulse_inequality, least_admissible
from nonsmooth.contact.planar.single import BORDER_WIDTH
from nonsmooth.integrators.rigid.modes import RigidContacts
from nonsmooth.jit import kernel, late_kernel
from nonsmooth.jit.blocks import view
from nonsmooth.mechanics.laws import static_coefficient
from nonsmooth.mechanics.sys import Sys
from nonsmooth.mechanics.system import BILATERAL, GIVEN_FORCE, UNILATERAL, ContactMode
from nonsmooth.numerics.dense import cholesky, cholesky_solve
from nonsmooth.numerics.rounding import rounded_sum

# derived: what is left of a row that depends on others, over its length. Between the two bounds a row is dependent if
# it asks for what the others give, to rounding: of the loads it would say that rounding over the square of what is
# left.
DEPENDENT_ROW, NEARLY_DEPENDENT_ROW = 1e-10, 1e-6
ROW_ROUNDINGS = 200  # chosen: units of rounding
CONSISTENT_ROW = 1e-7  # chosen: of the sizes of its terms: what a dependent row may lack
LARGEST_MARGIN = 1e5  # chosen: largest forces: the margin that is aimed at
# chosen: of the largest force: of the sign that the modes have, whatever rounding leaves of a margin
LEAST_MARGIN = 1e-9
VANISHING = 1e-10  # derived: of the other rows' terms, where its own vanish: W' u by differences has an error of 1e-11


@late_kernel("void(int64, int64, int64)", short_loops=True)
def share_load(sys_at, m, contacts_at):
    """Overwrite contacts.z by the admissible forces of least squares of the m equations, or where there are none by the
    least forces of all, and say which in the facts; of more contacts than there is room for, z stays."""
    sys, contacts = view(sys_at, Sys), view(contacts_at, RigidContacts)
    planar = contacts.redundant.planar
    family = planar.family
    if m > family.B.shape[0]:
        return
    rank, is_consistent = orthogonalise(sys.n, m, contacts)
    reduce(sys.n, m, rank, contacts)
    full = eliminate_completely(m, DEPENDENT_ROW, family)
    largest = 0.0
    for k in range(full):
        largest = max(largest, abs(family.B[k, m]))
    size, is_admissible = 0, False
    for has_guess in (True, False):
        size = list_inequalities(sys, m, BORDER_WIDTH * largest, has_guess, contacts)
        is_admissible = find_share(m, full, size, largest, planar) and is_consistent and full == rank
        if is_admissible:
            break
    for e in range(m):
        contacts.z[e] = family.x[e]
    contacts.facts.is_shared = 0 if full == m else 1
    contacts.facts.is_admissible = 1 if is_admissible else 0
    if largest == 0.0:
        contacts.numbers.margin = 1.0  # no load is near no limit
    elif contacts.facts.margin_asked == 1:
        margin = find_margin(m, full, size, largest, planar) if is_consistent and 0 < full == rank else -largest
        least = LEAST_MARGIN * largest
        contacts.numbers.margin = max(least, margin) if is_admissible else min(-least, margin)


@kernel
def find_share(m, rank, size, largest, planar):
    """The forces of least squares that satisfy the inequalities, to family.x; whether there are any."""
    family = planar.family
    for e in range(m):
        family.x[e] = 0.0
    for k in range(rank):
        family.x[family.column[k]] = -family.B[k, m]
    if m > rank and not least_admissible(m, rank, size, planar):
        return False
    for e in range(size):
        total = BORDER_WIDTH * largest
        for f in range(m):
            total += family.C[e, f] * family.x[f]
        if not total >= family.e[e]:
            return False
    return True


@kernel
def find_margin(m, rank, size, largest, planar):
    """What the worst of the inequalities has left in the share that is best for it [N]: max_y min_e (C x - e)_e.

    With the margin as another unknown s = S + sigma, S = LARGEST_MARGIN largest, and A = C N it is that of

        min (y^T H y + sigma^2)/2    subject to    A y - sigma + C x_0 - e - S >= 0:

    the multipliers add up to -sigma, about S, so that y is that of the linear program but for 1/LARGEST_MARGIN of it.
    """
    family, free = planar.family, m - rank
    B, C, column, x = family.B, family.C, family.column, family.x
    for e in range(m):
        x[e] = 0.0
    for k in range(rank):
        x[column[k]] = -B[k, m]
    for a in range(free + 1):
        for b in range(free + 1):
            family.H[a, b] = 1.0 if a == b else 0.0
            for k in range(rank if max(a, b) < free else 0):
                family.H[a, b] += B[k, rank + a] * B[k, rank + b]
    cholesky(free + 1, free + 1, family.H, family.L)
    for e in range(size):
        planar.b[e] = -family.e[e] - LARGEST_MARGIN * largest
        for k in range(m):
            planar.b[e] += C[e, k] * x[k]
        for a in range(free):
            family.A[e, a] = C[e, column[rank + a]]
            for k in range(rank):
                family.A[e, a] -= C[e, column[k]] * B[k, rank + a]
        family.A[e, free] = -1.0
        for a in range(free + 1):
            family.AH[e, a] = family.A[e, a]
        cholesky_solve(free + 1, free + 1, family.L, family.AH[e])
        family.slack[e] = BORDER_WIDTH * LARGEST_MARGIN * largest
    find_least(size, free + 1, family.slack, planar)
    margin = LARGEST_MARGIN * largest
    for e in range(size):
        total = planar.b[e] + LARGEST_MARGIN * largest
        for a in range(free):
            total += family.A[e, a] * family.y[a]
        margin = min(margin, total)
    return margin


@kernel
def orthogonalise(n, m, contacts):
    """Q and M^-1 Q of the rows that do not depend on others, and y, to contacts.redundant: (their number, whether the
    others ask for the same)."""
    work, rows, b = contacts.work, contacts.redundant, contacts.b
    Q, X, R, y, order, length = rows.Q, rows.X, rows.R, rows.y, rows.order, rows.length
    for e in range(m):
        order[e], length[e] = e, 0.0
        for j in range(n):
            Q[e, j], X[e, j] = work.W[contacts.row[e], j], work.X[contacts.row[e], j]
            length[e] += Q[e, j] * X[e, j]
    rank = 0
    for k in range(m):
        pivot, most = k, 0.0
        for e in range(k, m):
            left = squared(n, Q, X, order[e]) / length[order[e]]
            if left > most:
                pivot, most = e, left
        if not most > DEPENDENT_ROW * DEPENDENT_ROW:
            break
        if most < NEARLY_DEPENDENT_ROW * NEARLY_DEPENDENT_ROW and are_consistent(
            k, m, rounded_sum(ROW_ROUNDINGS, 1.0), 0.0, contacts
        ):
            break
        order[k], order[pivot] = order[pivot], order[k]
        e = order[k]
        norm = math.sqrt(squared(n, Q, X, e))
        R[k, e] = norm
        y[k] = b[e]
        for l in range(k):
            y[k] -= R[l, e] * y[l]
        y[k] /= norm
        for j in range(n):
            Q[e, j] /= norm
            X[e, j] /= norm
        for f in range(k + 1, m):
            g = order[f]
            R[k, g] = 0.0
            for j in range(n):
                R[k, g] += Q[e, j] * X[g, j]
            for j in range(n):
                Q[g, j] -= R[k, g] * Q[e, j]
                X[g, j] -= R[k, g] * X[e, j]
        rank += 1
    return rank, are_consistent(rank, m, CONSISTENT_ROW, VANISHING, contacts)


@kernel
def are_consistent(rank, m, tolerance, vanishing, contacts):
    """Whether the rows after the first ``rank`` ask for what these give, within a part of the sizes of their terms.

    A row whose terms all vanish asks for the error of the others: ``vanishing`` of its length times |y|.
    """
    rows, b = contacts.redundant, contacts.b
    total = 0.0
    for l in range(rank):
        total += rows.y[l] * rows.y[l]
    error = vanishing * math.sqrt(total)
    for k in range(rank, m):
        e = rows.order[k]
        lack, terms = b[e], abs(b[e])
        for l in range(rank):
            lack -= rows.R[l, e] * rows.y[l]
            terms += abs(rows.R[l, e] * rows.y[l])
        if not abs(lack) <= tolerance * terms + error * math.sqrt(rows.length[e]):
            return False
    return True


@kernel
def squared(n, Q, X, e):
    """Squared length of what is left of row e, in the metric M^-1."""
    total = 0.0
    for j in range(n):
        total += Q[e, j] * X[e, j]
    return total


@kernel
def reduce(n, m, rank, contacts):
    """(Q M^-1 w_f) z - y = 0 to family.B, each equation over its largest coefficient."""
    work, rows, family = contacts.work, contacts.redundant, contacts.redundant.planar.family
    for k in range(m):
        family.column[k] = k
        for f in range(m + 1):
            family.B[k, f] = 0.0
    for k in range(rank):
        e = rows.order[k]
        largest = 0.0
        for f in range(m):
            i, a = contacts.contact[f], contacts.row[f]
            for j in range(n):
                family.B[k, f] += rows.X[e, j] * work.W[a, j]
                if contacts.part[f] == 0 and contacts.mode[i] == ContactMode.SLIDE:
                    family.B[k, f] += contacts.ratio[i] * rows.X[e, j] * work.W[a + 1, j]
            largest = max(largest, abs(family.B[k, f]))
        family.B[k, m] = -rows.y[k]
        if largest > 0.0:
            for f in range(m + 1):
                family.B[k, f] /= largest


@kernel
def list_inequalities(sys, m, slack, has_guess, contacts):
    """What the modes ask of the forces z, to family.C and family.e; returns the number of inequalities.

    The sign of a bilateral force that sticks is that of the guess in contacts.z, or the one that it had before.
    """
    family = contacts.redundant.planar.family
    size = 0
    for e in range(m):
        i = contacts.contact[e]
        kind, sticks = sys.kinds[i, 0], contacts.mode[i] == ContactMode.STICK
        if contacts.part[e] == 0 and (kind == UNILATERAL or sys.kinds[i, 1] > 0):
            sign = 1.0
            if kind == BILATERAL:
                sign = float(contacts.sign[i])
                if sticks and has_guess:
                    sign = -1.0 if contacts.z[e] < 0.0 else 1.0
            size = impulse_inequality(e, sign, 0.0, -slack, size, m, family)
            if sticks:
                reach = sign * static_coefficient(sys.laws, i)
                size = impulse_inequality(e, reach, 1.0, -slack, size, m, family)
                size = impulse_inequality(e, reach, -1.0, -slack, size, m, family)
        elif kind == GIVEN_FORCE:
            reach = static_coefficient(sys.laws, i) * contacts.la[i, 0] + slack
            size = impulse_inequality(e, 1.0, 0.0, -reach, size, m, family)
            size = impulse_inequality(e, -1.0, 0.0, -reach, size, m, family)
    return size
