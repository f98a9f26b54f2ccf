"""Linear algebra, derivatives and quadratic programs, without mechanics."""
