"""Equations of motion that `sympy.physics.mechanics` derived, as a declaration to which contacts are added.

    M_s v' = f_s,  v = A q' + b      ->      M = A^T M_s A,    h = A^T (f_s - M_s (A' q' + b'))

v are the generalised speeds of Kane's method, which q' = Y v + z gives; of Lagrange's method v = q'. Source: Kane and
Levinson, *Dynamics* (1985), ch. 2.14.
"""

from __future__ import annotations

from typing import Any

import sympy as sp
from sympy.physics.mechanics import KanesMethod, LagrangesMethod, dynamicsymbols

from nonsmooth.checks.arrays import as_instance
from nonsmooth.errors import InvalidInput, said_by, shown
from nonsmooth.symbolic.parts import Given


def declared_by(method: Any, parameters: Any, into: Any) -> Any:
    """The declaration ``into`` with the coordinates, parameters, M and h of a method."""
    if not isinstance(method, KanesMethod | LagrangesMethod):
        raise InvalidInput(
            f"method must be a LagrangesMethod or KanesMethod of sympy.physics.mechanics; got {shown(method)}"
        )
    as_instance("parameters", parameters, dict, "a dict from symbols to values")
    q = list(method.q)
    names = [_name_of(symbol) for symbol in q]
    mine = into.coordinates(" ".join(names))
    rates = [symbol.diff(dynamicsymbols._t) for symbol in q]
    translation = (
        dict(zip(rates, into.rates, strict=True)) | dict(zip(q, mine, strict=True)) | {dynamicsymbols._t: into.t}
    )
    for symbol, value in parameters.items():
        if not isinstance(symbol, sp.Symbol):
            raise InvalidInput(f"parameters must have symbols as keys; got {shown(symbol)}")
        translation[symbol] = into.parameter(symbol.name, value)
    mass, force = _of_rates(method, q, rates)
    into.expressions.translation = translation
    check = into.expressions.of_state
    entries = [check("the mass matrix", entry) for entry in mass]
    h = tuple(check("the forcing", entry) for entry in force)
    n = len(q)
    into.declared.given.append(Given(tuple(tuple(entries[i * n : (i + 1) * n]) for i in range(n)), h))
    return into


def _name_of(symbol: Any) -> str:
    name = getattr(getattr(symbol, "func", None), "__name__", "")
    if not name:
        raise InvalidInput(f"coordinates must be dynamicsymbols; got {shown(symbol)}")
    return name


def _of_rates(method: Any, q: list[Any], rates: list[Any]) -> tuple[Any, Any]:
    """M and h for q' as velocities, free of second derivatives."""
    try:
        mass, forcing = sp.Matrix(method.mass_matrix), sp.Matrix(method.forcing)
    except Exception as error:
        raise InvalidInput(
            f"the equations of the method are not formed ({said_by(error)}): call form_lagranges_equations() or "
            "kanes_equations(...) first"
        ) from error
    n = len(q)
    if mass.shape != (n, n):
        raise InvalidInput(
            f"the method has constraints: a mass matrix {mass.shape} of {n} coordinates; hand it in without them, and "
            "add each as constraint(...), a bilateral contact"
        )
    if isinstance(method, LagrangesMethod):
        return mass, forcing
    return _of_speeds(method, mass, forcing, q, rates)


def _of_speeds(method: Any, mass: Any, forcing: Any, q: list[Any], rates: list[Any]) -> tuple[Any, Any]:
    """The same from the speeds of Kane's method."""
    if len(method.u) != len(q):
        raise InvalidInput(
            f"the method has {len(q)} coordinates and {len(method.u)} speeds: constraints of velocities have no place "
            "here, where q' = u"
        )
    given = method.kindiffdict()
    v = list(method.u)
    flow = sp.Matrix([given[rate] for rate in rates])
    Y = flow.jacobian(v)
    A = Y.inv()
    b = -A * flow.xreplace(dict.fromkeys(v, sp.S.Zero))
    speeds = dict(zip(v, A * sp.Matrix(rates) + b, strict=True))
    at_rest = {rate.diff(dynamicsymbols._t): sp.S.Zero for rate in rates}
    change = (A * sp.Matrix(rates) + b).diff(dynamicsymbols._t).xreplace(at_rest)
    h = A.T * (forcing - mass * change)
    return (A.T * mass * A).subs(speeds), h.subs(speeds)
