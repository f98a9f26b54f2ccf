"""How the contact problems of a scene are solved: to which residual, and at what cost."""

from __future__ import annotations

from dataclasses import dataclass

from nonsmooth.checks.arrays import as_count, as_flag, as_tolerance
from nonsmooth.errors import InvalidInput, shown


@dataclass(frozen=True)
class ContactSolver:
    """Options of the contact problems of a scene.

    Parameters
    ----------
    tol : float
        Residual asked of each step, the largest of its islands [-]: |F| / max(|P|, R / tol), with F the natural map, P
        the impulses and R what rounding of the velocities does to F; relative to |P| alone where that is within tol.
    sweeps : int
        The most sweeps of block Gauss-Seidel over an island that is too large for a direct method; of discs and spheres
        four times as many while `tol` is in sight, and eight times while a step would drive bodies into one another by
        more than 3e-4 of the smallest shape, in space 1e-3.
    interior : int
        The most bodies of an island that interior points solve where nothing else came to `tol`; 0 is none. They take
        1 to 3 ms of 300 discs, 0.1 to 0.5 s of 1000 spheres that fall and 1 s of 2000 in a pile in the mean, and up to
        8 s. With `tol` above 1e-5 it is 200 at most.
    on_residual : {"warn", "raise"}
        What happens where the residual of a step is above ``tol``: one warning at the end, or a `StepFailure` there.
    may_sleep : bool
        Leave out steps that would change nothing: after one that began and ended at rest, with the impulses it was
        handed, all are the same until something is told to move. No bit of the result depends on it.

    Raises
    ------
    InvalidInput
        Unless 0 < tol < 1, sweeps >= 1, interior >= 0 and on_residual is one of the two.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> ns.MoreauJean(dt=1e-3, contacts=ns.ContactSolver(tol=1e-6)).contacts.tol
    1e-06
    """

    tol: float = 1e-8
    sweeps: int = 60
    interior: int = 6000
    on_residual: str = "warn"
    may_sleep: bool = True

    def __post_init__(self) -> None:
        as_flag("may_sleep", self.may_sleep)
        as_tolerance("tol", self.tol)
        as_count("sweeps", self.sweeps)
        as_count("interior", self.interior, 0)
        if not isinstance(self.on_residual, str) or self.on_residual not in ("warn", "raise"):
            raise InvalidInput(f"on_residual must be 'warn' or 'raise'; got {shown(self.on_residual)}")
