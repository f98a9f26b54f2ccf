"""
All shapes of space on one slope
================================

A sphere, a box, a capsule, a cylinder, an ellipsoid, a hull and a dumbbell start down a slope at once. Round
ones roll, flat ones stick.
"""

from pathlib import Path

import numpy as np

import nonsmooth as ns

alpha = np.radians(15)
gravity = (9.81 * np.sin(alpha), 0, -9.81 * np.cos(alpha))
scene = ns.Scene(gravity=gravity, material=ns.Material(mu=0.6), name="shapes")
scene.fixed(ns.HalfSpace((0, 0, 1)))
across = (np.sqrt(0.5), 0, 0, np.sqrt(0.5))  # the x-axis of the shape along y
hull = ns.Polyhedron([(x, y, z) for z, s in ((-0.1, 0.12), (0.1, 0.06)) for x in (-s, s) for y in (-s, s)])
dumbbell = ns.Compound((ns.Sphere(0.1), (-0.12, 0, 0)), (ns.Sphere(0.1), (0.12, 0, 0)))
shapes = {"sphere": ns.Sphere(0.1), "box": ns.Box(0.2, 0.2, 0.2), "capsule": ns.Capsule(0.2, 0.1)}
shapes |= {"cylinder": ns.Cylinder(0.1, 0.2), "ellipsoid": ns.Ellipsoid(0.15, 0.1, 0.1)}
shapes |= {"hull": hull, "dumbbell": dumbbell}
for k, (name, shape) in enumerate(shapes.items()):
    turned = {} if name in ("sphere", "box", "hull") else {"turn": across}
    scene.body(shape, density=1000, position=(0, 0.5 * k, 0.1), **turned, name=name)
sol = ns.simulate(scene, (0, 0.8), integrator=ns.MoreauJean(dt=2e-3), every=5)
figure = sol.picture(times=(0, 0.8))
page = Path("shapes.html")
sol.view(page)
ways = {name: sol[name].position[-1, 0] for name in shapes}
error = abs(ways["sphere"] - 5 / 7 * gravity[0] * 0.32)
print(
    f"stuck: {[name for name, way in ways.items() if way < 1e-9]}; the sphere's way to {error:.0e} m; "
    f"{sol.stats.missed} of {sol.stats.steps} steps missed"
)
