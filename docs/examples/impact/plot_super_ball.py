"""
A super ball under a table
==========================

A rough, elastic ball is thrown under a table. It bounces between floor and table top, its spin and its
way turn round at each impact, and it comes back; without tangential restitution it goes on (Leine).
"""

import matplotlib.pyplot as plt
import numpy as np

import nonsmooth as ns

figure, axes = plt.subplots(figsize=(7, 3.6), layout="constrained")
ways, kept = {}, {}
for e_F in (1.0, 0.0):
    made = ns.lagrangian(f"super ball, tangential restitution {e_F}")
    x, y = made.coordinates("x y", unit="m")
    phi = made.coordinates("phi", unit="rad")
    m, J, R, g = made.parameters(m=(1.0, "kg"), J=(0.004, "kg m^2"), R=(0.1, "m"), g=(10.0, "m/s^2"))
    made.rigid_body(m, J, at=(x, y), angle=phi)
    made.gravity(g)
    made.contact(gap=y - R, slip=made.rate(x) + R * made.rate(phi), mu=1.0, e=1.0, e_F=e_F, name="floor")
    made.contact(gap=1 - R - y, slip=made.rate(x) - R * made.rate(phi), mu=1.0, e=1.0, e_F=e_F, name="table")
    ball = made.model()
    start = ball.state(y=0.9, xdot=1.0, ydot=-1.0)
    sol = ns.simulate(ball, (0, 1.2), *start, integrator=ns.EventDriven(rtol=1e-9))
    t = np.linspace(0, 1.2, 600)
    axes.plot(*sol(t).q[:, :2].T, label=f"tangential restitution {e_F:.0f}")
    ways[e_F], kept[e_F] = sol["xdot"][-1], sol.ledger["kinetic"][-1] + sol.ledger["potential"][-1]
axes.set(xlabel="x [m]", ylabel="height of the centre [m]", ylim=(0, 1))
axes.legend()
print(f"velocity at the end {ways[1.0]:.3f} and {ways[0.0]:.3f} m/s; energy of the first {kept[1.0]:.9f} J of 10")
