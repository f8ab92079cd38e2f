"""The checksum of Unitree's messages: over the C structure that a message is, without its last word.

It is CRC-32/MPEG-2 (polynomial 0x04C11DB7, all ones at the start, nothing reflected) of the structure's
little-endian words, each from its highest bit on. The structure has C's alignment.
"""

from __future__ import annotations

import struct
from dataclasses import fields
from functools import cache
from typing import Any

import numpy as np

from surefoot.arrays import IntArray
from surefoot.kernels import kernel

POLYNOMIAL = 0x04C11DB7
CODES = {"uint8": "B", "uint16": "H", "int16": "h", "uint32": "I", "int32": "i", "float32": "f"}
WIDTHS = "xBHhIif"
"""Codes of `struct` by rising width."""


@cache
def layout(kind: type[Any]) -> struct.Struct:
    """Return the C structure of a message class."""
    return struct.Struct("@" + _code(kind))


def _code(kind: Any) -> str:
    """Return the codes of a type, with the padding that C has before and after a structure."""
    said = getattr(kind, "__metadata__", None)
    if said is not None:
        inner = said[0]
        return CODES[inner] if isinstance(inner, str) else inner.length * _code(inner.subtype)
    body = "".join(_code(field.type) for field in fields(kind))
    widest = "0" + max((c for c in body if c in WIDTHS), key=WIDTHS.index)
    return widest + body + widest


def flat(part: Any, numbers: list[Any]) -> list[Any]:
    """Append all numbers of a message in order, and return them all."""
    for name in part.__dataclass_fields__:
        value = getattr(part, name)
        kind = type(value)
        if kind is int or kind is float:
            numbers.append(value)
        elif hasattr(value, "__dataclass_fields__"):
            flat(value, numbers)
        elif hasattr(value[0], "__dataclass_fields__"):
            for one in value:
                flat(one, numbers)
        else:
            numbers.extend(value)
    return numbers


def checksum(message: Any) -> int:
    """Return the checksum that belongs into a message's `crc`, whatever stands there.

    Raises
    ------
    struct.error, OverflowError
        For numbers that do not fit their fields.
    """
    words = np.frombuffer(layout(message.__class__).pack(*flat(message, [])), dtype="<u4")[:-1]
    return int(remainder(words.astype(np.int64)))


@kernel
def remainder(words: IntArray) -> int:
    """Return the CRC-32/MPEG-2 of (k,) words of 32 bits."""
    crc = 0xFFFFFFFF
    for k in range(len(words)):
        crc ^= words[k]
        for _ in range(32):
            crc <<= 1
            if crc & 0x100000000:
                crc ^= 0x100000000 | POLYNOMIAL
    return crc
