"""
Real playing cards
==================

Five levels of cards of 88 x 63 x 0.3 mm and 1.8 g, leaning at 25° with a friction of 0.8: forty cards of
paper that stand (after a test of a fork of PhysX, 2026).
"""

import math

import nonsmooth as ns

LENGTH, WIDTH, THICKNESS, LEAN = 0.088, 0.063, 0.0003, math.radians(25)
scene = ns.Scene(gravity=(0, 0, -9.81), material=ns.Material(mu=0.8), name="playing cards")
scene.fixed(ns.HalfSpace((0, 0, 1)))


def card(x, z, lean):
    turn = (math.cos(lean / 2), 0, math.sin(lean / 2), 0)
    scene.body(ns.Box(THICKNESS, WIDTH, LENGTH), mass=0.0018, position=(x, 0, z), turn=turn)


height = LENGTH * math.cos(LEAN) + THICKNESS * math.sin(LEAN)
reach = (LENGTH * math.sin(LEAN) + THICKNESS * math.cos(LEAN)) / 2
for level in range(5):
    z = level * (height + THICKNESS)
    for k in range(5 - level):
        for side in (-1, 1):
            card((k + level / 2) * LENGTH + side * reach, z + height / 2, -side * LEAN)
        if k:
            card((k - 0.5 + level / 2) * LENGTH, z + height + THICKNESS / 2, math.pi / 2)
sol = ns.simulate(scene, (0, 0.5), integrator=ns.MoreauJean(dt=0.01))
figure = sol.picture()
moved = abs(sol.position[-1] - sol.position[0]).max()
print(
    f"{len(list(sol)) - 1} cards, {sol.stats.contacts} contacts; moved {moved:.0e} m; "
    f"residual {sol.stats.worst_residual:.0e}; {sol.stats.missed} of {sol.stats.steps} steps missed"
)
