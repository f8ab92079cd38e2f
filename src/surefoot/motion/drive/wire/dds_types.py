"""Types for Cyclone DDS of the messages' structures; messages stay the bytes of the wire.

This module needs the extra ``wire``.
"""

from __future__ import annotations

from functools import cache
from typing import Any

from surefoot.base.errors import needs
from surefoot.motion.drive.wire.messages import Structure
from surefoot.motion.drive.wire.packed import HEADER

with needs("cyclonedds", "wire"):
    from cyclonedds.idl import make_idl_struct, types
    from cyclonedds.idl.annotations import autoid, final

FAMILY = "{}.msg.dds_.{}"


def _make_type(structure: Structure) -> Any:
    """Return Cyclone DDS's type of a structure, made anew."""
    fields = {}
    for name, kind, count in structure.fields:
        one = dds_type(kind) if isinstance(kind, Structure) else getattr(types, kind)
        fields[name] = one if count is None else types.array[one, count]
    full = FAMILY.format(structure.family, structure.name)
    return autoid("sequential")(final(make_idl_struct(structure.name, full, fields)))


@cache
def dds_type(structure: Structure) -> Any:
    """Return Cyclone DDS's type of a structure, which packs and unpacks it field by field."""
    return _make_type(structure)


@cache
def carrier_type(structure: Structure) -> Any:
    """Return a type for a topic, the messages of which carry the bytes of the wire as ``data``.

    Field by field a message takes a quarter of a millisecond.
    """
    kind = _make_type(structure)
    kind.serialize, kind.deserialize = _bytes, classmethod(_of_bytes)
    return kind


def _bytes(self: Any, **_: Any) -> bytes:
    """Return what a message carries."""
    data: bytes = self.data
    return data


def _of_bytes(kind: Any, data: bytes) -> Any:
    """Return a message that carries bytes; ones of another encoding are encoded anew."""
    carrier = kind.__new__(kind)
    if data[:2] != HEADER[:2]:
        data = kind.__idl__.serialize(kind.__idl__.deserialize(data), use_version_2=False)
    carrier.data = data
    return carrier
