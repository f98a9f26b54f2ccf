"""The contact problem that a step of a scene was not solved to: a file that ``nonsmooth solve`` opens again."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from nonsmooth.checks.files import as_place
from nonsmooth.contact.network.matrices import Matrices
from nonsmooth.results.fclib import FCLIB_ENDINGS, ContactProblem, write_fclib
from nonsmooth.results.npz import write_npz


class SceneProblem:
    """The islands of a step that stayed above the tolerance.

    Parameters
    ----------
    matrices : Matrices
        Rows and impulses.
    about : str
        The message of the failure.

    Attributes
    ----------
    problem : ContactProblem
        gamma = G P + c; its ``P`` are the best impulses that were found.
    """

    def __init__(self, matrices: Matrices, about: str) -> None:
        G, c, mu, P, d = matrices
        note = "the best impulses that the step found; they miss its tolerance"
        self.problem = ContactProblem(G, c, mu, d, P, note, about)

    def save(self, path: str | Path) -> Path:
        """Write to .npz, or to .hdf5 or .h5 in the form of FCLIB (needs the extra [io]); both are read by ``nonsmooth
        solve``.

        Raises
        ------
        InvalidInput, MissingExtra, FileFailure
        """
        path = as_place("path", path, (".npz", *FCLIB_ENDINGS))
        problem = self.problem
        if path.suffix in FCLIB_ENDINGS:
            write_fclib(path, problem)
            return path
        G = problem.G
        arrays = {"data": G.data, "indices": G.indices, "indptr": G.indptr, "shape": np.array(G.shape)}
        arrays |= {"q": problem.c, "mu": problem.mu, "dim": np.array(problem.dim)}
        write_npz(path, "sceneproblem", arrays, is_compressed=True)
        return path
