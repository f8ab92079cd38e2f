"""The rows of a recording: raw copies while its loop runs, channels of a log when they are asked for."""

from __future__ import annotations

from copy import copy
from typing import Any

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.worlds.mujoco.model_file import model_bytes
from surefoot.worlds.mujoco.record_capture import RawBlock, RawSteps
from surefoot.worlds.mujoco.record_contacts import Slots
from surefoot.worlds.mujoco.record_copy import NO_ROOM
from surefoot.worlds.mujoco.record_forces import TreeForces
from surefoot.worlds.mujoco.record_instants import Kinematics, StepReplay
from surefoot.worlds.mujoco.record_model import ModelWatch, TorqueDemand
from surefoot.worlds.mujoco.record_tree import BodyTree

BLOCK = 1024
"""Rows that are worked out at once."""


class RecordedRows:
    """What was recorded so far.

    The model is as it was at the start; `ModelWatch` says what a loop changed, and rows are worked out with
    the numbers of their time.

    Attributes
    ----------
    model
        A copy of the loop's.
    slots, forces, asked, watch, replay
        The parts that work rows out.
    """

    def __init__(self, mujoco: Any, model: Any, data: Any, tree: BodyTree) -> None:
        self._mujoco, self.model, self._tree = mujoco, copy(model), tree
        self.slots = Slots(mujoco, self.model, tree.bodies, tree.mount)
        self.forces = TreeForces(mujoco, self.model, tree)
        self.asked = TorqueDemand(mujoco, self.model, tree)
        self.watch = ModelWatch(mujoco, model)
        self.replay = StepReplay(mujoco, self.model)
        self._kinematics = Kinematics(mujoco, self.model, mujoco.MjData(self.model), tree)
        self.raw = RawSteps(mujoco, model, data)
        self._blocks: list[dict[str, Any]] = []
        self._done = self._worked = self._version = 0

    @property
    def count(self) -> int:
        """Number of rows so far."""
        return self._done + self.raw.count

    def take(self, scheme: int = -1) -> int:
        """Copy the step that the data has just made, -1 for the model's scheme; see `RawSteps.take`."""
        raw, watch = self.raw, self.watch
        if watch.changed():
            watch.note(self.count, raw.begun)
        while (out := raw.take(scheme)) == NO_ROOM:
            self.work_out()
        return out

    def work_out(self) -> None:
        """Turn the raw copies into rows of channels, and forget them."""
        raw = self.raw
        while self._worked < raw.count:
            first, end = self._worked, self._end_of_block()
            self._blocks.append(self._channels(raw.rows(first, end), self._done + first))
            self._worked = end
        self._done += raw.count
        self._worked = 0
        raw.clear()

    def first_model_file(self) -> bytes:
        """Return the model as it was at the start, as MuJoCo's binary file."""
        first = copy(self.model)
        self.watch.restore(0, first)
        return model_bytes(self._mujoco, first)

    def _end_of_block(self) -> int:
        """Return the end of the next rows with one scheme and one version of the model."""
        first, most = self._worked, min(self._worked + BLOCK, self.raw.count)
        schemes = self.raw.rows(first, most).schemes
        other = np.flatnonzero(schemes != schemes[0])
        most = first + int(other[0]) if other.size else most
        following = [row - self._done for row, _, _ in self.watch.versions if row - self._done > first]
        return min(most, *following) if following else most

    def _channels(self, block: RawBlock, first: int) -> dict[str, Any]:
        """Return the channels of rows, the first of which has a number in the recording."""
        version, tree, at = self.watch.version(first), self._tree, self._kinematics
        if version != self._version:
            self.watch.restore(version, self.model)
            self._version = version
        instants = self.replay.instants(block)
        which, inner = self.slots.sort(instants.raw)
        outer = self.slots.outer(instants.raw, which)
        bodies = self.model.geom_bodyid[outer.pair[:, 0]]
        at.trace(instants, (outer.row, outer.force, outer.place, bodies))
        self.slots.read(instants, at, outer, first)
        inner_force, inner_bodies = self.slots.inner_forces(instants, inner)
        place = np.full(self.model.nbody + 1, -1)
        place[tree.bodies] = np.arange(len(tree.bodies))
        return {
            "time": block.time.copy(),
            "q": block["start_qpos"].copy(), "v": block["start_qvel"].copy(),
            "end_q": block["end_qpos"].copy(),
            "torques": tree.torques(block["qfrc_actuator"], block["qfrc_applied"]),
            "torques_commanded": self.asked.read(block),
            "pushed_body": tree.pushed_place(block["xfrc_applied"]).astype(np.float64),
            "inner_force": inner_force, "inner_bodies": place[inner_bodies].astype(np.float64),
            **self.forces.rows(instants, at),
        }  # fmt: skip

    def channels(self) -> dict[str, FloatArray]:
        """Return all rows so far, name to array (T, ...); states in MuJoCo's order."""
        self.work_out()
        if not self._blocks:
            return {}
        return {name: np.concatenate([one[name] for one in self._blocks]) for name in self._blocks[0]}
