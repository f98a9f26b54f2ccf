"""
Balls on hilly ground
=====================

Ground of a grid of heights, 18 by 18 cells: nine balls roll from its hills into the hollows between them.
"""

import numpy as np

import nonsmooth as ns

x = np.linspace(-1.5, 1.5, 19)
heights = 0.12 * np.cos(4 * x) * np.cos(4 * x[:, None]) + 0.15 * (x**2 + x[:, None] ** 2)
scene = ns.Scene(gravity=(0, 0, -9.81), material=ns.Material(mu=0.5, rolling=2e-3), name="hills")
scene.fixed(ns.heightfield(heights, (3, 3)), name="ground")
for k, place in enumerate(np.ndindex(3, 3)):
    a, b = 0.8 * (np.array(place) - 1) + 0.1
    scene.body(ns.Sphere(0.1), density=1000, position=(a, b, 0.55), name=f"ball {k}")
sol = ns.simulate(scene, (0, 3), integrator=ns.MoreauJean(dt=2e-3), every=5)
figure = sol.picture(times=(0, 3))
print(f"{len(scene.bodies[0].shape.parts)} prisms; deepest penetration {sol.penetration.max():.0e} m")
