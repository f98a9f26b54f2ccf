"""
A car on springs over a bump
============================

Four springs with dampers hold two wheels to a chassis. They are rows of the contact problem, implicit
in the step, so that stiffness sets no largest step.
"""

import matplotlib.pyplot as plt

import nonsmooth as ns


def ride(stiffness, damping):
    car = ns.Scene(gravity=(0, -9.81), material=ns.Material(mu=0.8))
    car.fixed(ns.HalfPlane((0, 1)), name="road")
    car.fixed(ns.Capsule(0.3, 0.05), position=(1.5, 0.0), name="bump")
    car.body(ns.Box(1.6, 0.3), mass=20.0, position=(0, 0.5), velocity=(2.5, 0), name="chassis")
    for wheel, x in (("rear", -0.6), ("front", 0.6)):
        car.body(ns.Disc(0.15), mass=2.0, position=(x, 0.15), velocity=(2.5, 0), spin=-2.5 / 0.15, name=wheel)
        for end in (x - 0.3, x + 0.3):
            car.spring("chassis", wheel, at_a=(end, 0.5), stiffness=stiffness, damping=damping)
    return ns.simulate(car, (0, 2.0), integrator=ns.MoreauJean(dt=1e-3), every=5)


soft, stiff = ride(3e3, 80.0), ride(1e6, 80.0)
figure, axes = plt.subplots(figsize=(7, 3.5))
for sol, label in ((soft, "3 kN/m"), (stiff, "1000 kN/m")):
    axes.plot(sol.t, 1e3 * sol["chassis"].position[:, 1], label=label)
axes.set(xlabel="t [s]", ylabel="height of the chassis [mm]")
axes.legend(title="each spring")
missed = soft.stats.missed + stiff.stats.missed
print(f"worst residual {max(soft.residual.max(), stiff.residual.max()):.0e}, {missed} steps missed")
