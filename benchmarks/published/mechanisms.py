"""Andrews' squeezing mechanism: seven bodies, six equations of closure, from its energies."""

from __future__ import annotations

import functools

import numpy as np
import sympy as sp
from scipy.integrate import solve_ivp

import nonsmooth as ns
from benchmarks.published.rows import Row, Section
from nonsmooth.mechanics.system import FORCE, MASS, NORMAL, ROW_RATES

START = (-0.0617138900142764496, 0.0, 0.455279819163070380, 0.222668390165885885, 0.487364979543842550,
         -0.222668390165885885, 1.23054744454982120)  # fmt: skip


@functools.cache
def andrews():
    """The mechanism with the numbers of the test set, in metres and kilograms."""
    l = ns.lagrangian("Andrews' squeezer")
    beta, Theta, gamma, Phi, delta, Omega, epsilon = l.coordinates("beta Theta gamma Phi delta Omega epsilon")
    A, B, C = np.array([-0.06934, -0.00227]), np.array([-0.03635, 0.03273]), np.array([0.014, 0.072])

    def turned(angle, x, y):
        """A point of a body."""
        return np.array([sp.cos(angle) * x - sp.sin(angle) * y, sp.sin(angle) * x + sp.cos(angle) * y])

    crank, joint = turned(beta, 0.007, 0), turned(beta, 0.007, 0) - turned(beta + Theta, 0.028, 0)
    bodies = (  # mass, inertia, centre, angle
        (0.04325, 2.194e-6, turned(beta, 0.00092, 0), beta),
        (0.00365, 4.41e-7, crank - turned(beta + Theta, 0.0115, 0), beta + Theta),
        (0.02373, 5.255e-6, B + turned(gamma, 0.01043, -0.01874), gamma),
        (0.00706, 5.667e-7, A + turned(delta, 0.04, 0) - turned(Phi + delta, 0, 0.02 - 0.01421), Phi + delta),
        (0.0705, 1.169e-5, A + turned(delta, 0.02308, 0.00916), delta),
        (0.00706, 5.667e-7, A - turned(epsilon, 0, 0.04) + turned(Omega + epsilon, 0.02 - 0.01421, 0), Omega + epsilon),
        (0.05498, 1.912e-5, A - turned(epsilon, 0.00449, 0.01228), epsilon),
    )
    for m, I, centre, angle in bodies:
        l.rigid_body(m, I, at=tuple(centre), angle=angle)
    ends = (
        B - turned(gamma, 0, 0.035),
        A + turned(delta, 0.04, 0) - turned(Phi + delta, 0, 0.02),
        A - turned(epsilon, 0, 0.04) + turned(Omega + epsilon, 0.02, 0),
    )
    for end in ends:
        for closure in joint - end:
            l.constraint(closure)
    spring = B + turned(gamma, 0.02, -0.018) - C
    l.potential(4530 * (sp.sqrt(spring[0] ** 2 + spring[1] ** 2) - 0.07785) ** 2 / 2)
    l.force(0.033, at=beta)
    return l.model()


@functools.cache
def after(t):
    """The angles and their rates at a time."""
    sol = ns.simulate(andrews(), (0, t), START, np.zeros(7), integrator=ns.EventDriven(rtol=1e-12, atol=1e-14))
    return sol.q[-1], sol.u[-1]


@functools.cache
def forces():
    """The only solution at the start: accelerations and the forces of the closures."""
    (solution,) = ns.classify(andrews(), 0.0, START, np.zeros(7)).solutions
    return solution


def by_scipy(t):
    """Angles and rates by SciPy: accelerations from the closures differentiated twice, DOP853 at 3e-14."""
    system = andrews().system()

    def rate(t, x):
        q, u = x[:7], x[7:]
        M, W, h = (system.evaluate(which, t, q, u) for which in (MASS, NORMAL, FORCE))
        inertia = np.block([[M, W.T], [W, np.zeros((6, 6))]])
        free = np.concatenate([h, -system.evaluate(ROW_RATES, t, q, u)[:, 0]])
        return np.concatenate([u, np.linalg.solve(inertia, free)[:7]])

    x = solve_ivp(rate, (0, t), [*START, *np.zeros(7)], "DOP853", rtol=3e-14, atol=1e-16).y[:, -1]
    return x[:7], x[7:]


ANGLES = ("beta", "Theta", "gamma", "Phi", "delta", "Omega", "epsilon")
AT_END = ("15.81077119629904", "-15.75637105984298", "0.04082224013073101", "-0.5347301163226948",
          "0.5244099658805304", "0.5347301163226948", "1.048080741042263")  # fmt: skip
RATES = ("1139.920302151208", "-1424.379294994111", "11.03291221937134", "19.29337464421385",
         "0.5735699284790808", "-19.29337464421385", "0.3231791658026955")  # fmt: skip
PRINTED = "error of the reference, see above"

SECTIONS = (
    Section(
        "andrews",
        "Andrews' squeezing mechanism",
        "*Test Set for IVP Solvers*, Andrews' squeezing mechanism; Hairer, Wanner, *Solving Ordinary Differential "
        "Equations II* (1996), VI.9. Seven bodies driven by 0.033 N m; the closures are bilateral contacts without "
        "friction. A page of OpenSim's benchmarks prints the point B at x = +0.03635 m, which has the wrong sign. "
        "The reference at 0.03 s was integrated by PSIDE with tolerances of 1e-14 and errs by 1.2e-9 rad and "
        "5.4e-7 rad/s: SciPy's DOP853 at 3e-14 (`by_scipy`) meets our angles to 1e-12 rad, our rates to 1e-9 rad/s.",
        (
            Row("beta'' at the start [rad/s^2]", "14222.4439199541139", lambda: forces().du[0], within=1e-8,
                why="14 digits are printed beyond rounding"),
            Row("Theta'' at the start [rad/s^2]", "-10666.8329399655855", lambda: forces().du[1], within=1e-8,
                why="14 digits are printed beyond rounding"),
            Row("first force of closure [N]", "98.5668703962410896", lambda: -forces().la_N[0], within=1e-10,
                why="rounding; it counts with the other sign"),
            Row("second one [N]", "-6.12268834425566266", lambda: -forces().la_N[1], within=1e-10,
                why="rounding; it counts with the other sign"),
            *(
                Row(f"{name} at 0.03 s [rad]", printed, lambda k=k: after(0.03)[0][k], within=2e-9, why=PRINTED)
                for k, (name, printed) in enumerate(zip(ANGLES, AT_END, strict=True))
            ),
            *(
                Row(f"{name}' at 0.03 s [rad/s]", printed, lambda k=k: after(0.03)[1][k], within=6e-7, why=PRINTED)
                for k, (name, printed) in enumerate(zip(ANGLES, RATES, strict=True))
            ),
        ),
        (andrews, after, forces, by_scipy),
    ),
)  # fmt: skip
