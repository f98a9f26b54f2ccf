"""
A contact problem as a file
===========================

A step that is not solved as strictly as was asked is written as a contact problem in the form of FCLIB,
read again, and solved to the end. Other programs read the same file.
"""

import matplotlib.pyplot as plt
import numpy as np

import nonsmooth as ns
from nonsmooth.catalogue import Hourglass

hasty = ns.ContactSolver(sweeps=1, interior=0, on_residual="raise")
try:
    ns.simulate(Hourglass(n=60), (0, 0.6), integrator=ns.MoreauJean(dt=2e-3, contacts=hasty))
except ns.StepFailure as failure:
    path = failure.dump("step.hdf5")
problem = ns.read_fclib(path).local()
ns.write_fclib("local.hdf5", problem)  # for another program
found = ns.solve_contact(problem.G, problem.c, problem.mu, problem.dim)
P_N, P_T = found.P.reshape(-1, 2).T
figure, axes = plt.subplots(figsize=(7, 4), layout="constrained")
limit = np.array([0, 1.05 * P_N.max()])
axes.fill_between(limit, -0.3 * limit, 0.3 * limit, color="0.92", label="cone of friction")
axes.plot(P_N, P_T, "o", ms=4, label="impulses of the contacts")
axes.set(xlabel="normal impulse [N s]", ylabel="impulse of friction [N s]")
axes.legend()
print(f"{len(P_N)} contacts, {found.status.name}, residual {found.error:.0e}")
