"""Friction under each foot of a recorded walk: an interval, or only a lower bound where the foot never slid.

A foot uses no more friction than there is, so that the most it used bounds mu below; a foot that slides uses
all of it. Forces are known from joints and motion alone, and badly where a foot lands: each row gets the
deviation of its forces from what the equation of motion leaves over there, and counts by it.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from scipy.ndimage import maximum_filter1d, minimum_filter1d, uniform_filter1d

from surefoot.base.arrays import BoolArray, FloatArray, of_kind
from surefoot.base.errors import ProblemError
from surefoot.base.numerics.phases import runs_of
from surefoot.base.spatial import GRAVITY
from surefoot.mechanics import Robot, real_actuators
from surefoot.records.identification.walk_motion import (
    CREEP,
    WINDOW,
    WalkRows,
    fit_motion,
    forces_of,
    walk_channels,
    walk_rows,
)
from surefoot.records.log import Log

LOADED = 0.12
"""Share of m g from which a foot tells of friction."""
LASTED = 0.02
"""A use of friction counts that lasts so long [s]."""
CREEPING = 0.04
"""Mean speed over `LASTED` from which a loaded foot slides [m/s]."""
SHARE, LEFT = 0.02, 0.4
"""Deviation of a foot's force by scales of torques and by masses, of its normal force [-], and by what the
equation of motion leaves over there, of its largest within `LASTED` [-]: measured on simulated walks."""
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
    forces, left = forces_of(rows, motors, theta, dt)
    steady = is_upright(q[:-1]) if known is None else is_upright(q[:-1]) & known[:-1]
    return friction_of_feet(robot, rows, forces, left, steady, dt)


def friction_of_feet(
    robot: Robot, rows: WalkRows, forces: FloatArray, left: FloatArray, upright: BoolArray, dt: float
) -> tuple[FootFriction, ...]:
    """Return friction under each foot.

    Parameters
    ----------
    robot, rows
        Who walked, and how.
    forces
        (T, p, 3) on the contact points, axes of the ground [N].
    left
        (T,) deviation of a force that the equation of motion leaves open [N].
    upright
        (T,) where nothing but feet touches.
    dt
        Of a row [s].
    """
    owner = np.asarray(robot.contact_points.foot)
    motion = np.einsum("tpji,tpj->tpi", rows.frames, np.einsum("tpiv,tv->tpi", rows.levers, rows.v))
    window = max(2, round(LASTED / dt))
    out = []
    for k, foot in enumerate(robot.feet):
        mine = owner == k
        force, speed = forces[:, mine].sum(axis=1), motion[:, mine].mean(axis=1)
        steady = upright & ~rows.swung[:, mine].any(axis=1)
        out.append(_bound(foot.name, force, speed, steady, left, LOADED * robot.mass * GRAVITY, window))
    return tuple(out)


def is_upright(q: FloatArray) -> BoolArray:
    """Return where the base of configurations (T, nq) has not yet leaned by `LEANS`."""
    up = 1.0 - 2.0 * (q[:, 3] ** 2 + q[:, 4] ** 2)
    return np.asarray(np.logical_and.accumulate(up > math.cos(LEANS)))


def _bound(
    name: str, force: FloatArray, velocity: FloatArray, steady: BoolArray, left: FloatArray, least: float,
    window: int,
) -> FootFriction:  # fmt: skip
    """Return the interval of one foot, of its forces and velocities (T, 3)."""
    normal = np.maximum(force[:, 2], 1e-9)
    used = np.hypot(force[:, 0], force[:, 1]) / normal
    error = np.hypot(SHARE, LEFT * maximum_filter1d(left, window) * np.sqrt(1.0 + used**2) / normal)
    loaded = minimum_filter1d((steady & (force[:, 2] > least)).astype(np.int8), window) > 0
    mean = uniform_filter1d(velocity[:, :2], window, axis=0)
    sliding = loaded & (minimum_filter1d(np.linalg.norm(mean, axis=1), window) > CREEPING)
    surely = np.where(loaded, minimum_filter1d(used - SURE * error, window), 0.0)
    low = max(0.0, float(surely.max()))
    slides = [slice(a, b) for a, b in runs_of(sliding)]
    if len(slides) < SLIPS:
        return FootFriction(name, low, math.inf, len(slides))
    uses = np.array([np.average(used[s], weights=error[s] ** -2) for s in slides])
    errors = np.array([error[s].min() for s in slides])
    # a middle by weights: slides of badly known forces, and false ones, are outvoted
    order = np.argsort(uses)
    share = np.cumsum(errors[order] ** -2) / np.sum(errors**-2)
    middle = float(uses[order][np.searchsorted(share, 0.5)])
    spread = 1.4826 * float(np.median(np.abs(uses - middle)))
    half = SURE * math.hypot(max(spread, float(np.median(errors))) / math.sqrt(len(uses)), SHARE)
    low = max(low, middle - half)
    return FootFriction(name, min(low, middle), middle + half, len(slides))
