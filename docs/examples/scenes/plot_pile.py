"""
A pile of spheres in a box
==========================

Fifty spheres fall into a box; at every step some two hundred contacts with friction in two directions
are solved together.
"""

from pathlib import Path

import nonsmooth as ns
from nonsmooth.catalogue import SphereBox

box = SphereBox(n=50)
sol = ns.simulate(box, (0, 0.6), integrator=ns.MoreauJean(dt=box.dt), every=10)
figure = sol.picture(n=2)

# %%
# Energies, contacts, residuals and penetrations over the time.

drawn = sol.plot()

# %%
# In three dimensions: drag to turn, the wheel zooms.

page = Path("pile.html")
sol.view(page)
print(f"worst residual {sol.stats.worst_residual:.0e}; {sol.stats.missed} of {sol.stats.steps} steps missed")
