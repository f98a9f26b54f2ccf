"""Where a run of steps is, what it works on, and its worst figures."""

from __future__ import annotations

from math import sqrt

from nonsmooth.contact.network.joint import is_contact
from nonsmooth.contact.network.patience import FACTORS, MANY_FACTORS
from nonsmooth.contact.network.problem import worst_contact
from nonsmooth.contact.network.solve import BY_FACTORS, BY_INTERIOR, BY_START, BY_SWEEPS, Solver
from nonsmooth.integrators.assembly.book import Ledger
from nonsmooth.integrators.records import FRICTION_WORK, N_LEDGER, NORMAL_WORK
from nonsmooth.jit import kernel
from nonsmooth.jit.blocks import Block, view
from nonsmooth.numerics.rounding import rounded_sum

GAIN_ROUNDINGS = 1000  # chosen: of the works of a rebound, and of those booked so far
GAIN = 1e-4  # chosen: of what was lost in landing: contact problems are solved to a residual, not to rounding
# chosen: [rad] of a turn in a step: normals and points are those of its beginning, and a turn of this angle misses them
# by 0.5^2/2 of a reach
MOST_TURN = 0.5
SPEED_SHARE = 1.0  # measured: of the way of the fastest body in a step, in the margin
# chosen: factors of a problem, some 0.4 ms in space: after less no thread is thought of (contact/network/parallel.py)
SHARED_FACTORS = 16
# where a step goes on when there is room for what it found
PREDICT, FIND, SOLVE, DRAW, HOLD, REBOUND, STRUCK = range(7)
# how a run of steps comes back
DONE, MORE_CONTACTS, MORE_PAIRS, MORE_FACTORS, NOT_MET, LOST, UNSOLVED, TOGETHER, DOUBTFUL, EXAMINED, MORE_BOOKS = (
    range(11)
)
NEXT_PART = -1  # code: a part of a step is done, or is to be taken again, shorter
NO_FRICTION = 11  # code: a law gives no coefficient at the speed that was met; ``wanted`` is the contact
BY_LAW = 12  # code: an impact is to follow another law than Newton's (struck.py)
TOO_MANY = 13  # code: and has more contacts than that is done for; ``wanted`` is one of them
RECORD = 14  # code: a record is due that Python writes (written.py)


class Places(Block):
    """Addresses of the blocks that the stages of a step are handed."""

    bodies: int
    motion: int
    shapes: int
    surfaces: int
    scratch: int
    found: int
    contacts: int
    network: int
    moves: int
    ledger: int
    solver: int
    desk: int
    asleep: int
    joints: int
    held: int
    doubts: int
    pairs: int
    links: int
    parts: int
    springs: int
    reactions: int
    drives: int
    bearings: int


class Counts(Block):
    """What a run did, from its start on."""

    steps: int
    impacts: int  # steps in which contacts rebounded
    gains: int  # of these, steps in which the contacts gained energy
    together: int  # and steps in which several bodies struck one together (together.py)
    first_together: int  # the first of these
    limited: int  # steps whose rebounds would have given back more energy than there was (energy_limit.py)
    struck: int  # the body that was struck in it
    missed: int  # whose residual stayed above the tolerance
    most_contacts: int
    kept: int  # islands, of steps, that the impulses of the step before solved
    swept: int
    direct: int
    inside: int
    sweeps: int
    factors: int
    spun: int  # steps in which a body that is not round turned far while it touched
    spinner: int  # the last body that did
    asleep: int  # steps that were not taken, since the one before changed nothing and they would have repeated it
    left_islands: int  # islands, of steps, that were asleep


class Figures(Block):
    """The worst of the steps, and of those since the record before; and those of the last step."""

    residual: float
    penetration: float
    since_residual: float
    since_penetration: float
    last_residual: float
    last_penetration: float
    gain: float  # [J] of a step, the largest
    drift: float  # the farthest apart that the points of a joint were [m]
    last_drift: float


class Worst(Block):
    """Where the residual was the largest of the run."""

    row: int  # of the contacts in that step
    i: int  # its bodies
    j: int
    step: int


class Progress(Block):
    """Where a run of steps is."""

    places: Places
    counts: Counts
    figures: Figures
    worst: Worst
    stage: int
    wanted: int  # of what there was no room for
    may_sleep: int
    is_missed: int  # whether a problem of the step at hand stayed above its tolerance
    is_tried: int  # whether all that can be tried has been, on the problem at hand
    threads: int  # that may solve islands at once
    is_shared: int  # whether they have, on the problem at hand
    factors: int  # of the problem before
    is_asked: int  # whether islands of the step at hand have been asked for their solutions
    is_examined: int  # whether some were doubtful
    has_verdicts: int  # whether a paradox was found in one
    is_strict: int  # whether a step that misses its tolerance ends the run
    lands_whole: int  # whether what lands in a step has its whole impulse in it
    has_restitution: int
    has_impact_law: int  # whether impacts follow another law than Newton's
    has_laws: int  # whether friction varies with the slip
    has_pins: int  # whether joints have friction
    has_grain: int  # whether friction differs by direction
    has_adhesion: int  # whether contacts may hold on to one another
    has_rolling: int  # whether contacts have friction of rolling or spinning
    speeds: int  # times that the coefficients of the step were taken at other velocities
    has_faces: int  # whether several shapes have plane faces, which may hide one another
    is_resting: int  # whether the last step changed nothing: the next one of its length would be the same
    dt_at_rest: float  # its length [s]
    may_divide: int  # whether a step may be taken in parts (divided.py)
    parts: int  # which part of the step is at hand, from 1 on; 0 where it is not divided
    divisions: int  # times that a part of the step was taken again
    is_pushed: int  # whether bodies were moved in the step otherwise than by their velocities
    is_stroke: int  # whether the part at hand is that of an impact
    lets_in: int  # whether the part at hand ends before a landing
    left: float  # of the step, behind the part at hand [s]
    whole: float  # the length of the step [s]
    dt: float  # the length of the part at hand: of a step that is not divided, its own [s]
    theta: float
    margin: float  # of a scene at rest: gaps below it are candidates for contacts [m]
    widest: float  # that it may become [m]
    tight: float  # penetration that is a rounding [m]


@kernel
def note_islands(network, asleep, progress):
    """Count how the islands of a problem were solved; those that sleep are as the step before left them."""
    islands, counts, before = network.islands, progress.counts, progress.counts.factors
    counts.kept += asleep.count
    for k in range(islands.count):
        counts.kept += 1 if islands.rung[k] == BY_START else 0
        counts.swept += 1 if islands.rung[k] == BY_SWEEPS else 0
        counts.direct += 1 if islands.rung[k] == BY_FACTORS else 0
        counts.inside += 1 if islands.rung[k] == BY_INTERIOR else 0
        counts.sweeps += islands.sweeps[k]
        counts.factors += islands.factors[k]
    progress.factors = counts.factors - before


@kernel
def are_worth_sharing(islands, progress):
    """Whether several threads would be done earlier: the problem before was factorised, and there are some islands."""
    return progress.threads > 1 and progress.factors >= SHARED_FACTORS and islands.count > 1


@kernel
def is_met(network):
    """Whether all islands are solved to the tolerance, or to what rounding lets them."""
    islands = network.islands
    for k in range(islands.count):
        if islands.is_met[k] == 0:
            return False
    return True


@kernel
def note_residual(residual, network, asleep, progress, d):
    """Note the residual of a problem, of the step's contacts with those that sleep or of their impact, and whether it
    missed its tolerance."""
    figures, islands = progress.figures, network.islands
    if residual > figures.residual:
        note_worst(residual, network, progress, d)
    if progress.stage == SOLVE and progress.parts <= 1:
        figures.last_residual = max(residual, asleep.residual) if residual == residual else residual
    elif not residual <= figures.last_residual:
        figures.last_residual = residual
    figures.residual = max(figures.residual, figures.last_residual)
    figures.since_residual = max(figures.since_residual, figures.last_residual)
    for k in range(islands.count):
        islands.is_met[k] = 1 if islands.residual[k] <= network.tol else 0
    if not is_met(network):
        progress.is_missed = 1


@kernel
def note_worst(residual, network, progress, d):
    """Note the contact at which the residual of a problem is largest."""
    worst, islands = progress.worst, network.islands
    for k in range(islands.count):
        if islands.residual[k] == residual:
            worst.row = worst_contact(network, k, d, 3 * (d - 1))
            worst.i, worst.j = network.i[worst.row], network.j[worst.row]
            worst.step = progress.counts.steps - (1 if progress.stage >= REBOUND and progress.left == 0.0 else 0)
            return


@kernel
def note_step(network, asleep, deepest, left, progress):
    """The figures of a step, before more islands fall asleep; left: ropes that are no rows, less rows of rolling."""
    counts, figures = progress.counts, progress.figures
    figures.last_penetration = max(figures.last_penetration if progress.parts > 1 else 0.0, -deepest)
    if progress.left > 0.0:
        return
    counts.steps += 1
    counts.left_islands += asleep.count
    counts.most_contacts = max(counts.most_contacts, network.n_c + asleep.n_c + left)
    figures.penetration = max(figures.penetration, figures.last_penetration)
    figures.since_penetration = max(figures.since_penetration, figures.last_penetration)


@kernel
def note_turns(bodies, shapes, network, dt, progress):
    """Count a step in which a body turned farther than its contacts are true for."""
    v, d, limit = bodies.v_move, bodies.gravity.shape[0], (MOST_TURN / dt) ** 2
    for b in range(v.shape[0]):
        square = 0.0
        for k in range(d, v.shape[1]):
            square += v[b, k] * v[b, k]
        if square > limit and bodies.motion.moves[b] == 1 and is_touched(network, b) and not is_round(shapes, d, b):
            progress.counts.spun += 1
            progress.counts.spinner = b


@kernel
def is_touched(network, b):
    """Whether an impulse of a contact acts on a body."""
    for c in range(network.n_c):
        if network.P[c, 0] > 0.0 and is_contact(network, c) and (network.i[c] == b or network.j[c] == b):
            return True
    return False


@kernel
def is_round(shapes, d, b):
    """Whether a body looks the same however it turns: a disc or a ball about its centre of mass."""
    for s in range(shapes.body.shape[0]):
        if shapes.body[s] == b:
            if shapes.reach[s] > 0.0:
                return False
            for k in range(d):
                if shapes.place[s, k] != 0.0:
                    return False
    return True


@kernel
def is_at_rest(bodies, network):
    """Whether the step began and ended at rest, with the impulses that it was handed: the next one is the same."""
    v, v_0 = bodies.motion.v, bodies.v_0
    for b in range(v.shape[0]):
        for x in range(v.shape[1]):
            if v[b, x] != 0.0 or v_0[b, x] != 0.0 or bodies.v_move[b, x] != 0.0:
                return False
    islands = network.islands
    for k in range(islands.count):
        if islands.rung[k] != BY_START or islands.is_met[k] == 0:
            return False
    return True


@kernel
def is_repeated(ledger, solver):
    """Whether the next step would book nothing, as one with a belt does, and solve as this one did."""
    for column in range(N_LEDGER):
        if ledger.work[column] != ledger.before[column]:
            return False
    left = solver.patience.left
    return left[FACTORS] == 0 and left[MANY_FACTORS] == 0


@kernel
def note_rest(bodies, network, progress):
    """Note whether the step just taken would be repeated by the next one."""
    figures = progress.figures
    is_tight = figures.last_penetration <= progress.tight and figures.last_drift <= progress.tight
    progress.is_resting = 0
    if progress.may_sleep == 1 and progress.parts == 0 and is_tight and is_at_rest(bodies, network):
        if is_repeated(view(progress.places.ledger, Ledger), view(progress.places.solver, Solver)):
            progress.is_resting, progress.dt_at_rest = 1, progress.whole


@kernel
def is_asleep(bodies, progress):
    """Whether the next step would repeat the last one: of the same length, and with nothing told to move."""
    if progress.is_resting == 0 or progress.whole != progress.dt_at_rest:
        return False
    v, gain = bodies.motion.v, bodies.gain
    for b in range(v.shape[0]):
        for x in range(v.shape[1]):
            if v[b, x] != 0.0 or gain[b, x] != 0.0:
                return False
    return True


@kernel
def leave_out(network, asleep, steps, progress):
    """Count so many steps as if they had been taken, with the figures of the last one."""
    counts, figures = progress.counts, progress.figures
    counts.steps += steps
    counts.asleep += steps
    counts.kept += steps * (network.islands.count + asleep.count - asleep.new_islands)
    counts.left_islands += steps * asleep.count
    figures.since_residual = max(figures.since_residual, figures.last_residual)
    figures.since_penetration = max(figures.since_penetration, figures.last_penetration)


@kernel
def note_gain(size, ledger, progress):
    """Note what the contacts gained in a step in which they rebounded, in landing and rebounding together; ``size`` is
    that of the works of the rebound."""
    landing, rebound = ledger.landing, ledger.rebound
    gain = landing[NORMAL_WORK] + landing[FRICTION_WORK] + rebound[NORMAL_WORK] + rebound[FRICTION_WORK]
    taken = abs(landing[NORMAL_WORK]) + abs(landing[FRICTION_WORK])
    booked = abs(ledger.work[NORMAL_WORK]) + abs(ledger.work[FRICTION_WORK])
    if gain > GAIN * taken + rounded_sum(GAIN_ROUNDINGS, booked + size):
        progress.counts.gains += 1
        progress.figures.gain = max(progress.figures.gain, gain)


@kernel
def margin_of(progress, bodies):
    """Gap below which shapes are candidates: an impact may turn the velocity of a body within the step."""
    v, fastest = bodies.motion.v, 0.0
    d = bodies.gravity.shape[0]
    for b in range(v.shape[0]):
        square = 0.0
        for k in range(d):
            square += v[b, k] * v[b, k]
        fastest = max(fastest, square)
    return min(progress.margin + SPEED_SHARE * progress.dt * sqrt(fastest), progress.widest)


@kernel
def deepest_gap(found, n_c):
    """The least gap, or 0 [m]."""
    deepest = 0.0
    for c in range(n_c):
        deepest = min(deepest, found.gap[c])
    return deepest
