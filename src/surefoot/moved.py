"""Names that have moved: found at their new home for one release, with a warning."""

from __future__ import annotations

import importlib
import warnings
from collections.abc import Callable
from typing import Any


def moved(old: str, homes: dict[str, str]) -> Callable[[str], Any]:
    """Return a module's ``__getattr__`` for names that have moved.

    Parameters
    ----------
    old
        The module that they were in, its ``__name__``.
    homes
        Name to its new place: "module" where it keeps its name, else "module:name".
    """

    def find(name: str) -> Any:
        if name not in homes:
            raise AttributeError(f"module {old!r} has no attribute {name!r}")
        module, _, new = homes[name].partition(":")
        new = new or name
        warnings.warn(f"{old}.{name} is now {module}.{new}", DeprecationWarning, stacklevel=2)
        return getattr(importlib.import_module(module), new)

    return find
