"""
A slide that turns into the paradox
===================================

In the plane a rod that slides under load never comes to p = 0. In space its slide turns as it is
braked, p falls like the root of the time that is left, and the normal force grows like its inverse,
until the slide ends by an impact without collision.
"""

import matplotlib.pyplot as plt
import numpy as np

import nonsmooth as ns
from nonsmooth.catalogue import SpatialPainleveRod

rod = SpatialPainleveRod(mu=2.0)
figure, (left, right) = plt.subplots(1, 2, figsize=(9, 3.8), layout="constrained")
for phi in (0.9, 1.0, 1.1, 1.2):
    q, u = rod.state(th=1.0, phi=phi, psidot=4.0, slip=3.0)
    sol = ns.simulate(rod, (0, 0.03), q, u, integrator=ns.EventDriven(rtol=1e-10, atol=1e-12))
    impact = next(event for event in sol.events if event.kind.name == "INCONSISTENT")
    before = sol.t < impact.t
    slip, psi = sol.gamma_F[before, 0], sol["psi"][before]
    turned = np.unwrap(np.arctan2(-slip[:, 1], -slip[:, 0]) - psi)
    line = left.plot(1e3 * sol.t[before], np.degrees(turned), label=f"{np.degrees(phi):.0f}°")[0]
    left.plot(1e3 * impact.t, np.degrees(turned[-1]), "o", color=line.get_color())
    right.loglog(impact.t - sol.t[before], sol.la[before, 0, 0])
    print(f"phi = {phi}: impact of {impact.P_N:.4f} N s after {1e3 * impact.t:.3f} ms")
until = np.array([1e-9, 1e-3])
right.loglog(until, 0.3 / np.sqrt(until), ":", color="0.3", label="slope -1/2")
left.set(xlabel="t [ms]", ylabel="azimuth of the slide [degrees]", title="dots: p = 0")
left.legend(title="at first", loc="upper right")
right.set(xlabel="time until the impact [s]", ylabel="normal force [N]", xlim=(1e-10, 3e-2), ylim=(5, 1e6))
right.legend()
