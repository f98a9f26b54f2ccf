"""The integrator of a run, from the options of the command line: ``--integrator NAME`` and what belongs to it."""

from __future__ import annotations

import argparse
import importlib
from typing import Any

from nonsmooth.commands.outputs import Options
from nonsmooth.commands.typed_input import number
from nonsmooth.errors import InvalidInput

# name of the option: class, its module, and the options that it takes
INTEGRATORS: dict[str, tuple[str, str, tuple[str, ...]]] = {
    "moreau-jean": ("MoreauJean", "moreau_jean.options", ("dt", "theta", "projection")),
    "adaptive": ("Adaptive", "adaptive.options", ("rtol", "atol")),
    "event-driven": ("EventDriven", "event_driven.options", ("rtol", "atol")),
    "penalty": ("Penalty", "penalty.options", ("stiffness", "damping", "damping_ratio", "rtol", "atol")),
}
AUTO, OF_AUTO = "auto", ("rtol",)  # chosen by `simulate`; the options that it takes


def add_integrator(command: Options, many: tuple[str, ...] = (), may_choose: bool = False) -> None:
    """The options that name an integrator, or leave the choice; those named in ``many`` take several values."""

    def add(option: str, what: str, **more: Any) -> None:
        several: dict[str, Any] = {"nargs": "+"} if option in many else {}
        command.add_argument(f"--{option}", type=number, help=what, **several, **more)

    names = [*INTEGRATORS, AUTO] if may_choose else [*INTEGRATORS]
    what = "moreau-jean by default" + ("; auto chooses by what touches at once" if may_choose else "")
    command.add_argument("--integrator", choices=names, default="moreau-jean", help=what)
    add("dt", "moreau-jean: step [s]; the model's own by default" if "dt" not in many else
        "moreau-jean: steps [s]; 1e-2 to 1e-4 by default")  # fmt: skip
    add("theta", "moreau-jean: weight of the new velocity, 0.5 (default) to 1")
    command.add_argument("--projection", action="store_true", default=None,
                         help="moreau-jean: move positions back to the surfaces after each step")  # fmt: skip
    add("rtol", "adaptive, event-driven, penalty, auto: relative tolerance; 1e-8 by default" if "rtol" not in many else
        "adaptive, event-driven, penalty: relative tolerances; 1e-4 to 1e-10 by default")  # fmt: skip
    add("atol", "adaptive, event-driven, penalty: absolute tolerance; 1e-10 by default")
    add("stiffness", "penalty: [N/m]", metavar="K")
    add("damping", "penalty: [N s/m]", metavar="C")
    add("damping-ratio", "penalty: c = 2 zeta sqrt(k m)", metavar="ZETA")


def new_integrator(arguments: argparse.Namespace, model: Any) -> Any:
    """The integrator with the options that were given.

    Raises
    ------
    InvalidInput
        For an option of another integrator, and where a step or a stiffness is missing.
    """
    name, own, given = given_options(arguments)
    if name == AUTO:
        from nonsmooth.runs.choice import Auto

        return Auto(**given)
    if "dt" in own and "dt" not in given:
        from nonsmooth.mechanics.start import own_time

        given["dt"] = own_time(model, "dt")
        if given["dt"] is None:
            raise InvalidInput(f"the model {arguments.model} has no dt of its own; give --dt")
    return integrator_class(name)(**given)


def given_options(arguments: argparse.Namespace) -> tuple[str, tuple[str, ...], dict[str, Any]]:
    """The integrator's name, the options that it takes, and those that were given.

    Raises
    ------
    InvalidInput
        For an option of another integrator, and where a stiffness is missing.
    """
    name = arguments.integrator
    own = INTEGRATORS[name][2] if name in INTEGRATORS else OF_AUTO
    every = {option for _, _, options in INTEGRATORS.values() for option in options}
    given = {option: getattr(arguments, option) for option in sorted(every) if getattr(arguments, option) is not None}
    for option in given:
        if option not in own:
            raise InvalidInput(f"--{option.replace('_', '-')} is no option of --integrator {name}")
    if "stiffness" in own and "stiffness" not in given:
        raise InvalidInput(f"--integrator {name} needs --stiffness [N/m]")
    return name, own, given


def integrator_class(name: str) -> Any:
    """The class of an integrator."""
    of_class, module, _ = INTEGRATORS[name]
    return getattr(importlib.import_module(f"nonsmooth.integrators.{module}"), of_class)
