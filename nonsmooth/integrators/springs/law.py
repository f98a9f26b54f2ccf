"""The force of a compliant contact of a scene: a spring with a damper, and beside it a spring that slides at mu la_N.

    la_N = max(0, k d + c d'),  d = -g_N            (or as penalty/law.py has it)
    stick   la_T = -(k_T xi + c_T gamma_T),  xi' = gamma_T,    |la_T| <= mu |la_N|
    slide   la_T = mu |la_N| in that direction,  k_T |xi| <= mu |la_N|

xi is the elongation of the tangential spring, k_T = ratio k and c_T = sqrt(ratio) c, the same part of critical damping.
Or la_T = -mu |la_N| tanh(|gamma_T|/v_s) gamma_T/|gamma_T|. Sources: Cundall and Strack, *Geotechnique* 29 (1979) 47-65;
Luding, *Granular Matter* 10 (2008) 235-246.
"""

from __future__ import annotations

import math
from typing import Annotated as Array

from nonsmooth.integrators.penalty.law import NormalLaw, normal_force
from nonsmooth.jit import kernel
from nonsmooth.jit.blocks import Block, Floats, Ints


class Law(Block):
    """Coefficients of all contacts."""

    law: int  # of the normal force, ``NormalLaw``
    is_regularised: int
    k: float  # [N/m]
    c: float  # [N s/m]
    zeta: float  # c = 2 zeta sqrt(k m), or < 0
    mass: float  # m, or 0: 1/G_NN of the contact [kg]
    ratio: float  # k_T/k
    v_s: float  # [m/s]


class Springs(Block):
    """The contacts that were closed when the step began, in the order of their keys, and what their springs did."""

    n_before: int
    is_asked: int  # whether the run keeps pairs
    key_before: Array[Ints, "m"]
    point_before: Array[Floats, "m", "d"]
    normal_before: Array[Floats, "m", "d"]
    xi: Array[Floats, "m", "d"]  # elongations [m]; in the plane along the tangent, in xi[:, 0], in space in the world
    rate: Array[Floats, "stages", "m", "d"]  # their rates, in the axes of the beginning of the step
    exchange: Array[Floats, "stages", "m", "exchanged"]  # forces and powers (exchange.py); none where nobody asks
    is_taken: Array[Ints, "m"]
    source: Array[Ints, "m"]  # the spring of a contact that was found
    stretch: Array[Floats, "m", "d"]  # of a contact that was found, at the present stage
    excess: Array[Floats, "m"]  # by which a spring went beyond its slider in the step, at most [m]
    next_key: Array[Ints, "m"]  # of the step to come
    next_xi: Array[Floats, "m", "d"]
    next_rate: Array[Floats, "m", "d"]


@kernel
def damping_of(law, G_NN):
    """c of a contact."""
    if law.zeta < 0.0 or G_NN <= 0.0:
        return law.c
    return 2.0 * law.zeta * math.sqrt(law.k * (law.mass if law.mass > 0.0 else 1.0 / G_NN))


@kernel
def spring_and_damper(law, c, d, d_rate):
    """la_N of a closed contact, and what of it is the spring's."""
    la = normal_force(law.law, law.k, c, d, d_rate)
    if law.law != NormalLaw.KELVIN_VOIGT:
        la = max(0.0, la)
    return la, normal_force(law.law, law.k, 0.0, d, 0.0)


@kernel
def elastic_energy(law, d):
    """Of the normal spring [J]."""
    return 0.4 * law.k * d * d * math.sqrt(d) if law.law == NormalLaw.HUNT_CROSSLEY else 0.5 * law.k * d * d


@kernel
def friction(law, c, limit, xi_1, xi_2, gamma_1, gamma_2):
    """la_T, and whether it slides."""
    if law.is_regularised == 1:
        speed = math.sqrt(gamma_1 * gamma_1 + gamma_2 * gamma_2)
        scale = -limit * math.tanh(speed / law.v_s) / speed if speed > 0.0 else 0.0
        return scale * gamma_1, scale * gamma_2, True
    k_T, c_T = law.ratio * law.k, math.sqrt(law.ratio) * c
    la_1, la_2 = -(k_T * xi_1 + c_T * gamma_1), -(k_T * xi_2 + c_T * gamma_2)
    size = math.sqrt(la_1 * la_1 + la_2 * la_2)
    if size <= limit:
        return la_1, la_2, False
    return limit / size * la_1, limit / size * la_2, True
