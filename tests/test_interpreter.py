"""One source, two speeds: kernels run by the interpreter give the bits of the compiled ones.

Both do the same operations in the same order: compiled code is not allowed to rearrange a sum or to fuse a product into
it, and both call the same libm (kernels write x * x and sqrt: x ** 2 is rounded otherwise by the interpreter). So
nothing may differ, not even by rounding. The interpreter refuses an index beyond
the end of an array, and it counts the lines that it comes through; CONTRIBUTING.md has the command.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

import nonsmooth as ns
from models import BeadChain, BeltOscillator, BouncingBall, PainleveRod, RockingBlock, SpragSlip, Woodpecker
from nonsmooth import blocks
from nonsmooth.bench import stress_random, stress_scenes
from nonsmooth.contact_solvers.solve import SOLVERS as CONTACT_SOLVERS
from nonsmooth.jit import Kernel, interpreted
from nonsmooth.lcp.solve import SOLVERS as LCP_SOLVERS
from nonsmooth.studies.solve_files import load_problem

DATA = Path(__file__).parent / "data"


class ArraysForAddress(blocks.Block):
    """A block that kernels are handed as arrays: the interpreter knows no addresses."""

    def __init__(self, *layout):
        super().__init__(*layout)
        self.address = self.arrays


@contextmanager
def interpreter() -> Iterator[None]:
    """No kernel is compiled or called compiled in here."""
    with pytest.MonkeyPatch.context() as patch, np.errstate(all="ignore"):
        patch.setenv("NONSMOOTH_INTERPRET", "1")
        patch.setattr(blocks, "Block", ArraysForAddress)
        patch.setattr(Kernel, "dispatcher", property(interpreted))
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
    "groove": scene(stress_scenes.groove(0.3, mu=0.2), [0.1, 0, 0, 0], 0.02),
    **{f"random system {seed}": random_system(seed) for seed in (1, 2, 3)},
}


@pytest.mark.parametrize("integrator", INTEGRATORS, ids=lambda i: type(i).__name__)
@pytest.mark.parametrize("name", SCENES)
def test_a_run_has_the_same_bits_at_both_speeds(name, integrator):
    system, q0, u0, t_end, selection = SCENES[name]
    run = dict(t_span=(0, t_end), q0=q0, u0=u0, integrator=integrator, selection=selection, on_failure="return")
    compiled = ns.simulate(system, **run)
    with interpreter():
        twin = ns.simulate(system, **run)
    assert compiled.stats.is_compiled and not twin.stats.is_compiled
    assert (twin.status, twin.events) == (compiled.status, compiled.events)
    assert not differing(compiled, twin, RECORDS)


# contact problems, complementarity problems, paradoxes

FILES = {
    "fc": sorted(DATA.glob("fc*/*.npz")),
    "lcp": sorted(DATA.glob("lcp/*.npz")),
}
# Python rounds math.hypot better than libm does: the starting points of the interior point differ by EPS. Close to the
# boundary of the cones its systems have condition numbers of 1/tol = 1e8, and EPS grows to HYPOT.
HYPOT = np.finfo(float).eps * 1e8
LARGEST = 30  # unknowns: the interpreter takes seconds for more


def problems(kind):
    for path in FILES[kind]:
        _, matrix, arguments = load_problem(path)
        if matrix.shape[0] > LARGEST:
            continue
        yield arguments
        if kind == "fc":
            G, c, mu, dim = arguments
            yield G, c, 0.0 * mu, dim


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
    "box in a corner": (stress_scenes.box_in_corner(0.3, 5.0), np.zeros((2, 4))),
}


@pytest.mark.parametrize("name", STATES)
def test_the_solutions_of_a_state_have_the_same_bits_at_both_speeds(name):
    system, (q, u) = STATES[name]
    compiled = ns.classify(system, 0.0, q, u)
    with interpreter():
        twin = ns.classify(system, 0.0, q, u)
    assert compiled.n_solutions == twin.n_solutions and repr(twin) == repr(compiled)
