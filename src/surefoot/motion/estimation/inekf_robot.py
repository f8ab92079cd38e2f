"""The invariant filter on a robot: IMU and encoders in, configuration and velocity out."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from surefoot.base.arrays import (
    BoolArray,
    FloatArray,
    finite_array,
    of_kind,
    real_number,
    sized_array,
    sized_flags,
)
from surefoot.base.errors import ProblemError
from surefoot.base.live_arrays import Bound
from surefoot.base.spatial import rotation_from_quaternion
from surefoot.mechanics import Robot, Terrain
from surefoot.motion.estimation.estimator_kernels import BELIEVED, LANDED, fade_shake, stand
from surefoot.motion.estimation.foot_kinematics import FootKinematics, base_state
from surefoot.motion.estimation.inekf import FilterNoise, InvariantFilter
from surefoot.motion.estimation.trust import Trust, TrustMonitor

SLIDING = 0.5
"""A foot that moves faster than this over the ground does not stand, whatever the contact says [m/s]."""
SETTLING = 0.02
"""Time after a touchdown in which a foot may still move a little, see `FilterNoise.landing` [s]."""
EDGE = 0.003
"""A sole whose edge is so far below its middle turns about that edge [m]."""


class InvariantEkf(Bound):
    """State estimate of a legged robot from its IMU, encoders and which feet touch; see `InvariantFilter`.

    A round foot rolls while it stands: what stands still is its centre less what it has rolled, r ∫ ω x n dt.

    Parameters
    ----------
    robot
        With a floating base and feet.
    dt
        Time between predictions [s].
    noise
        See `FilterNoise`; None for its defaults.
    ground
        Map of the ground. Where a foot lands, its height there corrects the estimate, which else drifts
        upwards or down; None to know nothing about the ground (it is taken to be level for rolling).
    imu_position
        (3,) of the IMU from the base's origin, base axes [m]; its axes are the base's.

    Attributes
    ----------
    filter
        `InvariantFilter`, with covariance and biases; its body is the IMU.
    normals
        (n, 3) of the ground where each foot landed last, world axes.
    feet
        `FootKinematics`.
    monitor
        `TrustMonitor`, which `trust` asks.
    memory
        What holds its numbers, see `robot_arrays`; q (nq,) and v (nv,) there are those of `StateEstimator`'s
        last reading, `stances` (2, n) says which feet stand and which have just landed.

    Raises
    ------
    ProblemError
        If the robot is bolted to the world or has no feet, or a number is out of range.

    Examples
    --------
    >>> from surefoot.mechanics.robot import load_robot
    >>> robot = load_robot("go2")
    >>> ekf = InvariantEkf(robot, 0.001)
    >>> ekf.reset(robot.nominal)
    >>> ekf.predict([0.0, 0.0, 0.0], [0.0, 0.0, 9.81])
    >>> ekf.update(robot.nominal[7:], np.zeros(12), [True] * 4)
    array([False, False, False, False])
    >>> q, v = ekf.q_v()
    >>> bool(abs(q - robot.nominal).max() < 1e-9)
    True
    """

    MEMORY = ("filter", "feet", "memory", "stances", "monitor")

    def __init__(
        self,
        robot: Robot,
        dt: float,
        noise: FilterNoise | None = None,
        ground: Terrain | None = None,
        imu_position: ArrayLike = (0.0, 0.0, 0.0),
    ) -> None:
        of_kind("robot", robot, Robot)
        if not robot.floating or not robot.feet:
            raise ProblemError(f"a state estimate needs a floating base with feet; {robot.name} has no such")
        self.robot, self.dt, self.ground = robot, real_number("dt", dt, low=1e-6, high=1.0), ground
        self.filter = InvariantFilter(len(robot.feet), noise)
        self.imu_position = finite_array("imu_position", imu_position, (3,))
        points, n, joints = robot.contact_points, len(robot.feet), robot.joints
        self._soles = points.foot_radii
        self._corners = [
            (k, points.centres[points.foot == k] - points.middles[k]) for k in range(n) if points.flat[k]
        ]
        self.feet = FootKinematics(robot, self.filter.noise.joint)
        self.stances: BoolArray = np.zeros((2, n), dtype=np.bool_)
        noise = self.filter.noise
        largest = np.array([noise.gyro_bias, noise.accelerometer_bias])
        self.monitor = TrustMonitor(tuple(foot.name for foot in robot.feet), self.dt, largest)
        self._sizes = [12, 7 + joints, 6 + joints, 3 * n, 3 * n, 3 * n, 3 * n]  # as `robot_arrays` has them
        self.memory: FloatArray = np.zeros(sum(self._sizes) + 9 * n)
        self._bind()
        self._numbers[0], self._numbers[1] = (self.dt, SETTLING, SLIDING), self.imu_position
        self._lines[0] = np.where(points.flat, 0.0, points.foot_radii)
        self.reset(robot.nominal)

    def _bind(self) -> None:
        """Find the parts of the memory."""
        n = self.filter.n
        parts = np.split(self.memory, np.cumsum(self._sizes))
        self._numbers, self.q, self.v = parts[0].reshape(4, 3), parts[1], parts[2]
        self._turn, self._lines = self._numbers[2], parts[3].reshape(3, n)
        self._pace, self._age = self._lines[1:]
        self.normals, self._rolled = parts[4].reshape(n, 3), parts[5].reshape(n, 3)
        self._turned = parts[7].reshape(n, 3, 3)

    def reset(self, q: ArrayLike, v: ArrayLike | None = None) -> None:
        """Start from (nq,) q [m, rad] and (nv,) v [m/s, rad/s]: place and heading are taken as they are.

        Velocity (zero for None), tilt and biases are as uncertain as the noise says.

        Raises
        ------
        ProblemError
            For wrong shapes or numbers that are not finite.
        """
        start = self.robot.configuration(q)
        velocity = (
            np.zeros(self.robot.model.nv) if v is None else finite_array("v", v, (self.robot.model.nv,))
        )
        R, arm = rotation_from_quaternion(start[3:7]), self.imu_position
        linear = R @ (velocity[:3] + np.cross(velocity[3:6], arm))
        self.filter.reset(R, linear, start[:3] + R @ arm)
        self.monitor.reset()
        self._turn[:] = velocity[3:6]
        self.joints(start[7:], velocity[6:])
        self._rolled[:] = self._pace[:] = self._numbers[3] = 0.0
        self._age[:], self.stances[:], self.normals[:] = -self.dt, False, (0.0, 0.0, 1.0)
        self.feet.update(*self.legs)
        self._turned[:] = R @ self.feet.rotations

    def predict(self, gyro: ArrayLike, accelerometer: ArrayLike) -> None:
        """Go on by dt with the (3,) turn rate [rad/s] and specific force [m/s²] of the IMU, base axes."""
        rate = sized_array("gyro", gyro, (3,))
        force = sized_array("accelerometer", accelerometer, (3,))
        self.filter.predict(rate, force, self.dt)
        self._numbers[3, 0] = fade_shake(self._numbers[3, 0], force, self.dt)
        self._turn[:] = rate - self.filter.bias[:3]

    def joints(self, positions: ArrayLike, speeds: ArrayLike) -> None:
        """Take the (joints,) angles [rad] and speeds [rad/s] that `q_v` holds from now on."""
        joints = (self.robot.joints,)
        self.q[7:] = sized_array("positions", positions, joints)
        self.v[6:] = sized_array("speeds", speeds, joints)

    def update(self, positions: ArrayLike, speeds: ArrayLike, contact: ArrayLike) -> BoolArray:
        """Correct with encoders and contacts; return which feet were believed: (n,).

        Parameters
        ----------
        positions, speeds
            (joints,) angles [rad] and speeds [rad/s].
        contact
            (n,) mask of the feet that touch; one that moves over the ground all the same is not used.
        """
        self.joints(positions, speeds)
        self.feet.update(*self.legs)
        touching, body = sized_flags("contact", contact, len(self.robot.feet)), self.filter
        self.correct(touching)
        self.monitor.take_correction(body.innovations, body.distances > 0.0, body.used, touching, body.bias)
        return body.used.copy()

    def correct(self, contact: BoolArray) -> bool:
        """Correct with feet where `feet` has them; return whether one was believed.

        Parameters
        ----------
        contact
            (n,) mask of the feet that touch [-].
        """
        body = self.filter
        found = stand(
            body.memory, body.flags, self.memory, self.feet.memory, self.stances, contact, self.robot.joints
        )
        if found & LANDED:
            self.land()
        return bool(found & BELIEVED)

    def land(self) -> None:
        """Use the map where feet have just landed."""
        ground, body = self.ground, self.filter
        if ground is None:
            return
        for k in np.flatnonzero(self.stances[0] & (self._age < 0.5 * self.dt)).tolist():
            place = body.X[:, 5 + k]
            normal = self.normals[k] = ground.normal(place[:2])
            excess = float(place[2] - ground.height(place[:2])) * normal[2] - self._soles[k]
            spread = body.height_deviation(k, normal, body.noise.height)
            believed = body.observe_height(k, self.normals[k], excess, body.noise.height)
            self.monitor.take_landing(excess, spread, believed)

    def level(self, standing: BoolArray) -> BoolArray:
        """Return which of the feet (n,) that stand do so on a whole sole; all of them if none does.

        The middle of a sole that turns about its edge moves.
        """
        out = standing.copy()
        for k, corners in self._corners:
            up = (self.filter.X[:, :3] @ self.feet.rotations[k]).T @ self.normals[k]
            out[k] &= float((corners @ up).min()) > -EDGE
        return out if not self._corners or out.any() else standing

    @property
    def trust(self) -> Trust:
        """Whether `update` has found the estimate as good as its covariance says, and why not if so."""
        return self.monitor.trust

    @property
    def legs(self) -> tuple[FloatArray, FloatArray]:
        """The (joints,) angles [rad] and speeds [rad/s] that it was given last; they are overwritten."""
        return self.q[7:], self.v[6:]

    def q_v(self) -> tuple[FloatArray, FloatArray]:
        """Return the estimate q (nq,) [m, rad] and v (nv,) [m/s, rad/s] in Pinocchio's order."""
        q, v = self.q.copy(), self.v.copy()
        base_state(self.filter.X, self._turn, self.imu_position, q, v)
        return q, v
