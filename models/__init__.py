"""Classical systems of nonsmooth mechanics: one file, one frozen dataclass, one system.

Each model holds its physical parameters in SI units, builds its ``System``, a consistent state from natural variables,
and carries its closed forms as methods. Nothing but the models that are used is imported.
"""

from __future__ import annotations

import importlib
from typing import Any

# name: module of this package
MODELS = {
    "BeadChain": "bead_chain",
    "BeltOscillator": "belt_oscillator",
    "BilateralRod": "bilateral_rod",
    "BilliardBall": "billiard_ball",
    "BouncingBall": "bouncing_ball",
    "FollowerForceArm": "follower_force_arm",
    "InclinedBlock": "incline",
    "ModeCoupling": "mode_coupling",
    "LeadScrew": "lead_screw",
    "PainleveRod": "painleve_rod",
    "RockingBlock": "rocking_block",
    "RobotFinger": "robot_finger",
    "SelfLockingRod": "self_locking_rod",
    "SliderCrank": "slider_crank",
    "SlidingBlock": "sliding_block",
    "SpatialPainleveRod": "spatial_painleve_rod",
    "SpinningTop": "spinning_top",
    "SpragSlip": "sprag_slip",
    "WallPendulum": "pendulum",
    "Woodpecker": "woodpecker",
}

__all__ = [*MODELS]


def __getattr__(name: str) -> Any:
    if name not in MODELS:
        raise AttributeError(f"there is no model {name!r}; known: {', '.join(__all__)}")
    model = getattr(importlib.import_module(f"{__name__}.{MODELS[name]}"), name)
    globals()[name] = model
    return model


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
