"""
A pulse through a chain of beads
================================

Twenty beads in a line and a wall. Each impact is located, and the velocities run to and fro as waves
that the restitution eats up.

The player: ``nonsmooth run bead-chain --view``.
"""

import matplotlib.pyplot as plt
import numpy as np

import nonsmooth as ns
from nonsmooth.catalogue import BeadChain

chain = BeadChain(n=20, e=0.9)
sol = ns.simulate(chain, (0, 0.12), *chain.state(velocity=1.0), integrator=ns.EventDriven())
t = np.linspace(0, 0.12, 601)
figure, axes = plt.subplots(figsize=(7, 3.8), layout="constrained")
image = axes.pcolormesh(t, np.arange(chain.n), sol(t).u.T, cmap="RdBu_r", vmin=-1, vmax=1)
figure.colorbar(image, label="velocity [m/s]")
axes.set(xlabel="t [s]", ylabel="bead, the wall behind the last", yticks=range(0, chain.n, 5))
q, u = chain.exact(t=0.12, velocity=1.0)
impacts = sum(event.kind.name == "IMPACT" for event in sol.events)
print(
    f"{impacts} impacts; positions to {np.abs(sol.q[-1] - q).max():.0e} m, "
    f"velocities to {np.abs(sol.u[-1] - u).max():.0e} m/s"
)
