"""Flutter without contact, and by the coupling of modes."""

from __future__ import annotations

import functools
import math

import numpy as np

import nonsmooth as ns
from benchmarks.published.rows import Row, Section
from models import FollowerForceArm, ModeCoupling

FINE = ns.EventDriven(rtol=1e-12, atol=1e-14)


@functools.cache
def arm_after(t, P, phi1):
    """Deviations from the equilibrium and their rates, (phi_1, phi_2, phi_1', phi_2'), from a start at rest."""
    arm = FollowerForceArm(P=P)
    sol = ns.simulate(arm, (0, t), *arm.state(phi1=phi1), integrator=FINE)
    return np.concatenate([sol.q[-1] - arm.equilibrium(), sol.u[-1]])


@functools.cache
def oscillating(P):
    """The eigenvalue of the arm that grows most."""
    return ns.linearise(FollowerForceArm(P=P)).dominant


@functools.cache
def coupled():
    """The cycle of the damped mass at mu = 0.6, from a start beside steady sliding."""
    return ns.limit_cycle(ModeCoupling(mu=0.6), duration=60.0, dt=5e-4)


def coupled_range(side):
    """Least (0) or largest (1) deviations from steady sliding and rates, (y_1, y_2, y_1', y_2')."""
    return coupled().extremes[side] - np.concatenate([ModeCoupling(mu=0.6).equilibrium(), [0.0, 0.0]])


def end_of_stick():
    """(y_1, y_2, y_1', y_2') where slip begins."""
    (slip,) = [phase for phase in coupled().phases if not phase.sticks]
    return np.concatenate([slip.q - ModeCoupling(mu=0.6).equilibrium(), slip.u])


def squared_frequencies(mu):
    """omega^2 of the mass without damping, complex beyond flutter."""
    s = ns.linearise(ModeCoupling(cx=0.0, cz=0.0, mu=mu)).eigenvalues
    return sorted(-(s[s.imag >= 0] ** 2), key=lambda square: (square.real, square.imag))


def edge(model, parameter, bracket):
    """Where steady sliding loses its stability."""
    return ns.flutter_boundary(model, parameter, bracket)


UNDAMPED = ModeCoupling(cx=0.0, cz=0.0)
ARM_500 = ("-0.021525545", "0.013952941", "2.625585437", "-4.058975616")
ARM_1000 = {0.5: ("0.128952859", "-0.240257355", "8.535722285", "-13.650474257"),
            1.0: ("0.384635644", "-0.636994466", "6.667450408", "-5.10260154")}  # fmt: skip
STATE = ("phi_1 [rad]", "phi_2 [rad]", "phi_1' [rad/s]", "phi_2' [rad/s]")
RANGE = (("y_1 [m]", "-1.014243", "0.655763"), ("y_2 [m]", "-1.527588", "1.460413"),
         ("y_1' [m/s]", "-13.291654", "10"), ("y_2' [m/s]", "-22.428607", "22.594766"))  # fmt: skip

SECTIONS = (
    Section(
        "arm",
        "An arm with a follower force",
        "Massless links of 0.5 m, 1 kg at elbow and tip, 1000 and 100 N m/rad, at rest at 30 "
        "degrees. The chapter also prints the stiffness as K + dh/dq (its displayed matrix is right), and excludes "
        "divergence by det K, where det Lp is meant.",
        (
            Row(
                "load of flutter [N]", "900", lambda: edge(FollowerForceArm(), "P", (0, 2000)).value,
                corrected="948.126555160", errs="the chapter rounds it to about 900 N",
            ),
            Row("omega^2 there [1/s^2]", "1131.370850",
                lambda: edge(FollowerForceArm(), "P", (0, 2000)).frequency ** 2, within=1e-3,
                why="a double eigenvalue is known to the root of rounding"),
            Row("load that ends the complex range [N]", "2698.363351", lambda: FollowerForceArm().critical_loads()[1]),
            Row("th1 of the equilibrium, 500 N [rad]", "-0.125",
                lambda: ns.equilibrium(FollowerForceArm(P=500.0)).q[0], within=1e-12, why="exact"),
            Row("th2 [rad]", "0.398599", lambda: ns.equilibrium(FollowerForceArm(P=500.0)).q[1]),
            Row("th2, 1000 N [rad]", "0.273599", lambda: ns.equilibrium(FollowerForceArm(P=1000.0)).q[1]),
            Row("first frequency at 500 N [rad/s]", "20.676943655",
                lambda: min(ns.linearise(FollowerForceArm(P=500.0)).frequencies)),
            Row("second one [rad/s]", "54.716541708",
                lambda: max(ns.linearise(FollowerForceArm(P=500.0)).frequencies)),
            Row("growth rate at 1000 N [1/s]", "5.790640885", lambda: oscillating(1000.0).real),
            Row("frequency [rad/s]", "33.133658537", lambda: abs(oscillating(1000.0).imag)),
            Row("real part of omega^2 [1/s^2]", "1064.307806", lambda: -(oscillating(1000.0) ** 2).real),
            Row("imaginary part [1/s^2]", "383.730236", lambda: abs((oscillating(1000.0) ** 2).imag)),
            *(
                Row(f"{name} after 1 s from phi_1 = 0.05, 500 N", printed, lambda k=k: arm_after(1.0, 500.0, 0.05)[k])
                for k, (name, printed) in enumerate(zip(STATE, ARM_500, strict=True))
            ),
            *(
                Row(f"{name} after {t} s from phi_1 = 0.01, 1000 N", printed,
                    lambda k=k, t=t: arm_after(t, 1000.0, 0.01)[k])
                for t, line in ARM_1000.items() for k, (name, printed) in enumerate(zip(STATE, line, strict=True))
            ),
        ),
        (edge, oscillating, arm_after),
        table="B",
    ),
    Section(
        "coupling",
        "Coupled modes: a mass on a conveyor with an oblique spring",
        "Mass m = 1 kg, k = kx = 100, kz = 200 N/m, vb = 10 m/s, damping 1.33 and 1 N s/m, R = 1000 N "
        "(not printed). The chapter also prints the load vector with the wrong components (0, -R is right), and the "
        "condition of slip with an absolute value.",
        (
            Row(
                "critical friction without damping, formula",
                lambda: ((100.0 - 200.0) ** 2 + 100.0**2) / (100.0 * 200.0),
                lambda: edge(UNDAMPED, "mu", (0.8, 0.3)).value,
                corrected=lambda: ((100.0 - 200.0) ** 2 + 100.0**2) / (2 * 100.0 * 200.0),
                errs="the chapter's formula lacks the 2 of its denominator",
            ),
            Row("the same, quoted", "0.5", lambda: edge(UNDAMPED, "mu", (0.8, 0.3)).value, within=1e-9,
                why="exact; a double eigenvalue"),
            Row(
                "omega^2 where the frequencies meet [1/s^2]", lambda: math.sqrt((100.0 + 200.0 + 100.0) / 2),
                lambda: round(edge(UNDAMPED, "mu", (0.8, 0.3)).frequency ** 2, 4), corrected="200",
                errs="the chapter's formula has a root too many",
            ),
            Row("omega_1^2, mu = 0 [1/s^2]", "129.289322", lambda: squared_frequencies(0.0)[0].real),
            Row("omega_2^2, mu = 0 [1/s^2]", "270.710678", lambda: squared_frequencies(0.0)[-1].real),
            Row("real part, mu = 0.6 [1/s^2]", "200", lambda: squared_frequencies(0.6)[0].real, within=1e-10,
                why="exact"),
            Row("imaginary part, mu = 0.6 [1/s^2]", "31.622777", lambda: abs(squared_frequencies(0.6)[0].imag)),
            Row("critical friction with damping", "0.522527017", lambda: edge(ModeCoupling(), "mu", (0.3, 0.8)).value),
            Row("frequency there [rad/s]", "14.390328", lambda: edge(ModeCoupling(), "mu", (0.3, 0.8)).frequency),
            Row("growth rate, mu = 0.6 [1/s]", "0.538256313", lambda: ns.linearise(ModeCoupling(mu=0.6)).dominant.real),
            Row("its frequency [rad/s]", "14.303524084",
                lambda: abs(ns.linearise(ModeCoupling(mu=0.6)).dominant.imag)),
            Row("decay of the other mode [1/s]", "-1.703256313",
                lambda: min(ns.linearise(ModeCoupling(mu=0.6)).eigenvalues.real)),
            Row("period of the cycle [s]", "0.416823626", lambda: coupled().period),
            Row("time of stick [s]", "0.088711270", lambda: coupled().stick_duration),
            *(
                Row(f"{end} {name}", printed[side], lambda side=side, k=k: coupled_range(side)[k])
                for k, (name, *printed) in enumerate(RANGE) for side, end in enumerate(("least", "largest"))
            ),
            Row("y_1 where slip begins [m]", "0.090339759", lambda: end_of_stick()[0]),
            Row("y_2 there [m]", "-0.383585197", lambda: end_of_stick()[1]),
            Row("y_2' there [m/s]", "21.995303625", lambda: end_of_stick()[3]),
            Row("largest multiplier", "0.8756", lambda: max(coupled().multipliers.real)),
            Row("least multiplier", "-0.4306", lambda: min(coupled().multipliers.real)),
            Row("load below which the cycle lifts off [N]", "399.1795",
                lambda: ModeCoupling(mu=0.6).lift_off_load(coupled_range(1)[1])),
            Row("z of steady sliding over R [m/N]", "-0.003658537",
                lambda: ns.equilibrium(ModeCoupling(mu=0.6, R=1.0)).q[1]),
        ),
        (edge, squared_frequencies, coupled, coupled_range, end_of_stick),
        table="C",
    ),
)  # fmt: skip
