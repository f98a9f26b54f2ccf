"""
Driven machines
===============

A feeder shakes a part along, a car rolls over a bump of 4 mm, a governor swings out, and the angles of Andrews'
squeezer, whose crank makes two turns and a half in 0.03 s.
"""

import matplotlib.pyplot as plt
import numpy as np

import nonsmooth as ns
from nonsmooth.catalogue import AndrewsSqueezer, CarOnBump, Governor, VibratingFeeder

drawn, ((first, second), (third, fourth)) = plt.subplots(2, 2, figsize=(8.4, 5.6), layout="constrained")
for a, label in ((3e-4, "it hops"), (1.5e-4, "it slides")):
    feeder = VibratingFeeder(a=a)
    fed = ns.simulate(feeder, (0, 0.2), integrator=ns.MoreauJean(5e-5))
    first.plot(fed.t, 1e3 * (fed["part"].position[:, 0] - fed["plate"].position[:, 0]), label=f"a = {a:g} m, {label}")
    first.plot(fed.t, 1e3 * feeder.way(fed.t), "k:", lw=1)
    print(f"conveys {1e3 * feeder.speed():.2f} mm/s where {label}")
first.set(xlabel="t [s]", ylabel="way on the plate [mm]", title="vibrating feeder")
first.legend(title="dotted: by its phases")
car = CarOnBump()
ride = ns.simulate(car, (0, 1.2), integrator=ns.MoreauJean(1e-4), every=5)
linear = car.linear(ride.t)
second.plot(ride.t, 1e3 * (ride["chassis"].position[:, 1] - car.r), label="height [mm]")
second.plot(ride.t, 1e3 * ride["chassis"].turn, label="pitch [mrad]")
second.plot(ride.t, 1e3 * linear.T, "k:", lw=1)
second.set(xlabel="t [s]", title="car over a bump")
second.legend(title="dotted: linear")
governor = Governor()
swung = ns.simulate(governor, (0, 2), integrator=ns.MoreauJean(1e-3))
third.plot(swung.t, np.degrees(governor.angle(swung)))
third.axhline(np.degrees(governor.rest()), color="0.3", ls=":", label="where it rests")
third.set(xlabel="t [s]", ylabel="angle of the arms [°]", title="governor")
third.legend()
squeezer = AndrewsSqueezer()
squeezed = ns.simulate(squeezer, (0, 0.03), integrator=ns.Adaptive(1e-10, 1e-12), t_eval=np.linspace(0, 0.03, 301))
angles = squeezer.angles(squeezed)
for k, name in ((2, "γ"), (3, "Φ"), (4, "δ"), (6, "ε")):
    fourth.plot(1e3 * squeezed.t, angles[:, k], label=name)
fourth.set(xlabel="t [ms]", ylabel="angle [rad]", title="Andrews' squeezer")
fourth.legend(ncols=2)
print(f"seven angles at 0.03 s: {abs(angles[-1] - squeezer.published()).max():.1e} rad from the published ones")
figure = swung.picture(times=(0, 0.5))
