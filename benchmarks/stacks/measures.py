"""What a run's log says, the same for every stack: from the true motion and the measured forces alone.

A controller's own word is taken for nothing but the forces that it counted on.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray
from surefoot.base.loaded import loaded_feet
from surefoot.base.spatial import GRAVITY, rotation_from_quaternion
from surefoot.records.audit.laws import log_laws
from surefoot.records.audit.limits import LIMITS
from surefoot.records.audit.motion import foot_forces, heading_velocity
from surefoot.records.audit.summary.estimate_summary import estimate_errors
from surefoot.records.audit.summary.motor_summary import motor_use
from surefoot.records.log import Log

CONE_LIMIT = 1e-3
"""A commanded force leaves its cone if it is this share of m g outside."""
TOUCHED = 1e-3
"""Something else than a foot touches the ground from this wrench on the base on, as a share of m g."""


@dataclass(frozen=True)
class Measures:
    """What one run came to; NaN where it cannot be told.

    Attributes
    ----------
    forward, left, turn
        Mean velocity in the heading frame after settling [m/s, rad/s].
    velocity_error, turn_error
        Distance of the planar velocity from the asked one [m/s], of the yaw rate [rad/s].
    heading
        Error of the heading at the end against the integrated command [deg].
    slip
        Longest sliding of one stance: net way of a contact's material over the ground between touchdown and
        lift-off as the forces have them [m].
    load
        Largest force of a foot over the weight.
    friction_use
        Share of the ground's friction that loaded contacts use, its 99th percentile.
    tilt
        Largest lean of the base against the vertical [deg].
    torque_use, speed_use
        Largest joint torque and speed over the robot's limits.
    over_speed
        Share of the steps with a joint above its speed limit.
    beyond_curve
        Share of the steps at which a motor was asked for more than it gives at its speed.
    cost_of_transport
        Positive mechanical work over m g times the way.
    cone_violations
        Share of the steps at which a force that the controller counted on lies outside the true cone.
    hits
        Share of the steps at which something else than a foot touched the ground; NaN where nothing else can.
    laws
        The laws of contact that the motion broke, a line each.
    estimate_velocity, estimate_drift
        Error of the estimated velocity [m/s rms]; drift of the estimated place over the way.
    """

    forward: float = math.nan
    left: float = math.nan
    turn: float = math.nan
    velocity_error: float = math.nan
    turn_error: float = math.nan
    heading: float = math.nan
    slip: float = math.nan
    tilt: float = math.nan
    torque_use: float = math.nan
    speed_use: float = math.nan
    over_speed: float = math.nan
    beyond_curve: float = math.nan
    cost_of_transport: float = math.nan
    cone_violations: float = math.nan
    hits: float = math.nan
    laws: tuple[str, ...] = ()
    estimate_velocity: float = math.nan
    estimate_drift: float = math.nan
    load: float = math.nan
    friction_use: float = math.nan


def measured(log: Log, asked: FloatArray, settled: float, links: bool) -> Measures:
    """Return what a log says.

    Parameters
    ----------
    log
        Of a run.
    asked
        (T, 3) velocity that was asked for at each of its rows: forward, left [m/s], yaw rate [rad/s].
    settled
        From when on the velocity should be the asked one [s].
    links
        Whether its world lets anything but feet touch.
    """
    weight, dt = log.fact("mass") * GRAVITY, float(log.fact("dt"))
    velocity, late = heading_velocity(log), log["time"] >= settled
    mean, wanted = (x[late].mean(axis=0) if late.any() else np.full(3, np.nan) for x in (velocity, asked))
    up = rotation_from_quaternion(log["q"][:, 3:7])[:, 2, 2]
    motors = motor_use(log)
    errors = estimate_errors(log) if "q_estimated" in log else None
    drift = math.nan if errors is None or errors.drift_share is None else errors.drift_share
    return Measures(
        forward=float(mean[0]),
        left=float(mean[1]),
        turn=float(mean[2]),
        velocity_error=float(np.linalg.norm((mean - wanted)[:2])),
        turn_error=float(abs(mean[2] - wanted[2])),
        heading=heading_error(log["q"], asked[:, 2], dt),
        slip=float(stance_slides(log).max()),
        tilt=float(np.degrees(np.arccos(np.clip(up.min(), -1.0, 1.0)))),
        torque_use=float((np.abs(log["torques"]) / log.fact("effort_limits")).max()),
        speed_use=math.nan if motors is None else motors.speed_use_max,
        over_speed=math.nan if motors is None else motors.over_speed_share,
        beyond_curve=math.nan if motors is None else motors.beyond_curve_share,
        cost_of_transport=cost_of_transport(log, weight),
        cone_violations=float(outside_cones(log, CONE_LIMIT * weight).mean()),
        hits=_hits(log, weight) if links else math.nan,
        laws=tuple(log_laws(log).broken(weight)),
        estimate_velocity=math.nan if errors is None else errors.velocity_rms,
        estimate_drift=drift,
        load=float(np.linalg.norm(foot_forces(log), axis=-1).max()) / weight,
        friction_use=friction_use(log, weight),
    )


def heading_error(q: FloatArray, turning: FloatArray, dt: float) -> float:
    """Return how far (T, nq) configurations turned beyond (T,) yaw rates [rad/s] at the end [deg]."""
    R = rotation_from_quaternion(q[:, 3:7])
    yaw = np.unwrap(np.arctan2(R[:, 1, 0], R[:, 0, 0]))
    return float(np.degrees(yaw[-1] - yaw[0] - turning[:-1].sum() * dt))


def stance_slides(log: Log) -> FloatArray:
    """Return the longest net way over the ground in one stance of each contact: (p,) [m].

    A stance lasts while the contact carries weight; gaps shorter than `LawLimits.release` are bounces.
    """
    dt, velocity = float(log.fact("dt")), log["contact_velocities"][..., :2]
    loaded = loaded_feet(log["forces"][..., 2], log.fact("mass") * GRAVITY)
    contacts = range(loaded.shape[1])
    return np.array(
        [_longest(loaded[:, c], velocity[:, c] * dt, round(LIMITS.laws.release / dt)) for c in contacts]
    )


def _longest(loaded: BoolArray, steps: FloatArray, gap: int) -> float:
    """Return the longest net way of a stance: (T,) whether it is loaded, (T, 2) ways of each row [m]."""
    rows = np.flatnonzero(loaded)
    if len(rows) == 0:
        return 0.0
    starts = np.concatenate([[0], np.flatnonzero(np.diff(rows) > gap) + 1])
    stance = np.repeat(np.arange(len(starts)), np.diff([*starts, len(rows)]))
    way = np.cumsum(steps[rows], axis=0)
    # the row of a touchdown is left out: its velocity is that of the free foot
    return float(np.linalg.norm(way - way[starts][stance], axis=1).max())


def cost_of_transport(log: Log, weight: float) -> float:
    """Return positive mechanical work over weight [N] times way; NaN for a way shorter than 0.1 m."""
    power = np.maximum(log["torques"] * log["v"][:, 6:], 0.0).sum(axis=1)
    way = float(np.linalg.norm(log["q"][-1, :2] - log["q"][0, :2]))
    return float(power.sum() * log.fact("dt") / (weight * way)) if way > 0.1 else math.nan


def friction_use(log: Log, weight: float) -> float:
    """Return the 99th percentile of the share of friction that loaded contacts use; NaN without any."""
    f, mu = log["forces"], np.broadcast_to(log["mu"][:, None], log["forces"].shape[:2])
    loaded = loaded_feet(f[..., 2], weight)
    use = np.hypot(f[..., 0], f[..., 1])[loaded] / (mu * f[..., 2])[loaded]
    return float(np.percentile(use, 99.0)) if use.size else math.nan


def outside_cones(log: Log, least: float) -> BoolArray:
    """Return at which rows a commanded force lies more than `least` [N] outside the ground's cone: (T,)."""
    f, mu = log["forces_commanded"], log["mu"][:, None]
    return np.asarray((np.hypot(f[..., 0], f[..., 1]) - mu * f[..., 2] > least).any(axis=1))


def _hits(log: Log, weight: float) -> float:
    if "other_forces" not in log:
        return math.nan
    # what touches moves the base; joints at their stops, which the channel holds as well, do not
    return float((np.abs(log["other_forces"][:, :6]).max(axis=1) > TOUCHED * weight).mean())
