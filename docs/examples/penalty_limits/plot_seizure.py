"""
What a stiff contact does where there is no force
=================================================

The sprag-slip rod starts where rigid mechanics has no solution. On springs the force grows without
bound until the tip sticks: the stiffer, the sooner, and the impulse tends to that of the rigid jump.
"""

import matplotlib.pyplot as plt

import nonsmooth as ns
from nonsmooth.catalogue import SpragSlip

rod, start = SpragSlip(), SpragSlip().state(th=0.78, thdot=1.0)
figure, axes = plt.subplots(figsize=(7, 3.6), layout="constrained")
times = {}
for k in (1e5, 1e6, 1e7, 1e8):
    sol = ns.simulate(rod, (0, 2e-3), *start, integrator=ns.Penalty(stiffness=k, damping=k))
    axes.semilogx(1e3 * sol.t[1:], sol["thdot"][1:], label=f"k = {k:.0e} N/m")
    times[k] = sol.events[0].t
rate = rod.seizure(0.78, 1.0).thdot
axes.axhline(rate, color="0.5", ls="--", lw=1, label="rigid jump")
axes.set(xlabel="t [ms]", ylabel="rate of the rod [rad/s]")
axes.legend()
print(
    f"sticks after {', '.join(f'{t:.1e}' for t in times.values())} s; rate {sol['thdot'][-1]:.6f}, "
    f"rigid {rate:.6f} rad/s"
)
