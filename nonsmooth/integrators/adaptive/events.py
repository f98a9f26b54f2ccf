"""Where a mode ends within an adaptive step, found on its motion, which goes on smoothly beyond.

The event functions are those of rigid/rates.py, and the load of a given normal force:

    g_N of an open contact, la_N of a closed one    s gamma_F of a slide    mu sigma la_N -+ la_F of one that sticks
    sigma la_N of a bilateral slide                 det A of all slides     N of a given normal force

Each substep leaves a sample of them. Where a sample has fallen, where the parabola through three of them dips low, and
at the end of the step they are evaluated on the motion; the first fall through zero is enclosed and the step taken anew
to end there. Within its band a function is zero. It is armed once it has been above it; an armed one that falls through
zero is an event, one that was never armed if it falls below minus its band. A step may end with an event whose function
is beyond that by less than its band: there modes are decided, by a plain step that sees what no longer holds.

Redundant contacts have no function with a slope: their modes hold while any share of their load is admissible, and
what ends them is enclosed by bisection.
Source: Hairer, Nørsett, Wanner, *Solving Ordinary Differential Equations I* (1993), section II.6.
"""

from __future__ import annotations

import math

from nonsmooth.errors import Status
from nonsmooth.integrators.adaptive.held import load
from nonsmooth.integrators.adaptive.polynomial import state_within
from nonsmooth.integrators.adaptive.scales import BAND, closed_gap
from nonsmooth.integrators.adaptive.state import NOWHERE, Extrapolation
from nonsmooth.integrators.radau.resolution import LOW_DIP
from nonsmooth.integrators.records import CLOSURE, FRICTION, N_FUNCTIONS, State
from nonsmooth.integrators.rigid.census import enters_region
from nonsmooth.integrators.rigid.rates import rigid_events
from nonsmooth.jit import kernel, rare_kernel
from nonsmooth.jit.blocks import address, view
from nonsmooth.mechanics.sys import Sys
from nonsmooth.mechanics.system import GIVEN_FORCE, ContactMode
from nonsmooth.numerics.rounding import spacing

STANDS, WITHIN, BEYOND = range(3)
ENCLOSURES = 100  # chosen: of regula falsi, before an event is given up
NARROW_ENCLOSURE = 1e-3  # chosen: of an enclosure: regula falsi goes no nearer to its ends


@kernel
def event_values(sys, t, y, run, out):
    """The event functions at a state, to out (E,); returns a Status. Bands are left in run.function, behind E values,
    negative where a function has no slope."""
    contacts, function = run.contacts, run.function
    status = rigid_events(address(sys), address(contacts), t, y, function)
    E = run.f_0.shape[0]
    for e in range(E):
        out[e] = function[e]
    for i in range(sys.n_c):
        e = N_FUNCTIONS * i
        if sys.kinds[i, 0] == GIVEN_FORCE:
            out[e + CLOSURE] = load(i, run)
    return status


@kernel
def set_bands(sys, run):
    """The bands of the functions that were evaluated last."""
    contacts, function = run.contacts, run.function
    E = run.f_0.shape[0]
    for e in range(E):
        run.band[e] = max(0.0, function[E + e])
    for i in range(sys.n_c):
        e = N_FUNCTIONS * i
        if sys.kinds[i, 0] == GIVEN_FORCE:
            run.heaviest[i] = max(run.heaviest[i], abs(contacts.work.N[i]))
            run.band[e + CLOSURE] = contacts.numbers.rtol * run.heaviest[i]
        elif contacts.mode[i] == ContactMode.OPEN:
            run.band[e + CLOSURE] = closed_gap(i, run)
        if contacts.mode[i] == ContactMode.SLIDE:
            run.band[e + FRICTION] = BAND * run.tol_slip[i]


@kernel
def threshold(e, place, run):
    """Below which event function e has fallen at a place of the step."""
    return run.band[e] if run.armed[e] == 1 or place >= run.rises[e] else -run.band[e]


@kernel
def find_rises(m, run):
    """The places from which on functions count as armed that rise above their bands in a step of m substeps."""
    for e in range(run.f_0.shape[0]):
        run.rises[e] = NOWHERE
        if run.armed[e] == 1:
            continue
        for a in range(interior(e, m, run), 0, -1):
            place, value = node(e, a, m, run)
            if value > run.band[e]:
                run.rises[e] = place


@kernel
def arm_functions(run):
    """Arm the functions that are above their bands at the beginning of a step."""
    for e in range(run.armed.shape[0]):
        if run.f_0[e] > run.band[e]:
            run.armed[e] = 1


@kernel
def interior(e, m, run):
    """How many samples of function e lie within a step of m substeps: those of a slide are taken at their ends."""
    i = e // N_FUNCTIONS
    is_slide = i < run.contacts.mode.shape[0] and run.contacts.mode[i] == ContactMode.SLIDE
    return m - 1 if is_slide and e % N_FUNCTIONS == FRICTION else m


@kernel
def node(e, a, m, run):
    """(Place, value) of function e: its beginning, a = 0, the samples within the step, and its end."""
    size = interior(e, m, run)
    if a == 0:
        return 0.0, run.f_0[e]
    if a > size:
        return 1.0, run.f_1[e]
    return (a if size < m else a - 0.5) / m, run.sample[a - 1, e]


@kernel
def crossing(m, run):
    """Where in a step of m substeps a function falls through zero first, as the parabola through its samples has it;
    NOWHERE if none does."""
    first = NOWHERE
    if not has_negative(m, run):
        return first
    find_rises(m, run)
    for e in range(run.f_0.shape[0]):
        size = interior(e, m, run)
        for a in range(1, size + 1):
            place, value = node(e, a, m, run)
            if value < threshold(e, place, run) and value < 0.0:
                first = min(first, root(e, a, size, m, run))
                break
    return first


@kernel
def has_negative(m, run):
    """Whether any of m samples is."""
    for a in range(m):
        for e in range(run.f_0.shape[0]):
            if run.sample[a, e] < 0.0:
                return True
    return False


@kernel
def root(e, a, size, m, run):
    """The zero of function e before node a, at which it is negative, of the parabola through three nodes."""
    (t_0, v_0), (t_1, v_1) = node(e, a - 1, m, run), node(e, a, m, run)
    if not v_0 > 0.0:
        return t_0
    slope, curvature = (v_1 - v_0) / (t_1 - t_0), 0.0
    if a < size:
        t_2, v_2 = node(e, a + 1, m, run)
        curvature = ((v_2 - v_1) / (t_2 - t_1) - slope) / (t_2 - t_0)
    elif a > 1:
        t_2, v_2 = node(e, a - 2, m, run)
        curvature = (slope - (v_0 - v_2) / (t_0 - t_2)) / (t_1 - t_2)
    steepness = slope - curvature * (t_1 - t_0)  # at t_0: v = v_0 + (t - t_0) (steepness + curvature (t - t_0))
    square = steepness * steepness - 4.0 * curvature * v_0
    return t_0 + 2.0 * v_0 / (math.sqrt(max(0.0, square)) - steepness)


@kernel
def next_suspect(after, m, run):
    """The next place after one at which a function may have fallen: a sample has, or it dips low; 1 if none."""
    first = 1.0
    for e in range(run.f_0.shape[0]):
        size = interior(e, m, run)
        lowest, highest = extent(e, size, run)
        if lowest > max(run.band[e], highest - lowest):
            continue  # no parabola dips by more than a third of that
        for a in range(1, size + 1):
            place, value = node(e, a, m, run)
            if place > after and value < threshold(e, place, run):
                first = min(first, place)
        for a in range(1, size + 1):
            place, value = dip(e, a, m, run)
            if after < place < first and value < LOW_DIP * (highest - lowest):
                first = place
    return first


@kernel
def extent(e, size, run):
    """The lowest and the highest of the nodes of function e."""
    lowest, highest = min(run.f_0[e], run.f_1[e]), max(run.f_0[e], run.f_1[e])
    for a in range(size):
        lowest, highest = min(lowest, run.sample[a, e]), max(highest, run.sample[a, e])
    return lowest, highest


@kernel
def dip(e, a, m, run):
    """(Place, value) of the lowest point of the parabola about node a of function e; NOWHERE where there is none."""
    (t_0, v_0), (t_1, v_1), (t_2, v_2) = node(e, a - 1, m, run), node(e, a, m, run), node(e, a + 1, m, run)
    slope = (v_1 - v_0) / (t_1 - t_0)
    curvature = ((v_2 - v_1) / (t_2 - t_1) - slope) / (t_2 - t_0)
    if not curvature > 0.0:
        return NOWHERE, 0.0
    place = 0.5 * (t_0 + t_1 - slope / curvature)
    if not t_0 < place < t_2:
        return NOWHERE, 0.0
    return place, v_0 + (place - t_0) * (slope + (place - t_1) * curvature)


@kernel("Tuple((int64, float64))(int64, float64, float64, int64, int64, int64)", short_loops=True)
def find_event(sys_at, t, H, j, state_at, run_at):
    """Where a step that converged at row j, and was fitted, has its first event: (Status, place, 1 if it ends with one,
    NOWHERE if there is none). Its end is run.x."""
    sys = view(sys_at, Sys)
    state, run = view(state_at, State), view(run_at, Extrapolation)
    status = event_values(sys, t + H, run.x, run, run.f_1)
    if status != Status.RUNNING:
        return status, NOWHERE
    is_known, low = True, 0.0
    find_rises(j + 1, run)
    place = next_suspect(low, j + 1, run)
    while place < 1.0:
        is_known = False
        status = values_within(sys, t, H, place, state, run)
        if status != Status.RUNNING:
            return status, NOWHERE
        if find_fallen(run.f_in, place, run) == BEYOND:
            return enclose(sys, t, H, low, place, state, run)
        low = place
        place = next_suspect(low, j + 1, run)
    how = find_fallen(run.f_1, 1.0, run)
    ends = run.counters.is_located == 1 and how == BEYOND and not has_slope(run.f_1, run)
    if not is_known and (how != BEYOND or ends):
        status = event_values(sys, t + H, run.x, run, run.f_1)  # the forces at the end are known again
    if how == STANDS:
        return Status.RUNNING.value, NOWHERE
    if how == WITHIN or ends:
        return Status.RUNNING.value, 1.0
    for e in range(run.f_1.shape[0]):
        run.f_in[e] = run.f_1[e]
    return enclose(sys, t, H, low, 1.0, state, run)


@kernel
def only_enters_region(sys, run):
    """Whether nothing has fallen but the function that tells that a second force fits a bilateral slide."""
    enters = False
    for e in range(run.f_1.shape[0]):
        if run.f_1[e] < threshold(e, 1.0, run):
            if not enters_region(sys, e, run.contacts):
                return False
            enters = True
    return enters


@rare_kernel
def values_within(sys, t, H, place, state, run):
    """The event functions at a place of the motion that was fitted, to run.f_in; returns a Status."""
    state_within(place, H, state, run)
    return event_values(sys, t + place * H, run.y, run, run.f_in)


@kernel
def find_fallen(f, place, run):
    """How far the function has fallen that has fallen farthest: STANDS, WITHIN its band, or BEYOND."""
    how = STANDS
    for e in range(f.shape[0]):
        below = threshold(e, place, run) - f[e]
        if below > 0.0:
            how = max(how, WITHIN if below <= 2.0 * run.band[e] else BEYOND)
    return how


@kernel
def has_slope(f, run):
    """Whether a function that has fallen beyond its band has one."""
    for e in range(f.shape[0]):
        if threshold(e, 1.0, run) - f[e] > 2.0 * run.band[e] > 0.0:
            return True
    return False


@rare_kernel
def enclose(sys, t, H, low, high, state, run):
    """(Status, place) of the first fall between two places, at the second of which the values are in run.f_in.

    Regula falsi with the Illinois factor for the lowest of all functions, each over what it falls by until there, and
    counted from the middle of where it counts as fallen; every third time, and where they have no slope, bisection.
    """
    E = run.f_0.shape[0]
    for e in range(E):
        run.scale[e] = max(abs(run.f_0[e]), abs(run.f_in[e])) + run.band[e]
    status = Status.RUNNING.value
    if low > 0.0:
        v_high = lowest(run.f_in, high, run)
        status = values_within(sys, t, H, low, state, run)
        v_low = lowest(run.f_in, low, run)
    else:
        v_low, v_high = lowest(run.f_0, low, run), lowest(run.f_in, high, run)
    side = 0
    for k in range(ENCLOSURES):
        if status != Status.RUNNING or (high - low) * H <= run.clock.least or high - low <= spacing(high):
            break
        part = 0.5
        if k % 3 < 2 and v_low > 0.0 > v_high:
            part = min(1.0 - NARROW_ENCLOSURE, max(NARROW_ENCLOSURE, v_low / (v_low - v_high)))
        middle = low + part * (high - low)
        status = values_within(sys, t, H, middle, state, run)
        how, value = find_fallen(run.f_in, middle, run), lowest(run.f_in, middle, run)
        if how == WITHIN:
            return status, middle
        if how == BEYOND:
            high, v_high = middle, value
            v_low *= 0.5 if side == 1 else 1.0
            side = 1
        else:
            low, v_low = middle, value
            v_high *= 0.5 if side == -1 else 1.0
            side = -1
    return status, high


@kernel
def lowest(f, place, run):
    """The lowest event function over its scale, from half a band below where it falls."""
    value = math.inf
    for e in range(f.shape[0]):
        if run.scale[e] > 0.0:
            value = min(value, (f[e] - threshold(e, place, run) + run.band[e]) / run.scale[e])
    return value
