"""
A pile of spheres in a box
==========================

A hundred spheres fall into a box; at every step some hundred contacts with friction in two directions
are solved together.
"""

from pathlib import Path

import nonsmooth as ns
from nonsmooth.catalogue import SphereBox

box = SphereBox(n=100)
sol = ns.simulate(box, (0, 1), integrator=ns.MoreauJean(dt=box.dt), every=10)
print(sol.summary())
figure = sol.picture(n=2)

# %%
# Energies, contacts, residuals and penetrations over the time.

drawn = sol.plot()

# %%
# In three dimensions: drag to turn, the wheel zooms.

page = Path("pile.html")
sol.view(page)
