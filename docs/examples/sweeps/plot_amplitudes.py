"""
Amplitudes over a parameter
===========================

Many runs are a sweep: a task, its axes, and as many workers as there are cores. What has not settled
is marked, never drawn as a result.
"""

import numpy as np

import nonsmooth as ns
from nonsmooth.catalogue import BeltOscillator

belt = ns.RunTask(BeltOscillator(), ["amplitude", "period"], t_span=(0, 200), integrator=ns.MoreauJean(dt=1e-2))
found = ns.sweep(belt, {"vb": (np.linspace(0.05, 0.4, 40), "m/s")})
figure = ns.plot_sweep(found)
print(f"{found.amplitude.size} runs; {found.attrs['cells_unsettled']} not settled")
