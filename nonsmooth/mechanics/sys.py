"""The system as kernels see it: what is constant in a run.

A kernel takes two things, what is constant in a run and what changes: ``step(sys, run)``. Kernels call a function of
the model by ``evaluate``; in the interpreter the handle of the model is a Python function.
"""

from __future__ import annotations

from typing import Annotated as Array
from typing import Any

from nonsmooth.jit import call_model, kernel
from nonsmooth.jit.blocks import Block, Floats, Handle, Ints, new
from nonsmooth.mechanics.laws import LAW_WIDTH
from nonsmooth.mechanics.own_law import point_to
from nonsmooth.mechanics.system import System


class Sys(Block):
    """A system: its functions, parameters and contacts."""

    model: Handle  # what ``call_model`` takes
    has: int  # one bit a function that the model has, and what is constant in it (contact_problem.model_facts)
    n: int  # velocities
    n_q: int  # coordinates
    n_c: int  # contacts
    p: Array[Floats, "n_p"]  # parameters
    kinds: Array[Ints, "n_c", 2]  # of contact, and the number of its tangential directions
    laws: Array[Floats, "n_c", LAW_WIDTH]  # of friction and impact


def new_sys(system: System, model: Any, has: int) -> Sys:
    """The block of a system.

    Parameters
    ----------
    system : System
    model : int or callable
        The handle of its compiled functions, or of their source.
    has : int
        ``model_facts`` of the system.
    """
    sys = new(Sys, n_p=len(system.p), n_c=system.n_c)
    fill_sys(sys, system, model, has)
    return sys


def fill_sys(sys: Sys, system: System, model: Any, has: int) -> None:
    """Write a system into a block of its sizes."""
    sys.model, sys.has, sys.n, sys.n_q, sys.n_c = model, has, system.n_u, system.n_q, system.n_c
    fill_numbers(sys, system)


def fill_numbers(sys: Sys, system: System) -> None:
    """Write parameters, kinds of contact and laws of a system; laws of the user's find the parameters here."""
    sys.p[:], sys.kinds[:], sys.laws[:] = system.p, system.kinds, system.laws
    if system.own_laws:
        point_to(sys.laws, sys.p)


@kernel
def evaluate(sys, which, t, q, u, out):
    """Call a function of the model; False if it raised."""
    return call_model(sys.model, which, t, q, u, sys.p, out)
