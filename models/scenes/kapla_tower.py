"""A tower of planks: two side by side on two, crosswise, layer on layer.

It stands for any friction; each layer presses with the weight of what is above it.
"""

from __future__ import annotations

from dataclasses import dataclass

from nonsmooth.checks.arrays import as_count, as_non_negative, as_positive
from nonsmooth.scenes.materials import Material
from nonsmooth.scenes.scene import Scene
from nonsmooth.scenes.shapes import Box, HalfSpace

LENGTH, WIDTH, THICKNESS = 0.117, 0.0234, 0.0078  # defined: of a plank of the toy of this name, 15 : 3 : 1 [m]


@dataclass(frozen=True)
class KaplaTower:
    """A tower of planks: bodies "layer 0 plank 0", "layer 0 plank 1" and so on upwards.

    Parameters
    ----------
    layers : int
        Number of layers.
    density : float
        Density [kg/m^3].
    mu : float
        Friction coefficient.
    g : float
        Gravity [m/s^2].

    Raises
    ------
    InvalidInput
        When a parameter is out of range.

    Examples
    --------
    >>> from nonsmooth.catalogue import KaplaTower
    >>> KaplaTower(layers=3).scene()
    Scene(spatial, 7 bodies, 6 of them dynamic)
    """

    layers: int = 15
    density: float = 600.0  # [kg/m^3]
    mu: float = 0.4  # friction [-]
    g: float = 9.81  # gravity [m/s^2]

    name = "kapla-tower"
    source = "the toy of planks whose edges are 15 : 3 : 1"
    t_end = 2.0  # s
    dt = 2e-3  # s

    def __post_init__(self) -> None:
        as_count("layers", self.layers)
        as_positive("density", self.density, "kg/m^3")
        as_non_negative("mu", self.mu)
        as_positive("g", self.g, "m/s^2")

    def scene(self) -> Scene:
        """The tower, at rest on the ground."""
        scene = Scene(gravity=(0.0, 0.0, -self.g), material=Material(mu=self.mu))
        scene.fixed(HalfSpace((0, 0, 1)), name="ground")
        apart = 0.5 * (LENGTH - WIDTH)
        for layer in range(self.layers):
            for k, side in enumerate((-apart, apart)):
                height = (layer + 0.5) * THICKNESS
                along_x = layer % 2 == 0
                plank = Box(LENGTH, WIDTH, THICKNESS) if along_x else Box(WIDTH, LENGTH, THICKNESS)
                place = (0.0, side, height) if along_x else (side, 0.0, height)
                scene.body(plank, density=self.density, position=place, name=f"layer {layer} plank {k}")
        return scene

    def load(self, layer: int) -> float:
        """Force between a layer and what it stands on [N]."""
        return 2 * (self.layers - layer) * self.density * LENGTH * WIDTH * THICKNESS * self.g
