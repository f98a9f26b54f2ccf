"""
A stack on springs
==================

Five boxes on springs sink by what they carry over the stiffness. The error against rigid boxes falls as
1/k, with the constant that statics gives.
"""

import numpy as np

import nonsmooth as ns
from nonsmooth.catalogue import BoxStack

stack = BoxStack(n=5, dim=2)
study = ns.penalty_study(stack, (0, 0.2), stiffness=[1e7, 1e8, 1e9])
figure = study.plot()
errors = np.ravel(study.data.error_q)
print(f"error times stiffness: {', '.join(f'{e * k:.1f}' for e, k in zip(errors, (1e7, 1e8, 1e9), strict=True))} N")
