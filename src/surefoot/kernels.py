"""The one decorator for compiled kernels, so that their settings live in one place."""

from __future__ import annotations

from collections.abc import Callable
from typing import ParamSpec, TypeVar, cast

import numba

P = ParamSpec("P")
R = TypeVar("R")


def kernel(function: Callable[P, R]) -> Callable[P, R]:
    """Compile a function with Numba: nopython, cached on disk, IEEE division.

    No fast-math: kernels must see NaN and infinity as they are. The plain Python function stays
    reachable as `kernel.py_func`; tests compare a kernel with a NumPy twin.
    """
    return cast("Callable[P, R]", numba.njit(cache=True, error_model="numpy")(function))


def inline_kernel(function: Callable[P, R]) -> Callable[P, R]:
    """Compile a function that LLVM should fold into its callers.

    For small ones (3x3 algebra, projections), and for the parts of a kernel that runs for a microsecond: a
    call that is not folded in counts references to every array it is given, about 10 ns each.
    """
    return cast(
        "Callable[P, R]",
        numba.njit(cache=True, error_model="numpy", inline="never", forceinline=True)(function),
    )
