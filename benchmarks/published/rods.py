"""Painlevé's rod with a unilateral and a bilateral contact, compliant contact, self-locking."""

from __future__ import annotations

import functools
import math

import numpy as np
from scipy.optimize import brentq

import nonsmooth as ns
from benchmarks.published.rows import Row, Section
from models import BilateralRod, PainleveRod, SelfLockingRod

FINE = ns.EventDriven(rtol=1e-12, atol=1e-14)
ROD = PainleveRod(mu=2.0)
STEEP = math.pi / 3
ELASTIC = "0.255296505"  # gamma_N after the impact without collision of ROD, energetic with e = 1


@functools.cache
def state_of(rod, degrees, thdot, slip):
    """Every contact force of a rod whose tip slips at 1 m/s, and the impacts without collision at e = 1."""
    start = {"th": math.radians(degrees), "thdot": thdot, "slip": slip}
    return ns.classify(rod, state=start, restitution=1.0)


def p_of(rod, degrees, slip):
    """Coefficient of the normal force, the chapter's A."""
    return state_of(rod, degrees, 0.0, slip).p[0, 0 if slip > 0 else 1]


def forces(rod, degrees, thdot, slip):
    """Normal forces of all solutions in which the contact is pressed or pulled, in increasing order [N]."""
    return sorted(solution.la_N[0] for solution in state_of(rod, degrees, thdot, slip).solutions if solution.la_N[0])


def impact(rod, law):
    """The impact without collision of a rod at 60 degrees, at rest but for its slip of -1 m/s."""
    (found,) = [one for one in state_of(rod, 60, 0.0, -1.0).impacts if one.law.name == law]
    return found


def paradoxical_angle(mu, bracket):
    """Angle [degrees] at which a coefficient of friction is critical."""

    def excess(degrees):
        return ns.critical_friction(ROD, ROD.state(th=math.radians(degrees))[0]) - mu

    return brentq(excess, *bracket, xtol=1e-13)


@functools.cache
def fallen(rod, degrees, thdot, slip):
    """The motion of a rod until it has fallen to 2 degrees."""
    start = rod.state(th=math.radians(degrees), thdot=thdot, slip=slip)
    return ns.simulate(rod, (0, 1), *start, integrator=FINE, events=lambda t, q, u: q[2] - math.radians(2))


def zero_of_force(rod, degrees, thdot, slip):
    """First time at which a bilateral contact is neither pressed nor pulled: a record of the run."""
    sol = fallen(rod, degrees, thdot, slip)
    return sol.t[np.abs(sol.la[:, 0, 0]) < 1e-9][0]


def compliant(k, thdot=0.0, force=0.0, rod=ROD, **damping):
    """The rod on springs, 60 degrees, slip -1 m/s, with a force in the spring at the start."""
    q0, u0 = rod.state(th=STEEP, thdot=thdot, slip=-1.0)
    q0[1] -= force / k
    integrator = ns.Penalty(stiffness=k, rtol=1e-10, atol=1e-12, **damping)
    return ns.simulate(rod, (0, 20 * math.log10(k) / math.sqrt(k)), q0, u0, integrator=integrator)


def thrown_back(k):
    """gamma_N where the compliant contact opens [m/s]."""
    return next(event.gamma_N for event in compliant(k).events if event.mode_after == ns.ContactMode.OPEN)


def seizing_force(k):
    """Least force in the spring, of that of the saddle, at which an indeterminate state ends in an impact."""
    (saddle,) = forces(ROD, 60, 6.0, -1.0)
    low, high = 1.0, 1.2
    while high - low > 1e-7:
        part = 0.5 * (low + high)
        sticks = any(event.mode_after == ns.ContactMode.STICK for event in compliant(k, 6.0, part * saddle).events)
        low, high = (low, part) if sticks else (part, high)
    return high


def restitution(rod, zeta):
    """Energetic restitution of a stiff contact with damping zeta, in an impact without collision."""
    after = [rod.compliant_limit(th=STEEP, zeta=value).gamma_N for value in (zeta, 0.0)]
    return after[0] / after[1]


def jam_angle(mu):
    """Angle [degrees] at which a pressed rod locks: friction is critical."""
    rod = SelfLockingRod(mu=mu)

    def excess(th):
        return ns.critical_friction(rod, [th]) - mu

    return math.degrees(brentq(excess, 0.01, 1.56, xtol=1e-14))


def pressed(mu, degrees):
    """Every force of a rod that stands on the moving plane."""
    rod = SelfLockingRod(mu=mu, th0=math.radians(degrees))
    return ns.classify(rod, 0.0, *rod.state(thdot=0.0)).solutions


STATES = (  # mu, th [deg], th' [rad/s], slip; p [1/kg], b [m/s^2], number of solutions, the force that is not zero [N]
    (0.5, 60, 0.0, -1.0, "1.10048095", "-9.81", "1", "8.914284273"),
    (0.5, 60, 6.0, -1.0, "1.10048095", "5.77845727", "1", None),
    (2.0, 60, 0.0, -1.0, "-0.84807621", "-9.81", "0", None),
    (2.0, 60, 6.0, -1.0, "-0.84807621", "5.77845727", "2", "6.813606125"),
    (2.0, 60, 0.0, 1.0, "4.34807621", "-9.81", "1", "2.256170206"),
    (1.5, 65, 3.0, -1.0, "-0.18778141", "-5.73161496", "0", None),
    (1.5, 65, 5.0, -1.0, "-0.18778141", "1.51884734", "2", "8.088379598"),
)
BILATERAL = (  # th' [rad/s], slip; forces [N]
    (6.0, -1.0, ("-1.328968718", "6.813606125")), (0.0, -1.0, ()), (0.0, 1.0, ("-11.567356646", "2.256170206")),
    (6.0, 1.0, ()),
)  # fmt: skip
T1, T2 = (PainleveRod(mu=0.3), 50, 0.0, -0.4), (PainleveRod(mu=0.3), 50, 0.0, 0.8)
T3, T4 = (PainleveRod(mu=0.3), 20, 6.0, -1.0), (PainleveRod(mu=1.0), 75, -0.5, -0.5)
U1, U2 = (BilateralRod(mu=0.3), 20, 6.0, -1.0), (BilateralRod(mu=0.8), 40, 7.0, -0.3)
LIMITS = {0.1: "0.200882468 1.148376255", 0.5: "0.091258409 1.230594299", 1.0: "0.043548397 1.266376808"}
EXCESS = {1e6: "0.0438", 1e8: "0.00788", 1e10: "0.00117", 1e12: "0.000155"}

SECTIONS = (
    Section(
        "rod",
        "Painlevé's rod",
        "Mass m = 1 kg, l = 1 m, I = 1/12 kg m^2, g = 9.81 m/s^2; gamma_N' = p la_N + b. The least "
        "critical friction of 4/3 is that of Génot and Brogliato, *Eur. J. Mech. A/Solids* 18 (1999) 653.",
        (
            Row("least critical friction", "4/3",
                lambda: ns.least_critical_friction(ROD, ROD.state()[0], "th", (0.0, math.pi / 2)).mu,
                within=1e-12, why="exact"),
            Row("its angle [degrees]", "63.4349",
                lambda: math.degrees(ns.least_critical_friction(ROD, ROD.state()[0], "th", (0.0, math.pi / 2)).at)),
            Row(
                "critical friction at 60 degrees", lambda: 1 / math.tan(STEEP),
                lambda: ns.critical_friction(ROD, ROD.state(th=STEEP)[0]),
                corrected=lambda: (1 + 3 * math.cos(STEEP) ** 2) / (3 * math.sin(STEEP) * math.cos(STEEP)),
                errs="the chapter's mu > cot th is necessary, not sufficient",
            ),
            *(
                Row(f"{end} paradoxical angle, mu = {mu} [degrees]", printed,
                    lambda mu=mu, bracket=bracket: paradoxical_angle(mu, bracket))
                for mu, end, printed, bracket in (
                    (1.5, "first", "50.641598", (5, 63)), (1.5, "last", "73.048469", (64, 89)),
                    (2.0, "first", "37.377368", (5, 63)),
                )
            ),
            Row(
                "last paradoxical angle, mu = 2 [degrees]", "79.187684", lambda: paradoxical_angle(2.0, (64, 89)),
                corrected="79.187683",
                errs="the corrected table, by a unit of its last digit: arctan(3 + sqrt 5) = 79.18768304",
            ),
            *(
                Row(f"p, mu = {mu}, {th} degrees, slip {slip:+g} m/s [1/kg]", p,
                    lambda mu=mu, th=th, slip=slip: p_of(PainleveRod(mu=mu), th, slip))
                for mu, th, p, slip in dict.fromkeys((mu, th, p, slip) for mu, th, _, slip, p, *_ in STATES)
            ),
            *(
                Row(f"b, {th} degrees, th' = {thdot} rad/s [m/s^2]", b,
                    lambda th=th, thdot=thdot: state_of(ROD, th, thdot, -1.0).b[0])
                for th, thdot, b in dict.fromkeys((th, thdot, b) for _, th, thdot, _, _, b, *_ in STATES)
            ),
            *(
                Row(f"solutions, mu = {mu}, {th} degrees, th' = {thdot} rad/s, slip {slip:+g} m/s", n,
                    lambda mu=mu, th=th, thdot=thdot, slip=slip: (
                        state_of(PainleveRod(mu=mu), th, thdot, slip).n_solutions))
                for mu, th, thdot, slip, _, _, n, _ in STATES
            ),
            *(
                Row(f"normal force, mu = {mu}, {th} degrees, th' = {thdot} rad/s, slip {slip:+g} m/s [N]", N,
                    lambda mu=mu, th=th, thdot=thdot, slip=slip: forces(PainleveRod(mu=mu), th, thdot, slip)[0])
                for mu, th, thdot, slip, _, _, _, N in STATES if N
            ),
            Row(
                "normal force, mu = 0.5, 60 degrees, at rest but for its slip to the left [N]",
                lambda: 9.81 / (1 + 3 * (math.cos(STEEP) + 0.5 * math.sin(STEEP)) * math.cos(STEEP)),
                lambda: forces(PainleveRod(mu=0.5), 60, 0.0, -1.0)[0], corrected="8.914284273",
                errs="the chapter prints friction without its minus, Ft = mu N sgn u",
            ),
        ),
        (state_of, p_of, forces, paradoxical_angle),
        table="D",
    ),
    Section(
        "rod-motions",
        "Motions of Painlevé's rod",
        "It falls to 2 degrees. T1, T2: mu = 0.3, from 50 degrees at rest, slip -0.4 and 0.8 m/s; "
        "T3: mu = 0.3, 20 degrees, 6 rad/s, -1 m/s; T4: mu = 1, 75 degrees, -0.5 rad/s, -0.5 m/s.",
        (
            Row("T1: end [s]", "0.361904031", lambda: fallen(*T1).t_events[0][0]),
            Row("T2: slip reverses [s]", "0.112538799", lambda: fallen(*T2).events[0].t),
            Row("T2: reverses again [s]", "0.200072319", lambda: fallen(*T2).events[1].t),
            Row("T2: end [s]", "0.330648443", lambda: fallen(*T2).t_events[0][0]),
            Row("T3: lifts off [s]", "0.042777016", lambda: fallen(*T3).events[0].t),
            Row("T3: th there [rad]", "0.602423510", lambda: fallen(*T3)(fallen(*T3).events[0].t).q[2]),
            Row("T3: th' there [rad/s]", "5.884309335", lambda: fallen(*T3)(fallen(*T3).events[0].t).u[2]),
            Row("T3: x' there [m/s]", "-2.018621486", lambda: fallen(*T3)(fallen(*T3).events[0].t).u[0]),
            Row("T4: begins to stick [s]", "0.007552851", lambda: fallen(*T4).events[0].t),
            Row("T4: slips again [s]", "0.587985263", lambda: fallen(*T4).events[1].t),
            Row("T4: end [s]", "0.721927014", lambda: fallen(*T4).t_events[0][0]),
        ),
        (fallen,),
        table="D",
    ),
    Section(
        "impact-without-collision",
        "Impacts without collision",
        "With mu = 2, 60 degrees, no rotation, slip -1 m/s: no contact force exists, so the tip strikes "
        "the ground on which it slides. Contact by a spring k [N/m] and a damper 2 zeta sqrt(k m) tends to these "
        "impacts; below, mu = 1.8, l = 2 m, I = 1/3 kg m^2.",
        (
            Row("normal impulse, plastic [N s]", "0.32475953", lambda: impact(ROD, "NEWTON").P_N[0]),
            Row("friction impulse, plastic [N s]", "0.4375", lambda: impact(ROD, "NEWTON").P_F[0], within=1e-12,
                why="exact"),
            Row("th' after it [rad/s]", "1.29903811", lambda: impact(ROD, "NEWTON").u[2]),
            Row("impulse until slip ends [N s]", "0.19227213", lambda: ROD.impact_without_collision(th=STEEP).P_1),
            Row("gamma_N after it, energetic, e = 1 [m/s]", ELASTIC, lambda: impact(ROD, "ENERGETIC").gamma_N[0]),
            Row("th' after it [rad/s]", "1.107565727", lambda: impact(ROD, "ENERGETIC").u[2]),
            *(
                Row(f"gamma_N, compliant limit, zeta = {zeta} [m/s]", line.split()[0],
                    lambda zeta=zeta: ROD.compliant_limit(th=STEEP, zeta=zeta).gamma_N)
                for zeta, line in LIMITS.items()
            ),
            *(
                Row(f"th', compliant limit, zeta = {zeta} [rad/s]", line.split()[1],
                    lambda zeta=zeta: ROD.compliant_limit(th=STEEP, zeta=zeta).u[2])
                for zeta, line in LIMITS.items()
            ),
            *(
                Row(f"gamma_N above the limit, k = {k:g} [m/s]", printed,
                    lambda k=k: thrown_back(k) - impact(ROD, "ENERGETIC").gamma_N[0])
                for k, printed in EXCESS.items()
            ),
            *(
                Row(f"force of an indeterminate state that seizes, of its saddle's, k = {k:g}", printed,
                    lambda k=k: seizing_force(k))
                for k, printed in ((1e6, "1.0708"), (1e8, "1.0063"), (1e10, "1.00062"))
            ),
            Row("gamma_N, mu = 1.8, energetic, e = 1 [m/s]", "0.22730317",
                lambda: impact(PainleveRod(l=2.0, I=1 / 3, mu=1.8), "ENERGETIC").gamma_N[0]),
            Row("gamma_N, mu = 1.8, Poisson, e = 1 [m/s]", "0.39970403",
                lambda: impact(PainleveRod(l=2.0, I=1 / 3, mu=1.8), "POISSON").gamma_N[0]),
            *(
                Row(f"effective energetic restitution, zeta = {zeta}", printed,
                    lambda zeta=zeta: restitution(PainleveRod(l=2.0, I=1 / 3, mu=1.8), zeta))
                for zeta, printed in ((0.05, "0.8889"), (0.1, "0.7945"), (0.2, "0.6439"), (0.5, "0.3739"),
                                      (1.0, "0.1838"), (2.0, "0.0678"))
            ),
        ),
        (impact, compliant, thrown_back, seizing_force, restitution),
        table="D",
    ),
    Section(
        "bilateral",
        "Painlevé's rod with its tip held on the ground",
        "The rod of table D, mu = 2, 60 degrees. U1: mu = 0.3, 20 degrees, 6 rad/s, -1 m/s; U2: "
        "mu = 0.8, 40 degrees, 7 rad/s, -0.3 m/s.",
        (
            *(
                Row(f"solutions, th' = {thdot} rad/s, slip {slip:+g} m/s", str(len(found)),
                    lambda thdot=thdot, slip=slip: state_of(BilateralRod(mu=2.0), 60, thdot, slip).n_solutions)
                for thdot, slip, found in BILATERAL
            ),
            *(
                Row(f"force {k + 1}, th' = {thdot} rad/s, slip {slip:+g} m/s [N]", N,
                    lambda thdot=thdot, slip=slip, k=k: forces(BilateralRod(mu=2.0), 60, thdot, slip)[k])
                for thdot, slip, found in BILATERAL for k, N in enumerate(found)
            ),
            Row(
                "force that presses, at rest, slip to the right [N]",
                lambda: -9.81 / (1 + 3 * (math.cos(STEEP) + 2 * math.sin(STEEP)) * math.cos(STEEP)),
                lambda: forces(BilateralRod(mu=2.0), 60, 0.0, 1.0)[1], corrected="2.256170206",
                errs="the chapter prints N = B/A, which lacks a minus; so do N+ and N-",
            ),
            Row(
                "solutions for B < 0, slip to the left", "2",
                lambda: state_of(BilateralRod(mu=2.0), 60, 0.0, -1.0).n_solutions, corrected="0",
                errs="the chapter interchanges two and none, by the sign of N",
            ),
            Row(
                "solutions for B < 0, slip to the right", "1",
                lambda: state_of(BilateralRod(mu=2.0), 60, 0.0, 1.0).n_solutions, corrected="2",
                errs="the chapter says that paradoxes need slip to the left; a contact that pulls has them too",
            ),
            Row("U1: N changes its sign [s]", "0.042777016", lambda: zero_of_force(*U1)),
            Row("U1: slip reverses [s]", "0.067382918", lambda: fallen(*U1).events[0].t),
            Row("U1: reverses again [s]", "0.275053724", lambda: fallen(*U1).events[1].t),
            Row("U2: slip reverses [s]", "0.012095236", lambda: fallen(*U2).events[0].t),
            Row("U2: begins to stick [s]", "0.061687512", lambda: fallen(*U2).events[1].t),
            Row("U2: slips again [s]", "0.216340381", lambda: fallen(*U2).events[2].t),
        ),
        (zero_of_force,),
        table="E",
    ),
    Section(
        "self-locking",
        "A rod that locks itself",
        "Pivoted above a plane that moves towards the pivot, pressed down by R; N = R/(1 - mu tan "
        "th). Beyond the angle of jamming there is no solution, and no impact without collision either.",
        (
            *(
                Row(f"angle of jamming, mu = {mu} [degrees]", printed, lambda mu=mu: jam_angle(mu))
                for mu, printed in ((0.3, "73.300756"), (0.5, "63.434949"), (1.0, "45.000000"), (1.3, "37.568592"))
            ),
            *(
                Row(f"N/R, mu = 1, {degrees} degrees", printed,
                    lambda degrees=degrees: pressed(1.0, degrees)[0].la_N[0])
                for degrees, printed in ((10, "1.214074"), (20, "1.572253"), (30, "2.366025"), (44, "29.144981"))
            ),
            Row("solutions, mu = 1, 50 degrees", "0", lambda: len(pressed(1.0, 50))),
        ),
        (jam_angle, pressed),
        table="F",
    ),
)  # fmt: skip
