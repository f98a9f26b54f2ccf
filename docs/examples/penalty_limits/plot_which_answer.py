"""
Which answer does a stiff contact take?
=======================================

The rigid rod by the complementarity problem, and the same rod on springs that become stiffer and
stiffer: how fast one tends to the other is measured, not assumed.
"""

import nonsmooth as ns
from nonsmooth.catalogue import PainleveRod

rod = PainleveRod(mu=0.5)
start = rod.state(th=1.0, thdot=0.0, slip=-1.0)
study = ns.penalty_study(rod, (0, 0.2), *start, stiffness=[1e4, 1e5, 1e6, 1e7, 1e8])
print(study.table())
figure = study.plot()
errors = study.data.error_q.values[:, 0]
print(
    f"error of the coordinates {errors[0]:.1e} at k = 1e4 N/m, "
    f"{errors[-1]:.1e} at 1e8: a factor {errors[0] / errors[-1]:.0f}"
)
