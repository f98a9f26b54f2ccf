"""Modes that follow from other modes: what a walk over the modes of redundant contacts need not try.

Rows whose velocities are known fix those of the rows that depend on them, whatever the impulses. With K = W M^-1 W^T
and c the velocities without impulses, fixing gamma_i = 0 leaves

    S_ef = K_ef - K_ei K_if / K_ii,    s_e = c_e - K_ei c_i / K_ii

(symmetric elimination). A row with S_ee = 0 has gamma_e = s_e, and one with S_ef^2 = S_ee S_ff has

    gamma_e = (S_ef/S_ff) gamma_f + s_e - (S_ef/S_ff) s_f

A contact whose velocities follow in one of these ways has one mode: it is free where gamma_N > 0 and closed where it
is 0, slides where gamma_F is not zero and sticks where it is. Of the 4^n modes of n feet of a block on a floor ten are
left: it flies, turns about either end, or stays; and with each of the last three, sticks or slides to either side.
Pivots between the two bounds of zero are neither used nor trusted.

Source: Golub, Van Loan, *Matrix Computations*, section 4.2.
"""

from __future__ import annotations

from nonsmooth.contact.planar.enumerate import SAME_MOTION
from nonsmooth.contact.planar.single import FREE, SLIDE_PLUS, STICK, slip_of
from nonsmooth.jit import kernel
from nonsmooth.mechanics.system import GIVEN_FORCE
from nonsmooth.numerics.dense import SINGULAR

# derived, of the diagonal of K: a pivot below SINGULAR is rounding of 0, and one above CLEAR_PIVOT leaves seven digits
# of the rows that are left, so that a velocity is told from zero where it exceeds TOLD_VELOCITY of the largest.
CLEAR_PIVOT, TOLD_VELOCITY = 1e-9, 1e-6
UNKNOWN_SIGN, ZERO_SIGN = 2, 0  # code: what is known of a velocity, beside its sign +1 or -1


@kernel
def begin_walk(r, K, c, tree):
    """Nothing is fixed before the first contact."""
    for k in range(r):
        tree.s[0, k] = c[k]
        for m in range(r):
            tree.S[0, k, m] = K[k, m]


@kernel
def are_dependent(K, problem, tree):
    """Whether a row depends on those before it: then some modes leave the impulses open."""
    r = problem.r
    begin_walk(r, K, problem.c, tree)
    for row in range(r):
        if not tree.S[0, row, row] > SINGULAR * K[row, row]:
            return True
        fix(0, row, K[row, row], r, tree)
    return False


@kernel
def descend(level, candidate, scale, problem, tree):
    """Fix the rows that contact ``level`` holds at zero with this mode; False where what is known before forbids it, or
    where it makes the mode of a contact before another."""
    S, s, first, r = tree.S, tree.s, problem.start[level], problem.r
    for k in range(r):
        s[level + 1, k] = s[level, k]
        for m in range(r):
            S[level + 1, k, m] = S[level, k, m]
    if problem.kinds[level, 0] != GIVEN_FORCE:
        sign = sign_of(level, first, scale, problem, tree)
        if candidate == FREE:
            return sign == UNKNOWN_SIGN or sign == 1
        if sign == 1 or sign == -1:
            return False
        fix(level + 1, first, S[0, first, first], r, tree)
    if problem.kinds[level, 1] > 0:
        t = problem.start[level + 1] - 1
        sign = sign_of(level, t, scale, problem, tree)
        if candidate != STICK and sign != UNKNOWN_SIGN and sign != slip_of(candidate):
            return False
        if candidate == STICK and (sign == 1 or sign == -1):
            return False
        if candidate == STICK:
            fix(level + 1, t, S[0, t, t], r, tree)
    return are_kept(level, scale, problem, tree)


@kernel
def mode_row(k, problem, tree):
    """The row whose velocity has a sign in the mode of contact k on the branch, and this sign; 0 where it has none."""
    candidate = tree.candidate[k]
    if candidate == FREE:
        return problem.start[k], 1
    if candidate >= SLIDE_PLUS and problem.kinds[k, 1] > 0:
        return problem.start[k + 1] - 1, slip_of(candidate)
    return problem.start[k], 0


@kernel
def are_kept(level, scale, problem, tree):
    """Whether the contacts before move as their modes say, as far as that is known now."""
    for k in range(level):
        row, sign = mode_row(k, problem, tree)
        is_told = known(level + 1, row, scale, tree) if sign != 0 else UNKNOWN_SIGN
        if is_told != UNKNOWN_SIGN and is_told != sign:
            return False
    return True


@kernel
def known(level, row, scale, tree):
    """The sign of the velocity of a row that the fixed rows leave no choice."""
    if not abs(tree.S[level, row, row]) <= SINGULAR * tree.S[0, row, row]:
        return UNKNOWN_SIGN
    return sign_at(tree.s[level, row], scale)


@kernel
def sign_at(value, scale):
    """The sign of a velocity, UNKNOWN_SIGN where rounding may have made it."""
    if abs(value) <= SAME_MOTION * scale:
        return ZERO_SIGN
    if abs(value) <= TOLD_VELOCITY * scale:
        return UNKNOWN_SIGN
    return 1 if value > 0.0 else -1


@kernel
def sign_of(level, row, scale, problem, tree):
    """The sign of the velocity of a row of contact ``level``, as it follows from fixed rows, or from a row that is
    parallel to it and has a sign."""
    sign = known(level + 1, row, scale, tree)
    S, s, here = tree.S, tree.s, level + 1
    size = S[here, row, row]
    if sign != UNKNOWN_SIGN or not size > CLEAR_PIVOT * S[0, row, row]:
        return sign
    for k in range(level):
        other, side = mode_row(k, problem, tree)
        if side == 0 or not S[here, other, other] > CLEAR_PIVOT * S[0, other, other]:
            continue
        left = size * S[here, other, other] - S[here, row, other] * S[here, row, other]
        ratio = S[here, row, other] / S[here, other, other]
        distance = abs(s[here, row] - ratio * s[here, other])
        if left <= SINGULAR * size * S[here, other, other] and distance <= SAME_MOTION * scale:
            return side if ratio > 0.0 else -side
    return UNKNOWN_SIGN


@kernel
def fix(level, row, size, r, tree):
    """Eliminate a row of a given size K_ii with the velocity zero from all others, unless it depends on others or
    nearly so."""
    S, s = tree.S, tree.s
    pivot = S[level, row, row]
    if not pivot > CLEAR_PIVOT * size:
        return
    for k in range(r):
        factor = S[level, k, row] / pivot
        if k != row and factor != 0.0:
            s[level, k] -= factor * s[level, row]
            for m in range(r):
                if m != row:
                    S[level, k, m] -= factor * S[level, row, m]
    for k in range(r):
        S[level, k, row] = S[level, row, k] = 0.0
    s[level, row] = 0.0
