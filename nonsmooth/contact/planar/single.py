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
from nonsmooth.jit.blocks import Block
from nonsmooth.mechanics.laws import LAW_CODE, SMOOTHED, depends_on_speed, friction_coefficient, static_coefficient
from nonsmooth.mechanics.system import BILATERAL, GIVEN_FORCE, ContactMode
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


class Contact(Block):
    """One contact, all numbers: its kind, its rows, what was before, and the impulses of the answer.

    A contact under a given normal impulse P_N has G_NN = 1, G_NF = G_FN = 0 and c_N = -P_N.
    """

    kind: int
    d: int  # directions of friction: 0 or 1
    law: int  # its row in the table of laws
    was_stuck: int  # 0 or 1
    slip: int  # sign of sliding before
    selection: int  # the rule where there are several solutions
    G_NN: float
    G_NF: float
    G_FN: float
    G_FF: float
    c_N: float
    c_F: float
    offset: float  # sliding velocity before the step, (1 - e_F) gamma_F, of which a law mu(v) takes the mean
    P_N: float
    P_F: float


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
def take_contact(k, problem, contact):
    """Contact k of a problem without the others."""
    contact.kind, contact.d, contact.law = problem.kinds[k, 0], problem.kinds[k, 1], k
    contact.was_stuck = 1 if problem.mode[k] == ContactMode.STICK else 0
    contact.slip, contact.selection = problem.slip[k], problem.selection
    take_rows(k, problem, contact)


@kernel
def take_rows(k, problem, contact):
    """The rows of contact k of a problem, of which the kind is known."""
    a, t, G, c = problem.start[k], problem.start[k + 1] - 1, problem.G, problem.c
    if contact.kind == GIVEN_FORCE:
        contact.G_NN, contact.G_NF, contact.G_FN, contact.c_N = 1.0, 0.0, 0.0, -problem.normal_impulse[k]
        contact.selection = Selection.COMPLIANT_LIMIT.value
    else:
        contact.G_NN, contact.G_NF, contact.G_FN, contact.c_N = G[a, a], G[a, t], G[t, a], c[a]
    contact.G_FF, contact.c_F, contact.offset = G[t, t], c[t], problem.offset[t]


@kernel
def give_impulses(a, contact, P):
    """The impulses of a contact to its rows, the first of which is a."""
    if contact.kind == GIVEN_FORCE:
        P[a] = contact.P_F
        return
    P[a] = contact.P_N
    if contact.d > 0:
        P[a + 1] = contact.P_F


@kernel
def slide(contact, laws, s, sigma):
    """Sliding impulses (P_N, P_F, gamma_F, D) for given signs.

    A law mu(v) is taken at v = s (offset + gamma_F) / 2, the speed in the middle of the step; ``offset`` is the sliding
    velocity before it, gamma_F that after it. The scalar equation for v is solved by Newton steps inside a bracket.
    """
    v = max(0.0, s * contact.offset)
    if depends_on_speed(laws, contact.law):
        v = mid_point_speed(contact, laws, v, s, sigma)
    mu = friction_coefficient(laws, contact.law, v)
    D = contact.G_NN - s * mu * sigma * contact.G_NF
    P_N = -contact.c_N / D if D != 0.0 else -sigma * 1e300
    P_F = -s * mu * sigma * P_N
    return P_N, P_F, contact.c_F + contact.G_FN * P_N + contact.G_FF * P_F, D


@rare_kernel
def mid_point_speed(contact, laws, v, s, sigma):
    """The speed v at which mu(v) leads to that very speed in the middle of the step; starts from a guess."""
    offset = contact.offset
    high = max(0.0, s * (offset + contact.c_F - contact.G_FN * contact.c_N / contact.G_NN) / 2)
    low, v = 0.0, min(v, high)
    for _ in range(SPEED_ITERATIONS):
        excess = v - mid_speed(contact, s, sigma, friction_coefficient(laws, contact.law, v))
        if abs(excess) <= 4e-16 * (abs(v) + abs(offset)):
            break
        if excess > 0.0:
            high = v
        else:
            low = v
        step = 1e-7 * v + 1e-12 * abs(offset) + 1e-300
        ahead = mid_speed(contact, s, sigma, friction_coefficient(laws, contact.law, v + step))
        slope = (v + step - ahead - excess) / step
        v_new = v - excess / slope if slope > 0.0 else high
        v = v_new if low < v_new < high else 0.5 * (low + high)
        if not high - low > 4e-16 * high:
            break
    return v


@kernel
def mid_speed(contact, s, sigma, mu):
    """Sliding speed in the middle of the step that a friction coefficient would lead to, at least zero."""
    P_N = -contact.c_N / (contact.G_NN - s * mu * sigma * contact.G_NF)
    return max(0.0, s * (contact.offset + contact.c_F + (contact.G_FN - s * mu * sigma * contact.G_FF) * P_N) / 2)


@kernel
def stick(G_NN, G_NF, G_FN, G_FF, c_N, c_F):
    """Sticking impulses (P_N, P_F, exists). A mechanism with G of rank one sticks only if c allows it."""
    determinant = G_NN * G_FF - G_NF * G_FN
    if determinant > SINGULAR * G_NN * G_FF:
        return (G_NF * c_F - G_FF * c_N) / determinant, (G_FN * c_N - G_NN * c_F) / determinant, True
    P_N = -c_N / G_NN
    return P_N, 0.0, abs(c_F + G_FN * P_N) <= 1e-12 * (abs(c_F) + abs(G_FN * P_N))


@kernel
def stick_contact(contact):
    """``stick`` of a contact."""
    return stick(contact.G_NN, contact.G_NF, contact.G_FN, contact.G_FF, contact.c_N, contact.c_F)


@kernel
def candidate_impulses(candidate, contact, laws):
    """(P_N, P_F) of one candidate."""
    if candidate == FREE:
        return 0.0, 0.0
    if candidate == STICK:
        P_N, P_F, _ = stick_contact(contact)
        return P_N, P_F
    P_N, P_F, _, _ = slide(contact, laws, slip_of(candidate), sigma_of(candidate))
    return P_N, P_F


@rare_kernel
def admissible(contact, laws, tolerance):
    """Bits of all admissible candidates, and bits of the sliding ones with D > 0."""
    found = 0
    stable = 0
    is_bilateral = contact.kind == BILATERAL
    is_smoothed = laws[contact.law, LAW_CODE] == SMOOTHED
    if not is_bilateral and contact.c_N >= 0.0:
        found |= 1 << FREE
    if not is_smoothed:
        P_N, P_F, exists = stick_contact(contact)
        reach = abs(P_N) if is_bilateral else P_N
        if exists and reach >= 0.0 and abs(P_F) <= static_coefficient(laws, contact.law) * reach * (1.0 + tolerance):
            found |= 1 << STICK
    for candidate in range(SLIDE_PLUS, PULL_MINUS + 1 if is_bilateral else PULL_PLUS):
        s = slip_of(candidate)
        sigma = sigma_of(candidate)
        P_N, P_F, gamma_F, D = slide(contact, laws, s, sigma)
        if is_smoothed:
            gamma_F += contact.offset  # no sticking: the sign is that of the velocity in the middle of the step
        slack = tolerance * (abs(contact.c_F) + abs(contact.G_FN * P_N))
        if sigma * P_N >= 0.0 and s * gamma_F > -slack and P_N != 0.0:
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
def solve_single(contact, laws):
    """Solve a contact with friction, impulses to ``contact``: (candidate taken, bits of all admissible ones)."""
    slip = contact.slip
    if contact.kind != BILATERAL and slip != 0 and laws[contact.law, LAW_CODE] != SMOOTHED:
        # Sliding on with p > 0 excludes every other mode, so the others need not be tried (67 ns -> 15 ns).
        P_N, P_F, gamma_F, p = slide(contact, laws, slip, 1)
        if p > 0.0 and P_N > 0.0 and slip * gamma_F > 0.0:
            candidate = SLIDE_PLUS if slip > 0 else SLIDE_MINUS
            contact.P_N, contact.P_F = P_N, P_F
            return candidate, 1 << candidate
    found, stable = admissible(contact, laws, 0.0)
    if found == 0:
        found, stable = admissible(contact, laws, BOUNDARY)
    candidate = choose(found, stable, contact.was_stuck == 1, slip, contact.selection)
    contact.P_N, contact.P_F = 0.0, 0.0
    if candidate != NO_CANDIDATE:
        contact.P_N, contact.P_F = candidate_impulses(candidate, contact, laws)
    return candidate, found


@kernel
def solve_given_force(contact, laws):
    """Friction under a given normal impulse P_N >= 0: the candidate. There is always one solution."""
    candidate, _ = solve_single(contact, laws)
    if candidate == NO_CANDIDATE:  # P_N = 0: no friction
        candidate = SLIDE_PLUS if contact.c_F > 0.0 else SLIDE_MINUS
    if candidate >= SLIDE_PLUS and abs(contact.c_F + contact.G_FF * contact.P_F) <= STILL * abs(contact.c_F):
        return STICK
    return candidate


@kernel
def solve_alone(contact, laws):
    """The contact problem of one contact of any kind, impulses to ``contact``.

    Returns (candidate, found, error): the candidate that names what the contact does, NO_CANDIDATE where there is no
    solution; the bits of all admissible ones; and the velocity that is left where there should be none.
    """
    c_N, c_F = contact.c_N, contact.c_F
    if contact.kind == GIVEN_FORCE:
        candidate = solve_given_force(contact, laws)
        return candidate, 1 << candidate, 0.0
    if contact.d == 0:
        contact.P_N = -c_N / contact.G_NN if contact.kind == BILATERAL or c_N < 0.0 else 0.0
        candidate = FREE if contact.kind != BILATERAL and c_N > 0.0 else STICK
        return candidate, 1 << candidate, 0.0
    candidate, found = solve_single(contact, laws)
    if candidate == NO_CANDIDATE:
        return candidate, 0, 0.0
    if candidate == FREE:
        return (candidate if c_N > STILL * (c_N + abs(c_F)) else closed_mode(c_N, c_F)), found, 0.0
    error = abs(c_N + contact.G_NN * contact.P_N + contact.G_NF * contact.P_F)
    gamma_F = abs(c_F + contact.G_FN * contact.P_N + contact.G_FF * contact.P_F)
    if candidate == STICK:
        error = max(error, gamma_F)
    elif gamma_F <= STILL * (abs(c_N) + abs(c_F)):
        candidate = STICK  # its impulse lies on the border of the cone, but it does not move
    return candidate, found, error


@rare_kernel
def closed_mode(c_N, c_F):
    """The candidate of a contact without impulse that does not part."""
    if abs(c_F) <= STILL * (abs(c_N) + abs(c_F)):
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
