"""
A ball with backspin comes back
===============================

A ball slides forward at 4 m/s and spins backwards at 200 rad/s. It stops, turns round and rolls back, at
80/7 m/s, whatever the step (Song, Fan, Ascher, Pai 2026).
"""

import matplotlib.pyplot as plt

import nonsmooth as ns

scene = ns.Scene(gravity=(0, 0, -9.81), material=ns.Material(mu=0.5))
scene.fixed(ns.HalfSpace((0, 0, 1)))
scene.body(ns.Sphere(0.25), density=1000, position=(0, 0, 0.25), velocity=(4, 0, 0), spin=(0, -200, 0), name="ball")
sol = ns.simulate(scene, (0, 4), integrator=ns.MoreauJean(dt=1 / 60))
ball, rolls = sol["ball"], 2 * (4 + 200 * 0.25) / (7 * 0.5 * 9.81)
figure, (above, below) = plt.subplots(2, 1, figsize=(7, 4.6), sharex=True, layout="constrained")
above.plot(sol.t, ball.velocity[:, 0])
above.set(ylabel="velocity [m/s]", title="dashed: rolls from here on")
below.plot(sol.t, ball.spin[:, 1])
below.set(xlabel="t [s]", ylabel="spin [rad/s]", xlim=(0, 4))
for axes in (above, below):
    axes.axvline(rolls, color="0.5", ls="--", lw=1)
errors = abs(ball.velocity[-1, 0] + 80 / 7), abs(ball.spin[-1, 1] + 320 / 7)
print(
    f"errors {errors[0]:.0e} m/s and {errors[1]:.0e} rad/s at 1/60 s; "
    f"{sol.stats.missed} of {sol.stats.steps} steps missed"
)
