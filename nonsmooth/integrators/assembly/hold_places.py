"""Places of joined bodies after they have moved: what their points have parted within the step is taken back at once.

    g(x) = 0  by  x <- x + dt w,   dt J w = -g(x),   w = M^-1 J^T P,   until |g| is a rounding

That is Newton's method on the gaps of the joints with the rows of the middle of the step, which are those that the
velocities were solved with: each pass leaves about omega dt/2 of the gap. One or two leave less than is asked for; no
pass is made beyond the first that does not halve the gaps. Contacts and limits of the island do not close by it, nor go
deeper. It is the problem of draw_together.py, which takes back what is off at the beginning of the step.
"""

from __future__ import annotations

from nonsmooth.contact.network.joint import is_joint, may_land
from nonsmooth.contact.network.problem import Network
from nonsmooth.contact.network.solve import Solver, solve_network
from nonsmooth.integrators.assembly.bodies import Bodies
from nonsmooth.integrators.assembly.contacts import Contacts
from nonsmooth.integrators.assembly.draw_together import Held, begin_places, end_places
from nonsmooth.integrators.assembly.joined_trees import solve_trees
from nonsmooth.integrators.assembly.joints import Joints, drift_of_joint, first_joint, largest_drift
from nonsmooth.integrators.assembly.of_body import move_body
from nonsmooth.integrators.assembly.progress import Progress
from nonsmooth.integrators.assembly.project import Moves, has_joints, normal_velocity
from nonsmooth.jit import kernel
from nonsmooth.jit.blocks import address, view
from nonsmooth.numerics.rounding import rounded_sum
from nonsmooth.scenes.detection import Found

HELD_TO = 0.1  # chosen: of a penetration that is a rounding (``Progress.tight``): 1e-11 of the smallest shape
PLACE_ROUNDINGS = 16  # chosen: of the places of its bodies, that a gap of a joint is made of
MOST_HOLDS = 12  # measured: where a body turns by 0.3 rad in a step it takes seven
HALVED = 0.5  # chosen: of the largest gap, that a pass leaves at most where another one follows
NEVER_CLOSES = 1e30  # code: the gap of a row that is no contact [m]


@kernel("int64(int64, int64)")
def hold_places(progress_at, d):
    """Take back what joints have parted where bodies have moved to, d is 2 or 3. Returns 0, or how many blocks of
    factors are wanted: called again with more room it goes on."""
    progress = view(progress_at, Progress)
    places = progress.places
    network, solver, held = view(places.network, Network), view(places.solver, Solver), view(places.held, Held)
    bodies, found, contacts = view(places.bodies, Bodies), view(places.found, Found), view(places.contacts, Contacts)
    joints, moves, first = view(places.joints, Joints), view(places.moves, Moves), first_joint(found, network)
    if held.is_begun == 0:
        held.passes = 0
        write_gaps(joints, bodies, found, contacts, network, first)
    largest = largest_drift(contacts, network, first)
    while held.is_begun == 1 or asks_for_pass(bodies, contacts, network, held, progress.tight):
        if held.is_begun == 0:
            begin_places(network, solver, held)
            write_problem(bodies, found, contacts, network, held, progress.dt)
        solve_trees(places.network, address(held.tree), solver.tol, 0, d)
        wanted = solve_network(places.network, places.solver, places.desk, d)
        if wanted > 0:
            return wanted
        push(bodies, network, moves, held, progress, d)
        end_places(network, solver, held)
        held.passes += 1
        write_gaps(joints, bodies, found, contacts, network, first)
        before, largest = largest, largest_drift(contacts, network, first)
        if largest > HALVED * before:
            break
    progress.figures.last_drift = largest
    progress.figures.drift = max(progress.figures.drift, largest)
    return 0


@kernel
def write_gaps(joints, bodies, found, contacts, network, first):
    """How far all joints are off where their bodies are."""
    for c in range(first, network.n_c):
        drift_of_joint(joints, bodies.motion.x, found.key[c], c, contacts)


@kernel
def asks_for_pass(bodies, contacts, network, held, tight):
    """Whether another pass is due; marks its islands."""
    return held.passes < MOST_HOLDS and mark_parted(bodies, contacts, network, held, tight)


@kernel
def mark_parted(bodies, contacts, network, held, tight):
    """Mark the islands with joints that are off by more than roundings; whether there is one."""
    islands, is_any = network.islands, False
    for k in range(islands.count):
        held.is_parted[k] = 0
        if has_joints(network, k):
            for at in range(islands.contact_start[k], islands.contact_start[k + 1]):
                c = islands.contacts[at]
                if is_joint(network, c) and is_off(bodies, contacts, network, c, HELD_TO * tight):
                    held.is_parted[k] = 1
                    is_any = True
    return is_any


@kernel
def is_off(bodies, contacts, network, c, tight):
    """Whether joint c is off by more than a length, and than the roundings of the places of its bodies."""
    size, square, x = 0.0, 0.0, bodies.motion.x
    for axis in range(contacts.drift.shape[1]):
        size += abs(x[network.i[c], axis]) + abs(x[network.j[c], axis])
        square += contacts.drift[c, axis] * contacts.drift[c, axis]
    limit = max(tight, rounded_sum(PLACE_ROUNDINGS, size))
    return square > limit * limit


@kernel
def write_problem(bodies, found, contacts, network, held, dt):
    """The problem of the places; islands that are not parted are left out as if they were solved."""
    islands, n = network.islands, network.v.shape[1]
    for c in range(network.n_c):
        for row in range(network.b.shape[1]):
            network.P[c, row] = 0.0
            network.b[c, row] = contacts.drift[c, row] / dt if is_joint(network, c) else 0.0
        if not is_joint(network, c):
            gap = NEVER_CLOSES
            if may_land(network, c):
                speed, _ = normal_velocity(network, c, bodies.v_move, n)
                gap = max(found.gap[c] + dt * speed, 0.0)
            network.mu[c], network.b[c, 0] = 0.0, gap / dt
    for b in range(network.v.shape[0]):
        for x in range(n):
            network.v[b, x] = network.v_free[b, x] = 0.0
    for k in range(islands.count):
        islands.is_met[k], islands.sweeps[k], islands.factors[k] = 1 - held.is_parted[k], 0, 0
        islands.owner[k] = 0  # whichever thread had it: this problem is solved here


@kernel
def push(bodies, network, moves, held, progress, d):
    """Move the bodies of parted islands by dt w, and add w to what they were pushed by in the step."""
    if progress.is_pushed == 0:
        for b in range(network.v.shape[0]):
            for x in range(network.v.shape[1]):
                moves.push[b, x] = 0.0
    progress.is_pushed, islands = 1, network.islands
    for k in range(islands.count):
        if held.is_parted[k] == 1:
            for at in range(islands.body_start[k], islands.body_start[k + 1]):
                b = islands.bodies[at]
                move_body(bodies, b, progress.dt, network.v, d)
                for x in range(network.v.shape[1]):
                    moves.push[b, x] += network.v[b, x]
