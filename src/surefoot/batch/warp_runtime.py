"""Warp, imported here and nowhere else, and the types of its kernels."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from surefoot.errors import MissingExtra

try:
    import warp as wp
except ImportError as error:
    raise MissingExtra("warp-lang", "warp") from error

if TYPE_CHECKING:
    from typing import TypeAlias

    Real: TypeAlias = Any
    Vector: TypeAlias = Any
    Matrix: TypeAlias = Any
    Integers: TypeAlias = Any
else:
    Real = wp.float64
    Vector, Matrix = wp.array(dtype=wp.float64), wp.array2d(dtype=wp.float64)
    Integers = wp.array(dtype=wp.int32)

__all__ = ["Integers", "Matrix", "Real", "Vector", "wp"]
