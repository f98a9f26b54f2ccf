"""Impacts in which the contacts gain energy: Newton's law of impact with friction allows them.

In a step, or at an impact, the contacts do on the bodies, relative to the surfaces, the work

    A = P . (gamma_0 + gamma_1) / 2,    gamma_1 = gamma_0 + d + G P

with d what forces, moving rows and the gap fed back add to gamma_0; at an impact d = 0. The laws make
P . (gamma_1 + e gamma_0) <= 0, so that with one e for all normals and tangents (1 + e) P . gamma_0 <= -P . (d + G P),

    A <= (1 - e) P . gamma_0 / 2 <= (1 - e)/(1 + e) |P . d| / 2

What A has beyond sum |P_r d_r| is due to coefficients that differ, as e_N > 0 = e_F, and not to the length of a step.
One contact that strikes and then sticks, D = G_NN G_FF - G_NF^2, gains

    A = (2 G_NF gamma_N gamma_F - (1 - e_N^2) G_FF gamma_N^2 - G_NN gamma_F^2) / (2 D)

which is positive for some gamma_F where G_NF^2 > (1 - e_N^2) G_NN G_FF. Poisson's and the energetic law do not gain.

Friction alone may do work, P_F (gamma_F0 + gamma_F1)/2 > 0, although all together loses: the law takes the force of the
end for the whole impact, at which a slide that reverses was the other way before. That is counted apart.
Source: Kane, Levinson, *Dynamics: Theory and Applications* (1985), section 4.13; Stronge, *Proc. R. Soc. A* 431 (1990)
169.
Equations: docs/theory/moreau_jean.md, (7) and (8).
"""

from __future__ import annotations

from nonsmooth.contact.planar.problem import ACCEPTED_RESIDUAL
from nonsmooth.jit import kernel, rare_kernel
from nonsmooth.mechanics.laws import LAW_E_F, LAW_E_N
from nonsmooth.mechanics.system import BILATERAL, GIVEN_FORCE
from nonsmooth.numerics.rounding import rounded_sum


@kernel
def note_gains(sys, gain, push, rounding, is_impact, n_k, state, work):
    """Note what a step, or an impact, gained beyond rounding, and where friction drove a slide."""
    if gain > rounding:
        note_gain(sys, gain, is_impact, n_k, state, work)
    if push > rounding:
        note_push(push, n_k, state, work)


@rare_kernel
def note_push(push, n_k, state, work):
    """Count an impact at which friction did work, beyond what the residual leaves open."""
    impulses, scale = 0.0, 0.0
    for r in range(work.start[n_k]):
        impulses += abs(work.P[r])
        scale = max(scale, abs(work.c[r]))
    if push > ACCEPTED_RESIDUAL * scale * impulses:
        state.counters.pushes += 1
        state.worst.push = max(state.worst.push, push)


@rare_kernel
def note_gain(sys, gain, is_impact, n_k, state, work):
    """Count a step, or an impact, whose contacts gained more than its forces, and what the residual leaves open,
    explain: ACCEPTED max |c| sum |P|. What is lost in the energies of the run is none."""
    c, gamma_0, P = work.c, work.gamma_0, work.P
    driven, impulses, scale = 0.0, 0.0, 0.0
    for k in range(n_k):
        i = work.closed[k]
        for r in range(work.start[k], work.start[k + 1]):
            is_normal = r == work.start[k] and sys.kinds[i, 0] != GIVEN_FORCE
            e = sys.laws[i, LAW_E_F]
            if is_normal:
                e = sys.laws[i, LAW_E_N] if sys.kinds[i, 0] != BILATERAL else 0.0
            if not is_impact:
                driven += abs(P[r] * (c[r] - (1.0 + e) * gamma_0[r]))
            impulses += abs(P[r])
            scale = max(scale, abs(c[r]))
    rounding = rounded_sum(2, state.worst.ledger_size)
    if gain > driven + ACCEPTED_RESIDUAL * scale * impulses + rounding:
        state.counters.gains += 1
        state.worst.gain = max(state.worst.gain, gain)
