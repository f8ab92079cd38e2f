"""Runs go2-convex-mpc for the bench, with the interpreter and the checkout of whoever has it.

What its own examples do each control step is done here with its classes and its settings: gait of 3 Hz with
duty 0.6, control at 200 Hz, a plan every sixteenth of a cycle, torques clipped to 90 % of the motors'. The
robot's model, the friction and the state are the bench's. Needs nothing of Surefoot.

References
----------
.. [1] https://github.com/elijah-waichong-chan/go2-convex-mpc
"""

from __future__ import annotations

import importlib
import sys
from pathlib import Path
from typing import Any

import numpy as np

GAIT_HZ, DUTY, CONTROL_DT, HEIGHT = 3.0, 0.6, 1.0 / 200.0, 0.27
PLANS, TORQUE_SHARE = 16, 0.9
LEGS = ("FL", "FR", "RL", "RR")


class Stack:
    """Its parts, joined as in its examples."""

    def __init__(self, setup: dict[str, Any]) -> None:
        data: Any = importlib.import_module("convex_mpc.go2_robot_data")
        mpc: Any = importlib.import_module("convex_mpc.centroidal_mpc")
        gait = importlib.import_module("convex_mpc.gait")
        data.URDF_PATH, data.PACKAGE_DIRS = Path(setup["urdf"]["file"]), Path(setup["urdf"]["packages"])
        mpc.MU = setup["mu"]
        mpc.OPTS["error_on_fail"] = False  # a plan that was not finished is used, as on a robot
        self.limits = TORQUE_SHARE * np.array(setup["effort_limits"])
        self.go2 = data.PinGo2Model()
        self.legs = importlib.import_module("convex_mpc.leg_controller").LegController()
        self.trajectory = importlib.import_module("convex_mpc.com_trajectory").ComTraj(self.go2)
        self.gait = gait.Gait(GAIT_HZ, DUTY)
        self.dt, self.period, self.joints = CONTROL_DT, self.gait.gait_period, self.go2.q_init[7:]
        self.plan_dt = self.gait.gait_period / PLANS
        self.every = max(1, int((1.0 / CONTROL_DT) // (1.0 / self.plan_dt)))
        self.plan(0.0, np.zeros(3))
        self.mpc = mpc.CentroidalMPC(self.go2, self.trajectory)
        self.forces = np.zeros(12)
        self.number = 0

    def plan(self, now: float, wanted: np.ndarray) -> None:
        """Make the reference of the next cycle."""
        forward, left, turn = (float(x) for x in wanted)
        self.trajectory.generate_traj(
            self.go2, self.gait, now, forward, left, HEIGHT, turn, time_step=self.plan_dt
        )

    def step(self, now: float, wanted: np.ndarray, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Return torques, planned forces and planned stance: (28,)."""
        self.go2.update_model(q, v)
        if self.number % self.every == 0:
            self.plan(now, wanted)
            steps = self.trajectory.N
            found = self.mpc.solve_QP(self.go2, self.trajectory, False)["x"].full().ravel()
            self.forces = found[12 * steps :].reshape((12, steps), order="F")[:, 0]
        self.number += 1
        torques = np.zeros(12)
        for k, leg in enumerate(LEGS):
            part = slice(3 * k, 3 * k + 3)
            torques[part] = self.legs.compute_leg_torque(leg, self.go2, self.gait, self.forces[part], now).tau
        stance = self.gait.compute_current_mask(now).ravel()
        return np.concatenate([np.clip(torques, -self.limits, self.limits), self.forces, stance])


if __name__ == "__main__":
    serve = importlib.import_module("serving").serve
    sys.path.insert(0, str(Path(sys.argv[1]) / "src" / "python"))
    serve(Stack)
