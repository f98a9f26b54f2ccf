"""Islands solved from the inside of the cones: interior points, and Newton's method for the digits.

    from a distance of the boundary, next to the impulses:  interior points (``interior``)
    from where they end:                                    the augmented Lagrangian (``al_newton``)

Each distance comes with a shift of its own. Where one path fails another ends; a small shift ends what a large one
only creeps to, as a train of dominoes, and a large one what a small one leaves in its roundings, as a heap. Each
begins at the best impulses so far: from the first ones two of 350 steps of 300 spheres that fall are missed, and a pile
of 2048 takes a quarter longer. The impulses of the least residual are left.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from nonsmooth.contact.blocks.interior import CONE_STEP_PART
from nonsmooth.contact.blocks.ladder import FAR, INSIDE, NEAR, OUTERMOST
from nonsmooth.contact.network.al_newton import solve_by_al_newton
from nonsmooth.contact.network.interior import CENTRING, Inside, go_inside
from nonsmooth.contact.network.lagrangian import Direct
from nonsmooth.contact.network.multifrontal import lay_out_fronts
from nonsmooth.contact.network.problem import Network
from nonsmooth.jit.blocks import new


class Start(NamedTuple):
    """Where interior points begin, and how they go; fields as in ``Inside``."""

    distance: float
    shift: float
    centring: float = CENTRING
    part: float = CONE_STEP_PART
    is_centred: bool = False


# measured: distances, each with its shift of W^-2: of 204 islands of 100 to 300 discs that scenes left 177 are solved,
# of 109 of some 300 spheres 106, and all of 20 of trains of dominoes; with 1e-6 everywhere 177, 106 and 16, with 1e-4
# 158, 103 and 11, with 1e-8 173, 105 and 20, with 1e-12 175, 106 and 17
STARTS = (Start(INSIDE, 1e-6), Start(NEAR, 1e-8), Start(FAR, 1e-7))
# measured: and of few bodies: of 300 steps of a wall of 24 bricks that a ball knocks over 43 are missed with the starts
# above, 34 with these too, in less time
STARTS_OF_FEW = (*STARTS, Start(OUTERMOST, 1e-6), Start(INSIDE, 1e-9), Start(FAR, 1e-10))
INSIDE_STEPS = 100  # measured: most take 15 to 40
DIGITS_FACTORS = 100  # measured: with 25 a heap of discs is left at 2e-8 to 1e-6 in 4 of 100 islands more


def from_inside(network: Network, direct: Direct, k: int, tol: float, digits_tol: float,
                starts: Sequence[Start] = STARTS,
                most: tuple[int, int] = (INSIDE_STEPS, DIGITS_FACTORS)) -> bool:  # fmt: skip
    """Solve island k, whose residual is known, to a residual of tol, better by digits to ``digits_tol``, with ``most``
    steps and factors of the digits from each start.

    Impulses alone are left: velocities and residual are to be judged anew. False where there is no room for the
    factors, as many blocks as ``direct.desk.graph.wanted``; nothing is changed.
    """
    islands, d = network.islands, network.b.shape[1]
    contacts = islands.contacts[islands.contact_start[k] : islands.contact_start[k + 1]]
    best, least = network.P[contacts].copy(), float(islands.residual[k])
    point = new(Inside, m=len(contacts))
    laid_out = lay_out_fronts(network, direct, k)
    if laid_out is None:
        return False
    at = network.address, direct.address, laid_out[0].address, laid_out[1].address, point.address
    for point.start, point.shift, point.centring, point.part, point.is_centred in starts:
        network.P[contacts] = best
        go_inside(*at, k, tol, most[0], d)
        solve_by_al_newton(network.address, direct.address, k, digits_tol, most[1], d)
        if islands.residual[k] < least:
            best, least = network.P[contacts].copy(), float(islands.residual[k])
        if least <= tol:
            break
    network.P[contacts] = best
    return True
