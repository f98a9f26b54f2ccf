"""
Two answers that must agree
===========================

A double pendulum that strikes a wall, from its energies. Two integrators that share neither steps nor
the treatment of impacts give the same motion.
"""

import matplotlib.pyplot as plt
import numpy as np
import sympy as sp

import nonsmooth as ns

made = ns.lagrangian("double pendulum at a wall")
a, b = made.coordinates("a b", unit="rad")
m, l, g, e = made.parameters(m=(1.0, "kg"), l=(0.5, "m"), g=(9.81, "m/s^2"), e=0.7)
first = l * sp.Matrix([sp.sin(a), -sp.cos(a)])
second = first + l * sp.Matrix([sp.sin(b), -sp.cos(b)])
made.point_mass(m, at=first)
made.point_mass(m, at=second)
made.gravity(g)
made.contact(point=second, normal=(1, 0), offset=0.2, e=e, name="wall")
made.line((0, 0), first, second)
made.line((-0.2, -1.1), (-0.2, 0.1))
pendulum, t = made.model(), np.linspace(0, 3, 601)
start = pendulum.state(a=0.9, b=0.6)
runs = [ns.simulate(pendulum, (0, 3), *start, integrator=one) for one in (ns.EventDriven(1e-10), ns.Adaptive(1e-9))]
figure, axes = plt.subplots(figsize=(7, 3.6), layout="constrained")
axes.plot(t, runs[0](t).q, label=["upper angle", "lower angle"])
axes.set(xlabel="t [s]", ylabel="angle [rad]", xlim=(0, 3))
axes.legend()
impacts = sum(event.kind.name == "IMPACT" for event in runs[0].events)
print(f"{impacts} impacts; the two differ by {np.abs(runs[0](t).q - runs[1](t).q).max():.0e} rad")
