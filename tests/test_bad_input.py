"""Bad input to every public function: refused before anything is computed, with quantity, rule, value and cure.

`CALLS` has a call of each public function that works; a row of `ROWS` changes some of its arguments and says what the
refusal must say. Further down every argument of every function meets values that fit nowhere.
"""

import functools
import inspect
import math
import tempfile
import warnings
from enum import Enum
from pathlib import Path

import numpy as np
import pytest

import nonsmooth as ns
from models import BeltOscillator, BouncingBall, ModeCoupling, PainleveRod, SlidingBlock, SpragSlip
from tests.systems import ball, ball_gap, ball_mass, ball_normal, ball_weight

STEP = ns.MoreauJean(dt=1e-3)
BALL, ROD, SPRAG, BELT = BouncingBall(e=0.5), PainleveRod(), SpragSlip(), BeltOscillator()
Q, U = ROD.state()
A, B = np.array([[2.0, -1.0], [-1.0, 2.0]]), np.array([-1.0, -1.0])
G, C = np.array([[1.0, 0.2], [0.2, 1.0]]), np.array([-1.0, 0.5])
nan, inf = math.nan, math.inf


def block_with(**contact):
    block = SlidingBlock().system()
    system = ns.System(n_q=2, contacts=[ns.Contact(**contact)], parameters=block.parameters, mass=block.mass,
                       force=block.force, gap=block.gap, normal=block.normal, tangent=block.tangent)  # fmt: skip
    return ns.simulate(system, (0, 0.01), [0, 0], [1, 0], integrator=STEP)


@functools.cache
def run():
    return ns.simulate(BALL, (0, 0.01), [1.0], [0.0], integrator=STEP)


@functools.cache
def penalty_run():
    return ns.simulate(BALL, (0, 0.5), [1.0], [0.0], integrator=ns.Penalty(1e5, damping_ratio=0.1))


@functools.cache
def a_scene():
    scene = ns.Scene(gravity=(0, -9.81))
    scene.body(ns.Disc(0.1), density=1000, position=(0, 1), name="ball")
    return scene


def scene_run():
    return ns.simulate(a_scene(), (0, 0.01), integrator=STEP)


def a_mesh():
    path = Path(tempfile.mkdtemp()) / "t.obj"
    path.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n")
    return path


IN_A_SCENE = {"system": a_scene(), "q0": None, "u0": None, "selection": "compliant-limit"}


@functools.cache
def chart():
    return ns.paradox_map(ROD, th=[0.5, 1.0], mu=[0.5, 2.0])


@functools.cache
def stability_chart():
    return ns.stability_map(ModeCoupling(), {"mu": [0.4, 0.6], "cz": [0.5, 1.0]}, sensitivities=False)


@functools.cache
def swept():
    return ns.sweep(ns.RunTask(BALL, t_span=(0, 0.01), integrator=STEP), {"e": [0.2, 0.5]}, progress=False)


SPRING = object()  # stands for the method of `spring`, which needs SymPy


def handed_in(method, parameters, name):
    """What SymPy derived, as a declaration."""
    pytest.importorskip("sympy", reason="energies need SymPy, the extra [symbolic]")
    return ns.lagrangian_of(spring() if method is SPRING else method, parameters, name)


def spring():
    """A spring and a mass, derived by SymPy."""
    from sympy.physics import mechanics

    x = mechanics.dynamicsymbols("x")
    method = mechanics.LagrangesMethod(x.diff() ** 2 / 2 - x**2 / 2, [x])
    method.form_lagranges_equations()
    return method


def declared(name):
    """A declaration of nothing yet."""
    pytest.importorskip("sympy", reason="energies need SymPy, the extra [symbolic]")
    return ns.lagrangian(name)


def lazily(function, **made):
    """The function, some of whose arguments are made when it is called."""
    return lambda **given: function(**{name: make() for name, make in made.items() if name not in given} | given)


SIMULATE = {"system": BALL, "t_span": (0, 0.01), "q0": [1.0], "u0": [0.0], "integrator": STEP}
STUDY = {"system": BALL, "t_span": (0, 0.1), "q0": [1.0], "u0": [0.0]}
CALLS = {
    "System": (ns.System, {
        "n_q": 1, "mass": ball_mass, "force": ball_weight, "gap": ball_gap, "normal": ball_normal,
        "contacts": [ns.Contact()], "parameters": (), "n_u": 1, "stiffness": None, "name": "ball",
    }),
    "Contact": (ns.Contact, {
        "mu": 0.3, "e_N": 0.5, "e_F": 0.0, "bilateral": False, "normal_force": False, "impact": "newton",
    }),
    "Coulomb": (ns.Coulomb, {"mu": 0.3}),
    "StaticKinetic": (ns.StaticKinetic, {"mu_s": 0.3, "mu_k": 0.2}),
    "Polynomial": (ns.Polynomial, {"m0": 0.3, "m1": 0.1, "m3": 0.1}),
    "Friction": (ns.Friction, {"function": lambda v, p: 0.3}),
    "Stribeck": (ns.Stribeck, {"mu_s": 0.3, "mu_k": 0.2, "v_s": 0.1, "delta": 1.0, "m_v": 0.0}),
    "Smoothed": (ns.Smoothed, {"m0": 0.3, "r": 50.0, "m1": 0.1, "m3": 0.1}),
    "simulate": (ns.simulate, SIMULATE | {
        "every": 1, "t_eval": None, "selection": "lift-off", "project": False, "on_failure": "raise",
        "events": (), "max_steps": None, "max_wall_time": None, "progress": None,
        "record": None, "view": False, "threads": 1,
    }),
    "MoreauJean": (ns.MoreauJean, {"dt": 1e-3, "theta": 0.5, "projection": False, "compliance": None,
                                  "contacts": ns.ContactSolver(), "specialise": "auto"}),  # fmt: skip
    "EventDriven": (ns.EventDriven, {"rtol": 1e-8, "atol": 1e-10}),
    "Auto": (ns.Auto, {"rtol": 1e-6}),
    "Adaptive": (ns.Adaptive, {"rtol": 1e-6, "atol": 1e-8}),
    "Compliance": (ns.Compliance, {"stiffness": 1e4, "damping": 1.0}),
    "Penalty": (ns.Penalty, {
        "stiffness": 1e5, "damping": None, "damping_ratio": 0.1, "mass": 1.0, "law": "clipped", "friction": "coulomb",
        "rtol": 1e-8, "atol": 1e-10,
    }),
    "Regularised": (ns.Regularised, {"v_s": 0.1}),
    "TangentialSpring": (ns.TangentialSpring, {"ratio": 0.8}),
    "classify": (ns.classify, {
        "system": ROD, "t": 0.0, "q": Q, "u": U, "state": None, "restitution": None, "tolerance": 1e-9,
    }),
    "paradox_map": (ns.paradox_map, {
        "system": ROD, "t": 0.0, "state": None, "workers": 1, "kept": None, "th": [0.5, 1.0], "mu": [0.5, 2.0],
        "journal": None,
    }),
    "paradox_boundaries": (ns.paradox_boundaries, {
        "system": ROD, "contact": 0, "t": 0.0, "state": None, "th": [0.2, 0.7, 1.2], "mu": [0.5, 1.0, 2.0],
    }),
    "plot_map": (lazily(ns.plot_map, chart=chart), {
        "path": None, "boundaries": None, "motions": (), "regions": None, "title": None,
    }),
    "plot_stability_map": (lazily(ns.plot_stability_map, chart=stability_chart), {"path": None, "units": ("", "")}),
    "plot_graphical_problem": (
        lazily(ns.plot_graphical_problem, cases=lambda: ns.classify(ROD, 0.0, Q, U)), {"path": None, "contact": 0},
    ),
    "critical_friction": (ns.critical_friction, {"system": ROD, "q": Q, "contact": 0, "t": 0.0}),
    "least_critical_friction": (ns.least_critical_friction, {
        "system": ROD, "q": Q, "coordinate": 2, "between": (0.1, 1.4), "contact": 0, "t": 0.0,
    }),
    "penalty_study": (ns.penalty_study, STUDY | {
        "stiffness": [1e4, 1e5], "damping": None, "damping_ratio": None, "penalty": None, "reference": None,
        "times": None, "restitution": "equal",
    }),
    "convergence_study": (ns.convergence_study, STUDY | {
        "dt": [1e-2, 5e-3], "integrator": ns.MoreauJean, "reference": None, "times": None,
    }),
    "work_precision": (lambda **given: ns.work_precision(**given), {
        "systems": {"ball": ns.TimedMotion(BALL, (0, 0.1), [1.0], [0.0])}, "integrators": {"step": ns.MoreauJean},
        "repeats": 1,
    }),
    "force_episode": (lazily(ns.force_episode, solution=penalty_run), {"contact": 0}),
    "solve_lcp": (ns.solve_lcp, {"A": A, "b": B, "solver": "auto", "tol": 1e-10, "guess": None}),
    "solve_mlcp": (ns.solve_mlcp, {
        "A": A, "b": B, "free": [True, False], "solver": "auto", "tol": 1e-10, "guess": None,
    }),
    "is_p_matrix": (ns.is_p_matrix, {"A": A}),
    "lcp_solutions": (ns.lcp_solutions, {"A": A, "b": B}),
    "contact_solutions": (ns.contact_solutions, {"G": G, "c": C, "mu": 0.3, "mu_static": 0.4}),
    "solve_contact": (ns.solve_contact, {
        "G": G, "c": C, "mu": [0.3], "dim": 2, "solver": "auto", "tol": 1e-8, "guess": None, "max_time": None,
    }),
    "ContactProblem": (ns.ContactProblem, {"G": G, "c": C, "mu": [0.3], "dim": 2, "P": None, "note": ""}),
    "GlobalContactProblem": (ns.GlobalContactProblem, {
        "M": np.eye(2), "H": np.eye(2), "f": [0.0, 0.0], "w": C, "mu": [0.3], "dim": 2, "G": None, "b": None,
        "P": None, "note": "",
    }),
    "read_fclib": (ns.read_fclib, {"path": "problem.hdf5"}),
    "write_fclib": (ns.write_fclib, {
        "path": "problem.hdf5", "problem": ns.ContactProblem(G, C, [0.3], 2), "matrix_format": "csr",
    }),
    "sweep": (ns.sweep, {
        "task": ns.RunTask(BALL, t_span=(0, 0.01), integrator=STEP), "axes": {"e": [0.2, 0.5]}, "workers": 1,
        "executor": None, "scheduler": None, "journal": None, "resume": True, "out": None, "progress": False,
        "timeout": None, "retries": 1, "fail_fast": False, "batch": None,
    }),
    "RunTask": (ns.RunTask, {
        "model": BALL, "measures": "final_state", "t_span": (0, 0.01), "integrator": STEP, "state": None,
        "selection": "compliant-limit", "window": 0.5, "every": 1, "settle": 0.01, "settle_by": None,
        "record": None,
    }),
    "SceneTask": (ns.SceneTask, {
        "make_scene": lambda mu: None, "measures": len, "t_span": (0, 0.01), "integrator": STEP, "every": 1,
        "record": None,
    }),
    "mesh": (ns.mesh, {"path": a_mesh(), "scale": 1.0, "cut": None}),
    "heightfield": (ns.heightfield, {"heights": [[0.0, 0.1], [0.0, 0.2]], "lengths": (1.0, 1.0), "base": None}),
    "Stepper": (ns.Stepper, {"scene": a_scene(), "integrator": STEP, "t_0": 0.0, "record": None}),
    "MapTask": (ns.MapTask, {"model": ROD, "t": 0.0, "state": None, "kept": None}),
    "Axis": (ns.Axis, {"name": "e", "values": [0.1, 0.2], "unit": ""}),
    "LocalPool": (lambda workers: ns.LocalPool(workers).shutdown(), {"workers": 1}),
    "load_sweep": (ns.load_sweep, {"path": "sweep.npz"}),
    "save_sweep": (lazily(ns.save_sweep, found=swept), {"path": "sweep.npz"}),
    "plot_sweep": (lazily(ns.plot_sweep, found=swept), {"path": None, "name": None}),
    "equilibrium": (ns.equilibrium, {"system": SPRAG, "guess": None, "sliding": None, "normal": None, "t": 0.0}),
    "linearise": (ns.linearise, {"system": SPRAG, "at": None}),
    "eigen_path": (ns.eigen_path, {"system": SPRAG, "parameter": "mu", "values": [0.1, 0.2], "at": None}),
    "eigenvalue_sensitivity": (ns.eigenvalue_sensitivity, {"system": SPRAG, "parameter": "mu", "at": None}),
    "flutter_boundary": (ns.flutter_boundary, {
        "system": ModeCoupling(), "parameter": "mu", "bracket": (0.3, 0.8), "at": None,
    }),
    "stability_map": (ns.stability_map, {
        "system": SPRAG, "axes": {"mu": [0.1, 0.2], "cth": [0.1, 0.2]}, "at": None, "sensitivities": False,
    }),
    "averaged_amplitude": (ns.averaged_amplitude, {"system": BELT, "at": None, "largest": None}),
    "limit_cycle": (ns.limit_cycle, {
        "system": BELT, "guess": None, "duration": None, "dt": None, "forcing": None, "drift": None,
    }),
    "continue_cycle": (ns.continue_cycle, {
        "system": BELT, "parameter": "vb", "values": [0.2], "cycle": None, "rtol": 1e-9,
        "forcing": None, "state": None, "duration": None,
    }),
    "bifurcation_diagram": (ns.bifurcation_diagram, {
        "system": BELT, "parameter": "vb", "values": [0.2, 0.3], "coordinate": 0, "start": None, "duration": 12.0,
        "dt": 1e-2, "forcing": None, "integrator": None,
    }),
    "Solution": (ns.Solution.load, {"path": "run.npz"}),
    "Scene": (ns.Scene, {"gravity": (0, -9.81), "material": ns.Material()}),
    "Material": (ns.Material, {"mu": 0.5, "e": 0.1, "name": "rubber", "adhesion": 1.0}),
    "PinFriction": (ns.PinFriction, {"mu": 0.5, "radius": 0.01}),
    "GuideFriction": (ns.GuideFriction, {"mu": 0.5, "length": 0.1}),
    "EllipticFriction": (ns.EllipticFriction, {"along": 0.2, "across": 0.6, "direction": (1, 0, 0)}),
    "Disc": (ns.Disc, {"radius": 0.1}),
    "Sphere": (ns.Sphere, {"radius": 0.1}),
    "Box": (lambda lengths: ns.Box(lengths), {"lengths": (0.2, 0.1)}),
    "Capsule": (ns.Capsule, {"length": 0.2, "radius": 0.1}),
    "Cylinder": (ns.Cylinder, {"radius": 0.1, "length": 0.2}),
    "Ellipsoid": (ns.Ellipsoid, {"a": 0.1, "b": 0.2, "c": 0.3}),
    "Polyhedron": (ns.Polyhedron, {"points": [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]}),
    "Polygon": (ns.Polygon, {"vertices": [(0, 0), (1, 0), (0, 1)], "radius": 0.0}),
    "Segment": (ns.Segment, {"a": (0, 0), "b": (1, 0)}),
    "HalfPlane": (ns.HalfPlane, {"normal": (0, 1), "offset": 0.0}),
    "HalfSpace": (ns.HalfSpace, {"normal": (0, 0, 1), "offset": 0.0}),
    "Compound": (lambda part: ns.Compound(part), {"part": (ns.Disc(0.1), (0, 0))}),
    "ContactSolver": (ns.ContactSolver, {"tol": 1e-8, "sweeps": 60, "interior": 200, "on_residual": "warn",
                                         "may_sleep": True}),  # fmt: skip
    "SceneSolution": (ns.SceneSolution.load, {"path": "scene.npz", "scene": None}),
    "lagrangian": (declared, {"name": "block"}),
    "lagrangian_of": (handed_in, {"method": SPRING, "parameters": {}, "name": "block"}),
}  # fmt: skip
FILES = {  # what a call reads has to be there
    "read_fclib": lambda: ns.write_fclib("problem.hdf5", ns.ContactProblem(G, C, [0.3], 2)),
    "load_sweep": lambda: ns.save_sweep(swept(), "sweep.npz"),
    "Solution": lambda: run().save("run.npz"),
    "SceneSolution": lambda: scene_run().save("scene.npz"),
}
# What the library makes and users only read.
RECORDS = {"TimedMotion", "OwnMethod"}  # of what work_precision compares, which checks them
RESULTS = {
    "Stats", "Event", "ParadoxEvent", "Classification", "SpatialClassification", "SpatialSolution", "Episode", "Study",
    "LCPResult", "ContactResult", "Equilibrium",
    "Linearisation", "EigenPath", "StabilityBoundary", "AveragedMotion", "LimitCycle", "CycleBranch",
    "BifurcationDiagram", "Motion", "StateAt", "WorkPrecision", "Body", "SceneStats", "SceneContacts", "BodyMotion",
    "BodyState", "SceneEvent", "SceneEvents", "SceneParadox", "ScenePair", "ScenePairs", "Joint", "JointMotion",
    "SpringForces", "ContactSolutions",
}  # fmt: skip

DIRECTIONS = np.random.default_rng(0).normal(size=(300, 3))
SPHERE_OF_POINTS = DIRECTIONS / np.linalg.norm(DIRECTIONS, axis=1)[:, None]
GAP_OF = {"contacts": [ns.Contact(mu="mue")], "tangent": lambda t, q, p, W_F: None}
ROWS = [
    ("Scene", {"gravity": 9.81}, r"gravity must be.* one-dimensional|gravity must"),
    ("Scene", {"gravity": (0, 0, 0, 1)}, r"gravity must have 2 entries \(planar\) or 3 \(spatial\) \[m/s\^2\]; got 4"),
    ("Scene", {"material": 0.5}, r"material must be a Material\(mu=..., e=...\); got 0.5"),
    (
        "Material",
        {"mu": ns.Friction},
        r"mu is a function, .*Friction'>; give the law of it, mu=ns.Friction\(...\)",
    ),
    ("PinFriction", {"mu": 0.0}, r"mu of PinFriction must be positive; got 0"),
    ("EllipticFriction", {"along": 0.0}, r"along of EllipticFriction must be positive; got 0"),
    ("EllipticFriction", {"across": -0.1}, r"across of EllipticFriction must not be negative; got -0.1"),
    ("EllipticFriction", {"direction": (0, 1)}, r"direction of EllipticFriction must have 3 entries; got 2"),
    (
        "EllipticFriction",
        {"direction": (0, 0, 0)},
        r"direction of EllipticFriction must have a length; got \(0, 0, 0\)",
    ),
    ("GuideFriction", {"mu": nan}, r"mu of GuideFriction must be finite; got nan"),
    ("GuideFriction", {"length": -1.0}, r"length of GuideFriction must not be negative; got -1"),
    ("PinFriction", {"radius": -1.0}, r"radius of PinFriction must be positive.*got -1"),
    ("Material", {"mu": -0.1}, r"mu must not be negative; got -0.1"),
    ("Material", {"e": 1.5}, r"e must lie in \[0, 1\]; got 1.5"),
    ("Material", {"adhesion": -3.0}, r"adhesion must not be negative; got -3"),
    ("Material", {"name": 3}, r"the name of a material must be a text; got 3"),
    ("Disc", {"radius": 0}, r"radius must be positive \[m\]; got 0"),
    ("Sphere", {"radius": -1.0}, r"radius must be positive \[m\]; got -1"),
    ("Box", {"lengths": (0.2,)}, r"two lengths in the plane or three in space \[m\]; got 1"),
    ("Box", {"lengths": (0.2, nan)}, r"lengths\[1\] must be finite; got nan"),
    ("Capsule", {"length": 0.0}, r"length must be positive \[m\]; got 0"),
    ("Capsule", {"radius": inf}, r"radius must be finite; got inf"),
    ("Cylinder", {"radius": -1.0}, r"radius must be positive \[m\]; got -1"),
    ("Cylinder", {"length": inf}, r"length must be finite; got inf"),
    ("Ellipsoid", {"a": 0.0}, r"a must be positive \[m\]; got 0"),
    ("Ellipsoid", {"b": nan}, r"b must be finite; got nan"),
    ("Ellipsoid", {"c": -2.0}, r"c must be positive \[m\]; got -2"),
    (
        "Polyhedron",
        {"points": [(0, 0, 0), (1, 0, 0)]},
        r"points must be a \(k, 3\) array with k >= 4; got shape \(2, 3\)",
    ),
    ("Polyhedron", {"points": [(0, 0, 1), (1, 0, 1), (0, 1, 1), (1, 1, 1)]}, r"lie in a plane; give it a thickness"),
    ("Polyhedron", {"points": [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, nan)]}, r"points must be finite"),
    ("Polyhedron", {"points": SPHERE_OF_POINTS}, r"at most 200 corners; the hull of these points has 300"),
    ("Polygon", {"vertices": [(0, 0), (1, 0)]}, r"vertices must be a \(k, 2\) array with k >= 3; got shape \(2, 2\)"),
    ("Polygon", {"vertices": [(0, 0), (2, 0), (0.5, 0.5), (0, 2)]}, r"must be convex.*make others of parts: Compound"),
    ("Polygon", {"radius": -0.1}, r"radius must not be negative; got -0.1 m"),
    ("Segment", {"b": (0, 0)}, r"the ends of a Segment must differ; both are \(0.0, 0.0\)"),
    ("Segment", {"a": (0, 0, 0)}, r"a must have 2 entries; got 3"),
    ("HalfPlane", {"normal": (0, 0)}, r"normal must not be zero; it points out of the ground"),
    ("HalfSpace", {"normal": (0, 1)}, r"normal must have 3 entries; got 2"),
    ("HalfSpace", {"offset": nan}, r"offset must be finite; got nan"),
    ("Compound", {"part": (ns.HalfPlane((0, 1)), (0, 0))}, r"part 0 of a Compound must be a bounded shape"),
    ("Compound", {"part": (ns.Disc(0.1), (0, 0, 0))}, r"position of part 0 must have 2 entries; got 3"),
    ("ContactSolver", {"tol": 0.0}, r"tol must"),
    ("ContactSolver", {"sweeps": 0}, r"sweeps must be a whole number of at least 1; got 0"),
    ("ContactSolver", {"interior": -1}, r"interior must be a whole number of at least 0; got -1"),
    ("ContactSolver", {"on_residual": "shout"}, r"on_residual must be 'warn' or 'raise'; got 'shout'"),
    ("ContactSolver", {"may_sleep": 1}, r"may_sleep must be True or False; got 1"),
    ("SceneSolution", {"path": 3}, r"path must"),
    ("System", {"n_q": 0}, r"n_q must be a whole number of at least 1; got 0"),
    ("System", {"n_q": 1.0}, r"n_q must be a whole number"),
    ("System", {"n_u": 2}, r"n_u must equal n_q \(q' = u\), or kinematics= .*; got n_u = 2"),
    ("System", {"mass": None}, r"needs the function mass; it was not given"),
    ("System", {"force": ball_mass}, r"force must take \(t, q, u, p, out\); got force\(t, q, p, M\)"),
    ("System", {"gap": 1.0}, r"gap must be a function; got float"),
    ("System", {"gap": None}, r"needs the function gap"),
    ("System", {"stiffness": "difference"}, r"stiffness must be a function; got str"),
    ("System", {"contacts": [1.0]}, r"contacts must be a list of Contact, one for each gap; got \[1.0\]"),
    ("System", {"contacts": "floor"}, r"contacts must be a list of Contact.*got 'floor'"),
    ("System", {"parameters": {"m": 1.0}}, r"parameters must be a NamedTuple or a dataclass; got dict"),
    ("System", GAP_OF, r"mu refers to the parameter 'mue', which does not exist"),
    ("System", {"name": 3}, r"name must be a text; got 3"),
    ("Contact", {"mu": -0.1}, r"mu must not be negative; got -0.1"),
    ("Contact", {"mu": nan}, r"mu must be finite; got nan"),
    ("Contact", {"mu": None}, r"mu must be a number; got None"),
    ("Contact", {"mu": abs}, r"mu is a function, .*abs.*; give the law of it, mu=ns.Friction\(...\)"),
    ("Contact", {"e_N": 1.5}, r"e_N must lie in \[0, 1\]; got 1.5"),
    ("Contact", {"e_N": -0.1}, r"e_N must lie in \[0, 1\]; got -0.1"),
    ("Contact", {"e_F": inf}, r"e_F must be finite; got inf"),
    ("Contact", {"impact": "poison"}, r"no impact law 'poison'; did you mean 'poisson'"),
    ("Contact", {"bilateral": 1}, r"bilateral must be True or False; got 1"),
    ("Contact", {"bilateral": True, "normal_force": True}, r"either bilateral or has a given normal force"),
    ("Coulomb", {"mu": -1.0}, r"mu must not be negative; got -1"),
    ("StaticKinetic", {"mu_k": 0.4}, r"mu_s - mu_k must not be negative; got -0.1"),
    ("Polynomial", {"m0": -0.1}, r"m0 must not be negative"),
    ("Polynomial", {"m3": nan}, r"m3 must be finite; got nan"),
    ("Friction", {"function": 0.3}, r"a friction law must be a function mu\(v, p\); got 0.3"),
    ("Stribeck", {"v_s": 0.0}, r"v_s must be positive \[m/s\]; got 0"),
    ("Stribeck", {"delta": -1.0}, r"delta must be positive; got -1"),
    ("Smoothed", {"r": 0.0}, r"r must be positive \[s/m\]; got 0"),
    ("simulate", {"q0": [1.0, 2.0]}, r"q0 must have 1 entries; got 2"),
    ("simulate", {"q0": [nan]}, r"q0 must be finite; q0\[0\] is nan"),
    ("simulate", {"q0": [1j]}, r"q0 must be an array of numbers; got \[1j\]"),
    ("simulate", {"q0": np.array([1j])}, r"q0 must be an array of numbers"),
    ("simulate", {"q0": ["1.0"]}, r"q0 must be an array of numbers; got \['1.0'\]"),
    ("simulate", {"q0": []}, r"q0 must have 1 entries; got 0"),
    ("simulate", {"q0": [10**400]}, r"q0 must be an array of numbers"),
    ("simulate", {"u0": [-inf]}, r"u0 must be finite; u0\[0\] is -inf"),
    ("simulate", {"u0": [[1.0]]}, r"u0 must be a vector; got shape \(1, 1\)"),
    ("simulate", {"t_span": (1.0, 0.0)}, r"t_span must not run backwards; got \(1, 0\)"),
    ("simulate", {"t_span": {0.0, 1.0}}, r"t_span must be a pair \(start, end\) \[s\]; got \{"),
    ("simulate", {"t_span": (0.0, nan)}, r"t_span\[1\] must be finite; got nan"),
    ("simulate", {"t_span": (0.0, "1")}, r"t_span\[1\] must be a number \[s\]; got '1'"),
    ("simulate", {"t_span": (0.0, 1.0, 2.0)}, r"t_span must be a pair"),
    ("simulate", {"t_eval": [0.005, 0.002]}, r"t_eval must increase within \[0, 0.01\]"),
    ("simulate", {"every": 0}, r"every must be a whole number of at least 1; got 0"),
    ("simulate", {"every": 10**30}, r"every must be a whole number of at least 1 and at most"),
    ("simulate", {"selection": "liftoff"}, r"no selection rule 'liftoff'; did you mean 'lift-off'"),
    ("simulate", {"on_failure": "ignore"}, r"on_failure must be 'raise' or 'return'; got 'ignore'"),
    ("simulate", {"project": "yes"}, r"project must be True or False; got 'yes'"),
    ("simulate", {"threads": 0}, r"threads must be a whole number of at least 1; got 0"),
    ("simulate", {"threads": 65}, r"threads must be at most 64, and processors help no more; got 65"),
    ("simulate", {"threads": 2}, r"threads share the islands of a scene, and a system has none; leave out threads="),
    ("simulate", {"max_steps": 0.5}, r"max_steps must be a whole number of at least 1"),
    ("simulate", {"events": 3}, r"events must be functions f\(t, q, u\) in a list; got 3"),
    ("simulate", {"events": [None]}, r"events must be functions f\(t, q, u\); events\[0\] is None"),
    ("simulate", {"max_wall_time": 0.0}, r"max_wall_time must be positive \[s\]; got 0"),
    ("SceneTask", {"make_scene": 3}, r"make_scene must be a function of the axes; got 3"),
    ("SceneTask", {"measures": "final_state"}, r"measures must be functions of the run of a scene; got 'final_state'"),
    ("SceneTask", {"measures": []}, r"measures must be functions of the run of a scene; got \[\]"),
    ("SceneTask", {"integrator": 3}, r"integrator must be an integrator"),
    ("SceneTask", {"t_span": (1, 0)}, r"t_span must not run backwards"),
    ("SceneTask", {"every": 0}, r"every must be a whole number"),
    ("SceneTask", {"record": "body"}, r"record must be some of"),
    ("mesh", {"path": "nowhere.stl"}, r"nowhere.stl is no mesh that trimesh reads"),
    ("mesh", {"scale": 0.0}, r"scale must be positive \[m\]; got 0"),
    ("mesh", {"cut": 2.0}, r"cut must lie in \[0, 1\]; got 2"),
    ("heightfield", {"heights": [[0.0, 0.1]]}, r"of 2 points a side or more; got shape \(1, 2\)"),
    ("heightfield", {"heights": [[0.0, 0.1], [0.0, np.nan]]}, r"heights must be finite"),
    ("heightfield", {"heights": [[0.0, 0.1], [0.0, 1e300]]}, r"heights must not be larger than"),
    ("heightfield", {"lengths": 1.0}, r"lengths must have 2 entries; got 1"),
    ("heightfield", {"lengths": (1.0, 0.0)}, r"lengths must be positive \[m\]; got \[1.0, 0.0\]"),
    ("heightfield", {"base": 0.0}, r"base must be below all heights, the lowest of which is 0 m; got 0 m"),
    ("Stepper", {"scene": ROD}, r"a stepper goes on with an ns.Scene, or a ready scene; got"),
    (
        "Stepper",
        {"integrator": ns.EventDriven()},
        r"integrator must be ns.MoreauJean\(dt\), whose steps are of one",
    ),
    ("Stepper", {"record": "body"}, r"record must be some of"),
    ("simulate", IN_A_SCENE | {"project": "yes"}, r"project must be True or False; got 'yes'"),
    (
        "simulate",
        IN_A_SCENE | {"threads": 2, "integrator": ns.Penalty(1e6)},
        r"Penalty has none: .* costs what is gained; leave out threads=",
    ),
    ("simulate", IN_A_SCENE | {"events": 3}, r"events must be functions f\(t, bodies\) in a list; got 3"),
    ("simulate", IN_A_SCENE | {"events": [None]}, r"events must be functions f\(t, bodies\); events\[0\] is None"),
    ("simulate", IN_A_SCENE | {"events": lambda t: t}, r"events\[0\].*bodies"),
    (
        "simulate",
        IN_A_SCENE | {"record": ("event",)},
        r"record must be some of 'bodies', 'contacts', 'ledger', 'events', 'pairs'",
    ),
    ("simulate", {"record": ["bodies"]}, r"record must be some of 'coordinates', 'velocities', 'gaps', 'impulses'"),
    ("RunTask", {"record": "ledgers"}, r"record must be some of .*'ledger', 'events', 'motion'; got 'ledgers'"),
    ("simulate", {"view": "page.html"}, r"view must be True or False; got 'page.html'"),
    ("simulate", {"progress": 1}, r"progress must be a function of the fraction done, or True for a bar; got 1"),
    ("simulate", {"integrator": ns.MoreauJean}, r"integrator must be an integrator, as ns.MoreauJean\(dt=1e-3\) is"),
    ("simulate", {"integrator": ns.MoreauJean(5e-324)}, r"dt = 4.94066e-324 s is too small for the span"),
    ("simulate", {"integrator": ns.MoreauJean(1e-13)}, r"GiB are free; take a larger every or dt"),
    ("simulate", {"system": BouncingBall}, r"got the class BouncingBall: call it first"),
    ("simulate", {"system": 3}, r"a system or a model is needed; got int"),
    ("MoreauJean", {"specialise": "always"}, r'specialise must be True, False or "auto"; got .always.'),
    ("MoreauJean", {"dt": 0}, r"dt must be positive \[s\]; got 0"),
    ("MoreauJean", {"dt": -1e-3}, r"dt must be positive \[s\]; got -0.001"),
    ("MoreauJean", {"dt": nan}, r"dt must be finite; got nan"),
    ("MoreauJean", {"dt": "1e-3"}, r"dt must be a number \[s\]; got '1e-3'"),
    ("MoreauJean", {"theta": 0.2}, r"theta must lie in \[0.5, 1\]; got 0.2"),
    ("MoreauJean", {"projection": 1}, r"projection must be True or False; got 1"),
    ("MoreauJean", {"compliance": 1e6}, r"compliance must be a Compliance"),
    ("EventDriven", {"rtol": 0.0}, r"rtol must lie in \[2.2e-14, 1\), above the rounding; got 0"),
    ("EventDriven", {"atol": -1.0}, r"atol must be positive; got -1"),
    ("Auto", {"rtol": 1.0}, r"rtol must lie in \[2.2e-14, 1\), above the rounding; got 1"),
    ("Adaptive", {"rtol": 0.0}, r"rtol must lie in \[2.2e-14, 1\), above the rounding; got 0"),
    ("Adaptive", {"atol": -1.0}, r"atol must be positive; got -1"),
    ("Compliance", {"stiffness": -1.0}, r"stiffness must be positive \[N/m\]; got -1"),
    ("Compliance", {"damping": nan}, r"damping must be finite; got nan"),
    ("Penalty", {"stiffness": 0.0}, r"stiffness must be positive \[N/m\]; got 0"),
    ("Penalty", {"damping_ratio": -0.1}, r"damping_ratio must not be negative; got -0.1"),
    ("Penalty", {"damping": 1.0}, r"either damping or damping_ratio; got both"),
    ("Penalty", {"law": "hunt-crosley"}, r"no contact law 'hunt-crosley'; did you mean 'hunt-crossley'"),
    ("Penalty", {"friction": "viscous"}, r"friction must be 'coulomb' or Regularised\(v_s\); got 'viscous'"),
    ("TangentialSpring", {"ratio": 0.0}, r"ratio must be positive; got 0"),
    ("Regularised", {"v_s": 0.0}, r"v_s must be positive \[m/s\]; got 0"),
    ("classify", {"q": [0.0, 1.0]}, r"q must have 3 entries; got 2"),
    ("classify", {"t": nan}, r"t must be finite; got nan"),
    ("classify", {"u": None}, r"a classification needs q and u, or state=\(q0, u0\) or dict\(th=..., thdot=...\)"),
    ("classify", {"state": {"th": 0.1}}, r"either q and u, or state; got both"),
    ("classify", {"q0": Q}, r"classify takes no q0=; its start is state=\(q0, u0\) or dict"),
    ("classify", {"restitution": 1.5}, r"restitution must lie in \[0, 1\]; got 1.5"),
    ("classify", {"tolerance": nan}, r"tolerance must be finite; got nan"),
    ("paradox_map", {"th": [nan, 1.0]}, r"th must be finite; th\[0\] is nan"),
    ("paradox_map", {"tht": 1.0}, r"no variable or parameter 'tht'; did you mean 'th'"),
    ("paradox_map", {"state": 1.0}, r"state must be .*, or a function of the variables that returns \(q, u\); got 1.0"),
    ("paradox_map", {"p": [1.0, 2.0]}, "p is a result of a map, and no name of an axis; give the parameter another"),
    ("paradox_map", {"kept": 0}, r"kept must be a whole number of at least 1; got 0"),
    ("paradox_boundaries", {"mu": 0.5}, r"boundaries need two axes, each of increasing values; got th"),
    ("paradox_boundaries", {"contact": 1}, r"contact must be a whole number from 0 to 0; got 1"),
    ("plot_map", {"chart": 1}, r"chart must be the Dataset of ns.paradox_map\(...\); got 1"),
    ("plot_map", {"motions": [[1.0, 2.0, 3.0]]}, r"motions must be a list of arrays \(n, 2\); got one of shape \(3,\)"),
    ("plot_map", {"path": "nowhere/map.png"}, r"cannot be written: there is no folder 'nowhere'; choose another path"),
    ("plot_stability_map", {"chart": 1}, r"chart must be the Dataset of ns.stability_map\(...\); got 1"),
    ("plot_stability_map", {"units": ("m", 1)}, r"units must be two texts, one for each parameter; got \['m', 1\]"),
    ("plot_graphical_problem", {"cases": []}, r"cases must be a Classification or pairs \(title, Classification\)"),
    ("plot_graphical_problem", {"contact": 2}, r"contact must be a whole number from 0 to 0; got 2"),
    ("critical_friction", {"q": None}, r"critical friction is that of a configuration; give q"),
    ("critical_friction", {"contact": -1}, r"contact must be a whole number from 0 to 0; got -1"),
    ("least_critical_friction", {"coordinate": "thh"}, r"no coordinate 'thh'; did you mean 'th'"),
    ("least_critical_friction", {"coordinate": 3}, r"coordinate must be a whole number from 0 to 2; got 3"),
    ("penalty_study", {"stiffness": [1e5, 1e4]}, r"stiffness must increase from value to value"),
    ("penalty_study", {"stiffness": []}, r"stiffness must hold at least one value; got none"),
    ("penalty_study", {"restitution": "same"}, r"same.*equal"),
    ("penalty_study", {"penalty": STEP}, r"penalty must be a Penalty, whose stiffness is varied; got MoreauJean"),
    ("convergence_study", {"dt": []}, r"dt must have at least one value; it is empty"),
    ("convergence_study", {"times": [5.0]}, r"times must increase within \(0, 0.1\] s; got \[5.0\]"),
    ("work_precision", {"integrators": {}}, r"needs at least one motion and one integrator"),
    ("work_precision", {"integrators": {"m": 3}}, r"'m' must be an integrator or its class, with dt or rtol.*got 3"),
    ("work_precision", {"repeats": 0}, r"repeats must be a whole number of at least 1; got 0"),
    ("force_episode", {"solution": None}, r"solution must be a Solution, as ns.simulate\(...\) gives; got None"),
    ("force_episode", {"contact": 1}, r"contact must be a whole number from 0 to 0; got 1"),
    ("solve_lcp", {"A": [[1.0, 2.0]]}, r"A must be a square matrix; got shape \(1, 2\)"),
    ("solve_lcp", {"A": [[1.0, nan], [0.0, 1.0]]}, r"A must be finite; A\[0, 1\] is nan"),
    ("solve_lcp", {"b": [1.0]}, r"b must have 2 entries; got 1"),
    ("solve_lcp", {"solver": "lemk"}, r"got 'lemk'; did you mean 'lemke'"),
    ("solve_lcp", {"tol": 0.0}, r"tol must be positive; got 0"),
    ("solve_lcp", {"tol": 1e300}, r"tol must lie in \(0, 1\), it is a relative error; got 1e\+300"),
    ("solve_lcp", {"A": [[1.0, 2.0], [0.0, 1.0]], "solver": "qp"}, r"symmetric"),
    ("solve_mlcp", {"free": [0, 5]}, r"free must be a boolean mask of 2 entries or indices from 0 to 1; got \[0, 5\]"),
    ("is_p_matrix", {"A": "identity"}, r"A must be an array of numbers; got 'identity'"),
    ("lcp_solutions", {"A": np.ones((2, 3))}, r"A must be a square matrix; got shape \(2, 3\)"),
    (
        "contact_solutions",
        {"G": np.eye(4), "c": np.ones(4)},
        r"G of one contact is \(2, 2\) or \(3, 3\), and c as long",
    ),
    ("contact_solutions", {"mu": -0.3}, r"mu must not be negative; got -0.3"),
    ("solve_contact", {"mu": [-0.3]}, r"mu must not be negative; mu\[0\] is -0.3"),
    ("solve_contact", {"mu": nan}, r"mu must be finite; got nan"),
    ("solve_contact", {"dim": 4}, r"dim must be 2 \(planar\) or 3 \(spatial\); got 4"),
    ("solve_contact", {"dim": 3}, r"c must have 3 entries for each contact \(N, T1, T2\); got 2"),
    ("solve_contact", {"G": np.eye(3)}, r"G must be \(2, 2\) to fit c; got shape \(3, 3\)"),
    ("solve_contact", {"max_time": 0.0}, r"max_time must be positive \[s\]; got 0"),
    ("solve_contact", {"max_time": nan}, r"max_time must be finite"),
    ("solve_contact", {"solver": "newtn"}, r"no contact solver 'newtn'; did you mean 'newton'"),
    ("ContactProblem", {"c": [nan, 0.0]}, r"c must be finite; c\[0\] is nan"),
    ("ContactProblem", {"P": [1.0]}, r"P must have 2 entries; got 1"),
    ("GlobalContactProblem", {"M": np.eye(3)}, r"M must be a matrix of shape \(2, 2\); got \(3, 3\)"),
    ("GlobalContactProblem", {"mu": [-1.0]}, r"mu must not be negative"),
    ("read_fclib", {"path": "nowhere.hdf5"}, r"there is none at nowhere.hdf5"),
    ("write_fclib", {"matrix_format": "coo"}, r"no matrix format 'coo'"),
    ("write_fclib", {"problem": 1}, r"problem must be a ContactProblem or GlobalContactProblem; got 1"),
    ("write_fclib", {"path": "problem.txt"}, r"must end in one of .hdf5, .h5"),
    ("sweep", {"axes": {"ee": [0.1]}}, r"no axis 'ee'; did you mean 'e'"),
    ("sweep", {"axes": {"e": [nan]}}, r"the axis e must be finite; e\[0\] is nan"),
    ("sweep", {"workers": 10**9}, r"workers must be a whole number of at most 1024; got 1000000000"),
    ("sweep", {"executor": 2}, r"executor must be a concurrent.futures.Executor; got 2"),
    ("sweep", {"fail_fast": "no"}, r"fail_fast must be True or False; got 'no'"),
    ("sweep", {"out": "sweep.csv"}, r"'sweep.csv' is no file name here: it must end in one of .npz, .nc"),
    ("sweep", {"timeout": -1.0}, r"timeout must be positive \[s\]; got -1"),
    ("RunTask", {"measures": 1}, r"measures must be names of results or functions of the solution; got 1"),
    ("RunTask", {"measures": "amplitud"}, r"no measure 'amplitud'; did you mean 'amplitude'"),
    ("RunTask", {"t_span": (1.0, 0.0)}, r"t_span must not run backwards"),
    ("RunTask", {"settle": 0.0}, r"settle must be positive"),
    ("RunTask", {"settle_by": 1.0}, r"settle_by= needs a measure that settles: 'amplitude' or 'period'"),
    ("RunTask", {"settle_by": 1e-9, "measures": "period"}, r"settle_by must not lie before the end, 0.01 s; got 1e-09"),
    ("RunTask", {"window": 2.0}, r"window must lie in \[0, 1\]; got 2"),
    ("MapTask", {"state": 3}, r"state must be .*, or a function of the variables that returns \(q, u\); got 3"),
    ("Axis", {"values": []}, r"the axis e must have at least one value; it is empty"),
    ("Axis", {"values": [inf]}, r"the axis e must be finite; e\[0\] is inf"),
    ("Axis", {"name": "a/b\nc", "values": []}, r"the axis a/b c must have at least one value"),
    ("Axis", {"name": 1}, r"the name of an axis must be a text; got 1"),
    ("LocalPool", {"workers": 0}, r"workers must be a whole number of at least 1; got 0"),
    ("load_sweep", {"path": "nowhere.npz"}, r"there is no file 'nowhere.npz'"),
    ("save_sweep", {"found": {}}, r"found must be the Dataset of a sweep; got \{\}"),
    ("plot_sweep", {"name": "energy"}, r"no result 'energy'"),
    ("equilibrium", {"guess": [nan, 0.0]}, r"guess must be finite; guess\[0\] is nan"),
    ("linearise", {"at": 1.0}, r"at must be an Equilibrium, as ns.equilibrium\(system\) gives; got 1.0"),
    ("eigen_path", {"parameter": "muu"}, r"no parameter 'muu'; did you mean 'mu'"),
    ("eigen_path", {"values": [0.2, 0.1, 0.3]}, r"values must be in increasing or in decreasing order"),
    ("eigenvalue_sensitivity", {"at": 1.0}, r"at must be a Linearisation, as ns.linearise\(system\) gives; got 1.0"),
    ("flutter_boundary", {"bracket": (0.3,)}, r"bracket must have 2 entries; got 1"),
    ("flutter_boundary", {"bracket": (0.1, 0.2)}, r"both"),
    ("stability_map", {"axes": {"mu": [0.1]}}, r"axes must name two parameters; got \['mu'\]"),
    ("stability_map", {"sensitivities": 2}, r"sensitivities must be True or False; got 2"),
    ("averaged_amplitude", {"largest": 0.0}, r"largest must be positive; got 0"),
    ("limit_cycle", {"guess": [1.0]}, r"guess must be a pair \(q0, u0\) or dict\(x=..., velocity=...\); got \[1.0\]"),
    ("limit_cycle", {"drift": "x"}, r"drift must be a list of the coordinates that go on and on, as \[0\].*got 'x'"),
    ("limit_cycle", {"drift": [1]}, r"drift must be a whole number from 0 to 0; got 1"),
    ("limit_cycle", {"drift": [0]}, r"coordinate 0 cannot drift: force changes with it"),
    ("limit_cycle", {"duration": -1.0}, r"duration must be positive \[s\]; got -1"),
    ("continue_cycle", {"values": []}, r"values of vb must be at least one; got none"),
    ("continue_cycle", {"rtol": 2.0}, r"rtol must lie in \(0, 1\), it is a relative error; got 2"),
    ("bifurcation_diagram", {"forcing": -1.0}, r"forcing must be positive"),
    ("bifurcation_diagram", {"forcing": 1.0}, r"last fifth of duration = 12 s must hold 8 .*; give duration=40"),
    ("bifurcation_diagram", {"forcing": "vc"}, r"vc"),
    ("bifurcation_diagram", {"forcing": "m"}, r"forcing = 'm' must be a parameter whose unit .* got \[kg\]; give the"),
    ("bifurcation_diagram", {"integrator": 1e-3}, r"integrator must be an integrator"),
    ("bifurcation_diagram", {"coordinate": 1}, r"coordinate must be a whole number from 0 to 0; got 1"),
    ("bifurcation_diagram", {"start": [0.0]}, r"start must be a pair \(q0, u0\) or dict\(x=..., velocity=...\); got"),
    ("Solution", {"path": "nowhere.npz"}, r"there is no file 'nowhere.npz'"),
    ("Solution", {"path": 3}, r"path must be the path of a file; got 3"),
    ("lagrangian", {"name": 3}, r"name must be a text; got 3"),
    ("lagrangian", {"name": "12"}, r"name must have letters, it names the class of the model; got '12'"),
    (
        "lagrangian_of",
        {"method": 3},
        r"method must be a LagrangesMethod or KanesMethod of sympy.*; got 3",
    ),
    ("lagrangian_of", {"parameters": [1.0]}, r"parameters must be a dict from symbols to values; got \[1.0\]"),
    ("lagrangian_of", {"parameters": {"k": 1.0}}, r"parameters must have symbols as keys; got 'k'"),
]


def call(name, /, **changes):
    function, good = CALLS[name]
    return function(**good | changes)


@pytest.fixture(autouse=True)
def in_a_folder_of_its_own(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


@pytest.mark.parametrize("name", sorted(CALLS.keys() - {"work_precision"}))
def test_the_call_whose_arguments_are_broken_below_works(name):
    if name in FILES:
        FILES[name]()
    call(name)


@pytest.mark.upkeep
@pytest.mark.parametrize(("name", "changes", "message"), ROWS)
def test_a_refusal_says_quantity_rule_value_and_cure(name, changes, message):
    with pytest.raises(ns.InvalidInput, match=message) as refusal:
        call(name, **changes)
    assert "\n" not in str(refusal.value)


def test_every_public_function_has_a_row():
    public = {name for name in ns.__all__ if callable(getattr(ns, name))}
    made_by_us = {name for name in public if isinstance(getattr(ns, name), type)
                  and issubclass(getattr(ns, name), Enum | BaseException)}  # fmt: skip
    with_rows = {name for name, _, _ in ROWS}
    assert with_rows == set(CALLS)
    assert public - made_by_us - RESULTS - RECORDS == with_rows


class Nothing:
    """Fits nowhere, and has a repr that fails."""

    def __repr__(self):
        raise RuntimeError


NOWHERE = {
    "an object": Nothing(), "complex": 1 + 2j, "a matrix of nan": np.full((2, 2, 2), nan), "a huge int": 10**400,
    "rows of different lengths": [[1], [1, 2]], "bytes": b"\0", "a text with a zero": "\0", "a set": {1.5}, "nan": nan,
    "an array of objects": np.array([None, {}]), "a date": np.datetime64("2020-01-01"), "a dict": {1: 2},
}  # fmt: skip
SLOW = {"LocalPool", "work_precision"}  # a process each; a study each


@pytest.mark.parametrize("name", [name for name in CALLS if name not in SLOW])
def test_what_fits_nowhere_is_refused_in_one_sentence_by_every_argument(name):
    """Refused or taken: never an exception of another kind, and never a NaN that goes on unseen."""
    for argument in CALLS[name][1]:
        for label, value in NOWHERE.items():
            where = f"{name}({argument}={label})"
            try:
                with warnings.catch_warnings():
                    warnings.simplefilter("ignore", ns.NonsmoothWarning)
                    call(name, **{argument: value})
            except ns.NonsmoothError as refusal:
                assert "\n" not in str(refusal) and len(str(refusal)) > 15, where
            except Exception as error:
                raise AssertionError(f"{where} raised {type(error).__name__}: {error}") from error
            else:
                assert is_free_text(name, argument, value), f"{where} was taken"


def is_free_text(name, argument, value):
    """Names, notes and names of parameters may be any text."""
    of_laws = name in ("Contact", "Coulomb", "StaticKinetic", "Polynomial", "Stribeck", "Smoothed")
    return isinstance(value, str) and (of_laws or argument in ("name", "note", "title", "unit"))


# Arrays that hold the right numbers in another form ---------------------------------------------------------------


def forms(values):
    """The same numbers read-only, strided, in single precision, as integers, big-endian, in Fortran order, as lists."""
    array = np.asarray(values, dtype=float)
    read_only = array.copy()
    read_only.flags.writeable = False
    wide = np.zeros((*array.shape[:-1], 2 * array.shape[-1]))
    wide[..., ::2] = array
    return [read_only, wide[..., ::2], array.astype(np.float32), array.astype(int), array.astype(">f8"),
            np.asfortranarray(array), array.astype(object), array.tolist()]  # fmt: skip


@pytest.mark.parametrize("k", range(len(forms([1.0]))))
def test_the_form_of_an_array_changes_no_bit_of_the_answer(k):
    matrix, right = np.array([[2.0, -1.0], [-1.0, 2.0]]), np.array([-1.0, -3.0])
    q, u = np.array([3.0]), np.array([-1.0])
    given = [forms(array)[k] for array in (matrix, right, q, u)]
    kept = [np.array(array, dtype=float) for array in given]
    assert (ns.solve_lcp(given[0], given[1]).z == ns.solve_lcp(matrix, right).z).all()
    mu = [0.5]
    assert (ns.solve_contact(given[0], given[1], mu, 2).P == ns.solve_contact(matrix, right, mu, 2).P).all()
    one, other = (ns.simulate(BALL, (0, 1), *state, integrator=STEP) for state in ((q, u), given[2:]))
    assert (one.q == other.q).all() and (one.u == other.u).all()
    assert all((np.asarray(array, dtype=float) == before).all() for array, before in zip(given, kept, strict=True))


def test_signatures_of_the_table_are_those_of_the_library():
    for function, good in CALLS.values():
        if inspect.isfunction(function) and function.__name__ == "<lambda>":
            continue
        inspect.signature(function).bind(**good)


# Laws and inertia that break a rule only inside a system -----------------------------------------------------------


@pytest.mark.parametrize("m", [-1.0, 0.0])
@pytest.mark.parametrize("integrator", [STEP, ns.EventDriven(), ns.Penalty(1e5)])
def test_mass_that_is_negative_or_zero_is_refused_by_every_integrator(m, integrator):
    def indefinite(t, q, p, M):
        M[0, 0] = m

    system = ball(mass=indefinite)
    with pytest.raises(ns.InvalidInput, match="mass matrix.*positive definite"):
        ns.simulate(system, (0, 1), [1.0], [0.0], integrator=integrator)


@pytest.mark.parametrize("size", [1e300, -1e300])
@pytest.mark.parametrize("integrator", [STEP, ns.EventDriven(), ns.Penalty(1e5)])
def test_states_near_the_end_of_the_numbers_never_end_as_success_with_nan(size, integrator):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ns.NonsmoothWarning)
        try:
            found = ns.simulate(BALL, (0, 1e-2), [1.0], [size], integrator=integrator, on_failure="return")
        except ns.InvalidInput:
            return
    if found.success:
        assert np.isfinite(found.q).all() and np.isfinite(found.u).all()
    else:
        assert found.status.name in found.message or found.message


def test_an_infeasible_complementarity_problem_is_said_to_be_so_with_a_certificate():
    result = ns.solve_lcp([[0.0, -1.0], [1.0, 0.0]], [-1.0, -1.0])
    assert result.status == ns.LCPStatus.INFEASIBLE and not result.residual < 1e-10
    y = result.certificate  # y >= 0, A^T y <= 0, b.y < 0: then no z >= 0 has A z + b >= 0
    assert (y >= 0).all() and (np.array([[0.0, -1.0], [1.0, 0.0]]).T @ y <= 1e-12).all()
    assert np.array([-1.0, -1.0]) @ y < 0
