"""One planar contact, solved in closed form by its modes.

    gamma_N = c_N + G_NN P_N + G_NF P_F,    gamma_F = c_F + G_FN P_N + G_FF P_F

FREE            P = 0                                                admissible if gamma_N >= 0 (unilateral only)
STICK           gamma_N = gamma_F = 0                                |P_F| <= mu_s |P_N|
SLIDE s, sigma  P_F = -s mu sigma P_N, P_N = -c_N / D,               sigma P_N >= 0, s gamma_F > 0
                D = G_NN - s mu sigma G_NF

s is the sign of sliding, sigma that of P_N (+1 for a unilateral contact, where D is called p_s). At most three
modes are admissible. If p_+ and p_- are positive there is one, else {free, slide p < 0, stick} may coexist, and for a
bilateral contact {slide D > 0, stick, slide D < 0}; which one is taken is the selection rule. Impulses and velocities
may as well be forces and accelerations. Source: Génot, Brogliato, *Eur. J. Mech. A* 18 (1999) 653.
"""

from __future__ import annotations

from enum import IntEnum

from nonsmooth.jit import kernel, rare_kernel
from nonsmooth.mechanics.laws import LAW_CODE, SMOOTHED, depends_on_speed, friction_coefficient, static_coefficient
from nonsmooth.mechanics.system import BILATERAL, GIVEN_FORCE
from nonsmooth.numerics.dense import SINGULAR

# Candidates, and the bits of the set of admissible ones.
FREE, STICK, SLIDE_PLUS, SLIDE_MINUS, PULL_PLUS, PULL_MINUS = range(6)  # PULL: sliding with P_N < 0
NO_CANDIDATE = -1
BOUNDARY = 1e-12  # relative width within which a candidate on the border of admissibility is kept, if no other is
STILL = 1e-12  # of max |c|: a velocity below is none
SPEED_ITERATIONS = 60


class Selection(IntEnum):
    """Which solution is taken when a contact problem has several.

    COMPLIANT_LIMIT: a contact that stuck sticks; otherwise it lifts off, or slides where D > 0. This is what the limit
    of a stiff contact does. LIFT_OFF: free if admissible. IMPACT: stick if admissible.
    """

    COMPLIANT_LIMIT = 0
    LIFT_OFF = 1
    IMPACT = 2


@kernel
def slip_of(candidate):
    """Sign of sliding of a candidate."""
    if candidate == SLIDE_PLUS or candidate == PULL_PLUS:
        return 1
    if candidate == SLIDE_MINUS or candidate == PULL_MINUS:
        return -1
    return 0


@kernel
def sigma_of(candidate):
    """Sign of P_N of a sliding candidate."""
    return -1 if candidate >= PULL_PLUS else 1


@kernel
def slide(laws, i, G_NN, G_NF, G_FN, G_FF, c_N, c_F, offset, s, sigma):
    """Sliding impulses (P_N, P_F, gamma_F, D) for given signs.

    A law mu(v) is taken at v = s (offset + gamma_F) / 2, the speed in the middle of the step; ``offset`` is the sliding
    velocity before it, gamma_F that after it. The scalar equation for v is solved by Newton steps inside a bracket.
    """
    v = max(0.0, s * offset)
    if depends_on_speed(laws, i):
        v = mid_point_speed(laws, i, v, G_NN, G_NF, G_FN, G_FF, c_N, c_F, offset, s, sigma)
    mu = friction_coefficient(laws, i, v)
    D = G_NN - s * mu * sigma * G_NF
    P_N = -c_N / D if D != 0.0 else -sigma * 1e300
    P_F = -s * mu * sigma * P_N
    return P_N, P_F, c_F + G_FN * P_N + G_FF * P_F, D


@rare_kernel
def mid_point_speed(laws, i, v, G_NN, G_NF, G_FN, G_FF, c_N, c_F, offset, s, sigma):
    """The speed v at which mu(v) leads to that very speed in the middle of the step; starts from a guess."""
    low, high = 0.0, max(0.0, s * (offset + c_F - G_FN * c_N / G_NN) / 2)
    v = min(v, high)
    for _ in range(SPEED_ITERATIONS):
        mu = friction_coefficient(laws, i, v)
        excess = v - mid_speed(G_NN, G_NF, G_FN, G_FF, c_N, c_F, offset, s, sigma, mu)
        if abs(excess) <= 4e-16 * (abs(v) + abs(offset)):
            break
        if excess > 0.0:
            high = v
        else:
            low = v
        step = 1e-7 * v + 1e-12 * abs(offset) + 1e-300
        mu = friction_coefficient(laws, i, v + step)
        ahead = mid_speed(G_NN, G_NF, G_FN, G_FF, c_N, c_F, offset, s, sigma, mu)
        slope = (v + step - ahead - excess) / step
        v_new = v - excess / slope if slope > 0.0 else high
        v = v_new if low < v_new < high else 0.5 * (low + high)
        if not high - low > 4e-16 * high:
            break
    return v


@kernel
def mid_speed(G_NN, G_NF, G_FN, G_FF, c_N, c_F, offset, s, sigma, mu):
    """Sliding speed in the middle of the step that a friction coefficient would lead to, at least zero."""
    P_N = -c_N / (G_NN - s * mu * sigma * G_NF)
    return max(0.0, s * (offset + c_F + (G_FN - s * mu * sigma * G_FF) * P_N) / 2)


@kernel
def stick(G_NN, G_NF, G_FN, G_FF, c_N, c_F):
    """Sticking impulses (P_N, P_F, exists). A mechanism with G of rank one sticks only if c allows it."""
    determinant = G_NN * G_FF - G_NF * G_FN
    if determinant > SINGULAR * G_NN * G_FF:
        return (G_NF * c_F - G_FF * c_N) / determinant, (G_FN * c_N - G_NN * c_F) / determinant, True
    P_N = -c_N / G_NN
    return P_N, 0.0, abs(c_F + G_FN * P_N) <= 1e-12 * (abs(c_F) + abs(G_FN * P_N))


@kernel
def candidate_impulses(candidate, laws, i, G_NN, G_NF, G_FN, G_FF, c_N, c_F, offset):
    """(P_N, P_F) of one candidate."""
    if candidate == FREE:
        return 0.0, 0.0
    if candidate == STICK:
        P_N, P_F, _ = stick(G_NN, G_NF, G_FN, G_FF, c_N, c_F)
        return P_N, P_F
    P_N, P_F, _, _ = slide(laws, i, G_NN, G_NF, G_FN, G_FF, c_N, c_F, offset, slip_of(candidate), sigma_of(candidate))
    return P_N, P_F


@rare_kernel
def admissible(kind, laws, i, G_NN, G_NF, G_FN, G_FF, c_N, c_F, offset, tolerance):
    """Bits of all admissible candidates, and bits of the sliding ones with D > 0."""
    found = 0
    stable = 0
    is_bilateral = kind == BILATERAL
    if not is_bilateral and c_N >= 0.0:
        found |= 1 << FREE
    if laws[i, LAW_CODE] != SMOOTHED:
        P_N, P_F, exists = stick(G_NN, G_NF, G_FN, G_FF, c_N, c_F)
        reach = abs(P_N) if is_bilateral else P_N
        if exists and reach >= 0.0 and abs(P_F) <= static_coefficient(laws, i) * reach * (1.0 + tolerance):
            found |= 1 << STICK
    for candidate in range(SLIDE_PLUS, PULL_MINUS + 1 if is_bilateral else PULL_PLUS):
        s = slip_of(candidate)
        sigma = sigma_of(candidate)
        P_N, P_F, gamma_F, D = slide(laws, i, G_NN, G_NF, G_FN, G_FF, c_N, c_F, offset, s, sigma)
        if laws[i, LAW_CODE] == SMOOTHED:
            gamma_F += offset  # no sticking: the sign is that of the velocity in the middle of the step
        if sigma * P_N >= 0.0 and s * gamma_F > -tolerance * (abs(c_F) + abs(G_FN * P_N)) and P_N != 0.0:
            found |= 1 << candidate
            if D > 0.0:
                stable |= 1 << candidate
    return found, stable


@kernel
def choose(found, stable, was_stuck, previous_slip, selection):
    """The candidate taken from the set of admissible ones: the rule of docs/theory/selection.md."""
    if found & (1 << STICK) and was_stuck and selection != Selection.LIFT_OFF:
        return STICK
    if found & (1 << STICK) and selection == Selection.IMPACT:
        return STICK
    if found & (1 << FREE):
        return FREE
    for candidate in range(SLIDE_PLUS, PULL_MINUS + 1):  # static > kinetic friction: sliding goes on
        if stable & (1 << candidate) and slip_of(candidate) == previous_slip:
            return candidate
    if found & (1 << STICK) and was_stuck:
        return STICK
    for candidate in range(SLIDE_PLUS, PULL_MINUS + 1):
        if stable & (1 << candidate):
            return candidate
    if found & (1 << STICK):
        return STICK
    for candidate in range(SLIDE_PLUS, PULL_MINUS + 1):
        if found & (1 << candidate):
            return candidate
    return NO_CANDIDATE


@kernel
def solve_single(kind, laws, i, G_NN, G_NF, G_FN, G_FF, c_N, c_F, offset, was_stuck, previous_slip, selection):
    """Solve one planar frictional contact.

    Returns (candidate, P_N, P_F, found): the candidate taken, its impulses, and the bits of all admissible ones.
    """
    if kind != BILATERAL and previous_slip != 0 and laws[i, LAW_CODE] != SMOOTHED:
        # Sliding on with p > 0 excludes every other mode, so the others need not be tried (67 ns -> 15 ns).
        P_N, P_F, gamma_F, p = slide(laws, i, G_NN, G_NF, G_FN, G_FF, c_N, c_F, offset, previous_slip, 1)
        if p > 0.0 and P_N > 0.0 and previous_slip * gamma_F > 0.0:
            candidate = SLIDE_PLUS if previous_slip > 0 else SLIDE_MINUS
            return candidate, P_N, P_F, 1 << candidate
    found, stable = admissible(kind, laws, i, G_NN, G_NF, G_FN, G_FF, c_N, c_F, offset, 0.0)
    if found == 0:
        found, stable = admissible(kind, laws, i, G_NN, G_NF, G_FN, G_FF, c_N, c_F, offset, BOUNDARY)
    candidate = choose(found, stable, was_stuck, previous_slip, selection)
    if candidate == NO_CANDIDATE:
        return candidate, 0.0, 0.0, found
    P_N, P_F = candidate_impulses(candidate, laws, i, G_NN, G_NF, G_FN, G_FF, c_N, c_F, offset)
    return candidate, P_N, P_F, found


@kernel
def solve_given_force(laws, i, G_FF, c_F, offset, P_N, was_stuck, previous_slip):
    """Friction under a given normal impulse P_N >= 0: (candidate, P_F). There is always one solution.

    With G_NF = 0 and G_NN = 1, c_N = -P_N the contact of this module is one whose normal impulse is P_N.
    """
    candidate, _, P_F, _ = solve_single(
        GIVEN_FORCE,
        laws,
        i,
        1.0,
        0.0,
        0.0,
        G_FF,
        -P_N,
        c_F,
        offset,
        was_stuck,
        previous_slip,
        Selection.COMPLIANT_LIMIT.value,
    )
    if candidate == NO_CANDIDATE:  # P_N = 0: no friction
        return SLIDE_PLUS if c_F > 0.0 else SLIDE_MINUS, 0.0
    return candidate, P_F


@kernel
def solve_alone(kind, d, laws, i, G, c, offset, normal_impulse, was_stuck, previous_slip, selection, P):
    """The contact problem of one contact of any kind, impulses to P.

    Returns (candidate, found, error): the candidate that names what the contact does, NO_CANDIDATE where there is no
    solution; the bits of all admissible ones; and the velocity that is left where there should be none.
    """
    if kind == GIVEN_FORCE:
        candidate, P[0] = solve_given_force(laws, i, G[0, 0], c[0], offset[0], normal_impulse, was_stuck, previous_slip)
        if candidate >= SLIDE_PLUS and abs(c[0] + G[0, 0] * P[0]) <= STILL * abs(c[0]):
            candidate = STICK
        return candidate, 1 << candidate, 0.0
    if d == 0:
        P[0] = -c[0] / G[0, 0] if kind == BILATERAL or c[0] < 0.0 else 0.0
        candidate = FREE if kind != BILATERAL and c[0] > 0.0 else STICK
        return candidate, 1 << candidate, 0.0
    candidate, P[0], P[1], found = solve_single(
        kind, laws, i, G[0, 0], G[0, 1], G[1, 0], G[1, 1], c[0], c[1], offset[1], was_stuck, previous_slip, selection
    )
    if candidate == NO_CANDIDATE:
        return candidate, 0, 0.0
    if candidate == FREE:
        return (candidate if c[0] > STILL * (c[0] + abs(c[1])) else closed_mode(c)), found, 0.0
    error = abs(c[0] + G[0, 0] * P[0] + G[0, 1] * P[1])
    gamma_F = abs(c[1] + G[1, 0] * P[0] + G[1, 1] * P[1])
    if candidate == STICK:
        error = max(error, gamma_F)
    elif gamma_F <= STILL * (abs(c[0]) + abs(c[1])):
        candidate = STICK  # its impulse lies on the border of the cone, but it does not move
    return candidate, found, error


@rare_kernel
def closed_mode(c):
    """The candidate of a contact without impulse that does not part."""
    if abs(c[1]) <= STILL * (abs(c[0]) + abs(c[1])):
        return STICK
    return SLIDE_PLUS if c[1] > 0.0 else SLIDE_MINUS


@kernel
def count(found):
    """Number of admissible candidates."""
    if found & (found - 1) == 0:
        return 1 if found else 0
    total = 0
    for candidate in range(PULL_MINUS + 1):
        total += (found >> candidate) & 1
    return total
