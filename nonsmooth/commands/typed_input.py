"""What a user types, as values: numbers, whole numbers, NAME=VALUE, initial states, and paths that can be written.

Everything is checked before a run starts; a refusal is one sentence and the exit code 2.
"""

from __future__ import annotations

import argparse
import ast
import importlib.util
import math
import operator
import re
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn

from nonsmooth.checks.files import as_place
from nonsmooth.errors import InvalidInput, MissingExtra, closest

if TYPE_CHECKING:
    from nonsmooth.sweeps.axes import Axis

BAD_INPUT = 2  # exit code
AXIS = "NAME=START:STOP:COUNT[:log][:UNIT] or NAME=V,V,...[:UNIT]"

OPERATORS: dict[type, Any] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.Pow: operator.pow,
    ast.USub: operator.neg,
    ast.UAdd: operator.pos,
}
NAMES = {"pi": math.pi, "inf": math.inf, "nan": math.nan}
NEGATIVE = re.compile(r"-(\d|\.\d|pi\b|inf\b|nan\b|\()")  # -1e-3 and -pi/4 are numbers, not options


class Parser(argparse.ArgumentParser):
    """A parser that refuses in one line instead of ten, and suggests what was meant."""

    root: Parser | None = None  # the parser of all commands, once it has them

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> Any:
        """As of argparse; a command that has options of its own answers itself for words that it does not know."""
        found, unknown = super().parse_known_args(args, namespace)
        if unknown and not self.commands():
            options = [option for option in unknown if option.startswith("-")]
            word = options[0].partition("=")[0] if options else ""
            others = [name for name, other in self.root.leaves() if word in other.words()] if self.root else []
            if others:
                self.error(f"there is no {word} here; {', '.join(others)} {'have' if len(others) > 1 else 'has'} it")
            meant = suggestion(word, self.words()) if options else ""
            self.error(f"unrecognized arguments: {' '.join(unknown)}{meant}")
        if not self.commands():
            found.options = {action.dest: action.option_strings[0] for action in self._actions if action.option_strings}
        return found, unknown

    def _check_value(self, action: argparse.Action, value: Any) -> None:
        """As of argparse; with the nearest of the choices, or the command of another command."""
        if action.choices is None or value in action.choices:
            return
        what = action.metavar or (action.option_strings or [action.dest])[-1]
        known = {str(choice): str(choice) for choice in action.choices}
        if isinstance(action, argparse._SubParsersAction):
            known |= {word: f"{name} {word}" for name, command in action.choices.items() for word in command.commands()}
        meant = suggestion(str(value), list(known), known)
        choices = ", ".join(map(str, action.choices))
        raise argparse.ArgumentError(None, f"there is no {what} {value!r}{meant or f'; known: {choices}'}")

    def commands(self) -> list[str]:
        """The words of its commands, if it has any."""
        return [word for action in self._actions if isinstance(action, argparse._SubParsersAction)
                for word in action.choices]  # fmt: skip

    def words(self) -> list[str]:
        """Its options."""
        return [option for option in self._option_string_actions if option.startswith("--")]

    def leaves(self, name: str = "") -> Iterator[tuple[str, Parser]]:
        """What does something, by what is typed after the program's name."""
        if not self.commands():
            yield name, self
        for action in self._actions:
            if isinstance(action, argparse._SubParsersAction):
                for word, command in action.choices.items():
                    yield from command.leaves(f"{name} {word}".strip())

    def describe(self) -> None:
        """Begin the help of every command with what the list of the commands says of it."""
        for action in self._actions:
            if isinstance(action, argparse._SubParsersAction):
                for listed in action._choices_actions:
                    command, says = action.choices[listed.dest], listed.help or ""
                    command.description = f"{says[:1].upper()}{says[1:]}."
                    command.describe()

    def error(self, message: str) -> NoReturn:
        """One line that names the help, in place of the whole usage."""
        self.exit(BAD_INPUT, f"{self.prog}: {message}; see {self.prog} --help\n")


def suggestion(word: str, known: list[str], meant: dict[str, str] | None = None) -> str:
    """`; did you mean 'x'?` for the known word that is nearest, or nothing; ``meant`` is what is then typed."""
    close = closest(word, known)
    return f"; did you mean {(meant or {}).get(close, close)!r}?" if close else ""


def require_writable(path: Path | None, endings: tuple[str, ...]) -> None:
    """Raise before the run when a file could not be written after it."""
    if path is not None:
        as_place("the path", path, endings)


def require_module(module: str, extra: str, what: str) -> None:
    """Raise before the run when an optional dependency is not installed."""
    if importlib.util.find_spec(module) is None:
        raise MissingExtra(f'{what} need {module}; pip install "nonsmooth[{extra}]" brings it')


def initial_state(model: Any, arguments: argparse.Namespace) -> tuple[Any, Any]:
    """q0 and u0 as given, or from the variables of the model's state."""
    if (arguments.q0 is None) != (arguments.u0 is None):
        missing = "--q0" if arguments.q0 is None else "--u0"
        raise InvalidInput(f"--q0 and --u0 go together; {missing} is missing")
    if arguments.q0 is not None:
        if arguments.state:
            raise InvalidInput("give either --state, or --q0 and --u0; got both")
        return arguments.q0, arguments.u0
    from nonsmooth.mechanics.start import forms_of, own_state, start_of

    if not arguments.state and own_state(model) is None:
        names = forms_of(model).partition("dict(")[2].rstrip(")").replace(",", "")
        raise InvalidInput(f"{arguments.model} has no state of its own; give --state {names}, or --q0 and --u0")
    return start_of(model, assignments("--state", arguments.state))


def assignments(option: str, texts: list[str]) -> dict[str, float]:
    """NAME=VALUE texts as a dictionary of numbers."""
    return {name: number_of(option, name, value) for name, value in pairs(option, texts).items()}


def pairs(option: str, texts: list[str]) -> dict[str, str]:
    """NAME=VALUE texts as a dictionary of what is typed."""
    found: dict[str, str] = {}
    for text in texts:
        name, sign, value = text.partition("=")
        if not sign or not name:
            raise InvalidInput(f"{option} takes NAME=VALUE; got {text!r}")
        if name in found:
            raise InvalidInput(f"{option} gives {name} twice; give it once")
        found[name] = value
    return found


def number_of(option: str, name: str, text: str) -> float:
    """The number that is typed for a name."""
    try:
        return number(text)
    except argparse.ArgumentTypeError as error:
        raise InvalidInput(f"{option} {name} must be a number: {error}") from None


def read_axis(text: str, form: str = AXIS, points: int | None = None) -> Axis:
    """An axis as it is typed: a range with a count, which may be left out where ``points`` is given, or a list."""
    import numpy as np

    from nonsmooth.sweeps.axes import Axis

    name, sign, rest = text.partition("=")
    if not sign or not name or not rest:
        raise InvalidInput(f"--axis takes {form}; got {text!r}")
    parts = rest.split(":")
    if points is not None and has_ends_alone(parts):
        parts.insert(2, str(points))
    try:
        if len(parts) <= 2:
            return Axis(name, np.array([number(part) for part in parts[0].split(",")]), *parts[1:])
        start, stop, count = number(parts[0]), number(parts[1]), whole_number(parts[2])
    except argparse.ArgumentTypeError as error:
        raise InvalidInput(f"--axis {name}: {error}; it takes {form}") from None
    is_log = parts[3:4] == ["log"]
    units = parts[4:] if is_log else parts[3:]
    if len(units) > 1 or count < 1 or (is_log and not min(start, stop) > 0):
        raise InvalidInput(f"--axis takes {form}, COUNT >= 1, and positive ends for log; got {text!r}")
    values = np.geomspace(start, stop, count) if is_log else np.linspace(start, stop, count)
    return Axis(name, values, *units)


def has_ends_alone(parts: list[str]) -> bool:
    """Whether the parts of an axis are two ends, and no count after them: `th=0:x` is a range too, with a mistake."""
    if len(parts) < 2 or "," in parts[0] or (len(parts) == 2 and not is_number(parts[0])):
        return False
    return len(parts) == 2 or not is_number(parts[2])


def is_number(text: str) -> bool:
    """Whether a text is a number as it is typed."""
    try:
        number(text)
    except argparse.ArgumentTypeError:
        return False
    return True


def whole_number(text: str) -> int:
    """A whole number, which may be typed as 1000 or 1e3."""
    value = number(text)
    if not (math.isfinite(value) and value == int(value)):
        raise argparse.ArgumentTypeError(f"{text.strip()!r} is no whole number (try 10 or 1e3)")
    return int(value)


def number(text: str) -> float:
    """A number typed as arithmetic on numbers and pi: 1e-3, pi/4, -2*pi."""
    try:
        return float(_evaluate(ast.parse(text.strip(), mode="eval").body))
    except (ArithmeticError, KeyError, MemoryError, RecursionError, SyntaxError, TypeError, ValueError):
        raise argparse.ArgumentTypeError(f"{text.strip()!r} is no number (try 0.5, 1e-3 or pi/4)") from None


def _evaluate(node: Any) -> float:
    if isinstance(node, ast.Constant) and isinstance(node.value, int | float) and not isinstance(node.value, bool):
        return float(node.value)
    if isinstance(node, ast.Name):
        return NAMES[node.id]
    if isinstance(node, ast.UnaryOp):
        return OPERATORS[type(node.op)](_evaluate(node.operand))
    if isinstance(node, ast.BinOp):
        return OPERATORS[type(node.op)](_evaluate(node.left), _evaluate(node.right))
    raise ValueError(node)


def without_nan(value: Any) -> Any:
    """JSON knows neither NaN nor inf: null in their place."""
    if isinstance(value, dict):
        return {key: without_nan(entry) for key, entry in value.items()}
    if isinstance(value, list | tuple):
        return [without_nan(entry) for entry in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
