"""Machine code of a user's functions, kept with what it was made from."""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any

from nonsmooth.jit import CannotCompile, MachineCode, Unpack, compile_model, interpreted, key_of, survey_of
from nonsmooth.jit.linking import model_at
from nonsmooth.jit.watch import CHANGED, Watch


class Model:
    """A system's functions, ready to be called from a loop.

    Attributes
    ----------
    handle : int or callable
        The ``model`` argument of the loops: an address, or a Python function in the interpreted case.
    is_compiled : bool
    source : (str, tuple)
        Of a compiled one: what tells its functions from others, and the arguments of `compile_model`.
    """

    def __init__(self, handle: Any, keep: Any, is_compiled: bool, watch: Watch, source: Any = None) -> None:
        self.handle = handle
        self._keep = keep
        self.is_compiled = is_compiled
        self._watch = watch
        self.source = source

    @property
    def is_current(self) -> bool:
        """Whether it does what the functions do now: nothing that they read has changed since it was compiled."""
        return self._watch.holds()

    @functools.cached_property
    def call(self) -> Callable[..., bool]:
        """The machine code of a compiled one for calls from Python (`model_at`)."""
        return model_at(self.handle)

    def loop(self, integrator: Any, system: Any) -> Callable:
        """The integrator's loop that fits this model: compiled, or its source."""
        if not self.is_compiled:
            return interpreted(integrator.loop)
        integrator.load(system)
        return integrator.loop.compiled


class Shelf:
    """The machine code of some functions, compiled when it is asked for and again where what they read has changed.

    Parameters are those of `compile_model`.
    """

    def __init__(self, functions: dict[int, Any], n_q: int, n_u: int, unpack: Unpack, n_p: int) -> None:
        self._arguments = functions, n_q, n_u, unpack, n_p
        self._made_from, self._watch = b"", CHANGED
        self._made: MachineCode | CannotCompile | None = None
        self._model: Model | None = None

    def model(self) -> Model:
        """The machine code.

        Raises
        ------
        CannotCompile
        """
        if not self._watch.holds():
            self._update()
        if self._model is None:
            assert isinstance(self._made, CannotCompile)
            raise self._made.with_traceback(None)
        return self._model

    def _update(self) -> None:
        survey = survey_of(*self._arguments)  # imports numba, and refuses one that does not fit before a word is said
        made_from = survey.digest()
        if made_from != self._made_from:
            try:
                self._made = compile_model(*self._arguments, survey)
            except CannotCompile as reason:
                self._made = reason
        made = self._made
        if isinstance(made, MachineCode):
            self._model = Model(made.address, made, True, survey.watch, (key_of(made_from), self._arguments))
        else:
            self._model = None
        self._made_from, self._watch = made_from, survey.watch


class Same:
    """A key that is equal for the same object only: not everything can be a key itself."""

    def __init__(self, function: Any) -> None:
        self.function = function

    def __hash__(self) -> int:
        return id(self.function)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Same) and other.function is self.function
