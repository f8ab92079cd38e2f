"""MuJoCo's own arrays, reached from compiled code by their addresses.

Constraints and contacts lie in an arena: their arrays move at every step, and to ask MuJoCo's bindings for
each of them takes longer than a small step. The struct that holds their addresses does not move.
"""

from __future__ import annotations

import ctypes
from functools import cache
from typing import Any

import numpy as np

from surefoot.base.arrays import IntArray
from surefoot.worlds.mujoco.memory_places import (
    FIRST_BYTE,
    PROBE,
    address_of,
    contact_struct,
    field_offsets,
    unknown_layout,
)

ARENA = (
    "efc_J", "efc_type", "efc_id", "efc_pos", "efc_margin", "efc_frictionloss", "efc_vel", "efc_aref",
    "efc_R", "efc_force",
)  # fmt: skip
"""Arrays of constraints that are read or written."""
OF_DATA = ("qvel", "qfrc_smooth", "qacc_smooth", "qfrc_constraint", "qacc", "M")
"""Other arrays of mjData that are."""
CONTACT_FIELDS = ("dist", "includemargin", "friction", "dim", "geom", "exclude", "efc_address")
"""Fields of a contact that are."""


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
    model = mujoco.MjModel.from_xml_string(PROBE)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    # behind the two numbers of the energies every field is an address
    names = (*ARENA, "contact", *OF_DATA)
    offsets = field_offsets(mujoco, "mjData", "energy", "efc_force")
    if not all(name in offsets for name in names):
        raise unknown_layout(mujoco)
    first = (address_of(data.energy) - data._address) // 8
    found: IntArray = first + np.array([offsets[name] // 8 for name in names])
    words = np.ctypeslib.as_array((ctypes.c_int64 * int(found.max() + 1)).from_address(data._address))
    arrays = [getattr(data, name) for name in (*ARENA, *OF_DATA)]
    arrays.insert(len(ARENA), data.contact.dist)
    if any(words[at] != address_of(array) for at, array in zip(found, arrays, strict=True)):
        raise unknown_layout(mujoco)
    return found


@cache
def contact_places(mujoco: Any) -> IntArray:
    """Return (8,) a contact's size, and the offsets of `CONTACT_FIELDS` in it, in bytes."""
    struct = contact_struct(mujoco)
    fields: Any = struct.fields
    return np.array([struct.itemsize, *(int(fields[name][1]) for name in CONTACT_FIELDS)], dtype=np.int64)


@cache
def option_offsets(mujoco: Any) -> dict[str, int]:
    """Return how many bytes behind the first each option of a model lies, the first to the last."""
    return field_offsets(mujoco, "mjOption", "timestep", "disableactuator")


def option_words(mujoco: Any, model: Any) -> tuple[int, int]:
    """Return where a model's options begin, as an index of the view of all words, and how many they are.

    Raises
    ------
    ModelError
        If this MuJoCo keeps its options in another way.
    """
    offsets, option = option_offsets(mujoco), model.opt
    start = address_of(option.gravity) - offsets["gravity"]
    step = ctypes.c_double.from_address(start).value
    flags = ctypes.c_int32.from_address(start + offsets["disableflags"]).value
    if (step, flags) != (option.timestep, option.disableflags):
        raise unknown_layout(mujoco)
    return (start - FIRST_BYTE) // 8, offsets["disableactuator"] // 8 + 1
