"""The end of a smooth phase as a function of its beginning, with its derivative.

    x' = f(x),    Phi' = (df/dx) Phi,  Phi(0) = 1;    (df/dx) Phi_j = Im f(x + i h Phi_j)/h

The eighth-order method of Dormand and Prince carries the state and the columns of Phi together. Source: Hairer,
Norsett, Wanner, *Solving Ordinary Differential Equations I* (1993), sections I.14 and II.10.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from nonsmooth.cycles.mode_flow import ModeFlow
from nonsmooth.errors import InvalidInput
from nonsmooth.numerics.complex_step import COMPLEX_INCREMENT

EVALUATIONS = 100_000  # chosen: of the rates over one phase; a cycle of the models here takes some thousand
FLOW_RTOL = 1e-12  # chosen: of the state and, with it, of the derivative


def flow_map(
    flow: ModeFlow, x: np.ndarray, duration: float, scale: np.ndarray, rtol: float = FLOW_RTOL
) -> tuple[np.ndarray, np.ndarray]:
    """The state (m,) after a duration and Phi (m, m).

    ``scale`` (m,) holds the sizes of the states, against which the error is measured.
    """
    from scipy.integrate import solve_ivp

    m = x.size

    def rate(_: float, z: np.ndarray) -> np.ndarray:
        state, Phi = z[:m], z[m:].reshape(m, m)
        out = np.empty_like(z)
        columns = out[m:].reshape(m, m)
        for j in range(m):
            f = flow.rate(state + 1j * COMPLEX_INCREMENT * Phi[:, j])
            columns[:, j] = f.imag / COMPLEX_INCREMENT
        out[:m] = f.real
        return out

    rate = budgeted(rate)
    start = np.concatenate([x, np.eye(m).ravel()])
    sizes = np.concatenate([scale, np.outer(scale, 1 / scale).ravel()])
    with np.errstate(over="ignore", invalid="ignore"):  # of steps that are tried and refused
        run = solve_ivp(rate, (0.0, duration), start, method="DOP853", rtol=rtol, atol=rtol * sizes)
    if not run.success or not np.isfinite(run.y[:, -1]).all():
        raise InvalidInput(
            f"a phase of the guess ends before its time, after {run.t[-1]:.6g} of {duration:.6g} s: its forces grow "
            "without bound (a paradox, or a guess too far from the cycle)"
        )
    return run.y[:m, -1], run.y[m:, -1].reshape(m, m)


def budgeted(rate: Callable) -> Callable:
    """The rate, which refuses to be evaluated without end: a guess far from any cycle makes it stiff beyond measure."""
    left = EVALUATIONS

    def counted(t: float, z: np.ndarray) -> np.ndarray:
        nonlocal left
        left -= 1
        if left < 0:
            raise InvalidInput(
                f"a phase of the guess is not integrated within {EVALUATIONS} evaluations of its rates; give a guess "
                "nearer to the cycle, or a smaller dt"
            )
        return rate(t, z)

    return counted


def flow_curve(
    flow: ModeFlow, x: np.ndarray, duration: float, scale: np.ndarray, rtol: float = FLOW_RTOL, pieces: int = 1
) -> Callable[[Any], np.ndarray]:
    """The state (m,) as a function of the time since the beginning of the phase, (m, k) of k times.

    At least ``pieces`` steps are taken: with many, interpolation within a step is as good as the step's end.
    """
    from scipy.integrate import solve_ivp

    with np.errstate(over="ignore", invalid="ignore"):
        run = solve_ivp(
            budgeted(lambda _, z: flow.rate(z).real), (0.0, duration), x, method="DOP853", rtol=rtol, atol=rtol * scale,
            max_step=duration / pieces, dense_output=True,
        )  # fmt: skip
    return run.sol
