"""Friction that differs by direction: of wood along and across its grain, of skates, of brushed metal.

    (P_1/mu_1)^2 + (P_2/mu_2)^2 <= P_N^2,    gamma_k = -s mu_k^-2 P_k,  s >= 0

Slip is along the normal of the ellipse (of all P in it, P.gamma is least), so friction is against slip along its axes
alone. Source: Michalowski and Mroz, *Arch. Mech.* 30 (1978) 259-276 (associated and non-associated sliding rules).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from nonsmooth.checks.arrays import as_vector
from nonsmooth.errors import InvalidInput, shown
from nonsmooth.scenes.ranges import as_friction

SPACE = 3  # defined: entries of a direction


@dataclass(frozen=True)
class EllipticFriction:
    """Coefficients of friction along and across a direction that goes with a body, in space.

    On a face that the direction does not lie in, the coefficient along its projection, of length s, is
    sqrt(s^2 along^2 + (1 - s^2) across^2), so on an end face it is that across.

    Parameters
    ----------
    along, across : float
        Coefficients [-] of all pairs with it, but those with mu = 0 and those that `Scene.pair` gives their own.
    direction : (3,)
        In the axes of the shape, of any length.

    Raises
    ------
    InvalidInput
        For coefficients that are not positive, and a direction without a length.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> wood = ns.Material(mu=ns.EllipticFriction(along=0.2, across=0.6, direction=(1, 0, 0)))
    >>> scene = ns.Scene(gravity=(0, 0, -10.0), material=ns.Material(mu=0.5))
    >>> floor = scene.fixed(ns.HalfSpace((0, 0, 1)), material=wood)
    >>> block = scene.body(ns.Box(0.1, 0.1, 0.01), mass=1.0, position=(0, 0, 0.005), velocity=(1, 1, 0), name="block")
    >>> v = ns.simulate(scene, (0, 0.15), integrator=ns.MoreauJean(dt=1e-4))["block"].velocity[-1]
    >>> abs(v[1] - v[0] ** 9) < 1e-3  # v_2 = v_1^(mu_2/mu_1)^2
    np.True_
    """

    along: float
    across: float
    direction: ArrayLike

    def __post_init__(self) -> None:
        for what in ("along", "across"):
            mu = as_friction(f"{what} of EllipticFriction", getattr(self, what))
            if mu == 0.0:
                raise InvalidInput(f"{what} of EllipticFriction must be positive; got {shown(getattr(self, what))}")
            object.__setattr__(self, what, mu)
        vector = as_vector("direction of EllipticFriction", self.direction, SPACE)
        size = np.abs(vector).max()
        if size == 0.0:
            raise InvalidInput(f"direction of EllipticFriction must have a length; got {shown(self.direction)}")
        object.__setattr__(self, "direction", tuple((vector / size).tolist()))

    def against(self, mu: float) -> EllipticFriction | float:
        """That of a pair with a material of mu."""
        return self if mu > 0.0 else 0.0
