"""
The sprag-slip rod over its paradox regions
===========================================

A rod that is pressed on a belt, its tip held by a bilateral contact with friction. It starts where
rigid mechanics has no solution: the tip seizes to the belt, and the velocities jump although nothing
collided.
"""

# sphinx_gallery_thumbnail_path = "figures/sprag_slip_regions.png"
from pathlib import Path

import nonsmooth as ns
from nonsmooth.catalogue import SpragSlip

rod = SpragSlip()
sol = ns.simulate(rod, (0, 3), *rod.state(th=0.78, thdot=1.0), integrator=ns.MoreauJean(dt=1e-4))

# %%
# Modes, states, forces and energies over the time, and the phase plane with the number of solutions of
# each region.

figure = sol.plot()

# %%
# The same run in the player (``nonsmooth run sprag-slip --view``): space starts it, *p* and *n* go from
# event to event.

page = Path("sprag_slip.html")
sol.view(page)
seized = sum(event.kind.name == "INCONSISTENT" for event in sol.paradoxes)
print(f"{seized} seizures in {sol.stats.steps} steps; worst residual {sol.stats.worst_residual:.0e}")
