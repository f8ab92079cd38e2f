"""What a recorded walk tells of the robot and its floor: rotors, joint friction, payload, latency, friction.

Every row of a log obeys

    M a + h + S (s_I I a_j + s_b b q̇ + s_c c tanh(q̇ / creep)) + Y φ = S τ + Jᵀ f

with factors s of the figures I, b, c of the robot's motors, and the ten inertial parameters φ of what its
base carries. The forces f of feet that may touch are projected out, all else is linear [1]_; rows are
averaged over a window, so that a is a change of velocity, and weighed by what they leave over. Noise of the
velocities draws the factors down: as much noise again is added, and what that changes is taken off [2]_.
Intervals are jackknives over parts of the log, wider by what unknown zeros of the encoders, clocks, the
window and the moment at which dry friction turns make of the fit.

References
----------
.. [1] M. Mistry, S. Schaal, K. Yamane, "Inertial parameter estimation of floating base humanoid systems
   using partial force sensing", Humanoids 2009.
.. [2] J. Cook, L. Stefanski, "Simulation-extrapolation estimation in parametric measurement error models",
   JASA 1994.
"""

from __future__ import annotations

import math
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from scipy import stats
from scipy.ndimage import convolve1d, minimum_filter1d, shift

from surefoot.base.arrays import BoolArray, FloatArray, finite_array, of_kind
from surefoot.base.errors import ProblemError
from surefoot.base.spatial import GRAVITY
from surefoot.mechanics import Actuators, Robot, real_actuators, surface_frames
from surefoot.records.identification.friction_tracker import SLIDING_SPEED, SUSTAINED
from surefoot.records.identification.toss_fit import Estimate
from surefoot.records.log import Log

START, LONGEST, SHORTEST = 0.2, 20.0, 2.0
"""What is left out at the beginning, the longest part that is looked at, and the least that will do [s]."""
WINDOW, CREEP = 0.05, 0.03
"""Time over which rows are averaged [s], and speed at which dry friction counts as three quarters [rad/s]."""
SWUNG, AROUND = 0.3, 0.02
"""A foot that is faster [m/s] so long before and after [s] does not touch."""
ZEROS = 1e-3
"""Standard deviation of the zeros of the encoders [rad]: what a calibration leaves."""
LEAD = 0.003
"""Dry friction may turn so long before or after the speed does [s]: simulators smooth it, gears have play."""
FEW = 11
"""Rows over which a speed is averaged before its sign is taken."""
STAMPS = 1e-3
"""Largest difference between the clocks of torques and angles [s]: a row of an ordinary bus."""
DRAWS, PARTS = 12, 10
"""Draws of what is not known, and parts of the log that are left out one after the other."""
LATEST, AGREED, JUMPS = 0.03, 0.5, 5.0
"""Longest latency that is looked for [s], the least correlation that tells one, and how many times the median
a change is that is left out."""
LOADED, SLID = 0.1, 30
"""Share of m g over the feet from which a foot tells of friction, and sliding rows that tell it."""
FACTORS = ("armature", "joint_damping", "joint_friction")
"""Factors of the figures of `real_actuators`."""


class RobotFit(NamedTuple):
    """What a walk shows.

    Attributes
    ----------
    parameters
        By the names that `surefoot sweep` knows: `FACTORS` [x nominal], payload [kg], delay [s], mu [-]. One
        that is only bounded below has an infinite `high`.
    notes
        What to know about them, a line each.
    """

    parameters: dict[str, Estimate]
    notes: tuple[str, ...]


class WalkRows(NamedTuple):
    """T rows of a log, as the equation of motion needs them.

    Attributes
    ----------
    v, a, tau
        (T, nv), (T, nv), (T, joints) velocity at the end of a row, acceleration, torques.
    needed, load
        (T, nv) M a + h [N, N m]; (T, 6, 10) the same of a unit of each inertial parameter of the base's load.
    levers, frames
        (T, p, 3, nv) Jacobians of the contact points, world axes, and (T, p, 3, 3) axes of the ground there.
    swung
        (T, p) which points cannot touch.
    """

    v: FloatArray
    a: FloatArray
    tau: FloatArray
    needed: FloatArray
    load: FloatArray
    levers: FloatArray
    frames: FloatArray
    swung: BoolArray


def identify_robot(robot: Robot, log: Log, seed: int = 0) -> RobotFit:
    """Return what a walk says of rotors, friction in joints, payload, latency and friction of the ground.

    The log's own q, v and torques are used, the estimated q and v where it has them; of what a simulator
    knows besides (contact forces, mu, masses, motors) nothing.

    Parameters
    ----------
    robot
        Who walked, as its model says, without load.
    log
        With channels q, v or q_estimated, v_estimated, and torques; forces_commanded tell the latency.
    seed
        Of the zeros of the encoders that are tried.

    Raises
    ------
    ProblemError
        If a channel is missing or does not fit the robot, or the log is shorter than `SHORTEST`.
    """
    of_kind("robot", robot, Robot)
    of_kind("log", log, Log)
    dt, random, motors = log.fact("dt"), np.random.default_rng(seed), real_actuators(robot)
    q, v, tau = _channels(robot, log, dt)
    cut = slice(round(START / dt), round((START + LONGEST) / dt))
    log = log.rows(cut)
    q, v, tau = q[cut], v[cut], tau[cut]
    normals = log.arrays.get("normals")
    rows = _rows(robot, q, v, tau, normals, dt)
    once, error = _fit(rows, motors, round(WINDOW / dt), CREEP)
    # Second differences 1, -2, 1 of white noise have six times its variance; a motion hardly shows in them,
    # and the median passes over touchdowns.
    noise = stats.median_abs_deviation(np.diff(v, 2, axis=0), scale="normal") / math.sqrt(6.0)
    draws = np.empty((DRAWS, len(once)))
    for k in range(DRAWS):
        zeros = np.r_[np.zeros(robot.model.nq - robot.joints), ZEROS * random.normal(size=robot.joints)]
        late = STAMPS * random.uniform(-1.0, 1.0) / dt
        heard = shift(tau, (late, 0.0), order=1, mode="nearest")
        other = _rows(robot, q + zeros, v + noise * random.normal(size=v.shape), heard, normals, dt)
        window, creep = WINDOW * random.uniform(0.6, 1.4), CREEP * 3.0 ** random.uniform(-1.0, 1.0)
        draws[k] = _fit(other, motors, round(window / dt), creep, LEAD * random.uniform(-1.0, 1.0))[0]
    best = 2.0 * once - draws.mean(axis=0)  # what as much noise again has changed is taken off
    half = np.hypot(error, stats.t.ppf(0.975, DRAWS - 1) * draws.std(axis=0, ddof=1))
    units = dict.fromkeys(FACTORS, "x nominal") | {"payload": "kg"}
    low, high = (best + sign * half for sign in (-1.0, 1.0))
    found = {
        name: Estimate(float(best[k]), float(low[k]), float(high[k]), unit)
        for k, (name, unit) in enumerate(units.items())
        if name not in FACTORS or _figures(motors)[k].any()
    }
    notes = [f"{n}: the model gives no such figure of this robot's motors" for n in units if n not in found]
    notes += [
        f"{n}: below zero, so that the model is not this robot's, or other torques moved it"
        for n, e in found.items()
        if e.high < 0.0
    ]
    delay = _latency(rows, log, dt) if "forces_commanded" in log else None
    if delay is None:
        notes.append("delay: the log does not say which forces were commanded")
    else:
        found["delay"] = delay
    found["mu"] = _friction(rows, _forces(rows, motors, best, dt), robot, dt)
    if math.isinf(found["mu"].high):
        notes.append(f"mu: no foot slid, so that it is only known to be above {found['mu'].low:.2f}")
    return RobotFit(found, tuple(notes))


def _channels(robot: Robot, log: Log, dt: float) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return q (T, nq), v (T, nv) and torques (T, joints), or raise for what is missing or does not fit."""
    model, names = robot.model, ("q_estimated", "v_estimated", "torques")
    if not robot.floating or not robot.feet:
        raise ProblemError(f"a walk is of a floating base with feet; {robot.name} has no such thing")
    if "q_estimated" not in log or "v_estimated" not in log:
        names = ("q", "v", "torques")
    if missing := [name for name in names if name not in log]:
        raise ProblemError(f"a robot is identified from q, v and torques; the log has no {missing[0]}")
    if len(log) * dt < START + SHORTEST:
        raise ProblemError(f"a walk of {START + SHORTEST:g} s is needed, the log has {len(log) * dt:g} s")
    sizes = (int(model.nq), int(model.nv), robot.joints)
    q, v, tau = (finite_array(n, log[n], (len(log), k)) for n, k in zip(names, sizes, strict=True))
    return q, v, tau


def _rows(
    robot: Robot, q: FloatArray, v: FloatArray, tau: FloatArray, normals: FloatArray | None, dt: float
) -> WalkRows:
    """Return what the equation of motion needs, row by row, but the last."""
    import pinocchio

    model, data, points = robot.model, robot.model.createData(), robot.contact_points
    T, p, nv = len(q) - 1, len(points), int(model.nv)
    a, spheres = np.diff(v, axis=0) / dt, list(zip(points.joints.tolist(), points.places, strict=True))
    needed, load, J = np.empty((T, nv)), np.empty((T, 6, 10)), np.empty((T, 6, nv))
    frames, up = np.empty((T, p, 3, 3)), np.zeros((T, p, 3)) + np.array([0.0, 0.0, 1.0])
    up = up if normals is None else np.asarray(normals[:-1])
    surface_frames(np.ascontiguousarray(up).reshape(-1, 3), frames.reshape(-1, 3, 3))
    places = -points.radii[:, None] * up
    for k in range(T):
        # M a + h, and the columns Y of the base's ten inertial parameters: the regressor reads the velocities
        # and accelerations that rnea has left in the data, so it comes right behind it.
        needed[k] = pinocchio.rnea(model, data, q[k], v[k], a[k])
        load[k] = pinocchio.jointBodyRegressor(model, data, 1)
        J[k] = pinocchio.computeJointJacobians(model, data, q[k])
        places[k] += [data.oMi[joint].act(place) for joint, place in spheres]
    # Pinocchio's M has the rotors' inertias in it, which get a factor of their own here.
    needed[:, robot.base_dof :] -= np.array(model.armature)[robot.base_dof :] * a[:, robot.base_dof :]
    # World-axes columns are of the point at the origin: at the contact it is v + ω x p, of joints that move
    # the foot.
    levers = J[:, None, :3] + np.cross(J[:, None, 3:], places[..., None], axis=2)
    levers *= points.support[:, None, :]
    speed = np.linalg.norm(np.einsum("tpiv,tv->tpi", levers, v[1:]), axis=2)
    swung = minimum_filter1d(speed, 2 * round(AROUND / dt) + 1, axis=0) > SWUNG
    return WalkRows(v[1:], a, tau[:-1], needed, load, levers, frames, swung)


def _figures(motors: Actuators) -> tuple[FloatArray, FloatArray, FloatArray]:
    return motors.armature, motors.damping, motors.friction


def _smooth(values: FloatArray, window: int) -> FloatArray:
    """Return (T, ...) values averaged over a Hann window of so many rows."""
    weights = np.hanning(window + 2)[1:-1]
    return np.asarray(convolve1d(values, weights / weights.sum(), axis=0))


def _terms(rows: WalkRows, motors: Actuators, creep: float, lead: float) -> tuple[FloatArray, FloatArray]:
    """Return X (T, nv, 13) and y (T, nv) with X θ - Jᵀ f = y for the factors and inertial parameters θ."""
    joints = slice(rows.v.shape[1] - rows.tau.shape[1], None)
    X, y = np.zeros((*rows.v.shape, 13)), -rows.needed
    moving = rows.a, rows.v, np.tanh((_smooth(rows.v, FEW) + lead * _smooth(rows.a, FEW)) / creep)
    for k, (figure, by) in enumerate(zip(_figures(motors), moving, strict=True)):
        X[:, joints, k] = figure * by[:, joints]
    X[:, :6, 3:] = rows.load
    y[:, joints] += rows.tau
    return X, y


def _feet(rows: WalkRows) -> FloatArray:
    """Return (T, nv, 3p) what forces on the points do, zero for those of feet in the air."""
    T, nv = rows.v.shape
    levers = rows.levers * ~rows.swung[:, :, None, None]
    return np.asarray(levers.reshape(T, -1, nv).transpose(0, 2, 1))


def _fit(
    rows: WalkRows, motors: Actuators, window: int, creep: float, lead: float = 0.0
) -> tuple[FloatArray, FloatArray]:
    """Return the parameters (13,) and the half-widths of their 95 % intervals by the jackknife."""
    X, y = _terms(rows, motors, creep, lead)
    U, sizes, _ = np.linalg.svd(_feet(rows), full_matrices=False)
    U *= (sizes > 1e-6 * sizes.max(axis=1, keepdims=True))[:, None, :]
    system = np.concatenate([X, y[:, :, None]], axis=2)
    system -= U @ (U.transpose(0, 2, 1) @ system)
    system = _smooth(system, window)[window :: max(1, window // 4)]
    weights = np.ones(rows.v.shape[1])
    for _ in range(3):
        theta = _solve(system, weights)
        left = system[:, :, -1] - system[:, :, :-1] @ theta
        weights = 1.0 / (left.std(axis=0) + 1e-9)
    cuts = np.linspace(0, len(system), PARTS + 1).astype(int)
    parts = [_solve(np.delete(system, slice(a, b), axis=0), weights) for a, b in pairwise(cuts)]
    error = np.sqrt((PARTS - 1) * np.var(parts, axis=0))
    return theta, stats.t.ppf(0.975, PARTS - 1) * error


def _solve(system: FloatArray, weights: FloatArray) -> FloatArray:
    """Return the least squares' parameters (13,); zero where nothing tells one."""
    flat = (system * weights[:, None]).reshape(-1, system.shape[2])
    size = np.linalg.norm(flat[:, :-1], axis=0)
    size[size == 0.0] = 1.0
    return np.asarray(np.linalg.lstsq(flat[:, :-1] / size, flat[:, -1], rcond=1e-10)[0] / size)


def _forces(rows: WalkRows, motors: Actuators, theta: FloatArray, dt: float) -> FloatArray:
    """Return (T, p, 3) forces on the contact points, axes of the ground [N]."""
    X, y = _terms(rows, motors, CREEP, 0.0)
    pushed = np.linalg.pinv(_feet(rows), rcond=1e-6) @ (X @ theta - y)[:, :, None]
    forces = _smooth(pushed.reshape(rows.frames.shape[:3]), round(SUSTAINED / dt))
    return np.asarray(np.einsum("tpji,tpj->tpi", rows.frames, forces))


def _friction(rows: WalkRows, forces: FloatArray, robot: Robot, dt: float) -> Estimate:
    """Return friction: at least what a foot used for `SUSTAINED`; no more than that where feet slid.

    What a sliding foot uses scatters by the errors of the forces, and is given with its quantiles.
    """
    around = 2 * round(SUSTAINED / dt) + 1
    normal = np.maximum(forces[:, :, 2], 1e-9)
    used = np.hypot(forces[:, :, 0], forces[:, :, 1]) / normal
    motion = np.einsum("tpji,tpj->tpi", rows.frames, np.einsum("tpiv,tv->tpi", rows.levers, rows.v))
    speed = np.linalg.norm(_smooth(motion[:, :, :2], around), axis=2)
    least = LOADED * robot.mass * GRAVITY / len(robot.feet)
    loaded = minimum_filter1d((normal > least).astype(np.int8), around, axis=0) > 0
    slid = used[loaded & (minimum_filter1d(speed, around, axis=0) > SLIDING_SPEED)]
    if slid.size >= SLID:
        low, middle, high = np.quantile(slid, [0.025, 0.5, 0.975])
        return Estimate(float(middle), float(low), float(high))
    lasted = np.where(loaded, minimum_filter1d(used, around, axis=0), 0.0)
    return Estimate(float(lasted.max()), float(lasted.max()), math.inf)


def _latency(rows: WalkRows, log: Log, dt: float) -> Estimate | None:
    """Return by how much torques are late after the forces that were commanded [s]; None if nothing agrees.

    Changes from row to row of the torques are held against those of -Jᵀ f of the legs that were to push.
    """
    asked = np.einsum("tpij,tpj->tpi", rows.frames, np.nan_to_num(np.asarray(log["forces_commanded"])[:-1]))
    pushing = np.einsum("tpiv,tpi->tv", rows.levers, -asked)[:, rows.v.shape[1] - rows.tau.shape[1] :]
    change, wanted = np.diff(rows.tau, axis=0), np.diff(pushing, axis=0)
    if not change.any() or not wanted.any():
        return None
    for one in (change, wanted):  # a foot that lands or leaves jumps
        size = np.abs(one)
        one[size > JUMPS * np.median(size[size > 0.0])] = 0.0
    most = round(LATEST / dt)
    ahead = [wanted[most - late : len(wanted) - late] for late in range(most + 1)]
    whole = np.linalg.norm(change[most:])
    agreed = [float((change[most:] * w).sum() / (whole * np.linalg.norm(w) + 1e-12)) for w in ahead]
    late = int(np.argmax(agreed))
    if agreed[late] < AGREED:
        return None
    return Estimate(late * dt, max(0.0, (late - 0.5) * dt), (late + 0.5) * dt, "s")
