"""
How far does it slide?
======================

A block slides until friction has taken its energy, and then rests. Way and time are those of the
closed form, since the end of the slide is located.

The player: ``nonsmooth run sliding-block --view``.
"""

import matplotlib.pyplot as plt
import numpy as np

import nonsmooth as ns
from nonsmooth.catalogue import SlidingBlock

figure, axes = plt.subplots(figsize=(7, 3.6), layout="constrained")
t, errors = np.linspace(0, 2.5, 251), []
for mu in (0.1, 0.2, 0.3, 0.5):
    block = SlidingBlock(mu=mu)
    sol = ns.simulate(block, (0, 2.5), *block.state(speed=2.0), integrator=ns.EventDriven())
    errors.append(abs(sol["x"][-1] - block.position(2.5, speed=2.0)))
    line = axes.plot(t, sol(t).q[:, 0], label=f"μ = {mu}")[0]
    axes.plot(block.stop_time(2.0), block.stop_distance(2.0), "o", color=line.get_color())
axes.set(xlabel="t [s]", ylabel="x [m]", xlim=(0, 2.5), ylim=(0, None), title="dots: v²/(2μg) after v/(μg)")
axes.legend()
print(f"largest error of the way {max(errors):.0e} m; worst residual {sol.stats.worst_residual:.0e}")
