"""A core and a half-space: every vertex is a point of contact.

    d = n . (c + a_k - o),    g_N = d - r,    p = c + a_k - n (d + r)/2

with the outward normal n of the half-space and a point o of its border. The core is outside where all its vertices are:
the points are all the conditions there are.
"""

from __future__ import annotations

from nonsmooth.jit import rare_kernel
from nonsmooth.scenes.shape_rows import HALF_SPACE
from nonsmooth.scenes.spatial.core import VERTEX_OF_J, between, is_vertex, note, note_place, vertex_at


@rare_kernel
def core_on_half_space(shapes, scratch, i, j, limit):
    """The points of a pair whose gaps are below the limit; returns how many."""
    is_first = shapes.kind[i] == HALF_SPACE  # the half-space is i
    plane, core = (i, j) if is_first else (j, i)
    nx, ny, nz = scratch.axis[plane, 2, 0], scratch.axis[plane, 2, 1], scratch.axis[plane, 2, 2]
    r, sign, first = shapes.radius[core], 1.0 if is_first else -1.0, VERTEX_OF_J if is_first else 0
    x, y, z = between(scratch, plane, core)
    height = nx * x + ny * y + nz * z
    if height - shapes.reach[core] - r >= limit:
        return 0
    n = 0
    for vertex in range(8 if shapes.reach[core] > 0.0 else 1):
        if is_vertex(shapes, core, vertex):
            x, y, z = vertex_at(shapes, scratch, core, vertex)
            d = height + (nx * x + ny * y + nz * z)
            if d - r < limit:
                note(scratch.manifold, n, d - r, sign * nx, sign * ny, sign * nz, first + vertex)
                note_place(scratch, n, core, x, y, z, -0.5 * sign * (d + r))
                n += 1
    return n
