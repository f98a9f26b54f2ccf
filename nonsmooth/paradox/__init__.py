"""How many contact forces fit a state, why, and what follows: the classification of Painlevé's paradoxes."""
