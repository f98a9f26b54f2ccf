"""
Stick and slip on a belt
========================

A mass on a moving belt, held by a spring. It is carried along until the spring pulls it off, slides
back, and is caught again. Every change between sticking and sliding is located as an event.

The same run in the player: ``nonsmooth run belt-oscillator --view``.
"""

import matplotlib.pyplot as plt

import nonsmooth as ns
from nonsmooth.catalogue import BeltOscillator

belt = BeltOscillator(vb=0.2)
sol = ns.simulate(belt, (0, 16), *belt.state(), integrator=ns.EventDriven(rtol=1e-9))
sticks = sol.mode[:, 0] == ns.ContactMode.STICK
figure, (over_time, plane) = plt.subplots(1, 2, figsize=(9, 3.6), layout="constrained")
over_time.plot(sol.t, sol["xdot"], label="mass")
over_time.plot(sol.t[sticks], sol["xdot"][sticks], "C1.", ms=5, label="sticks")
over_time.axhline(belt.vb, color="0.5", ls="--", lw=1, label="belt")
over_time.set(xlabel="t [s]", ylabel="velocity [m/s]", ylim=(-0.3, 0.42))
over_time.legend(ncols=3, loc="upper left")
plane.plot(sol["x"], sol["xdot"])
plane.set(xlabel="x [m]", ylabel="velocity [m/s]", ylim=(-0.3, 0.42))

cycle = ns.limit_cycle(belt)
stuck = sol["xdot"][sticks][1:] - belt.vb
changes = sum(event.kind.name == "MODE_CHANGE" for event in sol.events)
print(f"{changes} changes of mode, creep while it sticks {abs(stuck).max():.0e} m/s, period {cycle.period:.9f} s")
