"""The convex hull of points in space: its corners, and its faces as plane polygons.

Qhull makes triangles; those that lie in one plane are one face.

Source: Barber, Dobkin, Huhdanpaa, "The quickhull algorithm for convex hulls", ACM Trans. Math. Software 22, 1996.
"""

from __future__ import annotations

import numpy as np

from nonsmooth.errors import InvalidInput

# chosen: of the width of the hull: corners this far from a plane lie in it, some thousand roundings of coordinates that
# were turned
COPLANAR = 1e-11
# derived: keys have 19 bits for a feature, and two edges of 594 each, the most of 200 corners, are one of 360 000
MOST_CORNERS = 200

Loop = tuple[int, ...]


def convex_hull(points: np.ndarray) -> tuple[np.ndarray, tuple[Loop, ...]]:
    """The corners (n, 3) of the hull of points (k, 3), and its faces: corners, counterclockwise from outside.

    Examples
    --------
    >>> corners, faces = convex_hull(np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], float))
    >>> len(corners), [len(face) for face in faces]
    (8, [4, 4, 4, 4, 4, 4])
    """
    from scipy.spatial import ConvexHull

    hull = ConvexHull(points)
    slack = COPLANAR * float(np.ptp(points, axis=0).max())
    loops = [boundary(points, facets, hull) for facets in planes(points, hull, slack)]
    loops = [without_straight(points, loop, slack) for loop in loops]
    used = sorted({corner for loop in loops for corner in loop})
    if len(used) > MOST_CORNERS:
        raise InvalidInput(f"a Polyhedron has at most {MOST_CORNERS} corners; the hull of these points has {len(used)}")
    number = {corner: k for k, corner in enumerate(used)}
    return np.ascontiguousarray(points[used]), tuple(tuple(number[corner] for corner in loop) for loop in loops)


def planes(points: np.ndarray, hull: object, slack: float) -> list[list[int]]:
    """The triangles of each plane: those, beside one, whose corners lie in its plane."""
    taken, found = set(), []
    by_size = np.argsort([-area_of(points[simplex]) for simplex in hull.simplices], kind="stable")  # type: ignore[attr-defined]
    for first in by_size.tolist():
        if first in taken:
            continue
        normal, offset = hull.equations[first, :3], hull.equations[first, 3]  # type: ignore[attr-defined]
        group, front = [], [first]
        taken.add(first)
        while front:
            at = front.pop()
            group.append(at)
            for beside in hull.neighbors[at].tolist():  # type: ignore[attr-defined]
                corners = points[hull.simplices[beside]]  # type: ignore[attr-defined]
                if beside not in taken and np.abs(corners @ normal + offset).max() <= slack:
                    taken.add(beside)
                    front.append(beside)
        found.append(group)
    return found


def area_of(triangle: np.ndarray) -> float:
    """Twice the area."""
    return float(np.linalg.norm(np.cross(triangle[1] - triangle[0], triangle[2] - triangle[0])))


def boundary(points: np.ndarray, facets: list[int], hull: object) -> Loop:
    """The border of triangles of one plane: edges that only one of them has, one behind the other."""
    edges = set()
    for facet in facets:
        a, b, c = hull.simplices[facet].tolist()  # type: ignore[attr-defined]
        outward = hull.equations[facet, :3]  # type: ignore[attr-defined]
        if np.cross(points[b] - points[a], points[c] - points[a]) @ outward < 0:
            b, c = c, b
        edges |= {(a, b), (b, c), (c, a)}
    following = {start: end for start, end in edges if (end, start) not in edges}
    first = min(following)
    loop = [first]
    while following[loop[-1]] != first:
        loop.append(following[loop[-1]])
    return tuple(loop)


def without_straight(points: np.ndarray, loop: Loop, slack: float) -> Loop:
    """The loop without corners that lie on a straight edge."""
    kept = []
    for before, here, behind in zip((loop[-1], *loop[:-1]), loop, (*loop[1:], loop[0]), strict=True):
        edge = points[behind] - points[before]
        if np.linalg.norm(np.cross(edge, points[here] - points[before])) > slack * np.linalg.norm(edge):
            kept.append(here)
    return tuple(kept)


def hull_points(points: np.ndarray, most: int) -> tuple[np.ndarray, float]:
    """Corners of the convex hull of points (k, 3), the widest ones where there are more than so many; how far the
    others stand out of their hull [m].

    Those that stand out farthest of each face are taken until there are so many, as quickhull does.
    """
    from scipy.spatial import ConvexHull

    corners = points[ConvexHull(points).vertices]
    if len(corners) <= most:
        return corners, 0.0
    taken = {int(k) for axis in range(3) for k in (corners[:, axis].argmin(), corners[:, axis].argmax())}
    taken |= set(farthest_from(corners, taken))
    while True:
        hull = ConvexHull(corners[sorted(taken)])
        height = corners @ hull.equations[:, :3].T + hull.equations[:, 3]
        out = height.max(axis=1)
        out[sorted(taken)] = 0.0
        room = most - len(taken)
        if room == 0 or not out.max() > 0.0:
            return corners[sorted(taken)], float(max(0.0, out.max()))
        best = {int(k) for k in height.argmax(axis=0) if out[k] > 0.0} - taken
        taken |= set(sorted(best, key=lambda k: -out[k])[:room])


def farthest_from(corners: np.ndarray, taken: set[int]) -> list[int]:
    """Corners that make a hull of those taken have a volume: the farthest from their mean along each principal axis."""
    middle = corners - corners.mean(axis=0)
    axes = np.linalg.svd(middle, full_matrices=False)[2]
    along = middle @ axes.T
    return [int(k) for axis in range(3) for k in (along[:, axis].argmin(), along[:, axis].argmax())]
