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
            from surefoot.base.errors import near_name

            hint = near_name(name, stub()[1])
            raise AttributeError(f"module {package!r} has no attribute {name!r}{hint}", name=name)
        return stub()[0](name)

    return load, lambda: sorted(stub()[1])
