"""Arrays that Numba does not count references to, by private parts of it that `numba_internals` looks at."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numba
from numba.core import cgutils  # get_null_value(type): a null of an LLVM type
from numba.extending import _Intrinsic  # _register: makes its name known to kernels

from surefoot.base.compilation import in_python


def _borrowed(typing: Any, array: Any) -> Any:
    """Return the same array uncounted. Relied upon: an array without `meminfo` is counted by nobody."""

    def code(context: Any, builder: Any, signature: Any, given: Any) -> Any:
        out = context.make_array(array)(context, builder, value=given[0])
        out.meminfo, out.parent = (cgutils.get_null_value(part.type) for part in (out.meminfo, out.parent))
        return out._getvalue()

    return array(array), code


def _window(typing: Any, array: Any, start: Any, rows: Any, columns: Any) -> Any:
    """Return a part of an array's memory as a matrix, uncounted."""
    kind, integer = numba.types.Array(array.dtype, 2, "C"), numba.int64
    from numba.np.arrayobj import populate_array  # takes 0.1 s: only where something is compiled

    def code(context: Any, builder: Any, signature: Any, given: Any) -> Any:
        memory = context.make_array(array)(context, builder, value=given[0])
        out, size = context.make_array(kind)(context, builder), memory.itemsize
        populate_array(
            out, data=builder.gep(memory.data, [given[1]]), shape=given[2:], itemsize=size, meminfo=None,
            strides=[builder.mul(given[3], size), size],
        )  # fmt: skip
        return out._getvalue()

    return kind(array, integer, integer, integer), code


def _keep(typing: Any, array: Any) -> Any:
    """Do nothing."""
    return numba.types.none(array), lambda context, *_: context.get_dummy_value()


class _Written(_Intrinsic):  # type: ignore[misc]
    """What is written into a kernel's code, and what Python does in its place."""

    def __init__(self, code: Callable[..., Any], in_python: Callable[..., Any]) -> None:
        super().__init__(code.__name__, code)
        self.py_func = in_python
        self._register()

    def __call__(self, *given: Any) -> Any:
        """Return what a kernel would be given."""
        return self.py_func(*given)


borrowed: Any = _Written(_borrowed, in_python.borrowed)
window: Any = _Written(_window, in_python.window)
keep: Any = _Written(_keep, in_python.keep)
