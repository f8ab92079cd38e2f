"""The shooting solver on MuJoCo: its steps, and A and B by its own finite differences (mjd_transitionFD).

Cost, Riccati recursion, line search and horizon are the same; what steps and what differentiates is not.
MuJoCo's tangents (linear parts in world axes) are turned into Pinocchio's (in body axes).
"""

from __future__ import annotations

from typing import Any

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.base.spatial import quaternion_wxyz, quaternion_xyzw, rotation_from_quaternion, skew
from surefoot.mechanics.robot import Robot
from surefoot.mechanics.terrain import FlatTerrain
from surefoot.motion.planning.shooting.horizon import FeedbackPolicy, Horizon
from surefoot.motion.planning.shooting.iteration import ShootingIteration
from surefoot.motion.planning.shooting.shooting_problem import ShootingProblem
from surefoot.motion.planning.shooting.state_space import feedback
from surefoot.worlds.mujoco.mujoco_world import add_ground, robot_spec

STEP = 1e-6
"""Of the finite differences."""


class MujocoHorizon(Horizon):
    """Knots that are MuJoCo's steps; no contact points, so a cost may not have terms of feet."""

    def __init__(self, problem: ShootingProblem, centred: bool) -> None:
        p = problem
        super().__init__(p.robot, p.knots, p.dt, p.mu, p.terrain)
        import mujoco

        self._mujoco, self._centred = mujoco, centred
        self.model = with_motors(p.robot, p.mu, p.dt)
        self._data = [mujoco.MjData(self.model) for _ in range(p.knots)]
        n = self.v.shape[1]
        self.J, self.rates, self.heights = (
            np.zeros((p.knots, 0, n)),
            np.zeros((p.knots, 0, n)),
            np.zeros((p.knots, 0)),
        )
        self._FD = np.zeros((2 * n, 2 * n)), np.zeros((2 * n, self.model.nu))

    def _step(self, k: int) -> tuple[FloatArray, FloatArray]:
        """Return the state behind a knot."""
        data = self._data[k]
        self._write(k)
        self._mujoco.mj_step(self.model, data)
        q = np.concatenate([data.qpos[:3], quaternion_xyzw(data.qpos[3:7]), data.qpos[7:]])
        v = data.qvel.copy()
        v[:3] = rotation_from_quaternion(q[3:7]).T @ v[:3]
        self._write(k)  # differentiate at the start
        return q, v

    def _write(self, k: int) -> None:
        data, q, v = self._data[k], self.q[k], self.v[k]
        data.qpos[:3], data.qpos[3:7], data.qpos[7:] = q[:3], quaternion_wxyz(q[3:7]), q[7:]
        data.qvel[:3], data.qvel[3:] = rotation_from_quaternion(q[3:7]) @ v[:3], v[3:]
        data.ctrl[:], data.qacc_warmstart[:] = self.torques[k], 0.0

    def run(
        self, start: tuple[FloatArray, FloatArray], policy: FeedbackPolicy, share: float, limits: FloatArray
    ) -> bool:
        """Step from a state under a policy; see `Horizon.run`."""
        self.q[0], self.v[0], self.gaps[:] = *start, 0.0
        for k in range(len(self)):
            here = self.q[k], self.v[k]
            self.torques[k] = feedback(
                self.floating, here, (policy.q[k], policy.v[k]), policy.torques[k], policy.steps[k], share,
                policy.gains[k], limits[k],
            )  # fmt: skip
            self.q[k + 1], self.v[k + 1] = self._step(k)
        return bool(np.isfinite(self.q[-1]).all())

    def take(self, q: FloatArray, v: FloatArray, torques: FloatArray) -> bool:
        """Take a motion as it is; see `Horizon.take`."""
        self.q[:], self.v[:], self.torques[:] = q, v, torques
        for k in range(len(self)):
            self._open(k, *self._step(k))
        return True

    def differentiate(self, smoothing: float) -> bool:
        """Fill A and B by finite differences; there is nothing to smooth."""
        for k, data in enumerate(self._data):
            self._mujoco.mjd_transitionFD(self.model, data, STEP, self._centred, *self._FD, None, None)
            before, after = _turned(self.q[k], self.v[k]), _turned(self.q[k + 1], self.v[k + 1])
            inverse = np.linalg.inv(after)
            self.A[k], self.B[k] = inverse @ self._FD[0] @ before, inverse @ self._FD[1]
        return True


def with_motors(robot: Robot, mu: float, dt: float) -> Any:
    """Return the world's model with a motor at every joint: applied forces are no inputs of MuJoCo's."""
    import mujoco

    spec = robot_spec(robot, 0.0)
    add_ground(spec, FlatTerrain(), mu, None, None)
    spec.option.timestep = dt
    for name in robot.joint_names:
        spec.add_actuator(name=name, trntype=mujoco.mjtTrn.mjTRN_JOINT, target=name)
    return spec.compile()


class MujocoIteration(ShootingIteration):
    """The solver's iteration on MuJoCo."""

    centred = False

    def horizon(self, tol: float) -> Horizon:
        """Return MuJoCo's knots."""
        return MujocoHorizon(self.problem, self.centred)


def _turned(q: FloatArray, v: FloatArray) -> FloatArray:
    """Return (2nv, 2nv) MuJoCo's tangents by Pinocchio's."""
    n, R = len(v), rotation_from_quaternion(q[3:7])
    T = np.eye(2 * n)
    T[:3, :3] = T[n : n + 3, n : n + 3] = R
    T[n : n + 3, 3:6] = -R @ skew(v[:3])
    return T
