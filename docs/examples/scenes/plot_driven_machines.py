"""
Driven machines
===============

A feeder shakes a part along, a car rolls over a bump of 4 mm, and a governor swings out. Dotted are the phases of the
part, in closed form, and the linear equations of the half car.
"""

import matplotlib.pyplot as plt
import numpy as np

import nonsmooth as ns
from nonsmooth.catalogue import CarOnBump, Governor, VibratingFeeder

drawn, (first, second, third) = plt.subplots(1, 3, figsize=(10.5, 3.4), layout="constrained")
for a, label in ((3e-4, "hops"), (1.5e-4, "slides")):
    feeder = VibratingFeeder(a=a)
    fed = ns.simulate(feeder, (0, 0.2), integrator=ns.MoreauJean(5e-5))
    first.plot(fed.t, 1e3 * (fed["part"].position[:, 0] - fed["plate"].position[:, 0]), label=f"a = {a:g} m, {label}")
    first.plot(fed.t, 1e3 * feeder.way(fed.t), "k:", lw=1)
first.set(xlabel="t [s]", ylabel="way on the plate [mm]", title="vibrating feeder (dotted: exact)")
first.legend()
car = CarOnBump()
ride = ns.simulate(car, (0, 1.2), integrator=ns.MoreauJean(1e-4), every=5)
height, linear = ride["chassis"].position[:, 1] - car.r, car.linear(ride.t)
second.plot(ride.t, 1e3 * np.array([height, ride["chassis"].turn]).T, label=["height [mm]", "pitch [mrad]"])
second.plot(ride.t, 1e3 * linear.T, "k:", lw=1)
second.set(xlabel="t [s]", title="car over a bump (dotted: linear)")
second.legend()
governor = Governor()
swung = ns.simulate(governor, (0, 2), integrator=ns.MoreauJean(1e-3))
third.plot(swung.t, np.degrees(governor.angle(swung)))
third.axhline(np.degrees(governor.rest()), color="0.3", ls=":")
third.set(xlabel="t [s]", ylabel="angle of the arms [°]", title="governor (dotted: where it rests)")
figure = swung.picture(times=(0, 0.5))
error = abs(height - linear[0]).max() / abs(linear[0]).max()
print(f"height of the car to {error:.1%} of the linear one; {swung.stats.missed} steps missed")
