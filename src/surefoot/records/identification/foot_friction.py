"""Friction under each foot of a recorded walk: an interval, or only a lower bound where the foot never slid.

A foot uses no more friction than there is, so that the most it used bounds mu below; a foot that slides uses
all of it, against its way. Each row's forces come with what the equation of motion leaves open of them, and
count by it; an estimated base that drifts makes standing feet seem to move, but their friction does not
oppose that.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from scipy.ndimage import minimum_filter1d, uniform_filter1d

from surefoot.base.arrays import BoolArray, FloatArray, of_kind
from surefoot.base.errors import ProblemError
from surefoot.base.numerics.phases import runs_of
from surefoot.base.spatial import GRAVITY
from surefoot.mechanics import Robot, real_actuators
from surefoot.records.identification.friction_tracker import OPPOSED
from surefoot.records.identification.walk_forces import LASTING, WalkForces, foot_forces_of
from surefoot.records.identification.walk_motion import (
    CREEP,
    WINDOW,
    WalkRows,
    fit_motion,
    walk_channels,
    walk_rows,
)
from surefoot.records.log import Log

LOADED = 0.12
"""Share of m g from which a foot tells of friction."""
CREEPING = 0.04
"""Mean speed over `LASTING` from which a loaded foot may slide [m/s]."""
SHARE = 0.02
"""Deviation of used friction by masses, places and clocks, as a share of it [-]."""
SURE = 2.6
"""Deviations that a bound is taken wider by: the most of many rows is looked for."""
SLIPS = 5
"""Slides from which friction is bounded above: a single one may be a foot that rolls, or a false one."""
SHORTEST = 0.6
"""Least of a walk that tells anything [s]."""
LEANS = 0.5
"""Tilt of the base [rad] from which the robot counts as fallen: other links than feet touch."""


class FootFriction(NamedTuple):
    """What a walk tells of the friction under a foot.

    Attributes
    ----------
    name
        Of the foot.
    low, high
        95 % interval of mu [-]; `high` is infinite where it is only bounded below.
    slips
        How often the foot slid.
    """

    name: str
    low: float
    high: float
    slips: int

    def __str__(self) -> str:
        if math.isinf(self.high):
            return f"{self.name}: mu above {self.low:.2f}"
        return f"{self.name}: mu {self.low:.2f} to {self.high:.2f}, {self.slips} slips"


def friction_of_walk(robot: Robot, log: Log, known: BoolArray | None = None) -> tuple[FootFriction, ...]:
    """Return friction under each foot of a walk, of its state, estimated where the log has that, and torques.

    Parameters
    ----------
    robot
        Who walked.
    log
        With channels q, v or q_estimated, v_estimated, and torques; without ``normals`` the ground is level.
    known
        (T,) rows whose state is believed; None for all.

    Raises
    ------
    ProblemError
        If a channel is missing or does not fit the robot, or the log is shorter than `SHORTEST`.

    Examples
    --------
    >>> from surefoot.mechanics import load_robot
    >>> robot, rows = load_robot("go2"), 800
    >>> import pinocchio
    >>> holding = pinocchio.computeGeneralizedGravity(robot.model, robot.data, robot.nominal)[6:]
    >>> log = Log({
    ...     "time": 0.001 * np.arange(rows), "q": np.tile(robot.nominal, (rows, 1)),
    ...     "v": np.zeros((rows, 18)), "torques": np.tile(holding, (rows, 1)),
    ... }, {"dt": 0.001})
    >>> [str(foot) for foot in friction_of_walk(robot, log)][0]
    'FL_foot: mu above 0.00'
    """
    of_kind("robot", robot, Robot)
    of_kind("log", log, Log)
    dt = log.fact("dt")
    q, v, torques = walk_channels(robot, log)
    if len(log) * dt < SHORTEST:
        raise ProblemError(f"friction needs a walk of {SHORTEST:g} s, the log has {len(log) * dt:g} s")
    rows = walk_rows(robot, q, v, torques, log.arrays.get("normals"), dt)
    motors = real_actuators(robot)
    theta, _ = fit_motion(rows, motors, max(2, round(WINDOW / dt)), CREEP)
    pushed = foot_forces_of(robot, rows, motors, theta, dt)
    steady = is_upright(q[:-1]) if known is None else is_upright(q[:-1]) & known[:-1]
    return friction_of_feet(robot, rows, pushed, steady, dt)[0]


def friction_of_feet(
    robot: Robot, rows: WalkRows, pushed: WalkForces, upright: BoolArray, dt: float
) -> tuple[tuple[FootFriction, ...], FootFriction]:
    """Return friction under each foot, and of the ground, taken to be the same under all of them.

    Parameters
    ----------
    robot, rows
        Who walked, and how.
    pushed
        Forces on the feet.
    upright
        (T,) where nothing but feet touches.
    dt
        Of a row [s].
    """
    seen = _gather_evidence(robot, rows, pushed, upright, dt)
    feet = tuple(_bound(foot.name, one) for foot, one in zip(robot.feet, seen, strict=True))
    slides = (np.concatenate(parts) for parts in zip(*(one[1:] for one in seen), strict=True))
    return feet, _bound("ground", _Evidence(max(one.low for one in seen), *slides))


def is_upright(q: FloatArray) -> BoolArray:
    """Return where the base of configurations (T, nq) has not yet leaned by `LEANS`."""
    up = 1.0 - 2.0 * (q[:, 3] ** 2 + q[:, 4] ** 2)
    return np.asarray(np.logical_and.accumulate(up > math.cos(LEANS)))


class _Evidence(NamedTuple):
    """What a foot shows: friction that it surely used, and (s,) what its slides used, with deviations.

    `shared` are those that all slides have alike.
    """

    low: float
    uses: FloatArray
    errors: FloatArray
    shared: FloatArray


def _gather_evidence(
    robot: Robot, rows: WalkRows, pushed: WalkForces, upright: BoolArray, dt: float
) -> list[_Evidence]:
    """Return what each foot shows of friction."""
    owner = np.asarray(robot.contact_points.foot)
    motion = np.einsum("tpji,tpj->tpi", rows.frames, np.einsum("tpiv,tv->tpi", rows.levers, rows.v))
    window, least = max(2, round(LASTING / dt)), LOADED * robot.mass * GRAVITY
    out = []
    for k in range(len(robot.feet)):
        mine = owner == k
        force, velocity = pushed.forces[:, k], motion[:, mine].mean(axis=1)
        bears = upright & ~rows.swung[:, mine].any(axis=1) & (force[:, 2] > least)
        loaded = minimum_filter1d(bears.astype(np.int8), window) > 0
        errors = pushed.covariance[:, k], pushed.by_scales[:, k]
        out.append(_weigh_foot(force, errors, velocity[:, :2], loaded, window))
    return out


def _weigh_foot(
    force: FloatArray, errors: tuple[FloatArray, FloatArray], velocity: FloatArray, loaded: BoolArray,
    window: int,
) -> _Evidence:  # fmt: skip
    """Return what a foot shows by forces (T, 3), their covariances, velocities (T, 2) and where it bears."""
    normal, size = np.maximum(force[:, 2], 1e-9), np.hypot(force[:, 0], force[:, 1])
    used = size / normal
    along = np.stack([*(force[:, :2].T / np.maximum(size, 1e-9)), -used], axis=1)
    error, alike = (np.sqrt(np.einsum("ti,tij,tj->t", along, one, along)) / normal for one in errors)
    alike = np.hypot(alike, SHARE * used)
    surely = minimum_filter1d(used - SURE * np.hypot(error, alike), window)
    mean = uniform_filter1d(velocity, window, axis=0)
    speed = np.linalg.norm(mean, axis=1)
    against = -np.einsum("ti,ti->t", force[:, :2], mean) / np.maximum(size * speed, 1e-9)
    moving = loaded & (minimum_filter1d(speed, window) > CREEPING)
    slides = [s for s in (slice(a, b) for a, b in runs_of(moving)) if np.median(against[s]) > OPPOSED]
    uses = np.array([np.average(used[s], weights=(error[s] + 1e-6) ** -2) for s in slides])
    each = np.array([error[s].min() for s in slides])
    shared = np.array([np.median(alike[s]) for s in slides])
    return _Evidence(float(np.where(loaded, surely, 0.0).max(initial=0.0)), uses, each, shared)


def _bound(name: str, seen: _Evidence) -> FootFriction:
    """Return the interval of what was seen."""
    low, uses, errors, shared = seen
    if len(uses) < SLIPS:
        return FootFriction(name, low, math.inf, len(uses))
    # middles by weights: slides of badly known forces, and false ones, are outvoted
    weights = (errors + 1e-6) ** -2
    middle = _weighted_median(uses, weights)
    spread = 1.4826 * _weighted_median(np.abs(uses - middle), weights)
    each = max(spread, math.sqrt(len(uses) / np.sum(weights)))
    count = np.sum(weights) ** 2 / np.sum(weights**2)  # of slides that weigh alike
    half = SURE * math.hypot(each / math.sqrt(count), _weighted_median(shared, weights))
    return FootFriction(name, max(0.0, middle - half), middle + half, len(uses))


def _weighted_median(values: FloatArray, weights: FloatArray) -> float:
    """Return the value that has half of the weight at or below it."""
    order = np.argsort(values)
    share = np.cumsum(weights[order]) / np.sum(weights)
    return float(values[order[np.argmax(share >= 0.5)]])
