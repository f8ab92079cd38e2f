"""Runs Quadruped-PyMPC for the bench, with the interpreter and the checkout of whoever has it.

What its own simulation does each step is done here with its classes and its settings: control at 500 Hz, MPC
at 100 Hz, torques clipped to 90 % of the motors'. Its gradient MPC is taken where acados is installed, else
its sampling MPC on the CPU. Its environment (gym-quadruped) serves as its model alone: the state is the
bench's, and so are mass and friction. Needs nothing of Surefoot.

References
----------
.. [1] https://github.com/iit-DLSLab/Quadruped-PyMPC
"""

from __future__ import annotations

import importlib
import importlib.util
import sys
from typing import Any

import numpy as np

LEGS = ("FL", "FR", "RL", "RR")
TORQUE_SHARE = 0.9


def configured(told: dict[str, Any]) -> Any:
    """Return its configuration with the bench's mass and friction, before anything else reads it."""
    config: Any = importlib.import_module("quadruped_pympc.config")
    config.mass = told["mass"]
    config.mpc_params["grf_max"] = told["mass"] * config.gravity_constant
    config.mpc_params["mu"] = told["mu"]
    if importlib.util.find_spec("acados_template") is None:
        config.mpc_params["type"], config.mpc_params["device"] = "sampling", "cpu"
    return config


class Stack:
    """Its wrapper, fed as by its simulation."""

    def __init__(self, told: dict[str, Any]) -> None:
        self.config = configured(told)
        self.mujoco = importlib.import_module("mujoco")
        make = importlib.import_module("gym_quadruped.quadruped_env").QuadrupedEnv
        self.attributes = importlib.import_module("gym_quadruped.utils.quadruped_utils").LegsAttr
        self.dt = self.config.simulation_params["dt"]
        self.env = make(
            robot=self.config.robot, scene="flat", sim_dt=self.dt, base_vel_command_type="human",
            state_obs_names=(),
        )  # fmt: skip
        self._weigh(told["mass"])
        self.env.reset(random=False)
        self.joints = np.concatenate([self.env.mjData.qpos[self.env.legs_qpos_idx[leg]] for leg in LEGS])
        wrapper = importlib.import_module("quadruped_pympc.quadruped_pympc_wrapper").QuadrupedPyMPC_Wrapper
        self.wrapper = wrapper(
            initial_feet_pos=self.env.feet_pos, legs_order=LEGS, feet_geom_id=self.env._feet_geom_id
        )
        self.limits = TORQUE_SHARE * np.array(told["effort_limits"])
        self.torques = self.attributes(*[np.zeros((self.env.mjModel.nv, 1)) for _ in LEGS])
        gait = self.config.simulation_params["gait_params"][self.config.simulation_params["gait"]]
        self.period = 1.0 / gait["step_freq"]
        self.number = 0

    def _weigh(self, mass: float) -> None:
        """Give the links of its model the robot's mass."""
        model = self.env.mjModel
        share = mass / model.body_mass.sum()
        model.body_mass *= share
        model.body_inertia *= share
        self.mujoco.mj_setConst(model, self.env.mjData)

    def _show(self, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Put its model into a state (Pinocchio's order) and return the base's rotation."""
        env, data = self.env, self.env.mjData
        x, y, z, w = q[3:7]
        data.qpos[:3], data.qpos[3:7] = q[:3], (w, x, y, z)
        rows = np.zeros(9)
        self.mujoco.mju_quat2Mat(rows, data.qpos[3:7])
        rotation = rows.reshape(3, 3)
        data.qvel[:3], data.qvel[3:6] = rotation @ v[:3], v[3:6]
        for k, leg in enumerate(LEGS):
            data.qpos[env.legs_qpos_idx[leg]] = q[7 + 3 * k : 10 + 3 * k]
            data.qvel[env.legs_qvel_idx[leg]] = v[6 + 3 * k : 9 + 3 * k]
        self.mujoco.mj_forward(env.mjModel, data)
        return rotation

    def step(self, now: float, wanted: np.ndarray, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Return torques, planned forces and planned stance: (28,)."""
        env, rotation = self.env, self._show(q, v)
        yaw = np.arctan2(rotation[1, 0], rotation[0, 0])
        c, s = np.cos(yaw), np.sin(yaw)
        velocity = np.array([c * wanted[0] - s * wanted[1], s * wanted[0] + c * wanted[1], 0.0])
        columns, rows = env.legs_qvel_idx, env.legs_qpos_idx
        self.torques = self.wrapper.compute_actions(
            np.array(env.com), np.array(env.base_pos), env.base_lin_vel(frame="world"),
            env.base_ori_euler_xyz, env.base_ang_vel(frame="base"), env.feet_pos(frame="world"),
            env.hip_positions(frame="world"), self.attributes(*[columns[leg] for leg in LEGS]), None, LEGS,
            self.dt, velocity, np.array([0.0, 0.0, wanted[2]]), self.number, env.mjData.qpos, env.mjData.qvel,
            env.feet_jacobians(frame="world", return_rot_jac=False),
            env.feet_jacobians_dot(frame="world", return_rot_jac=False), env.feet_vel(frame="world"),
            env.legs_qfrc_passive, env.legs_qfrc_bias, env.legs_mass_matrix, rows, columns, self.torques,
            env.get_base_inertia().flatten(), env.mjData.contact,
        )  # fmt: skip
        self.number += 1
        torques = np.concatenate([np.asarray(self.torques[leg]).ravel()[:3] for leg in LEGS])
        forces = np.concatenate([np.asarray(self.wrapper.nmpc_GRFs[leg]).ravel() for leg in LEGS])
        stance = np.asarray(self.wrapper.wb_interface.current_contact, dtype=np.float64)
        return np.concatenate([np.clip(torques, -self.limits, self.limits), forces, stance])


if __name__ == "__main__":
    serve = importlib.import_module("serving").serve
    sys.path.insert(0, sys.argv[1])
    serve(Stack)
