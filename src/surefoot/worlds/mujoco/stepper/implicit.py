"""The inertia that MuJoCo's implicit integrators step with: M - h ∂f/∂v."""

from __future__ import annotations

import ctypes
from typing import Any

import numpy as np

from surefoot.base.arrays import FloatArray


class ImplicitInertia:
    """M - h ∂f/∂v of a model, dense, as `mj_implicit` has it; not symmetric where turning bodies are.

    The derivative is MuJoCo's own (mjd_smooth_vel), called in its library: the bindings do not have it.
    """

    def __init__(self, mujoco: Any, model: Any) -> None:
        self._mujoco, self._model = mujoco, model
        library = ctypes.CDLL(mujoco._functions.__file__)
        self._smooth = library.mjd_smooth_vel
        self._smooth.argtypes = (ctypes.c_void_p, ctypes.c_void_p, ctypes.c_int)
        self._free = library.mjd_freeMhat
        number, memory = ctypes.c_double, ctypes.c_void_p
        self._free.argtypes = (memory, memory, ctypes.c_int, number, memory)
        self._block = np.zeros((6, 6))
        kinds = np.array(model.jnt_type) == int(mujoco.mjtJoint.mjJNT_FREE)
        self._joints = [(int(j), int(model.jnt_dofadr[j])) for j in np.flatnonzero(kinds)]
        nv = model.nv
        counts = np.array(model.D_rownnz, dtype=np.int64)
        self._rows, self._columns = np.repeat(np.arange(nv), counts), np.array(model.D_colind)
        self.dense = np.zeros((nv, nv))

    def fill(self, data: Any) -> FloatArray:
        """Return the (nv, nv) inertia at the data's state, its own array."""
        model, mujoco, out = self._model, self._mujoco, self.dense
        whole = int(model.opt.integrator) == int(mujoco.mjtIntegrator.mjINT_IMPLICIT)
        self._smooth(model._address, data._address, int(whole))
        mujoco.mj_fullM(model, data, out)
        h = float(model.opt.timestep)
        change = np.zeros_like(out)
        change[self._rows, self._columns] = data.qDeriv
        if not whole:  # implicitfast takes the lower half for both
            change = np.tril(change) + np.tril(change, -1).T
        out -= h * change
        if not whole:
            for joint, at in self._joints:
                if self._free(model._address, data._address, joint, h, self._block.ctypes.data):
                    out[at : at + 6, at : at + 6] = self._block
        return out
