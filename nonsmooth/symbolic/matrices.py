"""The derived matrices as SymPy expressions, to be looked at, checked on paper, or printed as LaTeX."""

from __future__ import annotations

import functools
from typing import Any

import sympy as sp

from nonsmooth.symbolic.equations import Equations
from nonsmooth.symbolic.refusals import require_possible


class Matrices:
    """The equations of a declaration, with nothing left bound.

    Attributes
    ----------
    M : Matrix (n, n)
    h : Matrix (n, 1)
    V : Expr
    K, C : Matrix (n, n)
        -dh/dq and -dh/du; zero where Jacobians were not asked for.
    g_N, W_N, w_N, W_F, w_F : Matrix
        (n_c, 1), (n_c, n), (n_c, 1), (n_c, n), (n_c, 1); rows of zeros where a contact has none.
    row_rates : Matrix (n_c, 2)
        W' u + w', normal and tangential.
    dW_N, dW_F : list of Matrix
        dW/dq_k, one (n_c, n) for each coordinate.
    """

    def __init__(self, declaration: Any, jacobians: bool) -> None:
        require_possible(declaration)
        self._equations = Equations(declaration.complete(), jacobians)
        self._n_c = len(declaration.declared.contacts)

    def _filled(self, name: str, rows: int, columns: int) -> Any:
        """A matrix of the entries of a function; an index of three parts has a single direction in its middle."""
        matrix = sp.zeros(rows, columns)
        for index, value in self._equations.functions.get(name, []):
            matrix[index[0], index[-1] if len(index) > 1 else 0] = self._equations.line.written_out(sp.S(value))
        return matrix

    @functools.cached_property
    def M(self) -> Any:
        """The mass matrix."""
        return self._filled("mass", self._equations.n, self._equations.n)

    @functools.cached_property
    def h(self) -> Any:
        """All smooth forces."""
        return self._filled("force", self._equations.n, 1)

    @functools.cached_property
    def V(self) -> Any:
        """The potential energy."""
        return self._filled("potential", 1, 1)[0]

    @functools.cached_property
    def K(self) -> Any:
        """-dh/dq."""
        return self._filled("stiffness", self._equations.n, self._equations.n)

    @functools.cached_property
    def C(self) -> Any:
        """-dh/du."""
        return self._filled("damping", self._equations.n, self._equations.n)

    @functools.cached_property
    def g_N(self) -> Any:
        """The gaps."""
        return self._filled("gap", self._n_c, 1)

    @functools.cached_property
    def W_N(self) -> Any:
        """The normal rows."""
        return self._filled("normal", self._n_c, self._equations.n)

    @functools.cached_property
    def w_N(self) -> Any:
        """dg_N/dt."""
        return self._filled("gap_rate", self._n_c, 1)

    @functools.cached_property
    def W_F(self) -> Any:
        """The tangential rows."""
        return self._filled("tangent", self._n_c, self._equations.n)

    @functools.cached_property
    def w_F(self) -> Any:
        """gamma_F at u = 0."""
        return self._filled("surface_velocity", self._n_c, 1)

    @functools.cached_property
    def row_rates(self) -> Any:
        """W' u + w'."""
        return self._filled("row_rates", self._n_c, 2)

    @functools.cached_property
    def dW_N(self) -> list[Any]:
        """dW_N/dq_k."""
        return [self.W_N.diff(q) for q in self._equations.q]

    @functools.cached_property
    def dW_F(self) -> list[Any]:
        """dW_F/dq_k."""
        return [self.W_F.diff(q) for q in self._equations.q]

    def latex(self) -> str:
        """M u' = h as LaTeX."""
        rates = sp.Matrix([sp.Symbol(rf"\ddot{{{sp.latex(q)}}}") for q in self._equations.q])
        return f"{sp.latex(self.M)} {sp.latex(rates)} = {sp.latex(self.h)}"
