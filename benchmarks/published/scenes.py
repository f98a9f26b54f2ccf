"""Scenes of the exact-friction paper of 2026, and of reports on other simulators."""

from __future__ import annotations

import functools
import math

import numpy as np

import nonsmooth as ns
from benchmarks.published.rows import Row, Section
from models.scenes import BlockOnIncline

STEP = ns.MoreauJean(dt=1 / 60)  # the printed step
UP = (0, 0, 1)


def slid(mu):
    """Way of a cube down a slope of atan 1/2 in 2 s [m]."""
    cube = BlockOnIncline(share=0.5 / mu, mu=mu, a=0.2, b=0.2, c=0.2)
    position = ns.simulate(cube, (0, 2), integrator=STEP)["block"].position
    return np.linalg.norm(position[-1] - position[0])


@functools.cache
def ball_with_backspin():
    """A ball of radius 0.25 m, at first at 4 m/s and -200 rad/s, mu = 0.5."""
    scene = ns.Scene(gravity=(0, 0, -9.81), material=ns.Material(mu=0.5))
    scene.fixed(ns.HalfSpace(UP))
    scene.body(ns.Sphere(0.25), density=1000, position=(0, 0, 0.25), velocity=(4, 0, 0), spin=(0, -200, 0), name="ball")
    return ns.simulate(scene, (0, 4), integrator=STEP)["ball"]


def end_of_slip():
    """Time from which on the ball rolls [s]."""
    ball = ball_with_backspin()
    return ball.t[np.argmax(np.abs(ball.velocity[:, 0] - 0.25 * ball.spin[:, 1]) < 1e-9)]


@functools.cache
def sliding_box(mu, speed, width, height):
    """A box on its way to rest."""
    scene = ns.Scene(gravity=(0, 0, -9.81), material=ns.Material(mu=mu))
    scene.fixed(ns.HalfSpace(UP))
    scene.body(ns.Box(width, 0.3, height), density=200, position=(0, 0, height / 2), velocity=(speed, 0, 0), name="box")
    return ns.simulate(scene, (0, 2), integrator=STEP)["box"].position


def rolled(degrees):
    """Way of a sphere down a slope in 1 s [m]."""
    slope = math.radians(degrees)
    scene = ns.Scene(gravity=(9.81 * math.sin(slope), 0, -9.81 * math.cos(slope)), material=ns.Material(mu=0.5))
    scene.fixed(ns.HalfSpace(UP))
    scene.body(ns.Sphere(0.1), density=1000, position=(0, 0, 0.1), name="ball")
    return ns.simulate(scene, (0, 1), integrator=STEP)["ball"].position[-1, 0]


SLOPE = {0.3: "3.50973", 0.4: "1.75487", 0.45: "0.877433"}

SECTIONS = (
    Section(
        "scenes",
        "Scenes with friction",
        "Song, Fan, Ascher, Pai, \"A Splitting Architecture for Exact Reduced Coulomb Friction\" (2026, arXiv "
        "2607.19599): slope, backspin, box, dt = 1/60 s. Reports on simulators: Genesis, pull request 3126 (a cube of "
        "0.1 m that slides at 6 m/s was lifted by 318 mm); Chrono, issue 260 (a gap of h mu v under what slides, in "
        "every method that makes friction convex).",
        (
            *(
                Row(f"way down the slope in 2 s, mu = {mu} [m]", printed, lambda mu=mu: slid(mu))
                for mu, printed in SLOPE.items()
            ),
            *(
                Row(f"the same, mu = {mu} [m]", "0", lambda mu=mu: slid(mu), within=1e-9, why="exact")
                for mu in (0.5, 0.55, 0.6, 0.8)
            ),
            Row("speed of the ball that rolls back [m/s]", "-80/7", lambda: ball_with_backspin().velocity[-1, 0],
                within=1e-11, why="exact"),
            Row("its angular velocity [rad/s]", "-320/7", lambda: ball_with_backspin().spin[-1, 1], within=1e-11,
                why="exact"),
            Row("time at which slip ends [s]", "3.1455", lambda: end_of_slip(), within=1 / 60,
                why="known to a step of 1/60 s"),
            Row("way of a box at 4 m/s, mu = b/h = 0.5 [m]", "1.63099",
                lambda: sliding_box(0.5, 4.0, 0.6, 1.2)[-1, 0], within=1.8e-4,
                why="the step in which it stops, mu g dt^2/8"),
            Row("lift of a cube at 6 m/s, mu = 0.3 [m]", "0.318", lambda: np.ptp(sliding_box(0.3, 6.0, 0.1, 0.1)[:, 2]),
                corrected="0.000000000", errs="Genesis before its repair: nothing lifts a cube that slides"),
            Row("gap under a cube at 6 m/s, mu = 0.8 [m]", "0",
                lambda: np.ptp(sliding_box(0.8, 6.0, 0.1, 0.1)[:, 2]), within=1e-12, why="exact"),
            Row("way of a sphere down 5 degrees in 1 s [m]", lambda: 9.81 * math.sin(math.radians(5)) * 5 / 14,
                lambda: rolled(5.0)),
        ),
        (slid, ball_with_backspin, end_of_slip, sliding_box, rolled),
    ),
)  # fmt: skip
