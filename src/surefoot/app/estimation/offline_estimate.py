"""State of a robot from a log that somebody else wrote, in one call."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from surefoot.app.estimation.foreign_log import ForeignLog, read_foreign
from surefoot.app.estimation.foreign_units import in_seconds
from surefoot.base.arrays import FloatArray, of_kind
from surefoot.base.errors import ProblemError
from surefoot.mechanics import FlatTerrain, Robot, Terrain, load_robot
from surefoot.motion.estimation.inekf import FilterNoise
from surefoot.motion.estimation.inekf_robot import InvariantEkf
from surefoot.records import Log, read_log
from surefoot.records.audit.contact_times import contact_times
from surefoot.records.identification.foot_friction import friction_of_walk

BEGIN = 20
"""Rows whose mean specific force tells the tilt at the start."""
STEEP, MOMENTS = 3.0, 400
"""Slope [deg] from which a floor is not level, whatever legs and IMU disagree about; moments that tell it."""
LONGEST_HOLE = 0.1
"""Time without rows [s] that the last reading bridges; where a robot is after a longer one nobody knows."""
KEPT = ("torques", "torques_commanded", "foot_sensors", "planned")
"""Channels of the log that are kept, those of joints in the robot's order."""


def estimate_state(
    log: Log | str | Path,
    robot: Robot | str,
    *,
    ground: Terrain | None = None,
    noise: FilterNoise | None = None,
) -> Log:
    """Return the log of a robot's estimated state, contacts and trust from its IMU, encoders and feet.

    Parameters
    ----------
    log
        With time, ``imu_angular_velocity``, ``imu_acceleration`` and ``joint_positions`` (or ``q``), or a
        file of it; ``foot_sensors`` or ``forces`` tell the contacts. Units, order of joints and swapped
        sides are found; what was guessed stands in the fact ``computed``.
    robot
        Whose log it is, or its name.
    ground
        Map of the ground; None for a level floor at the height on which the feet stand first. There no row is
        trusted if the feet stand on a slope.
    noise
        Beliefs about sensors and feet; None for their defaults.

    Returns
    -------
    Log
        q and v (Pinocchio's order), ``contact_estimated``, ``innovations`` and ``trusted``; reasons for doubt
        stand in the fact ``computed``, and the friction under each foot where the log has torques.

    Raises
    ------
    ProblemError
        If the log lacks a channel, has fewer than a second, other joints than the robot, a time that does not
        grow, or readings that are not finite.

    Examples
    --------
    >>> robot, rows = load_robot("go2"), 500
    >>> log = Log({
    ...     "time": 0.002 * np.arange(rows), "imu_angular_velocity": np.zeros((rows, 3)),
    ...     "imu_acceleration": np.tile([0.0, 0.0, 9.81], (rows, 1)),
    ...     "joint_positions": np.tile(robot.nominal[7:], (rows, 1)),
    ... }, {"joints": list(robot.joint_names)})
    >>> found = estimate_state(log, robot)
    >>> bool(abs(found["q"][-1] - robot.nominal).max() < 0.01), bool(found["trusted"].all())
    (True, True)
    """
    log = read_log(log) if isinstance(log, (str, Path)) else log
    robot = load_robot(robot) if isinstance(robot, str) else robot
    of_kind("log", log, Log)
    of_kind("robot", robot, Robot)
    if not robot.floating or not robot.feet:
        raise ProblemError(f"a state estimate needs a floating base with feet; {robot.name} has no such")
    clock: list[str] = []
    log = in_seconds(log, clock)
    _check_time(np.asarray(log["time"], dtype=np.float64))
    given = _read(log, robot)
    arrays, doubts = _run_filter(given, robot, FlatTerrain() if ground is None else ground, noise)
    told = [*clock, *given.told, "start: feet in contact stand on the ground, heading and place are zero"]
    if ground is None:
        told.append("the floor is taken to be level")
        doubts += _doubt_level(robot, arrays)
    arrays |= {name: np.asarray(log[name]) for name in KEPT[2:] if name in log}
    if given.torques is not None:
        arrays["torques"] = given.torques
    facts: dict[str, Any] = {
        "robot": robot.name, "dt": float(np.median(np.diff(given.time))), "mass": robot.mass,
        "feet": [foot.name for foot in robot.feet], "joints": list(robot.joint_names),
        "computed": [*told, *doubts],
    }  # fmt: skip
    found = Log(arrays, facts)
    if given.torques is not None and np.isfinite(given.torques).all() and given.torques.any():
        feet = friction_of_walk(robot, found, np.asarray(arrays["trusted"]))
        facts["computed"] = [*told, *map(str, feet), *doubts]
        found = Log(arrays, facts)
    return found


def _check_time(time: FloatArray) -> None:
    """Raise ProblemError unless the (T,) time grows from row to row, for a second."""
    wrong = np.flatnonzero(~(np.diff(time) > 0.0) | ~np.isfinite(np.diff(time)))
    if len(wrong):
        row = int(wrong[0])
        raise ProblemError(
            f"time must grow from row to row, got {time[row]:g} s and {time[row + 1]:g} s "
            f"in rows {row} and {row + 1}"
        )
    if len(time) < 2 * BEGIN or not time[-1] - time[0] > 0.9:
        raise ProblemError("a state estimate needs a second of a log, and a time in seconds")


def _read(log: Log, robot: Robot) -> ForeignLog:
    """Return a log's readings with the contacts that its feet's sensors or forces tell."""
    if "foot_sensors" not in log and "forces" not in log:
        return read_foreign(log, robot, None, ())
    times = contact_times(log)
    if len(times.feet) != len(robot.feet):
        raise ProblemError(f"{robot.name} has {len(robot.feet)} feet, the log has {len(times.feet)}")
    names, refused = zip(*((foot.name, foot.refused) for foot in times.feet), strict=True)
    return read_foreign(log, robot, times.contacts, names, refused)


def _run_filter(
    given: ForeignLog, robot: Robot, ground: Terrain, noise: FilterNoise | None
) -> tuple[dict[str, Any], list[str]]:
    """Return the channels of the estimate, and a line for each reason for doubt."""
    rows, dt = len(given.time), float(np.median(np.diff(given.time)))
    ekf = InvariantEkf(robot, dt, noise, ground)
    ekf.reset(_start(given, robot, ground))
    q, v = np.empty((rows, robot.model.nq)), np.empty((rows, robot.model.nv))
    innovations, trusted = np.zeros((rows, len(robot.feet))), np.ones(rows, dtype=bool)
    reasons: dict[str, tuple[float, int]] = {}
    ticks, hole = np.rint((given.time - given.time[0]) / dt).astype(np.int64), ""
    passed = np.diff(ticks, prepend=0)  # none may pass between two rows of a clock that jitters
    for t in range(rows):
        if passed[t] * dt > LONGEST_HOLE:
            hole = hole or f"nothing was recorded for {passed[t] * dt:.2f} s"
        for _ in range(min(passed[t], max(1, round(LONGEST_HOLE / dt)))):  # rows that are missing
            ekf.predict(given.gyro[t], given.accelerometer[t])
        ekf.update(given.joints[t], given.speeds[t], given.contact[t])
        q[t], v[t] = ekf.q_v()
        innovations[t], trusted[t] = ekf.filter.distances / 3.0, ekf.trust.good and not hole
        if not trusted[t]:
            reason = hole or ekf.trust.reason
            first, count = reasons.get(reason, (float(given.time[t]), 0))
            reasons[reason] = (first, count + 1)
    doubts = [f"doubted from {first:.2f} s on, {n} rows: {why}" for why, (first, n) in reasons.items()]
    return {
        "time": given.time, "q": q, "v": v, "contact_estimated": given.contact, "trusted": trusted,
        "innovations": innovations, "imu_acceleration": given.accelerometer,
        "imu_angular_velocity": given.gyro,
    }, doubts  # fmt: skip


def _doubt_level(robot: Robot, arrays: dict[str, Any]) -> list[str]:
    """Trust no row where standing feet rise one above another as on a slope; return the reason in a list."""
    standing, moments = arrays["contact_estimated"], []
    for row in np.unique(np.linspace(0, len(standing) - 1, MOMENTS).astype(np.int64)):
        if standing[row].sum() > 1:
            feet = robot.foot_positions(arrays["q"][row])[standing[row]]
            moments.append(feet - feet.mean(axis=0))
    if not moments:
        return []
    points = np.concatenate(moments)
    rise, _, _, spread = np.linalg.lstsq(points[:, :2], points[:, 2], rcond=None)
    if spread[1] < 0.05 * spread[0]:  # all in a row
        return []
    angle = float(np.degrees(np.arctan(np.hypot(*rise))))
    if angle < STEEP:
        return []
    arrays["trusted"] = np.zeros_like(arrays["trusted"])
    way = float(np.degrees(np.arctan2(rise[1], rise[0])))
    return [f"doubted throughout: feet stand on a slope of {angle:.1f}° that rises {way:.0f}° left of ahead"]


def _start(given: ForeignLog, robot: Robot, ground: Terrain) -> FloatArray:
    """Return q (nq,) at the first row: upright by the specific force, feet in contact on the ground."""
    x, y, z = given.accelerometer[:BEGIN].mean(axis=0)
    q = robot.nominal.copy()
    turn = Rotation.from_euler("ZYX", [0.0, float(np.arctan2(-x, np.hypot(y, z))), float(np.arctan2(y, z))])
    q[:3], q[3:7], q[7:] = 0.0, turn.as_quat(), given.joints[0]
    centres = robot.foot_positions(q)
    above = centres[:, 2] - robot.contact_points.foot_radii - [ground.height(c[:2]) for c in centres]
    stands = given.contact[0] if given.contact[0].any() else np.ones(len(centres), dtype=bool)
    q[2] -= float(np.mean(above[stands]))
    return q
