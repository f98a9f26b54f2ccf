"""``python -m benchmarks space [FILE] [NAME ...]``: run time against error of six motions with friction in space.

A block thrown on a conveyor, two balls that slide and then roll, a tippe-top and a rod that slides on its tip, as a
system of one contact (of eight: the block), as a scene of bodies, and in MuJoCo where it is installed; a rod with a
point for a tip, which no body has, as a system. Methods and settings take turns ROUNDS times; printed are medians of
the processor time of whole runs of ours, and of MuJoCo's steps alone, and the distance of the centre of mass from
where it should be at the end. FILE is that of the picture.
"""

from __future__ import annotations

import math
import os
import platform
import statistics
import sys
import time
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from scipy.integrate import solve_ivp

import nonsmooth as ns
from benchmarks.exact_scenes import ground
from benchmarks.peers import imports
from benchmarks.precision import STEPS, TOLERANCES, draw, mujoco
from benchmarks.precision_scenes import G, ends
from models import BilliardBall, SpatialPainleveRod, SpinningTop
from nonsmooth.mechanics.system import FORCE, KINEMATICS, MASS, NORMAL, ROW_RATES, TANGENT

ROUNDS = 5  # chosen
LONGEST = 0.5  # s, chosen: a method that took longer is not asked for a smaller error
ERRORS = 1e-4, 1e-6  # m, of the table
State = tuple[np.ndarray, np.ndarray]


class Motion(NamedTuple):
    """A motion as a system and as a scene, how long it goes on [s], and where its centre of mass is then (3,) [m]."""

    scene: Callable[[], ns.Scene] | None
    t_end: float
    exact: Callable[[], np.ndarray]
    source: str  # of the exact place
    system: Any = None  # with its start; of the scene if left out
    start: State | None = None
    guided: Callable[[], ns.Scene] | None = None  # of MuJoCo, which has no running surfaces


BELT, THROWN, MU = np.array([1.0, 0.0]), np.array([-0.5, 1.2]), 0.3  # m/s; m/s; -


def block_on_belt(is_guided: bool = False) -> ns.Scene:
    """A block that is thrown obliquely on a belt that runs along x, or on a plate that is guided along it."""
    scene = ns.Scene(gravity=(0, 0, -G), material=ns.Material(mu=MU))
    if is_guided:
        scene.kinematic(ns.Box(20, 20, 0.2), position=(0, 0, -0.1), velocity=(*BELT, 0), name="belt")
    else:
        scene.fixed(ns.HalfSpace((0, 0, 1)), surface_velocity=(*BELT, 0), name="belt")
    scene.body(ns.Box(0.2, 0.2, 0.1), mass=1.0, position=(0, 0, 0.05), velocity=(*THROWN, 0))
    return scene


def carried_on(t: float) -> np.ndarray:
    """It slides straight on the belt until it stops there, and goes with it."""
    slip = THROWN - BELT
    speed = math.hypot(*slip)
    slid = min(t, speed / (MU * G))
    return np.array([*(BELT * t + slip * (slid - 0.5 * MU * G * slid**2 / speed)), 0.05])


def ball(**state: float) -> Motion:
    """A billiard ball that slides along its parabola, and rolls on along a line."""
    model = BilliardBall()
    q, u = model.state(**state)

    def scene() -> ns.Scene:
        made = ground(model.mu)
        made.body(ns.Sphere(model.R), mass=model.m, position=q[:3], velocity=u[:3], spin=u[3:])
        return made

    return Motion(scene, 1.0, lambda: np.array([*model.path(1.0, u), model.R]), "closed form", model, (q, u))


def top(model: SpinningTop, t_end: float, **state: float) -> Motion:
    """A body of revolution that slides on its tip all the time."""
    q, u = model.state(**state)

    def scene() -> ns.Scene:
        made = ground(model.mu)
        made.body(
            ns.Sphere(model.r), mass=model.m, inertia=(model.A, model.A, model.C), centre=(0, 0, model.h),
            position=q[:3] - model.h * model.axis(q), turn=q[3:], velocity=u[:3], spin=u[3:],
        )  # fmt: skip
        return made

    return Motion(scene, t_end, lambda: sliding(model, q, u, t_end)[0][:3], "SciPy, 1e-12", model, (q, u))


def sliding(model: Any, q: np.ndarray, u: np.ndarray, t_end: float) -> tuple[np.ndarray, float]:
    """(q, u) at the end of M u' = h + (W_N - mu W_F d) la_N, d the direction of sliding, and the least speed of it."""
    system, n = model.system(), q.size

    def rates(t: float, y: np.ndarray) -> np.ndarray:
        q, u = y[:n], y[n:]
        M, h, W_N, W_F, r = (system.evaluate(which, t, q, u) for which in (MASS, FORCE, NORMAL, TANGENT, ROW_RATES))
        B = np.eye(n) if system.kinematics is None else system.evaluate(KINEMATICS, t, q, u)
        slip = W_F[0] @ u
        pushed, free = np.linalg.solve(M, np.column_stack([W_N[0] - model.mu * slip @ W_F[0] / np.hypot(*slip), h])).T
        la_N = -(W_N[0] @ free + r[0, 0]) / (W_N[0] @ pushed)
        if la_N < 0:
            raise ArithmeticError("the tip lifts off")
        return np.concatenate([B @ u, free + pushed * la_N])

    y = solve_ivp(rates, (0, t_end), np.concatenate([q, u]), method="DOP853", rtol=1e-12, atol=1e-14).y.T
    slips = [np.hypot(*(system.evaluate(TANGENT, 0.0, x[:n], x[n:])[0] @ x[n:])) for x in y]
    return y[-1], min(slips)


def rod() -> SpinningTop:
    """A rod of 1 m and 1 kg whose lower end is a ball of 1 cm, with 1 % of its inertia about its axis."""
    return SpinningTop(m=1.0, A=1 / 12, C=1 / 1200, h=0.49, r=0.01, mu=0.3)


def on_a_point() -> Motion:
    """A slender rod on a point."""
    model, t_end = SpatialPainleveRod(mu=MU), 0.2
    q, u = model.state(th=1.0, phi=0.7, psidot=3.0, thdot=-1.0, slip=2.0)
    return Motion(None, t_end, lambda: sliding(model, q, u, t_end)[0][:3], "SciPy, 1e-12", model, (q, u))


def tippe_top() -> Motion:
    """A tippe-top spun about the vertical through its centre of mass, at rest; it turns over half of the way."""
    model, th, spin = SpinningTop.tippe_top(eccentricity=0.2), 0.3, 150.0  # rad; rad/s
    slip = -model.h * spin * math.sin(th)
    return top(model, 0.5, th=th, spin=spin * math.cos(th), precession=spin, slip_y=slip)


MOTIONS = {
    "block on a conveyor": Motion(
        block_on_belt, 1.0, lambda: carried_on(1.0), "closed form", guided=lambda: block_on_belt(True)
    ),
    "slip to roll": ball(speed=1.0, w_x=0.0, w_y=0.0),
    "billiard parabola": ball(speed=1.0, w_x=40.0, w_y=10.0),
    "tippe-top": tippe_top(),
    "rod in space": top(rod(), 0.2, th=0.5, thdot=1.0, precession=3.0, spin=0.0, slip_x=2.0, slip_y=1.0),
    "rod on a point": on_a_point(),
}  # fmt: skip


def main(words: list[str]) -> int:
    """Print both tables and write the picture."""
    picture = next((word for word in words if word.endswith((".png", ".svg", ".pdf"))), None)
    names = [word for word in words if word != picture]
    if unknown := [name for name in names if name not in MOTIONS]:
        print(f"there is no motion {unknown[0]!r}; known: {', '.join(MOTIONS)}", file=sys.stderr)
        return 2
    warnings.simplefilter("ignore")
    print(f"{platform.platform()}, Python {platform.python_version()}, load {os.getloadavg()[0]:.1f}\n")
    curves = {name: curves_of(MOTIONS[name]) for name in names or MOTIONS}
    print("| motion | method | " + " | ".join(f"ms to {error:.0e} m" for error in ERRORS) + " |\n|---|---|---|---|")
    for name, found in curves.items():
        for label, curve in found.items():
            print(f"| {name} | {label} | {' | '.join(reached(curve, error) for error in ERRORS)} |")
    print("\n| motion | method | setting | error [m] | ms |\n|---|---|---|---|---|")
    for name, found in curves.items():
        for label, curve in found.items():
            for setting, error, seconds in curve.T:
                print(f"| {name} | {label} | {setting:.3g} | {error:.2g} | {1e3 * seconds:.3g} |")
    if picture is not None:
        draw(curves, Path(picture))
    return 0


def curves_of(motion: Motion) -> dict[str, np.ndarray]:
    """Of each method its settings, errors and seconds (3, n): all methods and settings in turn, ROUNDS times."""
    exact, asked = motion.exact(), dict(methods(motion))
    for run, settings in asked.values():
        run(settings[0])  # compiled before it is timed
    seconds: dict[tuple[str, float], list[float]] = {}
    errors: dict[tuple[str, float], float] = {}
    for k in range(ROUNDS):
        for label, (run, settings) in asked.items():
            for setting in settings:
                key = label, setting
                if k > 0 and key not in errors:
                    break
                took, place = run(setting)
                seconds.setdefault(key, []).append(took)
                errors[key] = float(np.abs(place - exact).max())
                if k == 0 and took > LONGEST:
                    break
    return {
        label: np.array([
            (s, errors[label, s], statistics.median(seconds[label, s])) for s in settings if (label, s) in errors
        ]).T
        for label, (_, settings) in asked.items()
    }  # fmt: skip


def methods(motion: Motion) -> Iterator[tuple[str, tuple[Callable[[float], tuple[float, np.ndarray]], Any]]]:
    """Ours of the system and of the scene, and MuJoCo, each with its settings."""
    make = motion.scene
    system = motion.system or make().system()  # type: ignore[misc]
    start = motion.start or make().state()  # type: ignore[misc]

    def ours(integrator: Any) -> tuple[float, np.ndarray]:
        began = time.process_time()
        sol = ns.simulate(system, (0, motion.t_end), *start, integrator=integrator, every=10**9)
        return time.process_time() - began, sol.q[-1, :3]

    def of_scene(dt: float) -> tuple[float, np.ndarray]:
        again = make()  # type: ignore[misc]
        began = time.process_time()
        sol = ns.simulate(again, (0, motion.t_end), integrator=ns.MoreauJean(dt=dt), every=10**9)
        return time.process_time() - began, ends(sol)[0]

    yield "MoreauJean", (lambda dt: ours(ns.MoreauJean(dt=dt)), STEPS)
    yield "Adaptive", (lambda rtol: ours(ns.Adaptive(rtol=rtol, atol=1e-2 * rtol)), TOLERANCES)
    yield "EventDriven", (lambda rtol: ours(ns.EventDriven(rtol=rtol, atol=1e-2 * rtol)), TOLERANCES)
    if make is None:
        return
    yield "MoreauJean, scene", (of_scene, STEPS)
    if imports("mujoco"):
        made = motion.guided or make
        yield "MuJoCo", (lambda dt: mujoco(made(), motion.t_end, dt), STEPS)


def reached(curve: np.ndarray, error: float) -> str:
    """The least time with at most an error."""
    least = curve[2][curve[1] <= error].min(initial=math.inf)
    return f"{1e3 * least:.3g}" if least < math.inf else "-"
