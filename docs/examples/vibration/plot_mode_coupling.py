"""
Friction couples two modes
==========================

Two frequencies approach as the friction grows, meet, and one mode grows: flutter without any fall of
friction with speed. Damping moves the limit.

The player of the growing motion: ``nonsmooth run mode-coupling --view``.
"""

import numpy as np

import nonsmooth as ns
from nonsmooth.catalogue import ModeCoupling

path = ns.eigen_path(ModeCoupling(), "mu", np.linspace(0, 1, 101))
figure = path.plot()
found = ns.flutter_boundary(ModeCoupling(), "mu", (0.4, 0.7))
exact = ModeCoupling().critical_friction()
print(
    f"flutter above μ = {found.value:.9f}, "
    f"by its closed form {exact:.9f} ({ModeCoupling().critical_friction_undamped()} undamped)"
)
