"""What a damped contact gives back of a collision, without friction, and the damping that gives back what is meant.

    m d'' + c d' + k d = 0,    d(0) = 0, d'(0) = v,    zeta = c/(2 sqrt(k m)),    e = -d'(end)/v

    clipped         until k d + c d' = 0    e = exp(-2 zeta a/b),    a = arccos zeta, b = sqrt(1 - zeta^2);
                                            beyond zeta = 1 a = arcosh zeta, b = sqrt(zeta^2 - 1); exp(-2) at 1
    kelvin-voigt    until d = 0             e = exp(-pi zeta/sqrt(1 - zeta^2)), none from zeta = 1 on
    hunt-crossley   depends on v; undamped  e = 1

Source: Schwager, Poeschel, *Granular Matter* 9 (2007) 465 (the clipped end).
"""

from __future__ import annotations

import math

from nonsmooth.integrators.penalty.law import LAWS, NormalLaw

# chosen: no finite damper of a clipped contact gives back nothing: e goes as 1/(4 zeta^2), and the contact gives way
# 2 zeta times as long as an undamped one. What is asked for below it gets this.
LEAST_RESTITUTION = 0.01


def restitution_of(law: str, zeta: float) -> float:
    """e of a collision at a damping ratio; NaN where it depends on the velocity."""
    if zeta == 0.0:
        return 1.0
    if LAWS[law] == NormalLaw.HUNT_CROSSLEY:
        return math.nan
    if LAWS[law] == NormalLaw.KELVIN_VOIGT:
        return math.exp(-math.pi * zeta / math.sqrt(1.0 - zeta**2)) if zeta < 1.0 else 0.0
    return clipped_restitution(zeta)


def clipped_restitution(zeta: float) -> float:
    """exp(-2 zeta a/b); both forms meet smoothly at 1, where a = b = 0."""
    b = math.sqrt(abs(1.0 - zeta**2))
    if b == 0.0:
        return math.exp(-2.0)
    a = math.atan2(b, zeta) if zeta < 1.0 else math.asinh(b)
    return math.exp(-2.0 * zeta * a / b)


def damping_ratio_for(law: str, e: float) -> float:
    """The zeta whose collisions give back e, at least `LEAST_RESTITUTION` of a clipped contact; NaN for a law whose e
    depends on the velocity."""
    if LAWS[law] == NormalLaw.HUNT_CROSSLEY:
        return math.nan
    if e == 1.0:
        return 0.0
    if LAWS[law] == NormalLaw.KELVIN_VOIGT:
        return -math.log(e) / math.hypot(math.pi, math.log(e)) if e > 0.0 else 1.0
    from scipy.optimize import brentq

    e = max(e, LEAST_RESTITUTION)
    # e <= 1/(1 + zeta)^2, as at both ends of [0, inf); so zeta lies below 1/sqrt(e)
    zeta: float = brentq(lambda zeta: clipped_restitution(zeta) - e, 0.0, 1.0 / math.sqrt(e))
    return zeta
