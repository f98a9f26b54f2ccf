"""
Andrews' squeezer
=================

Seven bodies on ten pins, a spring and a motor: its crank makes two turns and a half in 0.03 s. ``Adaptive`` takes it as
a system, and errs by no more than the angles of the test set do.
"""

import matplotlib.pyplot as plt
import numpy as np

import nonsmooth as ns
from nonsmooth.catalogue import AndrewsSqueezer

squeezer = AndrewsSqueezer()
sol = ns.simulate(squeezer, (0, 0.03), integrator=ns.Adaptive(1e-10, 1e-12), t_eval=np.linspace(0, 0.03, 301))
angles = squeezer.angles(sol)
drawn, axes = plt.subplots(figsize=(7, 3.4), layout="constrained")
for k, name in ((2, "γ"), (3, "Φ"), (4, "δ"), (6, "ε")):
    axes.plot(1e3 * sol.t, angles[:, k], label=name)
axes.set(xlabel="t [ms]", ylabel="angle [rad]")
axes.legend(ncols=4)
figure = sol.picture(times=(0, 0.011, 0.016))
print(f"seven angles at 0.03 s: {abs(angles[-1] - squeezer.published()).max():.1e} rad from the published ones")
