"""
Run time against error
======================

A method is as good as the error that it reaches in a time. Each integrator is run over its steps or
tolerances; the error is measured against a reference that two methods agree upon.
"""

import nonsmooth as ns
from nonsmooth.catalogue import Woodpecker

methods = {"MoreauJean": ns.MoreauJean, "Adaptive": ns.Adaptive, "EventDriven": ns.EventDriven}
study = ns.work_precision([Woodpecker()], methods)
print(study.table())
figure = study.plot()
cheapest = {name: study.cost_at(1e-6, "woodpecker", name) for name in methods}
print("at an error of 1e-6:", ", ".join(f"{name} {1e3 * cost:.1f} ms" for name, cost in cheapest.items() if cost < 1))
