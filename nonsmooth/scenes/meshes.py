"""Shapes from files of triangles: the convex hull of a mesh, or convex parts of it.

Files are read by trimesh, meshes cut by CoACD. Source: Wei, Liu, Ling, Su, *ACM Trans. Graph.* 41 (2022) 42.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from nonsmooth.checks.arrays import as_fraction, as_positive
from nonsmooth.checks.files import as_path
from nonsmooth.errors import InvalidInput, MissingExtra, NotUnderstoodWarning, said_by, warn_caller
from nonsmooth.scenes.convex_hull import MOST_CORNERS, hull_points
from nonsmooth.scenes.shapes import Compound, Polyhedron

HOLLOW = 0.01  # chosen: part of its volume by which the hull of a mesh may be larger without a word
STANDS_OUT = 1e-3  # chosen: part of the size by which corners may stand out of the hull of 200, without a word


def mesh(path: str | Path, *, scale: float = 1.0, cut: float | None = None) -> Polyhedron | Compound:
    """Read the shape of a body from an STL, OBJ, PLY or glTF file.

    Parameters
    ----------
    path : path-like
    scale : float
        Metres a unit of the file: 1e-3 of one in millimetres.
    cut : float, optional
        Cut the mesh into convex parts that differ from it by this part of its size at most, in (0, 1]: 0.05 is usual,
        and takes some seconds. Its convex hull is taken when left out.

    Returns
    -------
    Polyhedron or Compound
        In the axes of the file; of a hull of more than 200 corners those that stand out farthest.

    Raises
    ------
    MissingExtra
        Without trimesh, and without coacd where the mesh is cut.
    InvalidInput
        For a file that cannot be read, or has no volume.

    Warns
    -----
    NotUnderstoodWarning
        Where the hull is larger than the mesh by more than a hundredth, or leaves corners out, and where the mesh is
        not closed.

    Examples
    --------
    >>> from pathlib import Path
    >>> import nonsmooth as ns
    >>> tetrahedron = '''o t
    ... v 0 0 0
    ... v 1 0 0
    ... v 0 1 0
    ... v 0 0 1
    ... f 1 3 2
    ... f 1 2 4
    ... f 2 3 4
    ... f 3 1 4'''
    >>> _ = Path("t.obj").write_text(tetrahedron)
    >>> ns.mesh("t.obj", scale=0.1)
    Polyhedron(4 corners, 4 faces)
    """
    path, scale = as_path("path", path), as_positive("scale", scale, "m")
    tolerance = None if cut is None else as_fraction("cut", cut)
    if tolerance == 0.0:
        raise InvalidInput("cut must be above 0; got 0")
    loaded = read_mesh(path)
    if tolerance is None:
        return hull_of(path, loaded, scale)
    parts = convex_parts(loaded, tolerance)
    tell_of_corners(path, parts, scale)
    return Compound(*((Polyhedron(scale * corners), (0.0, 0.0, 0.0)) for corners, _ in parts))


def read_mesh(path: Path) -> Any:
    """The triangles of a file, all of its parts together."""
    try:
        import trimesh
    except ImportError:
        raise MissingExtra('files of meshes need trimesh; pip install "nonsmooth[mesh]" brings it') from None
    try:
        loaded: Any = trimesh.load(path, force="mesh")
        is_solid = len(loaded.vertices) > 3 and loaded.convex_hull.volume > 0.0
    except Exception as error:  # whatever trimesh and Qhull say of a file
        raise InvalidInput(f"{path} is no mesh that trimesh reads: {said_by(error)}") from error
    if not is_solid:
        raise InvalidInput(f"{path} has no volume; a shape needs one")
    return loaded


def hull_of(path: Path, loaded: Any, scale: float) -> Polyhedron:
    """The convex hull of a mesh, and a warning of what it is not."""
    corners, out = hull_points(np.asarray(loaded.vertices, dtype=float), MOST_CORNERS)
    if not loaded.is_watertight:
        warn_caller(f"{path} is not closed, and has no volume of its own: its hull is taken", NotUnderstoodWarning)
    elif loaded.convex_hull.volume > (1.0 + HOLLOW) * abs(loaded.volume):
        times = loaded.convex_hull.volume / abs(loaded.volume)
        warn_caller(
            f"{path} is not convex, and its hull, of {times:.3g} times its volume, is taken; cut=0.05 cuts it into "
            "convex parts", NotUnderstoodWarning,
        )  # fmt: skip
    tell_of_corners(path, [(corners, out)], scale)
    return Polyhedron(scale * corners)


def tell_of_corners(path: Path, hulls: list[tuple[np.ndarray, float]], scale: float) -> None:
    """Warn where corners that were left out stand out of a hull."""
    size, out = max(float(np.ptp(corners, axis=0).max()) for corners, _ in hulls), max(out for _, out in hulls)
    if out > STANDS_OUT * size:
        warn_caller(
            f"a hull of {path} has more than {MOST_CORNERS} corners: those left out stand out by {scale * out:.2g} m",
            NotUnderstoodWarning,
        )


def convex_parts(loaded: Any, tolerance: float) -> list[tuple[np.ndarray, float]]:
    """The corners (k, 3) of convex parts of a mesh, and how far others stand out."""
    try:
        import coacd
    except ImportError:
        raise MissingExtra('to cut a mesh needs coacd; pip install "nonsmooth[mesh]" brings it') from None
    coacd.set_log_level("error")
    parts = coacd.run_coacd(coacd.Mesh(loaded.vertices, loaded.faces), threshold=tolerance)
    return [hull_points(np.asarray(vertices, dtype=float), MOST_CORNERS) for vertices, _ in parts]
