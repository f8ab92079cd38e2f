"""Where the numbers of a model and its data are that a recording reads after every step.

In MuJoCo's structs, whose layout is counted in its own list of fields and tried on a scene. Of a MuJoCo that
keeps them otherwise, its bindings are asked before every step, and what they say lies in arrays of our own.
"""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np

from surefoot.base.arrays import FloatArray, IntArray
from surefoot.base.errors import ModelError
from surefoot.worlds.mujoco import record_copy as copy
from surefoot.worlds.mujoco.memory_places import (
    FIRST_BYTE,
    PROBE,
    address_of,
    field_offsets,
    place_of,
    unknown_layout,
)
from surefoot.worlds.mujoco.record_copy import ARRAYS, COUNTS, OPTIONS


class StepPlaces:
    """Places of the numbers of one model and its data.

    Attributes
    ----------
    at
        (PLACES,) for `record_copy.take_step`.
    known
        Whether MuJoCo's own structs are read; else `refresh` before every look.
    """

    def __init__(self, mujoco: Any, model: Any, data: Any) -> None:
        self._model, self._data = model, data
        self.at: IntArray = np.zeros(copy.PLACES, dtype=np.int64)
        self.at[copy.NITER] = place_of(data.solver_niter)
        kinds = mujoco.mjtIntegrator
        self.at[[copy.EULER, copy.RK4]] = int(kinds.mjINT_EULER), int(kinds.mjINT_RK4)
        forms = mujoco.mjtJacobian
        self.at[[copy.DENSE, copy.SPARSE]] = int(forms.mjJAC_DENSE), int(forms.mjJAC_SPARSE)
        self._halves = np.zeros(len(COUNTS) + len(OPTIONS), dtype=np.int32)
        self._words, self._floats = np.zeros(len(ARRAYS), dtype=np.int64), np.zeros(2)
        try:
            self._find(mujoco)
            self.known = True
        except ModelError:
            self._stand_in()
            self.known = False

    def _find(self, mujoco: Any) -> None:
        """Find the places in MuJoCo's structs."""
        offsets, energy = struct_offsets(mujoco), address_of(self._data.energy)
        gravity, at = address_of(self._model.opt.gravity), self.at
        at[copy.TIME] = (energy + offsets["time"] - FIRST_BYTE) // 8
        at[copy.TIMESTEP] = (gravity + offsets["timestep"] - FIRST_BYTE) // 8
        for fields, base, size in ((COUNTS, energy, 4), (OPTIONS, gravity, 4), (ARRAYS, energy, 8)):
            for name, k in fields.items():
                at[k] = (base + offsets[name] - FIRST_BYTE) // size

    def _stand_in(self) -> None:
        """Let the places be in arrays of our own."""
        at = self.at
        at[[copy.TIME, copy.TIMESTEP]] = place_of(self._floats) + np.arange(2)
        at[[*COUNTS.values(), *OPTIONS.values()]] = place_of(self._halves) + np.arange(len(self._halves))
        at[[*ARRAYS.values()]] = place_of(self._words) + np.arange(len(self._words))
        self.refresh()

    def refresh(self) -> None:
        """Ask MuJoCo's bindings for all that is not read in its structs."""
        data, option = self._data, self._model.opt
        self._floats[:] = data.time, option.timestep
        self._halves[:] = [*(getattr(data, n) for n in COUNTS), *(getattr(option, n) for n in OPTIONS)]
        arrays = [data.contact.dist, *(getattr(data, name) for name in list(ARRAYS)[1:])]
        self._words[:] = [address_of(array) if array.size else 0 for array in arrays]


@cache
def struct_offsets(mujoco: Any) -> dict[str, int]:
    """Return bytes from MjData's energies, and from MjOption's gravity, to the fields that are read.

    Raises
    ------
    ModelError
        If this MuJoCo keeps them in another way than it lists.
    """
    counted = field_offsets(mujoco, "mjData", "ncon", "energy")
    option = field_offsets(mujoco, "mjOption", "timestep", "iterations")
    behind = field_offsets(mujoco, "mjData", "energy", "efc_force")
    if not (
        {*COUNTS, "time"} <= {*counted} and {*OPTIONS, "gravity"} <= {*option} and {*ARRAYS} <= {*behind}
    ):
        raise unknown_layout(mujoco)
    out = {name: counted[name] - counted["energy"] for name in (*COUNTS, "time")}
    out |= {name: option[name] - option["gravity"] for name in (*OPTIONS, "timestep")}
    out |= {name: behind[name] for name in ARRAYS}
    _try_on_scenes(mujoco, out)
    return out


def _try_on_scenes(mujoco: Any, offsets: dict[str, int]) -> None:
    """Compare what lies at the offsets with what the bindings say, dense and sparse."""
    for jacobian in (mujoco.mjtJacobian.mjJAC_DENSE, mujoco.mjtJacobian.mjJAC_SPARSE):
        model = mujoco.MjModel.from_xml_string(PROBE)
        model.opt.jacobian, model.opt.timestep, model.opt.iterations = jacobian, 0.00371, 37
        model.opt.integrator = mujoco.mjtIntegrator.mjINT_IMPLICIT
        data = mujoco.MjData(model)
        data.time = 0.375
        mujoco.mj_forward(model, data)
        energy, gravity = address_of(data.energy), address_of(model.opt.gravity)
        read = {name: _number(energy + offsets[name], np.int32) == getattr(data, name) for name in COUNTS}
        read |= {n: _number(gravity + offsets[n], np.int32) == int(getattr(model.opt, n)) for n in OPTIONS}
        read["time"] = _number(energy + offsets["time"], np.float64) == data.time
        read["timestep"] = _number(gravity + offsets["timestep"], np.float64) == model.opt.timestep
        arrays = [data.contact.dist, *(getattr(data, name) for name in list(ARRAYS)[1:])]
        for name, array in zip(ARRAYS, arrays, strict=True):
            expected = address_of(array) if array.size else 0
            read[name] = _number(energy + offsets[name], np.int64) == expected
        if not all(read.values()):
            raise unknown_layout(mujoco)


def _number(address: int, kind: Any) -> float:
    """Return the number at an address."""
    import ctypes

    size = np.dtype(kind).itemsize
    held: FloatArray = np.frombuffer((ctypes.c_char * size).from_address(address), dtype=kind)
    return float(held[0])
