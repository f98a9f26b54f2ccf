"""
From a Lagrangian to a picture
==============================

Energies and contacts are declared with SymPy; what comes back is a model like any other, compiled,
with its paradoxes and a critical friction in closed form.
"""

import sympy as sp

import nonsmooth as ns

l = ns.lagrangian("two-link arm on a belt")
th1, th2 = l.coordinates("th1 th2", unit="rad")
m, a, k, c = l.parameters(m=(1.0, "kg"), a=(0.5, "m"), k=(20.0, "N m/rad"), c=(0.2, "N m s/rad"))
g, v, mu = l.parameters(g=(9.81, "m/s^2"), v=(-1.0, "m/s", "speed of the belt"), mu=0.3)
elbow = a * sp.Matrix([sp.sin(th1), -sp.cos(th1)])
tip = elbow + a * sp.Matrix([sp.sin(th2), -sp.cos(th2)])
l.rigid_body(m, m * a**2 / 12, at=elbow / 2, angle=th1)
l.rigid_body(m, m * a**2 / 12, at=(elbow + tip) / 2, angle=th2)
l.gravity(g)
l.potential(k * (th1 + 0.5) ** 2 / 2 + k * (th2 - th1 - 1.2) ** 2 / 2)
l.dissipation(c * l.rate(th1) ** 2 / 2 + c * l.rate(th2 - th1) ** 2 / 2)
l.contact(point=tip, normal=(0, 1), offset=0.8, surface=(v, 0), mu=mu, name="tip")
l.line((0, 0), elbow, tip)
l.line((-0.5, -0.8), (0.7, -0.8))
arm = l.model()

sol = ns.simulate(arm, (0, 1.5), *arm.state(th1=-0.5, th2=1.4), integrator=ns.EventDriven())
figure = sol.picture()
print(arm.critical_friction())
print(
    f"{len(sol.events)} events, penetration {sol.stats.worst_penetration:.0e} m, "
    f"energy of a step to {sol.stats.ledger_error:.0e}"
)
