"""Names that a package shows, loaded when asked for; the list stands in the stub beside `__init__.py`."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any


def face(package: str, file: str, *own: str) -> tuple[Callable[[str], Any], Callable[[], list[str]]]:
    """Return the `__getattr__` and `__dir__` of a package whose names stand in its `__init__.pyi`.

    The stub is read with the first name that is asked for: importing a package costs nothing.

    Parameters
    ----------
    package, file
        The package's `__name__` and `__file__`.
    *own
        Public names that `__init__.py` defines itself.
    """

    @cache
    def stub() -> tuple[Callable[[str], Any], tuple[str, ...]]:
        import lazy_loader  # reads the stub with `ast`

        load, _, names = lazy_loader.attach_stub(package, file)
        return load, (*names, *own)

    def load(name: str) -> Any:
        if name == "__all__":
            return list(stub()[1])
        if name.startswith("__") or name not in stub()[1]:
            # `doctest` and `inspect` ask for names of Python's own by the thousand: no guess for those
            hint = "" if name.startswith("__") else _hint(name, stub()[1])
            raise AttributeError(f"module {package!r} has no attribute {name!r}{hint}", name=name)
        return stub()[0](name)

    return load, lambda: sorted(stub()[1])


OTHER_WORDS = {
    "plot": ("picture", "ANSWER.plot()"),
    "draw": ("picture", "ANSWER.plot()"),
    "show": ("picture", "ANSWER.plot()"),
    "load": ("load_robot", "read_log"),
    "simulate": ("run",),
    "check": ("can_stand", "audit_log"),
    "contact": ("PointContact", "SoleContact", "ContactProblem"),
}
"""Words that people try, in small letters, to the names that do it: where no rule of spelling finds those."""


def _hint(name: str, known: tuple[str, ...]) -> str:
    """Return the question that asks for a known name that is meant; empty where none is near."""
    from surefoot.base.errors import names_with, near_name

    words = OTHER_WORDS.get(name.lower(), ())
    other = [word for word in words if word.startswith("ANSWER") or word in known]
    named = other if len(other) == len(words) and other else names_with(name, known)
    if not named:
        return near_name(name, known)
    *most, last = named
    return f" (did you mean {', '.join(most) + ' or ' if most else ''}{last}?)"
