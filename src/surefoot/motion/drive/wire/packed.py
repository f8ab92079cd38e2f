"""Messages as the bytes of the wire: their numbers are read and written in place, all of a name at once.

DDS's encoding (XCDR1, little-endian) of a message without strings and sequences has every number at a place
of its own, and so has the C structure that Unitree's checksum is over. Both are worked out once for a class;
field by field in Python a message takes a quarter of a millisecond.

The checksum is CRC-32/MPEG-2 (polynomial 0x04C11DB7, all ones at the start, nothing reflected) of the
structure's little-endian words but the last, each from its highest byte on.
"""

from __future__ import annotations

import struct
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from surefoot.base.arrays import IntArray
from surefoot.base.kernels import kernel
from surefoot.motion.drive.wire.messages import Structure

POLYNOMIAL = 0x04C11DB7
CODES = {"byte": "u1", "uint16": "<u2", "int16": "<i2", "uint32": "<u4", "int32": "<i4", "float32": "<f4"}
HEADER = bytes([0, 1, 0, 0])
"""What says the encoding."""


class Layout:
    """Where the numbers of a message class stand.

    Parameters
    ----------
    kind
        A message of `surefoot.motion.drive.wire.messages`.

    Attributes
    ----------
    places
        By name, as "motor_cmd.q": how the numbers are written, and at which multiples of their size.
    size, structure
        Of the encoding without its header, and of the C structure [bytes].
    order
        The encoding's bytes as the checksum takes them; -1 for what C leaves empty.
    """

    def __init__(self, kind: Structure) -> None:
        self._leaves: list[tuple[str, str, int, int]] = []
        self.size, self.structure = self._walk(kind, "", (0, 0))
        self.places: dict[str, tuple[str, IntArray]] = {}
        of = np.full(self.structure, -1, dtype=np.int64)
        for name in dict.fromkeys(leaf[0] for leaf in self._leaves):
            found = [leaf for leaf in self._leaves if leaf[0] == name]
            code, width = found[0][1], np.dtype(found[0][1]).itemsize
            at = np.array([leaf[2] // width for leaf in found])
            self.places[name] = code, at if len(at) > 1 else at[0]
            for _, _, wire, there in found:
                of[there : there + width] = np.arange(wire, wire + width)
        self.order: IntArray = of[:-4].reshape(-1, 4)[:, ::-1].ravel().copy()

    def _walk(
        self, kind: str | Structure, name: str, at: tuple[int, int], count: int | None = None
    ) -> tuple[int, int]:
        """Note the numbers of types that begin behind a place in both layouts; return where they end."""
        if count is not None:
            for _ in range(count):
                at = self._walk(kind, name, at)
            return at
        if isinstance(kind, Structure):  # C begins and ends it at multiples of its widest number
            wide = _widest(kind)
            at = at[0], _align(at[1], wide)
            for field, inner, many in kind.fields:
                at = self._walk(inner, f"{name}.{field}" if name else field, at, many)
            return at[0], _align(at[1], wide)
        width = np.dtype(CODES[kind]).itemsize
        at = _align(at[0], width), _align(at[1], width)
        self._leaves.append((name, CODES[kind], *at))
        return at[0] + width, at[1] + width


def _align(place: int, width: int) -> int:
    """Return the next multiple of a width."""
    return -(-place // width) * width


def _widest(kind: str | Structure) -> int:
    """Return the width of the widest number of a type [bytes]."""
    if isinstance(kind, Structure):
        return max(_widest(inner) for _, inner, _ in kind.fields)
    return np.dtype(CODES[kind]).itemsize


layout = cache(Layout)
"""The layout of a message class, worked out once."""


class PackedMessage:
    """A message: ``message["motor_cmd.q"]`` are its numbers of a name, and can be assigned.

    Fewer numbers than there are, as of a robot with fewer motors, are the first ones.

    Parameters
    ----------
    kind
        Its structure.
    data
        As it came from the wire; None for zeros.

    Raises
    ------
    struct.error
        For bytes that are too few, or encoded in another way.
    """

    def __init__(self, kind: Structure, data: bytes | None = None) -> None:
        self.kind, self.layout = kind, layout(kind)
        end = len(HEADER) + self.layout.size
        if data is not None and (data[:2] != HEADER[:2] or len(data) < end):
            raise struct.error(f"{len(data)} bytes are no {kind.name}")
        self.data = bytearray(HEADER + bytes(self.layout.size) if data is None else data[:end])
        self._views: dict[str, NDArray[Any]] = {}

    def __getitem__(self, name: str) -> Any:
        """Return a number, or an array of all of that name."""
        code, place = self.layout.places[name]
        return self._view(code)[place]

    def __setitem__(self, name: str, values: Any) -> None:
        """Write a number, or the first of that name."""
        code, place = self.layout.places[name]
        self._view(code)[place[: len(values)] if np.ndim(values) else place] = values

    def _view(self, code: str) -> NDArray[Any]:
        """Return the encoding as an array of numbers that are written in one way."""
        found = self._views.get(code)
        if found is None:
            found = self._views[code] = np.frombuffer(self.data, np.uint8, offset=len(HEADER)).view(code)
        return found

    @property
    def checksum(self) -> int:
        """What belongs into `crc`, whatever stands there."""
        return int(remainder(self._view("u1"), self.layout.order, TABLE))

    def seal(self) -> PackedMessage:
        """Write the checksum, and return the message."""
        self["crc"] = self.checksum
        return self

    @property
    def sealed(self) -> bool:
        """Whether the checksum is right."""
        return self.checksum == int(self["crc"])


def _table() -> IntArray:
    """Return (256,) remainders of a byte."""
    out = np.arange(256, dtype=np.int64) << 24
    for _ in range(8):
        out = (out << 1) ^ np.where(out & 0x80000000, 0x100000000 | POLYNOMIAL, 0)
    return out


TABLE = _table()


@kernel
def remainder(data: NDArray[np.uint8], order: IntArray, table: IntArray) -> int:
    """Return the CRC-32/MPEG-2 of bytes, (k,) numbers of them in turn, -1 for a zero; see `_table`."""
    crc = 0xFFFFFFFF
    for k in range(len(order)):
        byte = np.int64(data[order[k]]) if order[k] >= 0 else np.int64(0)
        crc = ((crc << 8) & 0xFFFFFFFF) ^ table[(crc >> 24) ^ byte]
    return crc
