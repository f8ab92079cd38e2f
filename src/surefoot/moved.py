"""Names that have moved: found for one release where they were, with a warning that says where they are."""

from __future__ import annotations

import importlib
import warnings
from collections.abc import Callable
from typing import Any


def moved(old: str, homes: dict[str, tuple[str, str]]) -> Callable[[str], Any]:
    """Return a module's ``__getattr__`` for names that have moved.

    Parameters
    ----------
    old
        The module that they were in, its ``__name__``.
    homes
        Name to the module that has what it stood for, and to what should be written from now on.
    """

    def find(name: str) -> Any:
        if name not in homes:
            raise AttributeError(f"module {old!r} has no attribute {name!r}")
        module, new = homes[name]
        warnings.warn(f"{old}.{name} is now {new}", DeprecationWarning, stacklevel=2)
        home = importlib.import_module(module)
        return getattr(home, name, None) or getattr(home, new.rpartition(".")[2])

    return find
