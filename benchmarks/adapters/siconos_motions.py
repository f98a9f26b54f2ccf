"""Motions by Siconos, run by the Python that has it (Debian: python3-siconos).

    python3 siconos_motions.py

Reads a line of JSON for each run, {"scene", "dt", "events", "read", "times", "q0", "u0", "p"}: p are the parameters
of the model, "read" asks for positions. It answers with one, {"q": positions at the times, "wall_time": seconds of the
loop, "steps"} or {"error": message}. Moreau-Jean with theta = 1/2 as everywhere in Siconos, one contact solver call a
step, the loop of C++ (``run``) timed alone; positions are read in a second pass of the same steps. What is not linear
is compiled from siconos_plugin.c.
"""

import contextlib
import json
import math
import os
import subprocess
import sys
import tempfile
import time
import zlib
from pathlib import Path

import numpy as np
import siconos.kernel as sk
import siconos.numerics as sn

THETA = 0.5
TOLERANCE = 1e-13
PLAY = 1e-9  # m, between two contacts that stand for a bilateral one
NEWTON_TOLERANCE, NEWTON_ITERATIONS = 1e-10, 20


def linear_contact(normal, offset, tangent, mu, e):
    """A contact with constant rows; without a tangential row it is frictionless."""
    rows = [normal] if tangent is None else [normal, tangent]
    relation = sk.LagrangianLinearTIR(np.array(rows, dtype=float), np.array([offset] + [0.0] * (len(rows) - 1)))
    law = sk.NewtonImpactNSL(e) if tangent is None else sk.NewtonImpactFrictionNSL(e, 0.0, mu, 2)
    return sk.Interaction(law, relation)


def plugin(macro, p):
    """Compile the functions of a model with its parameters; the name by which Siconos finds them."""
    values = [f"-D{key}={value!r}" for key, value in p.items() if key not in ("n", "r", "e", "mu")]
    name = str(Path.cwd() / f"plugin_{macro.lower()}_{zlib.crc32(repr(values).encode()):08x}")
    if not Path(f"{name}.so").is_file():
        source = Path(__file__).with_name("siconos_plugin.c")
        subprocess.run(
            ["cc", "-O2", "-shared", "-fPIC", f"-D{macro}", *values, str(source), "-o", f"{name}.so", "-lm"], check=True
        )
    return name


def plugin_contact(library, name, mu, e):
    """A contact whose gap and rows are compiled; without mu it is frictionless."""
    relation = sk.LagrangianScleronomousR(f"{library}:{name}_gap", f"{library}:{name}_rows")
    law = sk.NewtonImpactNSL(e) if mu is None else sk.NewtonImpactFrictionNSL(e, 0.0, mu, 2)
    return sk.Interaction(law, relation)


def belt_contact(library, name, mu, e):
    """A contact with a surface that moves: gap, rows and the rates of the surface are compiled."""
    parts = (f"{library}:{name}_gap", f"{library}:{name}_rows", f"{library}:belt_rates")
    return sk.Interaction(sk.NewtonImpactFrictionNSL(e, 0.0, mu, 2), sk.LagrangianRheonomousR(*parts))


def body(q0, u0, M, f, K=None):
    """A linear system M u' + K q = f."""
    if K is None:
        ds = sk.LagrangianLinearTIDS(q0, u0, M)
    else:
        ds = sk.LagrangianLinearTIDS(q0, u0, M, K, np.zeros_like(K))
    ds.setFExtPtr(np.array(f, dtype=float))
    return ds


def ball(q0, u0, p):
    return body(q0, u0, [[p["m"]]], [-p["m"] * p["g"]]), [linear_contact([1.0], 0.0, None, 0.0, p["e"])]


def block(q0, u0, p):
    m = p["m"]
    ds = body(q0, u0, np.diag([m, m]), [0.0, -m * p["g"]])
    return ds, [linear_contact([0.0, 1.0], 0.0, [1.0, 0.0], p["mu"], p["e"])]


def beads(q0, u0, p):
    n = len(q0)
    contacts = []
    for i in range(n):
        row = np.zeros(n)
        row[i] = -1.0
        if i + 1 < n:
            row[i + 1] = 1.0
        contacts.append(linear_contact(row, p["gap"], None, 0.0, p["e"]))
    return body(q0, u0, p["m"] * np.eye(n), np.zeros(n)), contacts


def woodpecker(q0, u0, p):
    mS, mM, lM, lG, c, g = p["mS"], p["mM"], p["lM"], p["lG"], p["cphi"], p["g"]
    M = [
        [mM + mS, mS * lM, mS * lG],
        [mS * lM, p["JM"] + mS * lM**2, mS * lM * lG],
        [mS * lG, mS * lM * lG, p["JS"] + mS * lG**2],
    ]
    K = np.array([[0.0, 0.0, 0.0], [0.0, c, -c], [0.0, -c, c]])
    ds = body(q0, u0, np.array(M), [-(mM + mS) * g, -mS * g * lM, -mS * g * lG], K)
    edge = [1.0, p["rM"], 0.0]
    play = p["rM"] - p["r0"]
    return ds, [
        linear_contact([0, 0, -p["hS"]], lM + lG - p["lS"] - p["r0"], [1, lM, lG - p["lS"]], p["mu"], p["e1"]),
        linear_contact([0, p["hM"], 0], play, edge, p["mu"], p["e2"]),
        linear_contact([0, -p["hM"], 0], play, edge, p["mu"], p["e3"]),
    ]


def rod(q0, u0, p):
    library = plugin("ROD", p)
    ds = body(q0, u0, np.diag([p["m"], p["m"], p["I"]]), [0.0, -p["m"] * p["g"], 0.0])
    return ds, [plugin_contact(library, "tip", p["mu"], p["e"])]


def rocking_block(q0, u0, p):
    library = plugin("BLOCK", p)
    m = p["m"]
    ds = body(q0, u0, np.diag([m, m, m * (p["width"] ** 2 + p["height"] ** 2) / 12]), [0.0, -m * p["g"], 0.0])
    return ds, [plugin_contact(library, side, p["mu"], p["e"]) for side in ("left", "right")]


def pendulum(q0, u0, p):
    library = plugin("PENDULUM", p)
    ds = sk.LagrangianDS(q0, u0, np.array([[p["m"] * p["l"] ** 2]]))
    ds.setComputeFIntFunction(library, "inner_force")
    return ds, [plugin_contact(library, "wall", None, p["e"])]


def slider_crank(q0, u0, p):
    library = plugin("SLIDER_CRANK", p)
    ds = sk.LagrangianDS(q0, u0, np.eye(3))
    ds.setComputeMassFunction(library, "mass")
    ds.setComputeFIntFunction(library, "inner_force")
    corners = ("upper_left", "upper_right", "lower_left", "lower_right")
    return ds, [plugin_contact(library, corner, p["mu"], p["e"]) for corner in corners]


def belt(q0, u0, p):
    """The given normal force is the weight of a second coordinate."""
    library = plugin("BELT", p)
    ds = sk.LagrangianDS([*q0, 0.0], [*u0, 0.0], np.diag([p["m"], p["m"]]))
    ds.setComputeFIntFunction(library, "inner_force")
    ds.setComputeJacobianFIntqFunction(library, "stiffness")
    ds.setComputeJacobianFIntqDotFunction(library, "damping")
    return ds, [belt_contact(library, "belt", p["m0"], 0.0)]


def sprag_slip(q0, u0, p):
    """The bilateral contact is two unilateral ones with a little play, of which one at most is closed.

    Without play both would be closed: |la_F| <= mu (la_1 + la_2) with la_1 - la_2 given alone, so that the tip may
    wedge under any friction force. The gap is a coordinate, (g, th) with g = y - l sin th, and does not drift.
    """
    library = plugin("SPRAG_SLIP", p | {"play": PLAY})
    (y, th), (y_rate, th_rate), l = q0, u0, p["l"]
    ds = sk.LagrangianDS([y - l * math.sin(th), th], [y_rate - l * math.cos(th) * th_rate, th_rate], np.eye(2))
    ds.setComputeMassFunction(library, "mass")
    ds.setComputeFIntFunction(library, "inner_force")
    return ds, [belt_contact(library, side, p["mu"], 0.0) for side in ("above", "below")]


SCENES = {  # and whether there is friction
    "ball through Zeno": (ball, False),
    "sliding block": (block, True),
    "rod, slip and stick": (rod, True),
    "rocking block": (rocking_block, True),
    "pendulum against a wall": (pendulum, False),
    "bead chain": (beads, False),
    "slider-crank": (slider_crank, True),
    "woodpecker": (woodpecker, True),
    "belt, stick-slip": (belt, True),
    "sprag-slip, limit cycle": (sprag_slip, True),
    "sprag-slip, seizures": (sprag_slip, True),
}


COORDINATES = {  # of the model, where those of Siconos are others
    "belt, stick-slip": lambda q, p: q[:1],
    "sprag-slip, limit cycle": lambda q, p: q + [p["l"] * math.sin(q[1]), 0.0],
    "sprag-slip, seizures": lambda q, p: q + [p["l"] * math.sin(q[1]), 0.0],
}


def model_of(request):
    """The model at its start, and whether there is friction."""
    build, has_friction = SCENES[request["scene"]]
    ds, contacts = build(request["q0"], request["u0"], request["p"])
    model = sk.NonSmoothDynamicalSystem(0.0, request["times"][-1])
    model.insertDynamicalSystem(ds)
    for contact in contacts:
        model.link(contact, ds)
    return model, ds, has_friction


def simulation(request):
    """The model and its time stepping."""
    model, ds, has_friction = model_of(request)
    solver = sk.FrictionContact(2, sn.SICONOS_FRICTION_2D_LEMKE) if has_friction else sk.LCP()
    solver.numericsSolverOptions().dparam[sn.SICONOS_DPARAM_TOL] = TOLERANCE
    stepping = sk.TimeStepping(model, sk.TimeDiscretisation(0.0, request["dt"]), sk.MoreauJeanOSI(THETA), solver)
    stepping.setNewtonTolerance(NEWTON_TOLERANCE)
    stepping.setNewtonMaxIteration(NEWTON_ITERATIONS)
    return model, ds, stepping


def run(request):
    """One run, timed, and once more with its positions read."""
    model, ds, stepping = simulation(request)
    start = time.perf_counter()
    stepping.run()
    wall_time = time.perf_counter() - start
    if not request["read"]:
        return {"q": [], "wall_time": wall_time, "steps": round(request["times"][-1] / request["dt"])}
    model, ds, stepping = simulation(request)
    times, q, k = request["times"], [], 0
    place = COORDINATES.get(request["scene"], lambda q, p: q)
    t_0, q_0 = 0.0, place(np.array(ds.q()), request["p"])
    steps = 0
    while stepping.hasNextEvent():
        stepping.computeOneStep()
        t_1, q_1 = stepping.nextTime(), place(np.array(ds.q()), request["p"])
        while k < len(times) and times[k] <= t_1 * (1 + 1e-12):
            q.append((q_0 + (q_1 - q_0) * min(1.0, (times[k] - t_0) / (t_1 - t_0))).tolist())
            k += 1
        stepping.nextStep()
        t_0, q_0 = t_1, q_1
        steps += 1
    while len(q) < len(times):  # the last step may end a rounding early
        q.append(q_0.tolist())
    return {"q": q, "wall_time": wall_time, "steps": steps}


def run_events(request):
    """One run by LSODAR between located events, the times among them; frictionless scenes only."""
    model, ds, _ = model_of(request)
    simulated = sk.EventDriven(model, sk.TimeDiscretisation(0.0, request["times"][0]))
    simulated.insertIntegrator(sk.LsodarOSI())
    simulated.insertNonSmoothProblem(sk.LCP(), sk.SICONOS_OSNSP_ED_IMPACT)
    simulated.insertNonSmoothProblem(sk.LCP(), sk.SICONOS_OSNSP_ED_SMOOTH_ACC)
    t, q, steps, start = [0.0], [np.array(ds.q())], 0, time.perf_counter()
    while simulated.hasNextEvent():
        simulated.advanceToEvent()
        simulated.processEvents()
        t.append(simulated.startingTime())
        q.append(np.array(ds.q()))
        steps += 1
    wall_time = time.perf_counter() - start
    at = [q[int(np.argmin(np.abs(np.array(t) - moment)))].tolist() for moment in request["times"]]
    return {"q": at, "wall_time": wall_time, "steps": steps}


@contextlib.contextmanager
def quiet():
    """Keep what the library prints away from the answers."""
    kept = os.dup(1)
    os.dup2(2, 1)
    try:
        yield
    finally:
        os.dup2(kept, 1)
        os.close(kept)


def main():
    """Answer requests until there are no more."""
    folder = tempfile.TemporaryDirectory()
    os.chdir(folder.name)  # plugins are looked for here
    for line in sys.stdin:
        with quiet():
            try:
                request = json.loads(line)
                answer = run_events(request) if request["events"] else run(request)
            except Exception as error:  # the library raises its own types
                answer = {"error": f"{type(error).__name__}: {error}"}
            sys.stderr.flush()
        print(json.dumps(answer), flush=True)


if __name__ == "__main__":
    main()
