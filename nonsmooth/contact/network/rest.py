"""Whether an island is at rest, but for what its solution leaves: no body is fast beside what the impulses do.

    v_b^T M_b v_b <= share^2 mean over b of (v - v_free)_b^T M_b (v - v_free)_b        for every body b

At rest v - v_free is what gravity gives in a step.
"""

from __future__ import annotations

from nonsmooth.jit import kernel

RESTING = 1e-3  # chosen: 2e-5 m/s with gravity and steps of 2 ms; a residual of 1e-8 leaves some 1e-6 m/s


@kernel
def is_at_rest(network, k, n):
    """Whether island k is, at the velocities at hand."""
    islands, change, fastest = network.islands, 0.0, 0.0
    begin, end = islands.body_start[k], islands.body_start[k + 1]
    for at in range(begin, end):
        body, energy = islands.bodies[at], 0.0
        for x in range(n):
            for y in range(n):
                energy += network.v[body, x] * network.M[body, x, y] * network.v[body, y]
                moved = network.v[body, y] - network.v_free[body, y]
                change += (network.v[body, x] - network.v_free[body, x]) * network.M[body, x, y] * moved
        fastest = max(fastest, energy)
    return fastest * (end - begin) <= RESTING * RESTING * change
