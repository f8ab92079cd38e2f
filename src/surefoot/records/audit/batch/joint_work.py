"""Joint work that the actuators cannot give: the balance of mechanical energy, many environments at once.

Over a row in which torques tau are held, joints turn from q' to q'_1 and contacts give the work W,

    E_1 - E <= sum_j clip(tau_j, limit_j) (q'_j + q'_1j) / 2 dt + W:

whatever damps, in joints or contacts, only takes. Sums over windows are judged, and what a row leaves open is
allowed: half of the change of the velocities, times the torque. Energy that an integrator makes is not:
joints without damping that turn by 0.1 rad in a row gain it, and no actuator gave it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray, IntArray
from surefoot.base.errors import ProblemError
from surefoot.records.audit.batch.environments import Environments
from surefoot.records.audit.batch.law_found import LawFound
from surefoot.records.audit.limits import AuditLimits
from surefoot.records.log.from_arrays import host_array

JOINT_ARRAYS = ("torques", "joint_velocities", "energy")
"""Arrays of joints and of the whole robot, beside those of contacts."""
JOINT_WORK = "joint work"
"""Name of the sign."""


@dataclass(frozen=True)
class JointArrays:
    """What is known of N environments' joints over T rows.

    Attributes
    ----------
    velocities
        (T, N, j) [rad/s or m/s].
    torques
        (T, N, j) [N m or N], None where not known.
    energy
        (T, N) mechanical energy of the robot [J], None where not known.
    most
        Of the torques that actuators give: to be broadcast to (T, N, j); infinite without limits.
    rounding
        Of the energy [J].
    """

    velocities: FloatArray
    torques: FloatArray | None
    energy: FloatArray | None
    most: FloatArray
    rounding: float


def read_joints(arrays: Mapping[str, Any], effort_limits: Any, shape: tuple[int, int]) -> JointArrays | None:
    """Return the arrays of joints of (T, N) rows, checked; None where nothing about joints can be judged.

    Raises
    ------
    ProblemError
        For shapes that do not fit, and for limits that judge nothing.
    """
    given = {name: host_array(name, arrays[name]) for name in JOINT_ARRAYS if name in arrays}
    if not given:
        return None
    speeds = given.get("joint_velocities")
    if speeds is None:
        raise ProblemError(
            "joint work needs the array joint_velocities (T, N, joints) beside torques and energy"
        )
    if speeds.ndim != 3 or speeds.shape[:2] != shape:
        raise ProblemError(f"array joint_velocities must have shape (*{shape}, joints), got {speeds.shape}")
    for name, wanted in (("torques", speeds.shape), ("energy", shape)):
        if name in given and given[name].shape != wanted:
            raise ProblemError(f"array {name} must have shape {wanted}, got {given[name].shape}")
    most = _limits(effort_limits, speeds.shape)
    if "energy" not in given and ("torques" not in given or effort_limits is None):
        raise ProblemError(
            "joint work needs energy (T, N), or torques and the fact effort_limits, beside joint_velocities"
        )
    if "torques" not in given and effort_limits is None:
        raise ProblemError(
            "joint work needs torques (T, N, joints), or the fact effort_limits, beside energy"
        )
    parts = {name: np.asarray(array, dtype=np.float64) for name, array in given.items()}
    rounding = 0.0
    if "energy" in given:
        kind = given["energy"].dtype
        eps = float(np.finfo(kind if kind.kind == "f" else np.float64).eps)
        rounding = 4.0 * eps * float(np.nanmax(np.abs(parts["energy"]), initial=0.0))
    return JointArrays(parts["joint_velocities"], parts.get("torques"), parts.get("energy"), most, rounding)


def _limits(effort_limits: Any, shape: tuple[int, ...]) -> FloatArray:
    """Return limits that go with (T, N, j) torques; infinite for None."""
    if effort_limits is None:
        return np.full(1, np.inf)
    most = np.asarray(host_array("effort_limits", effort_limits), dtype=np.float64)
    if most.shape not in ((), shape[2:]) or not (most >= 0.0).all():
        wanted = f"a number or ({shape[2]},)"
        raise ProblemError(f"the fact effort_limits must be >= 0, {wanted}, got the shape {most.shape}")
    return most


def judge_joints(joints: JointArrays, given: Environments, limits: AuditLimits) -> tuple[LawFound, BoolArray]:
    """Return what the energy balance says of every environment, and in which rows (T, N) it is broken."""
    starts = _starts(given)
    last = np.append(starts[1:] > starts[:-1], np.ones((1, given.count), dtype=bool), axis=0)
    work, able, unsure = _works(joints, given.dt)
    if joints.energy is None:
        excess = np.maximum(work - able, 0.0).sum(axis=2)
    else:
        gain = np.diff(joints.energy, axis=0, append=joints.energy[-1:])
        excess = gain - able.sum(axis=2) - unsure.sum(axis=2) - _contact_work(given)
    excess, busy = (np.where(last, 0.0, part) for part in (excess, np.abs(work).sum(axis=2)))
    lost = ~np.isfinite(excess + busy)
    excess, busy = (np.where(lost, 0.0, part) for part in (excess, busy))
    w = max(1, round(limits.checks.slide_window / given.dt))
    value, power = (_window_sums(part, starts, w) for part in (excess, busy))
    least = limits.rebound.way * given.weights
    limit = np.maximum(least, limits.rebound.share * power) + joints.rounding
    bad = value > limit
    row = np.argmax(value - limit, axis=0)
    every = np.arange(given.count)
    joint = np.argmax(np.nan_to_num(np.abs(work[row, every])), axis=1)
    return (
        LawFound(
            JOINT_WORK,
            "J",
            False,
            bad.mean(axis=0),
            value[row, every],
            limit[row, every],
            given.dt * row,
            joint,
        ),
        bad,
    )


def _works(joints: JointArrays, dt: float) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the joints' work of rows, the most that actuators give, and what is open: (T, N, j) each [J]."""
    first = joints.velocities
    last = np.append(first[1:], first[-1:], axis=0)
    if joints.torques is None:  # as hard as they can, all the way
        able = joints.most * np.maximum(np.abs(first), np.abs(last)) * dt
        return able, able, np.zeros_like(able)
    torques = np.clip(joints.torques, -joints.most, joints.most)
    mean = 0.5 * dt * (first + last)
    return joints.torques * mean, torques * mean, 0.5 * dt * np.abs(torques * (last - first))


def _contact_work(given: Environments) -> FloatArray:
    """Return the most that contacts may have given in rows (T, N) [J]; of unknown velocities none."""
    if "contact_velocities" not in given.arrays:
        return np.zeros((given.rows, given.count))
    forces = np.asarray(given.arrays["forces"], dtype=np.float64)
    v = np.asarray(given.arrays["contact_velocities"], dtype=np.float64)
    ends = [
        (forces * u).sum(axis=3)
        for u in (v, np.append(v[1:], v[-1:], axis=0), np.append(v[:1], v[:-1], axis=0))
    ]
    return np.asarray(given.dt * np.max(ends, axis=0).sum(axis=2))


def _starts(given: Environments) -> IntArray:
    """Return the first row of the episode of every row (T, N)."""
    starts = np.zeros((given.rows, given.count), dtype=np.int64)
    for environment, first, end in given.episodes.tolist():
        starts[first:end, environment] = first
    return starts


def _window_sums(values: FloatArray, starts: IntArray, rows: int) -> FloatArray:
    """Return the sums of (T, N) values over so many rows up to each, no further than an episode's start."""
    total = np.concatenate([np.zeros((1, values.shape[1])), np.cumsum(values, axis=0)])
    place = np.arange(len(values))[:, None]
    begin = np.maximum(place - rows + 1, starts)
    return np.asarray(total[1:] - np.take_along_axis(total, begin, axis=0))
