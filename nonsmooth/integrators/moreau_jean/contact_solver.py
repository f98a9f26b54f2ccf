"""How the contact problems of a scene are solved: to which residual, and at what cost."""

from __future__ import annotations

from dataclasses import dataclass

from nonsmooth.checks.arrays import as_count, as_tolerance
from nonsmooth.contact.network.solve import NetworkSolver
from nonsmooth.errors import InvalidInput, shown


@dataclass(frozen=True)
class ContactSolver:
    """Options of the contact problems of a scene.

    Parameters
    ----------
    tol : float
        Residual of each step, |natural map| / |impulses| [-].
    sweeps : int
        The most sweeps of block Gauss-Seidel over an island that is too large for a direct method.
    on_residual : {"warn", "raise"}
        What happens where the residual of a step stays above ``tol``: one warning at the end, or a `StepFailure` there.
    """

    tol: float = 1e-8
    sweeps: int = 60
    on_residual: str = "warn"

    def __post_init__(self) -> None:
        as_tolerance("tol", self.tol)
        as_count("sweeps", self.sweeps)
        if not isinstance(self.on_residual, str) or self.on_residual not in ("warn", "raise"):
            raise InvalidInput(f"on_residual must be 'warn' or 'raise'; got {shown(self.on_residual)}")

    def start(self, dim: int) -> NetworkSolver:
        """A solver that begins a run."""
        return NetworkSolver(self.tol, self.sweeps)
