"""
Which answer does a stiff contact take?
=======================================

The rigid rod by the complementarity problem, and the same rod on springs that become stiffer and
stiffer: how fast one tends to the other is measured, not assumed.
"""

# sphinx_gallery_thumbnail_path = "figures/penalty_branches.png"
import nonsmooth as ns
from nonsmooth.catalogue import PainleveRod

rod = PainleveRod(mu=0.5)
start = rod.state(th=1.0, thdot=0.0, slip=-1.0)
study = ns.penalty_study(rod, (0, 0.2), *start, stiffness=[1e4, 1e5, 1e6, 1e7, 1e8])
print(study.table())
figure = study.plot()
