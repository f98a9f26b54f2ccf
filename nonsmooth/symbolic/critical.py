"""The critical friction of a contact in closed form.

    gamma_N' = p la_N + b,    p = G_NN - mu_s G_NF,    p = 0  at  mu_P = G_NN/|G_NF|,    G = W M^-1 W^T

The functions of the model are run with symbols for numbers. Source: Génot and Brogliato, *Eur. J. Mech. A/Solids* 18
(1999) 653; the number at a state is `nonsmooth.critical_friction`.
"""

from __future__ import annotations

import types
from collections.abc import Callable
from dataclasses import dataclass, fields
from typing import Any

from nonsmooth.errors import InvalidInput, MissingExtra, said_by
from nonsmooth.mechanics.model_system import as_system
from nonsmooth.mechanics.system import FUNCTION_NAMES, TAKES_U

MOST_COORDINATES = 6  # chosen: coordinates: beyond them the closed form of an inverse fills pages


@dataclass(frozen=True)
class CriticalFriction:
    """mu_P of a contact.

    Attributes
    ----------
    expression : Expr
        In the coordinates, parameters and t, as real symbols of their names; infinite where p never vanishes.
        Parameters that are positive in the model were taken to be so.
    """

    expression: Any

    @property
    def latex(self) -> str:
        """The expression as LaTeX."""
        import sympy as sp

        return sp.latex(self.expression)

    def _repr_latex_(self) -> str:
        return f"$\\mu_P = {self.latex}$"

    def __str__(self) -> str:
        return str(self.expression)


def critical_friction(model: Any, contact: int | str = 0) -> CriticalFriction:
    """mu_P = G_NN/|G_NF| of a contact, simplified.

    Raises
    ------
    InvalidInput
        For a contact without a gap or without friction, more than 6 coordinates, or functions that branch on values.
    """
    system = as_system(model)
    contact = system.described.contact(contact)
    of = system.contacts[contact]
    if of.normal_force or not of.has_friction:
        raise InvalidInput(
            f"{system.described.contacts[contact]} has no gap or no friction, so there is no critical friction"
        )
    if system.n_q > MOST_COORDINATES:
        raise InvalidInput(
            f"the closed form is worked out up to {MOST_COORDINATES} coordinates; got {system.n_q}: "
            "nonsmooth.critical_friction finds the number"
        )
    W_N, W_F, M = _symbolic(model, system)
    n, f = W_N[contact, :], W_F[contact, :]
    as_typed = {symbol: type(symbol)(symbol.name, real=True) for part in (M, n, f) for symbol in part.free_symbols}
    return CriticalFriction(_quotient(M, n, f).xreplace(as_typed))


def _quotient(M: Any, n: Any, f: Any) -> Any:
    import sympy as sp

    by_minors = M.adjugate() if not M.is_diagonal() else sp.diag(*(1 / M[i, i] for i in range(M.rows)))
    normal, coupling = sp.simplify((n * by_minors * n.T)[0]), sp.simplify((n * by_minors * f.T)[0])
    return sp.simplify(normal / sp.Abs(coupling)) if coupling != 0 else sp.oo


def _symbolic(model: Any, system: Any) -> Any:
    """W_N (n_c, n), W_F (n_c, n) and M (n, n) as matrices of SymPy."""
    try:
        import sympy as sp
    except ModuleNotFoundError:
        raise MissingExtra('closed forms need SymPy; install it with pip install "nonsmooth[symbolic]"') from None
    known = system.described
    names = known.names if known.has_names else [f"q_{i}" for i in range(system.n_q)]
    from nonsmooth.symbolic.coordinate import Symbol

    q = [Symbol(name, real=True) for name in names]
    values = {entry.name: getattr(model, entry.name) for entry in fields(model)}
    positive = {name for name, value in values.items() if isinstance(value, float) and value > 0}
    symbols = {name: sp.Symbol(name, **{"positive" if name in positive else "real": True}) for name in values}
    p = types.SimpleNamespace(**symbols)
    t = sp.Symbol("t", real=True)
    matrices = []
    for name in ("normal", "tangent", "mass"):
        out = sp.MutableDenseNDimArray.zeros(*system.shape_of(FUNCTION_NAMES[name]))
        function = _with_symbols(getattr(system, name), sp)
        try:
            function(t, q, q, p, out) if FUNCTION_NAMES[name] in TAKES_U else function(t, q, p, out)
        except Exception as error:
            raise InvalidInput(f"the function {name} cannot be run with symbols: {said_by(error)}") from error
        matrices.append(
            sp.Matrix(out.shape[0], system.n_u, [sp.nsimplify(entry, rational=True) for entry in _flat(out)])
        )
    return matrices


def _flat(array: Any) -> list[Any]:
    return list(array.reshape(len(array)))


def _with_symbols(function: Any, sp: Any) -> Callable:
    """The function with the functions of ``math`` replaced by those of SymPy."""
    names = {"sin", "cos", "tan", "asin", "acos", "atan", "atan2", "sinh", "cosh", "tanh", "exp", "log", "sqrt", "pi"}
    stand_in = types.SimpleNamespace(**{name: getattr(sp, name) for name in names})
    return types.FunctionType(function.__code__, function.__globals__ | {"math": stand_in}, function.__name__)
