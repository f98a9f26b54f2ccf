"""The least member of a family of impulses that satisfies linear inequalities: a dual active set.

    min y^T H y / 2    subject to    A y + b >= 0

with H positive definite has one solution or none. The method begins with y = 0 and adds the inequality p that is
violated most, by a step along z = H^-1 (A_p - A_W^T r), which keeps those of the active set W at equality, r the change
of their multipliers. Where a multiplier falls to zero first its inequality is dropped; where nothing can be changed,
z = 0 and r <= 0, no y satisfies all. Every step raises the minimum, so that no active set returns. Redundant contacts
on the borders of their cones make many inequalities active at once: an active set of dependent ones is never formed.

Source: Goldfarb, Idnani, *Math. Program.* 27 (1983) 1.
"""

from __future__ import annotations

import math

from nonsmooth.jit import kernel
from nonsmooth.numerics.dense import cholesky, cholesky_solve

DEPENDENT_CHANGE = 1e-12  # chosen: of |A_p|^2: a step that changes the inequality by less keeps to the active set
ACTIVE_SET_STEPS = 20  # chosen: times the number of inequalities


@kernel
def find_least(size, free, tolerance, planar):
    """Write y to family.y; False where no y satisfies the inequalities within ``tolerance[e]`` each.

    A and A H^-1 are in ``family``, b in ``planar``; family.H and family.L are overwritten.
    """
    family, multiplier, active = planar.family, planar.z, planar.basis
    for a in range(free):
        family.y[a] = 0.0
    count = 0
    p = most_violated(size, free, tolerance, planar)
    if p >= 0:
        multiplier[p] = 0.0
    for _ in range(1 + ACTIVE_SET_STEPS * size):
        if p < 0:
            return True
        curvature, length = find_direction(p, count, free, planar)
        value = inequality(p, free, planar)
        step, last = math.inf, -1
        if curvature > DEPENDENT_CHANGE * length:
            step = -value / curvature
        for j in range(count):
            change = planar.trial[j]
            if change > 0.0 and multiplier[active[j]] < step * change:
                step, last = multiplier[active[j]] / change, j
        if step == math.inf:
            return False
        take_step(step, p, count, free, curvature > DEPENDENT_CHANGE * length, planar)
        if last >= 0:
            for j in range(last, count - 1):
                active[j] = active[j + 1]
            count -= 1
            continue
        active[count] = p
        count += 1
        p = most_violated(size, free, tolerance, planar)
        if p >= 0:
            multiplier[p] = 0.0
    return False


@kernel
def inequality(e, free, planar):
    """(A y + b)_e."""
    total = planar.b[e]
    for a in range(free):
        total += planar.family.A[e, a] * planar.family.y[a]
    return total


@kernel
def product(e, f, free, planar):
    """A_e H^-1 A_f."""
    total = 0.0
    for a in range(free):
        total += planar.family.AH[e, a] * planar.family.A[f, a]
    return total


@kernel
def most_violated(size, free, tolerance, planar):
    """The inequality that is violated most, by the distance in the metric H; -1 where all hold."""
    which, farthest = -1, 0.0
    for e in range(size):
        value = inequality(e, free, planar)
        if value < -tolerance[e]:
            distance = value * value / max(product(e, e, free, planar), 1e-300)
            if distance > farthest:
                which, farthest = e, distance
    return which


@kernel
def find_direction(p, count, free, planar):
    """r to planar.trial: (what a unit step changes of inequality p, |A_p|^2 in the metric H^-1)."""
    family, active, r = planar.family, planar.basis, planar.trial
    for j in range(count):
        r[j] = product(active[j], p, free, planar)
        for k in range(count):
            family.H[j, k] = product(active[j], active[k], free, planar)
    length = product(p, p, free, planar)
    curvature = length
    if count > 0:
        cholesky(count, count, family.H, family.L)
        cholesky_solve(count, count, family.L, r)
    for j in range(count):
        curvature -= r[j] * product(active[j], p, free, planar)
    return curvature, length


@kernel
def take_step(step, p, count, free, moves, planar):
    """Change the multipliers by a step, and y with them where it moves."""
    family, multiplier, active = planar.family, planar.z, planar.basis
    multiplier[p] += step
    for j in range(count):
        multiplier[active[j]] = max(0.0, multiplier[active[j]] - step * planar.trial[j])
    if not moves:
        return
    for a in range(free):
        change = family.AH[p, a]
        for j in range(count):
            change -= planar.trial[j] * family.AH[active[j], a]
        family.y[a] += step * change
