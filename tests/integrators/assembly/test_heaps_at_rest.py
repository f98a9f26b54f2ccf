"""Heaps of more bodies than are solved to rounding in any case come to rest to the last bit, and stay there."""

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.integrators.assembly.held_closed import DRAWN_TOGETHER, hold_closed
from nonsmooth.jit import interpreted
from nonsmooth.runs.scene_run import SceneRun

G, DT, BOXES = 9.81, 2e-3, 60
pytestmark = [
    pytest.mark.filterwarnings("ignore::nonsmooth.errors.ResidualWarning"),
    pytest.mark.filterwarnings("ignore::nonsmooth.errors.PenetrationWarning"),
]


def box_heap(seed, boxes=BOXES, a_row=15):
    """Boxes at random that fall between two walls."""
    pitch, rng = 0.15, np.random.default_rng(seed)
    scene = ns.Scene(gravity=(0, -G), material=ns.Material(mu=0.5))
    scene.fixed(ns.HalfPlane((0, 1)), name="floor")
    for side in (1, -1):
        scene.fixed(ns.HalfPlane((side, 0), -0.5 * pitch * a_row), name=f"wall {side}")
    for k in range(boxes):
        place = pitch * np.array([k % a_row - 0.5 * (a_row - 1), k // a_row + 0.5]) + rng.uniform(-0.01, 0.01, 2)
        scene.body(ns.Box(0.1, 0.07), density=1000, position=place, turn=rng.uniform(0, 3))
    return scene


def assembly_after(seed, steps, **options):
    """The steps of such a heap after some have been taken."""
    solver = ns.ContactSolver(**options)
    run = SceneRun(box_heap(seed), (0.0, DT), ns.MoreauJean(DT, contacts=solver), 1, None)
    run.assembly.take_steps(DT, steps)
    return run.assembly


@pytest.mark.upkeep
def test_most_heaps_of_boxes_come_to_rest_and_sleep():
    """A heap that rests has no velocity at all, is solved to rounding, and its floor carries its weight."""
    resting = 0
    for seed in (1, 5, 7, 8):
        sol = ns.simulate(box_heap(seed), (0, 3.0), integrator=ns.MoreauJean(DT), every=50)
        if sol.stats.asleep > 0:
            resting += 1
            assert (sol.velocity[-1] == 0.0).all() and sol.residual[-1] < 1e-14
            assert (sol.position[-1] == sol.position[-3]).all()
    assert resting >= 3


@pytest.mark.slow
def test_every_other_heap_of_400_boxes_sleeps_within_three_seconds():
    """Their last penetrations, of 1e-7 m, are taken back in 100 to 200 steps, each solved to rounding by factors. Of 24
    heaps 11 to 13 do; which ones a rounding decides."""
    asleep = 0
    for seed in range(8):
        run = SceneRun(box_heap(seed, boxes=400, a_row=20), (0.0, DT), ns.MoreauJean(DT), 1, None)
        run.assembly.take_steps(DT, 1400)
        moving = run.assembly.bodies.motion.moves == 1
        if run.assembly.network.islands.count == 0 or run.assembly.progress.is_resting:
            asleep += 1
            assert not run.assembly.bodies.motion.v[moving].any()
            assert run.assembly.progress.figures.last_penetration <= run.assembly.progress.tight
    assert asleep >= 3


def test_floor_and_walls_carry_the_weight_of_a_heap_at_rest():
    assembly = assembly_after(8, 1500, may_sleep=False)
    network, n_c = assembly.network, int(assembly.network.n_c)
    fixed, up = network.M_inv[:, 0, 0] == 0.0, 0.0
    for c in range(n_c):
        for body, J in ((network.i[c], network.J_i[c]), (network.j[c], network.J_j[c])):
            up -= J[:, 1] @ network.P[c] if fixed[body] else 0.0
    weight = assembly.bodies.mass[~fixed].sum() * G * DT
    assert not assembly.bodies.motion.v.any()
    assert abs(up - weight) <= 1e-12 * weight  # sums of some hundred impulses, solved to 1e-14


def test_two_threads_bring_a_heap_to_the_same_rest():
    runs = [ns.simulate(box_heap(8), (0, 1.6), integrator=ns.MoreauJean(DT), threads=n, every=100) for n in (1, 2)]
    assert (runs[0].position == runs[1].position).all() and (runs[0].velocity == runs[1].velocity).all()


@pytest.mark.upkeep
@pytest.mark.parametrize("changed", ["nothing", "a coarse tolerance", "a wider gap", "no impulse", "no penetration"])
def test_a_gap_is_held_where_a_heap_that_penetrates_is_pressed_and_a_fine_residual_is_asked_for(changed):
    assembly = assembly_after(1, 400)
    network, found, solver, tight = assembly.network, assembly.found, assembly.solver, float(assembly.progress.tight)
    islands = network.islands
    k = int(np.argmax(np.diff(islands.body_start[: int(islands.count) + 1])))
    contacts = islands.contacts[islands.contact_start[k] : islands.contact_start[k + 1]]
    pressed = contacts[network.P[contacts, 0] > 0.0]
    c, deep = pressed[0], pressed[1]
    found.gap[contacts] = np.maximum(found.gap[contacts], 0.0)
    found.gap[deep] = 0.0 if changed == "no penetration" else -10 * tight
    found.gap[c] = 1e-6 if changed == "a wider gap" else 1e-8
    network.b[c, 0] = found.gap[c] / DT
    if changed == "a coarse tolerance":
        solver.tol = 1e-5
    if changed == "no impulse":
        network.P[c] = 0.0
    asked = network.b[c, 0]
    interpreted(hold_closed)(assembly.bodies, found, network, solver, DT, tight)
    assert network.b[c, 0] == (0.0 if changed == "nothing" else asked) and asked > 0.0


@pytest.mark.parametrize(
    "steps, held", [(0, (0, 0)), (1, (1, 1)), (DRAWN_TOGETHER, (1, 1)), (DRAWN_TOGETHER + 1, (1, 0))]
)
def test_gaps_that_cannot_all_close_are_held_without_penetration_and_the_widest_let_go_in_the_end(steps, held):
    assembly = assembly_after(1, 400)
    network, found, solver, tight = assembly.network, assembly.found, assembly.solver, float(assembly.progress.tight)
    pressed = np.flatnonzero(network.P[: network.n_c, 0] > 0.0)[:2]
    found.gap[: network.n_c] = 0.0
    found.gap[pressed] = 1e-9, 1e-8
    network.b[pressed, 0] = found.gap[pressed] / DT
    solver.contradicted = steps
    interpreted(hold_closed)(assembly.bodies, found, network, solver, DT, tight)
    np.testing.assert_array_equal(network.b[pressed, 0] == 0.0, held)
    assert solver.contradicted == {0: 0, DRAWN_TOGETHER + 1: 1}.get(steps, steps + 1)
    found.gap[pressed] = 0.5 * tight
    interpreted(hold_closed)(assembly.bodies, found, network, solver, DT, tight)
    assert solver.contradicted == 0


@pytest.mark.slow
def test_heaps_whose_gaps_contradict_one_another_come_to_rest():
    """Where none of their gaps was held without penetration they were asked to close and opened again, in turns, and
    where none was let go some were held for ever. Half of the heaps or more rest after 1100 to 2000 steps, others hold
    such gaps on; which ones a rounding decides."""
    resting = 0
    for seed in (11, 13, 15, 17):
        run = SceneRun(box_heap(seed, boxes=400, a_row=20), (0.0, DT), ns.MoreauJean(DT), 1, None)
        run.assembly.take_steps(DT, 2000)
        resting += run.assembly.progress.is_resting == 1 or run.assembly.network.islands.count == 0
        if resting == 2:
            return
    pytest.fail(f"{resting} of 4 heaps rest")


def test_few_bodies_have_no_gap_held():
    scene = ns.Scene(gravity=(0, -G), material=ns.Material(mu=0.5))
    scene.fixed(ns.HalfPlane((0, 1)))
    for k in range(5):
        scene.body(ns.Box(0.1, 0.1), density=1000, position=(0.0, 0.05 + 0.1 * k))
    assembly = SceneRun(scene, (0.0, DT), ns.MoreauJean(DT), 1, None).assembly
    assembly.take_steps(DT, 1)
    network, found = assembly.network, assembly.found
    found.gap[0], found.gap[1], network.b[1, 0] = -1e-6, 1e-9, 1e-9 / DT
    assert network.P[1, 0] > 0.0
    interpreted(hold_closed)(assembly.bodies, found, network, assembly.solver, DT, 1e-11)
    assert network.b[1, 0] == 1e-9 / DT
