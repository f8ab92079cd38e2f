"""The centroidal momentum matrix written out: the composite-rigid-body algorithm, and a plain sum over links.

Reference implementations to read and to check Pinocchio against; `centroidal.py` is what to use.
Everything here is in world axes and in the order [linear; angular]. With the spatial inertia of link i
about the world's origin ::

    I_i = [ m 1        -m [c]x                ]
          [ m [c]x     R J R' - m [c]x [c]x   ]

a link's momentum about the origin is I_i V_i, and its twist V_i is the sum of S_j v_j over the joints j
that carry it. The matrix A with h = A v therefore has, for joint j, the columns ::

    A_j = sum over links i carried by j of I_i S_j = Ic_j S_j,

Ic_j the *composite* inertia of everything beyond joint j. One sweep from the tips to the root collects
the composites, so that the whole matrix costs O(n) [1]_; summing link by link costs O(n * depth).

References
----------
.. [1] D. E. Orin, A. Goswami, S.-H. Lee, "Centroidal dynamics of a humanoid robot", Autonomous Robots 35,
   2013.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from surefoot.arrays import FloatArray
from surefoot.robot.contact_points import joint_support
from surefoot.spatial import skew, twist_transform, wrench_transform


def link_inertia(mass: float, centre: FloatArray, rotation: FloatArray, inertia: FloatArray) -> FloatArray:
    """Return the spatial inertia about the world's origin: (6, 6).

    Parameters
    ----------
    mass
        [kg].
    centre
        (3,) centre of mass in the world [m].
    rotation
        (3, 3) rotation_world_link.
    inertia
        (3, 3) about the centre of mass, in link axes [kg m^2].
    """
    c = mass * skew(centre)
    turned = rotation @ inertia @ rotation.T
    return np.block([[mass * np.eye(3), -c], [c, turned - c @ skew(centre)]])


def joint_columns(model: Any, q: FloatArray) -> tuple[list[Any], FloatArray]:
    """Return the joints' placements in the world and motion subspaces S: (6, nv) [m, -], world axes.

    Forward kinematics from the root; only a joint's own transform and subspace are Pinocchio's.
    """
    placements = [model.jointPlacements[0]]
    S = np.zeros((6, model.nv))
    for i in range(1, model.njoints):
        joint = model.joints[i]
        own = joint.createData()
        joint.calc(own, q)
        placements.append(placements[model.parents[i]] * model.jointPlacements[i] * own.M)
        columns = slice(joint.idx_v, joint.idx_v + joint.nv)
        pose = placements[i]
        S[:, columns] = twist_transform(pose.rotation, pose.translation) @ np.array(own.S).reshape(
            6, joint.nv
        )
    return placements, S


def composite_momentum_matrix(model: Any, q: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return A_G (6, nv), I_G and the centre of mass [m] by the composite-rigid-body algorithm.

    Returns
    -------
    tuple
        (6, nv) momentum matrix about the centre of mass, (6, 6) centroidal inertia, (3,) centre of mass.
    """
    placements, S = joint_columns(model, q)
    composite = [np.zeros((6, 6))]  # what is bolted to the world does not move
    composite += [
        link_inertia(b.mass, pose.act(b.lever), pose.rotation, b.inertia)
        for b, pose in zip(list(model.inertias)[1:], placements[1:], strict=True)
    ]
    momentum = np.zeros_like(S)
    for i in range(model.njoints - 1, 0, -1):  # children come after their parents in the model
        joint = model.joints[i]
        columns = slice(joint.idx_v, joint.idx_v + joint.nv)
        momentum[:, columns] = composite[i] @ S[:, columns]
        composite[model.parents[i]] = composite[model.parents[i]] + composite[i]
    return _about_com(momentum, composite[0])


def _about_com(momentum: FloatArray, total: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Move momentum matrix and total inertia from the world's origin to the centre of mass."""
    mass, first = total[0, 0], total[3:, :3]
    com = np.array([first[2, 1], first[0, 2], first[1, 0]]) / mass
    shift = wrench_transform(np.eye(3), -com)  # a momentum moves like a wrench
    return shift @ momentum, shift @ total @ shift.T, com


def summed_momentum_matrix(model: Any, q: FloatArray) -> FloatArray:
    """Return A_G link by link: the sum of I_i J_i, J_i the dense Jacobian of link i: (6, nv) [kg, kg m].

    The third opinion, and what the composites save: each link multiplies a Jacobian as wide as the
    robot.
    """
    placements, S = joint_columns(model, q)
    bodies = list(zip(model.inertias, placements, strict=True))[1:]
    com = sum(body.mass * pose.act(body.lever) for body, pose in bodies) / sum(b.mass for b, _ in bodies)
    momentum = np.zeros((6, model.nv))
    carried = joint_support(model)
    for j, (body, pose) in enumerate(bodies, 1):
        jacobian = np.where(carried[j], S, 0.0)
        centre = pose.act(body.lever)
        linear = body.mass * (jacobian[:3] - skew(centre) @ jacobian[3:])
        spin = pose.rotation @ body.inertia @ pose.rotation.T @ jacobian[3:]
        momentum[:3] += linear
        momentum[3:] += spin + skew(centre - com) @ linear
    return momentum
