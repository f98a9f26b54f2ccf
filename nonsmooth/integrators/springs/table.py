"""Dormand and Prince's method of order 5 with an estimate of order 4, as tables, and the sums that a stage is made of.

    y_s = y_0 + h sum_(j < s) a_sj k_j,    y_1 = y_6 (the last stage),    error = h sum_j e_j k_j

Its last stage is the first one of the next step. Source: Dormand and Prince, *J. Comput. Appl. Math.* 6 (1980) 19-26;
Hairer, Norsett and Wanner, *Solving Ordinary Differential Equations I* (1993), table II.5.2.
"""

from __future__ import annotations

from nonsmooth.jit import kernel

STAGES = 7  # defined: by the method
LAST_STAGE = STAGES - 1  # derived: the stage at the end of the step
EMBEDDED_ORDER = 5  # derived: of the local error estimate, in the length of the step
# defined: rows of the table, a_sj
STAGE_WEIGHTS = (
    (0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
    (1 / 5, 0.0, 0.0, 0.0, 0.0, 0.0),
    (3 / 40, 9 / 40, 0.0, 0.0, 0.0, 0.0),
    (44 / 45, -56 / 15, 32 / 9, 0.0, 0.0, 0.0),
    (19372 / 6561, -25360 / 2187, 64448 / 6561, -212 / 729, 0.0, 0.0),
    (9017 / 3168, -355 / 33, 46732 / 5247, 49 / 176, -5103 / 18656, 0.0),
    (35 / 384, 0.0, 500 / 1113, 125 / 192, -2187 / 6784, 11 / 84),
)
# derived: where in a step the stages are
STAGE_NODES = (0.0, 1 / 5, 3 / 10, 4 / 5, 8 / 9, 1.0, 1.0)
# defined: weights of order 5 less those of order 4
ERROR_WEIGHTS = (71 / 57600, 0.0, -71 / 16695, 71 / 1920, -17253 / 339200, 22 / 525, -1 / 40)


@kernel
def stage_sum(k, s, row, column):
    """sum_(j < s) a_sj k[j, row, column]."""
    total = 0.0
    for j in range(s):
        total += STAGE_WEIGHTS[s][j] * k[j, row, column]
    return total


@kernel
def error_sum(k, row, column):
    """sum_j e_j k[j, row, column]."""
    total = 0.0
    for j in range(STAGES):
        total += ERROR_WEIGHTS[j] * k[j, row, column]
    return total
