"""Coulomb friction on an assembled Delassus matrix: contact problem in, impulses out; one algorithm a file.

``problem`` checks and scales, ``natural_map`` measures, ``solve`` chooses; the other files are the solvers.
"""
