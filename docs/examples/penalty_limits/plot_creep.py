"""
Three kinds of friction on springs
==================================

A block on a slope, held by compliant contacts. Friction that is smoothed creeps at once, the slower the
smaller its parameter; a tangential spring gives way once and holds.
"""

import matplotlib.pyplot as plt

import nonsmooth as ns
from nonsmooth.catalogue import BlockOnIncline

block, ends = BlockOnIncline(share=0.5), {}
laws = {"tangential spring": ns.TangentialSpring()}
laws |= {f"smoothed, {v_s:.0e} m/s": ns.Regularised(v_s=v_s) for v_s in (1e-2, 1e-3)}
figure, axes = plt.subplots(figsize=(7, 3.6), layout="constrained")
for name, law in laws.items():
    springs = ns.Penalty(1e6, damping_ratio=1.0, friction=law)
    sol = ns.simulate(block, (0, 0.5), integrator=springs, every=20)
    way = sol["block"].position[:, 0] - sol["block"].position[0, 0]
    axes.semilogy(sol.t[1:], abs(way[1:]), label=name)
    ends[name] = abs(way[-1] - way[len(way) // 2]) / (sol.t[-1] - sol.t[len(way) // 2])
rigid = ns.simulate(block, (0, 0.5), integrator=ns.MoreauJean(dt=1e-2))["block"]
axes.set(xlabel="t [s]", ylabel="way [m]", xlim=(0, 0.5))
axes.legend()
creep = ", ".join(f"{name} {speed:.0e} m/s" for name, speed in ends.items())
print(f"creep: {creep}, rigid {abs(rigid.position[-1] - rigid.position[0]).max() / 0.5:.0e} m/s")
