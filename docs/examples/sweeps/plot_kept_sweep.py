"""
A map that is kept in a file
============================

One state of the sprag-slip rod a cell: how many forces fit, over its angle and its rate. The result is an
xarray data set with names and units, saved and read again to the same bits.
"""

import matplotlib.pyplot as plt
import numpy as np

import nonsmooth as ns
from nonsmooth.catalogue import SpragSlip

axes_of_map = {"th": np.linspace(0.6, 1.2, 80), "thdot": np.linspace(-3, 4, 80)}
found = ns.sweep(ns.MapTask(SpragSlip()), axes_of_map, progress=False)
ns.save_sweep(found, "map.npz")
again = ns.load_sweep("map.npz")
figure, axes = plt.subplots(figsize=(7, 4), layout="constrained")
image = axes.pcolormesh(again.th, again.thdot, again.n_solutions.T, cmap="viridis", vmin=0, vmax=2)
figure.colorbar(image, label="contact forces that fit", ticks=[0, 1, 2])
axes.set(xlabel="angle [rad]", ylabel="rate [rad/s]")
same = bool(np.array_equal(found.n_solutions, again.n_solutions))
print(
    f"{again.n_solutions.size} states, {again.attrs['cells_failed']} failed; "
    f"read again: {'the same' if same else 'different'}"
)
