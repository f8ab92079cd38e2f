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
from dataclasses import dataclass

import numpy as np
from scipy import stats
from scipy.ndimage import shift

from surefoot.base.arrays import of_kind
from surefoot.base.drawn import Drawn
from surefoot.base.errors import ProblemError, count_of
from surefoot.mechanics import Robot, real_actuators
from surefoot.records.identification.foot_friction import (
    FootFriction,
    friction_of_feet,
    is_upright,
)
from surefoot.records.identification.toss_fit import Estimate
from surefoot.records.identification.walk_forces import foot_forces_of
from surefoot.records.identification.walk_motion import (
    CREEP,
    WINDOW,
    WalkRows,
    figures_of,
    fit_motion,
    walk_channels,
    walk_rows,
)
from surefoot.records.log import Log

START, LONGEST, SHORTEST = 0.2, 20.0, 2.0
"""What is left out at the beginning, the longest part that is looked at, and the least that will do [s]."""
ZEROS = 1e-3
"""Standard deviation of the zeros of the encoders [rad]: what a calibration leaves."""
LEAD = 0.003
"""Dry friction may turn so long before or after the speed does [s]: simulators smooth it, gears have play."""
STAMPS = 1e-3
"""Largest difference between the clocks of torques and angles [s]: a row of an ordinary bus."""
DRAWS = 12
"""Draws of what is not known."""
LATEST, AGREED, JUMPS = 0.03, 0.5, 5.0
"""Longest latency that is looked for [s], the least correlation that tells one, and how many times the median
a change is that is left out."""
FACTORS = ("armature", "joint_damping", "joint_friction")
"""Factors of the figures of `real_actuators`."""


@dataclass(frozen=True, repr=False)
class RobotFit(Drawn):
    """What a walk shows.

    Attributes
    ----------
    parameters
        By the names that `surefoot sweep` knows: `FACTORS` [x nominal], payload [kg], delay [s], mu [-]. One
        that is only bounded below has an infinite `high`.
    notes
        What to know about them, a line each.
    feet
        Friction under each foot.
    """

    parameters: dict[str, Estimate]
    notes: tuple[str, ...]
    feet: tuple[FootFriction, ...] = ()

    def __repr__(self) -> str:
        return f"RobotFit({', '.join(self.parameters)})"

    def __str__(self) -> str:
        found = ", ".join(
            f"{name} {one.value:.3g} {one.unit}".rstrip() for name, one in self.parameters.items()
        )
        notes = f"; {count_of(len(self.notes), 'note')}, see .notes" if self.notes else ""
        return f"What the walk shows: {found or 'nothing'}{notes}."


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
    q, v, tau = walk_channels(robot, log)
    if len(log) * dt < START + SHORTEST:
        raise ProblemError(f"a walk of {START + SHORTEST:g} s is needed, the log has {len(log) * dt:g} s")
    cut = slice(round(START / dt), round((START + LONGEST) / dt))
    log = log.rows(cut)
    q, v, tau = q[cut], v[cut], tau[cut]
    normals = log.arrays.get("normals")
    rows = walk_rows(robot, q, v, tau, normals, dt)
    once, error = fit_motion(rows, motors, round(WINDOW / dt), CREEP)
    # Second differences 1, -2, 1 of white noise have six times its variance; a motion hardly shows in them,
    # and the median passes over touchdowns.
    noise = stats.median_abs_deviation(np.diff(v, 2, axis=0), scale="normal") / math.sqrt(6.0)
    draws = np.empty((DRAWS, len(once)))
    for k in range(DRAWS):
        zeros = np.r_[np.zeros(robot.model.nq - robot.joints), ZEROS * random.normal(size=robot.joints)]
        late = STAMPS * random.uniform(-1.0, 1.0) / dt
        heard = shift(tau, (late, 0.0), order=1, mode="nearest")
        other = walk_rows(robot, q + zeros, v + noise * random.normal(size=v.shape), heard, normals, dt)
        window, creep = WINDOW * random.uniform(0.6, 1.4), CREEP * 3.0 ** random.uniform(-1.0, 1.0)
        draws[k] = fit_motion(other, motors, round(window / dt), creep, LEAD * random.uniform(-1.0, 1.0))[0]
    best = 2.0 * once - draws.mean(axis=0)  # what as much noise again has changed is taken off
    half = np.hypot(error, stats.t.ppf(0.975, DRAWS - 1) * draws.std(axis=0, ddof=1))
    units = dict.fromkeys(FACTORS, "x nominal") | {"payload": "kg"}
    low, high = (best + sign * half for sign in (-1.0, 1.0))
    found = {
        name: Estimate(float(best[k]), float(low[k]), float(high[k]), unit)
        for k, (name, unit) in enumerate(units.items())
        if name not in FACTORS or figures_of(motors)[k].any()
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
    seen = robot, rows, foot_forces_of(robot, rows, motors, best, dt), is_upright(q[:-1]), dt
    feet, ground = friction_of_feet(*seen)
    middle = ground.low if math.isinf(ground.high) else 0.5 * (ground.low + ground.high)
    found["mu"] = Estimate(middle, ground.low, ground.high)
    if math.isinf(found["mu"].high):
        notes.append(f"mu: no foot slid, so that it is only known to be above {found['mu'].low:.2f}")
    return RobotFit(found, tuple(notes), feet)


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
