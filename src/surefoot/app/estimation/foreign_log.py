"""What a stranger's log means for a robot: order of its joints and feet, units, speeds; each guess is told.

Names decide where they are known. Whether they tell the truth, and what the order is where there are none,
the feet decide: those that stand at the same time are points of one rigid floor, so that -(ω x p + ṗ) of each
is the velocity of the same body. Swapped sides, or columns in another order, break that at once.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from typing import NamedTuple

import numpy as np

from surefoot.app.estimation.column_orders import (
    ColumnOrder,
    foot_orders,
    leg_joints,
    named_orders,
    unnamed_orders,
)
from surefoot.app.estimation.foreign_units import to_si, turn_by_feet
from surefoot.app.estimation.standing_feet import Misfit, lowest_feet
from surefoot.base.arrays import BoolArray, FloatArray, IntArray
from surefoot.base.errors import ProblemError
from surefoot.mechanics import Robot
from surefoot.records import Log

PARTS = {
    "haa": "hip", "abad": "hip", "abduction": "hip", "hfe": "thigh", "kfe": "calf", "knee": "calf",
    "0": "hip", "1": "thigh", "2": "calf",
}  # fmt: skip
LEGS = {"lf": "fl", "rf": "fr", "lh": "rl", "rh": "rr", "hl": "rl", "hr": "rr"}
"""Other words for parts and legs, in lower case; parts may be numbered from the body."""
BETTER = 0.7
"""Share of the named order's misfit that another order must have to be taken instead."""
CLEAR = 1.5
"""How many times the best order's misfit the next one's is, for the order to be told without doubt."""
FOUR = 4
"""Feet of which the two that reach lowest stand, of robots that walk."""


class ForeignLog(NamedTuple):
    """Readings in the robot's order and in SI units.

    Attributes
    ----------
    time
        (T,) [s].
    gyro, accelerometer
        (T, 3) [rad/s], [m/s²], base axes.
    joints, speeds
        (T, joints) [rad], [rad/s].
    torques
        (T, joints) [N m]; None if the log has none.
    contact
        (T, n) which feet touch.
    told
        What was guessed, a line each.
    """

    time: FloatArray
    gyro: FloatArray
    accelerometer: FloatArray
    joints: FloatArray
    speeds: FloatArray
    torques: FloatArray | None
    contact: BoolArray
    told: tuple[str, ...]


def read_foreign(
    log: Log, robot: Robot, contact: BoolArray | None, names: Sequence[str], refused: Sequence[str] = ()
) -> ForeignLog:
    """Return a log's readings in the robot's order.

    Parameters
    ----------
    log
        With time, both channels of the IMU and the joints' positions.
    robot
        Whose log it is.
    contact, names
        (T, n) which feet touch by the log, and their names there; None where it does not tell.
    refused
        Why a foot's column tells nothing, empty where it does; such feet touch where they are the lowest.

    Raises
    ------
    ProblemError
        If a channel is missing, or the joints are not as many as the robot's.
    """
    for name in ("time", "imu_angular_velocity", "imu_acceleration"):
        if name not in log:
            have = ", ".join(log.arrays)
            raise ProblemError(f"a state estimate needs the channel {name}; the log has {have}")
    angles = log["joint_positions"] if "joint_positions" in log else log["q"][:, 7:] if "q" in log else None
    if angles is None:
        have = ", ".join(log.arrays)
        raise ProblemError(f"a state estimate needs joint_positions or q; the log has {have}")
    told = [
        f"{name} does not tell its contacts ({why}): within 1 cm of the lowest foot it is taken to touch"
        for name, why in zip(names, refused, strict=False) if why
    ]  # fmt: skip
    if told and all(refused):
        contact = None
    kept = _moving(angles, robot, told)
    time, gyro, force, joints = (
        np.array(part, dtype=np.float64)
        for part in (log["time"], log["imu_angular_velocity"], log["imu_acceleration"], angles[:, kept])
    )
    _check_finite({"imu_angular_velocity": gyro, "imu_acceleration": force, "joint_positions": joints})
    units = to_si(gyro, force, joints, told)
    order, feet, _ = _order(log, robot, (time, gyro, joints), contact, names, told)
    joints = joints[:, order]
    speeds = _speeds(log, time, joints, kept[order], units, told)
    torques = np.asarray(log["torques"])[:, kept[order]] if "torques" in log else None
    if contact is None:
        contact = lowest_feet(robot, time, force, joints)
        told.append("no contacts in the log: feet within 1 cm of the lowest are taken to touch")
        turn_by_feet(Misfit(robot, time, gyro, joints, contact), np.arange(robot.joints), feet, gyro, told)
    else:
        contact = contact[:, feet]
        if blind := [k for k, foot in enumerate(feet) if refused and refused[foot]]:
            contact[:, blind] = lowest_feet(robot, time, force, joints)[:, blind]
    return ForeignLog(time, gyro, force, joints, speeds, torques, contact, tuple(told))


def _check_finite(readings: dict[str, FloatArray]) -> None:
    for name, array in readings.items():
        if len(wrong := np.flatnonzero(~np.isfinite(array).all(axis=1))):
            raise ProblemError(
                f"a state estimate needs {name} in every row, got {array[wrong[0]]} in row {wrong[0]} "
                f"and {len(wrong) - 1} others"
            )


def _moving(angles: FloatArray, robot: Robot, told: list[str]) -> IntArray:
    """Return which columns are joints of the robot: all, or where they are too many, those that change."""
    count = angles.shape[1]
    if count == robot.joints:
        return np.arange(count)
    moved = np.flatnonzero((angles != angles[:1]).any(axis=0))
    if count < robot.joints or len(moved) != robot.joints:
        raise ProblemError(f"{robot.name} has {robot.joints} joints, the log has {count}")
    left = ", ".join(str(k + 1) for k in np.setdiff1d(np.arange(count), moved))
    told.append(
        f"columns {left} of the joints never change and are left out: {robot.name} has no such joints"
    )
    return moved


def _speeds(
    log: Log, time: FloatArray, joints: FloatArray, order: IntArray, factor: float, told: list[str]
) -> FloatArray:
    """Return the joints' speeds (T, joints)."""
    if "joint_velocities" in log:
        return np.asarray(log["joint_velocities"], dtype=np.float64)[:, order] * factor
    if "v" in log:
        return np.asarray(log["v"], dtype=np.float64)[:, 6:][:, order] * factor
    told.append("joint speeds are differences of the angles")
    return np.asarray(np.gradient(joints, time, axis=0))


def _plain(name: str) -> str:
    """Return a joint's or foot's name in words that robots share."""
    words = [w for w in re.findall(r"[a-z]+|\d+", name.lower()) if w not in ("joint", "foot", "leg", "toe")]
    return "_".join(LEGS.get(w, PARTS.get(w, w)) for w in words)


def _order(
    log: Log, robot: Robot, readings: tuple[FloatArray, FloatArray, FloatArray], contact: BoolArray | None,
    names: Sequence[str], told: list[str],
) -> ColumnOrder:  # fmt: skip
    """Return where the robot's joints and feet are in the log."""
    joints, feet, legs = np.arange(robot.joints), np.arange(len(robot.feet)), leg_joints(robot)
    own = [_plain(name) for name in robot.joint_names]
    given = [_plain(str(name)) for name in log.facts.get("joints", ())]
    named = sorted(given) == sorted(own)
    if named:
        joints = np.array([given.index(name) for name in own])
    mine, theirs = [_plain(foot.name) for foot in robot.feet], [_plain(str(name)) for name in names]
    known = sorted(mine) == sorted(theirs)
    if known:
        feet = np.array([theirs.index(name) for name in mine])
    first = ColumnOrder(joints, feet, "")
    if contact is not None or len(legs) >= FOUR:
        turn_by_feet(Misfit(robot, *readings, contact), joints, feet, readings[1], told)
    alike = len({len(leg) for leg in legs}) == 1 and sum(map(len, legs)) == robot.joints
    if not alike or (contact is None and len(legs) < FOUR):
        if not named:
            told.append("joints are taken in the robot's order: the log does not name them as the robot does")
        return first
    misfit = Misfit(robot, *readings, contact)
    if named:
        return _doubt_names(misfit, first, legs, known or contact is None, told)
    best, size = _best(misfit, first, unnamed_orders(legs, feet, known or contact is None))
    told.append(
        f"joints are ordered by best fit, {best.words or 'as the robot has them'}: {size:.3f} m/s rms"
    )
    others = (one for one in unnamed_orders(legs, feet, True) if (one.joints != best.joints).any())
    if (next_best := min(misfit(one.joints, best.feet) for one in others)) <= CLEAR * size:
        told.append(f"the order of the joints is in doubt: another fits to {next_best:.3f} m/s rms")
    return best


def _best(
    misfit: Misfit, first: ColumnOrder, orders: Iterable[ColumnOrder], share: float = 0.999
) -> tuple[ColumnOrder, float]:
    """Return the order of least misfit, and that [m/s]; others than the first by less than a share of it."""
    best, least = first, share * misfit(first.joints, first.feet)
    for order in orders:
        size = misfit(order.joints, order.feet)
        if size < least:
            best, least = order, size
    return best, misfit(best.joints, best.feet)


def _doubt_names(
    misfit: Misfit, first: ColumnOrder, legs: list[list[int]], known: bool, told: list[str]
) -> ColumnOrder:  # fmt: skip
    """Return the order that names tell, feet without names by best fit, unless another fits far better."""
    if not known:
        first, size = _best(misfit, first, foot_orders(first.joints, first.feet))
        if first.words:
            told.append(f"{first.words}, by best fit: {size:.3f} m/s rms")
    orders = named_orders(legs, first.joints, first.feet, known)
    best, size = _best(misfit, first, orders, BETTER)
    if best is not first:
        told.append(
            f"{best.words}, against their names: standing feet then move as one body ({size:.3f} m/s rms)"
        )
    return best
