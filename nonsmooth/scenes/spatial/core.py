"""The box core of a shape: its vertices and edges by number, points in its axes, and what is noted of a point.

vertex  bits 0, 1, 2: on the positive side of the axes x, y, z; along an axis without length on none
edge    4 axis + the bits of the two other axes, in their order

feature   vertex of i;   256 + vertex of j;   512 + 600 edge of i + edge of j;   512 + 600^2 the nearest points

A polyhedron has up to 200 vertices and 594 edges, so that these are numbers of 19 bits.
"""

from __future__ import annotations

from nonsmooth.jit import kernel, rare_kernel

VERTEX_OF_J = 256  # code: first feature of the vertices of j
TWO_EDGES = 512  # code: first feature of pairs of edges
EDGES = 600  # code: by which pairs of edges are numbered, more than a shape has
BOX_EDGES = 12  # derived: of a box
NEAREST_POINTS = TWO_EDGES + EDGES * EDGES  # code: feature of the nearest points where no corner is


@kernel
def sign_of(vertex, axis):
    """1 or -1, on which side of an axis a vertex is."""
    return 1.0 if vertex & (1 << axis) else -1.0


@rare_kernel
def vertex_at(shapes, scratch, s, vertex):
    """A vertex of a core from its centre, in world axes."""
    size, axis = shapes.size, scratch.axis
    x, y, z = 0.0, 0.0, 0.0
    for k in range(3):
        if size[s, k] > 0.0:
            half = sign_of(vertex, k) * size[s, k]
            x, y, z = x + half * axis[s, k, 0], y + half * axis[s, k, 1], z + half * axis[s, k, 2]
    return x, y, z


@kernel
def is_vertex(shapes, s, vertex):
    """Whether a core has this vertex: on the positive side only of axes along which it has a length."""
    for k in range(3):
        if vertex & (1 << k) and shapes.size[s, k] == 0.0:
            return False
    return True


@kernel
def edge_number(axis, vertex):
    """The edge along an axis through a vertex."""
    low, high = 1 if axis == 0 else 0, 1 if axis == 2 else 2
    return 4 * axis + (1 if vertex & (1 << low) else 0) + (2 if vertex & (1 << high) else 0)


@kernel
def edge_vertex(edge):
    """The vertex of an edge on the negative side of its axis."""
    axis = edge // 4
    low, high = 1 if axis == 0 else 0, 1 if axis == 2 else 2
    return (1 << low if edge & 1 else 0) | (1 << high if edge & 2 else 0)


@kernel
def in_axes(scratch, s, x, y, z):
    """The components of a world vector in the axes of a shape."""
    a = scratch.axis
    return (
        x * a[s, 0, 0] + y * a[s, 0, 1] + z * a[s, 0, 2],
        x * a[s, 1, 0] + y * a[s, 1, 1] + z * a[s, 1, 2],
        x * a[s, 2, 0] + y * a[s, 2, 1] + z * a[s, 2, 2],
    )


@kernel
def in_world(scratch, s, x, y, z):
    """The world components of a vector in the axes of a shape."""
    a = scratch.axis
    return (
        x * a[s, 0, 0] + y * a[s, 1, 0] + z * a[s, 2, 0],
        x * a[s, 0, 1] + y * a[s, 1, 1] + z * a[s, 2, 1],
        x * a[s, 0, 2] + y * a[s, 1, 2] + z * a[s, 2, 2],
    )


@kernel
def between(scratch, i, j):
    """From the centre of i to that of j."""
    c = scratch.centre
    return c[j, 0] - c[i, 0], c[j, 1] - c[i, 1], c[j, 2] - c[i, 2]


@rare_kernel
def note(manifold, n, gap, nx, ny, nz, feature):
    """Point n: its gap, its normal and its feature."""
    manifold.gap[n], manifold.feature[n] = gap, feature
    manifold.normal[n, 0], manifold.normal[n, 1], manifold.normal[n, 2] = nx, ny, nz


@rare_kernel
def note_place(scratch, n, s, x, y, z, back):
    """Point n: at (x, y, z) from the centre of shape s, and from there so far along its normal."""
    manifold, c = scratch.manifold, scratch.centre
    manifold.point[n, 0] = c[s, 0] + x + back * manifold.normal[n, 0]
    manifold.point[n, 1] = c[s, 1] + y + back * manifold.normal[n, 1]
    manifold.point[n, 2] = c[s, 2] + z + back * manifold.normal[n, 2]


@kernel
def turn_over(manifold, n):
    """The points of a pair (j, i) become those of (i, j)."""
    for k in range(n):
        manifold.feature[k] = exchanged(manifold.feature[k])
        for a in range(3):
            manifold.normal[k, a] = -manifold.normal[k, a]


@kernel
def exchanged(feature):
    """The feature of a pair (i, j) as one of (j, i)."""
    if feature < TWO_EDGES:
        return feature + (VERTEX_OF_J if feature < VERTEX_OF_J else -VERTEX_OF_J)
    if feature == NEAREST_POINTS:
        return feature
    edge_i, edge_j = (feature - TWO_EDGES) // EDGES, (feature - TWO_EDGES) % EDGES
    return TWO_EDGES + EDGES * edge_j + edge_i


@kernel
def order_points(manifold, n):
    """Put the points in the order of their features."""
    for k in range(1, n):
        m = k
        while m > 0 and manifold.feature[m - 1] > manifold.feature[m]:
            swap(manifold, m - 1, m)
            m -= 1


@kernel
def swap(manifold, k, m):
    """Exchange two points."""
    gap, feature, normal, point = manifold.gap, manifold.feature, manifold.normal, manifold.point
    gap[k], gap[m] = gap[m], gap[k]
    feature[k], feature[m] = feature[m], feature[k]
    for a in range(3):
        normal[k, a], normal[m, a] = normal[m, a], normal[k, a]
        point[k, a], point[m, a] = point[m, a], point[k, a]
