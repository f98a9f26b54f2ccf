"""A scene: bodies with shapes, what they are made of, and gravity; `simulate` sets it in motion.

    scene = Scene(gravity=(0, 0, -9.81))             in space; gravity=(0, -9.81) makes a planar one
    scene.fixed(HalfSpace((0, 0, 1)))                stands still
    scene.body(Sphere(0.1), density=1000, ...)       moves by forces and impulses
    scene.kinematic(Box(1, 1, 0.1), velocity=...)    moves as it is told
    scene.joint("a", "b", at=(0, 0, 1))              two bodies share a point
    scene.hinge("a", "b", at=..., axis=(0, 1, 0))    or turn about an axis, slide along it, ... (joining.py)
    scene.spring("a", "b", stiffness=100.0)          pulls and pushes them
    scene.force("a", (1.0, 0, 0))                    acts on one

A scene is a description: it is not changed by a run, and may be run again.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from nonsmooth.checks.arrays import (
    as_fraction,
    as_instance,
    as_non_negative,
    as_number,
    as_positive,
    as_vector,
)
from nonsmooth.errors import InvalidInput, nearest, shown
from nonsmooth.mechanics.laws import FrictionLaw
from nonsmooth.mechanics.system import System
from nonsmooth.scenes.elements import Body, Force, Joint, Kind, Spring
from nonsmooth.scenes.elliptic_friction import EllipticFriction
from nonsmooth.scenes.inertia import as_inertia
from nonsmooth.scenes.joining import Joining
from nonsmooth.scenes.materials import Material, as_mu
from nonsmooth.scenes.ranges import as_mass, require_within
from nonsmooth.scenes.shapes import PLANAR, SPATIAL, Shape, as_spin, as_turn
from nonsmooth.views import view


@dataclass(eq=False)
class Scene(Joining):
    """Bodies that touch.

    Parameters
    ----------
    gravity : array_like (2,) or (3,)
        [m/s^2]; its length says whether the scene lies in the plane or in space.
    material : Material
        Of the bodies that name none.
    name : str
        For messages and titles.
    t_end, dt : float, optional
        End of a run and step that suit the scene [s]: `simulate`, studies, sweeps and commands take them where no span
        and no step are given.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> scene = ns.Scene(gravity=(0, -9.81))
    >>> ground = scene.fixed(ns.HalfPlane((0, 1)))
    >>> disc = scene.body(ns.Disc(0.1), density=1000, position=(0, 0.5))
    >>> scene
    Scene(planar, 2 bodies, 1 of them dynamic)
    """

    gravity: ArrayLike = (0.0, -9.81)
    material: Material = field(default_factory=Material)
    name: str = field(default="", kw_only=True)
    t_end: float | None = field(default=None, kw_only=True)
    dt: float | None = field(default=None, kw_only=True)

    __hash__ = None  # type: ignore[assignment]  # it grows: its system must not be kept as that of a model is

    def __post_init__(self) -> None:
        gravity = require_within("gravity", as_vector("gravity", self.gravity), "m/s^2")
        if len(gravity) not in (PLANAR, SPATIAL):
            raise InvalidInput(f"gravity must have 2 entries (planar) or 3 (spatial) [m/s^2]; got {len(gravity)}")
        self.gravity = gravity
        self.dim = len(gravity)
        as_instance("material", self.material, Material, "a Material(mu=..., e=...)")
        as_instance("name", self.name, str, "a text")
        self.t_end = None if self.t_end is None else as_positive("t_end", self.t_end, "s")
        self.dt = None if self.dt is None else as_positive("dt", self.dt, "s")
        self.built_from: dict[str, float] | None = None  # the numbers of what built it, by name
        self.not_understood: tuple[str, ...] = ()  # of the file of another program that it was read from
        self.bodies: list[Body] = []
        self.joints: list[Joint] = []
        self.forces: list[Force] = []
        self.springs: list[Spring] = []
        self.ignored: list[tuple[Body, Body]] = []
        self.pairs: dict[frozenset[str], tuple[float | FrictionLaw | None, float | None]] = {}
        self.resistances: dict[frozenset[str], dict[str, float]] = {}
        self._names: dict[str, int] = {}

    def body(
        self, shape: Shape, *, position: ArrayLike | None = None, turn: Any = None, velocity: ArrayLike | None = None,
        spin: Any = None, density: float | None = None, mass: float | None = None, inertia: Any = None,
        centre: ArrayLike | None = None, material: Material | None = None, surface_velocity: ArrayLike | None = None,
        name: str | None = None,
    ) -> Body:  # fmt: skip
        """Add a body that moves by forces and impulses.

        Parameters
        ----------
        shape : Shape
        position, turn, velocity, spin, surface_velocity, inertia, centre
            As those of `Body`; left out: 0, not turned, at rest, no belt, of the shape, of the shape.
        density, mass : float
            One of them: [kg/m^3], in the plane [kg/m^2], or [kg].
        material : Material, optional
            The scene's own if left out.
        name : str, optional
            "body 3" for the fourth if left out.

        Returns
        -------
        Body

        Raises
        ------
        InvalidInput
            For what breaks a rule, with the name of the body.
        """
        name = self._new_name(name)
        if (density is None) == (mass is None):
            raise InvalidInput(f"{name} needs either density= or mass=; got {'neither' if mass is None else 'both'}")
        given = {
            "density": None if density is None else as_positive(f"density of {name}", density, "kg/m^3"),
            "mass": None if mass is None else as_mass(f"mass of {name}", mass),
            "inertia": None if inertia is None else as_inertia(f"inertia of {name}", inertia, self.dim),
            "centre": self._vector(f"centre of {name}", centre, None),
            "surface_velocity": self._vector(f"surface_velocity of {name}", surface_velocity, None),
        }
        if centre is not None and inertia is None:
            raise InvalidInput(f"{name} has centre= without inertia=, which is about it; give both")
        self._check_shape(name, shape)
        if not shape.has_mass:
            raise InvalidInput(f"{name} has no mass, its shape is {shape!r}; add it by scene.fixed or scene.kinematic")
        return self._add(name, Kind.DYNAMIC, shape, material, position, turn, velocity, spin, given)

    def fixed(
        self, shape: Shape, *, position: ArrayLike | None = None, turn: Any = None, material: Material | None = None,
        surface_velocity: ArrayLike | None = None, name: str | None = None,
    ) -> Body:  # fmt: skip
        """Add a body that stands still; a surface velocity makes it a conveyor.

        Parameters and errors are those of `body`.
        """
        name = self._new_name(name)
        self._check_shape(name, shape)
        given = {"surface_velocity": self._vector(f"surface_velocity of {name}", surface_velocity, None)}
        return self._add(name, Kind.FIXED, shape, material, position, turn, None, None, given)

    def kinematic(
        self, shape: Shape, *, position: ArrayLike | None = None, turn: Any = None, velocity: ArrayLike | None = None,
        spin: Any = None, motion: Callable[[float], Any] | None = None, material: Material | None = None,
        surface_velocity: ArrayLike | None = None, name: str | None = None,
    ) -> Body:  # fmt: skip
        """Add a body that moves as it is told: evenly by ``velocity`` and ``spin``, or by a function of time.

        Parameters
        ----------
        motion : callable, optional
            t [s] -> position, or (position, turn), in place of position, turn, velocity and spin. Within a step the
            body moves evenly from one of its places to the next.
        shape, position, turn, velocity, spin, material, surface_velocity, name
            As those of `body`.
        """
        name = self._new_name(name)
        self._check_shape(name, shape)
        if motion is not None:
            if not all(value is None for value in (position, turn, velocity, spin)):
                raise InvalidInput(f"{name} takes either motion= or position=, turn=, velocity=, spin=; got both")
            if not callable(motion):
                raise InvalidInput(f"motion of {name} must be a function of the time [s]; got {shown(motion)}")
        given = {
            "motion": motion,
            "surface_velocity": self._vector(f"surface_velocity of {name}", surface_velocity, None),
        }
        return self._add(name, Kind.KINEMATIC, shape, material, position, turn, velocity, spin, given)

    def force(self, body: Body | str, value: Any, *, at: ArrayLike | None = None) -> Force:
        """Apply a force to a body, in addition to gravity and what touches it.

        Parameters
        ----------
        body : Body or str
            A dynamic body of this scene, or its name.
        value : (2,) or (3,) array_like, or callable
            In the axes of the world [N]: the same at all times, or a function f(t, bodies) that returns a force, or a
            pair (force, torque) [N m]; ``bodies["box"]`` has ``position``, ``turn``, ``velocity`` and ``spin``, as of
            `simulate`'s events. It is asked twice a step, for the middle of it; a torque in the plane is a number.
        at : (2,) or (3,), optional
            Where the force acts: a point that goes with the body, given where it is at the start [m]. The centre of
            mass, if left out.

        Returns
        -------
        Force

        Raises
        ------
        InvalidInput
            For a body that is not there or does not move by forces, and a value that is none.

        Examples
        --------
        >>> import nonsmooth as ns
        >>> scene = ns.Scene(gravity=(0, 0))
        >>> scene.body(ns.Disc(0.1), mass=2.0, name="puck")
        Body('puck', dynamic, Disc(radius=0.1))
        >>> scene.force("puck", (4.0, 0.0))
        Force('puck', [4. 0.])
        >>> ns.simulate(scene, (0, 1), integrator=ns.MoreauJean(0.01))["puck"].velocity[-1].round(12).tolist()
        [2.0, 0.0]
        """
        owner = self._own("a force", body, "acts on")
        if owner.kind is not Kind.DYNAMIC:
            raise InvalidInput(f"a force acts on {owner.name}, which no force moves; it must be dynamic")
        name = f"the force on {owner.name}"
        if not callable(value):
            value = require_within(name, as_vector(name, value, self.dim), "N")
        place = None if at is None else require_within(f"at of {name}", as_vector(f"at of {name}", at, self.dim), "m")
        force = Force(owner, value, place)
        self.forces.append(force)
        return force

    def spring(
        self, a: Body | str, b: Body | str, *, at_a: ArrayLike | None = None, at_b: ArrayLike | None = None,
        stiffness: float = 0.0, damping: float = 0.0, length: float | None = None, name: str | None = None,
    ) -> Spring:  # fmt: skip
        """Put a spring with a damper between points of two bodies: it pulls with k (l - l_0) + c dl/dt along its line.

        It is implicit in the step: the stiffest one needs no smaller step to stay stable, and one that is not resolved
        loses no energy to that. The two bodies still touch.

        Parameters
        ----------
        a, b : Body or str
            Bodies of this scene, or their names; one of them may be fixed or kinematic.
        at_a, at_b : (2,) or (3,), optional
            The ends, points that go with their bodies, where they are at the start [m]; the centres of mass, if left
            out.
        stiffness, damping : float
            k [N/m] and c [N s/m]; one of them must not be 0.
        length : float, optional
            l_0 [m]; that at the start, if left out. One of length 0 is k and c times the vectors between its ends.
        name : str, optional
            "spring 2" for the third if left out.

        Returns
        -------
        Spring

        Raises
        ------
        InvalidInput
            For bodies that are not there, one and the same or not moved by forces, and numbers that are negative, or
            both 0.

        Examples
        --------
        >>> import nonsmooth as ns
        >>> scene = ns.Scene(gravity=(0, -10.0))
        >>> hook = scene.fixed(ns.Disc(0.01), position=(0, 1), name="hook")
        >>> bob = scene.body(ns.Disc(0.1), mass=2.0, name="bob")
        >>> scene.spring("hook", "bob", stiffness=100.0, damping=40.0)
        Spring('spring 0', 'hook', 'bob', 100, 40)
        >>> rest = ns.simulate(scene, (0, 10), integrator=ns.MoreauJean(0.01))["bob"].position[-1]
        >>> rest.round(9).tolist()  # m g/k below where it began
        [0.0, -0.2]
        """
        return self._add_spring(a, b, at_a, at_b, stiffness, damping, length, name)

    def torsion_spring(
        self, a: Body | str, b: Body | str, *, stiffness: float = 0.0, damping: float = 0.0,
        angle: float | None = None, name: str | None = None,
    ) -> Spring:  # fmt: skip
        """Put a torsion spring with a damper between two bodies of the plane: a torque k (phi - phi_0) + c dphi/dt.

        phi is the angle of b against that of a. With a joint of the same bodies it is one of a hinge.

        Parameters
        ----------
        a, b, name
            As of `spring`.
        stiffness, damping : float
            k [N m/rad] and c [N m s/rad]; one of them must not be 0.
        angle : float, optional
            phi_0 [rad]; that at the start, if left out.

        Returns
        -------
        Spring

        Raises
        ------
        InvalidInput
            As of `spring`, and in space, where bodies have no one angle.
        """
        if self.dim != PLANAR:
            raise InvalidInput("a torsion spring is one of bodies in the plane; in space give two springs with arms")
        return self._add_spring(a, b, None, None, stiffness, damping, angle, name, is_torsion=True)

    def _add_spring(
        self, a: Any, b: Any, at_a: Any, at_b: Any, stiffness: Any, damping: Any, length: Any, name: Any,
        is_torsion: bool = False,
    ) -> Spring:  # fmt: skip
        """A spring, checked."""
        name = f"spring {len(self.springs)}" if name is None else as_instance("name of a spring", name, str, "a text")
        if any(spring.name == name for spring in self.springs):
            raise InvalidInput(f"there is a spring {name!r} already; names of springs must differ")
        first, second = (self._own(name, body) for body in (a, b))
        if first is second:
            raise InvalidInput(f"{name} joins {first.name} to itself; a spring is one of two bodies")
        if Kind.DYNAMIC not in (first.kind, second.kind):
            raise InvalidInput(f"{name} joins {first.name} and {second.name}, and no force moves either")
        k = as_non_negative(f"stiffness of {name}", stiffness)
        c = as_non_negative(f"damping of {name}", damping)
        if k == c == 0.0:
            raise InvalidInput(f"{name} needs stiffness= or damping=; got neither")
        ends = [None if at is None else self._vector(f"at of {name}", at) for at in (at_a, at_b)]
        if length is not None:
            as_length = as_number if is_torsion else as_non_negative
            length = as_length(f"{'angle' if is_torsion else 'length'} of {name}", length)
        spring = Spring(name, first, second, ends[0], ends[1], k, c, length, is_torsion)
        self.springs.append(spring)
        return spring

    def ignore(self, *bodies: Body | str) -> None:
        """Let bodies pass through one another, each through each of the others; those that a joint holds do so anyway.

        Parameters
        ----------
        *bodies : Body or str
            Two or more of this scene, or their names.

        Raises
        ------
        InvalidInput
            For fewer than two, for one that is not there, and for one that is named twice.

        Examples
        --------
        >>> import nonsmooth as ns
        >>> scene = ns.Scene(gravity=(0, -9.81))
        >>> ground = scene.fixed(ns.HalfPlane((0, 1)), name="ground")
        >>> ghost = scene.body(ns.Disc(0.1), mass=1.0, position=(0, 0.1), name="ghost")
        >>> scene.ignore("ground", "ghost")
        >>> ns.simulate(scene, (0, 1), integrator=ns.MoreauJean(dt=0.01))["ghost"].position[-1].round(3).tolist()
        [0.0, -4.805]
        """
        own = [self._own("ignore", body, "ignores") for body in bodies]
        if len(own) < 2 or len({body.name for body in own}) < len(own):
            raise InvalidInput(
                f"ignore takes two or more bodies, each once; got {', '.join(body.name for body in own) or 'none'}"
            )
        known = self.apart()
        self.ignored += [pair for pair in combinations(own, 2) if frozenset(pair) not in known]

    def apart(self) -> set[frozenset[Body]]:
        """The pairs of bodies that pass through one another."""
        held = {frozenset((joint.a, joint.b)) for joint in self.joints if not joint.is_tie}
        return held | {frozenset(pair) for pair in self.ignored}

    def pair(
        self, a: Material | str, b: Material | str, *, mu: float | FrictionLaw | None = None, e: float | None = None,
        rolling: float | None = None, spinning: float | None = None, adhesion: float | None = None,
    ) -> None:  # fmt: skip
        """Give two materials coefficients of their own.

        Parameters
        ----------
        a, b : Material or str
            Materials of bodies of this scene, or their names.
        mu : float or FrictionLaw, optional
        e : float, optional
        rolling, spinning, adhesion : float, optional
            As of `Material`. What is left out stays as it was, or goes by the rule of `Material`.

        Raises
        ------
        InvalidInput
            For a material without a name, a coefficient that breaks its rule, and none at all.
        """
        names = frozenset(self._material_name(material) for material in (a, b))
        asked = {"rolling": rolling, "spinning": spinning, "adhesion": adhesion}
        given = {what: as_non_negative(what, value) for what, value in asked.items() if value is not None}
        if mu is e is None and not given:
            raise InvalidInput(
                f"the pair {', '.join(sorted(names))} needs mu=, e=, rolling=, spinning= or adhesion=; got none"
            )
        if given:
            self.resistances[names] = self.resistances.get(names, {}) | given
        if mu is None and e is None:
            return
        own_mu, own_e = self.pairs.get(names, (None, None))
        self.pairs[names] = (
            own_mu if mu is None else as_mu(mu),
            own_e if e is None else as_fraction("e", e),
        )

    @classmethod
    def load(cls, path: str | Path, **values: float) -> Scene:
        """Read a scene from a file, with other values by name.

        Parameters
        ----------
        path : path-like
            A TOML file, as ``save`` writes it, or by hand with formulas and repetition; a model of MuJoCo (``.xml``,
            ``.mjcf``), or a URDF (``.urdf``): docs/scenes.md. What a scene does not have of such a one gives a
            `NotUnderstoodWarning`, and stands in ``not_understood``, a sentence each.
        **values : float
            In the place of those of its table ``values``; of MJCF and URDF the controls of motors, 0 if left out.

        Raises
        ------
        InvalidInput
            For a file that cannot be read, a value that it does not have, and what breaks a rule of a body, a joint,
            ..., with the file, the table and its line.
        """
        return view(cls, "load")(path, **values)  # type: ignore[no-any-return]

    def save(self, path: str | Path) -> None:
        """Write the scene into a file from which ``load`` makes it again, to the last bit.

        Raises
        ------
        InvalidInput
            For what a file cannot hold: motions, forces and laws of friction that are functions.
        FileFailure
            Where the file cannot be written.

        Examples
        --------
        >>> import nonsmooth as ns
        >>> scene = ns.Scene(gravity=(0, -9.81), name="falls")
        >>> disc = scene.body(ns.Disc(0.1), mass=1.0, position=(0, 0.5), name="disc")
        >>> scene.save("falls.toml")
        >>> ns.Scene.load("falls.toml").bodies
        [Body('disc', dynamic, Disc(radius=0.1))]
        """
        view(self, "save")(self, path)

    def system(self, pairs: Any = None) -> System:
        """A small scene as a `System`, for Adaptive, EventDriven, `classify`, `limit_cycle` and their like.

        The coordinates are (x, y, angle) of the centres of mass of the dynamic bodies, in order; ``state()`` is where
        they start. Each vertex of a body has a contact with each half-plane, and each disc with each disc, whether they
        ever touch or not: it is for few bodies. In space spheres without friction have the coordinates (x, y, z); other
        bodies have seven, with the unit quaternion of their principal axes, along which the angular velocity is, and
        the round cone: `MoreauJean`, `classify`, `critical_friction` and `paradox_map` take it.

        Parameters
        ----------
        pairs : list of (str, str), optional
            Names of the bodies that may touch, all others pass through one another; all, if left out.

        Returns
        -------
        System
            Its parameters are mu_a_b and e_a_b of bodies a and b, of the earlier one first unless pairs says otherwise;
            no mu where there is no friction.

        Raises
        ------
        InvalidInput
            For bodies that move as a function says, half-planes that turn, and pairs that touch along faces: hulls with
            one another, segments. In space, for joints, guided bodies, and shapes without corners that are no spheres.

        Examples
        --------
        >>> import nonsmooth as ns
        >>> scene = ns.Scene(gravity=(0, -9.81), material=ns.Material(mu=2.0))
        >>> ground = scene.fixed(ns.HalfPlane((0, 1)), name="ground")
        >>> rod = scene.body(ns.Capsule(1.0, 1e-6), mass=1.0, name="rod", position=(0, 0.4330137), turn=1.0471975512,
        ...                  velocity=(-1, 0))
        >>> system = scene.system([("rod", "ground")])
        >>> system
        System('scene', n_q=3, n_c=2)
        >>> solution = ns.simulate(system, (0, 0.01), *scene.state(), integrator=ns.EventDriven())
        """
        return view(self, "system")(self, pairs)

    def state(self) -> tuple[np.ndarray, np.ndarray]:
        """q0 and u0 of ``system()``: coordinates of the dynamic bodies' centres of mass, and their rates.

        Raises
        ------
        InvalidInput
            For a scene without a system.
        """
        return view(self, "state")(self)

    def __getitem__(self, name: str) -> Body:
        if not isinstance(name, str) or name not in self._names:
            raise InvalidInput(f"there is no body {shown(name)}; {nearest(name, self._names)}")
        return self.bodies[self._names[name]]

    def __len__(self) -> int:
        return len(self.bodies)

    def __iter__(self) -> Iterator[Body]:
        return iter(self.bodies)

    @property
    def parameter_values(self) -> dict[str, float]:
        """The numbers of what built the scene, by name; of one that was built by hand its gravity [m/s^2] and, where
        all its bodies have the same, mu and e of its material."""
        if self.built_from is not None:
            return self.built_from
        materials = {body.material for body in self.bodies}
        surface = materials.pop() if len(materials) == 1 and not self.pairs | self.resistances else None
        of_surface = {} if surface is None else {"mu": surface.mu, "e": surface.e}
        numbers = {name: value for name, value in of_surface.items() if isinstance(value, float)}
        return {"g": float(np.linalg.norm(self.gravity)), **numbers}

    def __repr__(self) -> str:
        dynamic = sum(body.kind is Kind.DYNAMIC for body in self.bodies)
        where = "planar" if self.dim == PLANAR else "spatial"
        bodies = f"{len(self.bodies)} {'body' if len(self.bodies) == 1 else 'bodies'}"
        joints = f", {len(self.joints)} {'joint' if len(self.joints) == 1 else 'joints'}" if self.joints else ""
        return f"Scene({self.name + ': ' if self.name else ''}{where}, {bodies}, {dynamic} of them dynamic{joints})"

    def _add(
        self, name: str, kind: Kind, shape: Shape, material: Material | None, position: Any, turn: Any, velocity: Any,
        spin: Any, given: dict[str, Any],
    ) -> Body:  # fmt: skip
        own = self.material if material is None else material
        own = as_instance(f"material of {name}", own, Material, "a Material(mu=..., e=...)")
        if self.dim == PLANAR and isinstance(own.mu, EllipticFriction):
            raise InvalidInput(f"{name} lies in the plane, where friction has one direction; give a number as its mu")
        body = Body(
            name, len(self.bodies), kind, shape, own,
            self._vector(f"position of {name}", position), as_turn(f"turn of {name}", turn, self.dim),
            self._vector(f"velocity of {name}", velocity), as_spin(f"spin of {name}", spin, self.dim), **given,
        )  # fmt: skip
        self._names[name] = body.index
        self.bodies.append(body)
        return body

    def _own(self, name: str, body: Any, does: str = "joins") -> Body:
        """A body of this scene, from itself or its name."""
        if isinstance(body, Body):
            if body.index < len(self.bodies) and self.bodies[body.index] is body:
                return body
            raise InvalidInput(f"{name} {does} {body.name}, a body of another scene")
        if not isinstance(body, str) or body not in self._names:
            raise InvalidInput(
                f"{name} {does} {shown(body)}, which is no body of the scene; {nearest(body, self._names)}"
            )
        return self.bodies[self._names[body]]

    def _vector(self, name: str, value: Any, default: float | None = 0.0) -> Any:
        if value is None:
            return None if default is None else np.full(self.dim, default)
        return require_within(name, as_vector(name, value, self.dim), "in SI units")

    def _new_name(self, name: str | None) -> str:
        if name is None:
            name = f"body {len(self.bodies)}"
        if not isinstance(name, str) or not name:
            raise InvalidInput(f"the name of a body must be a text; got {shown(name)}")
        if name in self._names:
            raise InvalidInput(f"there is a body {name!r} already; names of bodies must differ")
        return name

    def _check_shape(self, name: str, shape: Any) -> None:
        as_instance(f"shape of {name}", shape, Shape, "a shape, as ns.Box(0.2, 0.2) is")
        if self.dim not in shape.dim:
            here, there = ("plane", "space") if self.dim == PLANAR else ("space", "plane")
            raise InvalidInput(f"{name} has a shape of the {there}, {shape!r}, and the scene is one of the {here}")

    def _material_name(self, material: Any) -> str:
        name = material.name if isinstance(material, Material) else material
        if not isinstance(name, str) or not name:
            raise InvalidInput(
                f"a pair is one of materials with names, as ns.Material(mu=0.8, name='rubber'); got {shown(material)}"
            )
        return name
