"""Scenes of boxes and spheres on half-spaces in Siconos, run by the Python that has it (Debian: python3-siconos).

    python3 siconos_bodies.py

Reads a scene as a line of JSON, {"dt", "gravity", "bodies": [{"shape", "sizes", "mass", "moments", "x", "v"}],
"planes": [x], "mu", "e"}, x a position and a quaternion (w, x, y, z). Each number of steps that follows is answered by
{"seconds", "x"}: processor time of the steps, and the places of the bodies. Detection is Bullet's; Moreau-Jean with
theta = 1/2, Gauss-Seidel with a tolerance of 1e-8 and 1000 sweeps.
"""

import json
import os
import sys
import time

import numpy as np
import siconos.kernel as sk
import siconos.mechanics.collision as collision
import siconos.numerics as sn
from siconos.mechanics.collision.bullet import SiconosBulletCollisionManager, SiconosBulletOptions

TOLERANCE, SWEEPS = 1e-8, 1000
MARGIN = 0.04  # of the least size: by which Bullet rounds a box from within, without which its detection ends
SPARSE_BLOCKS = 1  # code: of a matrix in Siconos


def shape_of(body):
    """A shape that Bullet makes no wider."""
    if body["shape"] == "box":
        shape = collision.SiconosBox(*body["sizes"])
    else:
        shape = collision.SiconosSphere(*body["sizes"])
    shape.setInsideMargin(MARGIN * min(body["sizes"]))
    shape.setOutsideMargin(0.0)
    return shape


def dynamic(body, gravity):
    """A body with its weight."""
    ds = collision.RigidBodyDS(body["x"], body["v"], body["mass"], np.diag(body["moments"]))
    contactors = collision.SiconosContactorSet()
    contactors.append(collision.SiconosContactor(shape_of(body)))
    ds.setContactors(contactors)
    ds.setFExtPtr(body["mass"] * np.array(gravity))
    return ds


def simulation_of(scene):
    """The simulation of a scene, and its bodies."""
    nsds = sk.NonSmoothDynamicalSystem(0.0, 1e9)
    bodies = [dynamic(body, scene["gravity"]) for body in scene["bodies"]]
    for ds in bodies:
        nsds.insertDynamicalSystem(ds)
    manager = SiconosBulletCollisionManager(SiconosBulletOptions())
    for x in scene["planes"]:
        contactors = collision.SiconosContactorSet()
        contactors.append(collision.SiconosContactor(collision.SiconosPlane()))
        manager.insertStaticContactorSet(contactors, x)
    manager.insertNonSmoothLaw(sk.NewtonImpactFrictionNSL(scene["e"], 0.0, scene["mu"], 3), 0, 0)
    problem = sk.FrictionContact(3, sn.SICONOS_FRICTION_3D_NSGS)
    options = problem.numericsSolverOptions()
    options.dparam[sn.SICONOS_DPARAM_TOL], options.iparam[sn.SICONOS_IPARAM_MAX_ITER] = TOLERANCE, SWEEPS
    problem.setMaxSize(100_000)
    problem.setMStorageType(SPARSE_BLOCKS)
    problem.setNumericsVerboseMode(False)
    problem.setKeepLambdaAndYState(True)
    simulation = sk.TimeStepping(nsds, sk.TimeDiscretisation(0.0, scene["dt"]))
    simulation.insertIntegrator(sk.MoreauJeanOSI(0.5))
    simulation.insertNonSmoothProblem(problem)
    simulation.insertInteractionManager(manager)
    simulation.setNewtonOptions(sk.SICONOS_TS_LINEAR)
    simulation.setNewtonMaxIteration(1)
    return simulation, (bodies, nsds, manager)


def main():
    """Answer until the input ends."""
    answers = os.fdopen(os.dup(1), "w")
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)  # what Siconos says
    simulation, kept = simulation_of(json.loads(sys.stdin.readline()))
    for line in sys.stdin:
        began = time.process_time()
        for _ in range(int(line)):
            simulation.computeOneStep()
            simulation.nextStep()
        seconds = time.process_time() - began
        places = [np.asarray(ds.q()).tolist() for ds in kept[0]]
        answers.write(json.dumps({"seconds": seconds, "x": places}) + "\n")
        answers.flush()


if __name__ == "__main__":
    main()
