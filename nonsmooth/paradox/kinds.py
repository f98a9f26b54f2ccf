"""What a classification says: the kinds of states, facts beside them, one set of forces, one island of contacts."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum, IntFlag

import numpy as np

from nonsmooth.paradox.stability import StabilityTag


class ParadoxKind(IntEnum):
    """What the number of solutions says."""

    INCONSISTENT = 0  # none
    REGULAR = 1  # one
    INDETERMINATE = 2  # several
    NOT_ENUMERATED = 3  # more contacts than are enumerated
    INADMISSIBLE = 4  # (maps only) the state penetrates or lands: there is no acceleration-level problem
    NOT_REACHED = 5  # (maps only) Ctrl-C came before


class ParadoxFlag(IntFlag):
    """Facts about a state beside the number of its solutions."""

    P_ZERO = 1  # p = 0 for the present slip (at rest: for either), within the tolerance
    B_ZERO = 2  # b = 0
    GENOT_BROGLIATO = 4  # p = b = 0
    REVERSE_CHATTER = 8  # bounces that grow out of a contact at rest coexist with sticking
    CONTACT_FLUTTER = 16  # a solution that a stiff contact leaves unless it is damped enough
    JAMMED = 32  # no forces, and no impact either: self-locking
    PAINLEVE = 64  # friction in two directions: p <= 0 for the present slip, at rest for some direction


@dataclass(frozen=True, eq=False)
class ForceSolution:
    """One set of contact forces that fits the state.

    Attributes
    ----------
    modes : tuple of str
        Mode of each contact: "free", "stick", "slide +", "slide -", "closed" (no friction), "open".
    la_N, la_F : ndarray (n_c,)
        Contact forces [N].
    du : ndarray (n_u,)
        Accelerations u'.
    dgamma_N, dgamma_F : ndarray (n_c,)
        Accelerations of the closed contacts [m/s^2]; nan for open ones.
    stability : StabilityTag
        Whether a stiff contact stays in this mode.
    is_unique_force : bool
        False where redundant contacts leave the forces of this motion undetermined; these are then one choice.
    """

    modes: tuple[str, ...]
    la_N: np.ndarray
    la_F: np.ndarray
    du: np.ndarray
    dgamma_N: np.ndarray
    dgamma_F: np.ndarray
    stability: StabilityTag
    is_unique_force: bool = True


@dataclass(frozen=True)
class ContactIsland:
    """Closed contacts that the Delassus matrix couples with one another, and with no others.

    Attributes
    ----------
    contacts : tuple of int
    kind : ParadoxKind
    n_solutions : int
        Sets of forces of these contacts that fit the state.
    is_complete : bool
        Whether no solution can be missing.
    """

    contacts: tuple[int, ...]
    kind: ParadoxKind
    n_solutions: int
    is_complete: bool


def kind_of(n_solutions: int, is_complete: bool) -> ParadoxKind:
    """The kind by the number of solutions; two of them are several, whether or not others are missing."""
    if n_solutions >= 2:
        return ParadoxKind.INDETERMINATE
    if not is_complete:
        return ParadoxKind.NOT_ENUMERATED
    return ParadoxKind(n_solutions)
