"""
Friction of a guide, of a grain and of what adheres
===================================================

A drawer of 2 kg, pulled by 10 N at 0.3 m from the middle of a guide of 0.4 m, slides as long as μ < h/(2 l) = 2/3. A
block that is thrown over wood turns to its grain, v_y = v_x^p with p = (0.6/0.2)^2. A ball that rolls below a ceiling
adheres to it by F, and falls where its weight is larger.
"""

import matplotlib.pyplot as plt
import numpy as np

import nonsmooth as ns

figure, (left, middle, right) = plt.subplots(1, 3, figsize=(10, 3.2), layout="constrained")
runs, mus = [], np.linspace(0.1, 1.0, 19)
for mu in mus:
    desk = ns.Scene(gravity=(0, 0))
    desk.fixed(ns.Disc(0.02), name="desk")
    desk.body(ns.Box(0.4, 0.6), mass=2.0, name="drawer")
    desk.slider("desk", "drawer", axis=(1, 0), friction=ns.GuideFriction(mu, length=0.4))
    desk.force("drawer", (10.0, 0), at=(0.2, 0.3))
    runs.append(ns.simulate(desk, (0, 1), integrator=ns.MoreauJean(dt=1e-2)))
left.plot(mus, [sol["drawer"].velocity[-1, 0] for sol in runs], "o", mus, np.maximum(0, 5 * (1 - 1.5 * mus)))
left.set(xlabel="μ", ylabel="acceleration [m/s²]", title="a drawer jams")
wood = ns.Material(mu=ns.EllipticFriction(along=0.2, across=0.6, direction=(1, 0, 0)))
for F, angle in zip((10, 15, 19.5, 19.7, 25), np.radians((15, 35, 55, 75, 89)), strict=True):
    hall = ns.Scene(gravity=(0, 0, -9.81), material=ns.Material(adhesion=F))
    hall.fixed(ns.HalfSpace((0, 0, 1)), material=wood)
    hall.fixed(ns.HalfSpace((0, 0, -1), -2.0))
    start = {"velocity": (np.cos(angle), np.sin(angle), 0)}
    hall.body(ns.Box(0.1, 0.1, 0.01), mass=1.0, position=(0, 0, 0.005), name="block", **start)
    hall.body(ns.Sphere(0.1), mass=2.0, position=(0, 0, 1.9), name="ball", **start)
    runs.append(ns.simulate(hall, (0, 0.5), integrator=ns.MoreauJean(dt=1e-3)))
    middle.plot(*runs[-1]["block"].position.T[:2])
    right.plot(runs[-1].t, runs[-1]["ball"].position[:, 2], label=f"{F} N")
middle.set(xlabel="x [m]", ylabel="y [m]", title="over wood", aspect="equal")
right.set(xlabel="t [s]", ylabel="z [m]", title="below a ceiling")
right.legend()
print(f"{sum(sol.stats.missed for sol in runs)} steps missed of {len(runs)} runs")
