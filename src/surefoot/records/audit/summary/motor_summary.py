"""What a run asked of the motors, and whether links that are no feet touched anything."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.records.audit.limits import LIMITS, AuditLimits
from surefoot.records.log import Log

IDEAL = "ideal"


@dataclass(frozen=True)
class MotorUse:
    """What the joints were asked for.

    Attributes
    ----------
    actuators
        "ideal", or the name of what the world's motors are.
    speed_use_max, speed_use_joint
        Highest share of a joint's speed limit, and whose.
    over_speed_share
        Share of the steps in which some joint was faster than its limit.
    beyond_curve_share
        Share of the steps in which some torque along the motion was more than the motor gives at that speed:
        what was asked for where the world's motors cut it off, what ideal ones gave where nothing did.
    beyond_curve_max
        Most that a torque was beyond, as a share of the joint's largest.
    """

    actuators: str
    speed_use_max: float
    speed_use_joint: str
    over_speed_share: float
    beyond_curve_share: float
    beyond_curve_max: float


def motor_use(log: Log, limits: AuditLimits = LIMITS) -> MotorUse | None:
    """Return what a log says about the use of the motors; None for one that tells no limit of speeds."""
    asked = "torques" in log or "torques_commanded" in log
    if not {"speed_limits", "effort_limits", "joints"} <= set(log.facts) or "v" not in log or not asked:
        return None
    fastest, effort = log.fact("speed_limits"), log.fact("effort_limits")
    joints = len(fastest)
    if not joints or not np.isfinite(fastest).any():
        return None
    most, over, cut, beyond_most = np.zeros(joints), 0, 0, 0.0
    for piece in log.chunks():
        speed = np.asarray(piece["v"])[:, -joints:]
        use = np.abs(speed) / np.maximum(fastest, 1e-12)
        with np.errstate(divide="ignore", invalid="ignore"):  # a limit of zero, numbers that are none
            beyond = np.nan_to_num(_beyond(log, piece, speed, effort), nan=0.0)
        most = np.fmax(most, use.max(axis=0, initial=0.0))
        over += int((use > limits.motors.over_speed).any(axis=1).sum())
        cut += int((beyond > limits.motors.cut).any(axis=1).sum())
        beyond_most = max(beyond_most, float(beyond.max(initial=0.0)))
    rows = max(len(log), 1)
    return MotorUse(
        str(log.facts.get("actuators", IDEAL)), float(most.max()), log.fact("joints")[int(most.argmax())],
        over / rows, cut / rows, beyond_most,
    )  # fmt: skip


def _beyond(log: Log, piece: Log, speed: FloatArray, effort: FloatArray) -> FloatArray:
    """Return by how much torques along the motion exceed the motors' curve, over the effort: (T, joints)."""
    torques = np.asarray(piece["torques_commanded"] if "torques_commanded" in piece else piece["torques"])
    knee, driving = (float(log.facts.get(name, 1.0)) for name in ("motor_knee", "motor_driving"))
    share = np.abs(speed) / log.fact("speed_limits")
    falling = np.clip((1.0 - share) / max(1.0 - knee, 1e-12), 0.0, 1.0)
    along = torques * np.sign(speed) / effort
    return np.asarray(np.maximum(along - driving * falling, 0.0))


def limits_broken(log: Log, use: MotorUse | None) -> list[str] | None:
    """Return one line per limit of the robot itself that a run did not keep; None if the log tells of none.

    Speeds count where the world has motors: ideal ones have no limit. What links touched counts where the
    world lets them.
    """
    if "speed_limits" not in log.facts and "link_touches" not in log.facts:
        return None
    out = []
    if use is not None and use.actuators != IDEAL and use.over_speed_share > 0.0:
        out.append(
            f"{use.speed_use_joint} at {100.0 * use.speed_use_max:.0f} % of its largest speed, in "
            f"{100.0 * use.over_speed_share:.2g} % of the steps beyond it"
        )
    touches = log.fact("link_touches") if log.facts.get("link_touches") else []
    return out + [f"touched: {line}" for line in touches]
