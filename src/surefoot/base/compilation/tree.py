"""What a kernel is compiled from: its own code, that of all kernels below it, the constants they read."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from types import CodeType, FunctionType, ModuleType
from typing import Any

import llvmlite
import numba
import numpy as np

PACKAGE = __name__.partition(".")[0]
FORMAT = 1
"""Part of every key: to be raised when kernels are compiled otherwise than before."""
Insides = Callable[[Any], "tuple[FunctionType | CodeType, str] | None"]
"""Returns what a compiled object is made from, and what else changes its code; None for another object."""


@dataclass
class KernelTree:
    """A kernel and all that it calls.

    Attributes
    ----------
    insides
        What looks into compiled functions and intrinsics.
    functions
        The Python functions.
    key
        Hash of their code and of the constants that they read, of the versions that compile them.
    """

    insides: Insides
    functions: list[FunctionType] = field(default_factory=list)
    key: str = ""

    @classmethod
    def below(cls, kernel: Any, insides: Insides) -> KernelTree:
        """Return the tree of a kernel."""
        tree, feed = cls(insides), hashlib.sha256()
        versions = numba.__version__, llvmlite.__version__, np.__version__, FORMAT
        feed.update(repr(versions).encode())
        for text in tree._of_value(kernel, ()):
            feed.update(text)
            feed.update(b"\0")
        tree.key = feed.hexdigest()
        return tree

    @property
    def name(self) -> str:
        """What the kernel is called."""
        return str(self.functions[0].__name__)

    @property
    def size(self) -> int:
        """Bytes of Python's code, which the time to compile follows."""
        return sum(len(f.__code__.co_code) for f in self.functions)

    def _of_value(self, value: Any, names: Iterable[str]) -> Iterable[bytes]:
        """Return what there is to say of a value that a function reads; `names` are those in its code."""
        if (inside := self.insides(value)) is not None:
            # options change what is compiled from the same code
            value, options = inside
            yield options.encode()
        if isinstance(value, FunctionType):
            yield f"{value.__module__}.{value.__qualname__}".encode()
            # once each: kernels of a tree share functions
            if value not in self.functions:
                self.functions.append(value)
                yield from self._of_function(value)
        elif isinstance(value, CodeType):
            # of an intrinsic: its own code; what Numba has below it goes with Numba's version
            for code in _codes(value):
                yield code.co_code
                yield repr(
                    (code.co_names, [c for c in code.co_consts if not isinstance(c, CodeType)])
                ).encode()
        elif isinstance(value, ModuleType):
            yield value.__name__.encode()
            if value.__name__.partition(".")[0] == PACKAGE:
                # of a module of this package what the code may read: any name in the code that the module has
                for name in names:
                    if name in vars(value):
                        yield from self._of_value(vars(value)[name], names)
        elif isinstance(value, (tuple, list)):
            yield f"{type(value).__qualname__} {len(value)}".encode()
            for item in value:
                yield from self._of_value(item, names)
        elif isinstance(value, np.ndarray):
            yield f"{value.dtype} {value.shape} {value.strides}".encode() + value.tobytes()
        elif isinstance(value, type):
            # the values of an enum are constants of the kernels that read it
            parts = getattr(value, "_fields", getattr(value, "__members__", ""))
            yield f"{value.__module__}.{value.__qualname__} {parts}".encode()
        elif isinstance(value, (frozenset, set)):
            yield repr(sorted(map(repr, value))).encode()
        else:
            # an address says nothing, and differs in every process
            text = repr(value)
            yield f"{type(value)} {'' if ' at 0x' in text else text}".encode()

    def _of_function(self, function: FunctionType) -> Iterable[bytes]:
        codes = list(_codes(function.__code__))
        for code in codes:
            yield code.co_code
            yield repr((code.co_names, code.co_varnames, code.co_argcount)).encode()
            for constant in code.co_consts:
                if not isinstance(constant, CodeType):
                    yield from self._of_value(constant, ())
        yield from self._of_value(function.__defaults__ or (), ())
        names = sorted({name for code in codes for name in code.co_names})
        for name in names:
            if name in function.__globals__:
                yield name.encode()
                yield from self._of_value(function.__globals__[name], names)


def _codes(code: CodeType) -> Iterable[CodeType]:
    """Return a function's code and that of the functions in it."""
    yield code
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            yield from _codes(constant)
