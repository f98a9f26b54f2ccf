"""The number whose multiples, modulo 1, are spread most evenly: directions and scales that no symmetry prefers.

    (sqrt(5) - 1)/2 = 0.618...

Source: Knuth, *The Art of Computer Programming* 3, section 6.4, theorem S.
"""

GOLDEN_RATIO = 0.6180339887498949  # derived: to the last place
