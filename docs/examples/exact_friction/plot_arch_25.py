"""
An arch of 25 stones under falling cubes
========================================

The end stones are fixed; friction is 0.8. Four cubes fall on the crown, and the arch stands (after Song,
Fan, Ascher, Pai 2026; the size of the stones is ours).
"""

from pathlib import Path

import numpy as np

import nonsmooth as ns

scene = ns.Scene(gravity=(0, 0, -9.81), material=ns.Material(mu=0.8), name="arch")
scene.fixed(ns.HalfSpace((0, 0, 1)))
angles = np.linspace(0, np.pi, 26)
for k in range(25):
    corners = [(r * np.cos(a), y, r * np.sin(a)) for a in angles[k : k + 2] for r in (0.9, 1.1) for y in (-0.15, 0.15)]
    if k in (0, 24):
        scene.fixed(ns.Polyhedron(corners), name=f"stone {k}")
    else:
        scene.body(ns.Polyhedron(corners), density=1000, name=f"stone {k}")
for k in range(4):
    scene.body(ns.Box(0.1, 0.1, 0.1), density=1000, position=(0.12 * (k - 2), 0, 1.6), name=f"cube {k}")
sol = ns.simulate(scene, (0, 1.5), integrator=ns.MoreauJean(dt=1 / 60))
figure = sol.picture(times=(0, 0.5, 1.5))
page = Path("arch_25.html")
sol.view(page)
crown = sol["stone 12"].position
moved = np.abs(crown - crown[0]).max()
print(
    f"the crown moved by {moved:.0e} m; residual {sol.stats.worst_residual:.0e}; "
    f"{sol.stats.missed} of {sol.stats.steps} steps missed"
)
