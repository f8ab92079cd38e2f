"""Surefoot: the contact layer for legged robots.

Names are loaded on first use, so that importing the package costs nothing. What is public, and where it
lives, stands in `__init__.pyi` and nowhere else.
"""

from __future__ import annotations

from functools import cache
from typing import Any

__version__ = "0.1.0"


@cache
def _stub() -> tuple[Any, tuple[str, ...]]:
    """Return what loads a name, and all names, from the stub beside this file."""
    import lazy_loader  # reads the stub with `ast`: not before a name is asked for

    load, _, names = lazy_loader.attach_stub(__name__, __file__)
    return load, (*names, "__version__")


def __getattr__(name: str) -> Any:
    load, names = _stub()
    if name == "__all__":
        return list(names)
    if name not in names:
        raise AttributeError(f"module 'surefoot' has no attribute {name!r}")
    return load(name)


def __dir__() -> list[str]:
    return sorted(_stub()[1])
