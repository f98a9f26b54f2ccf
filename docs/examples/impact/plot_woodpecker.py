"""
The woodpecker toy
==================

A sleeve with play on a pole, a spring and a woodpecker: it jams, swings, slips and pecks its way down.
Its motion closes but for the way down (Leine, Van Campen, Glocker 2003).

The player: ``nonsmooth run woodpecker --view``.
"""

import matplotlib.pyplot as plt
import numpy as np

import nonsmooth as ns
from nonsmooth.catalogue import Woodpecker

toy = Woodpecker()
sol = ns.simulate(toy, (0, 1), *toy.state(), integrator=ns.EventDriven(rtol=1e-8))
t = np.linspace(0, 1, 4001)
q = sol(t).q
figure, (height, angles) = plt.subplots(1, 2, figsize=(9, 3.6), layout="constrained")
height.plot(t, 1e3 * q[:, 0])
height.set(xlabel="t [s]", ylabel="height of the sleeve [mm]")
angles.plot(q[-1500:, 2], q[-1500:, 1])
angles.set(xlabel="angle of the woodpecker [rad]", ylabel="angle of the sleeve [rad]")
cycle = ns.limit_cycle(toy)
print(f"period {cycle.period:.9f} s, {-1e3 * cycle.drift[0]:.6f} mm down, multipliers {np.round(cycle.multipliers, 4)}")
