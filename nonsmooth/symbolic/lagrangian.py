"""The declaration of a system by its energies: coordinates, parameters, bodies, forces and contacts, in paper order.

    d/dt dT/du - dT/dq + dV/dq + dR/du = Q + W_N^T la_N + W_F^T la_F

What is typed is checked here; `Equations` derives, `model_file` writes. SymPy is imported by whoever calls
`nonsmooth.lagrangian`, and by nothing else.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from nonsmooth.errors import MissingExtra

if TYPE_CHECKING:
    from nonsmooth.symbolic.declaration import Lagrangian


def lagrangian(name: str) -> Lagrangian:
    """A system to be declared by its energies; needs the extra [symbolic].

    Parameters
    ----------
    name : str
        For messages, titles and the name of the class.

    Returns
    -------
    Lagrangian
        Its methods take the declaration; ``model()`` derives the equations of motion and returns a model.

    Raises
    ------
    MissingExtra
        When SymPy is not installed.
    InvalidInput
        When the name has no letters.

    Examples
    --------
    >>> import sympy as sp
    >>> import nonsmooth as ns
    >>> l = ns.lagrangian("pendulum at a wall")
    >>> (th,) = l.coordinates("th", unit="rad")
    >>> m, a, g, e = l.parameters(m=(1.0, "kg"), a=(0.5, "m"), g=(9.81, "m/s^2"), e=0.8)
    >>> bob = (a * sp.sin(th), -a * sp.cos(th))
    >>> l.point_mass(m, at=bob)
    >>> l.gravity(g)
    >>> l.contact(point=bob, normal=(1, 0), e=e)
    >>> pendulum = l.model()
    >>> pendulum
    PendulumAtAWall(m=1.0, a=0.5, g=9.81, e=0.8)
    >>> sol = ns.simulate(pendulum, (0, 2), *pendulum.state(th=1.0), integrator=ns.EventDriven())
    >>> len(sol.events)
    3
    """
    return _declaration().Lagrangian(name)


def lagrangian_of(method: Any, parameters: Any, name: str = "system") -> Lagrangian:
    """The declaration of a system that `sympy.physics.mechanics` derived; contacts are added to it.

    Parameters
    ----------
    method : LagrangesMethod or KanesMethod
        With its equations formed, without constraints: these are bilateral contacts here. The speeds of Kane's method
        may be any that q' gives: they are replaced by it.
    parameters : dict
        Symbol -> value, (value, unit) or (value, unit, text).
    name : str
        As for `lagrangian`.

    Returns
    -------
    Lagrangian
        Expressions given to it may be in the dynamic symbols of the method, or in its own ``coordinates``.

    Raises
    ------
    MissingExtra
        When SymPy is not installed.
    InvalidInput
        For another object, equations that are not formed, constraints, and symbols without a value.

    Examples
    --------
    >>> import sympy as sp
    >>> from sympy.physics.mechanics import LagrangesMethod, dynamicsymbols
    >>> import nonsmooth as ns
    >>> y, (m, g) = dynamicsymbols("y"), sp.symbols("m g")
    >>> method = LagrangesMethod(m * y.diff()**2 / 2 - m * g * y, [y])
    >>> _ = method.form_lagranges_equations()
    >>> l = ns.lagrangian_of(method, {m: (1.0, "kg"), g: (9.81, "m/s^2")}, name="ball")
    >>> l.contact(gap=y, e=0.5)
    >>> l.model()
    Ball(m=1.0, g=9.81)
    """
    declared = _declaration()
    from nonsmooth.symbolic.foreign_mechanics import declared_by

    return declared_by(method, parameters, declared.Lagrangian(name))


def _declaration() -> Any:
    try:
        from nonsmooth.symbolic import declaration
    except ModuleNotFoundError as error:
        if error.name not in ("sympy", "mpmath"):
            raise
        raise MissingExtra('energies need SymPy; install it with pip install "nonsmooth[symbolic]"') from None
    return declaration
