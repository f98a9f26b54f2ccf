"""Draw the figures of energies.md and rimless_wheel.md from the code of the pages: python docs/figures/energies.py"""

import os
import re
import shutil
import tempfile
from pathlib import Path

import numpy as np

from nonsmooth.drawing.plots import new_figure

DOCS = Path(__file__).parents[1]
PYTHON = re.compile(r"^```python\n(.*?)^```", re.MULTILINE | re.DOTALL)


def run(page):
    """What the Python of a page leaves."""
    scope = {"__name__": "page"}
    exec("\n".join(PYTHON.findall((DOCS / page).read_text())), scope)
    return scope


def draw_wheel(found, path):
    """Pictures along the slope, and the step map with the impacts of the run."""
    figure = new_figure(8.5, 4.0)
    left, right = figure.subplots(1, 2, width_ratios=[1.5, 1.0])
    wheel, sol, steps = found["wheel"], found["sol"], found["after"]
    for shade, t in zip(np.linspace(0.25, 1.0, 5), np.linspace(0, 4.0, 5), strict=True):
        for line in wheel.shape(sol.q[np.searchsorted(sol.t, t)]):
            left.plot(*line.T, color="C0", alpha=shade)
    for line in wheel.outline():
        left.plot(*line.T, color="grey")
    left.set(xlabel="x, along the slope [m]", ylabel="y [m]", aspect="equal", title="0, 1, 2, 3, 4 s")
    omega = np.linspace(1.1, 1.6, 50)
    right.plot(omega, omega, color="grey", lw=0.8)
    right.plot(omega, found["eta"] * np.sqrt(omega**2 + found["delta"]), label="closed form")
    before = np.array([found["omega_0"], *steps[:-1]])
    right.plot(-before, -steps, "o", ms=4, label="simulated")
    right.set(xlabel=r"$|\omega_k|$ [rad/s]", ylabel=r"$|\omega_{k+1}|$ [rad/s]", aspect="equal")
    right.legend()
    figure.savefig(path, dpi=110)


def main():
    here = os.getcwd()
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        run("energies.md")
        shutil.copy("arm.png", DOCS / "figures" / "two_link_arm.png")
        draw_wheel(run("rimless_wheel.md"), DOCS / "figures" / "rimless_wheel.png")
        os.chdir(here)


if __name__ == "__main__":
    main()
