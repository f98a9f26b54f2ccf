"""
Paradoxes in a scene of bodies
==============================

Two rods are pushed over rough ground. One has no force to slide with and seizes; the other may lift
off, stick or slide on. The run names both, with the bodies.
"""

from pathlib import Path

import numpy as np

import nonsmooth as ns

scene = ns.Scene(gravity=(0, -9.81), material=ns.Material(mu=2.0), name="pushed rods")
scene.fixed(ns.HalfPlane((0, 1)), name="ground")
rod, th = ns.Capsule(1.0, 0.01), np.pi / 3
for name, x, rate in (("seized", 0, 0.0), ("thrown", 2, 6.0)):  # both tips slide to the left at 1 m/s
    arm = np.array([0.5 * np.cos(th), 0.5 * np.sin(th) + 0.01])
    velocity = (-1 - rate * arm[1], rate * arm[0])
    scene.body(rod, mass=1, position=(x, arm[1]), turn=th, velocity=velocity, spin=rate, name=name)
sol = ns.simulate(scene, (0, 0.2), integrator=ns.MoreauJean(dt=1e-3))
figure = sol.picture(times=(0, 0.1, 0.2))
page = Path("pushed_rods.html")
sol.view(page)
for event in sol.paradoxes:
    print(f"{event.i} on {event.j} at t = {event.t:.3f} s: {event.kind.name}, taken: {event.choice}")
