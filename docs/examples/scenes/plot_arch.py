"""
An arch that is thick enough, and one that is not
=================================================

A semicircular arch stands if a line of thrust fits into it: from a thickness of 0.1075 of its radius on
with many stones. Just below it opens four hinges and falls.

The player: ``nonsmooth run masonry-arch --view``.
"""

import nonsmooth as ns
from nonsmooth.catalogue import MasonryArch

rough = ns.MoreauJean(dt=4e-3, contacts=ns.ContactSolver(tol=1e-6))
thick, thin = MasonryArch(n=21, ratio=0.115), MasonryArch(n=21, ratio=0.10)
stands = ns.simulate(thick, (0, 0.4), integrator=rough)
falls = ns.simulate(thin, (0, 1.0), integrator=rough, every=10)
figure = falls.picture(times=(0, 0.6, 1.0))
moved = abs(stands.position[-1] - stands.position[0]).max()
print(
    f"thick: {thick.stands()}, moved {moved:.0e} m; thin: {thin.stands()}; "
    f"least t/R {thin.least_ratio():.6f}; "
    f"{stands.stats.missed + falls.stats.missed} steps missed"
)
