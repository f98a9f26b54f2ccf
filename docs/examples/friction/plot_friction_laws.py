"""
Four laws of friction
=====================

The same oscillator under four laws: each falls with the sliding speed, three have a limit of sticking,
and the smoothed one never sticks. Their motions on a slow belt differ in what happens near rest.

The player: ``nonsmooth run belt-oscillator --view``.
"""

import matplotlib.pyplot as plt
import numpy as np

import nonsmooth as ns
from nonsmooth.catalogue import BeltOscillator

figure, (laws, motions) = plt.subplots(1, 2, figsize=(9, 3.6), layout="constrained")
speeds, shares = np.linspace(1e-6, 0.8, 400), {}
for name in ("cubic", "smoothed", "two-coefficient", "stribeck"):
    belt = BeltOscillator(vb=0.1, law=name)
    sol = ns.simulate(belt, (0, 12), *belt.state(), integrator=ns.EventDriven(rtol=1e-8))
    laws.plot(speeds, [belt.friction(v) for v in speeds], label=name)
    motions.plot(sol.t, sol["x"], label=name)
    sticks = sol.mode[1:, 0] == ns.ContactMode.STICK
    shares[name] = float(np.diff(sol.t)[sticks].sum() / sol.t[-1])
laws.set(xlabel="sliding speed [m/s]", ylabel="μ [-]", ylim=(0, None))
laws.legend()
motions.set(xlabel="t [s]", ylabel="x [m]", xlim=(0, 12))
print("share of the time that it sticks:", ", ".join(f"{name} {share:.2f}" for name, share in shares.items()))
