"""One impact with friction in two directions: normal impulse and hodograph of the sliding velocity (Keller, Routh).

    d gamma/dP = G (n - mu d),    d = gamma_T/v,    v = |gamma_T|,    P the normal impulse

d turns on the way, so that P is not a good variable where v vanishes. With dP = v dtau the velocities are those of

    gamma_T' = v G_TN - mu G_TT gamma_T,    gamma_N' = v G_NN - mu G_NT gamma_T,    P' = v,    work' = v gamma_N

which is homogeneous of degree one: v = 0 is reached as tau -> inf at a finite P, and each step of tau is a power series
with v^2 = gamma_T . gamma_T. There the contact sticks if the cone holds |G_TT^-1 G_TN| <= mu, else it slides away along
the d with d x (G_TN - mu G_TT d) = 0 that v grows along; gamma_N is linear in P from then on. Compression ends at P_c,
where gamma_N = 0 on the way up, and the law of impact says how far expansion goes (mechanics/impact.py). In the plane
all this is the line with one bend that is there.
Source: Keller, *J. Appl. Mech.* 53 (1986) 1; Stronge, *Impact Mechanics* (2000), chapter 5; the series is ours.
Equations: docs/theory/painleve_in_space.md, (16) to (18).
"""

from __future__ import annotations

import math
from typing import Annotated as Array

from nonsmooth.jit import kernel
from nonsmooth.jit.blocks import Block, Floats, Ints, view
from nonsmooth.mechanics.laws import ImpactLaw
from nonsmooth.numerics.dense import SINGULAR

IMPACT_TERMS = 24  # chosen: of a series
LAST_IMPACT_TERM = 1e-17  # chosen: of v: what the last term of a step may be
STOPPED_SLIDE = 1e-17  # chosen: of the velocity before: the rest of P is as small
MOST_IMPACT_STEPS = 1000  # chosen: of tau; a slide that stops has some 50
PATH_POINTS = 8  # chosen: points of the path in a step
IMPACT_HALVINGS = 60  # derived: of a step, to its last bit
DIRECTIONS_TRIED = 360  # chosen: in which a slide away is looked for
N, X, Y, V, P, WORK = range(6)  # code: rows of a series


class Hodograph(Block, most=MOST_IMPACT_STEPS):
    """An impact: what goes in, and what comes out."""

    mu: float
    e: float
    law: int
    sticks: int  # whether the impact ends in sticking
    G: Array[Floats, 3, 3]  # rows N, T1, T2
    before: Array[Floats, 3]  # velocities
    gamma: Array[Floats, 3]  # and after it
    impulse: Array[Floats, 3]
    P_c: float  # normal impulse of compression; inf where it never ends
    work: float  # of the normal impulse so far
    work_c: float  # of compression
    n: int  # points of the path
    path: Array[Floats, "most", 4]  # P and gamma, after each step
    series: Array[Floats, 6, IMPACT_TERMS + 1]
    slides: Array[Ints, "most"]  # whether the contact still slides at each point


@kernel("boolean(int64)", short_loops=True)
def collide_in_space(hodograph_at):
    """`collide` of a block of its own."""
    return collide(view(hodograph_at, Hodograph))


@kernel
def collide(h):
    """Fill the block; False where the impact has no end."""
    h.n, h.sticks, h.work, h.work_c, h.P_c = 0, 0, 0.0, 0.0, math.inf
    for a in range(3):
        h.gamma[a], h.impulse[a] = h.before[a], 0.0
    record(1, h)
    still = STOPPED_SLIDE * speed(h)
    steps = 0
    while speed(h) > still:
        steps += 1
        if steps > MOST_IMPACT_STEPS:
            return False
        expand(h)
        step = length_of_step(h)
        if not step > 0.0:
            return False
        if h.P_c == math.inf:
            if value(N, step, h) >= 0.0:  # it was negative before, or has just left zero
                step = first_time(step, h)
                advance(step, h)
                h.gamma[0], h.P_c, h.work_c = 0.0, h.impulse[0], h.work
                if is_over(h.gamma[0], h.impulse[0], h.work, h):
                    return True
                continue
        elif is_over(value(N, step, h), value(P, step, h), value(WORK, step, h), h):
            advance(first_time(step, h), h)
            return True
        advance(step, h)
    return go_on_straight(h)


@kernel
def speed(h):
    """|gamma_T|."""
    return math.sqrt(h.gamma[1] * h.gamma[1] + h.gamma[2] * h.gamma[2])


@kernel
def is_over(gamma_N, impulse, work, h):
    """Whether expansion has gone as far as the law says."""
    if h.law == ImpactLaw.POISSON:
        return impulse >= (1.0 + h.e) * h.P_c
    if h.law == ImpactLaw.ENERGETIC:
        return work >= (1.0 - h.e * h.e) * h.work_c
    return gamma_N >= -h.e * h.before[0]


@kernel
def expand(h):
    """The series of all in tau, from the present velocities."""
    s, G, mu = h.series, h.G, h.mu
    s[N, 0], s[X, 0], s[Y, 0] = h.gamma[0], h.gamma[1], h.gamma[2]
    s[V, 0], s[P, 0], s[WORK, 0] = speed(h), h.impulse[0], h.work
    for n in range(IMPACT_TERMS):
        x, y, v = s[X, n], s[Y, n], s[V, n]
        s[N, n + 1] = (G[0, 0] * v - mu * (G[0, 1] * x + G[0, 2] * y)) / (n + 1)
        s[X, n + 1] = (G[1, 0] * v - mu * (G[1, 1] * x + G[1, 2] * y)) / (n + 1)
        s[Y, n + 1] = (G[2, 0] * v - mu * (G[2, 1] * x + G[2, 2] * y)) / (n + 1)
        s[P, n + 1] = v / (n + 1)
        square, work = 0.0, 0.0
        for k in range(n + 2):
            square += s[X, k] * s[X, n + 1 - k] + s[Y, k] * s[Y, n + 1 - k]
            if 0 < k < n + 1:
                square -= s[V, k] * s[V, n + 1 - k]
            if k <= n:
                work += s[V, k] * s[N, n - k]
        s[V, n + 1], s[WORK, n + 1] = 0.5 * square / s[V, 0], work / (n + 1)


@kernel
def length_of_step(h):
    """tau over which the last terms of velocity stay rounding."""
    s, step = h.series, math.inf
    for n in range(IMPACT_TERMS - 1, IMPACT_TERMS + 1):
        largest = max(abs(s[X, n]), abs(s[Y, n]), abs(s[V, n])) / s[V, 0]
        if largest > 0.0:
            step = min(step, (LAST_IMPACT_TERM / largest) ** (1.0 / n))
    return step if step < math.inf else 0.0


@kernel
def value(row, tau, h):
    """A series at tau."""
    total = h.series[row, IMPACT_TERMS]
    for n in range(IMPACT_TERMS - 1, -1, -1):
        total = total * tau + h.series[row, n]
    return total


@kernel
def first_time(step, h):
    """When in a step compression, or the impact, ends."""
    low, high, compresses = 0.0, step, h.P_c == math.inf
    for _ in range(IMPACT_HALVINGS):
        tau = 0.5 * (low + high)
        gamma_N = value(N, tau, h)
        ends = gamma_N >= 0.0 if compresses else is_over(gamma_N, value(P, tau, h), value(WORK, tau, h), h)
        if ends:
            high = tau
        else:
            low = tau
    return high


@kernel
def advance(tau, h):
    """Velocities, impulses and work after tau."""
    for look in range(1, PATH_POINTS + 1):
        for a in range(3):
            h.gamma[a] = value(a, tau * look / PATH_POINTS, h)
        h.impulse[0] = value(P, tau * look / PATH_POINTS, h)
        record(1, h)
    h.work = value(WORK, tau, h)
    x, y = 0.0, 0.0
    for n in range(IMPACT_TERMS, 0, -1):  # dP_T = -mu gamma_T dtau
        x, y = (x + h.series[X, n - 1] / n) * tau, (y + h.series[Y, n - 1] / n) * tau
    h.impulse[1] -= h.mu * x
    h.impulse[2] -= h.mu * y


@kernel
def record(slides, h):
    """A point of the path, where it has room."""
    if h.n == h.path.shape[0]:
        return
    h.path[h.n, 0], h.slides[h.n] = h.impulse[0], slides
    for a in range(3):
        h.path[h.n, 1 + a] = h.gamma[a]
    h.n += 1


@kernel
def go_on_straight(h):
    """From v = 0 to the end of the impact; False where there is none."""
    G = h.G
    h.gamma[1] = h.gamma[2] = 0.0
    det = G[1, 1] * G[2, 2] - G[1, 2] * G[2, 1]
    q_1, q_2 = -(G[2, 2] * G[1, 0] - G[1, 2] * G[2, 0]) / det, -(G[1, 1] * G[2, 0] - G[2, 1] * G[1, 0]) / det
    h.sticks = 1 if math.sqrt(q_1 * q_1 + q_2 * q_2) <= h.mu else 0
    if h.sticks == 0:
        q_1, q_2 = slide_away(h)
    rise = G[0, 0] + G[0, 1] * q_1 + G[0, 2] * q_2
    if h.P_c == math.inf:
        if not rise > 0.0:
            return False
        forward(-h.gamma[0] / rise, rise, q_1, q_2, h)
        h.gamma[0], h.P_c, h.work_c = 0.0, h.impulse[0], h.work
    forward(left_to_go(rise, h), rise, q_1, q_2, h)
    return h.impulse[0] < math.inf


@kernel
def left_to_go(rise, h):
    """Normal impulse from here to the end of expansion."""
    if h.law == ImpactLaw.POISSON:
        return (1.0 + h.e) * h.P_c - h.impulse[0]
    if h.law == ImpactLaw.ENERGETIC:  # work + gamma_N dP + rise dP^2/2
        lacking = max(0.0, (1.0 - h.e * h.e) * h.work_c - h.work)
        root = math.sqrt(h.gamma[0] * h.gamma[0] + 2.0 * rise * lacking)
        return 2.0 * lacking / (h.gamma[0] + root) if lacking > 0.0 else 0.0
    return max(0.0, -h.e * h.before[0] - h.gamma[0]) / rise


@kernel
def forward(dP, rise, q_1, q_2, h):
    """A normal impulse dP with friction in a constant ratio."""
    G = h.G
    h.work += (h.gamma[0] + 0.5 * rise * dP) * dP
    h.gamma[0] += rise * dP
    if h.sticks == 0:
        h.gamma[1] += (G[1, 0] + G[1, 1] * q_1 + G[1, 2] * q_2) * dP
        h.gamma[2] += (G[2, 0] + G[2, 1] * q_1 + G[2, 2] * q_2) * dP
    h.impulse[0] += dP
    h.impulse[1] += q_1 * dP
    h.impulse[2] += q_2 * dP
    record(0, h)


@kernel
def turning(angle, h):
    """(d x k, d . k) of a direction, k = G_TN - mu G_TT d: how it turns, and how the speed grows."""
    G, d_1, d_2 = h.G, math.cos(angle), math.sin(angle)
    k_1 = G[1, 0] - h.mu * (G[1, 1] * d_1 + G[1, 2] * d_2)
    k_2 = G[2, 0] - h.mu * (G[2, 1] * d_1 + G[2, 2] * d_2)
    return d_1 * k_2 - d_2 * k_1, d_1 * k_1 + d_2 * k_2


@kernel
def p_before(h):
    """(p, dp/dP) of the slide before the impact: where dp/dP < 0 its force turns it into the paradox."""
    G, v = h.G, math.sqrt(h.before[1] * h.before[1] + h.before[2] * h.before[2])
    d_1, d_2 = h.before[1] / v, h.before[2] / v
    across = G[0, 2] * d_1 - G[0, 1] * d_2
    slope = -h.mu * across * turning(math.atan2(d_2, d_1), h)[0] / v
    return G[0, 0] - h.mu * (G[0, 1] * d_1 + G[0, 2] * d_2), slope


@kernel
def lose(h):
    """Let the impact begin where p = 0, from a slide whose p is not quite 0 yet.

    Until then gamma_N stays 0, held by a force: dp/dP < 0 where the slide turns into the paradox, and gamma_N would
    rise by p^2/(-2 dp/dP), which is taken off twice. Where it does not turn so, p is taken as just below 0.
    """
    p, slope = p_before(h)
    h.before[0] = 0.0
    if p >= 0.0 and slope < 0.0:
        h.before[0] = p * p / slope
    elif p >= 0.0:
        h.G[0, 0] -= p + SINGULAR * h.G[0, 0]


@kernel
def turns_into_paradox(P_N, h):
    """Whether a normal impulse turns the slide before the impact, as it turns at first, to p < 0 before it stops it."""
    v, size = math.hypot(h.before[1], h.before[2]), h.mu * math.hypot(h.G[0, 1], h.G[0, 2])
    if size <= h.G[0, 0]:  # p > 0 in all directions
        return False
    turned, grown = turning(math.atan2(h.before[2], h.before[1]), h)
    across = h.G[0, 2] * h.before[1] - h.G[0, 1] * h.before[2]
    along = h.G[0, 1] * h.before[1] + h.G[0, 2] * h.before[2]
    angle = abs(math.atan2(across, along)) - math.acos(h.G[0, 0] / size)  # to p = 0
    P = angle * v / abs(turned) if across * turned > 0.0 and angle > 0.0 else math.inf
    return P < P_N and -P * grown < v


@kernel
def slide_away(h):
    """dP_T/dP of the slide that begins at v = 0 where the cone does not hold: of those that do not turn the one along
    which the speed grows most."""
    best, found_1, found_2 = 0.0, 0.0, 0.0
    for m in range(DIRECTIONS_TRIED):
        low, high = 2.0 * math.pi * m / DIRECTIONS_TRIED, 2.0 * math.pi * (m + 1) / DIRECTIONS_TRIED
        below = turning(low, h)[0]
        if (below < 0.0) == (turning(high, h)[0] < 0.0):
            continue
        for _ in range(IMPACT_HALVINGS):
            middle = 0.5 * (low + high)
            if (turning(middle, h)[0] < 0.0) == (below < 0.0):
                low = middle
            else:
                high = middle
        growth = turning(low, h)[1]
        if growth > best:
            best, found_1, found_2 = growth, -h.mu * math.cos(low), -h.mu * math.sin(low)
    return found_1, found_2
