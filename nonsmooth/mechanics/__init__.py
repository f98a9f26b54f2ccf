"""Systems and their laws, and the equations of a contact problem: rows, Delassus matrix, impact, admissible starts."""
