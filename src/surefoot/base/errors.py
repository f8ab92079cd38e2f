"""Errors that Surefoot raises on purpose; everything else is a bug."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from typing import Any


class SurefootError(Exception):
    """Base of every error that Surefoot raises on purpose."""


class ProblemError(SurefootError, ValueError):
    """Input that does not describe a problem: wrong shape, NaN, negative friction, ..."""


class ModelError(SurefootError, ValueError):
    """A robot, foot, frame or terrain that cannot be found or built."""


class SolverNotFound(SurefootError, LookupError):
    """A solver name that is unknown, or whose optional package is not installed."""


class MissingExtra(SurefootError, ImportError):
    """Optional packages are needed; the message names them all and the extras that install them.

    Attributes
    ----------
    packages, extras
        What is missing, and the extras of Surefoot that bring it.

    Examples
    --------
    >>> print(MissingExtra(["pin", "mujoco"], ["robot", "sim"]))
    pin and mujoco are not installed; run: pip install -e '.[robot,sim]'
    """

    def __init__(self, packages: str | Iterable[str], extras: str | Iterable[str]) -> None:
        self.packages, self.extras = _unique(packages), _unique(extras)
        *most, last = self.packages
        named = f"{', '.join(most)} and {last} are" if most else f"{last} is"
        super().__init__(f"{named} not installed; run: pip install -e '.[{','.join(self.extras)}]'")

    @classmethod
    def of(cls, errors: Iterable[MissingExtra]) -> MissingExtra:
        """Return one error that names what several name."""
        listed = list(errors)
        return cls([p for e in listed for p in e.packages], [x for e in listed for x in e.extras])


def _unique(names: str | Iterable[str]) -> tuple[str, ...]:
    """Return the names without repetition, in their order."""
    return tuple(dict.fromkeys([names] if isinstance(names, str) else names))


@contextmanager
def needs(package: str, extra: str) -> Iterator[None]:
    """Name the extra of Surefoot that brings a package where an import in this context fails.

    Raises
    ------
    MissingExtra
        Where something cannot be imported.
    """
    try:
        yield
    except ImportError as error:
        raise MissingExtra(package, extra) from error


@contextmanager
def located(where: object) -> Iterator[None]:
    """Put what is at fault, a file or an entry of one, before the message of a ProblemError of this context.

    Raises
    ------
    ProblemError
        In place of the one that was raised.
    """
    try:
        yield
    except ProblemError as error:
        raise ProblemError(f"{where}: {error}") from error


class WriteError(SurefootError, OSError):
    """A file that cannot be written: the disk is full, a quota is used up, ...

    Parameters
    ----------
    path
        What was to be written.
    cause
        The system's own error.
    kept
        What is left all the same, to be added to the message.
    """

    def __init__(self, path: object, cause: OSError, kept: str = "") -> None:
        super().__init__(f"cannot write {path}: {cause.strerror or cause}{kept}")


@contextmanager
def writing(path: object) -> Iterator[None]:
    """Name what is written in this context where the system does not let it.

    Raises
    ------
    WriteError
        In place of an OSError.
    """
    try:
        yield
    except OSError as error:
        raise WriteError(path, error) from error


class NoSolution(SurefootError, RuntimeError):
    """Raised by `ContactSolution.raise_if_failed`; carries the problem and what was reached."""

    def __init__(self, message: str, problem: Any = None, solution: Any = None) -> None:
        super().__init__(message)
        self.problem = problem
        self.solution = solution


class SimulationError(SurefootError, RuntimeError):
    """A step that cannot be taken: the state would not stay finite, or the motion is too fast to resolve.

    The world that raises it stays in its last finite state.

    Attributes
    ----------
    what
        What was lost: "motion", "contact problem", ...
    time
        Start of the step that was not taken [s].
    """

    def __init__(self, what: str, time: float, dt: float, joint: str, speed: float) -> None:
        super().__init__(
            f"at {time:.6g} s the {what} became non-finite or too fast to resolve; the fastest joint, "
            f"{joint}, moved at {speed:.4g} (rad/s, m/s): take a smaller dt (now {dt:g} s), or lower gains "
            "and torques"
        )
        self.what = what
        self.time = time


def unknown_name(kind: str, name: object, valid: Iterable[str]) -> str:
    """Return the one-line message for a name that is not in a list.

    >>> unknown_name("gait", "hop", ["trot", "walk"])
    "unknown gait 'hop'; valid names: trot, walk"
    """
    known = sorted({str(one) for one in valid if one != ""})
    names = ", ".join(known) or "none, nothing has a name"
    near = _nearest(name, known)
    return f"unknown {kind} {shown(name)}; valid names: {names}" + (f"; did you mean {near}?" if near else "")


def near_name(name: object, valid: Iterable[str]) -> str:
    """Return the question that a message asks where a known name is near, in brackets; else nothing.

    >>> near_name("trott", ["trot", "walk"])
    ' (did you mean trot?)'
    """
    near = _nearest(name, valid)
    return f" (did you mean {near}?)" if near else ""


def names_with(word: str, valid: Iterable[str], most: int = 3) -> list[str]:
    """Return known names that a word is a part of, whatever its capitals: whole words only.

    >>> names_with("Contact", ["ContactSolver", "PointContact", "contact_times", "contacted"])
    ['ContactSolver', 'PointContact', 'contact_times']
    """
    import re

    def parts(name: str) -> list[str]:
        return [one.lower() for one in re.findall(r"[A-Z]?[a-z0-9]+|[A-Z]+", name)]

    asked = parts(word)
    n = len(asked)

    def held(name: str) -> bool:
        own = parts(name)
        return bool(n) and any(own[k : k + n] == asked for k in range(len(own) - n + 1))

    return [name for name in valid if held(name)][:most]


def _nearest(name: object, valid: Iterable[str]) -> str:
    """Return the known name that may be meant, whatever its capitals; empty for none."""
    import difflib

    known = {str(one).lower(): str(one) for one in valid}
    asked = name.lower()[:80] if isinstance(name, str) else ""
    found = difflib.get_close_matches(asked, known, n=1)
    return known[found[0]] if found else ""


def shown(value: object) -> str:
    """Return a value as a message shows it: one short line, whatever it is.

    >>> shown(10**5000)
    'a value of type int'
    """
    try:
        return " ".join(f"{value!r:.80}".split())
    except Exception:  # a foreign object's own, or a whole number of too many digits
        return f"a value of type {type(value).__name__}"


def count_of(number: int, noun: str) -> str:
    """Return a number with its noun.

    >>> count_of(1, "contact"), count_of(4, "contact")
    ('1 contact', '4 contacts')
    """
    return f"{number:,} {noun}{'' if number == 1 else 's'}"


def one_line(error: BaseException) -> str:
    """Return what an error says in one line, as messages of the command line are."""
    return " ".join(str(error).split())


def mujoco_line(error: Exception) -> str:
    """Return what an error of MuJoCo says, in one line."""
    return one_line(error).removeprefix("Error: ")


def check_name(kind: str, name: object, valid: Iterable[str], where: str = "") -> None:
    """Refuse a name that is not in a list.

    Parameters
    ----------
    kind, name, valid
        See `unknown_name`.
    where
        What holds the name, for the message; empty for nothing.

    Raises
    ------
    ProblemError
        With the message of `unknown_name`.
    """
    known = tuple(valid)
    if not isinstance(name, str | int) or name not in known:
        raise ProblemError((f"{where}: " if where else "") + unknown_name(kind, name, known))
