"""Every solution of a planar contact problem whose contacts are redundant.

For given modes the unknown impulses x satisfy linear equations B x + d = 0 of any rank. Complete elimination gives

    x = x_0 + N y,      y free, of dimension m - rank B,

or shows that there is no x. On the family the inclusions are linear inequalities C x >= e; the member with the least
|x|^2 that satisfies them is

    min (x_0 + N y)^2,    C N y >= e - C x_0,

which has a solution exactly where the family has an admissible member (least_share.py). So a block on two corners that
stick is one solution with the least impulses, not an undecided branch.

``enumerate_modes`` is faster by orders of magnitude and comes first; this walk decides what it leaves open. Modes
that follow from others are not tried (implied.py), unless nothing is found without the rest.
Source: Golub, Van Loan, *Matrix Computations*, section 5.5.
"""

from __future__ import annotations

from nonsmooth.contact.planar.enumerate import is_new, keep_solution, next_candidate
from nonsmooth.contact.planar.implied import begin_walk, descend
from nonsmooth.contact.planar.least_share import find_least
from nonsmooth.contact.planar.problem import ACCEPTED_RESIDUAL, Planar, largest_velocity, residual
from nonsmooth.contact.planar.single import BORDER_WIDTH, FREE, NO_CANDIDATE, SLIDE_PLUS, STICK, sigma_of, slip_of
from nonsmooth.jit import kernel
from nonsmooth.jit.blocks import view
from nonsmooth.mechanics.contact_problem import Problem
from nonsmooth.mechanics.system import BILATERAL, GIVEN_FORCE, UNILATERAL
from nonsmooth.numerics.dense import cholesky, cholesky_solve


@kernel("int64(int64, float64[:, ::1], int64)", short_loops=True)
def enumerate_redundant(problem_at, K, planar_at):
    """All solutions, redundant contacts included, to ``planar.tree``; their number. P is scratch.

    K = W M^-1 W^T of the rows; G is another matrix where it holds the friction of slides (contact/planar/forces.py).
    """
    problem, planar = view(problem_at, Problem), view(planar_at, Planar)
    found = walk(True, K, problem, planar)
    return found if found > 0 else walk(False, K, problem, planar)


@kernel
def walk(skips, K, problem, planar):
    """Try the combinations of modes, ``skips`` those that follow from others; the number of solutions."""
    tree, n, scale = planar.tree, problem.n, largest_velocity(problem)
    begin_walk(problem.r, K, problem.c, tree)
    found = 0
    level = 0
    tree.candidate[0] = NO_CANDIDATE
    while level >= 0:
        candidate = next_candidate(problem.kinds[level, 0], problem.kinds[level, 1], tree.candidate[level])
        tree.candidate[level] = candidate
        if candidate == NO_CANDIDATE:
            level -= 1
        elif skips and not descend(level, candidate, scale, problem, tree):
            continue
        elif level < n - 1:
            level += 1
            tree.candidate[level] = NO_CANDIDATE
        else:
            for signs in range(1 << count_signs(problem, tree)):
                if solve_leaf(signs, scale, problem, planar) and residual(problem, planar) <= ACCEPTED_RESIDUAL:
                    found += keep_leaf(found, scale, problem, planar)
    return found


@kernel
def keep_leaf(found, scale, problem, planar):
    """Keep the impulses of a leaf; 1, or 0 where they move as others do."""
    tree = planar.tree
    for k in range(problem.r):
        tree.P[k] = problem.P[k]
        tree.gamma[k] = planar.gamma[k]
    if not is_new(found, problem.r, scale, tree):
        return 0
    keep_solution(found, problem.n, problem.r, tree)
    return 1


@kernel
def count_signs(problem, tree):
    """Number of contacts whose stick leaves the sign of P_N open: bilateral ones with friction."""
    total = 0
    for k in range(problem.n):
        if problem.kinds[k, 0] == BILATERAL and problem.kinds[k, 1] > 0 and tree.candidate[k] == STICK:
            total += 1
    return total


@kernel
def solve_leaf(signs, scale, problem, planar):
    """The least impulses with the modes of the present leaf, to P; False where there are none."""
    family = planar.family
    largest = 0.0
    for k in range(problem.r):
        for e in range(problem.r):  # of slides the diagonal may vanish
            largest = max(largest, abs(problem.G[k, e]))
    m = assemble(problem, planar)
    rank = eliminate_completely(m, BORDER_WIDTH * largest, family)
    for k in range(rank, m):
        if abs(family.B[k, m]) > ACCEPTED_RESIDUAL * scale:
            return False
    size = inequalities(signs, m, problem, planar)
    x = family.x
    for k in range(m):
        x[k] = 0.0
    for k in range(rank):
        x[family.column[k]] = -family.B[k, m]
    if m > rank:
        if not least_admissible(m, rank, size, planar):
            return False
    else:
        slack = BORDER_WIDTH * max(scale, scale / largest)
        for e in range(size):
            total = -family.e[e]
            for k in range(m):
                total += family.C[e, k] * x[k]
            if total < -slack:
                return False
    expand(m, problem, planar)
    return True


@kernel
def friction_factor(k, problem, planar):
    """P_F = f P_N of a sliding contact."""
    candidate = planar.tree.candidate[k]
    return -slip_of(candidate) * problem.mu[k] * sigma_of(candidate)


@kernel
def assemble(problem, planar):
    """B and d = B[:, m] of the unknown impulses of the leaf; returns their number m.

    A sticking contact has an unknown and an equation for each of its rows, a sliding one for its normal row.
    """
    family, candidate, start = planar.family, planar.tree.candidate, problem.start
    m = 0
    for k in range(problem.n):
        family.first[k] = m
        if candidate[k] == STICK:
            for row in range(start[k], start[k + 1]):
                family.row[m] = row
                m += 1
        elif candidate[k] >= SLIDE_PLUS and problem.kinds[k, 0] != GIVEN_FORCE:
            family.row[m] = start[k]
            m += 1
    family.first[problem.n] = m
    for e in range(m):
        family.B[e, m] = velocity_row(family.row[e], family.B, e, problem, planar)
        family.column[e] = e
    return m


@kernel
def velocity_row(row, out, e, problem, planar):
    """Coefficients of the velocity of a row in the unknowns, to out[e, :m]; returns its constant part."""
    family, candidate, G = planar.family, planar.tree.candidate, problem.G
    constant = problem.c[row]
    for k in range(problem.n):
        first, t = family.first[k], problem.start[k + 1] - 1
        for j in range(first, family.first[k + 1]):
            out[e, j] = G[row, family.row[j]]
        if candidate[k] >= SLIDE_PLUS:
            if problem.kinds[k, 0] == GIVEN_FORCE:
                constant -= G[row, t] * slip_of(candidate[k]) * problem.mu[k] * problem.normal_impulse[k]
            else:
                out[e, first] += friction_factor(k, problem, planar) * G[row, t]
    return constant


@kernel
def eliminate_completely(m, smallest, family):
    """Gauss–Jordan elimination with complete pivoting on B (m, m + 1); returns the rank.

    After it, x[column[k]] + sum_j B[k, j] x[column[j]] + B[k, m] = 0 for k < rank <= j. Pivots up to ``smallest``
    count as 0.
    """
    B, column = family.B, family.column
    for k in range(m):
        pivot, p_row, p_column = 0.0, k, k
        for i in range(k, m):
            for j in range(k, m):
                if abs(B[i, j]) > pivot:
                    pivot, p_row, p_column = abs(B[i, j]), i, j
        if not pivot > smallest:
            return k
        for j in range(m + 1):
            B[k, j], B[p_row, j] = B[p_row, j], B[k, j]
        for i in range(m):
            B[i, k], B[i, p_column] = B[i, p_column], B[i, k]
        column[k], column[p_column] = column[p_column], column[k]
        inverse = 1.0 / B[k, k]
        for j in range(k, m + 1):
            B[k, j] *= inverse
        for i in range(m):
            factor = B[i, k]
            if i != k and factor != 0.0:
                for j in range(k, m + 1):
                    B[i, j] -= factor * B[k, j]
    return m


@kernel
def inequalities(signs, m, problem, planar):
    """C x >= e: the inclusions of the leaf; returns their number.

    Bit b of ``signs`` is the sign of P_N in the b-th contact whose stick leaves it open.
    """
    family, candidate = planar.family, planar.tree.candidate
    size = 0
    for k in range(problem.n):
        kind, d = problem.kinds[k, 0], problem.kinds[k, 1]
        j, mu = family.first[k], problem.mu_static[k]
        if candidate[k] == FREE:
            size = velocity_inequality(1.0, problem.start[k], size, m, problem, planar)
        elif candidate[k] >= SLIDE_PLUS:
            if kind != GIVEN_FORCE:
                size = impulse_inequality(j, float(sigma_of(candidate[k])), 0.0, 0.0, size, m, family)
            t = problem.start[k + 1] - 1
            size = velocity_inequality(float(slip_of(candidate[k])), t, size, m, problem, planar)
        elif kind == GIVEN_FORCE:
            reach = mu * problem.normal_impulse[k]
            size = impulse_inequality(j, 1.0, 0.0, -reach, size, m, family)
            size = impulse_inequality(j, -1.0, 0.0, -reach, size, m, family)
        elif kind == UNILATERAL or d > 0 or problem.slip[k] != 0:
            sigma = 1.0
            if kind == BILATERAL and d == 0:
                sigma = float(problem.slip[k])
            elif kind == BILATERAL:
                sigma = -1.0 if signs & 1 else 1.0
                signs >>= 1
            size = impulse_inequality(j, sigma, 0.0, 0.0, size, m, family)
            if d > 0:
                size = impulse_inequality(j, sigma * mu, 1.0, 0.0, size, m, family)
                size = impulse_inequality(j, sigma * mu, -1.0, 0.0, size, m, family)
    return size


@kernel
def impulse_inequality(j, factor, next_factor, bound, size, m, family):
    """factor x_j + next_factor x_(j+1) >= bound as the next row of C and e; returns the number of rows."""
    for k in range(m):
        family.C[size, k] = 0.0
    family.C[size, j] += factor
    if next_factor != 0.0:
        family.C[size, j + 1] += next_factor
    family.e[size] = bound
    return size + 1


@kernel
def velocity_inequality(factor, row, size, m, problem, planar):
    """factor gamma_row >= 0 as the next row of C and e; returns the number of rows."""
    family = planar.family
    constant = velocity_row(row, family.C, size, problem, planar)
    for k in range(m):
        family.C[size, k] *= factor
    family.e[size] = -factor * constant
    return size + 1


@kernel
def least_admissible(m, rank, size, planar):
    """Overwrite x = x_0 by the least x_0 + N y with C x >= e; False where there is none.

    N has -B[k, rank:] in the rows column[k < rank] and the identity below; so H = I + F^T F with F = B[:rank, rank:].
    """
    family = planar.family
    B, C, column, x = family.B, family.C, family.column, family.x
    free = m - rank
    if is_fixed_wrong(m, rank, size, family):
        return False
    for a in range(free):
        for b in range(free):
            total = 1.0 if a == b else 0.0
            for k in range(rank):
                total += B[k, rank + a] * B[k, rank + b]
            family.H[a, b] = total
    cholesky(free, free, family.H, family.L)
    for a in range(free):  # y = -H^-1 N^T x_0: the least member of the whole family
        total = 0.0
        for k in range(rank):
            total += B[k, rank + a] * x[column[k]]
        family.y[a] = total
    cholesky_solve(free, free, family.L, family.y)
    move(m, rank, family)
    for e in range(size):  # rows of A H^-1
        for a in range(free):
            family.AH[e, a] = family.A[e, a]
        cholesky_solve(free, free, family.L, family.AH[e])
        planar.b[e] = -family.e[e]
        family.slack[e] = abs(family.e[e])
        for k in range(m):
            planar.b[e] += C[e, k] * x[k]
            family.slack[e] += abs(C[e, k] * x[k])
        family.slack[e] *= BORDER_WIDTH
    if not find_least(size, free, family.slack, planar):
        return False
    move(m, rank, family)
    return True


@kernel
def is_fixed_wrong(m, rank, size, family):
    """Whether an inequality is violated that no member of the family changes, as of the motion that all have in common;
    A = C N is written on the way."""
    B, C, column, x = family.B, family.C, family.column, family.x
    for e in range(size):
        largest, change = 0.0, 0.0
        for a in range(m - rank):
            total, terms = C[e, column[rank + a]], abs(C[e, column[rank + a]])
            for k in range(rank):
                total -= C[e, column[k]] * B[k, rank + a]
                terms += abs(C[e, column[k]] * B[k, rank + a])
            family.A[e, a] = total
            largest, change = max(largest, terms), max(change, abs(total))
        if change > BORDER_WIDTH * largest:
            continue
        total, terms = -family.e[e], abs(family.e[e])
        for k in range(m):
            total += C[e, k] * x[k]
            terms += abs(C[e, k] * x[k])
        if total < -ACCEPTED_RESIDUAL * terms:
            return True
    return False


@kernel
def move(m, rank, family):
    """x += N y."""
    for a in range(m - rank):
        family.x[family.column[rank + a]] += family.y[a]
        for k in range(rank):
            family.x[family.column[k]] -= family.B[k, rank + a] * family.y[a]


@kernel
def expand(m, problem, planar):
    """The impulses of all rows from the unknowns x."""
    P, family, candidate = problem.P, planar.family, planar.tree.candidate
    for k in range(problem.r):
        P[k] = 0.0
    for j in range(m):
        P[family.row[j]] = family.x[j]
    for k in range(problem.n):
        if candidate[k] >= SLIDE_PLUS:
            t = problem.start[k + 1] - 1
            if problem.kinds[k, 0] == GIVEN_FORCE:
                P[t] = -slip_of(candidate[k]) * problem.mu[k] * problem.normal_impulse[k]
            else:
                P[t] = friction_factor(k, problem, planar) * P[problem.start[k]]
