"""Questions asked of many runs: convergence, penalty limit, maps of paradoxes, work and precision."""
