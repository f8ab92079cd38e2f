"""What an outside solver is to the package: a class that takes a `ConeProgram` in its own words."""

from __future__ import annotations

import importlib
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, ClassVar

from surefoot.base.errors import needs
from surefoot.contact.solvers.backends.program import ConeProgram, Outcome

Call = Callable[[], Any]
"""Hands a program over, solves it and returns what the library returns, for `Backend.read`."""


@dataclass(frozen=True)
class Options:
    """How a backend runs.

    Attributes
    ----------
    tol
        Tolerance of its own stopping test; None for its default.
    max_iterations, max_time
        Of its own kind, None for its default; [s].
    keep
        Where it can, go on with the workspace of the last program of the same pattern.
    warm
        With `keep`: start at the last answer, where it can.
    sparse
        Of backends with two forms, the sparse one.
    own
        Settings by the solver's own names, after all others.
    """

    tol: float | None = None
    max_iterations: int | None = None
    max_time: float = float("inf")
    keep: bool = False
    warm: bool = False
    sparse: bool = False
    own: Mapping[str, Any] = field(default_factory=dict)


class Backend(ABC):
    """An outside solver with its settings and, if wanted, its workspaces from call to call.

    A program is made `ready`, a `call` hands it over and solves it, its answer is `read`: three steps, so
    that a benchmark can time the second alone.

    Attributes
    ----------
    name, package
        In `BACKENDS`; what is imported.
    takes_cones, keeps_workspace, warm_starts, has_tol
        What it can do.
    tol_words, iterations_word, time_word
        Its own names of the options `tol`, `max_iterations` and `max_time`, as far as it has them.

    Raises
    ------
    MissingExtra
        If its package is not installed.
    """

    name: ClassVar[str]
    package: ClassVar[str]
    takes_cones: ClassVar[bool] = False
    keeps_workspace: ClassVar[bool] = False
    warm_starts: ClassVar[bool] = False
    has_tol: ClassVar[bool] = True
    tol_words: ClassVar[tuple[str, ...]] = ()
    iterations_word: ClassVar[str | None] = None
    time_word: ClassVar[str | None] = None

    def __init__(self, options: Options | None = None) -> None:
        self.options = options or Options()
        with needs(self.package, "qp"):
            self.module: Any = importlib.import_module(self.package)
        self._kept: dict[Any, Any] = {}

    def _words(self) -> dict[str, Any]:
        """Return the options by the solver's own names; what is not asked for is left out."""
        given = self.options
        words = {} if given.tol is None else dict.fromkeys(self.tol_words, given.tol)
        most = None if given.max_time == float("inf") else given.max_time
        for word, value in ((self.iterations_word, given.max_iterations), (self.time_word, most)):
            if word is not None and value is not None:
                words[word] = value
        return {**words, **given.own}

    def _set(self, settings: Any) -> None:
        """Write the options into the attributes of a settings object."""
        for name, value in self._words().items():
            setattr(settings, name, value)

    def solve(self, program: ConeProgram) -> Outcome:
        """Solve a program."""
        return self.read(self.call(self.ready(program))())

    @abstractmethod
    def ready(self, program: ConeProgram) -> Any:
        """Return a program in the solver's own words.

        Raises
        ------
        ProblemError
            If the solver does not take one of its cones.
        """

    def call(self, item: Any) -> Call:
        """Return the call that hands a ready program over and solves it; item[0] is its pattern."""
        keep = self.options.keep and self.keeps_workspace
        solver = self._kept.get(item[0]) if keep else None
        if solver is not None:
            change = self._change(item)

            def again() -> Any:
                self._update(solver, change)
                return self._run(solver)

            return again

        def fresh() -> Any:
            made = self._set_up(item)
            if keep:
                self._kept[item[0]] = made
            return self._run(made)

        return fresh

    def _set_up(self, item: Any) -> Any:
        """Return a new workspace with a program in it; for a solver without one, the program."""
        return item

    @abstractmethod
    def _run(self, solver: Any) -> Any:
        """Solve what is in a workspace and return the library's answer."""

    @abstractmethod
    def read(self, answer: Any) -> Outcome:
        """Return the library's answer in our words; at once, for some overwrite it in their next call."""

    def _change(self, item: Any) -> Any:
        """Return what a workspace of the same pattern has to be told; not timed."""
        return item

    def _update(self, solver: Any, change: Any) -> None:
        """Hand a change to a workspace."""
        raise NotImplementedError(f"{self.name} cannot go on from its last program")
