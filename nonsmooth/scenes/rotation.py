"""Rotations by unit quaternions p = (w, x, y, z):  r -> r + 2 w (e x r) + 2 e x (e x r),  e = (x, y, z).

Source: Shabana, *Dynamics of Multibody Systems*, section 2.2 (Euler parameters).
"""

from __future__ import annotations

from nonsmooth.jit import kernel


@kernel
def cross(a_x, a_y, a_z, b_x, b_y, b_z):
    """The vector product."""
    return a_y * b_z - a_z * b_y, a_z * b_x - a_x * b_z, a_x * b_y - a_y * b_x


@kernel
def turned(w, x, y, z, r_x, r_y, r_z):
    """A vector turned by a unit quaternion."""
    c_x, c_y, c_z = cross(x, y, z, r_x, r_y, r_z)
    e_x, e_y, e_z = cross(x, y, z, c_x, c_y, c_z)
    return r_x + 2.0 * (w * c_x + e_x), r_y + 2.0 * (w * c_y + e_y), r_z + 2.0 * (w * c_z + e_z)


@kernel
def composed(w, x, y, z, v, a, b, c):
    """The rotation by (v, a, b, c), and then by (w, x, y, z)."""
    e_x, e_y, e_z = cross(x, y, z, a, b, c)
    return w * v - x * a - y * b - z * c, w * a + v * x + e_x, w * b + v * y + e_y, w * c + v * z + e_z
