"""
Parcels on a belt
=================

Parcels at rest are put on a moving belt. Each slides until it has the speed of the belt, rides to the
end, and falls. What the belt puts in is split into motion and heat, half each.

The player: ``nonsmooth run conveyor --view``.
"""

import matplotlib.pyplot as plt

import nonsmooth as ns
from nonsmooth.catalogue import Conveyor

line = Conveyor()
sol = ns.simulate(line, (0, 3.0), integrator=ns.MoreauJean(dt=1e-3), every=10)
figure, (above, below) = plt.subplots(2, 1, figsize=(7, 5), sharex=True, layout="constrained")
for name in [name for name in sol if name.startswith("parcel")]:
    above.plot(sol.t, sol[name].velocity[:, 0], label=name)
above.axvline(line.carried_at(), color="0.5", ls="--", lw=1)
above.set(ylabel="speed along the belt [m/s]", title="dashed: v/(μg)")
above.legend(ncols=2, loc="lower left")
for name, words in (("surface", "put in by the belt"), ("friction", "friction"), ("kinetic", "kinetic energy")):
    below.plot(sol.t, sol.ledger[name], label=words)
below.set(xlabel="t [s]", ylabel="energy and work [J]")
below.set_ylim(-20, 48)
below.legend(ncols=3, loc="upper left")
error = abs(sol["parcel 0"].velocity[sol.t < 1.0][-1, 0] - line.v)
print(f"speed on the belt to {error:.0e} m/s; {sol.stats.missed} of {sol.stats.steps} steps missed")
