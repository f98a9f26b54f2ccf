"""
A tippe-top
===========

An eccentric sphere that is spun about the vertical turns over, and rises: its friction takes energy,
but not Jellett's integral, the angular momentum along the arm from the contact to the centre of mass.

The player: ``nonsmooth run spinning-top --view``.
"""

import matplotlib.pyplot as plt
import numpy as np

import nonsmooth as ns
from nonsmooth.catalogue import SpinningTop

top = SpinningTop.tippe_top(eccentricity=0.2)
th, w = 0.1, 200.0
start = top.state(th=th, spin=w * np.cos(th), precession=w, slip_y=-top.h * w * np.sin(th))
sol = ns.simulate(top, (0, 3), *start, integrator=ns.MoreauJean(dt=1e-4), every=20)
axis, jellett = top.axis(sol.q), top.jellett(sol.q, sol.u)
figure, (left, right) = plt.subplots(1, 2, figsize=(9, 3.8), layout="constrained")
left.plot(sol.t, np.degrees(np.arccos(np.clip(axis[:, 2], -1, 1))))
left.set(xlabel="t [s]", ylabel="tilt of the axis [degrees]")
right.plot(sol.t, sol["w_z"], label="spin about the vertical")
right.axhline(top.spin_turned_over(w), color="0.3", ls=":", label="upside down, by Jellett's integral")
right.set(xlabel="t [s]", ylabel="[rad/s]", ylim=(0, None))
right.legend()
print(f"a top of 50 g sleeps above {SpinningTop().sleeping_spin():.1f} rad/s")
print(f"Jellett's integral is kept to {np.abs(jellett / jellett[0] - 1).max():.0e}")
