"""
A disc rolls into four blocks
=============================

Bodies have shapes; nobody writes their contacts down. Contact and friction of all of them are one
complementarity problem a step, solved to 1e-8.
"""

from pathlib import Path

import nonsmooth as ns

scene = ns.Scene(gravity=(0, -9.81), name="tower", t_end=1.0, dt=1e-3)
stone = ns.Material(mu=0.6, name="stone")
scene.fixed(ns.HalfPlane((0, 1)), material=stone, name="ground")
for k in range(4):
    scene.body(ns.Box(0.4, 0.2), density=2000, position=(0.05 * k, 0.1 + 0.2 * k), material=stone, name=f"block {k}")
scene.body(ns.Disc(0.15), density=2000, position=(-2.0, 0.15), velocity=(5.0, 0), material=stone, name="ball")

sol = ns.simulate(scene, integrator=ns.MoreauJean(dt=1e-3))
figure = sol.picture(n=3)

# %%
# The player shows what each contact does, and with which force.

page = Path("tower.html")
sol.view(page)
print(f"worst residual {sol.stats.worst_residual:.0e}; {sol.stats.missed} of {sol.stats.steps} steps missed")
