"""Compiled last pieces of whole-body control: the torques of contact forces, and what motors give of them."""

from __future__ import annotations

import math

import numpy as np

from surefoot.arrays import BoolArray, FloatArray
from surefoot.kernels import inline_kernel, kernel


@kernel
def recover(
    rows: FloatArray, forces: FloatArray, offset: FloatArray, gain: FloatArray, M: FloatArray, nle: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return the joint torques (joints,) and accelerations (nv,) that go with contact forces.

    Parameters
    ----------
    rows
        (3p, nv) Jacobian of the contact points, rows in contact axes.
    forces
        (p, 3) contact frames [N].
    offset, gain
        Accelerations are offset + gain w for the ground's force w (6,) on the base; see `eliminate`.
    M, nle
        (nv, nv), (nv,) mass matrix and bias forces.
    """
    nv = len(offset)
    ground, a = np.zeros(nv), np.empty(nv)
    for k in range(len(forces)):
        for i in range(3):
            f = forces[k, i]
            if f != 0.0:
                for j in range(nv):
                    ground[j] += rows[3 * k + i, j] * f
    for j in range(nv):
        total = offset[j]
        for i in range(6):
            total += gain[j, i] * ground[i]
        a[j] = total
    torques = np.empty(nv - 6)
    for j in range(6, nv):
        total = nle[j] - ground[j]
        for i in range(nv):
            total += M[j, i] * a[i]
        torques[j - 6] = total
    return torques, a


@kernel
def commanded(torques: FloatArray, middle: FloatArray, half: FloatArray, losses: FloatArray) -> FloatArray:
    """Return motor torques (joints,) for those on the legs: within middle ± half, plus `losses` [N m]."""
    out = np.empty(len(torques))
    for j in range(len(torques)):
        out[j] = min(max(torques[j], middle[j] - half[j]), middle[j] + half[j]) + losses[j]
    return out


@kernel
def exceeded(
    torques: FloatArray, middle: FloatArray, half: FloatArray, loose: BoolArray
) -> tuple[float, float, float, bool]:
    """Return by how much (joints,) torques leave the range middle ± half [N m], and whether all are finite.

    The first two are the largest distances from the middle over the half [-] among the joints that no
    contact loads (`loose`) and among the others, at least zero; the third is the largest excess [N m], of
    either sign.
    """
    light = heavy = 0.0
    most, finite = -math.inf, True
    for j in range(len(torques)):
        size = abs(torques[j] - middle[j])
        if not math.isfinite(size):
            finite = False
            continue
        if size > 0.0:
            share = size / half[j]
            if loose[j]:
                light = max(light, share)
            else:
                heavy = max(heavy, share)
        most = max(most, size - half[j])
    return light, heavy, most, finite


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
    knee: float, driving: float, creep: float, limits: FloatArray, least: float,
) -> tuple[FloatArray, FloatArray, FloatArray]:  # fmt: skip
    """Return middle and half of the range of torques that move the legs, and what friction takes.

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

    Returns
    -------
    tuple[FloatArray, FloatArray, FloatArray]
        (joints,) each [N m]; half is infinite where a bound is.
    """
    known = np.empty(len(speed))
    for j in range(len(speed)):
        known[j] = speed[j] if math.isfinite(speed[j]) else 0.0
    losses = friction_losses(known, damping, friction, creep)
    low, high = motor_bounds(known, effort, fastest, knee, driving)
    middle, half = np.empty(len(speed)), np.empty(len(speed))
    for j in range(len(speed)):
        bottom, top = max(low[j], -limits[j]), min(high[j], limits[j])
        if math.isfinite(bottom) and math.isfinite(top):
            middle[j] = 0.5 * (top + bottom) - losses[j]
            half[j] = max(0.5 * (top - bottom), least * limits[j])
        else:
            middle[j], half[j] = 0.0, math.inf
    return middle, half, losses
