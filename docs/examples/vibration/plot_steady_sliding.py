"""
Is steady sliding stable, and what would help?
==============================================

Where a brake pad rests on its disc, whether it stays there, and what each parameter does to the growth:
three calls, and a bar for each parameter.
"""

import matplotlib.pyplot as plt

import nonsmooth as ns
from nonsmooth.catalogue import ModeCoupling

brake = ModeCoupling(mu=0.6)
at = ns.equilibrium(brake)
small = ns.linearise(brake, at)
names = ("mu", "k", "kx", "kz", "cx", "cz", "m")
worst = max(range(len(small.eigenvalues)), key=lambda k: small.eigenvalues[k].real)
slopes = {name: ns.eigenvalue_sensitivity(brake, name, small)[worst].real * getattr(brake, name) / 10 for name in names}
figure, axes = plt.subplots(figsize=(7, 3.4), layout="constrained")
axes.bar(list(slopes), list(slopes.values()), color=["C3" if slope > 0 else "C0" for slope in slopes.values()])
axes.axhline(0, color="k", lw=0.8)
axes.set(ylabel="change of the growth rate [1/s]\nby 10 % more of a parameter")
print(
    f"{small.verdict.name} at x = {at.q[0]:.6f} m, growth {small.growth:.6f} 1/s; most by {max(slopes, key=slopes.get)}"
)
