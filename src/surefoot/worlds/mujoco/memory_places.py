"""Where MuJoCo keeps what compiled code reads: views of all memory, places in them, layouts of its structs.

To ask MuJoCo's bindings for a number of an MjData takes 0.1 µs, for an array half a microsecond: longer than
a small step takes. The structs that hold the numbers, and the addresses of arrays, do not move.
"""

from __future__ import annotations

import ctypes
import importlib
from functools import cache
from typing import Any

import numpy as np

from surefoot.base.arrays import FloatArray, IntArray
from surefoot.base.errors import ModelError

FIRST_BYTE = 8
"""Address that the views of all memory begin at: zero is none."""
SPAN = 1 << 47
"""Bytes that they reach over: user space on 64-bit Linux, macOS and Windows."""
CONTACT = (
    "dist", "pos", "frame", "includemargin", "friction", "solref", "solreffriction", "solimp", "dim", "geom",
    "exclude", "efc_address",
)  # fmt: skip
"""Fields of an MjContact that are read."""
PROBE = """
<mujoco><option cone="elliptic" jacobian="dense"/><worldbody><geom type="plane" size="1 1 1"/>
<body pos="0 0 0.09"><freejoint/><geom type="box" size="0.1 0.1 0.1"/></body></worldbody></mujoco>
"""
"""A scene with four contacts."""
SIZES = {"int": 4, "mjtBool": 1, "mjtNum": 8, "mjtSize": 8, "size_t": 8, "uintptr_t": 8}
"""Bytes of the types of fields; all else is an address."""


@cache
def all_memory() -> tuple[FloatArray, IntArray, Any]:
    """Return views (n,) of all memory as float64, int64 and int32, to look addresses up in."""
    floats = (ctypes.c_double * (SPAN // 8)).from_address(FIRST_BYTE)
    whole = (ctypes.c_int64 * (SPAN // 8)).from_address(FIRST_BYTE)
    half = (ctypes.c_int32 * (SPAN // 4)).from_address(FIRST_BYTE)
    return np.ctypeslib.as_array(floats), np.ctypeslib.as_array(whole), np.ctypeslib.as_array(half)


def address_of(array: Any) -> int:
    """Return the address of an array's first number."""
    return int(array.__array_interface__["data"][0])


def place_of(array: Any) -> int:
    """Return where an array begins, as an index of the view of its kind; 0 for an empty one."""
    return (address_of(array) - FIRST_BYTE) // array.itemsize if array.size else 0


def field_offsets(mujoco: Any, struct: str, first: str, last: str) -> dict[str, int]:
    """Return how many bytes each of some fields, a first to a last one, lies behind the first.

    Raises
    ------
    ModelError
        If this MuJoCo does not list its fields, or has others.
    """
    try:
        fields = importlib.import_module("mujoco.introspect.structs").STRUCTS[struct].fields
        names = [field.name for field in fields]
        chosen = fields[names.index(first) : names.index(last) + 1]
    except (ImportError, AttributeError, KeyError, ValueError) as error:
        raise unknown_layout(mujoco) from error
    out, at = dict[str, int](), 0
    for field in chosen:
        kind, _, count = str(field.type).partition(" [")
        size = SIZES.get(kind, 8)
        at += -at % size
        out[field.name] = at
        at += size * (int(count.rstrip("]")) if count else 1)
    return out


def unknown_layout(mujoco: Any) -> ModelError:
    """Return the error of a MuJoCo whose structs are not as they are listed."""
    return ModelError(f"MuJoCo {mujoco.__version__} keeps its constraints in an unknown way")


@cache
def contact_struct(mujoco: Any) -> np.dtype[Any]:
    """Return MuJoCo's contact struct as a NumPy type, as its own arrays of fields lie in memory."""
    model = mujoco.MjModel.from_xml_string(PROBE)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    contacts = data.contact
    fields = {name: getattr(contacts, name) for name in CONTACT}
    base = address_of(contacts.dist)
    return np.dtype(
        {
            "names": list(fields),
            "formats": [(view.dtype, view.shape[1:]) for view in fields.values()],
            "offsets": [address_of(view) - base for view in fields.values()],
            "itemsize": contacts.dist.strides[0],
        }
    )
