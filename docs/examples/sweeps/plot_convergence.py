"""
A convergence study in one call
===============================

Mode coupling at seven steps against a reference that follows a tolerance: orders, costs and a figure, with
the floor of what can be told.
"""

import numpy as np

import nonsmooth as ns
from nonsmooth.catalogue import ModeCoupling

study = ns.convergence_study(ModeCoupling(mu=0.6), (0, 0.3), state={}, dt=np.geomspace(1e-4, 3e-3, 7), progress=False)
figure = study.plot()
print(study.table())
orders = study.orders("error_q")
print(f"orders between steps {np.nanmin(orders):.2f} to {np.nanmax(orders):.2f}")
