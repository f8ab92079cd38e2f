"""Arrays that a pickle describes, made from their bytes, shape and type.

A file may name the classes of `CLASSES` alone, and each stands for a function of this module: no code of the
file's runs, nor NumPy's or joblib's own unpickling.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from math import prod
from typing import IO, Any

import numpy as np

from surefoot.base.errors import ProblemError

KINDS = "biufcSU"
"""NumPy's kinds of types whose bytes are values: no pointers to objects, no records."""


class Refused(ProblemError):
    """Something in a pickle that arrays, numbers, texts, lists and mappings do not need."""


@dataclass
class DtypePart:
    """A NumPy type as a pickle describes it: its code, and its byte order once that has been set."""

    code: str
    order: str = "<"

    def fill(self, state: Any) -> None:
        """Take the byte order out of the state of a pickled type."""
        if not isinstance(state, tuple) or len(state) < 2 or state[1] not in ("<", ">", "|", "="):
            raise Refused("it holds an array type of records, which motions do not have")
        self.order = state[1]

    @property
    def objects(self) -> bool:
        """Whether entries are Python objects."""
        return self.code.startswith("O")

    def dtype(self) -> np.dtype[Any]:
        """Return NumPy's type."""
        try:
            order: Any = "=" if self.order == "|" else self.order
            made = np.dtype(str(self.code)).newbyteorder(order)
        except (TypeError, ValueError) as error:
            raise Refused(f"it holds arrays of the type {self.code!r:.40}, which are no numbers") from error
        if made.kind not in KINDS:
            raise Refused(f"it holds arrays of the type {self.code!r:.40}, which are no numbers")
        return made


@dataclass
class ArrayPart:
    """An array that a pickle makes empty and fills afterwards."""

    value: Any = None

    def fill(self, state: Any) -> None:
        """Make the array from its pickled state: version, shape, type, column order, contents."""
        _, shape, dtype, columns, contents = state
        self.value = shape_array(shape, dtype, "F" if columns else "C", contents)


@dataclass
class JoblibPart:
    """An array of joblib's: its bytes follow in the file when its description is complete."""

    fields: dict[str, Any] = field(default_factory=dict)
    value: Any = None

    def fill(self, state: Any) -> None:
        """Take the description."""
        if not isinstance(state, dict):
            raise Refused("an array of joblib's has no description")
        self.fields = state

    @property
    def objects(self) -> bool:
        """Whether a pickle of objects follows, and no bytes."""
        return bool(getattr(self.fields.get("dtype"), "objects", False))

    def take(self, file: IO[bytes]) -> None:
        """Read the array that follows in the file."""
        dtype, shape = self.fields.get("dtype"), self.fields.get("shape")
        if not isinstance(dtype, DtypePart) or not isinstance(shape, tuple):
            raise Refused("an array of joblib's has no type or shape")
        if self.fields.get("numpy_array_alignment_bytes") is not None:
            file.read(int.from_bytes(file.read(1), "little"))
        size = count_entries(shape) * dtype.dtype().itemsize
        self.value = shape_array(shape, dtype, str(self.fields.get("order", "C")), file.read(size))


def count_entries(shape: Any) -> int:
    """Return the number of entries of a shape, or refuse what is none."""
    whole = isinstance(shape, tuple) and all(isinstance(n, int) and 0 <= n < 2**40 for n in shape)
    if not whole or len(shape) > 8:
        raise Refused(f"an array has the shape {shape!r:.60}")
    return prod(shape)


def shape_array(shape: Any, dtype: Any, order: str, contents: Any) -> Any:
    """Return the array of a shape and type from its bytes, or from a list of what it holds."""
    count = count_entries(shape)
    if not isinstance(dtype, DtypePart):
        raise Refused("an array has no type")
    if dtype.objects:
        if not isinstance(contents, list) or len(contents) != count:
            raise Refused("an array of objects does not hold as many as its shape has")
        return contents if len(shape) == 1 else nest_list(contents, shape)
    if isinstance(contents, str):  # protocol 2 of Python 2 writes bytes as text
        contents = contents.encode("latin-1", "replace")
    kind = dtype.dtype()
    if not isinstance(contents, bytes | bytearray) or len(contents) != count * kind.itemsize:
        size = len(contents) if isinstance(contents, bytes | bytearray) else 0
        raise Refused(f"an array of shape {shape} needs {count * kind.itemsize} bytes, the file has {size}")
    flat = np.frombuffer(bytes(contents), kind).astype(kind.newbyteorder("="))
    return flat.reshape(shape, order="F" if order == "F" else "C")


def nest_list(contents: list[Any], shape: tuple[int, ...]) -> Any:
    """Return a list of objects as lists of lists; the only one as itself for an array without axes."""
    if not shape:
        return contents[0]
    if len(shape) == 1:
        return contents
    step = prod(shape[1:])
    return [nest_list(contents[k * step : (k + 1) * step], shape[1:]) for k in range(shape[0])]


def _dtype(code: Any, *_: Any) -> DtypePart:
    return DtypePart(str(code))


def _scalar(dtype: Any, contents: Any = b"") -> Any:
    return shape_array((), dtype, "C", contents)[()] if not getattr(dtype, "objects", True) else contents


def _from_buffer(contents: Any, dtype: Any, shape: Any, order: Any) -> Any:
    return shape_array(shape, dtype, str(order), contents)


def _encode(text: Any, encoding: Any = "latin1") -> bytes:
    if not isinstance(text, str) or encoding not in ("latin1", "latin-1"):
        raise Refused("it encodes a text other than as bytes")
    return text.encode("latin-1")


def checked_key(key: Any) -> Any:
    """Return the key of a mapping if it is a text or number: others take unbounded time to hash."""
    if not isinstance(key, str | bytes | int | float | np.generic):
        raise Refused(f"a key of a mapping is no text or number but a {type(key).__name__}")
    return key


def _mapping(pairs: Any = ()) -> dict[Any, Any]:
    return {checked_key(key): value for key, value in pairs}


CLASSES: dict[str, Callable[..., Any]] = {
    **{f"numpy.{core}.multiarray._reconstruct": lambda *_: ArrayPart() for core in ("core", "_core")},
    **{f"numpy.{core}.multiarray.scalar": _scalar for core in ("core", "_core")},
    **{f"numpy.{core}.numeric._frombuffer": _from_buffer for core in ("core", "_core")},
    "numpy.ndarray": lambda *_: ArrayPart(),
    "numpy.dtype": _dtype,
    "joblib.numpy_pickle.NumpyArrayWrapper": lambda *_: JoblibPart(),
    "collections.OrderedDict": _mapping,
    "_codecs.encode": _encode,
}
"""Classes and functions of a pickle that may be named, and what stands for them here."""
