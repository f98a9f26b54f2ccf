"""The acceleration of an oscillator with one coordinate at many states, friction opposed to the sliding of each.

M y'' = h(q, u) - sum_i mu_i(|gamma_F|) N_i sgn(gamma_F) W_F
"""

from __future__ import annotations

import numpy as np

from nonsmooth.errors import InvalidInput
from nonsmooth.jit import interpreted, kernel
from nonsmooth.jit.blocks import new, view
from nonsmooth.mechanics.compiled import model_of
from nonsmooth.mechanics.contact_problem import Work, evaluate_rows, model_facts
from nonsmooth.mechanics.laws import friction_coefficient
from nonsmooth.mechanics.sys import Sys, evaluate, new_sys
from nonsmooth.mechanics.system import FORCE, MASS, System


@kernel(
    "boolean(int64, float64, float64[::1], float64[::1], float64[::1], float64[:, ::1], int64)",
    short_loops=True,
    takes_arrays=True,
)
def accelerate(sys_at, t, q, u, a, gamma_F, work_at):
    """a[k] and gamma_F[:, k] at the states q[k], u[k]; False where a model function raised."""
    sys = view(sys_at, Sys)
    work = view(work_at, Work)
    rate = work.trial
    for k in range(q.shape[0]):
        work.q_mid[0] = q[k]
        rate[0] = u[k]
        if not evaluate(sys, MASS, t, work.q_mid, rate, work.M):
            return False
        if not evaluate(sys, FORCE, t, work.q_mid, rate, work.h):
            return False
        if not evaluate_rows(sys, True, t, rate, work):
            return False
        force = work.h[0]
        for i in range(sys.laws.shape[0]):
            W_F = work.W_F[i, 0, 0]
            gamma = W_F * u[k] + work.w_F[i, 0]
            gamma_F[i, k] = gamma
            friction = friction_coefficient(sys.laws, i, abs(gamma)) * max(work.N[i], 0.0) * W_F
            force -= friction if gamma > 0.0 else -friction
        a[k] = force / work.M[0, 0]
    return True


class Oscillator:
    """A system with one coordinate and contacts with a given normal force, ready to be evaluated at many states."""

    def __init__(self, system: System, t: float) -> None:
        self.system, self.t = system, t
        self._model = model_of(system)
        self._sys = new_sys(system, self._model.handle, model_facts(system))
        self._work = new(Work, **system.sizes)
        self._loop = accelerate.compiled if self._model.is_compiled else interpreted(accelerate)

    def accelerations(self, q: np.ndarray, u: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """y'' (n,) and gamma_F (n_c, n) at the states q, u (n,)."""
        system = self.system
        a, gamma_F = np.zeros(q.size), np.zeros((system.n_c, q.size))
        blocks = self._sys, self._work
        sys, work = (block.address if self._model.is_compiled else block for block in blocks)
        is_done = self._loop(sys, self.t, q, u, a, gamma_F, work)
        if not (is_done and np.isfinite(a).all()):
            raise InvalidInput("the model's functions raised or were not finite on the way; take a smaller amplitude")
        return a, gamma_F
