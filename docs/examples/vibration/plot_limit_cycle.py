"""
A limit cycle of stick and slip, and its branch
===============================================

A mass on a belt, held by a spring. The cycle closes to rounding; its multiplier is 0, because the
stick forgets where the motion came from. Followed over the speed of the belt it loses its stick.

The player: ``nonsmooth run belt-oscillator --view``.
"""

import numpy as np

import nonsmooth as ns
from nonsmooth.catalogue import BeltOscillator

cycle = ns.limit_cycle(BeltOscillator(vb=0.2))
figure = cycle.plot()

# %%
# The branch of this cycle.

branch = ns.continue_cycle(BeltOscillator(), "vb", np.linspace(0.1, 0.4, 13))
drawn = branch.plot()
print(f"period {cycle.period:.9f} s, stick {cycle.stick_duration:.9f} s, multipliers {cycle.multipliers.round(9)}")
