"""Rolling and spinning friction of contacts: moments in proportion to what a contact presses.

    rolling    |M_T| <= a P_N,    M_T against the angular velocity of the bodies against one another along the tangents
    spinning   |M_N| <= s P_N,    and along the normal (in space)

a and s are lengths. Each is a contact of its own behind those of the step, with a given normal force (drive_rows.py):
its normal row has J = 0, R and b such that its P_N is the limit, its tangents are those of the turn, times the lever
l, the reach of the smaller body, at which turns count as ways: mu = 1, P_T = M/l, limit a P_N/l. The problem is solved
again until the limits are those of the P_N which they lead to, as the friction of pins is (stages.py); what does not
come to that is a step that misses its tolerance. In a rebound there is none; the landing before it has its own.
Source: Acary and Bourrier, *Eur. J. Mech. A/Solids* 85 (2021) 104113 (the cone of rolling friction).
"""

from __future__ import annotations

from math import sqrt

from nonsmooth.contact.network.joint import PIN
from nonsmooth.contact.network.problem import Network
from nonsmooth.integrators.assembly.bodies import Bodies
from nonsmooth.integrators.assembly.contacts import Contacts, Surfaces
from nonsmooth.integrators.assembly.drive_rows import NO_GAP
from nonsmooth.integrators.assembly.joint_rows import write_axis, write_axis_in_space, write_turns_across
from nonsmooth.integrators.assembly.project import island_of
from nonsmooth.jit import kernel
from nonsmooth.jit.blocks import view
from nonsmooth.scenes.detection import FEATURE_BITS, FIRST_ROLLING, LAST_FEATURE, Found, contact_of, is_rolling
from nonsmooth.scenes.shape_rows import Shapes

ROLLS, SPINS = range(2)  # code: in the place of a feature of a key
# measured: of twelve balls in a heap with rolling = R/5, half as many steps then miss their tolerance
FULL_SWEEPS = 8
MOST_ROLLING = 2  # derived: rows of a contact


@kernel
def length_of(surfaces, found, c, kind):
    """a or s of contact c [m]."""
    first, second = surfaces.material[found.shape_i[c]], surfaces.material[found.shape_j[c]]
    return surfaces.rolling[first, second] if kind == ROLLS else surfaces.spinning[first, second]


@kernel
def add_rolling(surfaces, found, n):
    """Write the friction of the first n contacts, those found, behind them; the new n."""
    d, count = found.normal.shape[1], n
    for c in range(count):
        for kind in range(MOST_ROLLING if d == 3 else 1):
            if length_of(surfaces, found, c, kind) > 0.0:
                found.shape_i[n], found.shape_j[n] = found.shape_i[c], found.shape_j[c]
                found.key[n], found.gap[n] = FIRST_ROLLING | (c << FEATURE_BITS) | kind, 0.0
                for x in range(d):
                    found.normal[n, x], found.point[n, x] = 1.0 if x == 0 else 0.0, found.point[c, x]
                n += 1
    return n


@kernel
def count_rolling(keys, n):
    """How many of the first n keys are of such friction."""
    count = 0
    for c in range(n):
        count += 1 if is_rolling(keys[c]) else 0
    return count


@kernel
def lever_of(bodies, shapes, found, network, c):
    """The reach of the smaller shape of row c, of bodies that move [m]."""
    i, j = found.shape_i[c], found.shape_j[c]
    first, second = shapes.reach[i] + shapes.radius[i], shapes.reach[j] + shapes.radius[j]
    if bodies.motion.moves[network.i[c]] == 0:
        return second
    if bodies.motion.moves[network.j[c]] == 0:
        return first
    return min(first, second)


@kernel("void(int64, int64, int64, int64, int64, int64, int64)")
def write_rolling(bodies_at, shapes_at, surfaces_at, found_at, contacts_at, network_at, is_impact):
    """Make the friction of contacts of its rows, which were written as contacts; in an impact there is none. Its limits
    are those of the impulses that the solution starts from."""
    bodies, shapes, surfaces = view(bodies_at, Bodies), view(shapes_at, Shapes), view(surfaces_at, Surfaces)
    found, contacts, network = view(found_at, Found), view(contacts_at, Contacts), view(network_at, Network)
    for c in range(network.n_c):
        if not is_rolling(found.key[c]):
            continue
        lever = lever_of(bodies, shapes, found, network, c)
        write_turn(found, network, c, lever)
        R = 0.0
        for b in (network.i[c], network.j[c]):
            R += 1.0 / bodies.mass[b] if bodies.motion.moves[b] == 1 else 0.0
        found.gap[c], contacts.e[c], network.mu[c] = NO_GAP, 0.0, 1.0
        network.soft[c], network.sprung[c] = R, PIN
        network.b[c, 0] = NO_GAP if is_impact == 1 else -R * limit_of(surfaces, found, network, c, lever)


@kernel
def write_turn(found, network, c, lever):
    """The rows of row c: none at the normal, and what its bodies turn by against one another."""
    d, n, of = network.b.shape[1], network.v.shape[1], contact_of(found.key[c])
    for row in range(d):
        network.b[c, row] = network.turn[c, row] = 0.0
        for y in range(n):
            network.J_i[c, row, y] = network.J_j[c, row, y] = 0.0
    if d == 2:
        write_axis(network, c, 1, 2, lever)
        return
    e = (found.normal[of, 0], found.normal[of, 1], found.normal[of, 2])
    if found.key[c] & LAST_FEATURE == SPINS:
        write_axis_in_space(network, c, 1, e, lever)
        return
    write_turns_across(network, c, e, lever)


@kernel
def limit_of(surfaces, found, network, c, lever):
    """The largest impulse of row c, by what its contact presses [N s]."""
    of = contact_of(found.key[c])
    length = length_of(surfaces, found, of, found.key[c] & LAST_FEATURE)
    return length / lever * max(network.P[of, 0], 0.0)


@kernel("int64(int64, int64, int64, int64, int64, float64, int64)")
def limit_rolling(bodies_at, shapes_at, surfaces_at, found_at, network_at, tol, sweeps):
    """Take the limits of rolling and spinning friction at what contacts press in a solution; whether one changed by
    more than a part of the impulses of its island. After some sweeps they go half of the way, which ends cycles."""
    bodies, shapes, surfaces = view(bodies_at, Bodies), view(shapes_at, Shapes), view(surfaces_at, Surfaces)
    found, network, has_changed = view(found_at, Found), view(network_at, Network), 0
    for c in range(network.n_c):
        if is_rolling(found.key[c]):
            limit = limit_of(surfaces, found, network, c, lever_of(bodies, shapes, found, network, c))
            before, k = -network.b[c, 0] / network.soft[c], island_of(network, c)
            size = sqrt(network.islands.P[k]) if k >= 0 else 0.0
            if abs(limit - before) > tol * max(size, max(limit, before)):
                has_changed = 1
            step = 1.0 if sweeps < FULL_SWEEPS else 0.5
            network.b[c, 0] = -network.soft[c] * (before + step * (limit - before))
    return has_changed
