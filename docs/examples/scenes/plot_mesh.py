"""
A body from the mesh of a file
==============================

A hexagonal plate, drawn in millimetres, starts at rest on a slope steeper than its friction holds. It slides as the
closed form says.
"""

import tempfile
from pathlib import Path

import numpy as np

import nonsmooth as ns

slope, mu, t_end = np.radians(25), 0.2, 0.6
around = np.arange(6) * np.pi / 3
corners = [(150 * np.cos(a), 150 * np.sin(a), z) for z in (-40, 40) for a in around]
fans = [face for k in range(2, 6) for face in ((1, k + 1, k), (7, k + 6, k + 7))]
sides = [
    face for k in range(6) for face in ((k + 1, (k + 1) % 6 + 1, k + 7), ((k + 1) % 6 + 1, (k + 1) % 6 + 7, k + 7))
]
lines = ["v {} {} {}".format(*corner) for corner in corners] + ["f {} {} {}".format(*face) for face in fans + sides]
plate = Path(tempfile.mkdtemp(), "plate.obj")
plate.write_text("\n".join(lines))
scene = ns.Scene(gravity=(9.81 * np.sin(slope), 0, -9.81 * np.cos(slope)), material=ns.Material(mu=mu), name="plate")
scene.fixed(ns.HalfSpace((0, 0, 1)))
scene.body(ns.mesh(plate, scale=1e-3), density=2700, position=(0, 0, 0.04), name="plate")
sol = ns.simulate(scene, (0, t_end), integrator=ns.MoreauJean(dt=2e-3), every=10)
figure = sol.picture(times=(0, t_end))
way = sol["plate"].position[-1, 0]
exact = (np.sin(slope) - mu * np.cos(slope)) * 9.81 * t_end**2 / 2
print(f"the way: {way:.9f} m; of the closed form: {exact:.9f} m")
