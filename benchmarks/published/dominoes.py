"""Waves of dominoes, filmed."""

from __future__ import annotations

import functools

import numpy as np

import nonsmooth as ns
from benchmarks.published.rows import Row, Section
from models.scenes import DominoRow

FILMS = {  # gap [mm]: frames a second, frames in which two tiles begin to fall, tiles from one to the other
    8.96: ((5000, 4886, 9304, 69),),
    9.38: (
        (4000, 2305, 4329, 38), (4000, 3990, 6120, 38), (4000, 3727, 4793, 19), (4000, 1398, 5494, 77),
        (4000, 2371, 5641, 62), (1000, 739, 2084, 102), (5000, 4868, 9404, 71),
    ),
    15.0876: ((5000, 5013, 9906, 49),),
    43.2562: ((5000, 11083, 21842, 35), (5000, 25784, 31530, 19), (5000, 11767, 17202, 17), (5000, 18684, 22269, 12)),
}  # fmt: skip
ON_FELT = ((5000, 2462, 3913, 23), (5000, 7929, 12462, 72), (5000, 2484, 3923, 22), (5000, 4331, 8737, 70))
THICKNESS, HEIGHT = 7.5438e-3, 48e-3  # m
FRICTION = 0.066  # fitted: of tiles on one another, to the film of the gap of 15.1 mm
FIRST, LAST = 18, 36  # chosen: tiles between which the wave is steady, and has others before it


def filmed(gap, films=None):
    """Mean speed of the wave over the films [m/s], and its standard deviation from one to another."""
    pitch = 1e-3 * gap + THICKNESS
    speeds = [pitch * tiles * rate / (last - first) for rate, first, last, tiles in films or FILMS[gap]]
    return np.mean(speeds), np.std(speeds, ddof=1) if len(speeds) > 1 else np.nan


@functools.cache
def wave_speed(gap, mu_d=FRICTION):
    """Speed of the wave through a row of 40 tiles on a floor on which they do not slip [m/s]."""
    row = DominoRow(n=40, h=HEIGHT, d=THICKNESS, s=1e-3 * gap, mu=2.0, mu_d=mu_d, omega=15.0)
    sol = ns.simulate(row, (0, 0.7 + 0.05 * gap), integrator=ns.MoreauJean(dt=2e-4))
    falls = [sol.t[np.argmax(np.abs(sol[f"domino {k}"].turn) > 1e-3)] for k in range(FIRST, LAST)]
    return (row.s + row.d) / np.polyfit(range(FIRST, LAST), falls, 1)[0]


SECTIONS = (
    Section(
        "dominoes",
        "Waves of dominoes, measured",
        "Films of rows on a hard floor, read tile by tile, of which the repository 3b1b/manim keeps the numbers "
        "of the frames (old_projects/dominos, data02 to data19): from the 20th tile on, and of the gap of 43 mm "
        "the four stretches of two films that were in sight. Tiles are 7.54 mm thick; their height of 48 mm is "
        "that of the common ones, and is not in the data. The errors are two standard deviations from film to "
        "film, or stretch to stretch; of single films those of the gap of 9.38 mm. The friction of tiles on one "
        "another, 0.066, is fitted to one film, and the others are predicted; tiles do not slip on the floor. "
        "Without friction all would be faster (dashed). On felt four films of the gap of 9.38 mm have 1.33 m/s, 5 "
        "% more than on the hard floor, which rigid ground does not explain.",
        tuple(
            Row(f"speed of the wave, gap {gap} mm [m/s]", printed, lambda gap=gap: wave_speed(gap), within=within,
                why=why, is_slow=True)
            for gap, printed, within, why in (
                (8.96, "1.289", 0.086, "two standard deviations"), (9.38, "1.264", 0.086, "two standard deviations"),
                (15.0876, "1.133", 0.01, "friction is fitted to it"),
                (43.2562, "0.828", 0.049, "two standard deviations"),
            )
        ),
        (filmed, wave_speed),
        picture="![speed against the gap, filmed and computed](domino_speeds.png)",
    ),
)  # fmt: skip
