"""A step's laws at any state: MuJoCo's evaluation near a data, read into arrays of our own."""

from __future__ import annotations

import copy
from dataclasses import dataclass
from typing import Any

import numpy as np

from surefoot.base.arrays import FloatArray, IntArray
from surefoot.base.errors import ProblemError
from surefoot.worlds.mujoco.stepper.rows import STEP, read_blocks, restore_margins
from surefoot.worlds.mujoco.stepper.stage import find_places


@dataclass
class Instant:
    """What the laws are about at a state.

    Attributes
    ----------
    h
        Time step [s].
    M, impulse
        (nv, nv) the integrator's inertia, (nv,) what forces other than constraints give in the step [N s].
    J, b, gap, scale
        (m, nv), (m,), (m,), (m,) rows, what is added to their velocities, gaps, and scale of friction rows.
    keys, table, numbers
        Of the blocks; see `rows.read_blocks`.
    act
        (na,) activations after the step.
    """

    h: float
    M: FloatArray
    impulse: FloatArray
    J: FloatArray
    b: FloatArray
    gap: FloatArray
    scale: FloatArray
    keys: IntArray
    table: IntArray
    numbers: FloatArray
    act: FloatArray


class Evaluation:
    """MuJoCo's evaluation at states near that of a data, by a stepper that is used for nothing else.

    Attributes
    ----------
    h, share
        Time step [s], and share of a violation that a step undoes [-].
    sizes
        Numbers of positions, velocities, activations and controls.
    """

    def __init__(self, mujoco: Any, stepper: Any, data: Any) -> None:
        self._mujoco, self._stepper, self._model = mujoco, stepper, stepper.model
        self._start, self._data = data, copy.copy(data)
        self.h, self.share = float(stepper.model.opt.timestep), stepper.share
        self.sizes = (stepper.model.nv, stepper.model.nv, stepper.model.na, stepper.model.nu)

    def at(self, part: int = -1, i: int = 0, by: float = 0.0) -> Instant:
        """Return the laws where entry i of positions, velocities, activations or controls is changed."""
        self._evaluate(part, i, by)
        return self._read()

    def start_velocity(self, part: int = -1, i: int = 0, by: float = 0.0) -> FloatArray:
        """Return the (nv,) velocity before the step."""
        out = np.array(self._start.qvel)
        if part == 1:
            out[i] += by
        return out

    def place_after(self, part: int, i: int, by: float, v: FloatArray, push: FloatArray) -> FloatArray:
        """Return the (nq,) positions after the step with a velocity and a push (nv,)."""
        place = self._place(part, i, by)
        for velocity in (v, push):
            self._mujoco.mj_integratePos(self._model, place, velocity, self.h)
        return place

    def between(self, later: FloatArray, sooner: FloatArray) -> FloatArray:
        """Return the (nv,) way from one place (nq,) to another."""
        out = np.zeros(self._model.nv)
        self._mujoco.mj_differentiatePos(self._model, out, 1.0, sooner, later)
        return out

    def impulses(self, base: Instant) -> tuple[FloatArray, FloatArray]:
        """Return the step's impulses (m,), friction rows scaled, and its push (nv,)."""
        self._evaluate(-1, 0, 0.0)
        self._stepper._constrain(self._data)
        if self._stepper.certificate.status.value == "stalled":
            raise ProblemError("this step is not solved: it has no derivative")
        pushed = self._stepper._pushed
        push = np.array(self._stepper._push) if pushed else np.zeros(self._model.nv)
        return np.array(self._data.efc_force) * self.h / base.scale, push

    def _place(self, part: int, i: int, by: float) -> FloatArray:
        """Return the (nq,) positions before the step."""
        place, way = np.array(self._start.qpos), np.zeros(self._model.nv)
        if part == 0:
            way[i] = by
            self._mujoco.mj_integratePos(self._model, place, way, 1.0)
        return place

    def _evaluate(self, part: int, i: int, by: float) -> None:
        """Have MuJoCo evaluate everything before the constraint stage."""
        mujoco, data, start = self._mujoco, self._data, self._start
        data.time, data.qpos[:] = start.time, self._place(part, i, by)
        data.qvel[:], data.act[:], data.ctrl[:] = self.start_velocity(part, i, by), start.act, start.ctrl
        if part >= 2:
            (data.act, data.ctrl)[part - 2][i] += by
        self._stepper._begin(data)
        mujoco.mj_fwdActuation(self._model, data)
        mujoco.mj_fwdAcceleration(self._model, data)
        if self._stepper._guard.is_new(data):
            self._stepper._bind(data)

    def _read(self) -> Instant:
        """Return what was evaluated."""
        data, stepper, nv, count = self._data, self._stepper, self._model.nv, int(self._data.nefc)
        M = np.zeros((nv, nv))
        self._mujoco.mj_fullM(self._model, data, M)
        damping, dense = stepper._inertia(data)
        M = dense.copy() if dense.size else M + self.h * np.diag(damping) if damping.size else M
        J, b, scale = np.zeros((count, nv)), np.zeros(count), np.ones(count)
        keys, table = np.zeros((count, 3), np.int64), np.zeros((count, 4), np.int64)
        columns = np.zeros((count, nv + 1), np.int64)
        numbers, blocks = np.zeros((count, 6)), 0
        if count:
            floats, words, halves = stepper._memory_views
            settings, layout, soft = stepper._settings, stepper._layout, stepper._soft
            settings[STEP] = self.h
            at = find_places(words, stepper._fixed, stepper._arena)
            restore_margins(floats, halves, at, layout, count, settings, soft)
            blocks = read_blocks(
                floats, halves, at, layout, count, settings, soft, np.array(data.qvel), (J, b, scale),
                keys, (columns, table, numbers),
            )  # fmt: skip
        return Instant(
            self.h, M, self.h * np.array(data.qfrc_smooth), J, b, np.array(data.efc_pos - data.efc_margin),
            scale, keys[:blocks], table[:blocks], numbers[:blocks], self._activation(),
        )  # fmt: skip

    def _activation(self) -> FloatArray:
        """Return the (na,) activations after the step."""
        if not self._model.na:
            return np.zeros(0)
        twin = copy.copy(self._data)
        twin.qacc[:] = 0.0
        self._mujoco.mj_Euler(self._model, twin)
        return np.array(twin.act)
