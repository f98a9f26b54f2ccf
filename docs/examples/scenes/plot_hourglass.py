"""
Sand in an hourglass
====================

Discs run through a neck. How many have passed is nearly a straight line in time, as it is of sand.

The player: ``nonsmooth run hourglass --view``.
"""

import matplotlib.pyplot as plt

import nonsmooth as ns
from nonsmooth.catalogue import Hourglass

glass = Hourglass(n=60)
rough = ns.MoreauJean(dt=2e-3, contacts=ns.ContactSolver(tol=1e-6))
sol = ns.simulate(glass, (0, 1.2), integrator=rough, every=5)
figure = sol.picture(times=(0, 0.4, 1.2))
drawn, axes = plt.subplots(figsize=(7, 3.2), layout="constrained")
axes.plot(sol.t, glass.passed(sol))
axes.set(xlabel="t [s]", ylabel="discs below the neck", ylim=(0, glass.n))
print(
    f"{glass.passed(sol)[-1]} of {glass.n} have passed; residual {sol.stats.worst_residual:.0e}; "
    f"{sol.stats.missed} of {sol.stats.steps} steps missed"
)
