"""Motors in MuJoCo: rotors, damping and dry friction in its joints, and the actuators of an MJCF file."""

from __future__ import annotations

from typing import Any

import numpy as np

from surefoot.base.arrays import FloatArray, IntArray
from surefoot.base.errors import ModelError
from surefoot.mechanics import Actuators, Robot

FRICTION_TIME = (0.004, 1.0)
"""Time constant [s] and damping ratio of MuJoCo's dry friction of joints: as stiff as its contacts."""
FRICTION_IMPEDANCE = (0.99, 0.99, 0.001, 0.5, 2.0)
"""Its impedance: MuJoCo's own default takes a hundredth of a radian off a leg's swing."""


def fit_actuators(spec: Any, robot: Robot, actuators: Actuators | None) -> None:
    """Give the joints of an MjSpec, see `robot_spec`, what `actuators` say; nothing for None.

    MuJoCo's dry friction is a constraint with its own softness: a joint that it holds creeps, for the Go2 by
    less than 0.01 rad/s.
    """
    if actuators is None:
        return
    for k, name in enumerate(robot.joint_names):
        joint = spec.joint(name)
        joint.armature = float(actuators.armature[k])
        joint.damping[0] = float(actuators.damping[k])
        joint.frictionloss = float(actuators.friction[k])
        joint.solref_friction, joint.solimp_friction = FRICTION_TIME, FRICTION_IMPEDANCE


class Drives:
    """Asks the actuators of a compiled model for torques.

    An actuator on a joint of gear G gives the torque G f there, with MuJoCo's f = g u + b0 + b1 l + b2 l̇ and
    its length l = G q. Torque motors (g = 1, b = 0) and servos of position or velocity (g = kp, b1 = -kp,
    b2 = -kv) are both of that kind: solved for u, they give the torque that is asked for, as far as their own
    limits on u and f allow. A joint without an actuator gets its torque as it is.

    Parameters
    ----------
    mujoco, model
        The module and the compiled model.
    joints
        (joints,) MuJoCo's numbers of the robot's joints.

    Raises
    ------
    ModelError
        For actuators with a memory, or of another law, and joints with several.
    """

    def __init__(self, mujoco: Any, model: Any, joints: IntArray) -> None:
        self._q = np.array(model.jnt_qposadr)[joints]
        self._v = np.array(model.jnt_dofadr)[joints]
        owner = np.full(len(joints), -1, dtype=np.int64)
        for k in range(model.nu):
            self._check(mujoco, model, k)
            at = np.flatnonzero(joints == int(model.actuator_trnid[k, 0]))
            if not at.size:
                continue
            if owner[at[0]] >= 0:
                raise ModelError(f"joint {model.joint(int(joints[at[0]])).name} has several actuators")
            owner[at[0]] = k
        self._joint = np.flatnonzero(owner >= 0)
        self._free = np.flatnonzero(owner < 0)
        self._actuator = owner[self._joint]
        self._gear = np.array(model.actuator_gear)[self._actuator, 0]
        self._gain = np.array(model.actuator_gainprm)[self._actuator, 0]
        affine = np.array(model.actuator_biastype)[self._actuator] == int(mujoco.mjtBias.mjBIAS_AFFINE)
        self._bias = np.where(affine[:, None], np.array(model.actuator_biasprm)[self._actuator, :3], 0.0)

    def _check(self, mujoco: Any, model: Any, k: int) -> None:
        """Refuse an actuator that is neither a motor nor a servo."""
        name = model.actuator(k).name or f"number {k}"
        biases = (int(mujoco.mjtBias.mjBIAS_NONE), int(mujoco.mjtBias.mjBIAS_AFFINE))
        if int(model.actuator_dyntype[k]) != int(mujoco.mjtDyn.mjDYN_NONE):
            raise ModelError(f"actuator {name} has a state of its own; motors and servos have none")
        fixed = int(model.actuator_gaintype[k]) == int(mujoco.mjtGain.mjGAIN_FIXED)
        if not fixed or int(model.actuator_biastype[k]) not in biases:
            raise ModelError(f"actuator {name} is neither a torque motor nor a servo")
        if model.actuator_gear[k, 0] == 0.0 or model.actuator_gainprm[k, 0] == 0.0:
            raise ModelError(f"actuator {name} does nothing: its gear or gain is zero")

    def ask(self, data: Any, torques: FloatArray) -> None:
        """Set the controls that give (joints,) torques [N m] at the state of the data."""
        length = self._gear * data.qpos[self._q[self._joint]]
        rate = self._gear * data.qvel[self._v[self._joint]]
        bias = self._bias[:, 0] + self._bias[:, 1] * length + self._bias[:, 2] * rate
        data.ctrl[self._actuator] = (torques[self._joint] / self._gear - bias) / self._gain
        data.qfrc_applied[self._v[self._free]] = torques[self._free]

    def given(self, data: Any) -> FloatArray:
        """Return the torques (joints,) that were given in the last step [N m]."""
        return np.asarray(data.qfrc_actuator[self._v] + data.qfrc_applied[self._v])
