"""What surfaces are made of, and what two of them do to one another.

    mu = sqrt(mu_a mu_b),    e = sqrt(e_a e_b)

unless the pair was given its own: a rule, not a law of physics, that leaves equal materials as they are and has nothing
rebound from what swallows all. Coefficients belong to pairs; give those that matter by ``Scene.pair``.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from nonsmooth.checks.arrays import as_fraction
from nonsmooth.errors import InvalidInput, shown
from nonsmooth.mechanics.laws import FrictionLaw
from nonsmooth.scenes.ranges import as_friction


@dataclass(frozen=True)
class Material:
    """A surface.

    Parameters
    ----------
    mu : float
        Coefficient of Coulomb friction against its like [-].
    e : float
        Newton's coefficient of restitution against its like, 0 to 1 [-].
    name : str, optional
        By which ``Scene.pair`` finds it.

    Raises
    ------
    InvalidInput
        For mu < 0 or a friction law, or e outside [0, 1].

    Examples
    --------
    >>> import nonsmooth as ns
    >>> ns.Material(mu=0.8, e=0.1, name="rubber")
    Material(mu=0.8, e=0.1, name='rubber')
    """

    mu: float = 0.5
    e: float = 0.0
    name: str = ""

    def __post_init__(self) -> None:
        if isinstance(self.mu, FrictionLaw):
            raise InvalidInput(
                f"mu of a material must be a number, bodies rub by Coulomb's law; got {shown(self.mu)}; a law of the "
                "sliding speed stands at a contact of a System, Contact(mu=...)"
            )
        object.__setattr__(self, "mu", as_friction("mu", self.mu))
        object.__setattr__(self, "e", as_fraction("e", self.e))
        if not isinstance(self.name, str):
            raise InvalidInput(f"the name of a material must be a text; got {shown(self.name)}")


def of_pair(a: Material, b: Material) -> tuple[float, float]:
    """mu and e of two materials by the rule above."""
    return math.sqrt(a.mu * b.mu), math.sqrt(a.e * b.e)
