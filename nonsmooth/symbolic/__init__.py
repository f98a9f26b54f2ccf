"""Models from energies: positions, energies and contact points in, the source of a compiled model out. Needs SymPy."""
