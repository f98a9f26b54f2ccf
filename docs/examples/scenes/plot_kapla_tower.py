"""
A tower of planks
=================

Fifteen layers of planks, each across the one below. They stand still, and the ground carries their
weight.

The player: ``nonsmooth run kapla-tower --view``.
"""

import nonsmooth as ns
from nonsmooth.catalogue import KaplaTower

tower = KaplaTower()
sol = ns.simulate(tower, (0, 0.2), integrator=ns.MoreauJean(dt=tower.dt))
figure = sol.picture()
load = abs(sol.contacts().of("ground").P_N.sum() / tower.dt)
moved = abs(sol.position[-1] - sol.position[0]).max()
print(
    f"on the ground {load:.6f} N, weight {tower.load(0):.6f} N; moved {moved:.0e} m; "
    f"residual {sol.stats.worst_residual:.0e}"
)
