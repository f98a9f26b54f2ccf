"""What a user types, checked: coordinates, parameters, bodies, energies, forces, contacts, lines of the picture."""

from __future__ import annotations

import keyword
from dataclasses import replace
from typing import Any

import sympy as sp

from nonsmooth.checks.arrays import as_flag, as_fraction, as_instance, as_listed, as_name, as_number, as_positive
from nonsmooth.errors import InvalidInput, NonsmoothWarning, UnknownName, nearest, shown, warn_caller
from nonsmooth.mechanics.laws import IMPACT_LAWS, Coulomb, Friction, Polynomial, Smoothed, StaticKinetic, Stribeck
from nonsmooth.symbolic import coordinate
from nonsmooth.symbolic.contact import TypedContact, declared_contact
from nonsmooth.symbolic.expressions import Expressions
from nonsmooth.symbolic.law_source import source_of_law
from nonsmooth.symbolic.parts import Declared, Force, Parameter, Turning, Weighted
from nonsmooth.symbolic.rotation import Rotation
from nonsmooth.symbolic.units import dimension

TAKEN = {  # time, and the names of what a model has
    "t", "system", "state", "shape", "outline", "source", "save", "name", "coordinates", "t_end", "dt",
    "natural_state", "map_axes", "critical_friction", "self", "np", "math", "as_number",
}  # fmt: skip
LEFT_OUT = ("0.0", "False", "None", "''")  # values that the arguments of `Contact` have by themselves
LAWS = (Coulomb, Polynomial, Smoothed, StaticKinetic, Stribeck)


class Lagrangian:
    """A system by its energies; made by `nonsmooth.lagrangian`.

    Attributes
    ----------
    name : str
    t : Symbol
        Time, for what moves by itself.
    declared : Declared
        What was typed so far.
    """

    def __init__(self, name: str) -> None:
        self.name = as_instance("name", name, str, "a text")
        if not any(character.isascii() and character.isalpha() for character in name):
            raise InvalidInput(f"name must have letters, it names the class of the model; got {shown(name)}")
        self.t = sp.Symbol("t", real=True)
        self.declared = Declared(t=self.t)
        self.parameter_fields: dict[Any, Parameter] = {}
        self.coordinate_units: dict[Any, str] = {}
        self.laws: list[str] = []  # functions of friction laws
        self.starts: dict[str, float] = {}
        self._gravity: tuple[Any, tuple[Any, ...]] | None = None  # g, and its direction or nothing: downward
        self._masses: list[tuple[Any, tuple[Any, ...]]] = []
        self.expressions = Expressions(self)

    # symbols

    def coordinates(self, names: str, unit: str = "") -> Any:
        """Generalised coordinates, in the order of q: a tuple of symbols; of a single name the symbol itself, which a
        tuple of one takes too.

        Parameters
        ----------
        names : str
            Such as ``"x y"``; the rates are called ``xdot``, ``ydot``.
        unit : str
            Of each of them, such as ``"m"`` or ``"rad"``; left out, units are not checked where it occurs.
        """
        words = as_instance("names", names, str, "a text such as 'x y'").replace(",", " ").split()
        if not words:
            raise InvalidInput(f"names must have at least one coordinate; got {shown(names)}")
        dimension(as_instance("unit", unit, str, "a text"))
        made = []
        for word in words:
            self._require_new(word)
            self._require_new(f"{word}dot")
            symbol = coordinate.Symbol(word, real=True)
            self.declared.q.append(symbol)
            self.declared.u.append(sp.Symbol(f"{word}dot", real=True))
            self.coordinate_units[symbol] = unit
            made.append(symbol)
        return tuple(made) if len(made) > 1 else made[0]

    def parameters(self, **values: Any) -> tuple[Any, ...]:
        """Parameters, the fields of the model: ``m=1.0``, ``m=(1.0, "kg")`` or ``m=(1.0, "kg", "mass of the bob")``."""
        return tuple(self.parameter(name, value) for name, value in values.items())

    def parameter(self, name: str, value: Any) -> Any:
        """One parameter; ``value`` as in `parameters`."""
        self._require_new(name)
        number, unit, doc = (
            (*value, "", "")[:3] if isinstance(value, tuple) and 1 <= len(value) <= 3 else (value, "", "")
        )
        for text in (unit, doc):
            as_instance(f"what stands beside the value of {name}", text, str, "its unit and what it is, two texts")
        dimension(unit)
        symbol = sp.Symbol(name, real=True)
        self.parameter_fields[symbol] = Parameter(name, as_number(f"the parameter {name}", number, unit), unit, doc)
        return symbol

    def _require_new(self, name: Any) -> None:
        if not (isinstance(name, str) and name.isidentifier() and name.isascii()) or keyword.iskeyword(name):
            raise InvalidInput(f"a name must be one that Python can read, such as th1; got {shown(name)}")
        if name in TAKEN or name.startswith("_"):
            raise InvalidInput(
                f"{name} cannot be the name of a coordinate or parameter: a model has it already, or it is private"
            )
        if name in {str(symbol) for symbol in self.symbols}:
            raise InvalidInput(f"{name} is declared twice, or is the rate of a coordinate: choose another name")

    @property
    def symbols(self) -> list[Any]:
        """All that an expression may read."""
        return [*self.declared.q, *self.declared.u, *self.parameter_fields, self.t]

    @property
    def rates(self) -> tuple[Any, ...]:
        """The velocities u = q' of the coordinates declared so far."""
        return tuple(self.declared.u)

    def rate(self, of: Any) -> Any:
        """The rate of an expression or a vector along the motion, at any velocity: a velocity, of positions."""
        if isinstance(of, list | tuple | sp.MatrixBase):
            return tuple(self.rate(entry) for entry in of)
        expression = self.expressions.of_state("an expression", of)
        slopes = zip(self.declared.q, self.declared.u, strict=True)
        return sp.Add(*(expression.diff(q) * u for q, u in slopes), expression.diff(self.t))

    def start(self, **values: float) -> None:
        """Default coordinates and rates of ``state()``, by name; what is not named is zero."""
        known = [str(symbol) for symbol in (*self.declared.q, *self.declared.u)]
        for name, value in values.items():
            if name not in known:
                raise UnknownName(f"there is no coordinate or rate {name!r}; {nearest(name, known)}")
            self.starts[name] = as_number(name, value)

    # energies

    def point_mass(self, m: Any, at: Any) -> None:
        """A mass [kg] at a position of two or three components [m]."""
        mass = self.expressions.of_parameters("m", m, "kg")
        self._masses.append((mass, self.expressions.vector("at", at, "m")))

    def rigid_body(self, m: Any, I: Any, at: Any, angle: Any = None, rotation: Rotation | None = None) -> None:
        """A rigid body: its centre of mass, and how it turns.

        Parameters
        ----------
        m : expression
            Mass [kg].
        I : expression
            Central moment of inertia [kg m^2]; in space three principal ones or a (3, 3) matrix, in the body's frame.
        at : sequence
            Position of the centre, two components, or three [m].
        angle : expression
            Of a planar body [rad].
        rotation : Rotation
            Of a spatial one, from `rotation`.
        """
        if (angle is None) == (rotation is None):
            raise InvalidInput("a rigid body needs angle=, in the plane, or rotation=, in space: one of the two")
        mass = self.expressions.of_parameters("m", m, "kg")
        at = self.expressions.vector("at", at, "m")
        if rotation is None:
            I = self.expressions.of_parameters("I", I, "kg m^2")
            turning: Any = Weighted(I, self.expressions.of_configuration("angle", angle, "rad"), sp.S.Zero)
        else:
            as_instance("rotation", rotation, Rotation, "what rotation(...) returns")
            turning = Turning(self._inertia(I), rotation.omega)
        self._masses.append((mass, at))
        self.declared.energies.append(turning)

    def _inertia(self, I: Any) -> tuple[tuple[Any, ...], ...]:
        rows = as_listed(
            "I", I.tolist() if isinstance(I, sp.MatrixBase) else I, "three moments of inertia or a matrix (3, 3)"
        )
        if len(rows) != 3:
            raise InvalidInput(f"I must be three moments of inertia or a matrix (3, 3) in space; got {shown(I)}")
        if not isinstance(rows[0], list | tuple):
            rows = [[rows[a] if a == b else 0 for b in range(3)] for a in range(3)]
        return tuple(
            tuple(self.expressions.of_parameters("I", rows[a][b], "kg m^2") for b in range(3)) for a in range(3)
        )

    def rotation(self, axes: str, angles: Any) -> Rotation:
        """A rotation in space by three angles about axes of the turning body, such as ``"zxz"`` with (phi, th, psi).

        The coordinates are these angles themselves, since q' = u: a sequence has two places where they are none
        (th = 0 of zxz, th = pi/2 of xyz), and a motion must stay away from them.
        """
        angles = self.expressions.vector("angles", angles, "rad")
        if not isinstance(axes, str) or len(axes) != len(angles) or not 1 <= len(axes) <= 3 or {*axes} - {*"xyz"}:
            raise InvalidInput(f"axes must be a letter x, y or z for each angle, such as 'zxz'; got {shown(axes)}")
        if any(axis == other for axis, other in zip(axes, axes[1:], strict=False)):
            raise InvalidInput(f"two axes that follow each other must differ; got {axes!r}")
        return Rotation(axes, angles, tuple(self.rate(angle) for angle in angles))

    def kinetic(self, energy: Any) -> None:
        """A kinetic energy as it is typed, quadratic in the rates [J]."""
        self.declared.kinetic.append(self.expressions.of_state("the kinetic energy", energy, "J"))

    def potential(self, energy: Any) -> None:
        """A potential energy, of coordinates and time [J]."""
        self.declared.potentials.append(self.expressions.of_configuration("the potential energy", energy, "J"))

    def gravity(self, g: Any, direction: Any = None) -> None:
        """Gravity on all point masses and bodies [m/s^2], against the last axis when no direction is given."""
        if self._gravity is not None:
            raise InvalidInput("gravity was declared already: its direction may have several components")
        along = () if direction is None else self.expressions.vector("direction", direction)
        self._gravity = self.expressions.of_parameters("g", g, "m/s^2"), along

    def dissipation(self, power: Any) -> None:
        """Rayleigh's function R of the rates, with the force -dR/du: half the power that is lost [W]."""
        self.declared.dissipations.append(self.expressions.of_state("the dissipation", power, "W"))

    def force(self, vector: Any, at: Any) -> None:
        """A force [N] on a point, given by its position, or a moment [N m] on an angle; it may read the rates."""
        is_single = not isinstance(at, list | tuple | sp.MatrixBase)
        position = self.expressions.vector("at", (at,) if is_single else at)
        force = self.expressions.vector("vector", (vector,) if is_single else vector, rates=True)
        if len(position) != len(force):
            raise InvalidInput(f"a force needs a component for each of its point; got {len(force)} for {len(position)}")
        for r, component in zip(position, force, strict=True):
            self.expressions.require_unit("the work of a force", r * component, "J")
        self.declared.forces.append(Force(position, force))

    # contacts

    def contact(
        self, point: Any = None, normal: Any = None, offset: Any = 0, *, gap: Any = None, tangent: Any = None,
        surface: Any = None, slip: Any = None, normal_force: Any = None, bilateral: bool = False,
        mu: Any = 0, e: Any = 0, e_F: Any = 0, impact: str | None = None, name: str = "",
    ) -> None:  # fmt: skip
        """A contact: a point at a plane, or a gap and a sliding velocity of its own.

        Parameters
        ----------
        point, normal, offset : sequence, sequence, expression
            g_N = normal.point + offset [m], with a normal of length 1 that points away from the obstacle.
        gap : expression, instead
            g_N itself, of coordinates and time [m].
        tangent : sequence
            Direction of sliding; in the plane (n_y, -n_x) when left out.
        surface : sequence
            Velocity of the obstacle's surface [m/s].
        slip : expression, instead of tangent and surface
            gamma_F itself, linear in the rates [m/s]: where the point of contact wanders on the body.
        normal_force : expression, instead of a gap
            Friction only, under this force [N], where it is positive.
        bilateral : bool
            Keeps g_N = 0; a holonomic constraint is a bilateral contact without friction.
        mu, e, e_F, impact, name
            As in `nonsmooth.Contact`: numbers, parameters, or for mu a friction law. The function of a `Friction` is
            written into the source of the model; what it reads are v, the parameters p, and ``math``.
        """
        arguments = self._contact_arguments(bilateral, normal_force is not None, mu, e, e_F)
        if impact is not None:
            as_name("impact law", impact, IMPACT_LAWS)
        as_instance("the name of a contact", name, str, "a text")
        words = {"impact": repr(impact), "name": repr(name)}
        arguments = ", ".join(filter(None, [arguments, *listed_arguments(words)]))
        typed = TypedContact(point, normal, offset, gap, tangent, surface, slip, normal_force)
        number = len(self.declared.contacts)
        self.declared.contacts.append(declared_contact(self.expressions, typed, arguments, number))

    def constraint(self, of: Any) -> None:
        """A holonomic constraint, of = 0: a bilateral contact without friction."""
        self.contact(gap=of, bilateral=True)

    def _contact_arguments(self, bilateral: bool, is_given: bool, mu: Any, e: Any, e_F: Any) -> str:
        """The arguments of `Contact` as Python."""
        as_flag("bilateral", bilateral)
        if bilateral and is_given:
            raise InvalidInput("a contact is either bilateral or has a given normal force; both were asked for")
        words = {
            "mu": self._friction(mu),
            "e_N": self._coefficient("e", e),
            "e_F": self._coefficient("e_F", e_F),
            "bilateral": repr(bool(bilateral)),
            "normal_force": repr(is_given),
        }
        return ", ".join(listed_arguments(words))

    def _friction(self, mu: Any) -> str:
        """A coefficient or a law as Python; the function of a law of the user's is kept for the source."""
        if not isinstance(mu, Friction):
            return repr(mu) if type(mu) in LAWS else self._coefficient("mu", mu)
        name = f"friction_law_{len(self.laws)}"
        self.laws.append(source_of_law(mu, name))
        return f"Friction({name})"

    def _coefficient(self, name: str, value: Any) -> str:
        if isinstance(value, sp.Symbol) and value in self.parameter_fields:
            return repr(str(value))
        if isinstance(value, sp.Basic) and not value.is_Number:
            raise InvalidInput(
                f"{name} of a contact must be a number, a parameter or a friction law; got {shown(value)}"
            )
        number = as_number(name, value)
        if name != "mu":
            as_fraction(name, number)
        elif number < 0:
            raise InvalidInput(f"mu must not be negative; got {number:g}")
        return repr(number)

    # picture

    def line(self, *points: Any) -> None:
        """A polyline through points of the plane [m], for pictures: of a body, or of what stands still.

        Pictures know no time: points that move with it are drawn where they are at t = 0, and a warning says so.
        """
        corners = [self.expressions.vector("a point of a line", point, "m") for point in points]
        if len(corners) < 2:
            raise InvalidInput(f"a line needs at least two points; got {len(corners)}")
        if any(part.has(self.t) for corner in corners for part in corner):
            warn_caller("points of a line move with time: pictures draw them where they are at t = 0", NonsmoothWarning)
        self.declared.lines.append(tuple((corner[0], corner[1]) for corner in corners))

    def complete(self) -> Declared:
        """All that was declared, with the masses as weighted components of their positions."""
        weighted = []
        for mass, at in self._masses:
            pull = self._pull(len(at))
            weighted += [Weighted(mass, r, g) for r, g in zip(at, pull, strict=True)]
        return replace(self.declared, energies=[*weighted, *self.declared.energies])

    def _pull(self, size: int) -> tuple[Any, ...]:
        """The components of gravity in the plane or in space."""
        if self._gravity is None:
            return (sp.S.Zero,) * size
        g, along = self._gravity
        if not along:
            return (*(sp.S.Zero,) * (size - 1), -g)
        if len(along) != size:
            raise InvalidInput(f"gravity has {len(along)} components, the position of a body {size}: they must agree")
        return tuple(g * part for part in along)

    # results

    def equations(self, jacobians: bool = True) -> Any:
        """The derived matrices as SymPy expressions, see `Matrices`: to be looked at, or printed as LaTeX."""
        from nonsmooth.symbolic.matrices import Matrices

        return Matrices(self, as_flag("jacobians", jacobians))

    def model(self, jacobians: bool = True, t_end: float = 1.0, dt: float = 1e-3) -> Any:
        """The model: a frozen dataclass of its own whose fields are the parameters.

        Parameters
        ----------
        jacobians : bool
            Whether K = -dh/dq and C = -dh/du are derived too; the step is linearly implicit in h then.
        t_end, dt : float
            A sensible duration and step of it [s].

        Raises
        ------
        InvalidInput
            For what cannot be a system: the message says which quantity, and why.
        """
        from nonsmooth.symbolic.model_file import derived_model

        return derived_model(
            self, as_flag("jacobians", jacobians), as_positive("t_end", t_end, "s"), as_positive("dt", dt, "s")
        )


def listed_arguments(words: dict[str, str]) -> list[str]:
    """Arguments of `Contact` that differ from what it has by itself."""
    return [f"{key}={word}" for key, word in words.items() if word not in LEFT_OUT]
