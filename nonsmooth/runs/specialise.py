"""Whether a run, or a sweep, takes a loop that is compiled for its system alone (jit/specialised.py).

It pays where    steps SAVED > the time to compile it, or to read it from disk.
"""

from __future__ import annotations

from typing import Any

from nonsmooth.errors import InterpretedWarning, warn_caller
from nonsmooth.integrators.contract import Integrator, step_at
from nonsmooth.integrators.fixed_step import FixedStep
from nonsmooth.integrators.records import Skips, State
from nonsmooth.jit.beside import has_free_processor
from nonsmooth.jit.blocks import known_of
from nonsmooth.jit.specialised import Parts, Specialised
from nonsmooth.mechanics.compiled import Model
from nonsmooth.mechanics.sys import Sys

SAVED = 5e-8  # measured: s a step: ball 24 ns, belt oscillator 50, rod that slides 85
READ_TIME = 0.2  # measured: s, with what is looked at before
MOST_KEPT = 64  # chosen: loops of a process; each is some 200 kB of code

_made: dict[Parts, Specialised | None] = {}  # None where numba cannot compile one


def loop_of_system(
    integrator: Integrator, model: Model, sys: Sys, state: State, memory: Any, steps: float
) -> Specialised | None:
    """The loop of one system for a run, or for runs, of so many steps; None where the generic one is to be taken.

    With "auto" one that is not there yet is compiled beside the run, where a processor is free: until it is there its
    address is 0, and the generic loop takes the same steps.
    """
    wish = integrator.specialise
    if wish is False or not model.is_compiled or (wish == "auto" and steps * SAVED < READ_TIME):
        return None
    assert isinstance(integrator, FixedStep)
    parts = parts_of(integrator, model, sys, state, memory)
    if parts not in _made:
        if len(_made) >= MOST_KEPT:
            _made.clear()
        _made[parts] = Specialised(parts, model.source[1])
    found = _made[parts]
    if found is None or (wish == "auto" and steps * SAVED < found.time_to_load()):
        return None
    if found.refusal is not None:
        _made[parts] = None
        return None
    if wish == "auto" and found.time_to_load() > 0.0 and (found.is_begun or has_free_processor()):
        found.load_beside()
        return found
    try:
        found.load()
    except Exception as reason:  # numba raises many unrelated types
        _made[parts] = None
        if wish is True:
            warn_caller(
                f"specialise=True: numba cannot compile a loop for this system alone ({type(reason).__name__}); the "
                "generic one is taken, with the same results",
                InterpretedWarning,
            )
        return None
    return found


def parts_of(integrator: FixedStep, model: Model, sys: Sys, state: State, memory: Any) -> Parts:
    """What is constant in a run, from its blocks before the first step."""
    constant = (Sys, Skips, *integrator.constants)
    known = (
        (Sys, known_of(sys, constant, ("kinds",))),
        (State, known_of(state, constant)),
        (type(memory), known_of(memory, constant)),
    )
    return Parts(integrator.loop, step_at, integrator.step, integrator.inlined, known, Sys, model.source[0])
