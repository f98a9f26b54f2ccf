"""Where a motion begins, said in one way everywhere.

(q0, u0)                       coordinates and velocities
{"th": 0.8, "thdot": -1.0}     variables of the model's state(...); without one coordinates and their
                               rates, the others zero
{"q0": ..., "u0": ...}         the pair, by name
what has a method state()      what that gives, as the start of a scene
{"q0[1]": 0.8}                 entries of it, or "q[1]"; the others as in the model's default state, or zero without one
"""

from __future__ import annotations

import functools
import inspect
import re
from collections.abc import Callable, Mapping
from typing import Any, ParamSpec, TypeVar

import numpy as np

from nonsmooth.checks.arrays import as_number, as_positive, as_vector, result_of
from nonsmooth.errors import InvalidInput, UnknownName, nearest, shown
from nonsmooth.mechanics.model_system import as_system
from nonsmooth.mechanics.system import System

COMPONENT = re.compile(r"([qu])0?\[(\d+)\]")
# met: of new users
OF_INTEGRATORS = {"dt": "ns.MoreauJean(dt=...)", "rtol": "ns.Adaptive(rtol=...)", "method": "'auto'"}
WRONG_WORDS = ("q0", "u0", "start", "guess", "state0", "x0", "y0", "initial_state", "initial")  # met: of new users

Arguments = ParamSpec("Arguments")
Result = TypeVar("Result")
State = tuple[np.ndarray, np.ndarray]


def describing(model: Any) -> Any:
    """Who has the optional functions of a model (state, natural_state): the model, of a bare system its parameters."""
    return model.parameters if isinstance(model, System) else model


def own_time(model: Any, name: str) -> float | None:
    """Find ``t_end`` or ``dt`` of a model, a system or a scene [s]: its own, that of its parameters, or that of the
    system or the scene which it builds; None where none of them has one."""
    if isinstance(model, System) and getattr(model, name) is None:
        model = model.parameters
    elif not hasattr(model, name) and not isinstance(model, type):
        build = getattr(model, "scene", None) or getattr(model, "system", None)
        if callable(build):
            return own_time(build(), name)
    value = getattr(model, name, None)
    return None if value is None else as_positive(name, value, "s")


def own_state(model: Any) -> Callable | None:
    """The function ``state(...)`` of a model, or None."""
    state = getattr(describing(model), "state", None)
    return state if callable(state) else None


class CoordinateState:
    """``state(...)`` of a system that has none of its own: coordinates and rates by name.

    Parameters
    ----------
    system : System
    base : (q0, u0), optional
        What is not named; zero when left out.
    """

    def __init__(self, system: System, base: Any = None) -> None:
        q, u = (np.zeros(system.n_q), np.zeros(system.n_u)) if base is None else as_pair("state", base, system)
        self.n, names = system.n_q, (*system.described.coordinates, *system.described.rates)
        self.variables = {name: float(x) for (name, _), x in zip(names, (*q, *u), strict=True)}

    def __call__(self, **values: float) -> State:
        for name in values.keys() - self.variables.keys():
            raise UnknownName(f"the state has no variable {name!r}; {nearest(name, self.variables)}")
        x = np.array([as_number(name, value) for name, value in {**self.variables, **values}.items()])
        return x[: self.n], x[self.n :]


def state_function(model: Any) -> Callable:
    """The function ``state(...)`` of a model, or that of its coordinates."""
    return own_state(model) or CoordinateState(as_system(model))


def variables_of(state: Callable) -> dict[str, Any]:
    """The variables of a state function and their defaults, None where one must be given."""
    if isinstance(state, CoordinateState):
        return dict(state.variables)
    try:
        parameters = inspect.signature(state).parameters.items()
    except Exception:  # a callable that does not say what it takes
        raise InvalidInput(f"state must be a function of named variables; got {shown(state)}") from None
    empty = inspect.Parameter.empty
    return {name: None if parameter.default is empty else parameter.default for name, parameter in parameters}


def as_pair(name: str, value: Any, system: System) -> State:
    """Coordinates and velocities given as a pair, or `InvalidInput`."""
    if not isinstance(value, tuple | list) or len(value) != 2:
        raise InvalidInput(f"{name} must be a pair {forms_of(system)}; got {shown(value)}")
    return as_vector(f"{name}[0]", value[0], system.n_q), as_vector(f"{name}[1]", value[1], system.n_u)


def start_of(model: Any, given: Any, name: str = "state") -> State:
    """q0 (n_q,) and u0 (n_u,) from any of the forms above.

    Raises
    ------
    UnknownName
        For a variable that the state does not have.
    InvalidInput
        For another form, and a number that is none.
    """
    system = as_system(model)
    if callable(getattr(given, "state", None)):
        given = given.state()
    if not isinstance(given, Mapping):
        return as_pair(name, given, system)
    whole, entries, variables = split_state(model, given)
    if whole:
        q, u = as_vector("q0", whole["q0"], system.n_q), as_vector("u0", whole["u0"], system.n_u)
    elif entries and not variables and own_state(model) is None:
        q, u = np.zeros(system.n_q), np.zeros(system.n_u)
    else:
        q, u = as_pair("state(...)", result_of("state", state_function(model), **variables), system)
    for (which, k), value in entries.items():
        (q if which == "q" else u)[k] = value
    return q, u


def split_state(model: Any, given: Mapping[str, Any]) -> tuple[dict[str, Any], dict[tuple[str, int], float], dict]:
    """The pair, single entries, and variables of a state that was given by name."""
    system, known = as_system(model), variables_of(state_function(model))
    whole = {name: given[name] for name in ("q0", "u0") if name in given}
    entries, variables = {}, {}
    for name in given.keys() - whole.keys():
        match = COMPONENT.fullmatch(str(name))
        if match:
            place = match[1], _place(name, match, system.n_q)
            if place in entries:
                raise InvalidInput(f"the state has {match[1]}0[{place[1]}] twice, also as {name}; give it once")
            entries[place] = as_number(name, given[name])
        elif name not in known:
            raise UnknownName(f"the state has no variable {shown(name)}; {nearest(name, {'q0', 'u0', *known})}")
        else:
            variables[name] = as_number(name, given[name])
    if whole and (len(whole) < 2 or variables):
        raise InvalidInput(f"give q0 and u0, or variables of the state; got {', '.join(map(str, given))}")
    return whole, entries, variables


def _place(name: str, match: re.Match, n: int) -> int:
    if not int(match[2]) < n:
        raise InvalidInput(f"{name}: the state has {n} entries, counted from 0")
    return int(match[2])


def the_start(model: Any, q0: Any, u0: Any, state: Any, system: System | None = None) -> State:
    """The start from q0 and u0, or from ``state``: one of them; ``system`` is the model's, where it is at hand."""
    system = as_system(model) if system is None else system
    if state is not None:
        if q0 is not None or u0 is not None:
            raise InvalidInput("give either q0 and u0, or state; got both")
        return start_of(model, state)
    if u0 is None and isinstance(q0, Mapping):
        return start_of(model, q0, "q0")
    if q0 is None and u0 is None:
        raise InvalidInput(f"the motion has no start; give q0 and u0, or state={forms_of(model)}")
    if q0 is None or u0 is None:
        given, missing = ("q0", "u0") if u0 is None else ("u0", "q0")
        raise InvalidInput(f"the start has {given} and no {missing}; give both, or state={forms_of(model)}")
    return as_vector("q0", q0, system.n_q), as_vector("u0", u0, system.n_u)


def forms_of(model: Any) -> str:
    """How the start of this model is typed."""
    known = list(variables_of(state_function(model)))
    names = [name for name in known if name.isidentifier()][:2]
    by_name = f"dict({', '.join(f'{name}=...' for name in names)})" if names else '{"q[0]": ...}'
    return f"(q0, u0) or {by_name}"


def answers_start(function: Callable[Arguments, Result]) -> Callable[Arguments, Result]:
    """A function that answers other words for the start by the right one, also variables of the state beside it, and
    options of integrators by the integrator that has them."""
    own = inspect.signature(function).parameters
    is_open = any(parameter.kind == parameter.VAR_KEYWORD for parameter in own.values())
    wrong = {word for word in WRONG_WORDS if word not in own}
    method = "self" in own

    @functools.wraps(function)
    def answering(*given: Arguments.args, **options: Arguments.kwargs) -> Result:
        for word in sorted(options.keys() & wrong if is_open else options.keys() - own.keys()):
            model = (given[int(method) :] or (options.get("system", options.get("model")),))[0]
            name = function.__qualname__.removesuffix(".__init__")
            if word in OF_INTEGRATORS and "integrator" in own:
                raise InvalidInput(f"{name} takes no {word}=; give integrator={OF_INTEGRATORS[word]}")
            if word in wrong or word in variables_of(state_function(model)):
                form = forms_of(model) if word in wrong else f"dict({word}=...)"
                raise InvalidInput(f"{name} takes no {word}=; its start is state={form}")
        return function(*given, **options)

    return answering
