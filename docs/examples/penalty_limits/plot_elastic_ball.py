"""
An elastic ball keeps its energy
================================

A ball of 0.1 kg on a soft contact of 1000 N/m without a damper, dropped from 1 m: eleven bounces in ten
seconds (a scene of Kurtz and Castro 2025). Error control keeps its energy to the tolerance.
"""

import matplotlib.pyplot as plt
import numpy as np

import nonsmooth as ns
from nonsmooth.catalogue import BouncingBall

ball, errors = BouncingBall(m=0.1), {}
figure, (above, below) = plt.subplots(2, 1, figsize=(7, 5), layout="constrained")
for rtol in (1e-4, 1e-6, 1e-8):
    springs = ns.Penalty(stiffness=1e3, damping_ratio=0.0, rtol=rtol, atol=rtol / 100)
    sol = ns.simulate(ball, (0, 10), *ball.state(height=1.0), integrator=springs)
    elastic = 0.5 * 1e3 * np.minimum(sol["y"], 0.0) ** 2
    energy = sol.ledger["kinetic"] + ball.m * ball.g * sol["y"] + elastic
    below.semilogy(sol.t, np.abs(energy / energy[0] - 1) + 1e-16, label=f"rtol = {rtol:.0e}")
    errors[rtol] = abs(energy[-1] / energy[0] - 1)
t = np.linspace(0, 10, 4000)
above.plot(t, sol(t).q[:, 0])
above.set(xlabel="t [s]", ylabel="height [m]", xlim=(0, 10))
below.set(xlabel="t [s]", ylabel="error of the energy [-]", xlim=(0, 10))
below.legend()
bounces = np.sum(np.diff(np.sign(sol["y"])) < 0)
print(f"{bounces} bounces; energy lost {', '.join(f'{e:.0e}' for e in errors.values())}")
