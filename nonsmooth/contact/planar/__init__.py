"""A few contacts in the plane, on a dense matrix: every solution, or the word that there is none.

``problem`` has its arrays and its residual, ``single`` one contact in closed form, ``ladder`` the order of the methods
for several; what the runs and ``classify`` call.
"""
