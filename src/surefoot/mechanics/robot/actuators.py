"""The motors and gears of a robot as one value: what they weigh, lose and give.

A motor torque τ_m moves its rotor, the gear's friction takes its part, and the rest moves the leg::

    τ_m = (M + I_a) a + h - Jᵀ f   along the joint's row,  plus  b v + τ_c sgn v

with the rotor's inertia I_a as the joint feels it (armature), viscous friction b and dry friction τ_c; τ_m
is within what a motor gives at the joint's speed (`MotorLimits`). Where a model's file gives figures they
are taken; the rest comes from `FIGURES`.

Sources of the figures: armature 0.01 kg m² and dry friction 0.2 N m of Unitree's A1, Go1 and Go2 are those of
MuJoCo Menagerie (google-deepmind/mujoco_menagerie), damping 0.1 N m s that of the MJCF that Unitree ships for
the Go2 (unitreerobotics/unitree_mujoco; Menagerie's 2 N m s stands in for the derivative gain of its servos).
The G1's armatures, static and viscous friction and the shape of its curve are those of Unitree's motor tables
(unitreerobotics/unitree_rl_lab: N7520-14.3, N7520-22.5, N5020-16, W4010-25). ANYmal's are Menagerie's; its
drives are series elastic, their rotors behind the spring.
"""

from __future__ import annotations

import math
from copy import copy
from dataclasses import dataclass

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.base.errors import ProblemError, check_name
from surefoot.base.kernels import kernel
from surefoot.base.spatial import GRAVITY
from surefoot.mechanics.robot import Robot
from surefoot.mechanics.robot.motor_limits import DRIVING_SHARE, KNEE_SHARE, MotorLimits, motor_bounds
from surefoot.mechanics.robot.rotors import joint_figures

MODELS = ("ideal", "real")
"""Names that `actuators_of` knows."""
CREEP = 0.1
"""Joint speed at which dry friction counts as three quarters there [rad/s]; slower joints are at rest."""
RULE = 0.01 / 23.7, 0.1 / 23.7, 0.2 / 23.7
"""Armature, damping, dry friction over a joint's torque [s², s, -] where nothing else is known: the Go2's."""
LEG_SHARE = 0.5
"""Torque of a joint whose file gives none, or far too much, as a share of m g h: the Go2's, nearly."""
LEG_SPEED, FAR = 8.0, 10.0
"""Speed of a leg's end where a model gives none, Go2's is 10 [m/s]; limits so many times that are none."""
LEAST_SHARE = 0.02
"""Half the usable range is at least this share of the limits [-]: a motor that spins away still brakes."""
_UNITREE = {"": (0.01, 0.1, 0.2)}
_SERIES_ELASTIC = {"": (0.0, 1.0, 0.1)}
FIGURES: dict[str, dict[str, tuple[float, float, float]]] = {
    "go2": _UNITREE,
    "go1": _UNITREE,
    "a1": _UNITREE,
    "anymal_b": _SERIES_ELASTIC,
    "anymal_c": _SERIES_ELASTIC,
    "g1": {
        "hip_pitch": (0.01017752, 0.16, 1.6),
        "hip_yaw": (0.01017752, 0.16, 1.6),
        "waist_yaw": (0.01017752, 0.16, 1.6),
        "hip_roll": (0.025101925, 0.24, 2.4),
        "knee": (0.025101925, 0.24, 2.4),
        "ankle": (0.00721945, 0.12, 1.2),
        "waist": (0.00721945, 0.12, 1.2),
        "wrist_pitch": (0.00425, 0.06, 0.6),
        "wrist_yaw": (0.00425, 0.06, 0.6),
        "": (0.003609725, 0.06, 0.6),
    },
    "hyq": {"": (0.0, 0.1, 0.0)},
}
"""Robot -> part of a joint's name (first that fits) -> armature [kg m²], damping [N m s], friction [N m]."""
SHAPES: dict[str, tuple[float, float]] = {"g1": (0.64, 0.85), "hyq": (1.0, 1.0)}
"""Robot -> `knee` and `driving` of its `MotorLimits`; the Go2's for all others. Hydraulics have a box."""


@dataclass(frozen=True, eq=False)
class Actuators:
    """The actuators of a robot's joints.

    Attributes
    ----------
    armature
        (joints,) inertia of the rotors as the joints feel it [kg m²].
    damping
        (joints,) viscous friction [N m s].
    friction
        (joints,) dry friction [N m].
    limits
        What the motors give at a speed.
    name
        "real" for `real_actuators`, else what its maker says.

    Raises
    ------
    ProblemError
        For figures that are negative, not finite, or not one for every joint.

    Examples
    --------
    >>> from surefoot.mechanics.robot import load_robot
    >>> motors = real_actuators(load_robot("go2"))
    >>> motors.losses(np.full(12, 10.0))[:3].round(2)  # [N m]
    array([1.2, 1.2, 1.2])
    >>> low, high = motors.bounds(np.full(12, 10.0))
    >>> low[:3].round(1), high[:3].round(1)
    (array([-23.7, -23.7, -45.4]), array([20.5, 20.5, 25.9]))
    """

    armature: FloatArray
    damping: FloatArray
    friction: FloatArray
    limits: MotorLimits
    name: str = "own"

    def __post_init__(self) -> None:
        joints = self.limits.effort.shape
        for name in ("armature", "damping", "friction"):
            figures = np.asarray(getattr(self, name), dtype=np.float64)
            if figures.shape != joints or not (np.isfinite(figures).all() and (figures >= 0.0).all()):
                raise ProblemError(f"{name} must be {joints[0]} numbers >= 0, one a joint, got {figures}")
            object.__setattr__(self, name, figures)

    def losses(self, speed: FloatArray) -> FloatArray:
        """Return the torques that friction takes at joint speeds (joints,): (joints,) [N m].

        Dry friction is smoothed over `CREEP`: the direction of a joint that hardly moves is noise.
        """
        return friction_losses(np.asarray(speed, np.float64), self.damping, self.friction, CREEP)

    def bounds(self, speed: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return least and largest motor torque (joints,) at joint speeds (joints,) [N m]."""
        return self.limits.bounds(speed)

    def given(self, torques: FloatArray, speed: FloatArray) -> FloatArray:
        """Return what the motors give of (joints,) torques at (joints,) joint speeds [N m]."""
        return self.limits.clip(torques, speed)

    def usable(self, speed: FloatArray, limits: FloatArray, out: FloatArray) -> None:
        """Fill `out` (>= 3, joints) with the range of torques that move the legs, and the losses [N m].

        The middle, half of the range, and what friction takes of a motor's torque, at joint speeds (joints,)
        [rad/s], for commands within ± limits (joints,) [N m]; speeds that are not finite count as rest.
        """
        motors = self.limits
        torque_range(
            speed, self.damping, self.friction, motors.effort, motors.speed, motors.knee, motors.driving,
            CREEP, limits, LEAST_SHARE, out,
        )  # fmt: skip


def actuators_of(robot: Robot, actuators: str | Actuators) -> Actuators | None:
    """Return the actuators of that name, None for ideal ones; an own value as it is.

    Parameters
    ----------
    robot
        Whose joints.
    actuators
        "ideal": torque sources without limits, rotors or friction; "real": see `real_actuators`; or a value.

    Raises
    ------
    ProblemError
        For another name, or a value for another number of joints.
    """
    if isinstance(actuators, str):
        check_name("actuators", actuators, MODELS)
        return None if actuators == "ideal" else real_actuators(robot)
    if len(actuators.armature) != robot.joints:
        raise ProblemError(
            f"the actuators are {len(actuators.armature)}, {robot.name} has {robot.joints} joints"
        )
    return actuators


def limited_robot(robot: Robot) -> Robot:
    """Return a robot with likely torque and speed limits where its model has none, see `unknown_limits`."""
    unknown, out, height = unknown_limits(robot), copy(robot), _height(robot)
    if "torque" in unknown:
        out.effort_limits = np.full(robot.joints, LEG_SHARE * robot.mass * GRAVITY * height)
    if "speed" in unknown:
        out.speed_limits = np.full(robot.joints, LEG_SPEED / height)
    return out


def unknown_limits(robot: Robot) -> tuple[str, ...]:
    """Return which of "torque" and "speed" a robot's model gives no limit for, or one that no motor has."""
    height = _height(robot)
    torque = robot.effort_limits.max() > FAR * LEG_SHARE * robot.mass * GRAVITY * height
    speed = robot.speed_limits.max() > FAR * LEG_SPEED / height
    return tuple(name for name, none in (("torque", torque), ("speed", speed)) if none)


def _height(robot: Robot) -> float:
    """Return the height [m] at which a robot stands, for its legs' size; a metre of one that is bolted."""
    return max(float(robot.nominal[2]), 0.05) if robot.floating else 1.0


def file_actuators(robot: Robot) -> Actuators:
    """Return what a robot's file says of its actuators, and nothing else: zero where it says nothing.

    Torque and speed limits make a box: a file knows of no curve.
    """
    limits = MotorLimits(robot.effort_limits, robot.speed_limits)
    return Actuators(*joint_figures(robot), limits, "of its file")


def real_actuators(robot: Robot) -> Actuators:
    """Return a robot's actuators: figures of its file where it gives them, else of `FIGURES`, else `RULE`.

    Torque and speed limits are the file's; the torque falls with the speed as for the Go2's motors, unless
    `SHAPES` says otherwise.
    """
    file, table = joint_figures(robot), FIGURES.get(robot.name, {})
    torque = np.minimum(robot.effort_limits, LEG_SHARE * robot.mass * GRAVITY * _height(robot))
    rows = np.outer(torque, RULE)
    for row, joint in zip(rows, robot.joint_names, strict=True):
        row[:] = next((figures for part, figures in table.items() if part in joint), row)
    armature, damping, friction = (np.where(own > 0.0, own, rows[:, k]) for k, own in enumerate(file))
    shape = SHAPES.get(robot.name, (KNEE_SHARE, DRIVING_SHARE))
    limits = MotorLimits(robot.effort_limits, robot.speed_limits, *shape)
    return Actuators(armature, damping, friction, limits, "real")


@kernel
def friction_losses(speed: FloatArray, damping: FloatArray, friction: FloatArray, creep: float) -> FloatArray:
    """Return the torques that friction takes at joint speeds: (joints,) [N m]; see `Actuators.losses`."""
    out = np.empty(len(speed))
    for j in range(len(speed)):
        out[j] = damping[j] * speed[j] + friction[j] * math.tanh(speed[j] / creep)
    return out


@kernel
def torque_range(
    speed: FloatArray, damping: FloatArray, friction: FloatArray, effort: FloatArray, fastest: FloatArray,
    knee: float, driving: float, creep: float, limits: FloatArray, least: float, out: FloatArray,
) -> None:  # fmt: skip
    """Fill middle and half of the range of torques that move the legs, and what friction takes.

    Motors drive a joint less than they brake it, so the range is not symmetric: middle ± half. Of a motor's
    torque, friction takes its part, see `friction_losses`: what is left for the leg is moved by it.

    Parameters
    ----------
    speed
        (joints,) [rad/s]; those not finite count as rest.
    damping, friction, creep
        See `friction_losses`.
    effort, fastest, knee, driving
        Of the motors, see `motor_bounds`.
    limits
        (joints,) bounds of the command [N m].
    least
        Half the range is at least this share of those.
    out
        (>= 3, joints) its first rows [N m]; half is infinite where a bound is.
    """
    known = np.empty(len(speed))
    for j in range(len(speed)):
        known[j] = speed[j] if math.isfinite(speed[j]) else 0.0
    losses = friction_losses(known, damping, friction, creep)
    low, high = motor_bounds(known, effort, fastest, knee, driving)
    out[2] = losses
    for j in range(len(speed)):
        # The command's own limits within the motor's; both less the losses, since they are of the motor's
        # torque and the range is of the torque on the leg.
        bottom, top = max(low[j], -limits[j]), min(high[j], limits[j])
        if math.isfinite(bottom) and math.isfinite(top):
            out[0, j] = 0.5 * (top + bottom) - losses[j]
            out[1, j] = max(0.5 * (top - bottom), least * limits[j])
        else:
            out[0, j], out[1, j] = 0.0, math.inf
