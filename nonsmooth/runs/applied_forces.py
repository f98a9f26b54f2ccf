"""Applied forces in a step: what ``scene.force`` says, in the middle of the step.

    h = h(t + dt/2, x_0 + dt/2 v_0, v_0 + dt/2 a_0),    a_0 = g + M^-1 h(t, x_0, v_0)

the explicit mid-point rule, of second order; what impulses do within the step is not in it. A force at a point r from
the centre of mass has the torque r x f. Constant forces on centres of mass are written once. What a motor gives to a
joint with a spring, a damper or a rotor goes into the row of that one (assembly/drive_rows.py), at dt/2 too.

Source: Hairer, Norsett and Wanner, *Solving Ordinary Differential Equations I* (1993), section II.1.
"""

from __future__ import annotations

import numpy as np

from nonsmooth.checks.arrays import as_number, as_vector, result_of
from nonsmooth.errors import InvalidInput, shown
from nonsmooth.integrators.assembly.accelerations import row_of
from nonsmooth.integrators.assembly.apart import move
from nonsmooth.integrators.assembly.world import World
from nonsmooth.results.scene_bodies import SceneState
from nonsmooth.scenes.elements import Force, Joint, Motor
from nonsmooth.scenes.places import ORIGIN, compose, inverse, place_of, rotate
from nonsmooth.scenes.shapes import SPATIAL


class AppliedForces:
    """The forces that are applied to the bodies of a world.

    Parameters
    ----------
    world : World
        At the start.
    """

    def __init__(self, world: World) -> None:
        self.world, self.dim, x = world, world.dim, world.bodies.motion.x
        self.names = [body.name for body in world.scene.bodies]
        self.steady = np.zeros_like(world.bodies.load)
        self.changing: list[tuple[Force, np.ndarray | None]] = []
        for force in world.scene.forces:
            if callable(force.value) or force.at is not None:
                self.changing.append((force, self._arm_of(force, x)))
            else:
                self.steady[force.body.index, : self.dim] += force.value
        loads = [(joint, motor) for joint in world.scene.joints for motor in joint.motors if motor.load is not None]
        sprung = world.sprung
        self.motors = [(joint, motor, self._axis_of(joint, x)) for joint, motor in loads
                       if (joint.index, motor.along) not in sprung]  # fmt: skip
        self.geared = [(joint, motor, *sprung[joint.index, motor.along]) for joint, motor in loads
                       if (joint.index, motor.along) in sprung]  # fmt: skip
        self.speeds = [
            (k, scale, joint, motor.speed) for k, scale, joint, motor in world.speeds if callable(motor.speed)
        ]
        geared_functions = any(callable(motor.load) for _, motor, *_ in self.geared)
        self.is_asked = bool(self.changing or self.motors or self.speeds or geared_functions)
        self.are_applied = bool(world.scene.forces or loads or self.speeds)
        self._apply(self.steady)
        if not geared_functions:
            self._apply_geared(0.0, None)

    def _arm_of(self, force: Force, x: np.ndarray) -> np.ndarray | None:
        """Where a force acts, along the principal axes of its body."""
        if force.at is None:
            return None
        return compose(inverse(x[force.body.index]), place_of(force.at, ORIGIN[self.dim][self.dim :]))[: self.dim]

    def _axis_of(self, joint: Joint, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The axis of a joint along those of its first body, and its point along those of the second."""
        a, b, d = x[joint.a.index], x[joint.b.index], self.dim
        back = inverse(a)[d:] if d == SPATIAL else -a[d]
        return rotate(back, joint.axis), compose(inverse(b), place_of(joint.at, ORIGIN[d][d:]))[:d]

    def update(self, t: float, dt: float) -> None:
        """Take the forces in the middle of a step from t to t + dt [s].

        Raises
        ------
        InvalidInput
            For a function that raises, or returns no force.
        """
        bodies = self.world.bodies
        x, v = bodies.motion.x.copy(), bodies.motion.v.copy()
        state = self._state(t + dt, x, v) if self.speeds else None
        for k, scale, joint, speed in self.speeds:
            name = f"speed of the motor of {joint.name} at t = {t + dt:g} s"
            self.world.drives.speed[k] = scale * as_number(name, result_of(name, speed, t + dt, state))
        if not (self.changing or self.motors or self.geared):
            return
        start = self._loads(t, x, v)
        move(x, 0.5 * dt * v)
        v[:, : self.dim] += 0.5 * dt * self._accelerations(start)
        self._apply(self._loads(t + 0.5 * dt, x, v))
        self._apply_geared(t + 0.5 * dt, self._state(t + 0.5 * dt, x, v))

    def _apply_geared(self, t: float, state: SceneState | None) -> None:
        """Write what motors give to the rows of springs, in which they are summed."""
        drives = self.world.drives
        drives.load[:] = 0.0
        for joint, motor, k, scale in self.geared:
            drives.load[k] += self._value_of_motor(joint, motor, t, state) / scale

    def _value_of_motor(self, joint: Joint, motor: Motor, t: float, state: SceneState | None) -> float:
        """Torque or force that one says."""
        name = f"the motor of {joint.name} at t = {t:g} s"
        return as_number(name, result_of(name, motor.load, t, state) if callable(motor.load) else motor.load)

    def write(self, t: float) -> None:
        """Take the forces at a time t [s] and the state at hand, in stages of a step.

        Raises
        ------
        InvalidInput
            For a function that raises, or returns no force.
        """
        motion = self.world.bodies.motion
        self._apply(self._loads(t, motion.x, motion.v))

    def _accelerations(self, load: np.ndarray) -> np.ndarray:
        """Of the centres of mass (n_b, d), of bodies that move by forces."""
        bodies = self.world.bodies
        moves = (bodies.motion.moves == 1)[:, None]
        mass = np.where(moves, bodies.mass[:, None], 1.0)
        return np.where(moves, bodies.gravity + load[:, : self.dim] / mass, 0.0)

    def _loads(self, t: float, x: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Forces and torques (n_b, n) at a time and a state."""
        load, d = self.steady.copy(), self.dim
        state = self._state(t, x, v)
        for joint, motor, (axis, arm) in self.motors:
            value = self._value_of_motor(joint, motor, t, state)
            add_motor(load, x, joint, value, motor.along == "angle", axis, arm)
        for force, place in self.changing:
            b = force.body.index
            f, torque = self._value_of(force, t, state)
            turn = x[b, d:] if d == SPATIAL else x[b, d]
            load[b] += row_of(f, np.zeros(d) if place is None else rotate(turn, place))
            load[b, d:] += torque
        return load

    def _state(self, t: float, x: np.ndarray, v: np.ndarray) -> SceneState:
        return SceneState(t, self.names, self.world.scene, *self.world.record(x, v))

    def _value_of(self, force: Force, t: float, state: SceneState) -> tuple[np.ndarray, np.ndarray]:
        """Force and torque that one says."""
        none = np.zeros(2 * self.dim - 3)
        if not callable(force.value):
            return force.value, none
        name = f"the force on {force.body.name} at t = {t:g} s"
        said = result_of(name, force.value, t, state)
        if isinstance(said, tuple | list) and len(said) == 2 and (self.dim == SPATIAL or np.ndim(said[0]) == 1):
            f, torque = said
            return as_vector(name, f, self.dim), as_vector(f"torque of {name}", np.atleast_1d(torque), len(none))
        if np.shape(said) != (self.dim,):
            raise InvalidInput(f"{name} must be {self.dim} numbers [N], or (force, torque); got {shown(said)}")
        return as_vector(name, said, self.dim), none

    def _apply(self, load: np.ndarray) -> None:
        """Write what the next step has."""
        bodies = self.world.bodies
        bodies.load[:] = load
        moves = bodies.motion.moves == 1
        pull = np.linalg.norm(load[moves, : self.dim], axis=1) / bodies.mass[moves]
        bodies.strongest = float(pull.max(initial=0.0))


def add_motor(
    load: np.ndarray, x: np.ndarray, joint: Joint, value: float, is_torque: bool, axis: np.ndarray, arm: np.ndarray
) -> None:
    """Add what a motor gives to the loads of both bodies (n_b, n), at places (n_b, n_x)."""
    a, b, d = joint.a.index, joint.b.index, len(axis)
    turns = [x[body, d:] if d == SPATIAL else x[body, d] for body in (a, b)]
    if is_torque:
        torque = value * rotate(turns[0], axis) if d == SPATIAL else value
        load[b, d:] += torque
        load[a, d:] -= torque
        return
    point, force = x[b, :d] + rotate(turns[1], arm), value * rotate(turns[0], axis)
    load[b] += row_of(force, point - x[b, :d])
    load[a] -= row_of(force, point - x[a, :d])
