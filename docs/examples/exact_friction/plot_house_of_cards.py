"""
A house of cards
================

Four levels of 26 cards lean on one another with a friction of 0.8, at the step of a film. It stands: no
card moves (after Song, Fan, Ascher, Pai 2026; the size of the cards is ours).
"""

import math
from pathlib import Path

import nonsmooth as ns

LENGTH, WIDTH, THICKNESS, LEAN = 1.0, 0.45, 0.03, 0.23
scene = ns.Scene(gravity=(0, 0, -9.81), material=ns.Material(mu=0.8), name="house of cards")
scene.fixed(ns.HalfSpace((0, 0, 1)))


def card(x, z, lean):
    turn = (math.cos(lean / 2), 0, math.sin(lean / 2), 0)
    scene.body(ns.Box(THICKNESS, WIDTH, LENGTH), density=1000, position=(x, 0, z), turn=turn)


height = LENGTH * math.cos(LEAN) + THICKNESS * math.sin(LEAN)
reach = (LENGTH * math.sin(LEAN) + THICKNESS * math.cos(LEAN)) / 2
for level in range(4):
    z = level * (height + THICKNESS)
    for k in range(4 - level):
        for side in (-1, 1):
            card((k + level / 2) * LENGTH + side * reach, z + height / 2, -side * LEAN)
        if k:
            card((k - 0.5 + level / 2) * LENGTH, z + height + THICKNESS / 2, math.pi / 2)
sol = ns.simulate(scene, (0, 1), integrator=ns.MoreauJean(dt=1 / 60))
figure = sol.picture()
page = Path("house_of_cards.html")
sol.view(page)
moved = abs(sol.position[-1] - sol.position[0]).max()
print(
    f"{sol.stats.contacts} contacts, moved {moved:.0e} m; "
    f"residual {sol.stats.worst_residual:.0e}; {sol.stats.missed} of {sol.stats.steps} steps missed"
)
