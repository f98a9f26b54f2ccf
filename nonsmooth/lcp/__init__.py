"""Linear complementarity problems: w = A z + b, 0 <= w _|_ z >= 0. Arrays only; no mechanics."""
