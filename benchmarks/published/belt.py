"""The mass on a conveyor: negative damping, averaging, stick-slip cycles."""

from __future__ import annotations

import functools
import math

from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import nonsmooth as ns
from benchmarks.published.rows import Row, Section
from models import BeltOscillator

LENGTH = 0.1  # N/k of the belt [m], the unit of printed amplitudes


@functools.cache
def stick_slip(vb):
    """The cycle at a speed of the belt; y is counted from steady sliding."""
    belt = BeltOscillator(vb=vb)
    cycle = ns.limit_cycle(belt, belt.state(x=belt.equilibrium() + vb / 4), duration=60.0)
    slip, stick = sorted(cycle.phases, key=lambda phase: phase.sticks)
    low, high = (end - [belt.equilibrium(), 0.0] for end in cycle.extremes)
    return {
        "period": cycle.period,
        "stick": cycle.stick_duration,
        "half peak to peak": cycle.amplitudes[0],
        "y max": high[0],
        "y min": low[0],
        "y' min": low[1],
        "y stick begins": stick.q[0] - belt.equilibrium(),
        "y stick ends": slip.q[0] - belt.equilibrium(),
    }


@functools.cache
def weak_cycle(vb, **law):
    """A cycle near the averaged one, from which it starts."""
    belt = BeltOscillator(vb=vb, **law)
    amplitude = ns.averaged_amplitude(belt).amplitude
    start = belt.state(x=belt.equilibrium() + amplitude)
    return ns.limit_cycle(belt, ns.simulate(belt, (0, 200), *start, integrator=ns.MoreauJean(dt=1e-3)))


@functools.cache
def smoothed_cycle(vb, r):
    """The cycle of the smoothed law from a start far from it; a weak one from the averaged amplitude."""
    if vb > 0.43:
        return weak_cycle(vb, law="smoothed", r=r)
    belt = BeltOscillator(law="smoothed", r=r, vb=vb)
    return ns.limit_cycle(belt, belt.state(x=belt.equilibrium() + vb / 4), duration=60.0)


def averaged(vb, **law):
    """Averaged amplitude in units of N/k."""
    return ns.averaged_amplitude(BeltOscillator(vb=vb, **law)).amplitude / LENGTH


def speed_of_instability(bracket, **law):
    """Belt speed in the bracket at which steady sliding loses its stability."""
    return ns.flutter_boundary(BeltOscillator(**law), "vb", bracket).value


def end_of_stick():
    """Belt speed from which on the cycle slips throughout."""
    belt = BeltOscillator(vb=0.39)
    cycle = ns.limit_cycle(belt, belt.state(x=0.1), duration=60.0)
    return ns.continue_cycle(BeltOscillator(), "vb", [0.39, 0.398], cycle).changes[0].value


def touching_speed():
    """The same by SciPy alone: the cycle of the law without its sign, whose greatest velocity is the belt's."""

    def excess(vb):
        def rate(t, y):
            v = vb - y[1]
            return y[1], -0.1 * y[1] - 10 * y[0] + 0.4 - 0.45 * v + 0.6 * v**3

        def fastest(t, y):
            return rate(t, y)[1]

        def turn(t, y):
            return y[1] if t > 0.5 else -1.0

        def period(x):
            events = (turn, fastest)
            return solve_ivp(rate, (0, 3), (x, 0.0), "DOP853", events=events, rtol=1e-12, atol=1e-14, max_step=0.2)

        turn.direction, turn.terminal = -1, True
        rest = (0.4 - 0.45 * vb + 0.6 * vb**3) / 10
        start = brentq(lambda x: period(x).y_events[0][0][0] - x, rest + 0.08, rest + 0.16, xtol=1e-13)
        return max(y[1] for y in period(start).y_events[1]) - vb

    return brentq(excess, 0.394, 0.395, xtol=1e-11)


def growth_of_averaged_motion(vb):
    """a'/a at a = 0."""
    return ns.averaged_amplitude(BeltOscillator(vb=vb)).rate(1e-6) / 1e-6


def slope_of_friction(vb, r):
    """dmu/dv of the smoothed law, from the damping of small motions c + N dmu/dv."""
    belt = BeltOscillator(law="smoothed", r=r, vb=vb)
    return (ns.linearise(belt).C[0, 0] - belt.c) / belt.N


STICK_SLIP = {  # a line of the table for each speed of the belt [m/s]
    0.05: "2.042809386 0.303681193 0.018770409 0.017189662 -0.020351156 -0.059318283 -0.013441560 0.0017425",
    0.10: "2.037780395 0.292866358 0.037176962 0.034336553 -0.040017371 -0.117505656 -0.025846636 0.0034400",
    0.20: "2.020348258 0.250147633 0.071634355 0.068330977 -0.074937734 -0.226506509 -0.043509527 0.0065200",
    0.30: "1.999912298 0.176927619 0.101503869 0.101641330 -0.101366407 -0.320936464 -0.044198286 0.0088800",
    0.35: "1.992112980 0.121269023 0.114445695 0.117933223 -0.110958167 -0.361702872 -0.032766658 0.0096775",
    0.39: "1.989427764 0.038706254 0.123824814 0.130753458 -0.116896169 -0.391108761 -0.005004579 0.0100909",
}
COLUMNS = {
    "period": "s", "stick": "s", "half peak to peak": "m", "y max": "m", "y min": "m", "y' min": "m/s",
    "y stick begins": "m", "y stick ends": "m",
}  # fmt: skip
PURE_SLIP = {0.40: "0.1173788 0.1176282 1.9893366", 0.42: "0.0849575 0.0850607 1.9882990",
             0.44: "0.0183787 0.0183799 1.9869879"}  # fmt: skip
SMOOTHED_20 = {0.20: "0.369234 0.369972", 0.25: "0.590843 0.592365", 0.30: "0.752423 0.753587",
               0.35: "0.856938 0.857276", 0.40: "0.828605 0.828973", 0.44: "0.078412 0.078413"}  # fmt: skip
SMOOTHED_200 = {
    0.05: "0.125493 0.128988", 0.10: "0.303254 0.322441", 0.20: "0.633105 0.675981", 0.25: "0.793187 0.835153",
    0.30: "0.949947 0.981028", 0.35: "1.100838 1.113017", 0.40: "1.171261 1.173479", 0.44: "0.183787 0.183799",
}  # fmt: skip

SECTIONS = (
    Section(
        "belt",
        "A mass on a conveyor",
        "Friction that falls with the speed, mu(v) = 0.4 - 0.45 v + 0.6 v^3; m = 1 kg, k = 10 N/m, "
        "c = 0.1 N s/m, N = 1 N. The chapter also prints the condition of sticking without its absolute value, and a "
        "power of a too many in the general coefficient of the averaged equation.",
        (
            Row("largest unstable belt speed [m/s]", "0.440958552", lambda: speed_of_instability((0.3, 0.6))),
            Row("least one for averaging without stick [m/s]", "0.394405319", lambda: BeltOscillator().vb_min()),
            Row(
                "exact limit of pure slip [m/s]", "0.39433258", lambda: end_of_stick(), is_slow=True,
                corrected=lambda: touching_speed(),
                errs="the corrected table: there the cycle without stick would overtake the belt",
            ),  # fmt: skip
            Row(
                "growth of the averaged motion at a = 0, vb = 0.42 m/s [1/s]",
                lambda: -(-0.1 + (-0.45 + 3 * 0.6 * 0.42**2)) / 2,
                lambda: growth_of_averaged_motion(0.42),
                corrected=lambda: -(0.1 + (-0.45 + 3 * 0.6 * 0.42**2)) / 2,
                errs="the chapter, -(-c + N d)/(2 m); d is the slope of mu",
            ),
            Row(
                "slope of the smoothed law, r = 20, v = 0.3 m/s [s/m]",
                lambda: -(20 * 0.4 * math.exp(-20 * 0.3) - 0.45 + 3 * 0.6 * 0.3**2),
                lambda: slope_of_friction(0.3, r=20.0),
                corrected=lambda: 20 * 0.4 * math.exp(-20 * 0.3) - 0.45 + 3 * 0.6 * 0.3**2,
                errs="the chapter, by the sign",
            ),
            *(
                Row(f"averaged amplitude, vb = {vb} m/s [m]", line.split()[0], lambda vb=vb: averaged(vb) * LENGTH)
                for vb, line in PURE_SLIP.items()
            ),
            *(
                Row(f"exact one, vb = {vb} m/s [m]", line.split()[1], lambda vb=vb: weak_cycle(vb).amplitudes[0])
                for vb, line in PURE_SLIP.items()
            ),
            *(
                Row(f"its period, vb = {vb} m/s [s]", line.split()[2], lambda vb=vb: weak_cycle(vb).period)
                for vb, line in PURE_SLIP.items()
            ),
        ),
        (speed_of_instability, end_of_stick, touching_speed, averaged, weak_cycle, growth_of_averaged_motion,
         slope_of_friction),
        table="A",
    ),
    Section(
        "stick-slip",
        "Stick-slip cycles on the conveyor",
        "The discontinuous law: one slip and one stick phase in each period.",
        tuple(
            Row(f"{name}, vb = {vb} m/s [{unit}]", printed, lambda vb=vb, name=name: stick_slip(vb)[name])
            for vb, line in STICK_SLIP.items()
            for (name, unit), printed in zip(COLUMNS.items(), line.split(), strict=True)
        ),
        (stick_slip,),
        table="A",
    ),
    Section(
        "smoothed",
        "The conveyor with smoothed friction",
        "The law times 1 - exp(-r v), r in s/m; amplitudes, half peak to peak, in units of N/k. For "
        "r = 200 averaging is up to 7 % off, as the table says: quasi-stick distorts the motion.",
        (
            Row("least unstable speed, r = 20 [m/s]", "0.163896782",
                lambda: speed_of_instability((0.05, 0.3), law="smoothed", r=20.0)),
            Row("largest one [m/s]", "0.440201331",
                lambda: speed_of_instability((0.3, 0.6), law="smoothed", r=20.0)),
            Row("least unstable speed, r = 200 [m/s]", "0.027178274",
                lambda: speed_of_instability((0.01, 0.1), law="smoothed", r=200.0)),
            Row("largest one [m/s]", "0.440958552",
                lambda: speed_of_instability((0.3, 0.6), law="smoothed", r=200.0)),
            *(
                Row(f"averaged, r = {r}, vb = {vb} m/s", line.split()[0],
                    lambda vb=vb, r=r: averaged(vb, law="smoothed", r=r), is_slow=r > 100)
                for r, lines in ((20.0, SMOOTHED_20), (200.0, SMOOTHED_200)) for vb, line in lines.items()
            ),
            *(
                Row(f"exact, r = {r}, vb = {vb} m/s", line.split()[1],
                    lambda vb=vb, r=r: smoothed_cycle(vb, r).amplitudes[0] / LENGTH, is_slow=r > 100)
                for r, lines in ((20.0, SMOOTHED_20), (200.0, SMOOTHED_200)) for vb, line in lines.items()
            ),
        ),
        (averaged, smoothed_cycle),
        table="A",
    ),
)  # fmt: skip
