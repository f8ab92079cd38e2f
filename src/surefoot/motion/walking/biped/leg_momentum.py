"""The angular momentum of swinging legs and arms about the centre of mass, from the motion of the feet.

A single rigid body knows nothing of it, but the ground has to give it: with legs of a third of the weight it
moves the centre of pressure by the length of a foot. It is linear in the velocities of the feet against
the base, L = Σ G (v_foot - v_base), with G read off the centroidal momentum matrix [1]_ in the nominal pose.

References
----------
.. [1] D. Orin, A. Goswami, S.-H. Lee, "Centroidal dynamics of a humanoid robot", Autonomous Robots 2013.
"""

from __future__ import annotations

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.mechanics import Robot
from surefoot.motion.walking.walking_kernels import slope_frames


class LegMomentum:
    """Angular momentum of a robot's joints for motions of its feet, base upright and soles not turning.

    Parameters
    ----------
    robot
        With a left and a right foot.
    arms
        (joints,) speed of the joints outside the legs, over the speed at which the left foot overtakes the
        right one [rad/m].
    """

    def __init__(self, robot: Robot, arms: FloatArray) -> None:
        import pinocchio

        model, data, q = robot.model, robot.model.createData(), robot.nominal
        pinocchio.computeJointJacobians(model, data, q)
        A = np.array(pinocchio.ccrba(model, data, q, np.zeros(model.nv)))
        points = robot.contact_points
        shares, momenta = [], []
        for k, frame in enumerate(points.frames):
            pose = pinocchio.updateFramePlacement(model, data, frame)
            J = np.array(pinocchio.getFrameJacobian(model, data, frame, pinocchio.LOCAL_WORLD_ALIGNED))
            arm = pose.rotation @ points.middles[k]
            # From the frame's origin to the middle of the sole: v + ω x arm.
            J[:3] -= pinocchio.skew(arm) @ J[3:]
            leg = points.foot_support[k].copy()
            leg[:6] = False
            speeds = np.linalg.pinv(J[:, leg], rcond=1e-3)[:, :3]  # joint speeds of a foot that does not turn
            shares.append(A[:3, leg] @ speeds / robot.mass)
            momenta.append(A[3:, leg] @ speeds)
        self._shares, self._momenta = np.array(shares), np.array(momenta)
        self._base = np.linalg.inv(np.eye(3) - self._shares.sum(axis=0))
        self._arms = A[3:, 6:] @ arms

    def momentum(self, feet: FloatArray, com: FloatArray, yaw: FloatArray) -> FloatArray:
        """Return the angular momentum about the centre of mass (t, 3), world axes [N m s].

        Parameters
        ----------
        feet, com
            (t, 2, 3), (t, 3) velocities of the feet and of the centre of mass, world axes [m/s].
        yaw
            (t,) heading of the base [rad].
        """
        turns = slope_frames(yaw, np.zeros(2))
        local, flow = feet @ turns, np.einsum("ti,tij->tj", com, turns)
        # c' = v_base + Σ B (v_foot - v_base): the base is not the centre of mass
        base = (flow - np.einsum("kij,tkj->ti", self._shares, local)) @ self._base.T
        own = np.einsum("kij,tkj->ti", self._momenta, local - base[:, None])
        own += (local[:, 0, 0] - local[:, 1, 0])[:, None] * self._arms
        return np.asarray(np.einsum("tij,tj->ti", turns, own))

    def balancing(self) -> float:
        """Return the factor on the arms' motion at which they take up the legs' moment about the vertical.

        0 for a robot without arms that could.
        """
        legs = 0.5 * float(self._momenta[0, 2, 0] - self._momenta[1, 2, 0])
        arms = float(self._arms[2])
        return max(-legs / arms, 0.0) if abs(arms) > 1e-9 else 0.0
