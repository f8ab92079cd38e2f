"""MuJoCo's own arrays, reached from compiled code by their addresses.

Constraints and contacts lie in an arena: their arrays move at every step, and to ask MuJoCo's bindings for
each of them takes longer than a small step. The struct that holds their addresses does not move.
"""

from __future__ import annotations

import ctypes
import importlib
from functools import cache
from typing import Any

import numpy as np

from surefoot.base.arrays import FloatArray, IntArray
from surefoot.base.errors import ModelError
from surefoot.worlds.mujoco.record_capture import contact_struct

FIRST_BYTE = 8
"""Address that the views of all memory begin at: zero is none."""
SPAN = 1 << 47
"""Bytes that they reach over: user space on 64-bit Linux, macOS and Windows."""
ARENA = (
    "efc_J", "efc_type", "efc_id", "efc_pos", "efc_margin", "efc_frictionloss", "efc_vel", "efc_aref",
    "efc_R", "efc_force",
)  # fmt: skip
"""Arrays of constraints that are read or written."""
OF_DATA = ("qvel", "qfrc_smooth", "qacc_smooth", "qfrc_constraint", "qacc", "M")
"""Other arrays of mjData that are."""
CONTACT_FIELDS = ("dist", "includemargin", "friction", "dim", "geom", "exclude", "efc_address")
"""Fields of a contact that are."""
_PROBE = """
<mujoco><option cone="elliptic" jacobian="dense"/><worldbody><geom type="plane" size="1 1 1"/>
<body pos="0 0 0.09"><freejoint/><geom type="box" size="0.1 0.1 0.1"/></body></worldbody></mujoco>
"""


@cache
def all_memory() -> tuple[FloatArray, IntArray, Any]:
    """Return views (n,) of all memory as float64, int64 and int32, to look addresses up in."""
    floats = (ctypes.c_double * (SPAN // 8)).from_address(FIRST_BYTE)
    whole = (ctypes.c_int64 * (SPAN // 8)).from_address(FIRST_BYTE)
    half = (ctypes.c_int32 * (SPAN // 4)).from_address(FIRST_BYTE)
    return np.ctypeslib.as_array(floats), np.ctypeslib.as_array(whole), np.ctypeslib.as_array(half)


def place_of(array: Any) -> int:
    """Return where an array begins, as an index of the view of its kind; 0 for an empty one."""
    address = int(array.__array_interface__["data"][0])
    return (address - FIRST_BYTE) // array.itemsize if array.size else 0


@cache
def arena_words(mujoco: Any) -> IntArray:
    """Return at which words (17,) of mjData the addresses of `ARENA`, the contacts and `OF_DATA` stand.

    The places are counted in MuJoCo's own list of its fields, from an array that lies in the struct itself:
    a search for the addresses would read past the struct's end, where copies of them may lie.

    Raises
    ------
    ModelError
        If this MuJoCo keeps its data in another way.
    """
    model = mujoco.MjModel.from_xml_string(_PROBE)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    # behind the two numbers of the energies every field is an address
    first = (data.energy.__array_interface__["data"][0] - data._address) // 8 + 2
    found: IntArray = first + _places_after_energy(mujoco, (*ARENA, "contact", *OF_DATA))
    words = np.ctypeslib.as_array((ctypes.c_int64 * int(found.max() + 1)).from_address(data._address))
    arrays = [getattr(data, name) for name in (*ARENA, *OF_DATA)]
    arrays.insert(len(ARENA), data.contact.dist)
    if any(words[at] != a.__array_interface__["data"][0] for at, a in zip(found, arrays, strict=True)):
        raise _unknown(mujoco)
    return found


def _places_after_energy(mujoco: Any, wanted: tuple[str, ...]) -> IntArray:
    """Return how many fields of mjData lie between the energies and each of some."""
    try:
        fields = importlib.import_module("mujoco.introspect.structs").STRUCTS["mjData"].fields
        names = [field.name for field in fields]
        return np.array([names.index(name) for name in wanted]) - names.index("energy") - 1
    except (ImportError, AttributeError, KeyError, ValueError) as error:
        raise _unknown(mujoco) from error


def _unknown(mujoco: Any) -> ModelError:
    return ModelError(f"MuJoCo {mujoco.__version__} keeps its constraints in an unknown way")


@cache
def contact_places(mujoco: Any) -> IntArray:
    """Return (8,) a contact's size, and the offsets of `CONTACT_FIELDS` in it, in bytes."""
    model = mujoco.MjModel.from_xml_string(_PROBE)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    struct = contact_struct(data.contact)
    fields: Any = struct.fields
    return np.array([struct.itemsize, *(int(fields[name][1]) for name in CONTACT_FIELDS)], dtype=np.int64)
