"""A log of anybody's MuJoCo loop: any model, any geoms.

Inside ``with record(model, data) as log:`` every step of that data is seen that Python asks MuJoCo for. At
the end `log` holds a row per step: state at its start, torques and contact forces during it. What MuJoCo
computes is copied from the data of the step itself, a few microseconds each; momentum and gaps are worked
out when the log is first read.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import ExitStack
from pathlib import Path
from types import TracebackType
from typing import Any, overload

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.base.errors import ProblemError
from surefoot.base.text_files import path_of
from surefoot.records import Ending, Log, find_doubts
from surefoot.worlds.mujoco.environment_data import model_and_data
from surefoot.worlds.mujoco.model_file import check_model_file, model_path, write_model_file
from surefoot.worlds.mujoco.mujoco_world import import_mujoco
from surefoot.worlds.mujoco.record_capture import Scheme
from surefoot.worlds.mujoco.record_copy import NO_STEP
from surefoot.worlds.mujoco.record_hooks import StepHooks
from surefoot.worlds.mujoco.record_model import foot_geoms, model_facts
from surefoot.worlds.mujoco.record_open import OpenContacts
from surefoot.worlds.mujoco.record_rows import RecordedRows
from surefoot.worlds.mujoco.record_tree import BodyTree

_READ_LATER = ("arrays", "facts", "channels", "sizes")
"""Attributes of a log that are worked out when one of them is first asked for."""


JUMP = 0.05
"""Change of a position between two steps from which the state was set by hand, and not corrected [m, rad, -].

A judgement: who lifts a robot out of the ground or normalises a quaternion stays below.
"""
RARE = 0.02
"""Share of rows that may begin with such a change, to be resets; a judgement."""


class Recording(Log):
    """The log of a MuJoCo loop: empty during the ``with``, complete after it; made by `record`."""

    def __init__(self, model: Any, data: Any, robot: str | None) -> None:
        super().__init__({"time": np.zeros(0)})
        self._mujoco = import_mujoco()
        if not isinstance(model, self._mujoco.MjModel) or not isinstance(data, self._mujoco.MjData):
            raise ProblemError(
                f"record takes an MjModel and its MjData, got {type(model).__name__} and others"
            )
        self._model, self._data, self._option = model, data, model.opt
        self._tree = BodyTree(self._mujoco, model, robot)
        self._rows = RecordedRows(self._mujoco, model, data, self._tree)
        names = [self._rows.slots.name(geom) for geom in range(model.ngeom)]
        self._facts = model_facts(self._mujoco, model, self._tree, names)
        self._hooks = StepHooks(self._mujoco, model, data, self)
        self._open = False
        self._raw = self._rows.raw
        self._episodes = [0]
        self._reset = False
        self._left_out = self._unseen = 0
        self._ending: tuple[Ending, str] | None = None

    def __enter__(self) -> Recording:
        self._hooks.install()
        start = self._mujoco.MjData(self._model)
        start.qpos[:] = self._data.qpos
        self._mujoco.mj_kinematics(self._model, start)
        self._feet = foot_geoms(self._model, start, self._tree)
        self._raw.remember()
        self._open = True
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._hooks.remove()
        self._open = False
        if self._rows.count == 0:
            if kind is not None:
                return  # what happened says more
            raise ProblemError(
                "no step was seen: call mujoco.mj_step(model, data) inside the with, or log.step() after "
                "a step that was made in another way"
            )
        self.look()
        ending = Ending.DONE if kind is None else Ending.INTERRUPTED
        self._ending = ending, "" if error is None else f"{type(error).__name__}: {error}"
        for name in _READ_LATER:
            del self.__dict__[name]

    def __getattr__(self, name: str) -> Any:
        if name not in _READ_LATER or self.__dict__.get("_ending") is None:
            raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}")
        self._finish(*self.__dict__["_ending"])
        return self.__dict__[name]

    def __reduce__(self) -> tuple[Any, ...]:
        return Log, (self.arrays, self.facts, self.parts, self.channels)

    def begin_step(self) -> None:
        """Keep the state that a step starts from; called by MuJoCo's functions."""
        if not self._raw.note_start():
            self.look()
            self._raw.remember()

    def end_step(self, scheme: Scheme | None) -> None:
        """Record the step that began at `begin_step`; called by MuJoCo's functions."""
        if self._rows.take(-1 if scheme is None else scheme) == NO_STEP:
            self._left_out += 1
            self._reset = self._reset or self._raw.fell_back
            self._raw.remember()
        elif self._reset:
            self._begin_episode()

    def look(self) -> None:
        """Compare the clock with what it was after the last step: time that moved was not seen."""
        moved = self._data.time - self._raw.last
        if moved:
            if moved < 0.0:
                self._reset = True
            elif not self._reset and moved > 1e-6 * self._option.timestep:
                self._unseen += 1
            self._raw.last = self._data.time

    def end_episode(self) -> None:
        """End the episode: what comes next starts from a state that was set."""
        self._reset = True
        self._raw.last = self._data.time

    def _begin_episode(self) -> None:
        """Begin an episode with the last row."""
        self._reset = False
        if self._rows.count - 1 > self._episodes[-1]:
            self._episodes.append(self._rows.count - 1)

    def step(self) -> None:
        """Record the step that was just made by other means than MuJoCo's functions in Python.

        A step that was seen is not recorded twice. One after the state was set or reset by hand has no
        known start: it is left out, and named in the doubts.
        """
        if not self._open:
            raise ProblemError("log.step() belongs inside the with")
        if self._data.time != self._raw.last:
            self._raw.start_from_last()
            self.end_step(None)

    def save(self, path: Path | str, *, model: bool = True) -> Path:
        """Write to a new file, and the model as it was at the start beside it; see `Log.save`.

        Parameters
        ----------
        path
            Of the log; the model is MuJoCo's own binary file, the same name with the suffix .mjb, which its
            own version of MuJoCo alone reads. `surefoot.replay_log` takes it, and nothing else opens it.
        model
            Whether the model is written.

        Raises
        ------
        ProblemError
            If one of the files exists already, but for one that holds this very model.
        WriteError
            If the disk has no room.
        """
        if not model:
            return super().save(path)
        content, beside = self._rows.first_model_file(), model_path(path_of(path))
        check_model_file(beside, content)
        saved = super().save(path)
        write_model_file(beside, content)
        return saved

    def _finish(self, ending: Ending, error: str) -> None:
        """Become the log of the rows so far."""
        tree, rows, slots = self._tree, self._rows, self._rows.slots
        arrays, model = rows.channels(), rows.model
        slots.arrange()
        points = slots.arrays(len(arrays["time"]))
        q, v = arrays.pop("q"), arrays.pop("v")
        self._episodes = sorted({*self._episodes, *_jumps(q, arrays.pop("end_q"))})
        OpenContacts(self._mujoco, model, slots.points).fill(q, v, points)
        self._leave_out_empty_channels(arrays)
        arrays |= points
        arrays["q"], arrays["v"] = tree.pinocchio(q, v)
        if tree.other_places.size:
            arrays["others_q"], arrays["others_v"] = q[:, tree.other_places], v[:, tree.other_dofs]
        friction = arrays["contact_friction"]
        if friction.size and (friction == friction[0, 0]).all():
            arrays["mu"] = friction[:, 0]
        facts = {
            "source": "MuJoCo",
            "source_version": str(self._mujoco.__version__),
            "kind": "recording",
            "outcome": str(ending),
            "mass": tree.mass,
            "dt": float(model.opt.timestep),
            "joints": tree.joint_names,
            "armature": model.dof_armature[tree.joint_dofs],
            "gravity": np.array(model.opt.gravity),
            "robot": tree.title,
            **self._facts,
            **rows.watch.facts(),
            **slots.facts(self._feet),
            **self._more_facts(error),
        }
        load = tree.mass * float(np.linalg.norm(model.opt.gravity))
        facts |= slots.softness(q, points, load, self._kinetic_energy(arrays))
        Log.__init__(self, arrays, {k: f for k, f in facts.items() if np.size(f)})
        self.facts["doubts"] = [*self._own_doubts(), *self._found_doubts()]

    def _kinetic_energy(self, arrays: dict[str, Any]) -> float:
        """Return the most that the robot had [J]; zero where its energy is not known."""
        if "energy" not in arrays:
            return 0.0
        weight = self._tree.mass * np.asarray(self._rows.model.opt.gravity)
        kinetic = arrays["energy"] + arrays["com"] @ weight
        return float(np.max(kinetic[np.isfinite(kinetic)], initial=0.0))

    def _leave_out_empty_channels(self, arrays: dict[str, Any]) -> None:
        """Leave out what no actuator, push, inner contact or solver fills."""
        if not (self._rows.asked.known and self._tree.joints):
            del arrays["torques_commanded"]
        if not self._tree.joints:
            del arrays["torques"]
        if not (arrays["pushed_body"] >= 0.0).any():
            del arrays["pushed_body"]
        if not arrays["inner_force"].any():
            del arrays["inner_force"], arrays["inner_bodies"]
        if not arrays["solver_error"].any():
            del arrays["solver_error"]

    def _more_facts(self, error: str) -> dict[str, Any]:
        """Return the facts that only some recordings have."""
        tree, facts = self._tree, dict[str, Any]()
        if self._rows.asked.known:
            facts["model_torque_limits"] = self._rows.asked.limits
        if tree.free is not None and len(tree.free) < 6:
            facts["free_wrenches"] = tree.free
        if self._rows.replay.four:
            facts["velocities"] = "mean"
        if self._rows.forces.outside:
            facts["outside"] = [
                f"{name}: up to {force:.3g} N, {moment:.3g} N m"
                for name, (force, moment) in self._rows.forces.outside.items()
            ]
        if len(self._episodes) > 1:
            facts["episode_rows"] = np.array(self._episodes)
        if self._unseen:
            facts["unseen_steps"] = self._unseen
        if error:
            facts["error"] = error
        return facts

    def _found_doubts(self) -> list[str]:
        """Return what is not plausible, episode by episode."""
        parts = self.episodes
        if len(parts) == 1:
            return find_doubts(self)
        return [f"episode {k}: {line}" for k, part in enumerate(parts, 1) for line in find_doubts(part)]

    def _own_doubts(self) -> list[str]:
        """Return what a recording cannot tell about this model."""
        out, replay, tree = [], self._rows.replay, self._tree
        if self._unseen:
            out.append(
                f"rows are missing in {self._unseen} places: time moved without a step that was seen; call "
                "log.step() after steps that are not made by MuJoCo's functions in Python"
            )
        if self._left_out:
            out.append(
                f"{self._left_out} steps are left out: the state had been set by hand, or MuJoCo reset it"
            )
        if replay.missed:
            out.append(f"{replay.missed} steps of Runge and Kutta came out otherwise when made again")
        if replay.unsure:
            out.append(f"the solver's error is not known in {replay.unsure} steps: made again they differ")
        if self._rows.slots.inner:
            out.append(f"{self._rows.slots.inner} contacts of the robot with itself are not in the log")
        if tree.others:
            named = ", ".join(tree.others[:3])
            out.append(f"more bodies move ({named}): the robot is taken to be {tree.name}")
        return out


class ManyRecordings:
    """Logs of several loops, complete after the ``with``; made by `record` of a vector environment."""

    def __init__(self, recordings: Sequence[Recording]) -> None:
        self._recordings, self._stack = tuple(recordings), ExitStack()

    def __enter__(self) -> tuple[Recording, ...]:
        for one in self._recordings:
            self._stack.enter_context(one)
        return self._recordings

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._stack.__exit__(kind, error, trace)


def _jumps(start: FloatArray, end: FloatArray) -> list[int]:
    """Return the rows that start elsewhere than the row before ended, from (T, nq) positions; rare ones only.

    Where a loop sets the state again and again, as one that holds a trunk in place does, none is a reset.
    """
    far = np.abs(start[1:] - end[:-1]).max(axis=1, initial=0.0) > JUMP
    return (np.flatnonzero(far) + 1).tolist() if far.sum() <= RARE * far.size else []


@overload
def record(model: Any, data: Any, robot: str | None = None) -> Recording: ...
@overload
def record(model: Any, *, robot: str | None = None) -> Any: ...
def record(model: Any, data: Any = None, robot: str | None = None) -> Any:
    """Return a log that fills itself from a MuJoCo loop.

    Every contact between the robot and anything else is a contact point of the log, by its geoms: forces on
    the robot in contact axes, gap, velocity of the robot's material against the other's, position, normal,
    friction. How soft the model declares them stands in the facts ``sinking``, ``creep`` and ``stopping``.
    The fact ``feet`` names the robot's geoms that touched (a geom without a name is its body and
    number), ``contact_with`` what each contact point touches.

    Parameters
    ----------
    model, data
        `mujoco.MjModel` and `mujoco.MjData` of the loop; nothing is changed in them. Or one environment of
        gymnasium in their place; of a `SyncVectorEnv` ``with record(envs) as logs:`` gives a log each.
    robot
        Name of the body at the robot's root; None for that with the most actuators, of several the heaviest.

    Raises
    ------
    ProblemError
        For workers that have made their environments (see `surefoot.rl.RecordWrapper`), a body that is not
        there, a model in which nothing moves, or if no step was seen.
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
    if data is not None:
        return Recording(model, data, robot)
    core, mujoco = getattr(model, "unwrapped", None), import_mujoco()
    if core is None:
        raise ProblemError(
            f"record takes an MjModel and its MjData, or an environment, got {type(model).__name__} alone"
        )
    if not hasattr(core, "num_envs"):
        return Recording(*model_and_data(mujoco, core, "record"), robot)
    if not hasattr(core, "envs"):
        raise ProblemError(
            f"record cannot reach the environments of {type(core).__name__}: let them be wrapped where they "
            "are made, gymnasium.make_vec(..., wrappers=[sf.rl.RecordWrapper])"
        )
    parts = [model_and_data(mujoco, env.unwrapped, "record") for env in core.envs]
    return ManyRecordings([Recording(*part, robot) for part in parts])
