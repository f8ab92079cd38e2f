"""The derivative of constrained dynamics against differences of it, and against Pinocchio's."""

from __future__ import annotations

import numpy as np
import pinocchio
import pytest

import surefoot as sf
from surefoot.robot.dynamics import constrained_dynamics, rigid_constraint
from surefoot.robot.dynamics_derivative import constrained_dynamics_derivative
from surefoot.robot.jacobians import attach

STEP, NEAR = 1e-5, 1e-6
"""Accelerations of 1e3 are rounded to 1e-13: differences over 1e-5 tell them to some 1e-7 of themselves."""


def moving(name: str, seed: int):
    robot, rng = sf.load_robot(name), np.random.default_rng(seed)
    turn = np.concatenate([np.zeros(3), 0.05 * rng.normal(size=robot.model.nv - 3)])
    q = pinocchio.integrate(robot.model, sf.place(robot), turn)
    points = attach(robot, q, robot.stance(sf.place(robot), mu=0.6))
    return robot, q, rng.normal(size=robot.model.nv), 5.0 * rng.normal(size=robot.joints), points


@pytest.mark.parametrize(("name", "contacts"), [("go2", 4), ("go2", 2), ("g1", 1), ("go2", 0)])
def test_blocks_are_those_of_differences(name: str, contacts: int) -> None:
    """Feet that move and turn: classical accelerations, and forces in axes that do not turn."""
    robot, q, v, torque, points = moving(name, 1)
    points, nv, free = points[:contacts], robot.model.nv, np.zeros(robot.base_dof)
    tau = np.concatenate([free, torque])
    d = constrained_dynamics_derivative(robot, q, v, torque, points)

    def at(place: np.ndarray, speed: np.ndarray, effort: np.ndarray) -> np.ndarray:
        motion = constrained_dynamics(robot, place, speed, effort, points)
        return np.concatenate([motion.acceleration, motion.forces])

    def slope(which: int, e: np.ndarray) -> np.ndarray:
        ends = [
            at(
                pinocchio.integrate(robot.model, q, w * e) if which == 0 else q,
                v + w * e if which == 1 else v,
                tau + w * e if which == 2 else tau,
            )
            for w in (-STEP, STEP, -2.0 * STEP, 2.0 * STEP)
        ]
        return (8.0 * (ends[1] - ends[0]) - (ends[3] - ends[2])) / (12.0 * STEP)

    own = (
        (d.acceleration_q, d.forces_q),
        (d.acceleration_v, d.forces_v),
        (d.acceleration_torque, d.forces_torque),
    )
    for which in range(3):
        wanted = np.array([slope(which, e) for e in np.eye(nv)]).T
        for block, rows in zip(own[which], (wanted[:nv], wanted[nv:]), strict=True):
            assert np.abs(block - rows).max(initial=0.0) < NEAR * max(np.abs(rows).max(initial=0.0), 1.0)


def test_point_feet_are_pinocchios() -> None:
    robot, q, v, torque, points = moving("go2", 2)
    data = robot.model.createData()
    pinocchio.framesForwardKinematics(robot.model, data, q)
    models, datas = pinocchio.StdVec_RigidConstraintModel(), pinocchio.StdVec_RigidConstraintData()
    for point in points:
        models.append(rigid_constraint(robot, data, point))
        datas.append(models[-1].createData())
    pinocchio.initConstraintDynamics(robot.model, data, models, datas)
    settings = pinocchio.ProximalSettings(1e-13, 0.0, 1)
    tau = np.concatenate([np.zeros(6), torque])
    pinocchio.constraintDynamics(robot.model, data, q, v, tau, models, datas, settings)
    pinocchio.computeConstraintDynamicsDerivatives(robot.model, data, models, datas, settings)
    d = constrained_dynamics_derivative(robot, q, v, torque, points)
    for own, theirs in (
        (d.acceleration_q, data.ddq_dq),
        (d.acceleration_v, data.ddq_dv),
        (d.acceleration_torque, data.ddq_dtau),
    ):
        assert np.abs(own - theirs).max() < 1e-9 * np.abs(theirs).max()
