"""How far rounding moves a computed number. Every bound of a rounding error in this package is one of these.

    fl(x op y) = (x op y) (1 + d),                       |d| <= u                        (2.4)
    |fl(sum_i x_i y_i) - sum_i x_i y_i| <= gamma_n sum_i |x_i y_i|,    gamma_n = n u / (1 - n u)     (3.5)
    the doubles beside x are eps |x|/2 to eps |x| away from it                           (lemma 2.1)

in double precision, u = eps/2 = 2^-53. Here n u stands for gamma_n, which is more by n u of itself: by 1e-12 where n is
10^4. Source: Higham, *Accuracy and Stability of Numerical Algorithms*, 2nd edition, SIAM 2002.

A caller says how many roundings n its number has seen, and how large the terms were that it was made from. What is
farther above rounding (the smallest pivot, the width of a border) is no bound of it but a choice, and stands where it
is made.

Kernels call ``rounded_sum``; ``rounding_of_sum`` is the same source run by Python, which takes arrays too.
"""

from __future__ import annotations

from nonsmooth.jit import interpreted, kernel

EPS = 2.0**-52  # defined: distance from 1 to the next double
UNIT_ROUNDOFF = 0.5 * EPS  # derived: u, the largest relative error of one rounding to nearest, (2.4)
# derived: relative increments with the least error, of truncation and rounding together, of a forward and of a central
# difference. Source: Nocedal and Wright, *Numerical Optimization*, 2nd edition, section 8.1
FORWARD_INCREMENT, CENTRAL_INCREMENT = 2.0**-26, EPS ** (1 / 3)
NOTHING = 2.0**-960  # derived: what has decayed so far is zero to a difference: its increment would have too few digits


@kernel
def rounded_sum(n, size):
    """n u size: the rounding error of a sum whose terms are together as large as ``size``, after n roundings; (3.5)."""
    return n * UNIT_ROUNDOFF * size


rounding_of_sum = interpreted(rounded_sum)


@kernel
def spacing(x):
    """eps |x|: no less than the distance from x to the doubles beside it; lemma 2.1."""
    return EPS * abs(x)
