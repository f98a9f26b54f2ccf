"""Friction laws mu(v), v = |gamma_F| >= 0, and restitution.

Every law is a row of numbers, ``[code, c_0 .. c_4]``, so that one compiled loop serves them all and a sweep over a
coefficient never recompiles. A coefficient given as a string is the name of a parameter of the system.

    CONSTANT        mu(v) = mu
    STATIC_KINETIC  mu(0) = mu_s (limit of sticking),   mu(v > 0) = mu_k
    POLYNOMIAL      mu(v) = m0 - m1 v + m3 v^3
    STRIBECK        mu(v) = mu_k + (mu_s - mu_k) exp(-(v / v_s)^delta) + m_v v
    SMOOTHED        mu(v) = m0 (1 - exp(-r v)) - m1 v + m3 v^3,   mu(0) = 0: no sticking
    OWN             mu(v, p), a function of the user's (own_law.py)

Sources: the polynomial and the smoothed law are those of the mass on a conveyor (negative damping); Stribeck's curve as
in Armstrong-Hélouvry, Dupont, Canudas de Wit, *Automatica* 30 (1994) 1083, eq. (4).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields
from enum import IntEnum
from typing import Any, ClassVar

import numpy as np

from nonsmooth.checks.arrays import as_fraction, as_non_negative, as_number, as_positive
from nonsmooth.errors import InvalidInput, UnknownName, nearest, shown
from nonsmooth.jit import call_law, kernel, rare_kernel
from nonsmooth.mechanics.signatures import takes

CONSTANT, STATIC_KINETIC, POLYNOMIAL, STRIBECK, SMOOTHED = 0, 1, 2, 3, 4  # code: laws of friction
OWN = 99  # code: a law of the user's, whose row has addresses and is never read from a file

LAW_E_N, LAW_E_F, LAW_CODE, LAW_C = 0, 1, 2, 3  # code: columns of a contact's row of laws
LAW_IMPACT = 8  # code: column of the law of impact
LAW_WIDTH = 9  # derived: columns in all

Coefficient = float | str


class ImpactLaw(IntEnum):
    """How an impact ends: which quantity the coefficient e is a ratio of."""

    NEWTON = 0  # velocities
    POISSON = 1  # impulses
    ENERGETIC = 2  # works, e^2
    SEQUENTIAL = 3  # velocities, of several contacts one after the other (contact/planar/impacts.py)


IMPACT_LAWS = {law.name.lower(): law for law in ImpactLaw}
LAWS_OF_ONE = (ImpactLaw.NEWTON, ImpactLaw.POISSON, ImpactLaw.ENERGETIC)  # that say how the impact of one contact ends


@dataclass(frozen=True)
class FrictionLaw:
    """A friction law; use one of its subclasses."""

    code: ClassVar[int]

    def __post_init__(self) -> None:
        if any(isinstance(getattr(self, field.name), str) for field in fields(self)):
            return  # checked by the system that has the parameters
        self.check(self.coefficients({}))

    def coefficients(self, parameters: Mapping[str, float]) -> list[float]:
        """The numbers of the law, parameter names replaced by their values."""
        return [resolve(field.name, getattr(self, field.name), parameters) for field in fields(self)]

    def check(self, values: list[float]) -> None:
        """Raise `InvalidInput` when a resolved coefficient is out of range."""
        for field, value in zip(fields(self), values, strict=True):
            as_number(field.name, value)


@dataclass(frozen=True)
class Coulomb(FrictionLaw):
    """Constant friction coefficient mu >= 0."""

    mu: Coefficient
    code = CONSTANT

    def check(self, values: list[float]) -> None:
        """Raise `InvalidInput` for coefficients that break a rule."""
        as_non_negative("mu", values[0])


@dataclass(frozen=True)
class StaticKinetic(FrictionLaw):
    """A contact that sticks holds up to mu_s; one that slides is braked by mu_k <= mu_s."""

    mu_s: Coefficient
    mu_k: Coefficient
    code = STATIC_KINETIC

    def check(self, values: list[float]) -> None:
        """Raise `InvalidInput` for coefficients that break a rule."""
        as_non_negative("mu_k", values[1])
        as_non_negative("mu_s - mu_k", values[0] - values[1])


@dataclass(frozen=True)
class Polynomial(FrictionLaw):
    """mu(v) = m0 - m1 v + m3 v^3, with m1 in s/m and m3 in s^3/m^3. A negative mu(v) met in a run is an error."""

    m0: Coefficient
    m1: Coefficient = 0.0
    m3: Coefficient = 0.0
    code = POLYNOMIAL

    def check(self, values: list[float]) -> None:
        """Raise `InvalidInput` for coefficients that break a rule."""
        as_non_negative("m0", values[0])
        super().check(values)


@dataclass(frozen=True)
class Stribeck(FrictionLaw):
    """mu(v) = mu_k + (mu_s - mu_k) exp(-(v/v_s)^delta) + m_v v, with v_s in m/s and m_v in s/m."""

    mu_s: Coefficient
    mu_k: Coefficient
    v_s: Coefficient
    delta: Coefficient = 1.0
    m_v: Coefficient = 0.0
    code = STRIBECK

    def check(self, values: list[float]) -> None:
        """Raise `InvalidInput` for coefficients that break a rule."""
        as_non_negative("mu_s", values[0])
        as_non_negative("mu_k", values[1])
        as_positive("v_s", values[2], "m/s")
        as_positive("delta", values[3])
        as_number("m_v", values[4])


@dataclass(frozen=True)
class Smoothed(FrictionLaw):
    """mu(v) = m0 (1 - exp(-r v)) - m1 v + m3 v^3, with r in s/m. Without a jump at v = 0 there is no sticking."""

    m0: Coefficient
    r: Coefficient
    m1: Coefficient = 0.0
    m3: Coefficient = 0.0
    code = SMOOTHED

    def check(self, values: list[float]) -> None:
        """Raise `InvalidInput` for coefficients that break a rule."""
        as_non_negative("m0", values[0])
        as_positive("r", values[1], "s/m")
        super().check(values)


LAST_CODE = max(law.code for law in FrictionLaw.__subclasses__())  # derived: the largest code of a law


@dataclass(frozen=True)
class Friction(FrictionLaw):
    """A law of one's own: mu(v, p) of the sliding speed v = |gamma_F| >= 0 [m/s] and the parameters of the system.

    It is taken at the same speed as every law that varies with it: implicitly, in the middle of a step. It must be a
    finite number >= 0 and continuous for v >= 0, smooth but for a few corners; what it has at v = 0 is the limit of
    sticking, and with mu(0) = 0 there is no sticking.

    Parameters
    ----------
    function : callable
        ``mu(v, p)``, or ``mu(v)``, a plain Python function of numbers and ``math``; it is compiled when first used.

    Raises
    ------
    InvalidInput
        For what cannot be called so, and, by the system, where mu(0) is negative or no number.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> def leine(v, p):
    ...     return p.mu / (1.0 + 3.0 * v)
    >>> ns.Contact(mu=ns.Friction(leine)).law
    Friction(leine)
    """

    function: Callable[..., Any]
    code = OWN

    def __post_init__(self) -> None:
        function: Any = getattr(self.function, "py_func", self.function)
        if not callable(function):
            raise InvalidInput(f"a friction law must be a function mu(v, p); got {shown(self.function)}")
        if not takes(function, ("v", "p")) and not takes(function, ("v",)):
            raise InvalidInput(f"a friction law must take (v, p) or (v); got {shown(self.function)}")

    def coefficients(self, parameters: Mapping[str, float]) -> list[float]:
        """None that are numbers: the system writes where function and parameters are."""
        return []

    def check(self, values: list[float]) -> None:
        """Nothing here: its values are checked by the system, which has the parameters."""

    def __repr__(self) -> str:
        return f"Friction({getattr(self.function, '__name__', type(self.function).__name__)})"


def resolve(name: str, value: Coefficient, parameters: Mapping[str, float]) -> float:
    """A coefficient's number: itself, or the parameter it names."""
    if isinstance(value, str):
        if value not in parameters:
            raise UnknownName(f"{name} refers to the parameter {value!r}, which does not exist; "
                              + nearest(value, parameters))  # fmt: skip
        return float(parameters[value])
    return as_number(name, value)


def as_law(mu: Coefficient | FrictionLaw) -> FrictionLaw:
    """The law itself, or that of a constant coefficient."""
    if callable(mu) and not isinstance(mu, FrictionLaw):
        raise InvalidInput(f"mu is a function, {shown(mu)}; give the law of it, mu=ns.Friction(...)")
    return mu if isinstance(mu, FrictionLaw) else Coulomb(mu)


def law_row(
    law: FrictionLaw, e_N: Coefficient, e_F: Coefficient, impact: str, parameters: Mapping[str, float]
) -> np.ndarray:
    """One contact's laws as the row of numbers that the kernels read."""
    row = np.zeros(LAW_WIDTH)
    row[LAW_E_N] = as_fraction("e_N", resolve("e_N", e_N, parameters))
    row[LAW_E_F] = as_fraction("e_F", resolve("e_F", e_F, parameters))
    row[LAW_CODE] = law.code
    row[LAW_IMPACT] = IMPACT_LAWS[impact]
    coefficients = law.coefficients(parameters)
    law.check(coefficients)
    row[LAW_C : LAW_C + len(coefficients)] = coefficients
    return row


@kernel
def friction_coefficient(laws, i, v):
    """mu(v) of contact i at the sliding speed v > 0 (or its limit v -> 0)."""
    code = laws[i, LAW_CODE]
    a = laws[i, LAW_C]
    b = laws[i, LAW_C + 1]
    if code == CONSTANT:
        return a
    if code == STATIC_KINETIC:
        return b
    c = laws[i, LAW_C + 2]
    if code == POLYNOMIAL:
        return a + v * (c * v * v - b)
    if code == OWN:
        return own_coefficient(laws, i, v)
    if code == STRIBECK:
        return b + (a - b) * math.exp(-((v / c) ** laws[i, LAW_C + 3])) + laws[i, LAW_C + 4] * v
    return a * (1.0 - math.exp(-b * v)) + v * (laws[i, LAW_C + 3] * v * v - c)


@rare_kernel
def own_coefficient(laws, i, v):
    """mu(v) of a law of the user's: its machine code and the parameters by their addresses."""
    return call_law(int(laws[i, LAW_C]), int(laws[i, LAW_C + 1]), v)


@kernel
def copy_friction(laws, i, out, k):
    """The law of friction of contact i to row k of ``out``: written out, for loops over six numbers take longer."""
    a, b, c, d, e = LAW_C, LAW_C + 1, LAW_C + 2, LAW_C + 3, LAW_C + 4
    out[k, LAW_CODE] = laws[i, LAW_CODE]
    out[k, a], out[k, b], out[k, c], out[k, d], out[k, e] = laws[i, a], laws[i, b], laws[i, c], laws[i, d], laws[i, e]


@kernel
def is_no_friction(mu):
    """Whether a coefficient is none: negative, or not a number."""
    return not 0.0 <= mu < math.inf


@kernel
def static_coefficient(laws, i):
    """Largest |P_F| / P_N that contact i holds while it sticks; zero where the law has no sticking."""
    if laws[i, LAW_CODE] == STATIC_KINETIC:
        return laws[i, LAW_C]
    return friction_coefficient(laws, i, 0.0)


@kernel
def can_stick(laws, i):
    """Whether contact i has a jump of friction at v = 0, which holds it."""
    if laws[i, LAW_CODE] == OWN:
        return own_coefficient(laws, i, 0.0) > 0.0
    return laws[i, LAW_CODE] != SMOOTHED


@kernel
def depends_on_speed(laws, i):
    """Whether mu(v) of contact i varies with the sliding speed."""
    return laws[i, LAW_CODE] >= POLYNOMIAL
