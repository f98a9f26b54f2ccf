"""Classical scenes of bodies that touch: one file, one frozen dataclass, one scene.

Each holds its physical parameters in SI units, builds its ``Scene`` by ``scene()``, and carries its closed forms, or
the criterion by which it stands or falls, as methods. Nothing but the scenes that are used is imported.
"""

from __future__ import annotations

import importlib
from typing import Any

# name: module of this package
SCENES = {
    "AndrewsSqueezer": "andrews_squeezer",
    "BilliardBreak": "billiard_break",
    "BlockOnIncline": "block_on_incline",
    "BoxStack": "box_stack",
    "CarOnBump": "car_on_bump",
    "CardHouse": "card_house",
    "ChalkOnBoard": "chalk_on_board",
    "Conveyor": "conveyor",
    "CrankInSlot": "crank_in_slot",
    "DominoRow": "domino_row",
    "DoublePendulum": "double_pendulum",
    "EulersDisc": "eulers_disc",
    "FourBars": "four_bars",
    "Governor": "governor",
    "Gripper": "gripper",
    "Hourglass": "hourglass",
    "JammingDrawer": "jamming_drawer",
    "KaplaTower": "kapla_tower",
    "MasonryArch": "masonry_arch",
    "NewtonsCradle": "newtons_cradle",
    "Pyramid": "pyramid",
    "Rattleback": "rattleback",
    "RimlessWheel": "rimless_wheel",
    "RollingWheel": "rolling_wheel",
    "ShoeBrake": "shoe_brake",
    "SlipToRoll": "slip_to_roll",
    "SpatialFourBar": "spatial_four_bar",
    "SphereBox": "sphere_box",
    "TippeTop": "tippe_top",
    "TumblingBox": "tumbling_box",
    "Turntable": "turntable",
    "VibratingFeeder": "vibrating_feeder",
    "Wall": "wall",
    "WreckingBall": "wrecking_ball",
}

__all__ = [*SCENES]


def __getattr__(name: str) -> Any:
    if name not in SCENES:
        raise AttributeError(f"there is no scene {name!r}; known: {', '.join(__all__)}")
    scene = getattr(importlib.import_module(f"{__name__}.{SCENES[name]}"), name)
    globals()[name] = scene
    return scene


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
