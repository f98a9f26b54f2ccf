"""Exceptions, warnings and outcomes that users meet. A message names the quantity, the rule, the value and the cure."""

from __future__ import annotations

from enum import IntEnum
from typing import Any

INTERRUPTED = 130  # code: exit code after Ctrl-C, as of a shell: 128 + SIGINT
LONGEST_VALUE = 80  # chosen: characters of a value in a message
NEAR_WORD = 0.5  # chosen: part of the letters of two words that fit, of a word that may have been meant
NEAR_PART = 0.9  # chosen: what a fit with a part of a word counts, beside one with the whole
SHORTEST_NAME = 2  # chosen: letters of a name that may stand for a longer word, as th for theta


class NonsmoothError(Exception):
    """Base class of every exception raised by this package.

    Its message is one line, whatever stands in the names and texts of the user's that it repeats.
    """

    def __init__(self, message: str = "") -> None:
        super().__init__(" ".join(message.splitlines()))


class InvalidInput(NonsmoothError, ValueError):
    """An argument breaks a rule; nothing was computed."""


class UnknownName(InvalidInput):
    """A model, parameter, solver or option of this name does not exist; the message suggests the nearest one."""


class MissingExtra(NonsmoothError, ImportError):
    """An optional dependency is not installed; the message says which extra brings it."""


class UnsupportedVersion(NonsmoothError, ImportError):
    """A package, or Python itself, is of a version that was not tested; the message says which ones were."""


class CheckpointFailure(NonsmoothError, RuntimeError):
    """A checkpoint could not be written on; what it held before is whole, and can be resumed."""


class FileFailure(NonsmoothError, OSError):
    """A file could not be written; what stood at its place before is unchanged."""


class CellFailure(NonsmoothError, RuntimeError):
    """A cell of a sweep failed, and the sweep was told to stop there; the message has the cell's axis values."""


class NonsmoothWarning(UserWarning):
    """Base class of the package's warnings."""


class InterpretedWarning(NonsmoothWarning):
    """A model function could not be compiled: the same source runs in the interpreter, about a hundred times slower."""


class InitialStateWarning(NonsmoothWarning):
    """The initial state penetrates a contact or violates a bilateral one."""


class EnergyGainWarning(NonsmoothWarning):
    """Impacts gained energy, as Newton's law of impact with friction lets them."""


class FrictionGainWarning(EnergyGainWarning):
    """Friction did work at impacts and drove the slide, as Newton's law of impact lets it."""


class SimultaneousImpactWarning(NonsmoothWarning):
    """Newton's law of impact rebounded several coupled contacts at once: one answer of many."""


class ToleranceWarning(NonsmoothWarning):
    """An absolute tolerance that was not asked for is coarse beside the motion."""


class ModelNotFoundWarning(NonsmoothWarning):
    """A run was read from a file, and the model that it names was not found; its numbers and names are there."""


class ResidualWarning(NonsmoothWarning):
    """Contact problems of a scene were solved to less than the residual that was asked for."""


class PenetrationWarning(NonsmoothWarning):
    """Bodies of a scene were deeper in one another than a part of the smallest of them."""


class NotUnderstoodWarning(NonsmoothWarning):
    """A file of another program has what a scene does not; ``scene.not_understood`` lists it."""


class UnsettledWarning(NonsmoothWarning):
    """A figure of a steady motion was taken of one that still changes."""


class Status(IntEnum):
    """How an integration ended."""

    RUNNING = 0
    FINISHED = 1
    NO_SOLUTION = 2  # the contact problem of a step has no solution at all
    NOT_SOLVED = 3  # no solver reached an acceptable residual
    NOT_FINITE = 4  # a model function raised or wrote NaN or inf
    MASS_NOT_POSITIVE = 5  # the mass matrix (or M + theta dt C + theta^2 dt^2 K) is not positive definite
    NEGATIVE_FRICTION = 6  # a law mu(v) became negative, or no number
    INTERRUPTED = 7  # Ctrl-C
    STEP_VANISHED = 8  # an adaptive step fell below the resolution of time
    CHATTERING = 9  # one contact after the other changed its mode without time passing
    EVENT_REACHED = 10  # a terminal event of the user
    EVENT_FAILED = 11  # an event function of the user raised or returned NaN or inf
    BUDGET_SPENT = 12  # max_steps, or max_wall_time
    CONTRADICTED = 13  # a model function contradicts another, as a row that is no gradient of its gap
    PROGRESS_FAILED = 14  # the progress function of the user raised


def warn_caller(message: str, category: type[Warning]) -> None:
    """Warn at the line outside this package that led here."""
    import sys
    import warnings

    frame, level = sys._getframe(1), 2
    while frame.f_back is not None and frame.f_globals.get("__name__", "").split(".")[0] == "nonsmooth":
        frame, level = frame.f_back, level + 1
    warnings.warn(message, category, stacklevel=level)


def nearest(name: Any, known: Any) -> str:
    """`` Did you mean 'x'?`` for the known names of which a wrong one is a part, as a rod, or an array, or the closest
    to a misspelt one, or the list of all."""
    names, typed = sorted(known), name if isinstance(name, str) else shown(name)
    if not names:
        return "there are none"
    close = [one for one in names if typed in parts_of(one) or one.startswith((f"{typed}[", f"{typed}."))]
    close = close or [one for one in [closest(typed, names)] if one]
    return f"did you mean {' or '.join(map(repr, close))}?" if close else f"known: {', '.join(names)}"


def closest(typed: str, names: list[str]) -> str:
    """The name that a misspelt word is closest to, or to a part of it, as `evnt` to event-driven, or that is short for
    it, as th for theta; nothing where all are far."""
    from difflib import SequenceMatcher

    def alike(name: str) -> float:
        return SequenceMatcher(None, name.casefold(), typed.casefold()).ratio()

    def fit(name: str) -> float:
        parts = [NEAR_PART * alike(part) for part in parts_of(name) if len(part) > 2]
        return max((1.0 + alike(name)) / 2.0 if is_short_for(name, typed) else alike(name), *parts, 0.0)

    fits = {name: fit(name) for name in names}
    best = max(fits, key=fits.__getitem__, default="")
    return best if fits.get(best, 0.0) >= NEAR_WORD else ""


def is_short_for(name: str, word: str) -> bool:
    """Whether the letters of a name stand in a longer word in this order, and begin it: th or thdot for thetadot."""
    rest = iter(word.casefold())
    is_begun = word[:1].casefold() == name[:1].casefold()
    return is_begun and SHORTEST_NAME <= len(name) < len(word) and all(letter in rest for letter in name.casefold())


def parts_of(name: str) -> list[str]:
    """The words of a name."""
    return name.replace("_", "-").split("-")


def said_by(error: BaseException) -> str:
    """An exception of the user's in a message: its kind and what it says, on one line."""
    try:
        said = " ".join(str(error).split())
    except Exception:  # a text of the user's that fails
        said = ""
    said = said if len(said) <= 2 * LONGEST_VALUE else said[: 2 * LONGEST_VALUE - 3] + "..."
    return f"{type(error).__name__}: {said}"


def shown(value: Any) -> str:
    """A value in a message: on one line, and not longer than that."""
    try:
        text = " ".join(repr(value).split())
    except Exception:  # a repr of the user's that fails, an int of too many digits
        text = f"a {type(value).__name__}"
    return text if len(text) <= LONGEST_VALUE else text[: LONGEST_VALUE - 3] + "..."
