"""One source, two speeds: kernels run by the interpreter give the bits of the compiled ones.

Both do the same operations in the same order: compiled code is not allowed to rearrange a sum or to fuse a product into
it, and both call the same libm (kernels write x * x and sqrt: x ** 2 is rounded otherwise by the interpreter). So
nothing may differ, not even by rounding. The interpreter refuses an index beyond the end of an array, and coverage
counts the lines of the kernels that it comes through; CONTRIBUTING.md has the command.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import numba
import numpy as np
import pytest
from scipy import sparse

import nonsmooth as ns
from benchmarks import contact_scenes, core_scenes, stress_random, stress_scenes
from models import (
    BeadChain,
    BeltOscillator,
    BouncingBall,
    ModeCoupling,
    PainleveRod,
    RockingBlock,
    SelfLockingRod,
    SlidingBlock,
    SpatialPainleveRod,
    SpragSlip,
    Woodpecker,
)
from nonsmooth.commands.solve_files import load_problem
from nonsmooth.contact.blocks.solve import SOLVERS as CONTACT_SOLVERS
from nonsmooth.integrators.springs.steps import SpringPlaces
from nonsmooth.jit import Kernel, blocks, interpreted
from nonsmooth.lcp.solve import SOLVERS as LCP_SOLVERS
from tests.integrators.test_several_impacts_with_friction import feet

pytestmark = pytest.mark.upkeep

DATA = Path(__file__).parent / "data"


@contextmanager
def interpreter() -> Iterator[None]:
    """No kernel is compiled or called compiled in here."""
    with pytest.MonkeyPatch.context() as patch, np.errstate(all="ignore"):
        patch.setenv("NONSMOOTH_INTERPRET", "1")
        patch.setattr(blocks.Block, "address", property(lambda block: block), raising=False)  # it knows none
        patch.setattr(Kernel, "compiled", property(interpreted))
        patch.setattr(Kernel, "is_loaded", property(lambda kernel: True))
        yield


def differing(compiled, twin, names):
    """The names of the results that have not the same bits; NaN is equal to itself."""
    return [name for name in names if bits(getattr(compiled, name)) != bits(getattr(twin, name))]


def bits(value):
    return value if isinstance(value, str) else np.asarray(value).tobytes()


# runs

INTEGRATORS = [
    ns.MoreauJean(2e-3), ns.EventDriven(1e-4, 1e-5), ns.Adaptive(1e-4),
    ns.Penalty(1e4, damping_ratio=0.5, rtol=1e-4, atol=1e-5),
]  # fmt: skip
RECORDS = ("t", "q", "u", "P_N", "P_F", "g_N", "mode", "slip")


def scene(system, u0, t_end):
    return system, np.zeros(system.n_q), np.asarray(u0, dtype=float), t_end, "compliant-limit"


def of_model(model, t_end, **state):
    return model, *model.state(**state), t_end, "compliant-limit"


def guide():
    """A block of 1 kg in a guide, pushed along; the force across changes its sign twice about t = 0.6 s."""

    def mass(t, q, p, M):
        M[0, 0] = M[1, 1] = 1.0

    def force(t, q, u, p, h):
        h[0], h[1] = 0.02, 0.7 + np.cos(5 * t)

    def gap(t, q, p, g):
        g[0] = q[1]

    def normal(t, q, p, W):
        W[0, 1] = 1.0

    def tangent(t, q, p, W):
        W[0, 0, 0] = 1.0

    contacts = [ns.Contact(mu=0.3, bilateral=True)]
    return ns.System(n_q=2, mass=mass, force=force, gap=gap, normal=normal, tangent=tangent, contacts=contacts)


def random_system(seed):
    s = stress_random.sample(seed)
    return s.system, s.q0, s.u0, 0.1, s.selection


SCENES = {
    "ball": of_model(BouncingBall(e=0.5), 0.5),
    "sliding rod": of_model(PainleveRod(mu=0.3), 0.05),
    "sprag slip": of_model(SpragSlip(), 0.05),
    "rocking block": of_model(RockingBlock(), 0.1),
    "beads": of_model(BeadChain(n=3), 0.01),
    "woodpecker": of_model(Woodpecker(), 0.02),
    "belt": of_model(BeltOscillator(), 0.1),
    "box on three points": scene(stress_scenes.box_on([-0.2, 0.0, 0.2]), [0.5, 0, 0, 0], 0.02),
    "stack of two": scene(stress_scenes.stack(2, stress_scenes.Tower()), [0, 0, 0, 0.3, 0, 0], 0.01),
    "guide": scene(guide(), [0, 0], 1.0),
    "groove": scene(stress_scenes.groove(0.3, mu=0.2), [0.1, 0, 0, 0], 0.02),
    **{f"random system {seed}": random_system(seed) for seed in (1, 2, 3)},
}


@pytest.mark.parametrize("integrator", INTEGRATORS, ids=lambda i: type(i).__name__)
@pytest.mark.parametrize("name", SCENES)
def test_a_run_has_the_same_bits_at_both_speeds(name, integrator):
    compare_runs(SCENES[name], integrator)


FEET = {
    "block of five feet that lands": (
        contact_scenes.block(5, contact_scenes.Block(e=0.3)),
        np.array([0.0, 0.03, 0.05]),
        np.array([0.5, 0.0, 0.0]),
        0.15,
        "compliant-limit",
    ),
    "block of five feet on a shaken floor": scene(
        contact_scenes.block(5, contact_scenes.Block(v=0.5)), [0.0, 0.0, 0.0], 0.05
    ),
    "block that strikes a wall with two of six contacts": scene(
        contact_scenes.block(6, contact_scenes.Block(push=5.0, walls=2.0)), [-0.3, 0.0, 0.0], 0.03
    ),
}


@pytest.mark.filterwarnings("ignore::nonsmooth.SimultaneousImpactWarning")  # what is asked holds for it too
@pytest.mark.parametrize("name", FEET)
def test_steps_of_a_block_on_many_feet_have_the_same_bits_at_both_speeds(name):
    compare_runs(FEET[name], ns.MoreauJean(2e-3))


def compare_runs(scene, integrator, **options):
    system, q0, u0, t_end, selection = scene
    run = dict(t_span=(0, t_end), q0=q0, u0=u0, integrator=integrator, selection=selection, on_failure="return")
    compiled = ns.simulate(system, **run, **options)
    with interpreter():
        twin = ns.simulate(system, **run, **options)
    assert compiled.stats.is_compiled and not twin.stats.is_compiled
    assert (twin.status, twin.events, twin.paradoxes) == (compiled.status, compiled.events, compiled.paradoxes)
    assert not differing(compiled, twin, RECORDS)
    return compiled


@pytest.mark.parametrize("integrator", INTEGRATORS, ids=lambda i: type(i).__name__)
def test_records_within_the_steps_have_the_same_bits_at_both_speeds(integrator):
    compare_runs(of_model(BouncingBall(e=0.5), 0.5), integrator, t_eval=np.linspace(0.0, 0.5, 8))


def sliding_block(**contact):
    system = SlidingBlock().system()
    return scene(replace(system, contacts=[ns.Contact(**contact)]), [0.3, 0.0], 0.1)


LAWS = [
    ns.Polynomial(m0=0.4, m1=0.2, m3=0.1), ns.Stribeck(mu_s=0.5, mu_k=0.3, v_s=0.1, delta=2.0, m_v=0.01),
    ns.StaticKinetic(mu_s=0.5, mu_k=0.3),
]  # fmt: skip


@pytest.mark.parametrize("integrator", INTEGRATORS, ids=lambda i: type(i).__name__)
@pytest.mark.parametrize("law", LAWS, ids=lambda law: type(law).__name__)
def test_friction_that_varies_has_the_same_bits_at_both_speeds(law, integrator):
    compare_runs(sliding_block(mu=law), integrator)


def falling_rod(impact):
    rod = PainleveRod(mu=0.5)
    q0, u0 = rod.state(th=1.0, thdot=0.5, slip=0.4)
    start = q0 + [0.0, 1e-3, 0.0], u0 - [0.0, 1.0, 0.0]
    system = replace(rod.system(), contacts=[ns.Contact(mu=0.5, e_N=0.5, impact=impact)])
    return system, *start, 0.01, "compliant-limit"


@pytest.mark.parametrize("integrator", INTEGRATORS[:3], ids=lambda i: type(i).__name__)
@pytest.mark.parametrize("impact", ["poisson", "energetic"])
def test_other_laws_of_impact_have_the_same_bits_at_both_speeds(impact, integrator):
    compare_runs(falling_rod(impact), integrator)


@pytest.mark.parametrize("u", [[3.0, -1.0, 0.4], [0.1, -1.0, 0.0]], ids=["slides", "sticks"])
def test_contacts_struck_together_by_the_energetic_law_have_the_same_bits_at_both_speeds(u):
    compare_runs((feet(0.5, 0.6, "energetic"), np.zeros(3), np.array(u), 2e-3, "compliant-limit"), ns.MoreauJean(1e-3))


PARADOX = of_model(PainleveRod(mu=2.0), 0.02, th=1.0, thdot=4.0, slip=-1.0)  # three solutions
FEATURES = {
    "positions projected": (SCENES["rocking block"], ns.MoreauJean(2e-3, projection=True)),
    "bilateral position projected": (SCENES["sprag slip"], ns.MoreauJean(2e-3, projection=True)),
    "compliance": (SCENES["stack of two"], ns.MoreauJean(2e-3, theta=1.0, compliance=ns.Compliance(1e6, 10.0))),
    "theta = 1": (SCENES["sprag slip"], ns.MoreauJean(2e-3, theta=1.0)),
    "indentations by Hunt and Crossley": (
        SCENES["ball"], ns.Penalty(1e4, damping=10.0, law="hunt-crossley", rtol=1e-4, atol=1e-5),
    ),
    "regularised friction": (
        SCENES["sliding rod"],
        ns.Penalty(1e4, damping_ratio=0.5, friction=ns.Regularised(0.1), rtol=1e-4, atol=1e-5),
    ),
    **{f"paradox, {type(i).__name__}": (PARADOX, i) for i in INTEGRATORS},
    "lift-off chosen": (PARADOX[:4] + ("lift-off",), INTEGRATORS[0]),
    "impact chosen": (PARADOX[:4] + ("impact",), INTEGRATORS[1]),
    "sticks in space": (of_model(SpatialPainleveRod(mu=0.6), 0.05, th=1.3, phi=2.0, slip=0.2), INTEGRATORS[1]),
    "impact without collision in space": (of_model(SpatialPainleveRod(mu=2.0), 0.01, th=1.0), INTEGRATORS[1]),
    "no solution": (of_model(SelfLockingRod(mu=1.0, th0=0.9), 0.02, th=0.9), INTEGRATORS[0]),
    "accumulation of impacts": (of_model(BouncingBall(e=0.3), 0.3, height=0.01), INTEGRATORS[1]),
    "accumulation of impacts, extrapolated": (of_model(BouncingBall(e=0.3), 0.3, height=0.01), INTEGRATORS[2]),
    "given normal force": (of_model(ModeCoupling(), 0.05), INTEGRATORS[0]),
    "row of five blocks": (
        scene(core_scenes.row_of_blocks(5), [0.3, 0, -0.2, 0, 0, 0, 0.1, 0, 0, 0], 0.01), INTEGRATORS[0],
    ),
    "tower of four": (
        scene(stress_scenes.tower(4, stress_scenes.Tower()), [0, 0, 0.2, 0, 0, 0, 0.1, 0], 0.01), INTEGRATORS[0],
    ),
    "jacobians by differences": (
        (replace(SpragSlip().system(), stiffness="differences", damping=None), *SCENES["sprag slip"][1:]),
        INTEGRATORS[0],
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", FEATURES)
def test_what_an_integrator_can_do_has_the_same_bits_at_both_speeds(name):
    compare_runs(*FEATURES[name])


@pytest.mark.parametrize("integrator", INTEGRATORS, ids=lambda i: type(i).__name__)
@pytest.mark.parametrize("law", LAWS[:2], ids=lambda law: type(law).__name__)
def test_two_blocks_under_different_laws_have_the_same_bits_at_both_speeds(law, integrator):
    system = replace(core_scenes.row_of_blocks(2), contacts=[ns.Contact(mu=law), ns.Contact(mu=0.2)])
    compare_runs(scene(system, [0.3, 0.0, -0.2, 0.0], 0.01), integrator)


@contextmanager
def blocks_in_place_of_addresses(places: type) -> Iterator[None]:
    """A block of addresses holds the blocks themselves."""
    held: dict[str, Any] = {}
    with pytest.MonkeyPatch.context() as patch:
        for name in places.__annotations__:
            patch.setattr(places, name, property(
                lambda _, name=name: held[name], lambda _, block, name=name: held.__setitem__(name, block)
            ))  # fmt: skip
        yield


def on_the_ground(dim, mu=0.3):
    """A disc, or a ball, that slides into a box on the ground."""
    bodies = ns.Scene(gravity=(0,) * (dim - 1) + (-9.81,), material=ns.Material(mu=mu))
    bodies.fixed(ns.HalfPlane((0, 1)) if dim == 2 else ns.HalfSpace((0, 0, 1)), name="ground")
    up, along = np.eye(dim)[-1], np.eye(dim)[0]
    round_one, box = (ns.Disc(0.1), ns.Box(0.2, 0.2)) if dim == 2 else (ns.Sphere(0.1), ns.Box(0.2, 0.2, 0.2))
    bodies.body(round_one, mass=1.0, position=0.1 * up, velocity=along, name="ball")
    bodies.body(box, mass=2.0, position=0.1 * up + 0.201 * along, name="box")
    return bodies


@pytest.mark.parametrize("law", [
    ns.Penalty(1e4, damping_ratio=0.5, rtol=1e-3, atol=1e-4),
    ns.Penalty(1e4, damping=10.0, rtol=1e-3, atol=1e-4, friction=ns.Regularised(0.1)),
], ids=["springs", "regularised"])  # fmt: skip
@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.filterwarnings("ignore::nonsmooth.PenetrationWarning")
def test_springs_of_a_scene_have_the_same_bits_at_both_speeds(dim, law):
    """Landing, sliding, pushing and sticking; room for contacts is made anew on the way."""
    run = {"integrator": law, "record": ("bodies", "contacts", "ledger", "pairs")}
    compiled = ns.simulate(on_the_ground(dim), (0, 0.015), **run)
    with interpreter(), blocks_in_place_of_addresses(SpringPlaces):
        twin = ns.simulate(on_the_ground(dim), (0, 0.015), **run)
    assert compiled.stats.most_contacts > dim and compiled.stats.steps > 5
    assert not differing(compiled, twin, ("t", "position", "turn", "velocity", "spin", "penetration"))
    assert not [name for name in compiled.ledger if bits(compiled.ledger[name]) != bits(twin.ledger[name])]
    for rows in ("all_contacts", "pairs"):
        one, other = (getattr(run, rows).columns for run in (compiled, twin))
        assert len(one["i"]) > 0 and not [name for name in one if bits(one[name]) != bits(other[name])]


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.filterwarnings("ignore::nonsmooth.PenetrationWarning")
def test_what_holds_bodies_on_springs_has_the_same_bits_at_both_speeds(dim):
    """A joint, its limit, a spring, a function as a force and a law of friction."""
    law = ns.Penalty(1e4, damping_ratio=0.5, rtol=1e-3, atol=1e-4)
    scene = on_the_ground(dim, ns.Stribeck(mu_s=0.5, mu_k=0.2, v_s=0.5))
    up, axis = np.eye(dim)[-1], {} if dim == 2 else {"axis": (0, 1, 0)}
    shape = ns.Box(0.4, 0.02) if dim == 2 else ns.Box(0.4, 0.02, 0.02)
    scene.body(shape, mass=1.0, position=0.5 * up, spin=1.0 if dim == 2 else (0, 1.0, 0), name="arm")
    scene.hinge("ground", "arm", at=0.5 * up, limits=(-1.0, 0.01), name="pin", **axis)
    scene.spring("arm", "ball", stiffness=30.0, damping=1.0, length=0.2)
    scene.force("box", lambda t, bodies: np.eye(dim)[0] * t)
    run = {"integrator": law, "record": ("bodies", "contacts", "ledger")}
    compiled = ns.simulate(scene, (0, 0.02), **run)
    with interpreter(), blocks_in_place_of_addresses(SpringPlaces):
        twin = ns.simulate(scene, (0, 0.02), **run)
    assert compiled.stats.steps > 5 and abs(compiled.joint("pin").L[-1]).max() > 0.0
    names = ("t", "position", "turn", "velocity", "spin", "penetration", "joint_impulses", "joint_torques")
    assert not differing(compiled, twin, names)
    assert not [name for name in compiled.ledger if bits(compiled.ledger[name]) != bits(twin.ledger[name])]


def that_fails(function):
    """The function of a model, which writes NaN from t = 4 ms on."""
    good = numba.njit(function)

    def with_u(t, q, u, p, out):
        good(t, q, u, p, out)
        if t > 4e-3:
            out[:] = np.nan

    def without_u(t, q, p, out):
        good(t, q, p, out)
        if t > 4e-3:
            out[:] = np.nan

    return with_u if function.__code__.co_argcount == 5 else without_u


# The time steps know no accelerations, and a compliant contact carries its indentation along.
UNREAD = {("row_rates", "MoreauJean"), ("gap", "Penalty")}


@pytest.mark.parametrize("integrator", INTEGRATORS, ids=lambda i: type(i).__name__)
@pytest.mark.parametrize(("model", "name"), [
    *((PainleveRod(mu=0.3), name) for name in ("mass", "force", "gap", "normal", "tangent", "row_rates")),
    *((BeltOscillator(), name) for name in ("surface_velocity", "normal_force")),
], ids=lambda given: given if isinstance(given, str) else given.name)  # fmt: skip
def test_a_function_that_fails_ends_both_runs_at_the_same_bits_and_is_named(model, name, integrator):
    system = model.system()
    failing = replace(system, **{name: that_fails(getattr(system, name))})
    compiled = compare_runs((failing, *model.state(), 0.01, "compliant-limit"), integrator)
    if (name, type(integrator).__name__) in UNREAD:
        assert compiled.success
    else:
        assert compiled.status == ns.Status.NOT_FINITE and f"the model function {name} wrote nan" in compiled.message


def swept():
    axes = {"e": [0.2, 0.8], "height": [0.0, 0.1]}
    found = ["final_state", "amplitude", "modes", "impacts", "residual"]
    return ns.sweep(ns.RunTask(BouncingBall(), found, t_span=(0, 0.2), integrator=INTEGRATORS[0]), axes, progress=False)


@pytest.mark.filterwarnings("ignore::nonsmooth.UnsettledWarning")
def test_cells_of_a_sweep_have_the_same_bits_at_both_speeds():
    compiled = swept()
    with interpreter():
        assert compiled.equals(swept())


@pytest.mark.parametrize(("rod", "axes"), [
    (PainleveRod(), {"th": np.linspace(0.3, 1.4, 4), "mu": [0.5, 2.0], "slip": [-1.0, 0.0, 1.0]}),
    (SpatialPainleveRod(), {"th": np.linspace(0.3, 1.4, 4), "phi": [-0.9, 0.3], "slip": [0.0, 1.0], "mu": [0.5, 2.0]}),
], ids=["plane", "space"])  # fmt: skip
def test_cells_of_a_map_have_the_same_bits_at_both_speeds(rod, axes):
    compiled = ns.paradox_map(rod, **axes)
    with interpreter():
        assert compiled.equals(ns.paradox_map(rod, **axes))


# contact problems, complementarity problems, paradoxes

FILES = {
    "fc": sorted(DATA.glob("fc*/*.npz")),
    "lcp": sorted(DATA.glob("lcp/*.npz")),
}
# Python rounds math.hypot better than libm does: the starting points of the interior point differ by EPS. Close to the
# boundary of the cones its systems have condition numbers of 1/tol = 1e8, and EPS grows to HYPOT.
HYPOT = np.finfo(float).eps * 1e8
LARGEST = 20  # unknowns: the interpreter takes seconds for more


def problems(kind):
    for path in FILES[kind]:
        _, matrix, arguments = load_problem(path)
        if matrix.shape[0] > LARGEST:
            continue
        yield arguments
        if kind == "lcp":
            yield sparse.csr_array(arguments[0]), arguments[1]
            continue
        G, c, mu, dim = arguments
        yield G, c, 0.0 * mu, dim
        if path.name.startswith("Confeti"):  # six times: more than 60 unknowns, most of them uncoupled, are kept sparse
            yield sparse.kron(np.eye(6), G).tocsr(), np.tile(c, 6), np.tile(mu, 6), dim


def answer(solve, arguments, solver):
    """The result, or the refusal of a problem that the solver does not take."""
    try:
        return solve(*arguments, solver=solver)
    except ns.InvalidInput as refusal:
        return str(refusal)


@pytest.mark.parametrize(("kind", "solver"), [
    *(("fc", name) for name in ("auto", *CONTACT_SOLVERS)), *(("lcp", name) for name in ("auto", *LCP_SOLVERS)),
])  # fmt: skip
def test_a_solver_gives_the_same_bits_at_both_speeds(kind, solver):
    solve, names = {
        "fc": (ns.solve_contact, ("P", "gamma", "status", "error", "iterations", "solver")),
        "lcp": (ns.solve_lcp, ("z", "w", "status", "residual", "iterations", "solver")),
    }[kind]
    taken = 0
    for arguments in problems(kind):
        compiled = answer(solve, arguments, solver)
        with interpreter():
            twin = answer(solve, arguments, solver)
        if isinstance(compiled, str):
            assert twin == compiled
            continue
        taken += 1
        apart = differing(compiled, twin, names)
        if (kind, solver) == ("fc", "interior"):
            assert set(apart) <= {"P", "gamma", "error"}
            assert np.abs(twin.gamma - compiled.gamma).max() < 100 * HYPOT * np.abs(arguments[1]).max()
        else:
            assert not apart
    assert taken > 0


STATES = {
    "rod that slides into a paradox": (PainleveRod(mu=2.0), PainleveRod(mu=2.0).state(th=0.9, thdot=-3.0, slip=1.0)),
    "sprag slip": (SpragSlip(), SpragSlip().state()),
    "block on two corners": (RockingBlock(), RockingBlock().state(tilt=0.0)),
    **{name: (SCENES[name][0], SCENES[name][1:3]) for name in ("box on three points", "stack of two")},
}


@pytest.mark.parametrize("name", STATES)
def test_the_solutions_of_a_state_have_the_same_bits_at_both_speeds(name):
    system, (q, u) = STATES[name]
    compiled = ns.classify(system, 0.0, q, u)
    with interpreter():
        twin = ns.classify(system, 0.0, q, u)
    assert compiled.n_solutions == twin.n_solutions and repr(twin) == repr(compiled)


def test_all_solutions_of_a_complementarity_problem_have_the_same_bits_at_both_speeds():
    A = np.array([[1.0, -3.0, 0.0], [-3.0, 1.0, 0.5], [0.0, 0.5, 1.0]])
    for b in ([1.0, 1.0, -1.0], [-1.0, -1.0, -1.0], [0.0, 0.0, 0.0]):
        compiled = ns.lcp_solutions(A, b)
        with interpreter():
            twin = ns.lcp_solutions(A, b)
        assert repr(twin) == repr(compiled)


def test_a_large_sparse_problem_has_the_same_bits_at_both_speeds():
    A = sparse.diags_array([np.full(899, -1.0), np.full(900, 2.5), np.full(899, -1.0)], offsets=[-1, 0, 1]).tocsr()
    b = np.sin(np.arange(900.0))
    compiled = ns.solve_lcp(A, b, solver="pgs")
    with interpreter():
        twin = ns.solve_lcp(A, b, solver="pgs")
    assert compiled.success and not differing(compiled, twin, ("z", "w", "status", "residual", "iterations"))
