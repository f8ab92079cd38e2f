"""One leg whose base runs on rails that nobody measures: what a recording of its joints tells.

A foot that stands gives the rails their speed and acceleration, J_r ṙ + J_l q̇ = 0. The leg's rows of
M v̇ + h = τ + Jᵀ f then need no force on the rails, which a hand may hold.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.signal import savgol_filter

from surefoot.base.arrays import FloatArray
from surefoot.base.errors import ProblemError
from surefoot.base.text_files import path_of
from surefoot.mechanics import Robot
from surefoot.records.log.csv_file import source

LEAST = 100
"""Rows of the shortest log."""
SMOOTH = 0.1
"""Window over which links are differentiated [s]: belts keep what is quicker from them."""
QUICK = 0.015
"""Window over which a motor's acceleration and its torque are taken [s]."""
STEADY = 0.04
"""Window over which the speed that drags friction along is taken [s]."""


@dataclass(frozen=True)
class LegLog:
    """Angles, torques and, perhaps, a sensor's forces.

    Attributes
    ----------
    time, q, tau
        (T,) [s]; (T, k) joint angles [rad] and torques [N m] of the leg, from base to foot.
    sensor
        (T, 3) force that the sensor under the foot read [N], its own axes; None without one.
    names, sensor_name
        Of the joints' columns, and what the sensor's begin with.
    """

    time: FloatArray
    q: FloatArray
    tau: FloatArray
    sensor: FloatArray | None
    names: tuple[str, ...]
    sensor_name: str = ""

    @property
    def dt(self) -> float:
        """Time between rows [s]."""
        return float(np.median(np.diff(self.time)))

    def smooth(self, values: FloatArray, window: float, order: int = 0) -> FloatArray:
        """Return (T, k) values or their derivative of that order, by cubics over a window [s]."""
        rows = 2 * max(2, round(0.5 * window / self.dt)) + 1
        return np.asarray(savgol_filter(values, rows, 3, deriv=order, delta=self.dt, axis=0))


def read_leg_log(path: str | Path) -> LegLog:
    """Return the recording of a CSV file: columns time, q_NAME, tau_NAME and, perhaps, NAME_x, _y, _z.

    Raises
    ------
    ProblemError
        If columns are missing, rows are not evenly spaced, or numbers are not finite.
    """
    try:
        columns = source(path_of(path)).topics[""].fields
    except OSError as error:
        raise ProblemError(f"{path} cannot be read: {error.strerror}") from error
    names = tuple(name[2:] for name in columns if name.startswith("q_") and f"tau_{name[2:]}" in columns)
    if "time" not in columns or not names:
        raise ProblemError(
            f"{path}: a leg's log has the columns time [s], q_NAME [rad] and tau_NAME [N m] of each joint "
            f"(and NAME_x, NAME_y, NAME_z [N] of a force sensor), got {', '.join(columns)}"
        )
    head = next((n[:-2] for n in columns if {f"{n[:-2]}_{axis}" for axis in "xyz"} <= columns.keys()), "")
    wanted = [["time"], [f"q_{n}" for n in names], [f"tau_{n}" for n in names]]
    wanted += [[f"{head}_{axis}" for axis in "xyz"]] if head else []
    time, q, tau, *sensor = (np.stack([columns[name] for name in part], axis=1) for part in wanted)
    sound = np.isfinite(np.hstack([time, q, tau, *sensor])).all(axis=1)
    steps = np.diff(time[:, 0], prepend=2.0 * time[0, 0] - time[min(1, len(time) - 1), 0])
    sound &= np.abs(steps - np.median(steps)) < 0.5 * np.median(steps)
    if len(time) < LEAST or not sound.all():
        raise ProblemError(
            f"{path}: {LEAST} rows or more are needed, finite and evenly in time, got {len(time)}"
            + ("" if sound.all() else f"; row {int(np.argmin(sound))} is not so")
        )
    return LegLog(time[:, 0], q, tau, sensor[0] if sensor else None, names, head)


@dataclass(frozen=True)
class LegMotion:
    """What the leg's masses ask of its motors and its foot.

    Attributes
    ----------
    lever
        (T, 3, k) force of the ground on the foot [N], world axes, for a torque of 1 N m that a joint lacks.
    needed
        (T, k) torques [N m] that the motion asks for.
    slip
        (T,) speed [m/s] of the foot, along what no rail can give, were it on the ground.
    rails, joints
        Names of the model's joints that the log leaves out, and of those that its columns are.
    """

    lever: FloatArray
    needed: FloatArray
    slip: FloatArray
    rails: tuple[str, ...]
    joints: tuple[str, ...]


def leg_motion(robot: Robot, log: LegLog) -> LegMotion:
    """Return what a leg's recorded motion asks for.

    Parameters
    ----------
    robot
        A leg bolted to the world, or to one with rails: prismatic joints that come first.
    log
        Its last joints' angles, in the model's order (or by the model's names).

    Raises
    ------
    ProblemError
        If the robot floats, or a joint that is no rail is missing in the log.
    """
    import pinocchio

    model = robot.model
    mine, rails = _joints(robot, log)
    frame = robot.feet[0].frame if robot.feet else len(model.frames) - 1
    data, rows, nv = model.createData(), len(log.time), model.nv
    q, v, a = np.zeros((rows, nv)), np.zeros((rows, nv)), np.zeros((rows, nv))
    q[:, mine] = log.smooth(log.q, QUICK)
    v[:, mine], a[:, mine] = log.smooth(log.q, SMOOTH, 1), log.smooth(log.q, SMOOTH, 2)
    axes = pinocchio.LOCAL_WORLD_ALIGNED
    J, needed = np.empty((rows, 3, nv)), np.empty((rows, nv))
    for t in range(rows):
        J[t] = pinocchio.computeFrameJacobian(model, data, q[t], frame, axes)[:3]
    # J_r ṙ = -J_l q̇, and the same of accelerations with the rails' own still zero: `at` is J_l q̈ + J̇ v.
    held = -np.linalg.pinv(J[:, :, rails])
    free = np.einsum("tij,tj->ti", J[:, :, mine], log.smooth(log.q, STEADY, 1))
    slip = np.linalg.norm(free + np.einsum("tij,tjk,tk->ti", J[:, :, rails], held, free), axis=1)
    v[:, rails] = np.einsum("tri,tij,tj->tr", held, J[:, :, mine], v[:, mine])
    for t in range(rows):
        pinocchio.forwardKinematics(model, data, q[t], v[t], a[t])
        pinocchio.updateFramePlacement(model, data, frame)
        at = pinocchio.getFrameClassicalAcceleration(model, data, frame, axes).linear
        a[t, rails] = held[t] @ at
        needed[t] = pinocchio.rnea(model, data, q[t], v[t], a[t])
    lever = np.linalg.pinv(J[:, :, mine].transpose(0, 2, 1), rcond=1e-6)
    names = robot.joint_names
    return LegMotion(
        lever, needed[:, mine], slip, tuple(names[k] for k in rails), tuple(names[k] for k in mine)
    )


def _joints(robot: Robot, log: LegLog) -> tuple[list[int], list[int]]:
    """Return the model's joints that the log's columns are, and the rails, which it leaves out."""
    names, count = list(robot.joint_names), len(log.names)
    by_name = set(log.names) <= set(names)
    mine = [names.index(n) for n in log.names] if by_name else list(range(len(names) - count, len(names)))
    rails = [k for k in range(len(names)) if k not in mine]
    kinds = [robot.model.joints[k + 1].shortname() for k in rails]
    if robot.floating or count > len(names) or not all(kind.startswith("JointModelP") for kind in kinds):
        raise ProblemError(
            f"the log has the angles of {', '.join(log.names)}; {robot.name} "
            + ("floats" if robot.floating else f"has the joints {', '.join(names)}")
            + ": all are needed but those of prismatic joints, and a base that is bolted or runs on these"
        )
    return mine, rails
