"""What a step does with one body or one contact, in the plane (``planar``) or in space (``spatial``), by d."""

from __future__ import annotations

from nonsmooth.integrators.assembly.planar import move_planar, predict_planar_body, write_rows_planar
from nonsmooth.integrators.assembly.spatial import move_spatial, predict_spatial_body, write_rows_spatial
from nonsmooth.jit import kernel


@kernel
def predict_body(bodies, b, dt, d):
    """The free motion of body b in a step; it is put where its contacts are looked for."""
    if d == 2:
        predict_planar_body(bodies, b, dt)
    else:
        predict_spatial_body(bodies, b, dt)


@kernel
def write_rows(bodies, found, c, network, d):
    """J_i, J_j of contact c, and b_T from the moving surfaces."""
    if d == 2:
        write_rows_planar(bodies, found, c, network)
    else:
        write_rows_spatial(bodies, found, c, network)


@kernel
def move_body(bodies, b, dt, v, d):
    """Move body b by dt v, v (n_b, n)."""
    if d == 2:
        move_planar(bodies, b, dt, v)
    else:
        move_spatial(bodies, b, dt, v)
