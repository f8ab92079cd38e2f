"""The one decorator for compiled kernels, so that their settings live in one place."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, ParamSpec, TypeVar, cast

import numba

from surefoot.base import compilation
from surefoot.base.compilation import working_time

__all__ = [
    "BOOLEAN",
    "INTEGER",
    "MATRIX",
    "REAL",
    "VECTOR",
    "borrowed",
    "entry_point",
    "inline_kernel",
    "keep",
    "kernel",
    "releasing_kernel",
    "takes_kernels",
    "window",
    "working_time",
]

MATRIX, VECTOR = numba.float64[:, ::1], numba.float64[::1]
REAL, INTEGER, BOOLEAN = numba.float64, numba.int64, numba.boolean
P = ParamSpec("P")
R = TypeVar("R")


def kernel(function: Callable[P, R]) -> Callable[P, R]:
    """Compile a function with Numba: nopython, cached on disk, IEEE division.

    No fast-math: kernels must see NaN and infinity as they are. The plain Python function stays
    reachable as `kernel.py_func`; tests compare a kernel with a NumPy twin. Where Numba is switched off
    (NUMBA_DISABLE_JIT=1) it is that function.
    """
    return cast("Callable[P, R]", compilation.compiled(function))


def releasing_kernel(function: Callable[P, R]) -> Callable[P, R]:
    """Compile a kernel that releases the interpreter's lock while it runs: other threads go on."""
    return cast("Callable[P, R]", compilation.compiled(function, releasing=True))


def entry_point(function: Callable[P, R], *types: Any) -> Callable[P, R]:
    """Return the compiled function of a kernel for one choice of Numba types, past the look at the arguments.

    That look takes 80 ns, and would compile anew for an array that must not be written. The caller answers
    for the types. Where Numba is switched off, that is the function itself.
    """
    return cast("Callable[P, R]", compilation.entry_point(function, types))


def inline_kernel(function: Callable[P, R]) -> Callable[P, R]:
    """Compile a function that LLVM should fold into its callers.

    For small ones (3x3 algebra, projections), and for the parts of a kernel that runs for a microsecond: a
    call that is not folded in counts references to every array it is given, about 10 ns each.
    """
    return cast("Callable[P, R]", compilation.compiled(function, folded=True))


def takes_kernels(function: Callable[P, R]) -> Callable[P, R]:
    """Mark a function, below its decorator, that is given kernels as arguments.

    Plain Numba would write their addresses into the code, which could then not be kept: where kernels are
    compiled that way, the function is written into its callers before it is compiled.
    """
    function.takes_kernels = True  # type: ignore[attr-defined]
    return function


borrowed: Any = compilation.borrowed
"""borrowed(array): the same array uncounted; whoever owns it must outlive the last use (`keep`).

Numba counts references to every array that a variable holds, 10 ns each; kernels of a microsecond notice.
Where kernels are compiled the plain way (`base.compilation`), and in Python, it is the array, counted.
"""
window: Any = compilation.window
"""window(array, start, rows, columns): entries of an array's memory as a matrix, uncounted likewise."""
keep: Any = compilation.keep
"""keep(array): to be called after the last use of what was borrowed from a local array."""
