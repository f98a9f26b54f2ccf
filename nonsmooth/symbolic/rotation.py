"""Rotations in space by angles about axes of the turning body, and their angular velocity in its frame.

    R = R_1(a_1) R_2(a_2) R_3(a_3),    omega = R_3^T R_2^T e_1 a_1' + R_3^T e_2 a_2' + e_3 a_3'

Written as products of the single rotations, so that nothing has to be simplified. Source: Wittenburg, *Dynamics of
Multibody Systems* (2008), ch. 2.
"""

from __future__ import annotations

from typing import Any

import sympy as sp


class Rotation:
    """A rotation of a body.

    Parameters
    ----------
    axes : str
        A letter x, y or z for each angle.
    angles, rates : tuple
        The angles [rad] and their rates [rad/s].

    Attributes
    ----------
    matrix : Matrix
        (3, 3), from the frame of the body to that of space: ``at + rotation.matrix * r`` is a point r of the body.
    omega : tuple
        Angular velocity in the frame of the body [rad/s].
    """

    def __init__(self, axes: str, angles: tuple[Any, ...], rates: tuple[Any, ...]) -> None:
        self.axes, self.angles = axes, angles
        self.matrix = sp.eye(3)
        omega = sp.zeros(3, 1)
        for axis, angle, rate in zip(axes, angles, rates, strict=True):
            turn = single(axis, angle)
            self.matrix = self.matrix * turn
            omega = turn.T * omega
            omega["xyz".index(axis)] += rate
        self.omega = tuple(omega)


def single(axis: str, angle: Any) -> Any:
    """The rotation by an angle about one axis (3, 3)."""
    k = "xyz".index(axis)
    i, j = (k + 1) % 3, (k + 2) % 3
    turn = sp.eye(3)
    turn[i, i] = turn[j, j] = sp.cos(angle)
    turn[i, j], turn[j, i] = -sp.sin(angle), sp.sin(angle)
    return turn
