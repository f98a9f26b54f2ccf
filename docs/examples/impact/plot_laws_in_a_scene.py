"""
A rod lands, by four laws of impact
===================================

A rod at 60° lands on its end, which slips and turns back meanwhile. The law is an argument of the material:
Newton's turns the normal velocity round, and may leave more energy than there was; Poisson's gives impulses
back, the energetic one gives work back.
"""

import warnings

import matplotlib.pyplot as plt
import numpy as np

import nonsmooth as ns

warnings.simplefilter("ignore", ns.EnergyGainWarning)  # by Newton's law
figure, axes = plt.subplots(figsize=(7, 3.6), layout="constrained")
coefficients, missed = np.linspace(0, 1, 11), 0
for law in ("newton", "poisson", "energetic"):
    kept = []  # of the kinetic energy
    for e in coefficients:
        scene = ns.Scene(gravity=(0, 0), material=ns.Material(mu=0.3, e=e, impact=law))
        scene.fixed(ns.HalfPlane((0, 1)))
        y = 0.5 * np.sin(np.pi / 3) + 0.02  # its end is 10 mm above the ground
        scene.body(ns.Capsule(1.0, 0.01), mass=1.0, position=(0, y), turn=np.pi / 3, velocity=(0.3, -1), name="rod")
        sol = ns.simulate(scene, (0, 0.02), integrator=ns.MoreauJean(dt=1e-3))
        kept.append(sol.ledger["kinetic"][-1] / sol.ledger["kinetic"][0])
        missed += sol.stats.missed
    axes.plot(coefficients, kept, "o-", ms=3, label=law)
axes.set(xlabel="restitution [-]", ylabel="kinetic energy that is left [-]")
axes.axhline(1, color="0.5", ls="--", lw=1)
axes.legend()
print(f"largest share of the energy that the energetic law leaves: {max(kept):.3f}; {missed} steps missed")
