"""What `borrowed`, `window` and `keep` are where arrays are counted: in Python, and in plain Numba."""

from __future__ import annotations

from typing import Any


def borrowed(array: Any) -> Any:
    """Return the same array."""
    return array


def window(array: Any, start: int, rows: int, columns: int) -> Any:
    """Return entries of an array's memory as a matrix."""
    return array.reshape(array.size)[start : start + rows * columns].reshape(rows, columns)


def keep(array: Any) -> None:
    """Do nothing: whoever holds an array keeps it."""
