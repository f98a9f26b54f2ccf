"""
A robot finger on a table
=========================

A finger of two links, pressed on a table by constant torques. How far a slide may turn from the
plane of the links before the paradox ends follows from the plane: p < 0 where the part of friction
along it, μ cos φ, is above the critical friction.
"""

import numpy as np

import nonsmooth as ns
from nonsmooth.catalogue import RobotFinger

finger = RobotFinger()
axes = {"th2": np.linspace(-2.2, -0.65, 121), "phi": np.linspace(-np.pi, np.pi, 121)}
chart = ns.paradox_map(finger, **axes)
figure = ns.plot_map(chart, title="a finger on a table: numbers of solutions")
critical = np.array([finger.critical_friction(th2) for th2 in axes["th2"]])
away = np.array([finger.delassus(th2)[0, 1] > 0 for th2 in axes["th2"]])
edge = np.arccos(np.minimum(critical / finger.mu, 1.0)) + np.where(away, 0.0, np.pi)
for side in (edge, -edge, 2 * np.pi - edge, edge - 2 * np.pi):
    figure.axes[0].plot(axes["th2"], np.where(critical < finger.mu, side, np.nan), "k", lw=1)
figure.axes[0].set_ylim(-np.pi, np.pi)

held = finger.with_torques(finger.torques_that_press((1.0, 0.2, 0.3), th2=-1.2))
print("pressed at rest:", held.force_at_rest(th2=-1.2).round(12), "N, critical friction",
      round(finger.critical_friction(-1.2), 4))  # fmt: skip
