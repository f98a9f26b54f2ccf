"""A few contacts in the plane, on a dense matrix: every solution, or the word that there is none.

The contacts are one ``Problem`` (mechanics/contact_problem.py), into which the answer is written, beside ``Planar``,
the memory that the methods work in. ``problem`` has its residual, ``single`` one contact in closed form, ``ladder`` the
order of the methods for several; what the runs and ``classify`` call.
"""
