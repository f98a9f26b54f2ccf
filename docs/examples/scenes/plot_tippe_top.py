"""
A top that turns over
=====================

A ball with its centre of mass below its middle is spun, and friction turns it upside down. Jellett's
integral, which friction keeps, says what it may become.

The player: ``nonsmooth run tippe-top --view``.
"""

import matplotlib.pyplot as plt
import numpy as np

import nonsmooth as ns
from nonsmooth.catalogue import TippeTop

top = TippeTop()
sol = ns.simulate(top, (0, 2), integrator=ns.MoreauJean(dt=5e-4), record=("bodies",), every=10)
body = sol["top"]
jellett = top.jellett(body.turn, body.spin)
figure, (above, below) = plt.subplots(2, 1, figsize=(7, 4.6), sharex=True, layout="constrained")
above.plot(sol.t, np.degrees(np.arccos(np.clip(top.axis(body.turn)[:, 2], -1, 1))))
above.set(ylabel="tilt of its axis [°]", ylim=(0, 180))
below.plot(sol.t, jellett / jellett[0] - 1)
below.set(xlabel="t [s]", ylabel="change of Jellett's integral [-]", xlim=(0, 2))
print(
    f"Jellett's integral kept to {np.abs(jellett / jellett[0] - 1).max():.0e}; "
    f"{sol.stats.missed} of {sol.stats.steps} steps missed"
)
