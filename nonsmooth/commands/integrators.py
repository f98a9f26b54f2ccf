"""The integrator of a run, from the options of the command line: ``--integrator NAME`` and what belongs to it."""

from __future__ import annotations

import argparse
import importlib
from typing import Any

from nonsmooth.commands.typed_input import number
from nonsmooth.errors import InvalidInput

# name of the option: class, its module, and the options that it takes
INTEGRATORS: dict[str, tuple[str, str, tuple[str, ...]]] = {
    "moreau-jean": ("MoreauJean", "moreau_jean", ("dt", "theta", "projection")),
    "adaptive": ("Adaptive", "adaptive", ("rtol", "atol", "max_steps")),
    "event-driven": ("EventDriven", "event_driven", ("rtol", "atol")),
    "penalty": ("Penalty", "penalty", ("stiffness", "damping", "damping_ratio", "rtol", "atol")),
}


def add_integrator(command: argparse.ArgumentParser) -> None:
    """The options that choose an integrator."""
    command.add_argument("--integrator", choices=INTEGRATORS, default="moreau-jean", help="moreau-jean by default")
    command.add_argument("--dt", type=number, help="moreau-jean: step [s]; the model's own by default")
    command.add_argument("--theta", type=number, help="moreau-jean: weight of the new velocity, 0.5 (default) to 1")
    command.add_argument("--projection", action="store_true", default=None,
                         help="moreau-jean: move positions back to the surfaces after each step")  # fmt: skip
    command.add_argument(
        "--rtol", type=number, help="adaptive, event-driven, penalty: relative tolerance; 1e-8 by default"
    )
    command.add_argument(
        "--atol", type=number, help="adaptive, event-driven, penalty: absolute tolerance; 1e-10 by default"
    )
    command.add_argument("--max-steps", type=whole_number, metavar="N", help="adaptive: steps that may be tried")
    command.add_argument("--stiffness", type=number, metavar="K", help="penalty: [N/m]")
    command.add_argument("--damping", type=number, metavar="C", help="penalty: [N s/m]")
    command.add_argument("--damping-ratio", type=number, metavar="ZETA", help="penalty: c = 2 zeta sqrt(k m)")


def new_integrator(arguments: argparse.Namespace, model: Any) -> Any:
    """The integrator with the options that were given.

    Raises
    ------
    InvalidInput
        For an option of another integrator, and where a step or a stiffness is missing.
    """
    name, module, own = INTEGRATORS[arguments.integrator]
    every = {option for _, _, options in INTEGRATORS.values() for option in options}
    given = {option: getattr(arguments, option) for option in sorted(every) if getattr(arguments, option) is not None}
    for option in given:
        if option not in own:
            raise InvalidInput(f"--{option.replace('_', '-')} is no option of --integrator {arguments.integrator}")
    if "dt" in own and "dt" not in given:
        given["dt"] = getattr(model, "dt", None)
        if given["dt"] is None:
            raise InvalidInput(f"the model {arguments.model} has no dt of its own; give --dt")
    if "stiffness" in own and "stiffness" not in given:
        raise InvalidInput("--integrator penalty needs --stiffness [N/m]")
    return getattr(importlib.import_module(f"nonsmooth.integrators.{module}"), name)(**given)
