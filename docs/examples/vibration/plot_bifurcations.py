"""
Up and down the speed of a belt
===============================

Each simulation begins where the one before ended, first with rising speed, then with falling. Where
both agree there is one motion; what has not settled is a cross.
"""

import numpy as np

import nonsmooth as ns
from nonsmooth.catalogue import BeltOscillator

speeds = np.linspace(0.05, 0.38, 18)
diagram = ns.bifurcation_diagram(BeltOscillator(), "vb", speeds, duration=150.0, integrator=ns.MoreauJean(dt=5e-3))
figure = diagram.plot()
print(
    f"settled at {int(np.sum(diagram.settled))} of {np.size(diagram.settled)} speeds; "
    f"largest change {np.max(diagram.change):.1e}"
)
