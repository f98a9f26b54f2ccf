"""One planar contact, solved in closed form by its modes.

    gamma_N = c_N + G_NN P_N + G_NF P_F,    gamma_F = c_F + G_FN P_N + G_FF P_F

FREE            P = 0                                                admissible if gamma_N >= 0 (unilateral only)
STICK           gamma_N = gamma_F = 0                                |P_F| <= mu_s |P_N|
SLIDE s, sigma  P_F = -s mu sigma P_N, P_N = -c_N / D,               sigma P_N > 0, s gamma_F > 0
                D = G_NN - s mu sigma G_NF

s is the sign of sliding, sigma that of P_N (+1 for a unilateral contact, where D is called p_s). Each motion is one
mode. A bilateral contact without a load, c_N = 0, slides with P = 0 for either sigma, and where G is singular with
impulses of either sign: of such slides one with D > 0 stands for both. A unilateral contact without a load is free.

At most three modes are admissible. If p_+ and p_- are positive there is one, else {free, slide p < 0, stick} may
coexist, and for a bilateral contact {slide D > 0, stick, slide D < 0}; which one is taken is the rule of ``selection``.
Impulses and velocities may as well be forces and accelerations. A contact is number k of a ``Problem``
(mechanics/contact_problem.py), in whose c the impulses of the others are, if they have any. Every closed contact that
is solved by itself is solved here: the only one of a step or an impact, one to which no other is coupled, and each in
turn of Gauss–Seidel.

Source: Génot, Brogliato, *Eur. J. Mech. A* 18 (1999) 653.
"""

from __future__ import annotations

import math

from nonsmooth.contact.planar.selection import (
    FREE,
    NO_CANDIDATE,
    PULL_MINUS,
    PULL_PLUS,
    SLIDE_MINUS,
    SLIDE_PLUS,
    STICK,
    WORST_RANK,
    Selection,
    rank,
    sigma_of,
    slip_of,
)
from nonsmooth.jit import kernel, rare_kernel
from nonsmooth.mechanics.laws import can_stick, depends_on_speed, friction_coefficient, static_coefficient
from nonsmooth.mechanics.system import BILATERAL, GIVEN_FORCE, UNILATERAL, ContactMode
from nonsmooth.numerics.dense import SINGULAR

# chosen: relative width within which a candidate on the border of admissibility is kept, if no other is
BORDER_WIDTH = 1e-12
STILL_VELOCITY = 1e-12  # chosen: of max |c|: a velocity below is none
SPEED_ITERATIONS = 60  # chosen: bisection alone takes 53 to the last place


@kernel
def rows_of(k, problem):
    """(G_NN, G_NF, G_FN, G_FF, c_N, c_F) of contact k; of a given normal impulse P_N as if G_NN = 1, c_N = -P_N."""
    a, G, c = problem.start[k], problem.G, problem.c
    if problem.kinds[k, 0] == GIVEN_FORCE:
        return 1.0, 0.0, 0.0, G[a, a], -problem.normal_impulse[k], c[a]
    t = a + 1
    return G[a, a], G[a, t], G[t, a], G[t, t], c[a], c[t]


@kernel
def slide(k, problem, s, sigma):
    """Sliding impulses (P_N, P_F, gamma_F, D) for given signs.

    A law mu(v) is taken at v = s (offset + gamma_F) / 2, the speed in the middle of the step; ``offset`` is the sliding
    velocity before it, gamma_F that after it. The scalar equation for v is solved by Newton steps inside a bracket.
    """
    G_NN, G_NF, G_FN, G_FF, c_N, c_F = rows_of(k, problem)
    v = max(0.0, s * offset_of(k, problem))
    if depends_on_speed(problem.laws, k):
        v = mid_point_speed(k, problem, v, s, sigma)
    mu = friction_coefficient(problem.laws, k, v)
    D = G_NN - s * mu * sigma * G_NF
    P_N = -c_N / D if D != 0.0 else -sigma * 1e300
    P_F = -s * mu * sigma * P_N
    return P_N, P_F, c_F + G_FN * P_N + G_FF * P_F, D


@kernel
def offset_of(k, problem):
    """The sliding velocity before the step of contact k."""
    return problem.offset[problem.start[k + 1] - 1]


@rare_kernel
def mid_point_speed(k, problem, v, s, sigma):
    """The speed v at which mu(v) leads to that very speed in the middle of the step; starts from a guess."""
    G_NN, _, G_FN, _, c_N, c_F = rows_of(k, problem)
    offset = offset_of(k, problem)
    low, high = 0.0, max(0.0, s * (offset + c_F - G_FN * c_N / G_NN) / 2)
    v = min(v, high)
    for _ in range(SPEED_ITERATIONS):
        excess = v - mid_speed(k, problem, v, s, sigma)
        if abs(excess) <= 4e-16 * (abs(v) + abs(offset)):
            break
        if excess > 0.0:
            high = v
        else:
            low = v
        step = 1e-7 * v + 1e-12 * abs(offset) + 1e-300
        slope = (v + step - mid_speed(k, problem, v + step, s, sigma) - excess) / step
        v_new = v - excess / slope if slope > 0.0 else high
        if abs(v_new - v) <= 4e-16 * v:  # what is left is rounding: a bisection would begin anew far off
            break
        v = v_new if low < v_new < high else 0.5 * (low + high)
        if not high - low > 4e-16 * high:
            break
    return v


@kernel
def mid_speed(k, problem, v, s, sigma):
    """Sliding speed in the middle of the step that the friction coefficient mu(v) would lead to, at least zero."""
    G_NN, G_NF, G_FN, G_FF, c_N, c_F = rows_of(k, problem)
    mu = friction_coefficient(problem.laws, k, v)
    P_N = -c_N / (G_NN - s * mu * sigma * G_NF)
    return max(0.0, s * (offset_of(k, problem) + c_F + (G_FN - s * mu * sigma * G_FF) * P_N) / 2)


@kernel
def stick(G_NN, G_NF, G_FN, G_FF, c_N, c_F):
    """Sticking impulses (P_N, P_F, exists). A mechanism with G of rank one sticks only if c allows it."""
    determinant = G_NN * G_FF - G_NF * G_FN
    if determinant > SINGULAR * G_NN * G_FF:
        return (G_NF * c_F - G_FF * c_N) / determinant, (G_FN * c_N - G_NN * c_F) / determinant, True
    P_N = -c_N / G_NN
    return P_N, 0.0, abs(c_F + G_FN * P_N) <= 1e-12 * (abs(c_F) + abs(G_FN * P_N))


@kernel
def stick_of(k, problem):
    """``stick`` of contact k; where G leaves the impulses open and P_F = 0 would pull, those on the border of the cone
    push, P_N = (-c_N / G_NN) / (1 - mu_s |G_NF| / G_NN), if any do."""
    G_NN, G_NF, G_FN, G_FF, c_N, c_F = rows_of(k, problem)
    P_N, P_F, exists = stick(G_NN, G_NF, G_FN, G_FF, c_N, c_F)
    mu = static_coefficient(problem.laws, k)
    if exists and P_N < 0.0 and P_F == 0.0 and G_NF != 0.0 and problem.kinds[k, 0] == UNILATERAL:
        if G_NN < mu * abs(G_NF) and G_NN * G_FF - G_NF * G_FN <= SINGULAR * G_NN * G_FF:
            P_N *= G_NN / (G_NN - mu * abs(G_NF))
            P_F = -math.copysign(mu * P_N, G_NF)
    return P_N, P_F, exists


@kernel
def candidate_impulses(candidate, k, problem):
    """(P_N, P_F) of one candidate."""
    if candidate == FREE or candidate == NO_CANDIDATE:
        return 0.0, 0.0
    if candidate == STICK:
        P_N, P_F, _ = stick_of(k, problem)
        return P_N, P_F
    P_N, P_F, _, _ = slide(k, problem, slip_of(candidate), sigma_of(candidate))
    return P_N, P_F


@rare_kernel
def admissible(k, problem, is_border):
    """Bits of all admissible candidates, of those within BORDER_WIDTH too if asked, and bits of slides with D > 0."""
    found = 0
    stable = 0
    _, _, G_FN, _, c_N, c_F = rows_of(k, problem)
    kind, is_bilateral = problem.kinds[k, 0], problem.kinds[k, 0] == BILATERAL
    is_smoothed = not can_stick(problem.laws, k)
    before = offset_of(k, problem) if is_smoothed else 0.0
    if not is_bilateral and c_N >= 0.0:
        found |= 1 << FREE
    if not is_smoothed:
        P_N, P_F, exists = stick_of(k, problem)
        reach = abs(P_N) if is_bilateral else P_N
        is_loaded = reach > 0.0 or (reach == 0.0 and kind != UNILATERAL)
        most = static_coefficient(problem.laws, k) * reach
        if exists and is_loaded and abs(P_F) <= (most * (1.0 + BORDER_WIDTH) if is_border else most):
            found |= 1 << STICK
    for candidate in range(SLIDE_PLUS, PULL_MINUS + 1 if is_bilateral else PULL_PLUS):
        s = slip_of(candidate)
        sigma = sigma_of(candidate)
        P_N, P_F, gamma_F, D = slide(k, problem, s, sigma)
        speed = s * (gamma_F + before)  # no sticking: the sign is that of the velocity in the middle of the step
        width = BORDER_WIDTH * (abs(c_F) + abs(before) + abs(G_FN * P_N))
        slides = speed >= -width if is_border else speed > (width if found & 1 << STICK else 0.0)
        if slides and sigma * P_N >= 0.0 and (P_N != 0.0 or is_bilateral):
            twin = 1 << candidate - PULL_PLUS + SLIDE_PLUS if sigma < 0 else 0  # the same slide by a force that pushes
            if found & twin and abs(gamma_F - slide(k, problem, s, 1)[2]) <= width:
                if stable & twin:
                    continue
                found -= twin
            found |= 1 << candidate
            if D > 0.0:
                stable |= 1 << candidate
    return found, stable


@kernel
def rule_for(kind, selection):
    """The rule of a contact: with the normal force given nothing can lift off or strike."""
    return Selection.COMPLIANT_LIMIT.value if kind == GIVEN_FORCE else selection


@kernel
def choose(found, stable, k, problem):
    """The candidate that the rule takes from the admissible ones of contact k; of equals one that slides on."""
    G_NN, G_NF, _, _, _, _ = rows_of(k, problem)
    rule = rule_for(problem.kinds[k, 0], problem.selection)
    was_stuck, slip = problem.mode[k] == ContactMode.STICK, problem.slip[k]
    is_regular = G_NN > friction_coefficient(problem.laws, k, 0.0) * abs(G_NF)
    taken, best = NO_CANDIDATE, WORST_RANK
    for candidate in range(PULL_MINUS + 1):
        bit = 1 << candidate
        if found & bit == 0:
            continue
        value = rank(candidate, stable & bit == 0, was_stuck, is_regular, rule)
        if value > best or (value == best and slip_of(candidate) == slip):
            taken, best = candidate, value
    return taken


@kernel
def solve_single(k, problem):
    """Solve contact k, which has friction, without the others: (candidate taken, P_N, P_F, bits of all admissible)."""
    kind, slip = problem.kinds[k, 0], problem.slip[k]
    if kind != BILATERAL and slip != 0 and can_stick(problem.laws, k):
        # Sliding on with p > 0 excludes every other mode, so the others need not be tried (67 ns -> 15 ns).
        P_N, P_F, gamma_F, p = slide(k, problem, slip, 1)
        if p > 0.0 and P_N > 0.0 and slip * gamma_F > 0.0:
            candidate = SLIDE_PLUS if slip > 0 else SLIDE_MINUS
            return candidate, P_N, P_F, 1 << candidate
    found, stable = admissible(k, problem, False)
    is_border = found == 0
    if is_border:
        found, stable = admissible(k, problem, True)
    candidate = choose(found, stable, k, problem)
    if is_border and candidate != NO_CANDIDATE:
        found = 1 << candidate  # the others on the border are the same motion
    P_N, P_F = candidate_impulses(candidate, k, problem)
    return candidate, P_N, P_F, found


@kernel
def solve_alone(k, problem):
    """Solve contact k, of any kind, without the others; its impulses to P, what it does to problem.candidate.

    Returns (found, error): the bits of all admissible candidates, 0 where there is no solution, and the velocity that
    is left where there should be none.
    """
    kind, a, G, c, P = problem.kinds[k, 0], problem.start[k], problem.G, problem.c, problem.P
    if kind == GIVEN_FORCE:
        problem.candidate[k] = solve_given_force(k, problem)
        return 1 << problem.candidate[k], 0.0
    if problem.kinds[k, 1] == 0:
        P[a] = -c[a] / G[a, a] if kind == BILATERAL or c[a] < 0.0 else 0.0
        problem.candidate[k] = FREE if kind != BILATERAL and c[a] > 0.0 else STICK
        return 1 << problem.candidate[k], 0.0
    t = a + 1
    candidate, P_N, P_F, found = solve_single(k, problem)
    P[a], P[t], problem.candidate[k] = P_N, P_F, candidate
    if candidate == NO_CANDIDATE:
        return 0, 0.0
    if candidate == FREE:
        if not c[a] > STILL_VELOCITY * (c[a] + abs(c[t])):
            problem.candidate[k] = closed_mode(c[a], c[t])
        return found, 0.0
    error = abs(c[a] + G[a, a] * P_N + G[a, t] * P_F)
    gamma_F = abs(c[t] + G[t, a] * P_N + G[t, t] * P_F)
    if candidate == STICK:
        error = max(error, gamma_F)
    elif gamma_F <= STILL_VELOCITY * (abs(c[a]) + abs(c[t])):
        problem.candidate[k] = STICK  # its impulse lies on the border of the cone, but it does not move
    return found, error


@kernel
def solve_given_force(k, problem):
    """Friction under a given normal impulse P_N >= 0, to P: the candidate. There is always one solution."""
    t = problem.start[k]
    candidate, _, P_F, _ = solve_single(k, problem)
    problem.P[t] = P_F
    if candidate == NO_CANDIDATE:  # P_N = 0: no friction
        candidate = SLIDE_PLUS if problem.c[t] > 0.0 else SLIDE_MINUS
    if candidate >= SLIDE_PLUS and abs(problem.c[t] + problem.G[t, t] * P_F) <= STILL_VELOCITY * abs(problem.c[t]):
        return STICK
    return candidate


@rare_kernel
def closed_mode(c_N, c_F):
    """The candidate of a contact without impulse that does not part."""
    if abs(c_F) <= STILL_VELOCITY * (abs(c_N) + abs(c_F)):
        return STICK
    return SLIDE_PLUS if c_F > 0.0 else SLIDE_MINUS


@kernel
def count(found):
    """Number of admissible candidates."""
    if found & (found - 1) == 0:
        return 1 if found else 0
    total = 0
    for candidate in range(PULL_MINUS + 1):
        total += (found >> candidate) & 1
    return total
