"""Islands solved by the contacts that press: what is surely open is left out, and the rest falls into smaller islands.

    kept     P_N > 0,  or  rho gamma_N <= SURELY_OPEN size,    size^2 = mean of |P|^2 over the contacts with P_N > 0
    solved   each island of the kept contacts, from next to its impulses (``from_inside``)
    added    what was left out and approaches with the new velocities; then again, until nothing does

Of a heap in motion a third to a half of the contacts are open. Without them its graph is nearly a forest: measured, of
1000 falling spheres with 2371 contacts 1460 are kept, a factor has 4300 blocks in place of 16 100 and takes a tenth of
the time, and interior points take 20 steps in place of 50. Sweeps find most of what presses: of 54 islands of some
300 discs and 10 of some 1000 spheres, which they left at 5e-5 to 1e-3, 2 needed contacts that had been left out.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from nonsmooth.contact.network.al_newton import begin_direct
from nonsmooth.contact.network.from_inside import DIGITS_FACTORS, INSIDE_STEPS, STARTS, Start, from_inside
from nonsmooth.contact.network.interior import CENTRING
from nonsmooth.contact.network.joint import JOINED
from nonsmooth.contact.network.lagrangian import Direct
from nonsmooth.contact.network.problem import Network, judge_network, prepare_network
from nonsmooth.jit.blocks import new

SURELY_OPEN = 3e-3  # measured: with 1e-2 5 % more contacts are kept; with 1e-3 some are missing in 3 of 6 of spheres
# measured: of 30 islands of 1000 falling spheres and of a pile of 2048 the first start solves 28, in 20 steps in the
# mean; 0.02 with the centring 0.7 26, 0.3 with 3 20. Of 1000 steps of 300 discs one is missed where it is not first,
# of 60 of the pile two without the third
PRESSED_STARTS = {
    2: (Start(0.1, 1e-6, 1.0, 0.95, True), Start(1e-3, 1e-6, CENTRING, 0.99, True), *STARTS),
    3: (
        Start(0.1, 1e-6, 1.0, 0.95, True),
        Start(0.02, 1e-6, 0.7, 0.95, True),
        Start(1e-3, 1e-6),
        Start(0.1, 1e-6, 0.7, 0.99, True),
    ),
}
# measured: steps, and factors of the digits: solved ones take 10 to 50, and 5 to 20 where they lead anywhere
PRESSED_MOST = (50, 30)
FIRST_FILL_OF_PART = 8  # measured: blocks of factors a body: falling spheres take 2 to 8, discs 1 to 3
ADDITIONS = 5  # chosen: times that contacts are added; one is rare


def solve_pressed(network: Network, k: int, tol: float, starts: Sequence[Start]) -> int:
    """Improve the impulses of island k by its pressed contacts, to a residual of tol if that can be; how many factors
    that took. It judges velocities, gamma and residuals of all islands."""
    contacts, made = contacts_of(network, k), 0
    judge_impulses(network)
    best, least = network.P[contacts].copy(), float(network.islands.residual[k])
    is_kept = are_pressed(network, contacts)
    network.P[contacts[~is_kept]] = 0.0
    for _ in range(ADDITIONS):
        made += solve_part(network, contacts[is_kept], tol, starts, PRESSED_MOST)
        judge_impulses(network)
        if network.islands.residual[k] < least:
            best, least = network.P[contacts].copy(), float(network.islands.residual[k])
        is_approaching = ~is_kept & (network.gamma[contacts, 0] < 0.0)
        if least <= tol or not is_approaching.any():
            break
        is_kept |= is_approaching
    put_back(network, k, best, least)
    return made


def solve_whole(network: Network, k: int, tol: float, starts: Sequence[Start]) -> int:
    """The same by all its contacts, from other starts."""
    contacts = contacts_of(network, k)
    before, error = network.P[contacts].copy(), float(network.islands.residual[k])
    made = solve_part(network, contacts, tol, starts, (INSIDE_STEPS, DIGITS_FACTORS))
    judge_impulses(network)
    put_back(network, k, before, error)
    return made


def put_back(network: Network, k: int, P: np.ndarray, error: float) -> None:
    """Give island k impulses of a known residual, unless those that it has are as good."""
    if not network.islands.residual[k] <= error:
        network.P[contacts_of(network, k)] = P
        judge_impulses(network)


def are_pressed(network: Network, contacts: np.ndarray) -> np.ndarray:
    """Which of some contacts are kept."""
    P, gamma_N = network.P[contacts], network.gamma[contacts, 0]
    is_pressed = (P[:, 0] > 0.0) | (network.mu[contacts] == JOINED)
    size = np.sqrt((P**2).sum() / max(1, int(is_pressed.sum())))
    return np.asarray(is_pressed | (network.rho[contacts] * gamma_N <= SURELY_OPEN * size))


def part_of(network: Network, contacts: np.ndarray) -> Network:
    """The network of some contacts alone, with the bodies that they touch, prepared and judged."""
    d, n = network.b.shape[1], network.v.shape[1]
    bodies, places = np.unique(np.stack((network.i[contacts], network.j[contacts])), return_inverse=True)
    part = new(Network, d=d, n=n, m=len(contacts), n_b=len(bodies))
    part.n_c, part.tol = len(contacts), network.tol
    part.i[:], part.j[:] = places.reshape(2, -1)
    for name in ("J_i", "J_j", "b", "mu", "soft", "P"):
        getattr(part, name)[:] = getattr(network, name)[contacts]
    for name in ("v_free", "M", "M_inv"):
        getattr(part, name)[:] = getattr(network, name)[bodies]
    prepare_network(part.address, d)
    judge_impulses(part)
    return part


def solve_part(network: Network, contacts: np.ndarray, tol: float, starts: Sequence[Start],
               most: tuple[int, int]) -> int:  # fmt: skip
    """Solve the islands of some contacts that are above tol, for their impulses; how many factors that took."""
    part, made = part_of(network, contacts), 0
    islands, fill = part.islands, FIRST_FILL_OF_PART * len(part.v)
    direct = room_for(part, fill)
    for k in np.flatnonzero(~(islands.residual[: islands.count] <= tol)):
        while not from_inside(part, direct, int(k), tol, tol, starts, most):
            made, fill = made + int(direct.desk.factors), int(direct.desk.graph.wanted)
            direct = room_for(part, fill)
    network.P[contacts] = part.P
    return made + int(direct.desk.factors)


def room_for(part: Network, fill: int) -> Direct:
    """The memory of the direct rung for a network, with so many blocks of factors."""
    direct = new(Direct, d=part.b.shape[1], n=part.v.shape[1], m=len(part.i), n_b=len(part.v), fill=fill)
    begin_direct(part.address, direct.address)
    return direct


def judge_impulses(network: Network) -> None:
    """Velocities, gamma and residuals of the impulses of a network."""
    judge_network(network.address, network.b.shape[1])


def contacts_of(network: Network, k: int) -> np.ndarray:
    """The contacts of island k."""
    islands = network.islands
    return islands.contacts[islands.contact_start[k] : islands.contact_start[k + 1]]
