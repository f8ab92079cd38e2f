"""A kernel whose compiled code is not on disk runs as Python, where one short question is all that is asked.

Compiling the kernels below a question takes ten seconds to thirty, four contacts a tenth of a second of
Python. A command that asks once allows Python some seconds. Where these are used up, or Python stumbles over
what compiled code takes (a division by zero, say), the arrays are as they were again and all is compiled.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from types import FunctionType
from typing import Any

import numpy as np

from surefoot.base.compilation.clock import compiling

SECONDS = 10.0
"""CPU time that Python may take for kernels in one process: less than compiling takes, 15 s to 30 s for
`surefoot check`, and enough for every stance in examples, of which chimney.yaml takes longest, 6 s [s]."""


class NotKept(Exception):
    """Compiled code is not on disk, and Python may run instead."""


class _Overrun(Exception):
    """Python has had its time."""


class ColdStart:
    """Says whether kernels may run as Python, and runs them.

    Attributes
    ----------
    seconds
        CPU time that is left for that [s]; 0 where kernels are compiled, as they are unless a program asks.
    """

    def __init__(self) -> None:
        self.seconds = 0.0
        self._end = threading.local()
        self._functions: dict[FunctionType, Callable[..., Any]] = {}
        self._modules: dict[int, dict[str, Any]] = {}

    @property
    def allowed(self) -> bool:
        """Whether a kernel may run as Python."""
        return self.seconds > 0.0

    @property
    def inside(self) -> bool:
        """Whether a kernel of this thread runs as Python."""
        return getattr(self._end, "time", None) is not None

    def allow(self, seconds: float = SECONDS) -> None:
        """Allow Python so much CPU time in this process."""
        self.seconds = seconds

    def callable_of(self, kernel: Any, compiled: Callable[[], Any]) -> Callable[..., Any]:
        """Return what calls a kernel as Python, or what it compiles to."""
        return partial(self._run, self.in_python(kernel), compiled)

    def in_python(self, kernel: Any) -> Callable[..., Any]:
        """Return a kernel's Python function, which calls those of the kernels below it."""
        function: FunctionType = kernel.py_func
        made = self._functions.get(function)
        if made is None:
            names = self._names_of(function.__globals__)
            copy = FunctionType(
                function.__code__, names, function.__name__, function.__defaults__, function.__closure__
            )
            calls = any(_is_kernel(function.__globals__.get(name)) for name in function.__code__.co_names)
            made = self._functions[function] = self._watch(copy) if calls else copy
        return made

    def _names_of(self, names: dict[str, Any]) -> dict[str, Any]:
        """Return a module's names, with functions of Python for its kernels."""
        found = self._modules.get(id(names))
        if found is None:
            found = self._modules[id(names)] = dict(names)  # known before its kernels ask for it
            kernels = {name: value for name, value in names.items() if _is_kernel(value)}
            found |= {name: self.in_python(value) for name, value in kernels.items()}
        return found

    def _watch(self, function: FunctionType) -> Callable[..., Any]:
        """Return a function that ends where Python has had its time."""

        def call(*given: Any) -> Any:
            if time.thread_time() > self._end.time:
                raise _Overrun
            return function(*given)

        return call

    def _run(self, function: Callable[..., Any], compiled: Callable[[], Any], *given: Any) -> Any:
        """Return the result of one call."""
        if self.allowed:
            before = [(array, array.copy()) for array in _arrays_in(given) if array.flags.writeable]
            begin = time.thread_time()
            try:
                with self._until(begin + self.seconds), compiling(), np.errstate(all="ignore"):
                    return function(*given)
            except Exception:  # whatever Python stumbles over, compiled code answers
                self.seconds = 0.0
                for array, values in before:
                    array[...] = values
            finally:
                self.seconds = max(self.seconds - (time.thread_time() - begin), 0.0)
        return compiled()(*given)

    @contextmanager
    def _until(self, end: float) -> Iterator[None]:
        """Let kernels below run as Python, too, until this thread's CPU time [s] is so much."""
        self._end.time = end
        try:
            yield
        finally:
            self._end.time = None


def _is_kernel(value: Any) -> bool:
    """Return whether a value is compiled from a function of Python, or written into what is."""
    return isinstance(getattr(value, "py_func", None), FunctionType) and not isinstance(value, FunctionType)


def _arrays_in(values: Any) -> Iterator[np.ndarray]:
    """Return the arrays among arguments and in their tuples."""
    for value in values:
        if isinstance(value, np.ndarray):
            yield value
        elif isinstance(value, tuple):
            yield from _arrays_in(value)


cold_start = ColdStart()
