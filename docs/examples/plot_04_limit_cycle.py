"""
A limit cycle of stick and slip, and its branch
===============================================

A mass on a belt, held by a spring. The cycle closes to rounding; its multiplier is 0, because the
stick forgets where the motion came from. Followed over the speed of the belt it ends in a fold.
"""

import numpy as np

import nonsmooth as ns
from nonsmooth.catalogue import BeltOscillator

cycle = ns.limit_cycle(BeltOscillator(vb=0.2))
print(f"period {cycle.period:.9f} s, stick {cycle.stick_duration:.9f} s, multipliers {cycle.multipliers}")
figure = cycle.plot()

# %%
# The branch of this cycle.

branch = ns.continue_cycle(BeltOscillator(), "vb", np.linspace(0.1, 0.4, 31))
drawn = branch.plot()
