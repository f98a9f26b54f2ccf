"""The motions on which integrators are measured and tested: eleven scenes of the field, three more, random ones."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from nonsmooth.catalogue.entries import load

BEADS = 20  # the dense Jacobian of an implicit method is not made for a hundred


class Motion(NamedTuple):
    """A model, natural variables of its start, and the end [s]."""

    model: Any
    start: dict[str, float]
    t_end: float

    @property
    def state(self) -> tuple[np.ndarray, np.ndarray]:
        """q0, u0."""
        q0, u0 = self.model.state(**self.start)
        return q0, u0


def motions() -> dict[str, Motion]:
    """The scenes of the field: through impacts, accumulations, sticking, paradoxes."""
    sprag_slip = load("sprag-slip")
    belt = load("belt-oscillator")(k=10.0, c=0.1, m0=0.4, m1=0.45, m3=0.6, vb=0.2, N=1.0)
    return {
        "ball through Zeno": Motion(load("bouncing-ball")(e=0.5), {"height": 1.0}, 2.0),
        "sliding block": Motion(load("sliding-block")(mu=0.3), {"speed": 2.0}, 1.0),
        "rod, slip and stick": Motion(
            load("painleve-rod")(mu=0.5), {"th": math.pi / 3, "thdot": 0.0, "slip": 1.0}, 0.3
        ),
        "belt, stick-slip": Motion(belt, {}, 20.0),
        "rocking block": Motion(load("rocking-block")(), {}, 3.0),
        "pendulum against a wall": Motion(load("wall-pendulum")(), {}, 5.0),
        "sprag-slip, limit cycle": Motion(sprag_slip.set_1(cth=0.5), {"th": 0.8, "thdot": 0.0}, 3.0),
        "sprag-slip, seizures": Motion(sprag_slip(), {"th": 0.8, "thdot": 0.0}, 3.0),
        "bead chain": Motion(load("bead-chain")(n=BEADS), {}, 2.0),
        "slider-crank": Motion(load("slider-crank")(), {}, 0.2),
        "woodpecker": Motion(load("woodpecker")(), {}, 0.6),
    }


def bilateral_motions() -> dict[str, Motion]:
    """Motions on bilateral and compliant contacts, which other programs do not have."""
    return {
        "bilateral rod": Motion(load("bilateral-rod")(mu=0.8), {"th": 1.0, "thdot": 0.0, "slip": 1.0}, 0.3),
        "mode coupling": Motion(load("mode-coupling")(), {}, 2.0),
        "lead screw": Motion(load("lead-screw")(), {}, 0.3),
    }


def random_motion(rng: np.random.Generator) -> tuple[Any, tuple[np.ndarray, np.ndarray], float]:
    """A model of random parameters, its start (q0, u0), and the end [s]."""
    kinds = (sliding_rod, flying_rod, sprag_slip, bilateral_rod, block, lead_screw, pendulum, chain)
    model, (q0, u0), t_end = kinds[rng.integers(len(kinds))](rng)
    return model, (q0, u0), t_end


def sliding_rod(rng: np.random.Generator) -> tuple:
    rod = load("painleve-rod")(mu=rng.uniform(0.1, 3.0), e=rng.choice([0.0, 0.5, 1.0]))
    return rod, rod.state(th=rng.uniform(0.2, 2.9), thdot=4 * rng.normal(), slip=2 * rng.normal()), 0.3


def flying_rod(rng: np.random.Generator) -> tuple:
    rod, (q0, u0), t_end = sliding_rod(rng)
    return rod, (q0 + [0.0, rng.uniform(0.0, 0.2), 0.0], u0 + rng.normal(size=3)), t_end


def sprag_slip(rng: np.random.Generator) -> tuple:
    rod = load("sprag-slip")(mu=rng.uniform(0.2, 1.6))
    return rod, rod.state(th=rng.uniform(0.3, 1.3), thdot=3 * rng.normal()), 2.0


def bilateral_rod(rng: np.random.Generator) -> tuple:
    rod = load("bilateral-rod")(mu=rng.uniform(0.1, 2.5))
    return rod, rod.state(th=rng.uniform(0.2, 1.4), thdot=4 * rng.normal(), slip=2 * rng.normal()), 0.3


def block(rng: np.random.Generator) -> tuple:
    model = load("rocking-block")(
        width=rng.uniform(0.1, 1.0), height=0.6, mu=rng.uniform(0.0, 1.5), e=rng.choice([0.0, 0.8])
    )
    q0, u0 = model.state(tilt=rng.uniform(-0.5, 0.5))
    return model, (q0 + [0.0, rng.uniform(0.0, 0.2), 0.0], u0 + rng.normal(size=3)), 1.5


def lead_screw(rng: np.random.Generator) -> tuple:
    screw = load("lead-screw")(mu=rng.uniform(0.05, 0.4))
    return screw, screw.state(), 0.3


def pendulum(rng: np.random.Generator) -> tuple:
    model = load("wall-pendulum")(th_w=rng.uniform(-0.5, 1.0), e=rng.uniform())
    return model, model.state(th=rng.uniform(1.05, 1.8)), 10.0


def chain(rng: np.random.Generator) -> tuple:
    beads = load("bead-chain")(n=int(rng.integers(2, 14)), e=rng.uniform())
    return beads, beads.state(velocity=1.0), 0.5
