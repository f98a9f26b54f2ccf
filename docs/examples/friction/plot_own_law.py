"""
A system and a law of friction of one's own
===========================================

A mass on a belt as plain functions, under ready laws and one of its own, Leine's. The limit of sticking
is the same, the motions are not.
"""

import matplotlib.pyplot as plt
import numpy as np

import nonsmooth as ns


def motion_on_belt(law):
    belt = ns.System(
        coordinates=[("x", "m")],
        mass=lambda t, q, p: [[1.0]],
        force=lambda t, q, u, p: [-10.0 * q[0] - 0.05 * u[0]],
        tangent=lambda t, q, p: [[[1.0]]],
        surface_velocity=lambda t, q, p: [[-0.1]],
        normal_force=lambda t, q, u, p: [1.0],
        contacts=[ns.Contact(mu=law, normal_force=True, name="belt")],
    )
    return ns.simulate(belt, (0, 10), state={"x": 0.0, "xdot": 0.1}, integrator=ns.EventDriven(rtol=1e-8))


laws = {"Coulomb": ns.Coulomb(0.4), "StaticKinetic": ns.StaticKinetic(0.4, 0.3)}
laws |= {"Polynomial": ns.Polynomial(0.4, 0.45, 0.6), "Stribeck": ns.Stribeck(0.4, 0.3, 0.1)}
laws |= {"Smoothed": ns.Smoothed(0.4, 20.0), "Leine's": ns.Friction(lambda v: 0.4 / (1.0 + 3.0 * v))}
figure, axes = plt.subplots(figsize=(7.5, 4), layout="constrained")
t, ends = np.linspace(0, 10, 1000), {}
for name, law in laws.items():
    sol = motion_on_belt(law)
    axes.plot(t, sol(t).q[:, 0], label=name)
    ends[name] = sol["x"][sol.mode[:, 0] == ns.ContactMode.STICK].max() if name != "Smoothed" else np.nan
axes.set(xlabel="t [s]", ylabel="x [m]", xlim=(0, 10))
figure.legend(loc="outside right upper")
released = {name: end for name, end in ends.items() if name != "Smoothed"}
print("released at", ", ".join(f"{name} {end:.6f} m" for name, end in released.items()), "(0.0395 expected)")
