"""Angular velocities of joined bodies in space after the move: their angular momentum is that which the impulses left.

    I(R_1) omega_1 = I(R_0) omega_0 + r x P

A body that turns about several axes has another inertia at the end of the step than in its middle, where its impulses
act; J v_1 + b = 0 with the inertia of the middle errs by dt/2 (omega x I delta + delta x I omega) in each step, delta
what the impulses change of omega: together an error of first order. What omega_1 changes here is of second order, of
the size of what b leaves of the joints.
"""

from __future__ import annotations

from nonsmooth.contact.network.problem import Network
from nonsmooth.integrators.assembly.bodies import Bodies
from nonsmooth.integrators.assembly.joints import Joints
from nonsmooth.integrators.assembly.spatial import turn_back, turn_by
from nonsmooth.jit import kernel
from nonsmooth.jit.blocks import view


@kernel("void(int64, int64, int64)")
def keep_angular_momenta(joints_at, bodies_at, network_at):
    """Spins of the bodies that have joints and unlike moments, from before the step and the impulses of its problem."""
    joints, bodies, network = view(joints_at, Joints), view(bodies_at, Bodies), view(network_at, Network)
    for b in range(bodies.mass.shape[0]):
        I_0, I_1, I_2 = bodies.moments[b, 0], bodies.moments[b, 1], bodies.moments[b, 2]
        is_joined = joints.first[b] < joints.first[b + 1] and network.islands.of[b] >= 0
        if is_joined and not (I_0 == I_1 and I_1 == I_2):
            write_spin(bodies, network, b)


@kernel
def write_spin(bodies, network, b):
    """omega_1 of body b."""
    I, x, x_0, v, M = bodies.moments, bodies.motion.x, bodies.x_0, bodies.motion.v, network.M
    o_0, o_1, o_2 = turn_back(x_0, b, v[b, 3], v[b, 4], v[b, 5])
    L_0, L_1, L_2 = turn_by(x_0, b, I[b, 0] * o_0, I[b, 1] * o_1, I[b, 2] * o_2)
    for axis in range(3, 6):
        bodies.v_0[b, axis] = v[b, axis]  # works are those of the mean of omega_0 and omega_1
        change = network.v[b, axis] - network.v_free[b, axis]
        L_0 += M[b, 3, axis] * change
        L_1 += M[b, 4, axis] * change
        L_2 += M[b, 5, axis] * change
    p_0, p_1, p_2 = turn_back(x, b, L_0, L_1, L_2)
    network.v[b, 3], network.v[b, 4], network.v[b, 5] = turn_by(x, b, p_0 / I[b, 0], p_1 / I[b, 1], p_2 / I[b, 2])
