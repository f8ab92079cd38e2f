"""The derivative of a robot's motion on contacts that hold, and of the forces that hold them.

Of M v̇ + h = τ + Jᵀ f and J v̇ + J̇ v = 0 (`dynamics.constrained_dynamics`), in axes of the bodies that touch::

    M δv̇ - Jᵀ δf = δτ - ∂ID/∂q δq - ∂ID/∂v δv
    J δv̇         =    - ∂c/∂q δq - ∂c/∂v δv

with inverse dynamics ID under the forces f, and c the classical accelerations of the contacts (Pinocchio's
derivatives). Forces are returned in contact axes, which do not turn with the bodies.

Source: J. Carpentier, N. Mansard, "Analytical derivatives of rigid body dynamics algorithms", RSS 2018.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.linalg
from numpy.typing import ArrayLike

from surefoot.arrays import FloatArray, finite_array
from surefoot.robot.dynamics import (
    RANK_TOLERANCE,
    ConstrainedMotion,
    constrained_dynamics,
    generalised_torque,
    mass_matrix,
    placement_of,
)
from surefoot.robot.jacobians import Contacts, attached, contact_jacobian
from surefoot.robot.robot import Robot
from surefoot.spatial import skew


@dataclass(frozen=True)
class ConstrainedDerivative:
    """What `constrained_dynamics_derivative` returns; q moves in its tangent space.

    Attributes
    ----------
    motion
        The motion and the forces themselves.
    acceleration_q, acceleration_v, acceleration_torque
        (nv, nv) of the acceleration by q, v and generalised forces; those of motors are the last columns.
    forces_q, forces_v, forces_torque
        (sum of dims, nv) of the forces, likewise.
    """

    motion: ConstrainedMotion
    acceleration_q: FloatArray
    acceleration_v: FloatArray
    acceleration_torque: FloatArray
    forces_q: FloatArray
    forces_v: FloatArray
    forces_torque: FloatArray


def constrained_dynamics_derivative(
    robot: Robot, q: ArrayLike, v: ArrayLike, torque: ArrayLike, contacts: Contacts
) -> ConstrainedDerivative:
    """Return the derivative of `constrained_dynamics`: contacts that hold, both ways, without acceleration.

    A contact is a point of its body. Where contacts are redundant the motion's derivative is exact and the
    forces' is one of those that make it, of least norm.

    Parameters
    ----------
    robot, q, v, torque, contacts
        As for `constrained_dynamics`.

    Raises
    ------
    ProblemError
        For wrong shapes.
    """
    import pinocchio

    configuration = robot.configuration(q)
    points = attached(robot, configuration, contacts)
    motion = constrained_dynamics(robot, configuration, v, torque, points)
    speed, a = finite_array("v", v, (robot.model.nv,)), motion.acceleration
    generalised_torque(robot, torque)
    model, data, nv = robot.model, robot.data, robot.model.nv
    pinocchio.framesForwardKinematics(model, data, configuration)
    placed = [placement_of(model, data, point) for point in points]
    # forces on the bodies, in the joints' axes
    on_bodies = pinocchio.StdVec_Force()
    for _ in range(model.njoints):
        on_bodies.append(pinocchio.Force.Zero())
    start = 0
    for point, (joint, placement) in zip(points, placed, strict=True):
        wrench = np.zeros(6)
        wrench[: point.dim] = motion.forces[start : start + point.dim]
        on_bodies[joint] += placement.act(pinocchio.Force(wrench))
        start += point.dim
    pinocchio.computeRNEADerivatives(model, data, configuration, speed, a, on_bodies)
    right = np.hstack([-data.dtau_dq, -data.dtau_dv, np.eye(nv)])
    # accelerations and turns of the contacts
    pinocchio.computeForwardKinematicsDerivatives(model, data, configuration, speed, a)
    drift, turned = np.zeros((start, 3 * nv)), np.zeros((start, 3 * nv))
    start = 0
    for point, (joint, placement) in zip(points, placed, strict=True):
        rows = slice(start, start + point.dim)
        drift[rows, : 2 * nv] = _acceleration(model, data, joint, placement, point.dim)
        angular = placement.rotation.T @ _angular(model, data, joint)
        for first in range(0, point.dim, 3):
            three = slice(start + first, start + first + 3)
            turned[three, :nv] = -skew(motion.forces[three]) @ angular
        start += point.dim
    J = contact_jacobian(robot, configuration, points)
    factor = scipy.linalg.cho_factor(mass_matrix(robot, configuration))
    free, forces = scipy.linalg.cho_solve(factor, right), np.zeros((start, 3 * nv))
    if start:
        weighted = scipy.linalg.cho_solve(factor, J.T)
        values, vectors = np.linalg.eigh(J @ weighted)
        V = vectors[:, values > RANK_TOLERANCE * values[-1]]
        size = values[values > RANK_TOLERANCE * values[-1]]
        forces = -V @ ((V.T @ (drift + J @ free)) / size[:, None])
        free = free + weighted @ forces
    return ConstrainedDerivative(motion, *np.split(free, 3, axis=1), *np.split(forces + turned, 3, axis=1))


def _acceleration(model: Any, data: Any, joint: int, placement: Any, dim: int) -> FloatArray:
    """Return (dim, 2nv) the derivatives of a contact's acceleration by q and v, in its own axes."""
    import pinocchio

    local = pinocchio.ReferenceFrame.LOCAL
    _, by_q, by_v, _ = pinocchio.getPointClassicAccelerationDerivatives(model, data, joint, placement, local)
    out = np.hstack([by_q, by_v])
    if dim == 6:
        _, by_q, by_v, _ = pinocchio.getJointAccelerationDerivatives(model, data, joint, local)
        out = np.vstack([out, placement.rotation.T @ np.hstack([by_q, by_v])[3:]])
    return np.asarray(out)


def _angular(model: Any, data: Any, joint: int) -> FloatArray:
    """Return (3, nv) the angular velocity of a joint's body, in the joint's axes."""
    import pinocchio

    return np.asarray(pinocchio.getJointJacobian(model, data, joint, pinocchio.ReferenceFrame.LOCAL)[3:])
