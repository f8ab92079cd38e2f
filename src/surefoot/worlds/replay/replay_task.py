"""What a replay takes from a log: whose joints went where, under which torques, on which ground."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from surefoot.base.arrays import FloatArray, finite_array, real_number
from surefoot.base.discrete_damping import REPLAYED, largest_damping
from surefoot.base.errors import ProblemError, SurefootError, located
from surefoot.base.spatial import GRAVITY
from surefoot.mechanics import Robot, Terrain, load_robot, read_terrain
from surefoot.records import Log
from surefoot.worlds.replay.recorded_model import ground_of_recording, has_model, robot_of_recording

LONGEST_STEP = 1e-3
"""Longest step of a world that replays [s]; rows farther apart are replayed in several steps."""
LONGEST_ROW = 0.05
"""Torques are held from row to row: beyond this time they say nothing of what happened in between [s]."""
UNEVEN = 0.1
"""Share by which a row's time may differ from the usual."""
DAMPING_TIME = 0.03
"""Damping over stiffness of gains that no log tells [s]."""


@dataclass(frozen=True)
class ReplayTask:
    """Everything that is replayed, checked.

    Attributes
    ----------
    robot, terrain
        Who went, and where.
    time, q, v, torques, push, mu
        (T,), (T, nq), (T, nv), (T, joints), (T, 3), (T,) rows of the log.
    dt, steps
        Step of the world [s], and steps from row to row.
    payload, payload_position
        Point mass on the base [kg], and where: (3,) base axes [m].
    stiffness, damping
        (joints,) of the tracking [N m/rad, N m s/rad].
    """

    robot: Robot
    terrain: Terrain
    time: FloatArray
    q: FloatArray
    v: FloatArray
    torques: FloatArray
    push: FloatArray
    mu: FloatArray
    dt: float
    steps: int
    payload: float
    payload_position: FloatArray
    stiffness: FloatArray
    damping: FloatArray


def replay_task(
    log: Log, robot: Robot | None = None, terrain: Terrain | None = None, mu: float | None = None
) -> ReplayTask:
    """Return what a log tells of its replay; see `surefoot.replay_log` for the arguments.

    Raises
    ------
    ProblemError
        One line that names everything that is missing, or what cannot be replayed.
    """
    with located("the log cannot be replayed"):
        missing = _missing(log, robot, terrain, mu)
        if missing:
            raise ProblemError(f"it has no {', no '.join(missing)}")
        return _task(log, robot, terrain, mu)


def _task(log: Log, robot: Robot | None, terrain: Terrain | None, mu: float | None) -> ReplayTask:
    """Return what a log with all that a replay needs tells of it."""
    try:
        robot = _robot_of(log) if robot is None else robot
        ground = terrain or ground_of_recording(log) if "terrain" not in log.facts else terrain
        ground = read_terrain(str(log.fact("terrain"))) if ground is None else ground
    except SurefootError as error:
        raise ProblemError(str(error)) from error
    if not robot.floating or not robot.feet:
        raise ProblemError(f"{robot.name} is bolted to the world or has no feet")
    q, v, torques = _motion(log, robot)
    time = np.asarray(log["time"], dtype=np.float64)
    row, steps = row_clock(time)
    push = np.asarray(log["push"]) if "push" in log else np.zeros((len(time), 3))
    friction = _friction(log, mu, len(time))
    refuse_not_finite({"q": q, "v": v, "torques": torques, "push": push, "mu": friction})
    payload = real_number("the fact payload", log.facts.get("payload", 0.0), low=0.0, high=1e4)
    place = finite_array("the fact payload_position", log.facts.get("payload_position", np.zeros(3)), (3,))
    stiffness, damping = _gains(log, robot, row / steps)
    return ReplayTask(
        robot, ground, time, q, v, torques, push, friction, row / steps, steps, payload, place, stiffness,
        damping,
    )  # fmt: skip


def _robot_of(log: Log) -> Robot:
    """Return the robot of the model that a log holds, else the one that it names."""
    return robot_of_recording(log) if has_model(log) else load_robot(str(log.fact("robot")))


def _missing(log: Log, robot: Robot | None, terrain: Terrain | None, mu: float | None) -> list[str]:
    """Return what is neither in the log nor given."""
    out = [f"channel {name}" for name in ("q", "v", "torques") if name not in log]
    if robot is None and "robot" not in log.facts and not has_model(log):
        out.append("fact robot (give robot)")
    if terrain is None and "terrain" not in log.facts and ground_of_recording(log) is None:
        out.append("fact terrain (give terrain)")
    if mu is None and "mu" not in log and "contact_friction" not in log:
        out.append("friction mu (give mu)")
    return out


def _motion(log: Log, robot: Robot) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return q, v and torques in the robot's order of joints."""
    q, v, torques = (np.array(log[name], dtype=np.float64) for name in ("q", "v", "torques"))
    have, model = (q.shape[1], v.shape[1], torques.shape[1]), robot.model
    want = (int(model.nq), int(model.nv), robot.joints)
    if have != want:
        raise ProblemError(f"{robot.name} has (nq, nv, joints) = {want}, the log {have}")
    if "joints" in log.facts:
        named = tuple(map(str, log.fact("joints")))
        if named != robot.joint_names:
            if set(named) != set(robot.joint_names):
                raise ProblemError(f"its joints are not those of {robot.name}")
            if any(int(model.nqs[k]) != 1 for k in range(2, model.njoints)):
                raise ProblemError("its joints are in another order")
            order = np.array([named.index(name) for name in robot.joint_names])
            torques = torques[:, order]
            q[:, 7:], v[:, 6:] = q[:, 7 + order], v[:, 6 + order]
    length = np.linalg.norm(q[:, 3:7], axis=1)
    if (np.abs(length - 1.0) > 1e-3).any():
        row = int(np.argmax(np.abs(length - 1.0) > 1e-3))
        raise ProblemError(f"q[3:7] of row {row} is no unit quaternion, its length is {length[row]:g}")
    return q, v, torques


def refuse_not_finite(rows: Mapping[str, FloatArray]) -> None:
    """Raise `ProblemError` for the first of several (T, ...) arrays that has a row which is no number."""
    for name, values in rows.items():
        bad = ~np.isfinite(values.reshape(len(values), -1)).all(axis=1)
        if bad.any():
            raise ProblemError(f"{name} is not finite in row {int(bad.argmax())}")


def tracking_gains(inertia: FloatArray, stiffest: float, dt: float) -> tuple[FloatArray, FloatArray]:
    """Return stiffness and damping (n,) of joints whose own inertia is (n,) `inertia`, in steps of dt [s].

    Both are bounded by what a discrete loop can hold of it, the stiffness by `stiffest` as well [N m/rad].
    """
    stiffness = np.full(len(inertia), stiffest)
    damping = np.minimum(DAMPING_TIME * stiffness, largest_damping(inertia, dt, REPLAYED))
    return np.minimum(stiffness, REPLAYED**2 * inertia / dt**2), damping


def row_clock(time: FloatArray) -> tuple[float, int]:
    """Return the time from row to row of (T,) times [s], and the world's steps in it."""
    gaps = np.diff(time)
    if len(gaps) < 2:
        raise ProblemError("it has fewer than three rows")
    row = float(np.median(gaps))
    if not row > 0.0 or not (np.abs(gaps - row) < UNEVEN * row).all():
        raise ProblemError("its rows are not evenly spaced in time")
    if row > LONGEST_ROW:
        raise ProblemError(f"its rows are {row:g} s apart, at most {LONGEST_ROW:g} s are")
    return row, max(1, math.ceil(row / LONGEST_STEP - 1e-6))


def _friction(log: Log, mu: float | None, rows: int) -> FloatArray:
    """Return the ground's friction in every row: given, or the least of the contacts'."""
    if mu is not None:
        return np.full(rows, real_number("mu", mu, low=0.0))
    if "mu" in log:
        return np.asarray(log["mu"], dtype=np.float64)
    return np.asarray(np.min(log["contact_friction"], axis=1), dtype=np.float64)


def _gains(log: Log, robot: Robot, dt: float) -> tuple[FloatArray, FloatArray]:
    """Return the joints' stiffness and damping: the log's, else made from the robot.

    A joint that is one radian off gets a torque of m g on an arm of the base's height: for a Go2 47, for a G1
    240 N m/rad, such as their users take. Both gains are bounded by what a discrete loop can hold of the
    joint's own inertia, 1 / (M^-1)_jj.
    """
    import pinocchio

    if "joint_stiffness" in log.facts and "joint_damping" in log.facts:
        given = np.asarray([log.fact("joint_stiffness"), log.fact("joint_damping")], dtype=np.float64)
        if given.shape != (2, robot.joints) or not (np.isfinite(given) & (given >= 0.0)).all():
            raise ProblemError(f"joint_stiffness and joint_damping must be {robot.joints} numbers >= 0")
        return given[0], given[1]
    inverse = np.asarray(pinocchio.computeMinverse(robot.model, robot.data, robot.nominal))
    inertia = 1.0 / np.diag(inverse)[robot.base_dof :]
    return tracking_gains(inertia, robot.mass * GRAVITY * max(float(robot.nominal[2]), 0.1), dt)
