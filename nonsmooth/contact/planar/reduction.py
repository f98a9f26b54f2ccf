"""Contacts that add no motion to a problem: what a census may leave out, and what it may take together.

A body that stands on many feet touches its floor on one line. A foot i between j and k on it has the rows

    W_i = l W_j + (1 - l) W_k,    0 <= l <= 1,

normal and tangential ones, and so have the rows of G. Let the friction coefficients be equal. Where
c_N,i >= l c_N,j + (1 - l) c_N,k the contact cannot close unless j and k do. Then the body does not turn, all three
slide alike, and j and k can give the impulse of i in the parts l and 1 - l: it is left out, and the motions that solve
the problem are the same.

Contacts whose friction rows differ by a part of what their normal rows differ by,

    W_F,j - W_F,k = h (W_N,j - W_N,k),    h = 0 on a flat floor,

slide alike where both are closed, gamma_N = 0. They are a group: of the modes only those count in which its closed
members all stick, or slide the same way. In these the first closed one takes the friction of all, up to the sum of
their limits.

Lines are told by G alone: |W_i - W_j|^2 = G_ii + G_jj - 2 G_ij in the metric of the masses.
"""

from __future__ import annotations

from nonsmooth.contact.planar.enumerate import modes_of
from nonsmooth.contact.planar.problem import largest_velocity
from nonsmooth.jit import kernel
from nonsmooth.mechanics.system import UNILATERAL

# derived: of the diagonal of G: a squared distance below is rounding, of rows that differ by 1e-7 at most
SAME_ROW = 1e-14
# chosen: rows, relative to their lengths, and velocities, relative to max |c|, that differ by less are the same
EQUAL_ROWS = 1e-9
TILT = 1e-2  # chosen: largest h of a group: what one contact gives in place of another differs by as much


@kernel
def group_contacts(problem, planar):
    """List the contacts that a census must look at in planar.rest.place, and the groups of them; how many they are."""
    n, place, group, scale = problem.n, planar.rest.place, planar.tree.group, largest_velocity(problem)
    for k in range(n):
        planar.stays[k] = 1  # stays
    for b in range(n if n > 2 else 0):
        if planar.stays[b] == 1 and problem.kinds[b, 0] == UNILATERAL:
            j = farthest(b, problem, planar)
            k = farthest(j, problem, planar)
            leave_out(j, k, scale, problem, planar)
    left = 0
    for k in range(n):
        if planar.stays[k] == 1:
            place[left] = k
            left += 1
    for e in range(min(left, group.shape[0])):
        group[e] = 0
        for f in range(e):
            if (group[f] == 0 or group[f] == f + 1) and slide_alike(place[f], place[e], scale, problem):
                group[f] = f + 1
                group[e] = f + 1
                break
    return left


@kernel
def is_alike(j, k, problem):
    """Whether two contacts are unilateral, and both with or both without friction."""
    kinds = problem.kinds
    return kinds[j, 0] == UNILATERAL and kinds[k, 0] == UNILATERAL and kinds[j, 1] == kinds[k, 1]


@kernel
def squared_distance(j, k, G):
    """|W_j - W_k|^2 of two rows."""
    return max(0.0, G[j, j] + G[k, k] - G[j, k] - G[k, j])


@kernel
def farthest(b, problem, planar):
    """The contact farthest from b, in the metric of the masses, of those that are alike and stay."""
    largest, found = 0.0, b
    for k in range(problem.n):
        if planar.stays[k] == 1 and is_alike(b, k, problem):
            distance = squared_distance(problem.start[b], problem.start[k], problem.G)
            if distance > largest:
                largest, found = distance, k
    return found


@kernel
def leave_out(j, k, scale, problem, planar):
    """Leave out the contacts between j and k."""
    G, start, mu = problem.G, problem.start, problem.mu
    length = squared_distance(start[j], start[k], G)
    if not length > SAME_ROW * (G[start[j], start[j]] + G[start[k], start[k]]):
        return
    if not (problem.kinds[j, 1] == 0 or slide_alike(j, k, scale, problem)):
        return
    for i in range(problem.n):
        if i == j or i == k or planar.stays[i] == 0 or not is_alike(i, j, problem):
            continue
        from_j, from_k = squared_distance(start[i], start[j], G), squared_distance(start[i], start[k], G)
        part = 0.5 * (length + from_k - from_j) / length  # the foot of the perpendicular on the line from k to j
        if part < 0.0 or part > 1.0 or mu[i] != mu[j] or mu[i] != mu[k]:
            continue
        if is_between(i, j, k, part, scale, problem):
            planar.stays[i] = 0


@kernel
def is_between(i, j, k, part, scale, problem):
    """Whether the rows and velocities of contact i are those of j and k, in the parts ``part`` and 1 - ``part``."""
    G, c, start = problem.G, problem.c, problem.start
    for axis in range(1 + problem.kinds[i, 1]):
        a, b, d = start[i] + axis, start[j] + axis, start[k] + axis
        for m in range(problem.r):
            off = G[a, m] - part * G[b, m] - (1.0 - part) * G[d, m]
            if off * off > EQUAL_ROWS * EQUAL_ROWS * G[a, a] * G[m, m]:
                return False
        off = c[a] - part * c[b] - (1.0 - part) * c[d]
        if off < -EQUAL_ROWS * scale or (axis == 1 and off > EQUAL_ROWS * scale):
            return False
    return True


@kernel
def slide_alike(j, k, scale, problem):
    """Whether two closed contacts slide with one velocity."""
    G, c = problem.G, problem.c
    if not is_alike(j, k, problem) or problem.kinds[j, 1] == 0:
        return False
    if problem.mu[j] != problem.mu_static[j] or problem.mu[k] != problem.mu_static[k]:
        return False
    a, b = problem.start[j], problem.start[k]
    length = squared_distance(a, b, G)
    tilt = 0.0
    if length > SAME_ROW * (G[a, a] + G[b, b]):
        tilt = (G[a + 1, a] - G[a + 1, b] - G[b + 1, a] + G[b + 1, b]) / length
    if abs(tilt) > TILT or abs(c[a + 1] - c[b + 1] - tilt * (c[a] - c[b])) > EQUAL_ROWS * scale:
        return False
    for m in range(problem.r):
        off = G[a + 1, m] - G[b + 1, m] - tilt * (G[a, m] - G[b, m])
        if off * off > EQUAL_ROWS * EQUAL_ROWS * G[a + 1, a + 1] * G[m, m]:
            return False
    return True


@kernel
def count_modes(left, most, problem, planar):
    """Number of combinations of modes that are left, at most ``most`` + 1; that where the tree has no room for them."""
    group = planar.tree.group
    if left > group.shape[0]:
        return most + 1
    total = 1
    for e in range(left):
        modes = modes_of(planar.rest.place[e], problem.kinds)
        if group[e] == e + 1:
            members = 0
            for f in range(left):
                members += 1 if group[f] == e + 1 else 0
            modes = 1 + 3 * ((1 << members) - 1)
        elif group[e] != 0:
            modes = 1
        total *= modes
        if total > most:
            return most + 1
    return total
