"""``nonsmooth bench core``: nanoseconds a step, beside the same step written in C.

The scene is a sliding rod (three coordinates, one frictional contact). The C program takes the same step with all
known to the compiler: mid-point, rows at the mid-point and at the end, Delassus matrix, closed form of the contact. It
is the floor, not a rival: it books no energy, keeps no modes and asks for no second solution. Medians of interleaved
repeats; where there is no C compiler the column is left out.
"""

from __future__ import annotations

import math
import platform
import shutil
import statistics
import subprocess
import tempfile
import time
from pathlib import Path
from typing import Any, NamedTuple

REPEATS = 7
STEPS = 300_000
SPAN = 0.3  # s


class P(NamedTuple):
    m: float = 1.0  # mass [kg]
    l: float = 2.0  # length [m]
    I: float = 1 / 3  # central inertia [kg m^2]
    g: float = 9.81  # gravity [m/s^2]
    mu: float = 0.5  # friction coefficient


def mass(t, q, p, M):
    M[0, 0] = p.m
    M[1, 1] = p.m
    M[2, 2] = p.I


def force(t, q, u, p, h):
    h[1] = -p.m * p.g


def gap(t, q, p, g_N):
    g_N[0] = q[1] - p.l / 2 * math.sin(q[2])


def normal(t, q, p, W_N):
    W_N[0, 1] = 1.0
    W_N[0, 2] = -p.l / 2 * math.cos(q[2])


def tangent(t, q, p, W_F):
    W_F[0, 0, 0] = 1.0
    W_F[0, 0, 2] = p.l / 2 * math.sin(q[2])


C_SOURCE = r"""
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>
int main(int argc, char **argv) {
    long n = atol(argv[1]);
    double dt = 0.3 / n, m = 1, s = 1, I = 1.0 / 3, g = 9.81, mu = 0.5;
    double th0 = acos(-1.0) / 3, q[3] = {0, sin(th0), th0}, u[3] = {1, 0, 0};
    struct timespec a, b;
    clock_gettime(CLOCK_MONOTONIC, &a);
    for (long k = 0; k < n; k++) {
        double x = q[0] + dt / 2 * u[0], y = q[1] + dt / 2 * u[1], th = q[2] + dt / 2 * u[2], e = q[2] + dt * u[2];
        double gN = y - s * sin(th), f[3] = {u[0], u[1] - g * dt, u[2]};
        double N2 = -s * cos(th), T2 = s * sin(th), dN = -s * cos(e) - N2, dT = s * sin(e) - T2;
        double GNN = 1 / m + N2 * N2 / I, GTT = 1 / m + T2 * T2 / I, GNT = N2 * T2 / I;
        double cN = f[1] + N2 * f[2] + dN * u[2] + (gN > 0 ? gN / dt : 0), cT = f[0] + T2 * f[2] + dT * u[2];
        double PN = 0, PT = 0;
        if (cN < 0) {
            double det = GNN * GTT - GNT * GNT;
            PN = (GNT * cT - GTT * cN) / det;
            PT = (GNT * cN - GNN * cT) / det;
            if (!(PN >= 0 && fabs(PT) <= mu * PN)) {
                double sign = cT - GNT * cN / GNN > 0 ? 1 : -1;
                PN = -cN / (GNN - sign * mu * GNT);
                PT = -sign * mu * PN;
            }
        }
        double v[3] = {f[0] + PT / m, f[1] + PN / m, f[2] + (N2 * PN + T2 * PT) / I};
        for (int i = 0; i < 3; i++) { q[i] += dt / 2 * (u[i] + v[i]); u[i] = v[i]; }
        (void)x;
    }
    clock_gettime(CLOCK_MONOTONIC, &b);
    printf("%.17g %.17g\n", ((b.tv_sec - a.tv_sec) * 1e9 + (b.tv_nsec - a.tv_nsec)) / n, q[2]);
    return 0;
}
"""


def main(argv: list[str] | None = None) -> int:
    """Print the table; returns the exit code."""
    with tempfile.TemporaryDirectory() as folder:
        program = compile_c(Path(folder))
        run_rod(STEPS)  # compile, or load
        ours, theirs = [], []
        for _ in range(REPEATS):
            time_ours, th = run_rod(STEPS)
            ours.append(time_ours)
            if program:
                time_c, th_c = run_c(program, STEPS)
                theirs.append(time_c)
                if abs(th - th_c) > 1e-9:
                    raise AssertionError(f"the two programs disagree: th = {th!r} and {th_c!r}")
    print(f"{platform.platform()}, Python {platform.python_version()}, {STEPS} steps, median of {REPEATS}")
    print(f"rod, this package       {statistics.median(ours):8.1f} ns a step")
    if theirs:
        ratio = statistics.median(a / b for a, b in zip(ours, theirs, strict=True))
        print(f"rod, hard-coded in C    {statistics.median(theirs):8.1f} ns a step; ratio {ratio:.2f}")
    else:
        print("no C compiler (cc or gcc) was found: nothing to compare with")
    print(f"one simulate call       {call_overhead() * 1e6:8.1f} us (one step)")
    return 0


def rod() -> Any:
    from nonsmooth.system import Contact, System

    return System(n_q=3, mass=mass, force=force, gap=gap, normal=normal, tangent=tangent,
                  contacts=[Contact(mu="mu")], parameters=P(), name="rod")  # fmt: skip


def run_rod(steps: int) -> tuple[float, float]:
    """Nanoseconds a step of this package, and the final angle."""
    from nonsmooth.integrators.moreau_jean import MoreauJean
    from nonsmooth.simulate import simulate

    th = math.pi / 3
    solution = simulate(
        rod(), (0, SPAN), [0, math.sin(th), th], [1, 0, 0], integrator=MoreauJean(dt=SPAN / steps), every=steps
    )
    return solution.stats.wall_time / steps * 1e9, float(solution.q[-1, 2])


def compile_c(folder: Path) -> Path | None:
    """The C program, if the system has a compiler."""
    compiler = shutil.which("cc") or shutil.which("gcc")
    if compiler is None:
        return None
    source, program = folder / "rod.c", folder / "rod"
    source.write_text(C_SOURCE)
    subprocess.run([compiler, "-O2", str(source), "-o", str(program), "-lm"], check=True)
    return program


def run_c(program: Path, steps: int) -> tuple[float, float]:
    """Nanoseconds a step of the C program, and the final angle."""
    printed = subprocess.run([str(program), str(steps)], capture_output=True, text=True, check=True).stdout
    nanoseconds, th = map(float, printed.split())
    return nanoseconds, th


def call_overhead() -> float:
    """Seconds of a `simulate` call that takes one step, median."""
    from nonsmooth.integrators.moreau_jean import MoreauJean
    from nonsmooth.simulate import simulate

    system, integrator, th = rod(), MoreauJean(dt=1e-3), math.pi / 3
    times = []
    for _ in range(100):
        started = time.perf_counter()
        simulate(system, (0, 1e-3), [0, math.sin(th), th], [1, 0, 0], integrator=integrator)
        times.append(time.perf_counter() - started)
    return statistics.median(times)
