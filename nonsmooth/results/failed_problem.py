"""The contact problem of the step that failed, of a system or of a scene: a file that ``nonsmooth solve`` opens again.

    gamma_1 = G P + c on the closed contacts, each with its kind and laws (docs/theory/moreau_jean.md)

It is the very problem: the step is taken once more from the state that it failed at, in fresh arrays, and what it hands
to the solver is kept. Solving it again calls the same solver with the same bits.
"""

from __future__ import annotations

import json
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from nonsmooth.checks.files import as_path, as_place, refusals
from nonsmooth.contact.network.matrices import Matrices
from nonsmooth.errors import InvalidInput
from nonsmooth.integrators.moreau_jean.contact import Scratch
from nonsmooth.integrators.moreau_jean.rows import StepRows
from nonsmooth.integrators.records import State
from nonsmooth.mechanics.laws import LAST_CODE, LAW_CODE, LAW_IMPACT, LAW_WIDTH, ImpactLaw
from nonsmooth.mechanics.system import GIVEN_FORCE, ContactMode
from nonsmooth.results.fclib import FCLIB_ENDINGS, ContactProblem, write_fclib
from nonsmooth.results.forms import REAL, WHOLE, Form, Rule, require_forms
from nonsmooth.results.npz import Archive, read_npz, write_npz
from nonsmooth.results.seal import require_kind
from nonsmooth.views import Worded, view

PROBLEM_SCHEMA, KIND = 1, "problem"  # code: of the form of the file
WHAT = "contact problem of a step"
ENDINGS = (".npz", *FCLIB_ENDINGS)
ARRAYS: dict[str, Rule] = {
    "G": (REAL, ("r", "r")), "c": (REAL, ("r",)), "gamma_0": (REAL, ("r",)), "start": (WHOLE, ("n + 1",)),
    "kinds": (WHOLE, ("n", 2)), "laws": (REAL, ("n", LAW_WIDTH)), "N": (REAL, ("n",)),
    "P_before": (REAL, ("n", "1 + d")), "mode_before": (WHOLE, ("n",)), "slip_before": (WHOLE, ("n",)),
}  # fmt: skip


@dataclass(frozen=True, eq=False, repr=False)
class FailedProblem(StepRows, Worded):
    """The closed contacts of the step that failed. n = contacts, r = rows, per contact N, (N, T) or (N, T1, T2),
    without N where it is given.

    Attributes
    ----------
    G : (r, r), c : (r,), gamma_0 : (r,)
        Delassus matrix [1/kg], velocity without impulses, with restitution [m/s], velocity before the step [m/s].
    start : (n + 1,) first row of each contact
    kinds : (n, 2) unilateral, bilateral or given force, and its directions of friction
    laws : (n, LAW_WIDTH) restitution and friction, as in mechanics/laws.py
    N : (n,) given normal forces [N]
    P_before : (n, 1 + d) impulses of the step before [N s], mode_before, slip_before : (n,)
    dt : float [s]
    selection : int, the rule where there are several solutions
    about : str, the message of the failure
    """

    about: str = ""

    @classmethod
    def of_step(cls, scratch: Scratch, state: State, kinds: np.ndarray, laws: np.ndarray, dt: float, selection: int,
                about: str) -> FailedProblem | None:  # fmt: skip
        """From the arrays that a step left, whose closed contacts were marked -1 before; None where none is closed."""
        closed = scratch.work.closed[scratch.work.closed >= 0]
        if closed.size == 0:
            return None
        start = scratch.work.start[: closed.size + 1].copy()
        r = int(start[-1])
        work = scratch.work
        return cls(
            work.G[:r, :r].copy(), work.c[:r].copy(), work.gamma_0[:r].copy(), start, kinds[closed], laws[closed],
            work.N[closed], state.P[closed], state.mode[closed], state.slip[closed], dt, selection, about,
        )  # fmt: skip

    def save(self, path: str | Path) -> Path:
        """Write to .npz: plain arrays under their names, and one JSON text ``about``; to .hdf5, .h5: FCLIB's form.

        Raises
        ------
        InvalidInput
            For a place that cannot be written, and laws that FCLIB has no place for.
        MissingExtra
            For .hdf5 and .h5 where h5py is not installed.
        FileFailure
        """
        path = as_place("path", path, ENDINGS)
        if path.suffix in FCLIB_ENDINGS:
            return view(self, "exchange")(self, path)
        about = {
            "schema": PROBLEM_SCHEMA,
            "kind": WHAT,
            "dt": self.dt,
            "selection": self.selection,
            "about": self.about,
        }
        arrays = {name: getattr(self, name) for name in ARRAYS}
        write_npz(path, KIND, {"about": np.array(json.dumps(about)), **arrays}, is_compressed=False)
        return path

    @classmethod
    def load(cls, path: str | Path) -> FailedProblem:
        """Read what ``save`` wrote to .npz; FCLIB files are read by ``read_fclib``.

        Raises
        ------
        InvalidInput
            When the file is not there, or is none of ours, or damaged.
        """
        path = as_path("path", path)
        with refusals(path, "holds no contact problem of a step"):
            return cls.of_archive(read_npz(path, require_failed_problem))

    @classmethod
    def of_archive(cls, found: Archive) -> FailedProblem:
        """From what a file holds."""
        about = found.about()
        if about["schema"] != PROBLEM_SCHEMA:
            raise InvalidInput(f"the contact problem has schema {about['schema']}; this version reads {PROBLEM_SCHEMA}")
        require_kind(found.kind, KIND)
        arrays = {name: np.ascontiguousarray(found.arrays[name]) for name in ARRAYS}
        problem = cls(**arrays, dt=float(about["dt"]), selection=int(about["selection"]), about=str(about["about"]))
        problem.require_rows()
        return problem

    def require_rows(self) -> None:
        """Raise unless the rows are those of the contacts, and the laws are ours."""
        kind, directions = self.kinds.T
        rows = directions + (kind != GIVEN_FORCE)
        last = (
            (kind, GIVEN_FORCE), (directions, 2), (self.laws[:, LAW_CODE], LAST_CODE),
            (self.laws[:, LAW_IMPACT], max(ImpactLaw)), (self.mode_before, max(ContactMode)),
            (abs(self.slip_before), 1),
        )  # fmt: skip
        is_known = np.all([(code >= 0) & (code <= largest) for code, largest in last])
        if not is_known or (np.diff(self.start) != rows).any() or self.start[0] != 0:
            raise InvalidInput("the contact problem must have rows for each contact, of kinds and laws that are known")
        if self.start[-1] != len(self.c) or not np.isfinite(self.G).all():
            raise InvalidInput("the contact problem must have rows for each contact, and finite entries")


def require_failed_problem(forms: Mapping[str, Form]) -> None:
    """Raise `ValueError` unless the arrays of a file are those of a ``FailedProblem``."""
    require_forms(forms, ARRAYS)


def is_failed_problem(names: Collection[str]) -> bool:
    """Whether the arrays of a file have the names of those of a ``FailedProblem``."""
    return {"about", *ARRAYS} <= set(names)


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
        path, problem = as_place("path", path, ENDINGS), self.problem
        if path.suffix in FCLIB_ENDINGS:
            write_fclib(path, problem)
            return path
        G = problem.G
        arrays = {"data": G.data, "indices": G.indices, "indptr": G.indptr, "shape": np.array(G.shape)}
        arrays |= {"q": problem.c, "mu": problem.mu, "dim": np.array(problem.dim)}
        write_npz(path, "sceneproblem", arrays, is_compressed=True)
        return path
