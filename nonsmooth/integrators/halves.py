"""Steps that are taken whole and as two halves: how long the next one is, and how much each may err.

    h' = h min(MOST_GROWTH, max(MOST_SHRINKING, CAUTION error^(-1/order)))

A step with an error of the whole tolerance, or less, is kept. Of systems: adaptive/in_space.py; of scenes:
assembly/controlled.py.
"""

from __future__ import annotations

HALVES = 2  # defined: into which a step is divided
SHORT_PART = 1e-4  # chosen: of the run, steps that may err as one of this length: those that follow an impact
OF_A_LANDING = 0.1  # chosen: of the tolerance, the error of a step with an impact: so many of a run add up to it
CAUTION, MOST_SHRINKING, MOST_GROWTH = 0.9, 0.1, 4.0  # chosen: of a step after its error, as usual
FIRST_PART = 1e-3  # chosen: of the run, the first step that is tried
NO_STEP = 1e-14  # chosen: of the run: a step as short is a rounding of the time
