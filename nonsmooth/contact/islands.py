"""Islands of contacts: what the Delassus matrix does not couple is decided apart.

    gamma = G P + c,    G_km the block of contacts k and m

Where all blocks between two groups of contacts vanish, the solutions of the problem are the pairs of a solution of each
group: the one cannot make the other inconsistent, nor strike it. Contacts are coupled directly by a block that is more
than rounding, or through others; so two blocks that a third one joins are one island however light it is. An entry
G_ab = w_a M^-1 w_b is at most sqrt(G_aa G_bb) (Cauchy, Schwarz), and one that cancels, as between two contacts of a
symmetric body, is zero to the rounding of such terms.

The flood is one in a graph of n nodes. Source: Cormen, Leiserson, Rivest, Stein, *Introduction to Algorithms*, section
21.1.
"""

from __future__ import annotations

from nonsmooth.jit import kernel
from nonsmooth.numerics.rounding import EPS

# derived, of sqrt(G_aa G_bb). Rounding of a product with a well conditioned M is some 10 EPS; a body that joins two
# others is seen as long as it is not lighter than 5e-26 of them, the square of this.
UNCOUPLED = 1000.0 * EPS


@kernel
def find_islands(n, start, G, island):
    """Number the islands of n contacts from 0, in the order of their first contacts, to island (n,); how many."""
    for k in range(n):
        island[k] = k
        for m in range(k):
            if island[m] != island[k] and is_block(start[k], start[k + 1], start[m], start[m + 1], G):
                join(k + 1, island[m], island[k], island)
    return number_islands(n, island)


@kernel
def find_held_islands(n, start, held, G, island):
    """``find_islands`` where only the first held[k] rows of contact k are equations or undecided.

    The others are friction of a slide: a column that acts on the held rows, and a row that nothing is asked of. Two
    contacts of one body that slide are apart where friction couples but their velocities in the direction of sliding.
    """
    for k in range(n):
        island[k] = k
        for m in range(k):
            if island[m] != island[k] and (
                is_block(start[k], start[k] + held[k], start[m], start[m + 1], G)
                or is_block(start[m], start[m] + held[m], start[k], start[k + 1], G)
            ):
                join(k + 1, island[m], island[k], island)
    return number_islands(n, island)


@kernel
def is_block(a_0, a_1, b_0, b_1, G):
    """Whether an entry of the rows a_0 <= a < a_1 and the columns b_0 <= b < b_1 is more than rounding."""
    for a in range(a_0, a_1):
        for b in range(b_0, b_1):
            if G[a, b] * G[a, b] > UNCOUPLED * UNCOUPLED * abs(G[a, a] * G[b, b]):
                return True
    return False


@kernel
def spread_strike(n, start, G, strikes):
    """Let the impulses of the contacts with strikes[k] = 1 strike, one after the other, each contact whose normal
    velocity they change.

    A contact whose sliding they change alone is not struck: without a normal impulse it has no friction either.
    """
    grows = True
    while grows:
        grows = False
        for k in range(n):
            for m in range(n):
                if strikes[k] == 0 and strikes[m] == 1 and is_block(start[k], start[k] + 1, start[m], start[m + 1], G):
                    strikes[k] = 1
                    grows = True


@kernel
def join(n, first, second, island):
    """Give the contacts of two islands, among the first n contacts, the lower of their numbers."""
    low, high = min(first, second), max(first, second)
    for k in range(n):
        if island[k] == high:
            island[k] = low


@kernel
def number_islands(n, island):
    """Number the islands, each called by its first contact, without gaps; returns how many."""
    count = 0
    for k in range(n):
        if island[k] == k:
            island[k] = count
            count += 1
        else:
            island[k] = island[island[k]]
    return count
