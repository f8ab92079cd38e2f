"""Cross-check: the motion of a log in another world, and whether its success survives.

Torques alone, replayed open loop, diverge from any log within half a second, in its own world too: a legged
robot is unstable, and where a foot lands a millisecond later all that follows differs. So the joints are
tracked, tau = tau_log + K (q_log - q) + D (v_log - v) within the effort limits, and the replay starts again
from the log's state in every window. What is lost is counted only where the same replay in the log's own
world holds: else it is the tracking that fails, and one cannot tell.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from surefoot.base.errors import ProblemError, SimulationError, located
from surefoot.mechanics import Robot, Terrain
from surefoot.motion import Command, Controller, RobotState
from surefoot.records import Log, read_log
from surefoot.worlds.interface.world_names import WORLDS, make_world
from surefoot.worlds.replay.model_replay import replay_model
from surefoot.worlds.replay.replay_task import ReplayTask, replay_task
from surefoot.worlds.replay.windows import (
    WINDOW,
    ReplayReport,
    WindowReplay,
    judge_window,
    pieces_of,
    report_of,
)
from surefoot.worlds.running.run import run
from surefoot.worlds.running.scenario import Fall, Ice, Push, Scenario


def replay_log(
    log: Log | Path | str,
    world: str,
    robot: Robot | None = None,
    terrain: Terrain | None = None,
    mu: float | None = None,
    model: Any = None,
) -> ReplayReport:
    """Replay a log's joint motion and torques in another world and tell whether its success survives.

    In every window the robot starts in the log's state, lifted until no foot is in the ground, and tracks its
    joints with the log's torques as feed-forward. A window holds if the robot does not fall, does not lean
    `TILT` more than the log, ends near it (`DRIFT`), and breaks no law there that an audit can judge; all
    windows together must make `PROGRESS` of the log's way. Friction, pushes and payload are the log's.

    Parameters
    ----------
    log
        A log or its path. Needs `q`, `v` and `torques`, evenly spaced. The facts ``joint_stiffness`` and
        ``joint_damping`` give the gains, else they are made from the robot's mass and height.
    world
        Name of a world, see `surefoot.worlds.interface.world_names`.
    robot, terrain, mu
        None for the log's own: the facts ``robot`` and ``terrain``, the channel ``mu`` [-]. Others ask
        whether the success survives there.
    model
        Of a recording: the MjModel of its loop, or the .mjb file beside it, which MuJoCo reads as it is (ask
        for files that you trust). The motion of anything in it is replayed, on all that it holds, from
        the log's states as they are; worlds are "mujoco" and "mujoco-exact".

    Raises
    ------
    ProblemError
        In one line, for a log that lacks what a replay needs, or a model that is not the log's.
    MissingExtra
        If the world's engine is not installed.
    """
    log = log if isinstance(log, Log) else read_log(log)
    if model is not None:
        if not (robot is None and terrain is None and mu is None):
            raise ProblemError("robot, terrain and mu are the model's own where a model is given")
        with located("the log cannot be replayed in its model"):
            return replay_model(log, world, model)
    task = replay_task(log, robot, terrain, mu)
    make_world(world, task.robot, task.terrain, float(task.mu[0]))  # refused before any work, if it cannot be
    own = _own_world(log)
    fallen = _fall_of_the_log(task)
    if fallen:
        return ReplayReport(world, own, "cannot tell", fallen, (), ())
    pieces = pieces_of(len(task.time), task.dt * task.steps, WINDOW)
    made = [_replay(task, world, *piece) for piece in pieces]

    def replay_at_home() -> tuple[WindowReplay, ...]:
        at_home = _at_home(log, task, robot, terrain, mu)
        if not own or (own == world and at_home is task):
            return ()
        return tuple(_replay(at_home, own, *piece)[0] for piece in pieces)

    return report_of(world, own, made, replay_at_home)


def _at_home(
    log: Log, task: ReplayTask, robot: Robot | None, terrain: Terrain | None, mu: float | None
) -> ReplayTask:
    """Return the task on the log's own ground, where it tells that and another was given."""
    own_ground, own_mu = "terrain" in log.facts, "mu" in log or "contact_friction" in log
    if (terrain is None or not own_ground) and (mu is None or not own_mu):
        return task
    return replay_task(log, robot, None if own_ground else terrain, None if own_mu else mu)


def _own_world(log: Log) -> str:
    """Return the name of the world that a log comes from; empty where that is not one of ours.

    A recording is of a MuJoCo loop: our MuJoCo world is its engine, on ground close to rigid.
    """
    origin = str(log.facts.get("world", ""))
    if not origin and log.facts.get("kind") == "recording":
        return "mujoco"
    return next((name for name in WORLDS if origin and origin == WORLDS.object_name(name)), "")


def _fall_of_the_log(task: ReplayTask) -> str:
    """Return why a log has no success that could survive; empty where it has."""
    height = float(task.q[0, 2] - task.terrain.height(task.q[0, :2]))
    for row in range(0, len(task.q), 5):
        if Fall().happened(task.q[row], height, task.terrain) is not None:
            return f"the robot falls in the log itself, at {task.time[row]:.3f} s"
    return ""


class ReplayTracking(Controller):
    """Tracks the joints of a log from a row on, its torques as feed-forward, within the effort limits."""

    def __init__(self, task: ReplayTask, first: int, last: int) -> None:
        self._task, self._first, self._last = task, first, last
        self._limits = task.robot.effort_limits

    def step(self, state: RobotState) -> Command:
        """Return the torques at a time [s] from the first row on."""
        task, past = self._task, round(state.time / self._task.dt)
        row = min(self._first + past // task.steps, self._last - 1)
        torques = task.torques[row] + task.stiffness * (task.q[row, 7:] - state.q[7:])
        torques += task.damping * (task.v[row, 6:] - state.v[6:])
        return Command(np.clip(torques, -self._limits, self._limits))


def _replay(task: ReplayTask, name: str, first: int, last: int) -> tuple[WindowReplay, Log]:
    """Replay rows `first` to `last` - 1 in a world, and judge them."""
    at = {"payload_position": task.payload_position} if task.payload_position.any() else {}
    mu, rows, start = float(task.mu[first]), range(first, last), float(task.time[first])
    world = make_world(name, task.robot, task.terrain, mu, dt=task.dt, payload=task.payload, **at)
    length, q, v = task.dt * task.steps, task.q[first].copy(), task.v[first]
    times = [length * (row - first) for row in rows]
    world.reset(q, v)
    q[:3] += max(-float(world.contacts().gaps.min(initial=0.0)), 0.0) * task.terrain.normal(q[:2])
    scenario = Scenario(
        length * len(rows), mu, start=q, velocity=v,
        pushes=[Push(t, tuple(task.push[row]), length) for t, row in zip(times, rows, strict=True)
                if task.push[row].any()],
        ice=[Ice(t, float(task.mu[row])) for t, row in zip(times, rows, strict=True)
             if row > first and task.mu[row] != task.mu[row - 1]],
    )  # fmt: skip
    try:
        log = run(world, ReplayTracking(task, first, last), scenario)
    except SimulationError as error:
        raise ProblemError(f"the replay cannot begin at {start:.3f} s: {error}") from error
    seen = log["q"][:: task.steps]
    logged = task.q[first : first + len(seen)]
    height = float(task.q[first, 2] - task.terrain.height(task.q[first, :2]))
    outcome = str(log.facts["outcome"])
    return judge_window(start, outcome, seen[:, :7], logged[:, :7], height, log, task.robot), log
