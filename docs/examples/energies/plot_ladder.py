"""
A ladder that slips from a wall
===============================

Energies, and two contacts: the foot on the ground, the head at the wall. The ladder slides down until
the wall no longer pushes, leaves it, and falls on.
"""

from pathlib import Path

import numpy as np
import sympy as sp

import nonsmooth as ns

made = ns.lagrangian("ladder")
x, y = made.coordinates("x y", unit="m")
th = made.coordinates("th", unit="rad")
m, a, g, mu = made.parameters(m=(5.0, "kg"), a=(2.0, "m", "half its length"), g=(9.81, "m/s^2"), mu=0.1)
centre, arm = sp.Matrix([x, y]), a * sp.Matrix([-sp.cos(th), sp.sin(th)])
made.rigid_body(m, m * a**2 / 3, at=centre, angle=th)
made.gravity(g)
made.contact(point=centre - arm, normal=(0, 1), mu=mu, name="foot")
made.contact(point=centre + arm, normal=(1, 0), mu=mu, name="head")
made.line(centre - arm, centre + arm)
made.line((0, 4), (0, 0), (4, 0))
ladder = made.model()
start = ladder.state(x=2 * np.cos(1.1), y=2 * np.sin(1.1), th=1.1)
sol = ns.simulate(ladder, (0, 1.2), *start, integrator=ns.EventDriven(rtol=1e-9))
figure = sol.picture(n=8)
page = Path("ladder.html")
sol.view(page)
left = next(e for e in sol.events if e.contact == 1 and e.mode_after == ns.ContactMode.OPEN)
energy = sol.ledger["kinetic"][-1] - sum(sol.ledger[name][-1] for name in ("force", "friction", "normal"))
print(f"leaves the wall at t = {left.t:.6f} s, {np.degrees(sol(left.t).q[2]):.3f}°; energy balance {abs(energy):.0e} J")
