"""The one decorator for compiled kernels, so that their settings live in one place."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from typing import Any, ParamSpec, TypeVar, cast

import numba
from numba.core import cgutils, event
from numba.extending import intrinsic

from surefoot.base.compilation import Kernel

MATRIX, VECTOR = numba.float64[:, ::1], numba.float64[::1]
REAL, INTEGER, BOOLEAN = numba.float64, numba.int64, numba.boolean
OPTIONS = {"nopython": True, "boundscheck": None, "error_model": "numpy", "no_cfunc_wrapper": True}
COMPILING = not numba.config.DISABLE_JIT
"""Whether kernels are compiled: not under NUMBA_DISABLE_JIT=1."""
P = ParamSpec("P")
R = TypeVar("R")


def kernel(function: Callable[P, R]) -> Callable[P, R]:
    """Compile a function with Numba: nopython, cached on disk, IEEE division.

    No fast-math: kernels must see NaN and infinity as they are. The plain Python function stays
    reachable as `kernel.py_func`; tests compare a kernel with a NumPy twin. Where Numba is switched off
    (NUMBA_DISABLE_JIT=1) it is that function.
    """
    return _compiled(function, OPTIONS)


def releasing_kernel(function: Callable[P, R]) -> Callable[P, R]:
    """Compile a kernel that releases the interpreter's lock while it runs: other threads go on."""
    return _compiled(function, {**OPTIONS, "nogil": True})


def entry_point(function: Callable[P, R], *types: Any) -> Callable[P, R]:
    """Return the compiled function of a kernel for one choice of Numba types, past the look at the arguments.

    That look takes 80 ns, and would compile anew for an array that must not be written. The caller answers
    for the types. Where Numba is switched off, that is the function itself.
    """
    compiled = getattr(function, "compile", None)
    return function if compiled is None else cast("Callable[P, R]", compiled(types))


def inline_kernel(function: Callable[P, R]) -> Callable[P, R]:
    """Compile a function that LLVM should fold into its callers.

    For small ones (3x3 algebra, projections), and for the parts of a kernel that runs for a microsecond: a
    call that is not folded in counts references to every array it is given, about 10 ns each.
    """
    return _compiled(function, {**OPTIONS, "inline": "never", "forceinline": True})


def _compiled(function: Callable[P, R], options: dict[str, Any]) -> Callable[P, R]:
    if not COMPILING:
        function.py_func = function  # type: ignore[attr-defined]
        return function
    return cast("Callable[P, R]", Kernel(function, {}, options))


class _CompilingTime(threading.local, event.Listener):  # type: ignore[misc]
    """How long a thread has had Numba's compiler, or waited for it: nested calls count once."""

    depth, since, total = 0, 0.0, 0.0

    def on_start(self, event: Any) -> None:
        if self.depth == 0:
            self.since = time.perf_counter()
        self.depth += 1

    def on_end(self, event: Any) -> None:
        self.depth -= 1
        if self.depth == 0:
            self.total += time.perf_counter() - self.since


_compiling = _CompilingTime()
event.register("numba:compiler_lock", _compiling)


def working_time() -> float:
    """Return a clock [s] that stands still while this thread compiles kernels or loads compiled ones.

    Bounds on time are kept by it: what is compiled once per machine counts against nobody's `max_time`.
    """
    return time.perf_counter() - _compiling.total


def _borrowed(typing: Any, array: Any) -> Any:
    """Return the same array uncounted."""

    def code(context: Any, builder: Any, signature: Any, given: Any) -> Any:
        out = context.make_array(array)(context, builder, value=given[0])
        out.meminfo, out.parent = (cgutils.get_null_value(part.type) for part in (out.meminfo, out.parent))
        return out._getvalue()

    return array(array), code


def _window(typing: Any, array: Any, start: Any, rows: Any, columns: Any) -> Any:
    """Return a part of an array's memory as a matrix, uncounted."""
    kind = numba.types.Array(array.dtype, 2, "C")
    from numba.np.arrayobj import populate_array  # takes 0.1 s: only where something is compiled

    def code(context: Any, builder: Any, signature: Any, given: Any) -> Any:
        memory = context.make_array(array)(context, builder, value=given[0])
        out, size = context.make_array(kind)(context, builder), memory.itemsize
        populate_array(
            out, data=builder.gep(memory.data, [given[1]]), shape=given[2:], itemsize=size, meminfo=None,
            strides=[builder.mul(given[3], size), size],
        )  # fmt: skip
        return out._getvalue()

    return kind(array, INTEGER, INTEGER, INTEGER), code


def _keep(typing: Any, array: Any) -> Any:
    """Do nothing."""
    return numba.types.none(array), lambda context, *_: context.get_dummy_value()


if COMPILING:
    borrowed: Any = intrinsic(_borrowed)
    """borrowed(array): the same array uncounted; whoever owns it must outlive the last use (`keep`).

    Numba counts references to every array that a variable holds, 10 ns each; kernels of a microsecond notice.
    """
    window: Any = intrinsic(_window)
    """window(array, start, rows, columns): entries of an array's memory as a matrix, uncounted likewise."""
    keep: Any = intrinsic(_keep)
    """keep(array): to be called after the last use of what was borrowed from a local array."""
else:
    borrowed, keep = (lambda array: array), (lambda array: None)

    def window(array: Any, start: int, rows: int, columns: int) -> Any:
        """Return entries of an array's memory as a matrix."""
        return array.reshape(-1)[start : start + rows * columns].reshape(rows, columns)
