"""The sprag-slip rod: rigid contact, its limit cycle, its seizures, compliant contact; the lead screw."""

from __future__ import annotations

import functools
import math

import numpy as np

import nonsmooth as ns
from benchmarks.published.rows import Row, Section
from models import LeadScrew, SpragSlip

FINE = ns.EventDriven(rtol=1e-12, atol=1e-14)
SET_2 = SpragSlip()
SOFT = SpragSlip.set_1(cth=0.5)
SETS = {"set 1": SpragSlip.set_1(cth=5.0), "set 1, cth = 0.5": SOFT, "set 2": SET_2}


@functools.cache
def steady(name):
    """Steady sliding of a set: matrices (1, 1) of its small motions, and the equilibrium."""
    return ns.linearise(SETS[name])


@functools.cache
def curves():
    """Curves between the regions of set 2 in the plane of th and th', through the angles of the table."""
    th = np.array([0.70, 0.73, 0.75, 0.78, 0.80, 0.83])
    return ns.paradox_boundaries(SET_2, th=th, thdot=np.linspace(-7.0, 5.0, 81))


def on_curve(which, th):
    """th' on a curve at a line of its grid, in increasing order."""
    return sorted({round(y, 12) for line in getattr(curves(), which) for x, y in line if abs(x - th) < 1e-12})


def solutions(th, thdot, rod=SET_2):
    """Normal forces of a state, in increasing order [N]."""
    return sorted(one.la_N[0] for one in ns.classify(rod, state={"th": th, "thdot": thdot}).solutions)


@functools.cache
def after(t, th, thdot, rod=SET_2):
    """(th, th') of the rigid contact at a time."""
    sol = ns.simulate(rod, (0, t), *rod.state(th=th, thdot=thdot), integrator=FINE)
    return sol.q[-1, 1], sol.u[-1, 1]


@functools.cache
def cycle():
    """The limit cycle of set 1 with cth = 0.5."""
    return ns.limit_cycle(SOFT, SOFT.state(th=0.78, thdot=0.0), duration=6.0, dt=1e-4)


@functools.cache
def late_cycle():
    """The same by events: a run, and the time of a greatest angle from which a period follows."""
    sol = ns.simulate(SOFT, (0, 8), *SOFT.state(th=0.8, thdot=0.0), integrator=FINE, events=lambda t, q, u: u[1])
    return sol, sol.t_events[0][sol.q_events[0][:, 1] > 0.85][-2]


def sticks():
    """Times from the greatest angle, and angles, at which stick begins and ends."""
    sol, start = late_cycle()
    t = [event.t for event in sol.events if event.t > start][:2]
    return [*(np.array(t) - start), *sol(t).q[:, 1]]


def zeros_of_force():
    """Times from the greatest angle, and angles, at which the normal force is zero."""
    sol, start = late_cycle()
    at = (sol.t > start) & (sol.t < start + cycle().period) & (np.abs(sol.la[:, 0, 0]) < 1e-9)
    at &= np.diff(sol.t, prepend=0.0) > 0
    return [*(sol.t[at] - start), *sol.q[at, 1]]


def range_of_force():
    """Least and greatest normal force in a period [N]."""
    sol, start = late_cycle()
    la_N = sol.la[(sol.t > start) & (sol.t < start + cycle().period), 0, 0]
    return la_N.min(), la_N.max()


@functools.cache
def orbit():
    """The run of set 2 to its orbit of seizures, and the last two seizures."""
    sol = ns.simulate(SET_2, (0, 8), *SET_2.state(th=0.8, thdot=0.0), integrator=FINE)
    return sol, *[paradox for paradox in sol.paradoxes if paradox.kind == ns.EventKind.INCONSISTENT][-2:]


def orbit_at(side):
    """(th, th') just before ("left") or after ("right") the last seizure."""
    sol, _, last = orbit()
    state = sol(last.t, side=side)
    return state.q[1], state.u[1]


def release():
    """Time from the seizure, and angle, at which the tip leaves the belt."""
    sol, first, _ = orbit()
    t = next(event.t for event in sol.events if event.t > first.t and event.mode_before == ns.ContactMode.STICK)
    return t - first.t, sol(t).q[1]


def extremes_of_orbit():
    """Greatest th and least th' between two seizures."""
    sol, first, last = orbit()
    q, u = sol(np.linspace(first.t, last.t, 20001))
    return q[:, 1].max(), u[:, 1].min()


def seizure():
    """The impact without collision of the state (0.78, 1)."""
    (impact,) = ns.classify(SET_2, state={"th": 0.78, "thdot": 1.0}).impacts
    return impact


@functools.cache
def compliant(kappa, th, thdot, t, rtol=1e-10):
    """The contact as a spring and a damper of the same number kappa, without force at the start."""
    integrator = ns.Penalty(stiffness=kappa, damping=kappa, rtol=rtol, atol=1e-2 * rtol)
    return ns.simulate(SET_2, (0, t), *SET_2.state(th=th, thdot=thdot), integrator=integrator, t_eval=[0.0, t])


@functools.cache
def seized(kappa):
    """From (0.78, 1) to where the tip stops sliding: the time, th' less that of the impact, the force."""
    integrator = ns.Penalty(stiffness=kappa, damping=kappa, rtol=1e-10, atol=1e-12)
    sol = ns.simulate(SET_2, (0, 100 / kappa), *SET_2.state(th=0.78, thdot=1.0), integrator=integrator)
    t = next(event.t for event in sol.events if event.mode_after == ns.ContactMode.STICK)
    row = np.flatnonzero(sol.t == t)[0]
    return t, sol.u[row, 1] - seizure().u[1], sol.la[row, 0, 0]


def driving_screw(mu):
    """Number of forces of a screw that its load drives."""
    return ns.classify(LeadScrew(mu=mu), state={"th": 0.0, "thdot": 1.0}).n_solutions


STEADY = {  # th, M+, C+, K+, N
    "set 1": "0.828053558508 0.489459549014 1.489459549 675.731326054 37.830818394",
    "set 1, cth = 0.5": "0.828053558508 0.489459549014 -3.010540451 675.731326054 37.830818394",
    "set 2": "0.849626709900 -6.434826150 4.782586925 641.360025451 38.551699381",
}
CURVES = {0.73: "2.99908692 -5.90440381 3.66956101", 0.75: "2.93410545 -5.16977147 3.02291917",
          0.78: "2.84381989 -3.91369798 1.89198792", 0.80: "2.78801564 -2.81053350 0.86810430"}  # fmt: skip
RIGID = {
    (0.60, 0.0): "1.186249428 -1.143968348", (0.85, 0.0): "1.156378253 -1.522946610",
    (0.90, 2.0): "0.819553913 2.736571747", (0.80, 3.5): "0.949267286 -2.249010944",
    (1.00, 4.0): "0.847841624 2.667185293", (0.78, 1.0): "0.965195612 -2.235129844",
    (0.73, 3.3): "1.002287299 -2.187982995",
}  # fmt: skip
COMPLIANT = {
    (0.60, 0.0): "1.186246473 -1.144009893", (0.85, 0.0): "1.156443135 -1.522310527",
    (0.90, 2.0): "0.819395022 2.736977924", (0.80, 3.5): "0.949257312 -2.249010399",
    (1.00, 4.0): "0.847675162 2.667577120", (0.78, 1.0): "0.965232398 -2.235085643",
    (0.73, 3.3): "1.002262544 -2.188013998",
}  # fmt: skip
SEIZURES = {1e4: "1.634599e-3 -5.93e-3 2.9730e4", 1e5: "2.21393e-4 -7.66e-4 2.9337e5",
            1e6: "2.7867e-5 -9.32e-5 2.92795e6", 1e7: "3.358e-6 -1.10e-5 2.92719e7"}  # fmt: skip
BRANCHES = {(0.85, 0.0): "-4.315375307 38.80895774", (0.90, 2.0): "-13.7744419 90.89698531",
            (0.73, 3.3): "-169.1341771 1.416322438"}  # fmt: skip

SECTIONS = (
    Section(
        "sprag-slip",
        "The sprag-slip rod: steady sliding and regions",
        "Corrected table G. The chapter also uses v_t in two senses, introduces the condition of a paradox with "
        "N v_t < 0 (it is > 0), takes the origin for an equilibrium of the second system of its pair, and gives the "
        "damping c_theta in N/(m/s).",
        (
            *(
                Row(f"th of steady sliding, {name} [rad]", line.split()[0],
                    lambda name=name: steady(name).equilibrium.q[1])
                for name, line in STEADY.items()
            ),
            *(
                Row(f"M+, {name} [kg m^2]", line.split()[1], lambda name=name: steady(name).M[0, 0])
                for name, line in STEADY.items()
            ),
            *(
                Row(f"C+, {name} [N m s/rad]", line.split()[2], lambda name=name: steady(name).C[0, 0])
                for name, line in STEADY.items()
            ),
            *(
                Row(f"K+, {name} [N m/rad]", line.split()[3], lambda name=name: steady(name).K[0, 0])
                for name, line in STEADY.items()
            ),
            *(
                Row(f"N, {name} [N]", line.split()[4], lambda name=name: steady(name).equilibrium.la_N[0])
                for name, line in STEADY.items()
            ),
            Row("growth rate, set 1 [1/s]", "-1.521534877", lambda: steady("set 1").dominant.real),
            Row("frequency, set 1 [rad/s]", "37.124805254", lambda: abs(steady("set 1").dominant.imag)),
            Row("growth rate, cth = 0.5 [1/s]", "3.075372068", lambda: steady("set 1, cth = 0.5").dominant.real),
            Row("frequency, cth = 0.5 [rad/s]", "37.028479852",
                lambda: abs(steady("set 1, cth = 0.5").dominant.imag)),
            Row("first eigenvalue, set 2 [1/s]", "10.362024806", lambda: max(steady("set 2").eigenvalues.real)),
            Row("second one [1/s]", "-9.618789976", lambda: min(steady("set 2").eigenvalues.real)),
            Row("critical friction at th of set 1", "1.239300",
                lambda: ns.critical_friction(SETS["set 1"], steady("set 1").equilibrium.q)),
            Row(
                "critical friction at th of set 2",
                lambda: (1 / math.tan(0.8496267099)) * (1 + 4 / (50 * math.sin(0.8496267099) * math.cos(0.8496267099))),
                lambda: ns.critical_friction(SET_2, steady("set 2").equilibrium.q), corrected="1.040469",
                errs="the chapter multiplies I by a cot th too many",
            ),
            Row("least th with M+ < 0, set 2 [rad]", "0.720658419", lambda: curves().p[0][0, 0]),
            Row("v_t = 0 meets N = 0, th [rad]", "0.752865415", lambda: curves().crossings["b", "gamma_F"][0, 0]),
            Row("th' there [rad/s]", "2.925120353", lambda: curves().crossings["b", "gamma_F"][0, 1]),
            *(
                Row(f"th' on v_t = 0, th = {th} [rad/s]", line.split()[0], lambda th=th: on_curve("gamma_F", th)[0])
                for th, line in CURVES.items()
            ),
            *(
                Row(f"{end} th' on N = 0, th = {th} [rad/s]", line.split()[k + 1],
                    lambda th=th, k=k: on_curve("b", th)[k])
                for th, line in CURVES.items() for k, end in enumerate(("least", "largest"))
            ),
            *(
                Row(f"force {k + 1} in ({th}, {thdot}) [N]", printed,
                    lambda th=th, thdot=thdot, k=k: solutions(th, thdot)[k])
                for (th, thdot), line in BRANCHES.items() for k, printed in enumerate(line.split())
            ),
            *(
                Row(f"solutions in {region}, ({th}, {thdot})", printed,
                    lambda th=th, thdot=thdot: len(solutions(th, thdot)))
                for region, th, thdot, printed in (("A0", 0.6, 0.0, "1"), ("A1", 0.85, 0.0, "2"), ("A2", 0.8, 3.5, "0"),
                                                   ("A3", 0.78, 1.0, "0"), ("A4", 0.73, 3.3, "2"))
            ),
        ),
        (steady, curves, on_curve, solutions),
    ),
    Section(
        "sprag-slip-cycle",
        "The sprag-slip rod: its limit cycle",
        "Set 1. With cth = 5 the motion returns to steady sliding from 0.05 rad below; with "
        "cth = 0.5 it is attracted to a cycle with one stick phase. Times are counted from the greatest angle.",
        (
            Row("th after 0.1 s, cth = 5 [rad]", "0.84797101",
                lambda: after(0.1, steady("set 1").equilibrium.q[1] - 0.05, 0.0, SETS["set 1"])[0]),
            Row("th' after 0.1 s [rad/s]", "0.70989253",
                lambda: after(0.1, steady("set 1").equilibrium.q[1] - 0.05, 0.0, SETS["set 1"])[1]),
            Row("th after 1 s [rad]", "0.81310806",
                lambda: after(1.0, steady("set 1").equilibrium.q[1] - 0.05, 0.0, SETS["set 1"])[0]),
            Row("th' after 1 s [rad/s]", "-0.15110466",
                lambda: after(1.0, steady("set 1").equilibrium.q[1] - 0.05, 0.0, SETS["set 1"])[1]),
            Row("period, cth = 0.5 [s]", "0.377442788", lambda: cycle().period),
            Row("greatest th [rad]", "0.899886645", lambda: cycle().extremes[1][1]),
            Row("least th [rad]", "0.7532243", lambda: cycle().extremes[0][1]),
            Row("least th' [rad/s]", "-1.338581", lambda: cycle().extremes[0][3]),
            Row("largest th' [rad/s]", "1.389914", lambda: cycle().extremes[1][3]),
            Row("time of stick [s]", "0.016087590", lambda: cycle().stick_duration),
            Row("stick begins [s]", "0.259262266", lambda: sticks()[0]),
            Row("th where it begins [rad]", "0.803037060", lambda: sticks()[2]),
            Row("th where it ends [rad]", "0.825162958", lambda: sticks()[3]),
            Row("N = 0 first [s]", "0.108644837", lambda: zeros_of_force()[0]),
            Row("N = 0 again [s]", "0.279364694", lambda: zeros_of_force()[1]),
            Row("th at the first [rad]", "0.820830335", lambda: zeros_of_force()[2]),
            Row("th at the second [rad]", "0.830592534", lambda: zeros_of_force()[3]),
            Row("least N [N]", "-6.5777", lambda: range_of_force()[0]),
            Row("largest N [N]", "116.97", lambda: range_of_force()[1]),
            Row(
                "solutions where the cycle turns, th = 0.899886645 rad", "1",
                lambda: len(solutions(cycle().extremes[1][1], 0.0, SOFT)), corrected="2",
                errs="the chapter says that no paradox occurs in set 1: true of steady sliding only",
            ),
        ),
        (after, cycle, late_cycle, sticks, zeros_of_force, range_of_force),
        table="G",
    ),
    Section(
        "seizure",
        "The sprag-slip rod: seizures",
        "Set 2: where no force exists the belt seizes the tip. The rigid limit.",
        (
            Row("period of the orbit [s]", "0.460134276", lambda: orbit()[2].t - orbit()[1].t),
            Row("normal impulse of the seizure [N s]", "34.772865558", lambda: orbit()[2].P_N),
            Row("friction impulse [N s]", "38.865743710", lambda: orbit()[2].P_F),
            Row("th of the seizure [rad]", "0.807078634", lambda: orbit_at("left")[0]),
            Row("th' before it [rad/s]", "-2.258755703", lambda: orbit_at("left")[1]),
            Row("th' after it [rad/s]", "2.769048317", lambda: orbit_at("right")[1]),
            Row("time of stick [s]", "0.061700499", lambda: release()[0]),
            Row("th where it ends [rad]", "0.966466904", lambda: release()[1]),
            Row("greatest th [rad]", "1.215713", lambda: extremes_of_orbit()[0]),
            Row("least th' [rad/s]", "-2.275685", lambda: extremes_of_orbit()[1]),
            Row("total impulse from (0.78, 1) [N s]", "13.107965209",
                lambda: seizure().P_N[0]),
            Row("th' after it [rad/s]", "2.843819889",
                lambda: seizure().u[1]),
            *(
                Row(f"{name} after 0.4 s from {start}", printed, lambda start=start, k=k: after(0.4, *start)[k])
                for start, line in RIGID.items()
                for k, (name, printed) in enumerate(zip(("th [rad]", "th' [rad/s]"), line.split(), strict=True))
            ),
        ),
        (orbit, orbit_at, release, extremes_of_orbit, seizure, after),
        table="H",
    ),
    Section(
        "compliant",
        "The sprag-slip rod on a compliant contact",
        "Set 2: stiffness kappa [N/m] and damping kappa [N s/m], 1e6 where no other is named.",
        (
            *(
                Row(f"{name} after 0.4 s from {start}", printed,
                    lambda start=start, which=which: getattr(compliant(1e6, *start, 0.4), which)[-1, 1])
                for start, line in COMPLIANT.items()
                for (name, which), printed in zip((("th [rad]", "q"), ("th' [rad/s]", "u")), line.split(), strict=True)
            ),
            *(
                Row(f"time until the tip sticks, kappa = {kappa:g} [s]", line.split()[0],
                    lambda kappa=kappa: seized(kappa)[0])
                for kappa, line in SEIZURES.items()
            ),
            *(
                Row(f"th' there less the limit's, kappa = {kappa:g} [rad/s]", line.split()[1],
                    lambda kappa=kappa: seized(kappa)[1])
                for kappa, line in SEIZURES.items()
            ),
            *(
                Row(f"N there, kappa = {kappa:g} [N]", line.split()[2],
                    lambda kappa=kappa: seized(kappa)[2])
                for kappa, line in SEIZURES.items()
            ),
        ),
        (compliant, seized),
        table="H",
    ),
    Section(
        "screw",
        "The lead screw",
        "With rigid threads: I = 3.12e-6 kg m^2, r = 5.18 mm, lead angle 5.57 degrees, m = 10 kg.",
        (
            Row("critical friction", "0.219303854",
                lambda: ns.critical_friction(LeadScrew(), LeadScrew().state()[0])),
            Row("friction of self-locking, tan lambda", "0.097522252", lambda: math.tan(LeadScrew().lam)),
            Row("Gamma(-mu), mu = 0.2 [kg m^2]", "4.8971e-7", lambda: LeadScrew(mu=0.2).Gamma(-1)),
            Row("Gamma(-mu), mu = 0.25 [kg m^2]", "-7.7501e-7", lambda: LeadScrew(mu=0.25).Gamma(-1)),
            Row("solutions, mu = 0.2", "1", lambda: driving_screw(0.2)),
            Row("solutions, mu = 0.25", "2", lambda: driving_screw(0.25)),
        ),
        (driving_screw,),
        table="I",
    ),
)  # fmt: skip
