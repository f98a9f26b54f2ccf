"""Velocity Verlet: smooth forces that do not read the velocities, of second order, symplectic.

    u_mid = u_0 + dt/2 a(t_0, q_0),    q_1 = q_0 + dt u_mid,    u_1 = u_mid + dt/2 a(t_1, q_1)

Source: Hairer, Lubich, Wanner, *Acta Numerica* 12 (2003) 399.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated as Array

from nonsmooth.checks.arrays import as_positive
from nonsmooth.errors import InvalidInput, Status
from nonsmooth.integrators.contract import STEP
from nonsmooth.integrators.fixed_step import FixedStep
from nonsmooth.integrators.records import State
from nonsmooth.jit import Kernel, kernel
from nonsmooth.jit.blocks import Block, Floats, new, view
from nonsmooth.mechanics.sys import Sys, evaluate
from nonsmooth.mechanics.system import FORCE, MASS, System
from nonsmooth.numerics.dense import bandwidth, cholesky, cholesky_solve


class Scratch(Block):
    """Arrays of a step."""

    M: Array[Floats, "n", "n"]
    factor: Array[Floats, "n", "n"]
    a: Array[Floats, "n"]  # accelerations


@kernel(STEP)
def step(sys_at, t, dt, state_at, memory_at):
    """One step; returns a Status."""
    sys, state, memory = view(sys_at, Sys), view(state_at, State), view(memory_at, Scratch)
    q, u, a = state.q, state.u, memory.a
    status = accelerate(sys, t, state, memory)
    if status != Status.RUNNING:
        return status
    for i in range(sys.n):
        u[i] += 0.5 * dt * a[i]
        q[i] += dt * u[i]
    status = accelerate(sys, t + dt, state, memory)
    if status != Status.RUNNING:
        return status
    total = 0.0
    for i in range(sys.n):
        u[i] += 0.5 * dt * a[i]
        total += 0.0 * u[i]
    state.counters.step += 1
    state.counters.steps += 1
    return Status.RUNNING.value if total == 0.0 else Status.NOT_FINITE.value


@kernel
def accelerate(sys, t, state, memory):
    """a = M^-1 h; returns a Status."""
    M, n = memory.M, sys.n
    if not evaluate(sys, MASS, t, state.q, state.u, M) or not evaluate(sys, FORCE, t, state.q, state.u, memory.a):
        return Status.NOT_FINITE.value
    band = bandwidth(n, M)
    if not cholesky(n, band, M, memory.factor):
        return Status.MASS_NOT_POSITIVE.value
    cholesky_solve(n, band, memory.factor, memory.a)
    return Status.RUNNING.value


@dataclass(frozen=True)
class Verlet(FixedStep):
    """Velocity Verlet with a fixed step ``dt`` [s]; InvalidInput unless dt > 0, and for a system with contacts."""

    dt: float
    theta = 0.5
    step = step

    def __post_init__(self) -> None:
        object.__setattr__(self, "dt", as_positive("dt", self.dt, "s"))

    def entry_points(self, system: System) -> list[Kernel]:
        return [self.loop, self.step]

    def memory(self, system: System, selection: int) -> Scratch:
        if system.n_c:
            raise InvalidInput(f"Verlet takes systems without contacts; this one has {system.n_c}; use MoreauJean(dt)")
        return new(Scratch, n=system.n_u)
