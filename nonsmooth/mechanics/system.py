"""The mechanical system: plain functions, parameters, contacts.

Equation of motion, with q' = B(t, q) u, and B = 1 where nothing else is said:

    M(t, q) du = h(t, q, u) dt + W_N^T dP_N + W_F^T dP_F
    gamma_N = W_N u + w_N,    gamma_F = W_F u + w_F

Source: Moreau, *Unilateral contact and dry friction in finite freedom dynamics* (1988); Glocker, *Set-Valued Force
Laws* (2001). The symbols are those of docs/notation.md.
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, fields, replace
from enum import IntEnum
from typing import Any

import numpy as np

from nonsmooth.checks.arrays import as_count, as_flag, as_fraction, as_instance, as_name, as_positive
from nonsmooth.checks.parameters import constant_fields, layout_of, numeric_fields, with_changes
from nonsmooth.errors import InvalidInput, said_by, shown
from nonsmooth.jit import Unpack, unpack_of
from nonsmooth.jit.watch import Watch
from nonsmooth.mechanics.derived_rows import derived, watch_on
from nonsmooth.mechanics.description import Description, as_names, described, require_drawn
from nonsmooth.mechanics.laws import (
    IMPACT_LAWS,
    LAW_E_N,
    LAW_IMPACT,
    LAW_WIDTH,
    Coefficient,
    Friction,
    FrictionLaw,
    ImpactLaw,
    as_law,
    law_row,
)
from nonsmooth.mechanics.own_law import own_laws, require_values, write_handles
from nonsmooth.mechanics.returned import writing
from nonsmooth.mechanics.signatures import is_hashable, reads_argument, require_arguments, returns_values, takes

# The model functions, in the order of the ``which`` argument of the compiled model.
MASS, FORCE, GAP, NORMAL, TANGENT, SURFACE_VELOCITY, GAP_RATE, ROW_RATES = range(8)
STIFFNESS, DAMPING, POTENTIAL, NORMAL_FORCE, KINEMATICS = range(8, 13)

TAKES_U = {FORCE, ROW_RATES, STIFFNESS, DAMPING, NORMAL_FORCE}
FUNCTION_NAMES = {
    "mass": MASS,
    "force": FORCE,
    "gap": GAP,
    "normal": NORMAL,
    "tangent": TANGENT,
    "surface_velocity": SURFACE_VELOCITY,
    "gap_rate": GAP_RATE,
    "row_rates": ROW_RATES,
    "stiffness": STIFFNESS,
    "damping": DAMPING,
    "potential": POTENTIAL,
    "normal_force": NORMAL_FORCE,
    "kinematics": KINEMATICS,
}
NAMES = {which: name for name, which in FUNCTION_NAMES.items()}

UNILATERAL, BILATERAL, GIVEN_FORCE = 0, 1, 2  # code: kinds of contact


class ContactMode(IntEnum):
    """What a contact does during a step. The direction of sliding is kept apart, in ``Solution.slip``."""

    OPEN = 0  # no impulse
    STICK = 1  # gamma_N = 0, gamma_F = 0
    SLIDE = 2  # gamma_N = 0, friction at its limit
    LOCKED = 3  # gamma_N = 0 and no friction in the contact's law


@dataclass(frozen=True)
class Contact:
    """One contact of a system.

    Parameters
    ----------
    mu : float, str or FrictionLaw
        Friction coefficient, or law mu(|gamma_F|), ``Friction(mu)`` for one of your own; a string names a parameter.
        Zero: frictionless, no tangential rows.
    e_N, e_F : float or str
        Restitution coefficients in [0, 1]; Newton's gamma_plus = -e gamma_minus unless ``impact`` says otherwise.
    bilateral : bool
        Keeps g_N = 0: the normal force may have either sign, and |P_F| <= mu |P_N|.
    normal_force : bool
        Friction only, under the force ``normal_force(t, q, u, p, N)``: |P_F| <= mu dt max(N, 0); no gap, no W_N.
    impact : {"newton", "poisson", "energetic", "sequential"}, optional
        What e_N is a ratio of: velocities, impulses, or works (e_N^2). Newton's when left out, and a run in which it
        rebounds several coupled contacts at once warns; "newton" is his law as a choice, without the warning. Several
        contacts hit at once are decided together by the first three: "poisson" with one e_N, "energetic" as springs of
        equal stiffness, compressed and given back each in its own time, with e_N > 0 at all or at none. By "sequential"
        they are struck one after the other, the fastest approach first, of equal ones the lowest number, each by the
        energetic law.
    directions : {1, 2}
        Of friction: 1 in a plane, 2 on a surface in space, where ``tangent`` writes two orthonormal rows and the cone
        |P_F| <= mu |P_N| is round. Such a system has unilateral contacts, and some with a given normal force; impacts
        follow Newton's law, of one contact also Poisson's or the energetic one; `MoreauJean` simulates it.
    name : str
        For summaries, figures and messages, as "tip"; its number when left out.
    at : callable, optional
        Where it is drawn: ``at(q)`` or ``at(q, p)`` returns its point [m] and its normal, each (x, y), and its tangent
        where that is not the normal turned clockwise, (n_y, -n_x). Forces are drawn along both; they move nothing.
    """

    mu: Coefficient | FrictionLaw = 0.0
    e_N: Coefficient = 0.0
    e_F: Coefficient = 0.0
    bilateral: bool = False
    normal_force: bool = False
    impact: str | None = None
    directions: int = 1
    name: str = ""
    at: Callable[..., Any] | None = field(default=None, compare=False, repr=False)

    def __post_init__(self) -> None:
        as_instance("the name of a contact", self.name, str, "a text")
        if self.at is not None:
            require_drawn("at of a contact", self.at, ("q", "p"), "its point and its normal")
        if self.impact is not None:
            as_name("impact law", self.impact, IMPACT_LAWS)
        for name, value in (("e_N", self.e_N), ("e_F", self.e_F)):
            if not isinstance(value, str):  # a name is resolved by the system that has the parameters
                as_fraction(name, value)
        as_law(self.mu)
        if not isinstance(self.directions, int) or isinstance(self.directions, bool) or self.directions not in (1, 2):
            raise InvalidInput(f"directions must be 1 (planar friction) or 2 (spatial); got {shown(self.directions)}")
        if self.directions == 2 and not self.has_friction:
            raise InvalidInput("a contact with directions=2 needs friction; give it mu > 0, or leave directions out")
        as_flag("bilateral", self.bilateral)
        as_flag("normal_force", self.normal_force)
        if self.bilateral and self.normal_force:
            raise InvalidInput("a contact is either bilateral or has a given normal force; both were asked for")
        if self.normal_force and not self.has_friction:
            raise InvalidInput("a contact with a given normal force needs friction; give it mu > 0")

    @property
    def law(self) -> FrictionLaw:
        """The friction law, made from whatever was given."""
        return as_law(self.mu)

    @property
    def has_friction(self) -> bool:
        """Whether the contact has tangential rows."""
        return not (isinstance(self.mu, int | float) and self.mu == 0)

    @property
    def law_of_impact(self) -> str:
        """The name of the law that was chosen, or Newton's."""
        return "newton" if self.impact is None else self.impact

    @property
    def kind(self) -> int:
        """Unilateral, bilateral, or friction under a given normal force."""
        return BILATERAL if self.bilateral else GIVEN_FORCE if self.normal_force else UNILATERAL


@dataclass(frozen=True, eq=False)
class System:
    """A mechanical system with contacts, from plain Python functions that write into their last argument.

    A function without that argument returns its values, as ``mass(t, q, p)`` and what ``sympy.lambdify`` makes do.

    Parameters
    ----------
    coordinates : sequence of (str, str) or str, optional
        Name and unit of each coordinate, as ``[("x", "m"), ("th", "rad")]``, or names alone. They stand in figures,
        summaries, files and messages; ``sol["th"]`` and ``sol["thdot"]`` are the columns of a run, ``state=dict(th=0.8,
        thdot=-1)`` is a start (what is not named is zero), ``th`` and ``thdot`` are axes of sweeps and maps.
    n_q : int, optional
        Number of coordinates; that of the names when left out.
    n_u : int, optional
        Number of velocities; equal to n_q where there is no ``kinematics``.
    velocities : sequence of (str, str) or str, optional
        Name and unit of each velocity, as ``[("w_x", "rad/s")]``, where ``kinematics`` is given; else they are the
        rates of the coordinates.
    kinematics : callable, optional
        ``kinematics(t, q, p, B)`` writes B (n_q, n_u): q' = B u, as for unit quaternions and angular velocities. What
        is quadratic in q and stays constant along q' = B u, as |q| of a quaternion, stays so to rounding.
        `MoreauJean` takes it, and `classify`.
    mass : callable
        ``mass(t, q, p, M)`` writes M (n_u, n_u) [symmetric positive definite].
    force : callable
        ``force(t, q, u, p, h)`` writes h (n_u,): all smooth forces.
    gap, normal, tangent : callable, optional
        ``gap(t, q, p, g_N)`` (n_c,) [m]; ``normal(t, q, p, W_N)`` (n_c, n_u), the gradient of the gap, with kinematics
        times B, derived from the gap when left out; ``tangent(t, q, p, W_F)`` (n_c, d, n_u), d = 1 for planar
        friction, 2 where a contact has ``directions=2``.
    surface_velocity, gap_rate : callable, optional
        ``surface_velocity(t, q, p, w_F)`` (n_c, d) and ``gap_rate(t, q, p, w_N)`` (n_c,) [m/s]: gamma_F = W_F u + w_F,
        gamma_N = W_N u + w_N. When left out w_F is zero, and w_N is derived from the gap, the rate at which it changes
        with time.
    row_rates : callable, optional
        ``row_rates(t, q, u, p, r)`` (n_c, 1 + d) [m/s^2]: W' u + w' per contact, normal first. Computed by a
        fourth-order difference along the motion when left out.
    stiffness, damping : callable, optional
        ``stiffness(t, q, u, p, K)``, ``damping(t, q, u, p, C)``, (n_u, n_u): K = -dh/dq, C = -dh/du. They make the step
        linearly implicit in the force. Where damping is left out and the force reads u, C is computed by differences;
        so is K with ``stiffness="differences"``.
    potential : callable, optional
        ``potential(t, q, p, V)`` writes V[0] [J]; its drift stands beside the energy ledger.
    normal_force : callable, optional
        ``normal_force(t, q, u, p, N)`` (n_c,) [N] for the contacts with a given normal force.
    contacts : sequence of Contact
        Each may have a name.
    parameters : NamedTuple or dataclass instance
        What the functions see as ``p``: every field that is a number, an array of numbers, or a NamedTuple or dataclass
        of such. Within sweeps and ``with_parameters`` their numbers are called "mu", "k[0]", "spring.k". Fields that
        the attribute ``constants`` of its class names, the last ones, are read in the same way and are no parameters.
    name : str
        For messages and titles.
    shape : callable, optional
        ``shape(q, p)`` returns the bodies as polylines, a list of (k, 2) arrays [m], for pictures, animations and the
        player; ``shape(q)`` will do where nothing of p is needed.
    outline : callable, optional
        ``outline(p)``, or ``outline()``, returns the surroundings as polylines, which do not move.
    t_end, dt : float, optional
        End of a run and step of time stepping that suit the system [s]: `simulate`, studies, sweeps and commands take
        them where no span and no step are given.

    Raises
    ------
    InvalidInput
        When functions are missing, take the wrong number of arguments, or a law is out of range.

    Notes
    -----
    What ``parameters`` has under the names ``coordinates``, ``shape(q)``, ``outline()``, ``state(...)``, ``t_end`` and
    ``dt`` is taken where it is not given here: so a model is one class (docs/models.md).

    Examples
    --------
    >>> from typing import NamedTuple
    >>> import nonsmooth as ns
    >>> class P(NamedTuple):
    ...     m: float = 1.0
    ...     g: float = 9.81
    >>> def mass(t, q, p, M): M[0, 0] = p.m
    >>> def force(t, q, u, p, h): h[0] = -p.m * p.g
    >>> def gap(t, q, p, g_N): g_N[0] = q[0]
    >>> def normal(t, q, p, W_N): W_N[0, 0] = 1.0
    >>> ball = ns.System(coordinates=[("y", "m")], mass=mass, force=force, gap=gap, normal=normal,
    ...                  contacts=[ns.Contact(e_N=0.5, name="floor")], parameters=P(), name="ball")
    >>> ball
    System('ball', n_q=1, n_c=1)
    >>> sol = ns.simulate(ball, (0, 1), state=dict(y=1.0), integrator=ns.MoreauJean(dt=1e-3))
    >>> round(float(sol["y"].max()), 3)
    1.0
    """

    mass: Callable[..., Any]
    force: Callable[..., Any]
    n_q: int = field(default=None, kw_only=True)  # type: ignore[assignment]
    n_u: int = None  # type: ignore[assignment]
    gap: Callable[..., Any] | None = None
    normal: Callable[..., Any] | None = None
    tangent: Callable[..., Any] | None = None
    surface_velocity: Callable[..., Any] | None = None
    gap_rate: Callable[..., Any] | None = None
    row_rates: Callable[..., Any] | None = None
    stiffness: Callable[..., Any] | str | None = None
    damping: Callable[..., Any] | None = None
    potential: Callable[..., Any] | None = None
    normal_force: Callable[..., Any] | None = None
    kinematics: Callable[..., Any] | None = None
    contacts: Sequence[Contact] = ()
    parameters: Any = ()
    name: str = ""
    coordinates: Sequence[tuple[str, str] | str] = ()
    velocities: Sequence[tuple[str, str] | str] = ()
    shape: Callable[..., Any] | None = None
    outline: Callable[..., Any] | None = None
    t_end: float | None = None
    dt: float | None = None
    d: int = field(init=False)

    def __post_init__(self) -> None:
        set_ = functools.partial(object.__setattr__, self)
        set_("coordinates", as_names("coordinates", "coordinate", self.coordinates, self.n_q))
        if self.n_q is None and not self.coordinates:
            raise InvalidInput('a system needs its coordinates, as coordinates=[("x", "m"), ("th", "rad")], or n_q=')
        set_("n_q", len(self.coordinates) if self.n_q is None else as_count("n_q", self.n_q))
        as_instance("name", self.name, str, "a text")
        for name in ("t_end", "dt"):
            if getattr(self, name) is not None:
                set_(name, as_positive(name, getattr(self, name), "s"))
        set_("velocities", as_names("velocities", "velocity", self.velocities, self.n_u))
        set_("n_u", (len(self.velocities) or self.n_q) if self.n_u is None else as_count("n_u", self.n_u))
        _check_velocities(self)
        contacts = (self.contacts,) if isinstance(self.contacts, Contact) else self.contacts
        if not isinstance(contacts, list | tuple) or not all(isinstance(contact, Contact) for contact in contacts):
            raise InvalidInput(f"contacts must be a list of Contact, one for each gap; got {shown(self.contacts)}")
        set_("contacts", tuple(contacts))
        directions = [contact.directions for contact in self.contacts if contact.has_friction]
        set_("d", max(directions, default=int(self.tangent is not None)))
        _check_space(self)
        _check_functions(self)
        for name, names in (("shape", ("q", "p")), ("outline", ("p",))):
            if getattr(self, name) is not None:
                require_drawn(name, getattr(self, name), names)
        _check_parameters(self)
        _check_laws(self)

    def __getstate__(self) -> dict[str, Any]:
        """What was given: what was derived of it is made anew in another process."""
        return {part.name: getattr(self, part.name) for part in fields(self)}

    @property
    def n_c(self) -> int:
        """Number of contacts."""
        return len(self.contacts)

    @property
    def is_spatial(self) -> bool:
        """Whether it has kinematics, or friction in two directions: what `MoreauJean` takes and not every other."""
        return self.kinematics is not None or self.d > 1

    @property
    def sizes(self) -> dict[str, int]:
        """Sizes of the blocks of a run: n velocities, n_c contacts, d directions of friction, and n_q coordinates, 0
        where q' = u."""
        return {"n": self.n_u, "n_c": self.n_c, "d": self.d, "n_q": 0 if self.kinematics is None else self.n_q}

    @property
    def functions(self) -> dict[int, Callable[..., Any]]:
        """The functions, by their ``which`` number: those that were given, and the rows derived from the gap.

        Rows are derived anew where what the gap reads has changed.
        """
        known: tuple[dict[int, Callable[..., Any]], Watch] | None = vars(self).get("_functions")
        if known is None or not known[1].holds():
            known = vars(self)["_functions"] = self._find_functions()
        return known[0]

    def given(self, which: int) -> Callable[..., Any]:
        """The user's function behind one of ``functions``: the gap of a derived row, one that returns its values."""
        function = self.functions[which]
        function = getattr(function, "derived_from", function)
        return getattr(function, "returned_from", function)

    def _find_functions(self) -> tuple[dict[int, Callable[..., Any]], Watch]:
        derived_rows = self._derived_rows()
        given = {which: getattr(self, name) for name, which in FUNCTION_NAMES.items()} | derived_rows
        sources = {which: getattr(function, "py_func", function) for which, function in given.items()}  # of numba's
        found = {which: function for which, function in sources.items() if callable(function)}
        watch = watch_on(found[GAP]) if derived_rows else Watch()
        for which, function in found.items():
            if self._returns(which, function):
                found[which] = writing(NAMES[which], function, which in TAKES_U, self.shape_of(which))
                if hasattr(function, "__code__"):
                    watch.function(function)
        return found, watch

    def _returns(self, which: int, function: Callable[..., Any]) -> bool:
        """Whether a function returns its values: it has no place for an array to write into."""
        return not takes(function, arguments_of(which))

    def _derived_rows(self) -> dict[int, Callable[..., Any]]:
        """The rows that were left out."""
        if self.gap is None:
            return {}
        gap = getattr(self.gap, "py_func", self.gap)
        if self._returns(GAP, gap):
            gap = writing("gap", gap, False, self.shape_of(GAP))
        size, found = (self.n_q, self.n_c), {}
        if self.normal is None and self.kinematics is None:
            found[NORMAL] = derived("normal", gap, size)
        elif self.normal is None:
            kinematics: Any = getattr(self.kinematics, "py_func", self.kinematics)
            if self._returns(KINEMATICS, kinematics):
                kinematics = writing("kinematics", kinematics, False, self.shape_of(KINEMATICS))
            found[NORMAL] = derived("normal", gap, size, (kinematics, self.n_u))
        if self.gap_rate is None and reads_argument(getattr(self.gap, "__code__", None), 0):
            found[GAP_RATE] = derived("gap_rate", gap, size)
        return found

    @functools.cached_property
    def numbers(self) -> dict[str, float]:
        """All numbers that the functions see as ``p``, by name: the parameters, and behind them the constants."""
        return numeric_fields(self.parameters)

    @functools.cached_property
    def parameter_values(self) -> dict[str, float]:
        """The numeric parameters by name."""
        return numeric_fields(self.parameters, constant_fields(self.parameters))

    @functools.cached_property
    def p(self) -> np.ndarray:
        """All numbers as the vector that the compiled model unpacks."""
        return np.array(list(self.numbers.values()), dtype=np.float64)

    @property
    def laws(self) -> np.ndarray:
        """(n_c, LAW_WIDTH) restitution and friction coefficients; of laws of the user's the code as it is now."""
        if not self.own_laws:
            return self.law_numbers
        rows = self.law_numbers.copy()
        write_handles(rows, self.own_laws, self.unpack, self.p)
        return rows

    @functools.cached_property
    def own_laws(self) -> dict[int, Friction]:
        """The laws of the user's, by the number of their contact."""
        return own_laws(self.contacts)

    @functools.cached_property
    def law_numbers(self) -> np.ndarray:
        """(n_c, LAW_WIDTH) what of the laws is numbers, the same in every process."""
        rows = [
            law_row(contact.law, contact.e_N, contact.e_F, contact.law_of_impact, self.parameter_values)
            for contact in self.contacts
        ]
        return np.array(rows).reshape(self.n_c, LAW_WIDTH)

    @functools.cached_property
    def kinds(self) -> np.ndarray:
        """(n_c, 2) kind of each contact and its number of friction directions."""
        rows = [(contact.kind, contact.directions if contact.has_friction else 0) for contact in self.contacts]
        return np.array(rows, dtype=np.int64).reshape(self.n_c, 2)

    def shape_of(self, which: int) -> tuple[int, ...]:
        """Shape of the array that a model function writes."""
        return self._shapes[which]

    @functools.cached_property
    def _shapes(self) -> dict[int, tuple[int, ...]]:
        n_u, n_c, d = self.n_u, self.n_c, self.d
        return {
            MASS: (n_u, n_u),
            FORCE: (n_u,),
            GAP: (n_c,),
            NORMAL: (n_c, n_u),
            TANGENT: (n_c, d, n_u),
            SURFACE_VELOCITY: (n_c, d),
            GAP_RATE: (n_c,),
            ROW_RATES: (n_c, 1 + d),
            STIFFNESS: (n_u, n_u),
            DAMPING: (n_u, n_u),
            POTENTIAL: (1,),
            NORMAL_FORCE: (n_c,),
            KINEMATICS: (self.n_q, n_u),
        }

    def name_of(self, which: int) -> str:
        """The name of a function for messages: of a row derived from the gap it is the gap's, which is what runs."""
        is_derived = hasattr(self.functions.get(which), "derived_from")
        return next(name for name, number in FUNCTION_NAMES.items() if number == (GAP if is_derived else which))

    def call(self, which: int, t: float, q: np.ndarray, u: np.ndarray, out: np.ndarray) -> Any:
        """Call one model function in Python; what it raises is an Exception or Ctrl-C, whatever it raised."""
        function = self.functions[which]
        try:
            return function(t, q, u, self.unpacked, out) if which in TAKES_U else function(t, q, self.unpacked, out)
        except (Exception, KeyboardInterrupt):
            raise
        except BaseException as error:  # as sys.exit() does
            raise RuntimeError(said_by(error)) from error

    def evaluate(self, which: int, t: float, q: np.ndarray, u: np.ndarray) -> np.ndarray:
        """Call one model function in Python and return the array it wrote; overflow is inf, as in compiled code."""
        out = np.zeros(self.shape_of(which))
        with np.errstate(all="ignore"):
            self.call(which, t, q, u, out)
        return out

    @functools.cached_property
    def described(self) -> Description:
        """Names, units and pictures: those given here, else those of the parameters, else numbers."""
        return described(self)

    @functools.cached_property
    def unpack(self) -> Unpack:
        """What makes what the model functions see as ``p``."""
        return unpack_of(layout_of(self.parameters))

    @functools.cached_property
    def unpacked(self) -> Any:
        """The parameters as model functions see them."""
        return self.unpack(*self.p)

    def reads(self, which: int, argument: str) -> bool:
        """Whether a model function reads one of its arguments ``t``, ``q``, ``u`` (True when in doubt)."""
        if which not in self.functions:
            return False
        position = ("t", "q", "u").index(argument)
        return reads_argument(getattr(self.given(which), "__code__", None), position)

    def with_parameters(self, **changes: float) -> System:
        """The same system with some parameters changed.

        Raises
        ------
        UnknownName
            For a name that is not a parameter.
        """
        return replace(self, parameters=with_changes(self.parameters, changes))

    def __repr__(self) -> str:
        name = f"{self.name!r}, " if self.name else ""
        return f"System({name}n_q={self.n_q}, n_c={self.n_c})"


def _check_velocities(system: System) -> None:
    """Velocities are the rates of the coordinates where no kinematics says otherwise."""
    if system.kinematics is None and system.n_u != system.n_q:
        raise InvalidInput(
            f"n_u must equal n_q (q' = u), or kinematics= give q' = B u; got n_u = {system.n_u}, n_q = {system.n_q}"
        )
    if system.kinematics is None and system.velocities:
        raise InvalidInput("velocities= names those of q' = B u; give kinematics= too, or leave it out")


def _check_space(system: System) -> None:
    """What stands beside friction in two directions."""
    for contact in system.contacts if system.d > 1 else ():
        if contact.bilateral:
            raise InvalidInput(f"a system with friction in two directions takes no bilateral contact; got {contact}")
        if contact.law_of_impact == "sequential" or (contact.law_of_impact != "newton" and system.n_c > 1):
            raise InvalidInput(
                "a system with friction in two directions takes Newton's law of impact, of one contact also 'poisson' "
                f"and 'energetic'; got {contact}"
            )


def _check_parameters(system: System) -> None:
    """The names of the parameters can be those of ``p``, and their values are numbers."""
    for name in system.parameter_values:
        if name.startswith("_") or "._" in name:
            raise InvalidInput(f"a parameter's name must not begin with an underscore; got {name}")


def _check_laws(system: System) -> None:
    """Coefficients are in range, which ``laws`` sees to; several contacts have one law of impact that can be theirs."""
    require_values(system)
    others = np.flatnonzero(system.law_numbers[:, LAW_IMPACT] != ImpactLaw.NEWTON)
    if not len(others) or system.n_c == 1:
        return
    law, e = system.contacts[others[0]].law_of_impact, system.law_numbers[:, LAW_E_N]
    for contact in system.contacts:
        if contact.law_of_impact != law or contact.kind != UNILATERAL:
            raise InvalidInput(
                f"impact = {law!r} needs a system with one contact, or several that are all unilateral and of the same "
                f"law; got {contact}"
            )
    said = ", ".join(f"{value:g}" for value in e)
    if law == "poisson" and np.ptp(e) > 0.0:
        raise InvalidInput(
            f"impact = 'poisson' of several contacts needs one e_N, with several they may gain energy; got {said}; "
            "impact='sequential' or 'energetic' takes several"
        )
    if law == "energetic" and not e.all() and e.any():
        raise InvalidInput(
            "impact = 'energetic' of several contacts needs e_N > 0 at all of them, or e_N = 0 at all, which gives "
            f"nothing back; got {said}; impact='sequential' takes any"
        )


def evaluate(system: System, which: int, t: float, q: np.ndarray, u: np.ndarray) -> np.ndarray:
    """A model function's array, zeros where the system has no such function; `InvalidInput` when it raises."""
    if which not in system.functions:
        return np.zeros(system.shape_of(which))
    try:
        return system.evaluate(which, t, q, u)
    except Exception as error:
        raise InvalidInput(
            f"the model function {system.name_of(which)} raised {said_by(error)}, at t = {t:g} s; it writes an "
            f"array of shape {system.shape_of(which)}"
        ) from error


def _check_functions(system: System) -> None:
    has_normal = [contact for contact in system.contacts if not contact.normal_force]
    needed = {
        "mass": True,
        "force": True,
        "gap": bool(has_normal),
        "tangent": system.d > 0,
        "normal_force": any(contact.normal_force for contact in system.contacts),
    }
    for name, is_needed in needed.items():
        if is_needed and getattr(system, name) is None:
            raise InvalidInput(f"this system with its contacts needs the function {name}; it was not given")
    for name, which in FUNCTION_NAMES.items():
        function = getattr(system, name)
        if function is None or (name == "stiffness" and isinstance(function, str) and function == "differences"):
            continue
        if not callable(function) or not is_hashable(function):  # it is a key of what was compiled
            raise InvalidInput(f"{name} must be a function; got {type(function).__name__}")
        expected = arguments_of(which)
        if takes(function, expected) or not takes(function, expected[:-1]) or not returns_values(function):
            require_arguments(name, function, expected)


def arguments_of(which: int) -> tuple[str, ...]:
    """What a model function takes that writes."""
    return ("t", "q", "u", "p", "out") if which in TAKES_U else ("t", "q", "p", "out")
