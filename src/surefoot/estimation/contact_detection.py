"""Which feet touch, from torques and kinematics alone: no sensor in the foot.

The generalised momentum p = M(q) v changes by what is known and by the ground's forces,

    ṗ = S τ + C(q, v)ᵀ v - g(q) + Jᵀ f,

so that r' = K (Jᵀ f - r) follows Jᵀ f without an acceleration being measured [1]_. The rows of a leg's joints
give the force on its foot; a foot touches when it is pushed harder than a threshold and lets go at a
lower one. A rise of the foot away from the ground ends a contact as well: a leg is lifted before the filtered
force is gone.

References
----------
.. [1] A. De Luca, A. Albu-Schäffer, S. Haddadin, G. Hirzinger, "Collision detection and safe reaction with
   the DLR-III lightweight manipulator arm", IROS 2006.
.. [2] G. Bledt, P. Wensing, S. Ingersoll, S. Kim, "Contact model fusion for event-based locomotion in
   unstructured terrains", ICRA 2018 (why force alone is late).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from surefoot.arrays import BoolArray, FloatArray, finite_array, of_kind, real_number
from surefoot.errors import ProblemError
from surefoot.estimation.detection_kernels import add_torques, feel_feet
from surefoot.estimation.foot_kinematics import FootKinematics
from surefoot.estimation.live_arrays import Bound
from surefoot.log import Log
from surefoot.robot import Robot
from surefoot.spatial import GRAVITY


@dataclass(frozen=True)
class DetectionSettings:
    """When a foot counts as touching.

    Attributes
    ----------
    bandwidth
        K of the momentum observer [1/s]: a force is seen after about 1/K.
    touchdown, lift_off
        Force along the normal at which a contact begins and ends, as a share of m g over the number of feet.
    rising
        Speed along the normal away from the ground from which a foot has left it [m/s].
    confirm
        How long the force must stay above `touchdown` before a contact is told [s].
    still
        A foot that is slower than this needs no more than `lift_off` to touch: it has landed softly [m/s].
    """

    bandwidth: float = 200.0
    touchdown: float = 0.25
    lift_off: float = 0.10
    rising: float = 0.15
    confirm: float = 0.0015
    still: float = 0.0

    def __post_init__(self) -> None:
        for name in ("bandwidth", "touchdown", "lift_off", "rising"):
            real_number(name, getattr(self, name), low=1e-9)
        for name in ("confirm", "still"):
            real_number(name, getattr(self, name), low=0.0)
        if self.lift_off > self.touchdown:
            raise ProblemError(
                f"lift_off must not exceed touchdown, got {self.lift_off:g} and {self.touchdown:g}"
            )


class DetectedContacts(NamedTuple):
    """What is known after one more step.

    Attributes
    ----------
    contact
        (n,) which feet touch.
    forces
        (n, 3) estimated forces on the feet, world axes [N].
    """

    contact: BoolArray
    forces: FloatArray


class ContactDetector(Bound):
    """Tells from joint torques and the robot's motion which feet touch, step by step.

    Parameters
    ----------
    robot
        With a floating base and feet.
    dt
        Time between updates [s].
    settings
        Thresholds; None for `DetectionSettings()`.
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

    Examples
    --------
    >>> import numpy as np
    >>> from surefoot.robot import load_robot
    >>> robot = load_robot("go2")
    >>> detector = ContactDetector(robot, 0.002)
    >>> detector.update(robot.nominal, np.zeros(18), np.zeros(12)).contact  # limp, at rest: it falls
    array([False, False, False, False])
    """

    def __init__(
        self,
        robot: Robot,
        dt: float,
        settings: DetectionSettings | None = None,
        feet: FootKinematics | None = None,
        least: float = 0.0,
    ) -> None:
        of_kind("robot", robot, Robot)
        if not robot.floating or not robot.feet:
            raise ProblemError(
                f"contacts are detected for a floating base with feet; {robot.name} has no such thing"
            )
        self.robot, self.settings = robot, settings or DetectionSettings()
        self.dt = real_number("dt", dt, low=1e-6, high=1.0)
        self._feet = FootKinematics(robot, 0.0) if feet is None else feet
        self._flags = np.array([robot.contact_points.flat, np.zeros(len(robot.feet), dtype=bool)])
        self._share = robot.mass * GRAVITY / len(robot.feet)
        self._joints = (robot.joints,)
        n, nv = len(robot.feet), int(robot.model.nv)
        self._memory: FloatArray = np.zeros(4 + 13 * n + 4 * nv)
        self._bind()
        self._radii[:], self._rotors[:] = robot.contact_points.foot_radii, robot.model.armature
        self._numbers[:] = math.exp(-self.settings.bandwidth * self.dt), self.dt, 0.0, least
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
        """Forget the past: the next update is the first."""
        n = len(self.robot.feet)
        self._past[:] = self._numbers[2] = 0.0
        self._contact, self._above = np.zeros(n, dtype=bool), np.zeros(n)

    def update(
        self, q: ArrayLike, v: ArrayLike, tau: ArrayLike | None = None, normals: ArrayLike | None = None
    ) -> DetectedContacts:
        """Return which feet touch, after one more step of length dt.

        Parameters
        ----------
        q, v
            (nq,), (nv,) configuration [m, -, rad] and velocity [m/s, rad/s] now, Pinocchio's order.
        tau
            (joints,) torques applied from now to the next update [N m]; None to tell them by `applied`, once
            they are known.
        normals
            (n, 3) unit normals of the ground under each foot, world axes; None for upwards.

        Raises
        ------
        ProblemError
            For wrong shapes or numbers that are not finite; the past is kept then.
        """
        model = self.robot.model
        configuration = self.robot.configuration(q)
        velocity = finite_array("v", v, (model.nv,))
        torque = None if tau is None else finite_array("tau", tau, (self.robot.joints,))
        up = self._normals(normals)
        self.observe(configuration, velocity, up)
        self._decide(up)
        if torque is not None:
            self._rate[self.robot.base_dof :] += torque
        return DetectedContacts(self._contact.copy(), self.forces.copy())

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
        feel_feet(
            feet.twists, feet.drifts, feet.turns, feet.places, feet.momenta, feet.masses, feet.tables,
            feet.support, self._flags, feet.memory, self._memory, q, v, up,
        )  # fmt: skip
        return self._pushed.copy()

    def applied(self, tau: ArrayLike) -> None:
        """Tell the (joints,) torques [N m] from the last update, which was not told them, to the next.

        Raises
        ------
        ProblemError
            For the wrong shape or numbers that are not finite.
        """
        torques = np.asarray(tau, dtype=np.float64)
        if torques.shape != self._joints or not add_torques(self._rate, torques):
            finite_array("tau", tau, self._joints)  # says what is wrong

    def _normals(self, normals: ArrayLike | None) -> FloatArray:
        n = len(self.robot.feet)
        if normals is None:
            return np.tile([0.0, 0.0, 1.0], (n, 1))
        given = finite_array("normals", normals, (n, 3))
        length = np.linalg.norm(given, axis=1)
        if (np.abs(length - 1.0) > 1e-3).any():
            raise ProblemError(f"normals must have length 1, got {length}")
        return np.asarray(given / length[:, None])

    def _decide(self, up: FloatArray) -> None:
        """Move the contacts on: hysteresis in the force, a rising foot has left, a resting one touches."""
        s, share = self.settings, self._share
        normal, rising = (self.forces * up).sum(axis=1), (self.velocities * up).sum(axis=1)
        still = (self.velocities * self.velocities).sum(axis=1) < s.still**2
        least = np.where(still, s.lift_off, s.touchdown) * share
        pushed = (normal > least) & (rising < s.rising)
        self._above = np.where(pushed, self._above + self.dt, 0.0)
        begins = pushed & (self._above > s.confirm)
        ends = (normal < s.lift_off * share) | (rising > s.rising)
        self._contact = np.where(self._contact, ~ends, begins)


def detect_contacts(robot: Robot, log: Log, settings: DetectionSettings | None = None) -> BoolArray:
    """Return which feet touch in each row of a log, from its ``q``, ``v`` and ``torques``: (T, n).

    Raises
    ------
    ProblemError
        If a channel or the fact ``dt`` is missing, or what they hold does not fit the robot.
    """
    of_kind("robot", robot, Robot)
    of_kind("log", log, Log)
    missing = [name for name in ("q", "v", "torques") if name not in log]
    if missing:
        raise ProblemError(
            f"contacts are detected from q, v and torques; the log has no {', '.join(missing)}"
        )
    detector = ContactDetector(robot, log.fact("dt"), settings)
    rows = zip(log["q"], log["v"], log["torques"], strict=True)
    return np.array([detector.update(*row).contact for row in rows]).reshape(-1, len(robot.feet))
