"""
Equations that SymPy derived already
====================================

A pendulum on a cart by Lagrange's method of ``sympy.physics.mechanics``. A stop for the cart is added,
and the model runs with located impacts.
"""

import matplotlib.pyplot as plt
import numpy as np
import sympy as sp
from sympy.physics.mechanics import LagrangesMethod, dynamicsymbols

import nonsmooth as ns

x, th = dynamicsymbols("x th")
m, l, g = sp.symbols("m l g", positive=True)
bob = sp.Matrix([x + l * sp.sin(th), -l * sp.cos(th)])
rate = bob.diff(dynamicsymbols._t)
method = LagrangesMethod(m * x.diff() ** 2 + m * rate.dot(rate) / 2 + m * g * l * sp.cos(th), [x, th])
method.form_lagranges_equations()
cart = ns.lagrangian_of(method, {m: (1.0, "kg"), l: (0.5, "m"), g: (9.81, "m/s^2")}, name="cart")
cart.contact(gap=0.2 - x, e=0.8, name="stop")
model, t = cart.model(), np.linspace(0, 3, 600)
sol = ns.simulate(model, (0, 3), [0.0, 1.0], [0.0, 0.0], integrator=ns.EventDriven(rtol=1e-9))
figure, axes = plt.subplots(figsize=(7, 3.6), layout="constrained")
axes.plot(t, sol(t).q, label=["place of the cart [m]", "angle [rad]"])
axes.axhline(0.2, color="0.5", ls="--", lw=1, label="stop")
axes.set(xlabel="t [s]", xlim=(0, 3))
axes.legend()
impacts = sum(event.kind.name == "IMPACT" for event in sol.events)
print(f"{impacts} impacts, the first at t = {sol.events[0].t:.9f} s; penetration {sol.stats.worst_penetration:.0e} m")
