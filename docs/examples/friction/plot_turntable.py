"""
A ball on a turning table
=========================

A ball that rolls on a turning table does not fly off: it goes round on a circle, at two sevenths of the
rate of the table, wherever it was started.

The player: ``nonsmooth run turntable --view``.
"""

import matplotlib.pyplot as plt
import numpy as np

import nonsmooth as ns
from nonsmooth.catalogue import Turntable

figure, axes = plt.subplots(figsize=(7, 4.6), layout="constrained")
errors = []
for v_y in (0.2, 0.6, 1.0):
    table = Turntable(v_y=v_y)
    sol = ns.simulate(table, (0, table.t_end), integrator=ns.MoreauJean(dt=table.dt))
    path = sol["ball"].position
    exact = np.array([table.position(t) for t in sol.t])
    errors.append(np.abs(path[:, :2] - exact[:, :2]).max())
    axes.plot(path[:, 0], path[:, 1], label=f"{v_y} m/s")
axes.plot(0, 0, "k+", label="axis of the table")
axes.set(xlabel="x [m]", ylabel="y [m]", aspect="equal", title="paths of the ball, seen from outside")
figure.legend(title="start along y", loc="outside right upper")
print(
    f"circles to {max(errors):.0e} m, worst residual {sol.stats.worst_residual:.0e}, "
    f"{sol.stats.missed} of {sol.stats.steps} steps missed"
)
