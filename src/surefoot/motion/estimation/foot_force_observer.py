"""Forces on the feet from torques and kinematics alone: no sensor in the foot.

The generalised momentum p = M(q) v changes by what is known and by the ground's forces,

    ṗ = S τ + C(q, v)ᵀ v - g(q) + Jᵀ f,

so that r' = K (Jᵀ f - r) follows Jᵀ f without an acceleration being measured [1]_. The rows of a leg's joints
give the force on its foot; `contact_odds` says whether it touches.

References
----------
.. [1] A. De Luca, A. Albu-Schäffer, S. Haddadin, G. Hirzinger, "Collision detection and safe reaction with
   the DLR-III lightweight manipulator arm", IROS 2006.
.. [2] G. Bledt, P. Wensing, S. Ingersoll, S. Kim, "Contact model fusion for event-based locomotion in
   unstructured terrains", ICRA 2018 (why force alone is late).
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from surefoot.base.arrays import BoolArray, FloatArray, finite_array, of_kind, real_number
from surefoot.base.errors import ProblemError
from surefoot.base.live_arrays import Bound
from surefoot.mechanics import Robot
from surefoot.motion.estimation.detection_kernels import add_torques, sense_feet
from surefoot.motion.estimation.foot_kinematics import FootKinematics


class FootForceObserver(Bound):
    """Tells from joint torques and the robot's motion what pushes the feet, step by step.

    Parameters
    ----------
    robot
        With a floating base and feet.
    dt
        Time between observations [s].
    bandwidth
        K of the momentum observer [1/s]: a force is seen after about 1/K.
    feet
        Kinematics that are moved along; None for own ones.
    least
        Force along the normal that `observe` takes for a push [N].

    Attributes
    ----------
    forces, velocities
        (n, 3) estimated forces on the feet [N] and velocities of their lowest points [m/s], world axes; these
        arrays are overwritten by every step.
    points
        (n, 3) these points [m], likewise.

    Raises
    ------
    ProblemError
        If dt is not positive, or the robot is bolted to the world or has no feet.
    """

    MEMORY = ("_memory", "_flags")

    def __init__(
        self,
        robot: Robot,
        dt: float,
        bandwidth: float = 200.0,
        feet: FootKinematics | None = None,
        least: float = 0.0,
    ) -> None:
        of_kind("robot", robot, Robot)
        if not robot.floating or not robot.feet:
            raise ProblemError(
                f"forces are observed on the feet of a floating base; {robot.name} has no such thing"
            )
        self.robot = robot
        self.dt = real_number("dt", dt, low=1e-6, high=1.0)
        self._feet = FootKinematics(robot, 0.0) if feet is None else feet
        self._flags = np.array([robot.contact_points.flat, np.zeros(len(robot.feet), dtype=bool)])
        self._joints = (robot.joints,)
        n, nv = len(robot.feet), int(robot.model.nv)
        self._memory: FloatArray = np.zeros(4 + 13 * n + 4 * nv)
        self._bind()
        self._radii[:], self._rotors[:] = robot.contact_points.foot_radii, robot.model.armature
        keep = math.exp(-real_number("bandwidth", bandwidth, low=1e-9) * self.dt)
        self._numbers[:] = keep, self.dt, 0.0, least
        self.reset()

    def _bind(self) -> None:
        """Find the parts of the memory."""
        n, nv = len(self.robot.feet), int(self.robot.model.nv)
        sizes = [4, n, nv, nv, nv, nv, 3 * n, 3 * n, 3 * n]  # as `detector_arrays` has them
        parts = np.split(self._memory, np.cumsum(sizes))
        self._numbers, self._radii, self._rotors, _, self._rate, self._residual = parts[:6]
        self._past = self._memory[4 + n + nv :]
        self.forces, self.velocities, self.points = (part.reshape(n, 3) for part in parts[6:9])
        self._pushed: BoolArray = self._flags[1]

    def reset(self) -> None:
        """Forget the past: the next observation is the first."""
        self._past[:] = self._numbers[2] = 0.0

    def observe(self, q: FloatArray, v: FloatArray, up: FloatArray) -> BoolArray:
        """Find `forces`, `velocities` and `points` of the feet; return which are pushed by `least`: (n,).

        Parameters
        ----------
        q, v
            (nq,), (nv,) finite [m, rad], [m/s, rad/s]; the quaternion of length 1.
        up
            (n, 3) normals of the ground, world axes [-].
        """
        feet = self._feet
        feet.move(q, v)
        sense_feet(
            feet.twists, feet.drifts, feet.turns, feet.places, feet.momenta, feet.masses, feet.tables,
            feet.support, self._flags, feet.memory, self._memory, q, v, up,
        )  # fmt: skip
        return self._pushed.copy()

    def applied(self, tau: ArrayLike) -> None:
        """Take the (joints,) torques [N m] from the last observation to the next.

        Raises
        ------
        ProblemError
            For the wrong shape or numbers that are not finite.
        """
        torques = np.asarray(tau, dtype=np.float64)
        if torques.shape != self._joints or not add_torques(self._rate, torques):
            finite_array("tau", tau, self._joints)  # says what is wrong
