"""
A cycle with a seizure in every period
======================================

The sprag-slip rod on its belt: it slides into states without solution, seizes, sticks, and slides on.
The cycle is closed by Newton's method, the jump included.

The player: ``nonsmooth run sprag-slip --view``.
"""

import nonsmooth as ns
from nonsmooth.catalogue import SpragSlip

cycle = ns.limit_cycle(SpragSlip())
figure = cycle.plot()
for phase in cycle.phases:
    print(f"{phase.duration:.9f} s, until {phase.ends_by}")
print(f"period {cycle.period:.9f} s, stick {cycle.stick_duration:.9f} s, multipliers {cycle.multipliers.round(9)}")
