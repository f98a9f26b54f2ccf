"""What surfaces are made of, and what two of them do to one another.

    mu = sqrt(mu_a mu_b),    e = sqrt(e_a e_b),    and so the lengths of rolling and spinning friction, and adhesion

unless the pair was given its own: a rule, not a law of physics, that leaves equal materials as they are and has nothing
rebound from what swallows all. Laws of the sliding speed have no such mean: equal materials keep theirs, others are
given one. Coefficients belong to pairs; give those that matter by ``Scene.pair``.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, fields
from typing import Any

from nonsmooth.checks.arrays import as_fraction, as_name, as_non_negative
from nonsmooth.errors import InvalidInput, shown
from nonsmooth.mechanics.laws import IMPACT_LAWS, Coulomb, Friction, FrictionLaw, as_law
from nonsmooth.mechanics.signatures import takes
from nonsmooth.scenes.elliptic_friction import EllipticFriction
from nonsmooth.scenes.ranges import as_friction

# defined: beside mu and e: lengths of rolling and spinning friction [m], and the pull-off force of a point [N]
RESISTANCES = ("rolling", "spinning", "adhesion")


@dataclass(frozen=True)
class Material:
    """A surface.

    Parameters
    ----------
    mu : float, FrictionLaw or EllipticFriction
        Coefficient of friction against its like [-], or a law of the sliding speed, as `Stribeck`, `StaticKinetic` or
        ``Friction(mu)`` with a function mu(v) of one's own; or one that differs by direction, against a number.
    e : float
        Newton's coefficient of restitution against its like, 0 to 1 [-].
    name : str, optional
        By which ``Scene.pair`` finds it.
    impact : {"newton", "poisson", "energetic", "sequential"}, optional
        What e is a ratio of, as of `Contact`; of two materials the one that is given. What rebounds in a scene has one
        law. Others than Newton's are for islands of few contacts, and in space for those without friction.

    rolling, spinning : float, optional
        Lengths of rolling and spinning friction against its like [m]: the moments of a contact against the angular
        velocities of its bodies along its tangents, and along its normal, are at most these times what it presses. A
        ball of radius R rests on slopes up to atan(rolling/R).
    adhesion : float, optional
        F against its like [N]: a contact point that is closed stays closed up to a pull of F, and its friction is that
        of what it presses with F added to it. Once it is open nothing is left of it.

    Raises
    ------
    InvalidInput
        For mu < 0, lengths or adhesion < 0, or e outside [0, 1].

    Examples
    --------
    >>> import nonsmooth as ns
    >>> ns.Material(mu=0.8, e=0.1, name="rubber")
    Material(mu=0.8, e=0.1, name='rubber', impact=None, rolling=0.0, spinning=0.0, adhesion=0.0)
    """

    mu: float | FrictionLaw | EllipticFriction = 0.5
    e: float = 0.0
    name: str = ""
    impact: str | None = None
    rolling: float = 0.0
    spinning: float = 0.0
    adhesion: float = 0.0

    def __post_init__(self) -> None:
        if not isinstance(self.mu, EllipticFriction):
            object.__setattr__(self, "mu", as_mu(self.mu))
        object.__setattr__(self, "e", as_fraction("e", self.e))
        for what in RESISTANCES:
            object.__setattr__(self, what, as_non_negative(what, getattr(self, what)))
        if not isinstance(self.name, str):
            raise InvalidInput(f"the name of a material must be a text; got {shown(self.name)}")
        if self.impact is not None:
            as_name("impact law", self.impact, IMPACT_LAWS)


def as_mu(mu: Any) -> float | FrictionLaw:
    """A coefficient of friction or a law of numbers, or `InvalidInput`."""
    if isinstance(mu, EllipticFriction):
        raise InvalidInput("EllipticFriction goes with the axes of a body; give it to its material, Material(mu=...)")
    if not isinstance(mu, FrictionLaw):
        return as_friction("mu", as_law(mu).mu if isinstance(mu, Callable) else mu)  # type: ignore[attr-defined,arg-type]
    named = [field.name for field in fields(mu) if isinstance(getattr(mu, field.name), str)]
    if named:
        raise InvalidInput(f"{named[0]} of a law of a material must be a number, a scene has no parameters; got {mu}")
    if isinstance(mu, Friction) and not takes(getattr(mu.function, "py_func", mu.function), ("v",)):
        raise InvalidInput(f"a law of a material is a function mu(v) of the speed, a scene has no parameters; got {mu}")
    return mu.mu if isinstance(mu, Coulomb) else mu  # type: ignore[return-value]


def of_pair(a: Material, b: Material) -> tuple[float | FrictionLaw | EllipticFriction | None, float]:
    """mu and e of two materials by the rule above; no mu of two that have unlike laws, or two directions."""
    e = math.sqrt(a.e * b.e)
    match a.mu, b.mu:
        case (float(), float()):
            return math.sqrt(a.mu * b.mu), e
        case (EllipticFriction() as friction, float() as mu) | (float() as mu, EllipticFriction() as friction):
            return friction.against(mu), e
        case FrictionLaw(), FrictionLaw():
            return a.mu if a.mu == b.mu else None, e
    return None, e


def resistances_by_rule(a: Material, b: Material) -> tuple[float, ...]:
    """The ``RESISTANCES`` of two materials by the rule above."""
    return tuple(math.sqrt(getattr(a, what) * getattr(b, what)) for what in RESISTANCES)


def impact_of_pair(a: Material, b: Material) -> str | None:
    """The law of impact of two materials, that of either of them."""
    if a.impact is not None and b.impact is not None and a.impact != b.impact:
        raise InvalidInput(
            f"{a} and {b} have unlike laws of impact, and two bodies that strike have one; give both one"
        )
    return b.impact if a.impact is None else a.impact
