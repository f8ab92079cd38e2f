"""Dynamics of a robot in contact, and the Delassus operator G = J M⁻¹ Jᵀ.

With M v̇ + h = τ + Jᵀ f and the contacts' acceleration prescribed, J v̇ = γ, the motion and the forces
are the solution of one linear system::

    [ M   Jᵀ ] [  v̇ ]   [ τ - h ]
    [ J  -εI ] [ -f ] = [   γ   ]

Where rows of J depend on each other (two flat feet, four legs of a stiff body), ε = 0 gives the forces of
least norm, and the motion is exact as long as γ can be met. ε > 0 (damping) makes the system regular instead,
and is a compliance: J v̇ = γ - ε f, so that the motion misses γ by ε times the forces, and the forces go to
those of least norm as ε goes to zero; where γ cannot be met they grow like 1/ε.

References
----------
.. [1] R. Featherstone, Rigid Body Dynamics Algorithms, Springer 2008, chapter 8.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.linalg
from numpy.typing import ArrayLike

from surefoot.base.arrays import FloatArray, finite_array, real_number
from surefoot.base.errors import ModelError, ProblemError
from surefoot.mechanics.robot.jacobians import Contacts, attach_contacts, contact_drift, contact_jacobian
from surefoot.mechanics.robot.robot import Robot

LEAST_INERTIA = 1e-10
"""Least that a joint has to move [kg m²]: 1 mN m turns that by 10 krad/s within a step of 1 ms."""

RANK_TOLERANCE = 1e-10
"""Eigenvalues of G below this share of the largest count as zero."""


@dataclass(frozen=True)
class ConstrainedMotion:
    """What `constrained_dynamics` returns.

    Attributes
    ----------
    acceleration
        (nv,) v̇ in Pinocchio's coordinates [m/s^2, rad/s^2].
    forces
        (sum of dims,) contact forces on the robot, in contact axes [N, N m].
    rank
        Rank of the contact Jacobian.
    """

    acceleration: FloatArray
    forces: FloatArray
    rank: int


def mass_matrix(robot: Robot, q: ArrayLike) -> FloatArray:
    """Return the joint-space inertia M: (nv, nv), symmetric [kg, kg m, kg m^2]."""
    import pinocchio

    M = np.triu(pinocchio.crba(robot.model, robot.data, robot.configuration(q)))
    return np.asarray(M + np.triu(M, 1).T)


def joint_inertias(robot: Robot) -> FloatArray:
    """Return what a torque on each joint meets in the nominal pose, all else free: (joints,) [kg m², kg].

    Raises
    ------
    ModelError
        For a joint that moves next to nothing, which no step of any world can follow.
    """
    values, axes = np.linalg.eigh(mass_matrix(robot, robot.nominal))
    compliance = (axes**2 / np.maximum(values, 1e-300)).sum(axis=1)
    found = np.asarray(1.0 / compliance[robot.base_dof :])
    if found.min(initial=np.inf) < LEAST_INERTIA:
        joint = robot.joint_names[int(found.argmin())]
        raise ModelError(
            f"{robot.name} cannot be simulated: its joint {joint} moves less than {LEAST_INERTIA:g} kg m²; "
            "give the links behind it their masses"
        )
    return found


def bias_forces(robot: Robot, q: ArrayLike, v: ArrayLike) -> FloatArray:
    """Return h: Coriolis, centrifugal and gravity terms of M v̇ + h = τ: (nv,) [N, N m]."""
    import pinocchio

    velocity = finite_array("v", v, (robot.model.nv,))
    return np.array(pinocchio.nonLinearEffects(robot.model, robot.data, robot.configuration(q), velocity))


def generalised_torque(robot: Robot, torque: ArrayLike) -> FloatArray:
    """Return (nv,) generalised forces [N, N m] from (joints,) torques (a base has no motor) or (nv,) ones."""
    tau = finite_array("torque", torque)
    if tau.shape == (robot.joints,):
        return np.concatenate([np.zeros(robot.base_dof), tau])
    if tau.shape != (robot.model.nv,):
        raise ProblemError(
            f"torque must have shape ({robot.joints},) or ({robot.model.nv},), got {tau.shape}"
        )
    return tau


def constrained_dynamics(
    robot: Robot,
    q: ArrayLike,
    v: ArrayLike,
    torque: ArrayLike,
    contacts: Contacts,
    *,
    contact_acceleration: ArrayLike | None = None,
    damping: float = 0.0,
) -> ConstrainedMotion:
    """Return the motion of a robot whose contacts hold, and the forces that hold them.

    Parameters
    ----------
    robot, q, v
        Robot, (nq,) configuration and (nv,) velocity.
    torque
        (joints,) motor torques, or (nv,) generalised forces [N m].
    contacts
        A stance, or what `jacobians.attach` returned. Contacts hold both ways: they pull as well as push.
    contact_acceleration
        (sum of dims,) classical acceleration of the contacts in contact axes; None for zero. Stabilise
        with `Baumgarte.acceleration`.
    damping
        ε >= 0 of the system above [1/kg]; above zero the contacts' acceleration is missed by ε times the
        forces.

    Raises
    ------
    ProblemError
        For wrong shapes or a negative damping.
    """
    configuration = robot.configuration(q)
    points = attach_contacts(robot, configuration, contacts)
    epsilon = real_number("damping", damping, low=0.0)
    J = contact_jacobian(robot, configuration, points)
    wanted = -contact_drift(robot, configuration, v, points)
    if contact_acceleration is not None:
        wanted = wanted + finite_array("contact_acceleration", contact_acceleration, (J.shape[0],))
    effort = generalised_torque(robot, torque) - bias_forces(robot, configuration, v)
    factor = scipy.linalg.cho_factor(mass_matrix(robot, configuration))
    free = scipy.linalg.cho_solve(factor, effort)
    if not J.shape[0]:
        return ConstrainedMotion(free, np.zeros(0), 0)
    weighted = scipy.linalg.cho_solve(factor, J.T)
    values, vectors = np.linalg.eigh(J @ weighted)
    # G f = γ - J v̇_free by its eigenvectors: what repeats another contact has no direction of its own, and
    # least norm shares the force among them.
    keep = values > RANK_TOLERANCE * values[-1]
    use = keep if epsilon == 0.0 else np.ones_like(keep)
    V = vectors[:, use]
    forces = V @ ((V.T @ (wanted - J @ free)) / (values[use] + epsilon))
    return ConstrainedMotion(free + weighted @ forces, forces, int(keep.sum()))


def delassus_dense(robot: Robot, q: ArrayLike, contacts: Contacts) -> FloatArray:
    """Return G = J M⁻¹ Jᵀ from the dense mass matrix: (dims, dims) in contact axes [1/kg].

    The Cholesky factor L of M gives G = Yᵀ Y with L Y = Jᵀ, symmetric by construction.
    """
    J = contact_jacobian(robot, q, contacts)
    L = np.linalg.cholesky(mass_matrix(robot, q))
    Y = scipy.linalg.solve_triangular(L, J.T, lower=True)
    return np.asarray(Y.T @ Y)
