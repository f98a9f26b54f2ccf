"""Many contacts, in the plane or in space, on blocks of compressed rows; one algorithm a file.

``problem`` checks and scales, ``natural_map`` measures, ``solve`` chooses; the other files are the solvers.
"""
