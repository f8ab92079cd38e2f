"""Where the feet are, how they turn and how well that is known, from the joints alone: body axes."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray, IntArray
from surefoot.base.kernels import inline_kernel, kernel, window
from surefoot.base.live_arrays import Bound, live_parts
from surefoot.base.numerics.points import point_velocity
from surefoot.mechanics import Robot
from surefoot.motion.estimation.inekf_kernels import foresee

FLOOR = 1e-10
"""Least variance of a foot's place [m²]: a straight leg has no lever along itself, and is not exact."""


@kernel
def over_ground(
    X: FloatArray, turn: FloatArray, arm: FloatArray, centres: FloatArray, velocities: FloatArray,
    out: FloatArray,
) -> None:  # fmt: skip
    """Fill out (n,) with the feet's speeds over the ground [m/s], from the body's own velocity and turn rate.

    X (3, 5 + n) is the filter's state with the IMU as its body, at `arm` (3,) from the base; `turn` (3,) the
    turn rate, `centres` and `velocities` (n, 3) the feet against the base, all in body axes.
    """
    # Rᵀ v of the IMU, in body axes; a foot moves with it, with ω x r about it, and with its leg.
    u = X[0, 0] * X[0, 3] + X[1, 0] * X[1, 3] + X[2, 0] * X[2, 3]
    v = X[0, 1] * X[0, 3] + X[1, 1] * X[1, 3] + X[2, 1] * X[2, 3]
    w = X[0, 2] * X[0, 3] + X[1, 2] * X[1, 3] + X[2, 2] * X[2, 3]
    for k in range(centres.shape[0]):
        x, y, z = centres[k, 0] - arm[0], centres[k, 1] - arm[1], centres[k, 2] - arm[2]
        a = u + velocities[k, 0] + turn[1] * z - turn[2] * y
        b = v + velocities[k, 1] + turn[2] * x - turn[0] * z
        c = w + velocities[k, 2] + turn[0] * y - turn[1] * x
        out[k] = math.sqrt(a * a + b * b + c * c)


@kernel
def roll(
    X: FloatArray, feet: FloatArray, normals: FloatArray, radii: FloatArray, touching: BoolArray,
    last: FloatArray, rolled: FloatArray,
) -> None:  # fmt: skip
    """Add to rolled (n, 3) how far the centres of round feet went by rolling since the last call, world axes.

    A sphere that turns by a small δθ without sliding moves by r δθ x n; one in the air has not rolled.
    `feet` (n, 3, 3) are the feet's rotations in body axes, `last` (n, 3, 3) those in the world at the last
    call, which are replaced.
    """
    now = np.empty((3, 3))
    for k in range(radii.shape[0]):
        for r in range(3):
            for s in range(3):
                now[r, s] = 0.0
                for t in range(3):
                    now[r, s] += X[r, t] * feet[k, t, s]
        a = b = c = 0.0  # twice the turn: the skew part of now lastᵀ
        for s in range(3):
            a += now[2, s] * last[k, 1, s] - now[1, s] * last[k, 2, s]
            b += now[0, s] * last[k, 2, s] - now[2, s] * last[k, 0, s]
            c += now[1, s] * last[k, 0, s] - now[0, s] * last[k, 1, s]
        # The skew part holds 2 sin of the angle, which for the turn of one step is twice the angle.
        x, y, z, half = normals[k, 0], normals[k, 1], normals[k, 2], 0.5 * radii[k]
        rolled[k, 0] = rolled[k, 0] + half * (b * z - c * y) if touching[k] else 0.0
        rolled[k, 1] = rolled[k, 1] + half * (c * x - a * z) if touching[k] else 0.0
        rolled[k, 2] = rolled[k, 2] + half * (a * y - b * x) if touching[k] else 0.0
        last[k] = now


@kernel
def follow_stances(
    contact: BoolArray, pace: FloatArray, sliding: float, settling: float, dt: float, age: FloatArray,
    touching: BoolArray, landed: BoolArray,
) -> bool:  # fmt: skip
    """Fill which feet (n,) stand and which of them have just landed; return whether one does in this step.

    Parameters
    ----------
    contact, pace
        (n,) which touch, and their speeds over the ground [m/s].
    sliding, settling
        Speed from which a foot does not stand [m/s], and time in which it has just landed [s].
    dt, age
        Length of a step, and (n,) how long each foot stands, -dt in the air [s]; changed.
    touching, landed
        (n,) filled.
    """
    new = False
    for k in range(len(contact)):
        touching[k] = contact[k] and pace[k] <= sliding
        age[k] = age[k] + dt if touching[k] else -dt
        landed[k] = age[k] < settling
        # The first step on the ground has the age -dt + dt, zero but for rounding: half a step tells it from
        # the second.
        new = new or (touching[k] and age[k] < 0.5 * dt)
    return new


@kernel
def measure_places(
    X: FloatArray, centres: FloatArray, arm: FloatArray, rolled: FloatArray, out: FloatArray
) -> None:
    """Fill (n, 3) places of the feet from the IMU [m], body axes, less their (n, 3) rolls, world axes."""
    for k in range(len(centres)):
        for r in range(3):
            back = X[0, r] * rolled[k, 0] + X[1, r] * rolled[k, 1] + X[2, r] * rolled[k, 2]  # Rᵀ rolled
            out[k, r] = centres[k, r] - arm[r] - back


@kernel
def base_state(X: FloatArray, turn: FloatArray, arm: FloatArray, q: FloatArray, v: FloatArray) -> None:
    """Fill the base's part of q and v in Pinocchio's order from the filter's state; see `over_ground`."""
    for r in range(3):
        q[r] = X[r, 4] - X[r, 0] * arm[0] - X[r, 1] * arm[1] - X[r, 2] * arm[2]
        v[r] = X[0, r] * X[0, 3] + X[1, r] * X[1, 3] + X[2, r] * X[2, 3]
        v[3 + r] = turn[r]
    v[0] -= turn[1] * arm[2] - turn[2] * arm[1]
    v[1] -= turn[2] * arm[0] - turn[0] * arm[2]
    v[2] -= turn[0] * arm[1] - turn[1] * arm[0]
    # Shepperd's method: divide by the largest of the quaternion's numbers
    trace = X[0, 0] + X[1, 1] + X[2, 2]
    i = 0
    if X[1, 1] > X[i, i]:
        i = 1
    if X[2, 2] > X[i, i]:
        i = 2
    if trace >= X[i, i]:
        q[6] = 1.0 + trace
        q[3], q[4], q[5] = X[2, 1] - X[1, 2], X[0, 2] - X[2, 0], X[1, 0] - X[0, 1]
    else:
        j, m = (i + 1) % 3, (i + 2) % 3
        q[3 + i] = 1.0 + 2.0 * X[i, i] - trace
        q[3 + j], q[3 + m] = X[j, i] + X[i, j], X[m, i] + X[i, m]
        q[6] = X[m, j] - X[j, m]
    size = math.sqrt(q[3] * q[3] + q[4] * q[4] + q[5] * q[5] + q[6] * q[6])
    for r in range(3, 7):
        q[r] /= size if q[6] >= 0.0 else -size


@kernel
def state_ahead(
    X: FloatArray, bias: FloatArray, gyros: FloatArray, accelerometers: FloatArray, dt: float,
    arm: FloatArray, joints: FloatArray, speeds: FloatArray, early: FloatArray, late: FloatArray,
    span: float, ahead: float, q: FloatArray, v: FloatArray,
) -> None:  # fmt: skip
    """Fill q (nq,) [m, rad] and v (nv,) [m/s, rad/s] with the filter's state, moved on to now.

    Parameters
    ----------
    X, bias, arm
        (3, 5 + n), (6,), (3,) state of the filter and place of the IMU; see `over_ground`.
    gyros, accelerometers
        (m, 3) [rad/s], (m, 3) [m/s²] readings from the filter's time on, `dt` apart [s].
    joints, speeds
        (joints,) [rad], [rad/s] at the filter's time.
    early, late, span
        (joints,) speeds [rad/s] at two times and what is between them [s], for the accelerations.
    ahead
        How far the joints go on with them [s].
    """
    n = len(joints)
    now, turn = X[:, :5].copy(), np.empty(3)
    # The body by the readings that wait, its covariance left alone: nothing is learned here.
    foresee(now, bias, gyros, accelerometers, dt)
    for r in range(3):
        turn[r] = gyros[len(gyros) - 1, r] - bias[r]
    base_state(now, turn, arm, q, v)
    for j in range(n):
        rate = (late[j] - early[j]) / span
        q[7 + j] = joints[j] + ahead * (speeds[j] + 0.5 * ahead * rate)
        v[6 + j] = speeds[j] + ahead * rate


@kernel
def place_feet(
    twists: FloatArray, rotations: FloatArray, places: FloatArray, tables: IntArray, support: BoolArray,
    speeds: FloatArray, feet: FloatArray,
) -> None:  # fmt: skip
    """Fill what `FootKinematics` holds of feet, in its memory `feet`, from Pinocchio's placements of joints.

    Parameters
    ----------
    twists, support
        (6, nv) the joints' columns with the base at the origin; (n, nv) what moves each foot.
    rotations, places, tables
        (joints, 3, 3), (joints, 3) [m] of the joints; the joint of each velocity and of each foot.
    speeds
        (nv - 6,) of the joints [rad/s].
    """
    n, nv = support.shape
    centres, velocities, turned, spreads, fixed = foot_arrays(feet, n)
    variance = feet[36 * n]  # of an angle: times J Jᵀ it is a foot's
    for k in range(n):
        j = tables[nv + k]
        R, Q = rotations[j], fixed[4 * k : 4 * k + 4]
        velocity, spread = velocities[k], spreads[k]
        for r in range(3):
            velocity[r] = 0.0
            for s in range(3):
                turned[k, r, s] = R[r, 0] * Q[0, s] + R[r, 1] * Q[1, s] + R[r, 2] * Q[2, s]
                spread[r, s] = FLOOR if r == s else 0.0
            out = R[r, 0] * Q[3, 0] + R[r, 1] * Q[3, 1] + R[r, 2] * Q[3, 2]
            centres[k, r] = places[j, r] + out
        for j in range(6, nv):
            if support[k, j]:
                # Covariance J Jᵀ σ² of a foot whose joints' angles are off by σ each, independently.
                column = point_velocity(twists, j, centres[k, 0], centres[k, 1], centres[k, 2])
                for r in range(3):
                    velocity[r] += column[r] * speeds[j - 6]
                    for s in range(3):
                        spread[r, s] += variance * column[r] * column[s]


@inline_kernel
def foot_arrays(
    feet: FloatArray, n: int
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray, FloatArray]:
    """Return centres, velocities, rotations and spreads of n feet, and (4n, 3) how they lie on their joints.

    `feet` is the memory of `FootKinematics`; the last are rows of a rotation and a middle for each foot.
    """
    return (
        window(feet, 0, n, 3), window(feet, 3 * n, n, 3), window(feet, 6 * n, 3 * n, 3).reshape((n, 3, 3)),
        window(feet, 15 * n, 3 * n, 3).reshape((n, 3, 3)), window(feet, 24 * n, 4 * n, 3),
    )  # fmt: skip


class FootKinematics(Bound):
    """The feet of a robot as its joints have them; arrays are overwritten by the next `update` or `move`.

    Parameters
    ----------
    robot
        With a floating base and feet.
    deviation
        Standard deviation of a joint's angle [rad].

    Attributes
    ----------
    centres
        (n, 3) middles of the feet from the base's origin, base axes [m].
    rotations
        (n, 3, 3) rotation_base_foot.
    velocities
        (n, 3) of the middles against the base [m/s].
    spreads
        (n, 3, 3) covariances of the middles [m²].
    memory
        What holds these, see `foot_arrays`, and the variance of an angle and the joints' loads behind them.
    tables
        (nv + n,) joint that each velocity moves, and that carries each foot.
    support
        (n, nv) which velocities move each foot.
    """

    MEMORY = ("memory", "_q")

    def __init__(self, robot: Robot, deviation: float) -> None:
        import pinocchio

        points, model, n = robot.contact_points, robot.model, len(robot.feet)
        self._data: Any
        self._model, self._data, self._feet = model, model.createData(), n
        self._q: FloatArray = np.zeros(model.nq)
        self._q[6] = 1.0
        self.support = points.foot_support
        frames = [model.frames[frame] for frame in points.frames]
        joints = range(1, model.njoints)
        self.tables: IntArray = np.array(
            [i for i in joints for _ in range(model.joints[i].nv)] + [f.parentJoint for f in frames], np.int64
        )
        pinocchio.centerOfMass(model, self._data, self._q, True)
        fixed = [
            [*f.placement.rotation.ravel(), *f.placement.act(middle)]
            for f, middle in zip(frames, points.middles, strict=True)
        ]
        self.memory = np.concatenate([np.zeros(24 * n), np.ravel(fixed), [deviation**2], self._data.mass])
        self._bind()

    def _bind(self) -> None:
        """Find the parts of the memory and of Pinocchio's data."""
        n, data = self._feet, self._data
        self.centres, self.velocities = self.memory[: 3 * n].reshape(n, 3), self._part(3, n)
        self.rotations, self.spreads = self._part(6, n, 3), self._part(15, n, 3)
        self.twists, self.drifts = data.J, data.dJ
        self.turns, self.places = live_parts(data.oMi, "rotation"), live_parts(data.oMi, "translation")
        self.momenta, self.masses = live_parts(data.h, "vector"), live_parts(data.com)

    def __getstate__(self) -> dict[str, Any]:
        """Return what a copy is made of: no arrays on Pinocchio's memory."""
        views = ("twists", "drifts", "turns", "places", "momenta", "masses")
        return {name: value for name, value in self.__dict__.items() if name not in views}

    def _part(self, start: int, n: int, more: int = 1) -> FloatArray:
        """Return (n, 3) or (n, 3, 3) of the memory, from `start` times n on."""
        part = self.memory[start * n : (start + 3 * more) * n]
        return part.reshape((n, 3) if more == 1 else (n, more, 3))

    def update(self, positions: FloatArray, speeds: FloatArray) -> None:
        """Move to (joints,) angles [rad] and speeds [rad/s]."""
        import pinocchio

        self._q[7:] = positions
        pinocchio.computeJointJacobians(self._model, self._data, self._q)
        place_feet(self.twists, self.turns, self.places, self.tables, self.support, speeds, self.memory)

    def move(self, q: FloatArray, v: FloatArray) -> None:
        """Let Pinocchio find twists, their rates, momenta and centres of mass at (nq,) q, (nv,) v.

        All in the axes of the base, as if it were at the origin; the feet follow by `place_feet`.
        """
        import pinocchio as pin

        model, data = self._model, self._data
        self._q[7:] = q[7:]
        pin.computeJointJacobiansTimeVariation(model, data, self._q, v)
        pin.computeCentroidalMomentum(model, data)
        pin.centerOfMass(model, data, pin.KinematicLevel.POSITION, True)
