"""Tables of objects by name, imported when asked for: commands, solvers, tasks, worlds, targets."""

from __future__ import annotations

from collections.abc import Mapping
from pkgutil import resolve_name
from typing import Generic, TypeVar, cast

from surefoot.base.errors import check_name

T = TypeVar("T")


class LazyTable(dict[str, "str | T"], Generic[T]):
    """Names and where their objects are: "module:object", or the object itself.

    Reading the names imports nothing. An assignment adds an entry, or replaces one.

    Parameters
    ----------
    kind
        What the names are of, for the message about an unknown one.
    entries
        Name to entry.

    Examples
    --------
    >>> table = LazyTable("root", {"square": "math:sqrt"})
    >>> table.load("square")(9.0)
    3.0
    """

    def __init__(self, kind: str, entries: Mapping[str, str | T]) -> None:
        super().__init__(entries)
        self.kind = kind

    def load(self, name: object) -> T:
        """Return the object of a name, and import its module if that has not happened yet.

        Raises
        ------
        ProblemError
            For an unknown name, with the valid ones.
        """
        check_name(self.kind, name, self)
        entry = self[cast(str, name)]
        return cast(T, resolve_name(entry)) if isinstance(entry, str) else entry

    def object_name(self, name: str) -> str:
        """Return what the object of a name is called in its module, without an import; empty if nameless."""
        entry = self[name]
        return entry.rpartition(":")[2] if isinstance(entry, str) else str(getattr(entry, "__name__", ""))
