"""Draw the measured and computed speeds of waves of dominoes: python docs/figures/domino_speeds.py"""

import sys
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

DOCS = Path(__file__).parents[1]
GAPS = (6.0, 9.38, 12.0, 15.0876, 20.0, 27.0, 35.0, 43.2562)  # mm


def main():
    sys.path.append(str(DOCS.parent))
    from benchmarks.published import dominoes

    figure = Figure(figsize=(6.4, 3.6), layout="constrained")
    axes = figure.subplots()
    for mu_d, style in ((0.0, "--"), (dominoes.FRICTION, "-")):
        speeds = [dominoes.wave_speed(gap, mu_d) for gap in GAPS]
        axes.plot(GAPS, speeds, style, color="tab:blue", label=f"computed, $\\mu$ = {mu_d:g} between tiles")
    between_films = dominoes.filmed(9.38)[1]
    for k, gap in enumerate(dominoes.FILMS):
        speed, deviation = dominoes.filmed(gap)
        error = 2 * (between_films if np.isnan(deviation) else deviation)
        label = "filmed, two standard deviations" if k == 0 else None
        axes.errorbar(gap, speed, error, fmt="o", color="tab:red", capsize=3, label=label)
    axes.set(xlabel="gap between two tiles [mm]", ylabel="speed of the wave [m/s]", xlim=(0, 46), ylim=(0, 1.5))
    axes.legend(loc="lower left")
    figure.savefig(DOCS / "benchmarks" / "domino_speeds.png", dpi=150)


if __name__ == "__main__":
    main()
