"""When the solutions of a contact problem are counted anew.

A census tries every combination of modes (planar/enumerate.py) of the contacts that reduction.py leaves. Up to
EVERY_STEP combinations that is done with each problem, but for the first of these reasons not to. More are counted
where the last census of these contacts does not tell:

* all of its pivots were positive, so that there was one solution whatever c, and no entry of G has changed by more
  than a part of the least pivot since, and no friction coefficient, none of which differs for a contact that sticks;
* it found one solution with the modes that the contacts still have, and no entry of G, c and mu has changed by more
  than MATERIAL since; or none that it could tell from others, where contacts are redundant, and so would a new one.

A census costs up to 1e5 times what a step costs. So it may wait, where the caller allows: each problem pays off
EARNED of the work of the censuses taken, and none is begun with a debt of more than LARGEST_DEBT. What is then neither
certified nor counted is said to be not counted. So a run pays for one census and 4 us a step at most.
"""

from __future__ import annotations

from nonsmooth.contact.planar.single import FREE
from nonsmooth.jit import kernel

EVERY_STEP = 64  # measured: combinations: three contacts, about 4 us
MATERIAL = 0.01  # chosen: relative change of a number after which the last census does not tell
# chosen: part of the least pivot by which G may change: its determinant cannot change sign by less, but for a factor
SAFE = 0.1
ORIENTED = 1e-6  # chosen: least pivot that counts as positive: far above rounding
EARNED = 200  # measured: work of a census (eliminations times contacts, 20 ns each) that a problem pays off: 4 us
LARGEST_DEBT = 50_000  # measured: 1 ms: beyond it no other census is begun
UNKNOWN, NOT_TOLD, ONE_AS_BEFORE, ALWAYS_ONE = range(4)
LEFT_OUT, ALONE = -2, -1  # code: the part of a contact in a census, or the number of the first contact of its group


@kernel
def known_solutions(left, problem, planar):
    """What the last census of these contacts says of a problem: UNKNOWN, NOT_TOLD (the modes were
    singular), ONE_AS_BEFORE or ALWAYS_ONE solution."""
    memory, place = planar.memory, planar.rest.place
    first = problem.closed[0]
    if memory.members[first] != problem.n:
        return UNKNOWN
    is_as_before, is_oriented = memory.found[first] <= 1, memory.least[first] > ORIENTED
    e = 0
    for k in range(problem.n):
        i = problem.closed[k]
        if memory.stamp[i] != memory.stamp[first]:
            return UNKNOWN
        is_as_before = is_as_before and memory.candidate[i] == problem.candidate[k]
        role = LEFT_OUT
        if e < left and place[e] == k:
            role = role_of(e, problem, planar)
            e += 1
        has_same_law = problem.mu[k] == memory.mu[i] and problem.mu_static[k] == problem.mu[k]
        is_oriented = is_oriented and memory.role[i] == role and has_same_law
    if is_oriented and is_near(SAFE * memory.least[first], problem, memory):
        return ALWAYS_ONE
    if planar.may_wait == 1 and is_as_before and is_near(MATERIAL, problem, memory) and is_same_load(problem, memory):
        return ONE_AS_BEFORE if memory.found[first] == 1 else NOT_TOLD
    return UNKNOWN


@kernel
def role_of(e, problem, planar):
    """The part of a contact in a census: in a group, by the number of its first contact in the system, or alone."""
    group = planar.tree.group[e]
    return ALONE if group == 0 else problem.closed[planar.rest.place[group - 1]]


@kernel
def row_in_memory(a, k, problem, memory):
    """Where the memory has row a, which is one of contact k."""
    rows = memory.c.shape[0] // memory.stamp.shape[0]  # of each contact of the system
    return problem.closed[k] * rows + a - problem.start[k]


@kernel
def is_near(part, problem, memory):
    """Whether no entry of G has changed by more than a part of its diagonal since the last census."""
    G, start, part = problem.G, problem.start, min(part, MATERIAL)
    for k in range(problem.n):
        for a in range(start[k], start[k + 1]):
            row = row_in_memory(a, k, problem, memory)
            for m in range(problem.n):
                for b in range(start[m], start[m + 1]):
                    change = G[a, b] - memory.G[row, row_in_memory(b, m, problem, memory)]
                    if not change * change <= part * part * G[a, a] * G[b, b]:
                        return False
    return True


@kernel
def is_same_load(problem, memory):
    """Whether no velocity, friction coefficient or given force has changed materially since the last census."""
    for k in range(problem.n):
        i = problem.closed[k]
        if abs(problem.mu[k] - memory.mu[i]) > MATERIAL * memory.mu[i]:
            return False
        if abs(problem.normal_impulse[k] - memory.normal_impulse[i]) > MATERIAL * memory.normal_impulse[i]:
            return False
        for a in range(problem.start[k], problem.start[k + 1]):
            before = memory.c[row_in_memory(a, k, problem, memory)]
            if abs(problem.c[a] - before) > MATERIAL * abs(before):
                return False
    return True


@kernel
def remember_census(found, left, problem, planar):
    """Note a census, and its work."""
    memory, start = planar.memory, problem.start
    memory.last += 1
    memory.debt += planar.tree.nodes * left
    for k in range(problem.n):
        i = problem.closed[k]
        memory.stamp[i], memory.members[i], memory.found[i] = memory.last, problem.n, found
        memory.candidate[i], memory.role[i], memory.least[i] = FREE, LEFT_OUT, planar.tree.least
        memory.mu[i], memory.normal_impulse[i] = problem.mu[k], problem.normal_impulse[k]
        for a in range(start[k], start[k + 1]):
            row = row_in_memory(a, k, problem, memory)
            memory.c[row] = problem.c[a]
            for m in range(problem.n):
                for b in range(start[m], start[m + 1]):
                    memory.G[row, row_in_memory(b, m, problem, memory)] = problem.G[a, b]
    for e in range(left):
        memory.role[problem.closed[planar.rest.place[e]]] = role_of(e, problem, planar)


@kernel
def note_modes(problem, memory):
    """Note the modes that were taken after a census."""
    for k in range(problem.n):
        memory.candidate[problem.closed[k]] = problem.candidate[k]


@kernel
def pay_census_debt(memory):
    """What a problem pays off of the censuses before it."""
    memory.debt = max(0, memory.debt - EARNED)


@kernel
def may_count(planar):
    """Whether a census may be taken now."""
    return planar.may_wait == 0 or planar.memory.debt <= LARGEST_DEBT
