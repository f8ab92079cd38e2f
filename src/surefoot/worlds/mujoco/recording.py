"""A log of anybody's MuJoCo loop: any model, any geoms.

Inside ``with record(model, data) as log:`` every ``mujoco.mj_step`` of that data is seen. At the end `log`
holds a row per step: state at its start, torques and contact forces during it. What MuJoCo computes is
taken from the data of the step itself; only the gaps of contacts that were open are computed afterwards.
"""

from __future__ import annotations

from types import TracebackType
from typing import Any

import numpy as np

from surefoot.base.errors import ProblemError
from surefoot.records import CHANNELS, Ending, Log, Recorder, find_doubts
from surefoot.worlds.mujoco.mujoco_world import import_mujoco
from surefoot.worlds.mujoco.record_contacts import Slots
from surefoot.worlds.mujoco.record_forces import ForceStages, TreeForces
from surefoot.worlds.mujoco.record_model import ModelWatch, TorqueDemand, foot_geoms, model_facts
from surefoot.worlds.mujoco.record_tree import BodyTree

MOST_STEPS = 10**9
"""Largest number of steps of a recording."""


class Recording(Log):
    """The log of a MuJoCo loop: empty during the ``with``, complete after it; made by `record`."""

    def __init__(self, model: Any, data: Any, robot: str | None) -> None:
        super().__init__({"time": np.zeros(0)})
        self._mujoco = import_mujoco()
        if not isinstance(model, self._mujoco.MjModel) or not isinstance(data, self._mujoco.MjData):
            raise ProblemError(
                f"record takes an MjModel and its MjData, got {type(model).__name__} and others"
            )
        self._model, self._data = model, data
        self._tree = BodyTree(self._mujoco, model, robot)
        self._slots = Slots(self._mujoco, model, self._tree.bodies, self._tree.mount)
        self._stages = ForceStages(self._mujoco, model)
        self._forces = TreeForces(self._mujoco, model, self._tree)
        self._asked = TorqueDemand(self._mujoco, model, self._tree)
        self._watch = ModelWatch(self._mujoco, model)
        self._facts = self._model_facts()
        self._rows = Recorder(MOST_STEPS, _STATE, nq=model.nq, nv=model.nv, joints=self._tree.joints)
        self._original: Any = None
        self._before: tuple[Any, Any, float] | None = None
        self._left_out = 0

    def _model_facts(self) -> dict[str, Any]:
        """Return what the log keeps of the model, as it is before the first step."""
        names = [self._slots.name(geom) for geom in range(self._model.ngeom)]
        return model_facts(self._mujoco, self._model, self._tree, names)

    def __enter__(self) -> Recording:
        self._original = self._mujoco.mj_step
        self._mujoco.mj_step = self._mj_step
        start = self._mujoco.MjData(self._model)
        start.qpos[:] = self._data.qpos
        self._mujoco.mj_kinematics(self._model, start)
        self._feet = foot_geoms(self._model, start, self._tree)
        self._remember()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._mujoco.mj_step = self._original
        if self._rows.count == 0:
            self._rows.abandon()
            if kind is not None:
                return  # what happened says more
            raise ProblemError(
                "no step was seen: call mujoco.mj_step(model, data) inside the with, or log.step() after "
                "a step that was made in another way"
            )
        self._finish(Ending.DONE if kind is None else Ending.INTERRUPTED, error)

    def _mj_step(self, model: Any, data: Any, nstep: int = 1) -> None:
        """Step as MuJoCo does, and record every step of the data that is watched."""
        if data is not self._data:
            self._original(model, data, nstep)
            return
        for _ in range(nstep):
            self._remember()
            self._original(model, data)
            self.step()

    def _remember(self) -> None:
        self._before = self._data.qpos.copy(), self._data.qvel.copy(), self._data.time
        self._stages.remember(self._data)

    def step(self) -> None:
        """Record the step that was just made by other means than ``mujoco.mj_step``.

        A step after the state was set or reset by hand has no known start: it is left out, and named in the
        doubts.
        """
        if self._before is None:
            raise ProblemError("log.step() belongs inside the with")
        qpos, qvel, time = self._before
        rows, tree, data = self._rows, self._tree, self._data
        step = float(self._model.opt.timestep)
        if not abs(data.time - time - step) < 1e-6 * step + 1e-12:
            self._left_out += 1
            self._remember()
            return
        at = rows.slot()
        row = rows.arrays
        row["time"][at], row["q"][at], row["v"][at] = time, qpos, qvel
        row["torques"][at] = tree.torques(data)
        row["torques_commanded"][at] = self._asked.read(data)
        row["pushed_body"][at] = tree.pushed_place(data)
        self._watch.look(time)
        change = data.qvel - qvel
        for k, (weight, instant) in enumerate(self._stages.of(data)):
            if k == 0:
                self._forces.begin(instant, qvel)
            rate = change / step if instant is data else instant.qacc
            self._forces.add(instant, weight, change, rate, self._slots.read(instant, weight))
        row["inner_force"][at], bodies = self._slots.inner_now
        row["inner_bodies"][at] = [tree.place.get(body, -1) for body in bodies]
        self._slots.close(rows.count)
        rows.count += 1
        self._remember()

    def _finish(self, ending: Ending, error: BaseException | None) -> None:
        """Become the log of the rows so far."""
        state, tree = self._rows.finish({}), self._tree
        self._slots.arrange()
        points = self._slots.arrays(len(state))
        q, v = np.array(state["q"]), np.array(state["v"])
        self._slots.fill_open(q, v, points)
        arrays = {name: state[name] for name in ("time", "torques")} | points | self._forces.rows()
        arrays["q"], arrays["v"] = tree.pinocchio(q, v)
        arrays |= self._of_the_model(state)
        if not tree.joints:
            del arrays["torques"]
        friction = arrays["contact_friction"]
        if friction.size and (friction == friction[0, 0]).all():
            arrays["mu"] = friction[:, 0]
        facts: dict[str, Any] = {
            "source": "MuJoCo",
            "kind": "recording",
            "outcome": str(ending),
            "mass": tree.mass,
            "dt": float(self._model.opt.timestep),
            "joints": tree.joint_names,
            "armature": self._model.dof_armature[tree.joint_dofs],
            "gravity": np.array(self._model.opt.gravity),
            "robot": self._tree.title,
            **self._facts,
            **self._watch.facts(),
            **self._slots.facts(self._feet),
        }
        if self._asked.known:
            facts["model_torque_limits"] = self._asked.limits
        if tree.free is not None and len(tree.free) < 6:
            facts["free_wrenches"] = tree.free
        if self._stages.four:
            facts["velocities"] = "mean"
        if self._forces.outside:
            facts["outside"] = [
                f"{name}: up to {force:.3g} N, {moment:.3g} N m"
                for name, (force, moment) in self._forces.outside.items()
            ]
        if error is not None:
            facts["error"] = f"{type(error).__name__}: {error}"
        facts |= self._slots.softness(q, points, tree.mass * float(np.linalg.norm(self._model.opt.gravity)))
        Log.__init__(self, arrays, {k: f for k, f in facts.items() if np.size(f)})
        self.facts["doubts"] = [*self._own_doubts(), *find_doubts(self)]

    def _of_the_model(self, state: Log) -> dict[str, Any]:
        """Return what the model's actuators, pushes and inner contacts fill, where there are any."""
        out: dict[str, Any] = {}
        if self._asked.known and self._tree.joints:
            out["torques_commanded"] = state["torques_commanded"]
        if (np.asarray(state["pushed_body"]) >= 0.0).any():
            out["pushed_body"] = state["pushed_body"]
        if np.asarray(state["inner_force"]).any():
            out |= {name: state[name] for name in ("inner_force", "inner_bodies")}
        return out

    def _own_doubts(self) -> list[str]:
        """Return what a recording cannot tell about this model."""
        out = []
        if self._left_out:
            out.append(
                f"{self._left_out} steps are left out: the state had been set by hand, or time stood still"
            )
        if self._stages.missed:
            out.append(f"{self._stages.missed} steps of Runge and Kutta came out otherwise when made again")
        if self._slots.inner:
            out.append(f"{self._slots.inner} contacts of the robot with itself are not in the log")
        if self._tree.others:
            named = ", ".join(self._tree.others[:3])
            out.append(f"more bodies move ({named}): the robot is taken to be {self._tree.name}")
        return out


_STATE = [
    CHANNELS[name]
    for name in (
        "time", "q", "v", "torques", "torques_commanded", "pushed_body", "inner_force", "inner_bodies",
    )
]  # fmt: skip


def record(model: Any, data: Any, robot: str | None = None) -> Recording:
    """Return a log that fills itself from a MuJoCo loop.

    Every contact between the robot and anything else is a contact point of the log, by its geoms: forces on
    the robot in contact axes, gap, velocity of the robot's material against the other's, position, normal,
    friction. How soft the model declares them stands in the facts ``sinking``, ``creep`` and ``stopping``.
    The fact ``feet`` names the robot's geoms that touched (a geom without a name is its body and
    number), ``contact_with`` what each contact point touches.

    Parameters
    ----------
    model, data
        `mujoco.MjModel` and `mujoco.MjData` of the loop; nothing is changed in them.
    robot
        Name of the body at the robot's root; None for that with the most actuators, of several the heaviest.

    Raises
    ------
    ProblemError
        For a body that is not there, a model in which nothing moves, or if no step was seen.
    MissingExtra
        If MuJoCo is not installed.

    Examples
    --------
    >>> import mujoco
    >>> model = mujoco.MjModel.from_xml_string(
    ...     "<mujoco><worldbody><geom type='plane' size='1 1 1'/><body name='ball' pos='0 0 0.1'>"
    ...     "<freejoint/><geom name='skin' size='0.1'/></body></worldbody></mujoco>"
    ... )
    >>> data = mujoco.MjData(model)
    >>> with record(model, data) as log:
    ...     for _ in range(500):
    ...         mujoco.mj_step(model, data)
    >>> share = log["forces"][-1, 0, 2] / (log.facts["mass"] * 9.81)
    >>> log["forces"].shape, log.facts["feet"], round(float(share), 3)
    ((500, 1, 3), ['skin'], 1.0)
    """
    return Recording(model, data, robot)
