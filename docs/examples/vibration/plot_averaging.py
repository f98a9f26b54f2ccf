"""
How large does it become?
=========================

The amplitude of the belt oscillator by first-order averaging, and that of the cycles themselves. Beyond
the dashed line the oscillator never sticks, and the closed form is at home.
"""

import matplotlib.pyplot as plt
import numpy as np

import nonsmooth as ns
from nonsmooth.catalogue import BeltOscillator

belt = BeltOscillator()
speeds = np.linspace(belt.vb_min() + 1e-3, belt.vb_max() - 1e-3, 30)
averaged = [BeltOscillator(vb=v).averaged_amplitude() * belt.N / belt.k for v in speeds]
branch = ns.continue_cycle(belt, "vb", np.linspace(0.3, 0.43, 14))
figure, axes = plt.subplots(figsize=(7, 3.6), layout="constrained")
axes.plot(speeds, averaged, label="averaging, pure slip")
axes.plot(branch.values, [cycle.amplitudes[0] for cycle in branch.cycles], "o", ms=4, label="cycles")
axes.axvline(belt.vb_min(), color="0.5", ls="--", lw=1)
axes.set(xlabel="speed of the belt [m/s]", ylabel="amplitude [m]", ylim=(0, None))
axes.legend()
ends = [change for change in branch.changes if change.kind == "stick ends"]
print(f"stick ends at {ends[0].value:.9f} m/s, by averaging at {belt.vb_min():.6f} m/s")
