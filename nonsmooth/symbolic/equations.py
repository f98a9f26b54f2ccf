"""Lagrange's equations of declared energies, as a straight-line program.

    M_ij = sum w J_i J_j + J_i.I J_j + d2T/du_i du_j,         J_i = dr/dq_i, or d omega/du_i
    h_i  = sum J_i w (g - r'') - J_i.(I omega' + omega x I omega) + dT/dq_i - (dT/du_i)'
           - dV/dq_i - dR/du_i + J_i.F                        with the primes at u' = 0
    K = -dh/dq,  C = -dh/du,   W_N = dg_N/dq,  w_N = dg_N/dt,  W_F = d gamma_F/du,  w_F = gamma_F at u = 0
    row rates: gamma_N' and gamma_F' at u' = 0

r'' at u' = 0 holds what Christoffel's symbols sum: J_i w r'' = Gamma_ijk u_j u_k. Terms with the same J_i are summed
before they are multiplied, as one does by hand. Source: Lanczos, *The Variational Principles of Mechanics* (1970),
ch. V; the sums by partial velocities J_i are Kane's, *Dynamics* (1985), ch. 4.
"""

from __future__ import annotations

from collections import defaultdict
from typing import Any

import sympy as sp

from nonsmooth.errors import InvalidInput
from nonsmooth.symbolic.apparent import Apparent
from nonsmooth.symbolic.parts import Declared, DeclaredContact, Force, Turning, Weighted
from nonsmooth.symbolic.straight_line import Direction, StraightLine


class Equations:
    """Every function of a system, as lists of (index, expression) over one straight-line program.

    Parameters
    ----------
    declared : Declared
        What the user typed.
    jacobians : bool
        Whether K and C are derived.
    """

    def __init__(self, declared: Declared, jacobians: bool = True) -> None:
        self.line = StraightLine()
        self.q, self.u, self.t = declared.q, declared.u, declared.t
        self._by_q = [Direction({q: sp.S.One}) for q in self.q]
        self._by_u = [Direction({u: sp.S.One}) for u in self.u]
        self._by_t = Direction({self.t: sp.S.One})
        self._flow = Direction({self.t: sp.S.One, **dict(zip(self.q, self.u, strict=True))})
        self._declared = declared.mapped(self.line.shared)
        self._inertia: list[Any] = [defaultdict(lambda: sp.S.Zero) for _ in range(self.n * self.n)]
        self._loads: list[Any] = [defaultdict(lambda: sp.S.Zero) for _ in range(self.n)]
        self.V = sp.S.Zero
        self._add_energies()
        self._apparent = Apparent(self.line, [{*self.q}, {*self.u}, {self.t}])
        self.M = self._mass_matrix()
        self.h = self._apparent.freed([self._sum_of(loads) for loads in self._loads])
        self.functions = self._functions(jacobians)

    @property
    def n(self) -> int:
        """Number of coordinates."""
        return len(self.q)

    # derivatives

    def by_q(self, expression: Any) -> list[Any]:
        """d/dq of an expression (n,)."""
        return [self.line.derivative(expression, direction) for direction in self._by_q]

    def by_u(self, expression: Any) -> list[Any]:
        """d/du of an expression (n,)."""
        return [self.line.derivative(expression, direction) for direction in self._by_u]

    def rate(self, expression: Any) -> Any:
        """The rate along the motion, at u' = 0."""
        return self.line.derivative(expression, self._flow)

    # energies

    def _add_energies(self) -> None:
        declared = self._declared
        for part in declared.energies:
            {Weighted: self._add_weighted, Turning: self._add_turning}[type(part)](part)
        for kinetic in declared.kinetic:
            self._add_kinetic(kinetic)
        for potential in declared.potentials:
            self.V += potential
            self._add_gradient(potential, self.by_q, -1)
        for dissipation in declared.dissipations:
            self._add_gradient(dissipation, self.by_u, -1)
        for force in declared.forces:
            self._add_force(force)
        for given in declared.given:
            self._add_given(given.mass, given.force)

    def _add_weighted(self, part: Any) -> None:
        position, weight, gravity = part.position, part.weight, part.gravity
        J = [self.line.let(slope) for slope in self.by_q(position)]
        self._add_inertia(weight, J, J)
        acceleration = self.rate(self.line.let(self.rate(position)))
        self._add_load(J, self.line.let(weight * (gravity - acceleration)))
        self.V -= weight * gravity * position

    def _add_turning(self, part: Any) -> None:
        omega, inertia = part.omega, part.inertia
        J = [[self.line.let(slope) for slope in self.by_u(component)] for component in omega]
        spin = [self.line.let(sum(inertia[a][b] * omega[b] for b in range(3))) for a in range(3)]
        for a in range(3):
            for b in range(3):
                self._add_inertia(inertia[a][b], J[a], J[b])
            moment = sum(inertia[a][b] * self.line.let(self.rate(omega[b])) for b in range(3))
            k, m = (a + 1) % 3, (a + 2) % 3
            self._add_load(J[a], self.line.let(-moment - omega[k] * spin[m] + omega[m] * spin[k]))

    def _add_kinetic(self, kinetic: Any) -> None:
        momenta = [self.line.let(p) for p in self.by_u(kinetic)]
        for i, p in enumerate(momenta):
            for j, entry in enumerate(self.by_u(p)):
                if self.line.free_symbols(entry) & {*self.u}:
                    raise InvalidInput(
                        f"a kinetic energy must be quadratic in the velocities; d2T/d{self.u[i]} d{self.u[j]} reads "
                        "them: what is not belongs into force(...)"
                    )
                self._inertia[i * self.n + j][self.line.let(entry)] += 1
            self._loads[i][sp.S.One] -= self.rate(p)
        self._add_gradient(kinetic, self.by_q, 1)

    def _add_gradient(self, expression: Any, gradient: Any, sign: int) -> None:
        for i, slope in enumerate(gradient(expression)):
            self._loads[i][sp.S.One] += sign * slope

    def _add_force(self, force: Force) -> None:
        for position, component in zip(force.position, force.force, strict=True):
            J = [self.line.let(slope) for slope in self.by_q(position)]
            self._add_load(J, self.line.let(component))

    def _add_given(self, mass: Any, h: Any) -> None:
        for i in range(self.n):
            for j in range(self.n):
                self._inertia[i * self.n + j][sp.S.One] += mass[i][j]
            self._loads[i][sp.S.One] += h[i]

    def _add_inertia(self, weight: Any, J: list[Any], other: list[Any]) -> None:
        for i in range(self.n):
            for j in range(self.n):
                product = J[i] * other[j]
                if product != 0 and weight != 0:
                    sign, product = product.as_coeff_Mul()
                    self._inertia[i * self.n + j][product] += sign * weight

    def _add_load(self, J: list[Any], load: Any) -> None:
        for i in range(self.n):
            sign, arm = J[i].as_coeff_Mul()
            if sign != 0:
                self._loads[i][arm] += sign * load

    def _sum_of(self, terms: Any) -> Any:
        """sum (arm times the sum of what it is multiplied by)."""
        return sp.Add(*(arm * self.line.let(weight) for arm, weight in terms.items()))

    def _mass_matrix(self) -> list[list[Any]]:
        places = [(i, j) for i in range(self.n) for j in range(i, self.n)]
        sums = self._apparent.freed([self._sum_of(self._inertia[i * self.n + j]) for i, j in places])
        upper = {place: self.line.let(sum_) for place, sum_ in zip(places, sums, strict=True)}
        return [[upper[min(i, j), max(i, j)] for j in range(self.n)] for i in range(self.n)]

    # functions

    def _functions(self, jacobians: bool) -> dict[str, list[tuple[tuple[int, ...], Any]]]:
        n = range(self.n)
        functions: dict[str, list[tuple[tuple[int, ...], Any]]] = {
            "mass": [((i, j), self.M[i][j]) for i in n for j in n],
            "force": [((i,), self.h[i]) for i in n],
        }
        if not self._declared.given:  # whose h may hold forces of a potential that nobody told
            functions["potential"] = [((0,), self.V)]
        if jacobians:
            for name, gradient in (("stiffness", self.by_q), ("damping", self.by_u)):
                rows = [gradient(self.h[i]) for i in n]
                functions[name] = [((i, j), -rows[i][j]) for i in n for j in n]
        functions |= self._rows()
        return {name: self._freed(entries) for name, entries in functions.items()}

    def _freed(self, entries: list[tuple[tuple[int, ...], Any]]) -> list[tuple[tuple[int, ...], Any]]:
        values = self._apparent.freed([value for _, value in entries])
        return [(index, value) for (index, _), value in zip(entries, values, strict=True)]

    def _rows(self) -> dict[str, list[tuple[tuple[int, ...], Any]]]:
        rows: dict[str, list[Any]] = {name: [] for name in ROWS}
        for i, contact in enumerate(self._declared.contacts):
            if contact.gap is not None:
                speed = self.line.let(self.rate(contact.gap))
                rows["gap"].append(((i,), contact.gap))
                rows["normal"] += [((i, j), slope) for j, slope in enumerate(self.by_q(contact.gap))]
                rows["gap_rate"].append(((i,), self.line.derivative(contact.gap, self._by_t)))
                rows["row_rates"].append(((i, 0), self.rate(speed)))
            else:
                rows["normal_force"].append(((i,), contact.normal_force))
            if contact.slides:
                slopes, surface, slip = self._sliding(contact)
                rows["tangent"] += [((i, 0, j), slope) for j, slope in enumerate(slopes)]
                rows["surface_velocity"].append(((i, 0), surface))
                rows["row_rates"].append(((i, 1), self.rate(slip)))
        return rows

    def _sliding(self, contact: DeclaredContact) -> tuple[list[Any], Any, Any]:
        """W_F (n,), w_F and gamma_F of a contact."""
        if contact.slip is not None:
            slopes = self.by_u(contact.slip)
            at_rest = self._at_rest(contact.slip)
            return slopes, at_rest, contact.slip
        along = list(zip(contact.point, contact.tangent, contact.surface, strict=True))
        columns = [[tau * slope for slope in self.by_q(r)] for r, tau, _ in along]
        slopes = [sp.Add(*column) for column in zip(*columns, strict=True)]
        surface = sp.Add(*(tau * (self.line.derivative(r, self._by_t) - v) for r, tau, v in along))
        slip = sp.Add(*(tau * (self.line.let(self.rate(r)) - v) for r, tau, v in along))
        return slopes, surface, slip

    def _at_rest(self, slip: Any) -> Any:
        """gamma_F at u = 0."""
        return self.line.written_out(slip).xreplace(dict.fromkeys(self.u, sp.S.Zero))


ROWS = ("gap", "normal", "tangent", "surface_velocity", "gap_rate", "row_rates", "normal_force")
