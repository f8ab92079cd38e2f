"""What a joint's motor can give: torque limits that depend on the speed, as values and compiled."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.base.errors import ProblemError, check_name
from surefoot.base.kernels import inline_kernel, kernel
from surefoot.mechanics.robot import Robot

KNEE_SHARE = 0.45
"""Share of the no-load speed up to which a motor gives its driving torque: 13.5 of 30 rad/s for the Go2."""
DRIVING_SHARE = 20.2 / 23.4
"""Torque along the motion over torque against it, below that speed: 20.2 of 23.4 N m of the Go2's motors."""
MOTOR_MODELS = ("box", "curve")
"""Names that `motor_limits` knows."""


@dataclass(frozen=True, eq=False)
class MotorLimits:
    """Limits on every joint's torque, as a function of its speed.

    Against the motion (braking) a motor gives its whole `effort`. Along it, it gives `driving` times that up
    to the share `knee` of its no-load speed, and from there on linearly less, down to nothing at that speed:
    the back-EMF of a motor on a battery. With `driving` and `knee` one this is a box in torque and speed.

    Attributes
    ----------
    effort
        (joints,) largest torque [N m].
    speed
        (joints,) no-load speed, beyond which a motor only brakes [rad/s].
    knee, driving
        Shares, from 0 to 1.

    Raises
    ------
    ProblemError
        For limits that are not positive, or shares outside 0 to 1.

    Examples
    --------
    >>> motor = MotorLimits(np.array([20.0]), np.array([30.0]), knee=0.5)
    >>> [motor.clip(np.array([25.0]), np.array([speed])).item() for speed in (-30.0, 15.0, 22.5, 30.0)]
    [20.0, 20.0, 10.0, 0.0]
    """

    effort: FloatArray
    speed: FloatArray
    knee: float = 1.0
    driving: float = 1.0

    def __post_init__(self) -> None:
        for name in ("effort", "speed"):
            limits = np.asarray(getattr(self, name), dtype=np.float64)
            if limits.ndim != 1 or not (limits > 0.0).all():
                raise ProblemError(f"{name} limits must be positive, one for every joint, got {limits}")
            object.__setattr__(self, name, limits)
        for name in ("knee", "driving"):
            share = getattr(self, name)
            if not 0.0 <= share <= 1.0:
                raise ProblemError(f"{name} must be a share from 0 to 1, got {share:g}")

    def bounds(self, speed: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the least and the largest torque (joints,) at joint speeds (joints,) [rad/s]: [N m]."""
        return motor_bounds(np.asarray(speed, np.float64), self.effort, self.speed, self.knee, self.driving)

    def clip(self, torques: FloatArray, speed: FloatArray) -> FloatArray:
        """Return what the motors give of (joints,) torques at (joints,) joint speeds [N m]."""
        given = np.array(torques, np.float64)
        hold_to_motors(given, speed, self.effort, self.speed, self.knee, self.driving)
        return given


def motor_limits(robot: Robot, model: str = "box") -> MotorLimits:
    """Return the limits of a robot's motors: torque and speed limits of its URDF.

    Parameters
    ----------
    robot
        Limits that its model does not give are infinite.
    model
        "box": full torque up to the speed limit; "curve": falling torque, see `KNEE_SHARE` and
        `DRIVING_SHARE`, which Unitree publishes for the Go2's motors; the URDF's limits stay the scale.

    Raises
    ------
    ProblemError
        For another name.
    """
    check_name("motor model", model, MOTOR_MODELS)
    shares = (1.0, 1.0) if model == "box" else (KNEE_SHARE, DRIVING_SHARE)
    return MotorLimits(robot.effort_limits, robot.speed_limits, *shares)


@inline_kernel
def _driving(speed: float, effort: float, fastest: float, knee: float, driving: float) -> float:
    """Return a motor's largest torque along the motion [N m]; see `MotorLimits`."""
    share = abs(speed) / fastest
    if knee >= 1.0:
        falling = 1.0 if share < 1.0 else 0.0
    else:
        falling = min(max((1.0 - share) / (1.0 - knee), 0.0), 1.0)
    return 0.0 if falling == 0.0 else driving * falling * effort  # 0 times infinity is no torque


@inline_kernel
def _bounds(speed: float, effort: float, fastest: float, knee: float, driving: float) -> tuple[float, float]:
    """Return a motor's least and largest torque at a speed [N m]."""
    # Along the motion torque falls with speed, against it a motor brakes with all it has. NaN is neither: as
    # at rest.
    if speed > 0.0:
        return -effort, _driving(speed, effort, fastest, knee, driving)
    if speed < 0.0:
        return -_driving(speed, effort, fastest, knee, driving), effort
    return -effort, effort


@kernel
def motor_bounds(
    speed: FloatArray, effort: FloatArray, fastest: FloatArray, knee: float, driving: float
) -> tuple[FloatArray, FloatArray]:
    """Return the least and largest torques (joints,) of motors at joint speeds (joints,) [N m].

    Parameters
    ----------
    speed
        (joints,) [rad/s]; NaN counts as none.
    effort, fastest, knee, driving
        (joints,) [N m], (joints,) [rad/s], and shares: those of `MotorLimits`.
    """
    low, high = np.empty(len(speed)), np.empty(len(speed))
    for j in range(len(speed)):
        low[j], high[j] = _bounds(speed[j], effort[j], fastest[j], knee, driving)
    return low, high


@kernel
def hold_to_motors(
    torques: FloatArray, speed: FloatArray, effort: FloatArray, fastest: FloatArray, knee: float,
    driving: float,
) -> None:  # fmt: skip
    """Bring (joints,) torques [N m] within `motor_bounds`, which has the other parameters; NaN stays."""
    for j in range(len(torques)):
        low, high = _bounds(speed[j], effort[j], fastest[j], knee, driving)
        torques[j] = low if torques[j] < low else torques[j]
        torques[j] = high if torques[j] > high else torques[j]
