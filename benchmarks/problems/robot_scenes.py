"""Contact problems of real robot models: one time step with random joint torques and velocities."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.base.spatial import GRAVITY, skew
from surefoot.contact.problem import ContactProblem
from surefoot.mechanics.robot import Robot, load_robot

TIME_STEP = 2e-3
ROTOR = 0.01
"""Inertia of a rotor behind its gear, added to every joint [kg m²]; URDF files leave it out."""
SOLE = np.array([[0.1, 0.03, 0.0], [0.1, -0.03, 0.0], [-0.05, 0.03, 0.0], [-0.05, -0.03, 0.0]])


@lru_cache(maxsize=8)
def _robot(name: str) -> Robot:
    return load_robot(name)


def robot_delassus(
    rng: np.random.Generator,
    name: str,
    feet_down: int,
    points: int,
    push: float,
    mu: float,
    lift: float = 0.0,
    gain: float = 0.0,
) -> ContactProblem:
    """Return one time step of a robot near its nominal pose.

    Parameters
    ----------
    rng
        Random pose, velocity and torques come from it.
    name
        A robot of `surefoot.mechanics.robot.robot_names`.
    feet_down
        How many feet touch, the first and the last ones in turn (diagonal for two of four).
    points
        Contacts of each foot: 1 in its middle, or up to 4 at the corners of a sole.
    push, lift
        Horizontal and upward speed of the base [m/s].
    mu
        Friction coefficient.
    gain
        Damping of the joints' position control, taken implicitly [N m s / rad]: it adds to their inertia
        what a simulator's implicit step adds.
    """
    import pinocchio

    robot = _robot(name)
    model, data = robot.model, robot.model.createData()
    q = pinocchio.integrate(model, robot.nominal, np.r_[np.zeros(6), 0.05 * rng.normal(size=robot.joints)])
    heading = rng.uniform(0.0, 2.0 * np.pi)
    v = np.r_[
        push * np.cos(heading), push * np.sin(heading), lift, push * rng.normal(size=3),
        (push + 0.02) * rng.normal(size=robot.joints),
    ]  # fmt: skip
    v[2] *= rng.random()
    torque = np.r_[np.zeros(6), 0.15 * robot.mass * GRAVITY / len(robot.feet) * rng.normal(size=robot.joints)]
    torque[6:] += pinocchio.rnea(model, data, q, np.zeros(model.nv), np.zeros(model.nv))[6:]
    pinocchio.computeJointJacobians(model, data, q)
    pinocchio.updateFramePlacements(model, data)
    which = [0, len(robot.feet) - 1, *range(1, len(robot.feet) - 1)][:feet_down]
    blocks = []
    for i in sorted(which):
        foot = robot.feet[i]
        J = pinocchio.getFrameJacobian(model, data, foot.frame, pinocchio.LOCAL_WORLD_ALIGNED)
        middle = data.oMf[foot.frame].act(foot.centre) - [0.0, 0.0, foot.radius]
        for corner in SOLE[:points] if points > 1 else np.zeros((1, 3)):
            arm = middle + corner - data.oMf[foot.frame].translation
            blocks.append(J[:3] - skew(arm) @ J[3:])
    J = np.vstack(blocks)
    M = pinocchio.crba(model, data, q)
    M = np.triu(M) + np.triu(M, 1).T
    M[np.diag_indices(model.nv)] += np.r_[np.zeros(6), np.full(robot.joints, ROTOR + TIME_STEP * gain)]
    bias = pinocchio.rnea(model, data, q, v, np.zeros(model.nv))
    G = J @ np.linalg.solve(M, J.T)
    g: FloatArray = J @ (v + TIME_STEP * np.linalg.solve(M, torque - bias))
    return ContactProblem(0.5 * (G + G.T), g, mu)
