"""Names that moved: their old places work for one release."""

from __future__ import annotations

import importlib
import warnings
from collections.abc import Callable, Mapping
from typing import Any


def moved(module: str, homes: Mapping[str, str]) -> Callable[[str], Any]:
    """Return the `__getattr__` of a module whose names now live elsewhere.

    Parameters
    ----------
    module
        The old module's `__name__`.
    homes
        Name to the module that defines it now.
    """

    def find(name: str) -> Any:
        if name not in homes:
            raise AttributeError(f"module {module!r} has no attribute {name!r}")
        home = homes[name]
        told = f"{module}.{name} is now {home}.{name}; the old place goes with the next release"
        warnings.warn(told, DeprecationWarning, stacklevel=2)
        return getattr(importlib.import_module(home), name)

    return find
