"""A step of a scene, as a table of contents: predict, find contacts, solve them, move, book, rebound.

    v_free = v_0 + dt M^-1 h,    (gamma_1 + g_N/dt, P) in the laws of contact and friction,    v_1 = v_free + M^-1 J^T P

A stage that finds no room returns, and goes on when it is called again. d is 2 in the plane and 3 in space, a constant
of the entry point; the stages are entry points of their own, so that the one compiles nothing of the other.

Sources: Stewart and Trinkle, *Int. J. Numer. Methods Eng.* 39 (1996) 2673-2691 (gaps at the end of the step); the
stages of this scheme: docs/theory/scenes.md.
"""

from __future__ import annotations

from nonsmooth.contact.network.problem import Network, judge_network, prepare_network
from nonsmooth.contact.network.solve import Solver, solve_network
from nonsmooth.contact.planar.ladder import SPEED_SWEEPS
from nonsmooth.integrators.assembly.adhesion import book_pulls, pull_together
from nonsmooth.integrators.assembly.bearings import find_doubtful_machine
from nonsmooth.integrators.assembly.bodies import Bodies
from nonsmooth.integrators.assembly.book import Ledger, book_impact, book_landing, book_step
from nonsmooth.integrators.assembly.contacts import Contacts, Surfaces, write_contacts
from nonsmooth.integrators.assembly.divided import (
    Parts,
    ask_of_landings,
    begin_next_part,
    is_taken_again,
    land_whole,
)
from nonsmooth.integrators.assembly.doubtful import find_doubtful
from nonsmooth.integrators.assembly.draw_together import Held, draw_together
from nonsmooth.integrators.assembly.drive_rows import Drives, add_drives, rub_joints, write_drives
from nonsmooth.integrators.assembly.energy_limit import limit_rebounds
from nonsmooth.integrators.assembly.friction import UNCHANGED, take_friction, update_friction
from nonsmooth.integrators.assembly.grain import turn_to_grain
from nonsmooth.integrators.assembly.held_closed import hold_closed
from nonsmooth.integrators.assembly.hidden import leave_out_hidden
from nonsmooth.integrators.assembly.hold_places import hold_places
from nonsmooth.integrators.assembly.impact import ask_rebounds, begin_impact
from nonsmooth.integrators.assembly.joined_trees import solve_trees
from nonsmooth.integrators.assembly.joints import (
    Joints,
    add_joints,
    book_reactions,
    first_joint,
    largest_drift,
    leave_out_ignored,
    write_joints,
)
from nonsmooth.integrators.assembly.of_body import predict_body
from nonsmooth.integrators.assembly.pairs import Pairs, book_pairs, repeat_pairs
from nonsmooth.integrators.assembly.progress import (
    BY_LAW,
    DONE,
    DOUBTFUL,
    DRAW,
    EXAMINED,
    FIND,
    HOLD,
    LOST,
    MORE_BOOKS,
    MORE_CONTACTS,
    MORE_FACTORS,
    MORE_PAIRS,
    NEXT_PART,
    NO_FRICTION,
    NOT_MET,
    PREDICT,
    REBOUND,
    SOLVE,
    STRUCK,
    TOGETHER,
    UNSOLVED,
    Progress,
    are_worth_sharing,
    deepest_gap,
    is_asleep,
    is_met,
    leave_out,
    margin_of,
    note_gain,
    note_islands,
    note_residual,
    note_rest,
    note_step,
    note_turns,
)
from nonsmooth.integrators.assembly.project import move_bodies
from nonsmooth.integrators.assembly.rolling import (
    MOST_ROLLING,
    add_rolling,
    count_rolling,
    limit_rolling,
    write_rolling,
)
from nonsmooth.integrators.assembly.sleep import Asleep, let_sleep, mark_guides, wake_all, wake_touched
from nonsmooth.integrators.assembly.spatial import take_spins, turn_inertia
from nonsmooth.integrators.assembly.spring_rows import SIDES, Springs, add_springs, write_springs
from nonsmooth.integrators.assembly.together import note_together
from nonsmooth.integrators.assembly.wandering import ask_of_wandering, note_held
from nonsmooth.jit import in_dimensions, kernel
from nonsmooth.jit.blocks import address, view
from nonsmooth.scenes.detection import NOT_FINITE, Found
from nonsmooth.scenes.find_contacts import find_contacts
from nonsmooth.scenes.shape_rows import Shapes


@in_dimensions("int64(int64, int64)")
def take_steps(progress_at, most, d):
    """Take so many steps; how it comes back, DONE or why not."""
    progress = view(progress_at, Progress)
    bodies, network = view(progress.places.bodies, Bodies), view(progress.places.network, Network)
    for step in range(most):
        if is_asleep(bodies, progress):
            leave_out(network, view(progress.places.asleep, Asleep), most - step, progress)
            if view(progress.places.pairs, Pairs).is_asked == 1:
                repeat_pairs(progress.places.pairs, most - step)
            return DONE
        progress.is_resting = 0
        end = take_step(progress, d)
        if end != DONE:
            return end
        note_rest(bodies, network, progress)
        if progress.is_examined == 1:
            progress.is_examined = 0
            return EXAMINED
    return DONE


@kernel
def take_step(progress, d):
    """One step, in parts where a body lands within it, or what is left of one."""
    if progress.stage == PREDICT:
        begin(progress, progress.places, d)
    end = take_part(progress, d)
    while end == NEXT_PART:
        end = take_part(progress, d)
    return end


@kernel
def take_part(progress, d):
    """One step, or a part of one, or what is left of that."""
    places = progress.places
    network = view(places.network, Network)
    if progress.stage == PREDICT:
        predict(places.bodies, progress.dt, d)
        progress.stage = FIND
    if progress.stage == FIND:
        end = find(progress, places, network, d)
        if end != DONE:
            return end
        progress.stage, progress.speeds = SOLVE, 0
    if progress.stage == SOLVE:
        if progress.is_asked == 0:
            progress.is_asked = 1
            if progress.has_adhesion == 0 and progress.has_grain == 0 and has_doubts(places, progress, d):
                progress.is_examined = 1
                return DOUBTFUL
        end = solve(progress, places, network, d)
        if end == DONE and (progress.has_laws == 1 or progress.has_pins == 1 or progress.has_rolling == 1):
            end = find_speeds(progress, places, network, d)
        if end != DONE:
            return end
        if progress.may_divide == 1 and is_taken_again(progress, places):
            progress.stage = PREDICT
            return NEXT_PART
        progress.stage = DRAW
    if progress.stage == DRAW:
        if view(places.joints, Joints).count > 0:
            progress.wanted = draw_together(address(progress), d)
            if progress.wanted > 0:
                return MORE_FACTORS
            note_drift(places, network, progress.figures)
        move(progress, places, d)
        progress.stage = HOLD
    if progress.stage == HOLD:
        if view(places.joints, Joints).count > 0:
            progress.wanted = hold_places(address(progress), d)
            if progress.wanted > 0:
                return MORE_FACTORS
        end_step(progress, places, network, d)
        progress.stage = REBOUND if rebounds(progress, places, network, d) else PREDICT
    if progress.stage == REBOUND:
        if progress.has_impact_law == 1:
            progress.stage = STRUCK
            return BY_LAW
        end = solve(progress, places, network, d)
        if end != DONE:
            return end
        progress.counts.limited += limit_rebounds(places.bodies, places.contacts, places.network, d)
        note_together(places, progress.counts)
        progress.stage = STRUCK
    if progress.stage == STRUCK:
        size = book_impact(places.bodies, places.contacts, places.network, places.ledger)
        book_by_pairs(places, 1, False)
        note_gain(size, view(places.ledger, Ledger), progress)
        progress.stage = PREDICT
    note_held(places.bodies, places.found, places.contacts, places.network, progress.dt)
    if progress.left > 0.0:
        begin_next_part(progress, places)
        return NEXT_PART
    if progress.is_missed == 1:
        progress.is_missed = 0
        progress.counts.missed += 1
        if progress.is_strict == 1:
            return UNSOLVED
    return DONE


@kernel
def begin(progress, places, d):
    """Begin a step, which is whole until it is divided; wake what sleeps through steps of another length; say what is
    still."""
    progress.dt, progress.left = progress.whole, 0.0
    progress.parts, progress.divisions, progress.lets_in = 0, 0, 0
    progress.is_asked, progress.has_verdicts, progress.is_stroke = 0, 0, 0
    view(places.parts, Parts).n_c = 0
    bodies, asleep = view(places.bodies, Bodies), view(places.asleep, Asleep)
    if asleep.count > 0 and progress.dt != asleep.dt:
        wake_all(bodies, view(places.contacts, Contacts), asleep, (progress.dt, d))
    mark_guides(bodies, view(places.shapes, Shapes), asleep.count > 0)


@in_dimensions("void(int64, float64)")
def predict(bodies_at, dt, d):
    """The free motion of a step; bodies are put where their contacts are looked for."""
    bodies = view(bodies_at, Bodies)
    for b in range(bodies.mass.shape[0]):
        predict_body(bodies, b, dt, d)


@kernel
def find(progress, places, network, d):
    """The contacts of the step, and the rows of their problem."""
    dt = progress.dt
    end = find_among_awake(progress, places, network, d)
    if end != DONE:
        return end
    pairs = view(places.pairs, Pairs)
    if pairs.is_asked == 1 and pairs.count + network.n_c > pairs.i.shape[0]:
        progress.wanted = pairs.count + network.n_c
        return MORE_BOOKS
    write_contacts(places.bodies, places.shapes, places.surfaces, places.found, places.contacts, places.network, dt, d)
    if progress.has_grain == 1:
        turn_to_grain(places.bodies, places.surfaces, places.found, places.contacts, places.network, 0)
    hold(progress, places, 0, dt)
    prepare(places, d)
    if progress.divisions > 0:
        ask_of_landings(places.bodies, places.found, places.network, dt, progress.whole, progress.lets_in)
    elif progress.lands_whole == 1:
        land_whole(places.bodies, places.found, places.network, dt)
    approach = view(places.solver, Solver).approach
    ask_of_wandering(places.bodies, places.found, places.contacts, places.network, dt, approach)
    hold_closed(places.bodies, places.found, places.network, places.solver, dt, progress.tight)
    if progress.has_adhesion == 1:
        pull_together(places.bodies, places.shapes, places.surfaces, places.found, places.contacts, places.network, dt)
    if progress.has_laws == 1:
        take_friction(places.bodies, places.shapes, places.surfaces, places.found, places.contacts, places.network)
    return DONE


@kernel
def hold(progress, places, is_impact, dt):
    """The rows of rolling friction, drives, springs and joints, of a step or of its impact."""
    if progress.has_rolling == 1:
        write_rolling(
            places.bodies, places.shapes, places.surfaces, places.found, places.contacts, places.network, is_impact
        )
    if view(places.drives, Drives).count > 0:
        write_drives(places.drives, places.bodies, places.found, places.contacts, places.network, is_impact, dt)
    if view(places.springs, Springs).count > 0:
        write_springs(places.springs, places.bodies, places.found, places.contacts, places.network, is_impact, dt)
    if view(places.joints, Joints).count > 0:
        write_joints(places.joints, places.bodies, places.found, places.contacts, places.network, is_impact, dt)


@kernel
def find_among_awake(progress, places, network, d):
    """The contacts of what is awake, and of what they wake."""
    bodies, shapes, found = view(places.bodies, Bodies), view(places.shapes, Shapes), view(places.found, Found)
    contacts, asleep, joints = view(places.contacts, Contacts), view(places.asleep, Asleep), view(places.joints, Joints)
    springs, drives = view(places.springs, Springs), view(places.drives, Drives)
    others = joints.count + SIDES * springs.count + drives.count
    dt, margin, is_woken = progress.dt, margin_of(progress, bodies), True
    while is_woken:
        n = find_contacts(places.shapes, places.motion, dt, margin, places.found, places.scratch, d)
        if n == NOT_FINITE:
            return LOST
        if n < 0:
            progress.wanted = -n
            return MORE_PAIRS
        rolling = MOST_ROLLING * n if progress.has_rolling == 1 else 0
        if n + rolling + others + asleep.n_c > found.gap.shape[0]:
            progress.wanted = n + rolling + others + asleep.n_c
            return MORE_CONTACTS
        if progress.has_faces == 1:
            n = leave_out_hidden(places.shapes, places.motion, places.joints, places.links, places.found, n)
        if joints.apart > 0:
            n = leave_out_ignored(places.joints, places.shapes, places.found, n)
        if progress.has_rolling == 1:
            n = add_rolling(view(places.surfaces, Surfaces), found, n)
        if drives.count > 0:
            n = add_drives(drives, bodies.motion, found, margin, n)
        if springs.count > 0:
            n = add_springs(springs, bodies, found, n)
        if joints.count > 0:
            n = add_joints(joints, bodies.motion, found, n)
        network.n_c = n
        is_woken = asleep.count > 0 and wake_touched(bodies, shapes, found, n, contacts, asleep, (dt, d)) > 0
    return DONE


@kernel
def prepare(places, d):
    """What solvers need of the rows, at the present places."""
    if d == 3:
        turn_inertia(places.bodies, places.network)
    prepare_network(places.network, d)


@kernel
def has_doubts(places, progress, d):
    """Whether an island of few contacts, or a machine whose joints have friction, may have no solution, or several."""
    is_start = 1 if progress.counts.steps == 0 else 0
    few = find_doubtful(places.bodies, places.found, places.network, places.doubts, is_start, d)
    if progress.has_pins == 1 and few == 0:
        few = 1 + find_doubtful_machine(
            places.bodies, places.found, places.network, places.drives, places.bearings, 0, progress.dt, d
        )
    return few > 0


@kernel
def solve(progress, places, network, d):
    """The contact problem at hand; a problem that is not solved goes to Python once, for other solvers, and before that
    one that several threads are to solve."""
    if progress.is_tried == 0:
        if progress.is_shared == 0 and view(places.joints, Joints).count > 0:
            tree, tol = address(view(places.held, Held).tree), view(places.solver, Solver).tol
            solve_trees(places.network, tree, tol, 1, d)
        if progress.is_shared == 0 and are_worth_sharing(network.islands, progress):
            return TOGETHER
        if progress.is_shared == 0:
            progress.wanted = solve_network(places.network, places.solver, places.desk, d)
            if progress.wanted > 0:
                return MORE_FACTORS
        progress.is_shared = 0
        if not is_met(network):
            progress.is_tried = 1
            return NOT_MET
    progress.is_tried = 0
    asleep = view(places.asleep, Asleep)
    note_islands(network, asleep, progress)
    residual = judge_network(places.network, d)
    note_residual(residual, network, asleep, progress, d)
    return DONE


@kernel
def find_speeds(progress, places, network, d):
    """Solve again until friction is that of the velocities, and in joints of the load, which it leads to."""
    end, tol = DONE, view(places.solver, Solver).tol
    while end == DONE:
        change = UNCHANGED
        if progress.has_laws == 1:
            change = update_friction(
                places.bodies, places.shapes, places.surfaces, places.found, places.contacts, places.network, tol
            )
        if change >= 0 and progress.has_pins == 1:
            change |= rub_joints(
                places.drives, places.bodies, places.found, places.network, progress.dt, tol, progress.speeds
            )
        if change >= 0 and progress.has_rolling == 1:
            change |= limit_rolling(
                places.bodies, places.shapes, places.surfaces, places.found, places.network, tol, progress.speeds
            )
        if change < 0:
            progress.wanted, progress.stage = -1 - change, FIND
            return NO_FRICTION
        if change == UNCHANGED:
            break
        if progress.speeds == SPEED_SWEEPS:
            progress.is_missed = 1
            break
        progress.speeds += 1
        prepare(places, d)
        end = solve(progress, places, network, d)
    return end


@kernel
def move(progress, places, d):
    """The places after the step."""
    bodies, found, dt, theta = places.bodies, places.found, progress.dt, progress.theta
    progress.is_pushed = move_bodies(
        bodies, found, places.contacts, places.network, places.moves, dt, theta, progress.tight, d
    )


@kernel
def end_step(progress, places, network, d):
    """The energy of the step and its figures."""
    asleep, bodies, found, dt = view(places.asleep, Asleep), places.bodies, places.found, progress.dt
    deepest = min(deepest_gap(view(found, Found), network.n_c), asleep.deepest)
    left = view(places.drives, Drives).slack
    if progress.has_rolling == 1:
        left -= count_rolling(view(found, Found).key, network.n_c) + count_rolling(asleep.key, asleep.n_c)
    note_step(network, asleep, deepest, left, progress)
    if progress.may_sleep == 1 and progress.parts == 0:
        let_sleep(bodies, found, places.network, places.moves, places.solver, places.asleep, dt)
    book_step(bodies, found, places.contacts, places.network, places.moves, places.ledger, dt, progress.is_pushed)
    book_by_pairs(places, 0, progress.parts <= 1)
    if progress.has_adhesion == 1:
        book_pulls(places.bodies, places.contacts, places.network, places.pairs, places.ledger)
    if d == 3:
        of_bodies = view(bodies, Bodies)
        take_spins(of_bodies, of_bodies.motion.v)
    note_turns(view(bodies, Bodies), view(places.shapes, Shapes), network, dt, progress)


@kernel
def book_by_pairs(places, is_impact, is_first):
    """Book what each joint did, and each pair of bodies, where that is asked for; of the first problem of a step, with
    what sleeps."""
    if view(places.joints, Joints).count + view(places.drives, Drives).count > 0:
        step = 1 if is_first else 0
        book_reactions(places.joints, places.drives, places.found, places.network, places.reactions, step)
    if view(places.pairs, Pairs).is_asked == 1:
        book_pairs(
            places.bodies, places.found, places.network, places.asleep, places.pairs, is_impact, 1 if is_first else 0
        )


@kernel
def note_drift(places, network, figures):
    """How far the points of a joint were apart at the beginning of the step."""
    first = first_joint(view(places.found, Found), network)
    figures.last_drift = largest_drift(view(places.contacts, Contacts), network, first)
    figures.drift = max(figures.drift, figures.last_drift)


@kernel
def rebounds(progress, places, network, d):
    """Whether contacts rebound; then the problem of their impact is written."""
    if progress.has_restitution == 0 or network.n_c == 0:
        return False
    book_landing(places.bodies, places.contacts, places.network, places.ledger)
    bodies, shapes, found, contacts = places.bodies, places.shapes, places.found, places.contacts
    count = begin_impact(bodies, shapes, found, contacts, places.network, progress.dt, progress.whole, d)
    if count == 0:
        return False
    if progress.has_grain == 1:
        turn_to_grain(places.bodies, places.surfaces, places.found, places.contacts, places.network, 1)
    hold(progress, places, 1, progress.dt)
    prepare(places, d)
    if progress.has_impact_law == 0:
        ask_rebounds(places.contacts, places.network)
    progress.counts.impacts += 1
    return True
