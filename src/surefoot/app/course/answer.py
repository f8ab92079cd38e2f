"""A student's functions as the checks call them, and what a check says when they are wrong."""

from __future__ import annotations

import copy
import traceback
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from surefoot.base.arrays import FloatArray

LONGEST = 240
"""Characters of a call, or of an error, in a report."""


class PropertyError(Exception):
    """A property does not hold; the message says what came out and what was expected."""


def expect(holds: object, message: str) -> None:
    """Go on if something holds.

    Raises
    ------
    PropertyError
        If not.
    """
    if not holds:
        raise PropertyError(message)


def near(value: Any, right: Any, what: str, tol: float = 1e-5) -> None:
    """Go on if numbers agree to a share `tol` of the largest right one, at least of 1e-3.

    Single precision is precise enough.

    Raises
    ------
    PropertyError
        If not, with both.
    """
    value, right = np.asarray(value, float), np.asarray(right, float)
    scale = max(1e-3, float(np.abs(right).max(initial=0.0)))
    if float(np.abs(value - right).max(initial=0.0)) > tol * scale:
        raise PropertyError(f"{what} is {short(value)}, expected {short(right)}")


def short(value: object) -> str:
    """Return a value in one line that is not long."""
    if isinstance(value, np.ndarray):
        text = np.array2string(value, precision=5, separator=", ", threshold=24, suppress_small=True)
    elif isinstance(value, float | np.floating):
        text = f"{float(value):.6g}"
    else:
        text = repr(value)
    text = " ".join(text.split())
    return text if len(text) <= LONGEST else text[: LONGEST - 4] + " ..."


class Answer:
    """The functions of a student's file.

    Parameters
    ----------
    functions
        By their names.
    file
        The file's name, as its code objects have it.
    announce
        Is given each call before it is made.

    Attributes
    ----------
    last
        The last call, as one would write it; empty before the first.
    """

    def __init__(
        self, functions: Mapping[str, Any], file: str, announce: Callable[[str], None] = lambda call: None
    ) -> None:
        self._functions = functions
        self._file = file
        self._announce = announce
        self.last = ""

    def call(self, name: str, *given: Any) -> Any:
        """Return what a function returns for copies of these arguments.

        Raises
        ------
        PropertyError
            If it is missing, not written yet, or raises.
        """
        self.last = f"{name}({', '.join(map(short, given))})"
        self._announce(self.last)
        if not callable(function := self._functions.get(name)):
            raise PropertyError("there is no such function in the file")
        try:
            return function(*copy.deepcopy(given))
        except NotImplementedError:
            raise PropertyError("it is not written yet") from None
        except (Exception, SystemExit) as error:
            raise PropertyError(self._describe(error)) from None

    def numbers(self, shape: tuple[int, ...], name: str, *given: Any) -> FloatArray:
        """Return finite numbers (...) of this `shape` from a function, () for a single one.

        A column or a row is as good as a list, and an array with one number as that number.

        Raises
        ------
        PropertyError
            If it returns something else.
        """
        found = self.call(name, *given)
        expect(found is not None and not np.iscomplexobj(found), f"it returns {short(found)}, not numbers")
        try:
            out = np.array(found, dtype=float)
        except (TypeError, ValueError):
            raise PropertyError(f"it returns {short(found)}, not numbers") from None
        if out.shape != shape and [n for n in out.shape if n != 1] == [n for n in shape if n != 1]:
            out = out.reshape(shape)
        if out.shape != shape:
            expected = "one number" if shape == () else f"numbers of the shape {shape}"
            raise PropertyError(f"it returns the shape {out.shape}, expected {expected}")
        expect(np.isfinite(out).all(), f"it returns {short(out)}, which is not finite")
        return out

    def number(self, name: str, *given: Any) -> float:
        """Return one finite number from a function; see `numbers`."""
        return float(self.numbers((), name, *given))

    def truth(self, name: str, *given: Any) -> bool:
        """Return True or False from a function.

        Raises
        ------
        PropertyError
            If it returns something else.
        """
        found = self.call(name, *given)
        expect(
            isinstance(found, bool | np.bool_) or (isinstance(found, np.ndarray) and found.size == 1),
            f"it returns {short(found)}, expected True or False",
        )
        return bool(found)

    def several(self, count: int, name: str, *given: Any) -> tuple[Any, ...]:
        """Return so many values, a tuple of them, from a function.

        Raises
        ------
        PropertyError
            If it returns something else.
        """
        found = self.call(name, *given)
        expect(
            isinstance(found, tuple | list | np.ndarray) and len(found) == count,
            f"it returns {short(found)}, expected {count} values",
        )
        return tuple(found)

    def _describe(self, error: BaseException) -> str:
        """Return an error of the student's code, with the line in which it arose."""
        own = [s for s in traceback.extract_tb(error.__traceback__) if s.filename == self._file]
        where = f" (line {own[-1].lineno})" if own else ""
        text = " ".join(str(error).split())[:LONGEST]
        return f"it raises {type(error).__name__}{': ' if text else ''}{text}{where}"


Check = Callable[[Answer, np.random.Generator], None]


@dataclass(frozen=True)
class Property:
    """What must hold for a right answer.

    Attributes
    ----------
    words
        The property as a sentence.
    check
        Draws an input and raises PropertyError where the property does not hold for it.
    trials
        How many inputs are drawn.
    """

    words: str
    check: Check
    trials: int = 20


class Properties:
    """Properties by exercise, as a module of them collects its own."""

    def __init__(self) -> None:
        self._all: dict[str, list[Property]] = {}

    def holds(self, exercise: str, words: str, trials: int = 20) -> Callable[[Check], Check]:
        """Note the decorated check as a property of an exercise."""

        def note(check: Check) -> Check:
            self._all.setdefault(exercise, []).append(Property(words, check, trials))
            return check

        return note

    def of(self, exercise: str) -> Iterable[Property]:
        """Return the properties of an exercise, in the order of the module."""
        return self._all[exercise]
