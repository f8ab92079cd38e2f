"""Momentum of the whole robot about its centre of mass, and what changes it.

With h = [linear; angular] momentum about the centre of mass in world axes::

    h = A_G v,        ḣ = A_G v̇ + Ȧ_G v = sum of contact wrenches + [m g; 0]

Joint torques are internal: they are not in ḣ. In the air h_angular is constant whatever the legs do;
what the legs can change is the orientation.

With Pinocchio's floating base (linear velocity in *base* axes) the base's linear block of A_G is m R, with
R the base's orientation; it is m 1 only for a base velocity in world axes. Total mass and centre of mass
count what moves; links bolted to the world do not.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from surefoot.base.arrays import FloatArray, finite_array
from surefoot.base.errors import ProblemError
from surefoot.base.spatial import GRAVITY, rotation_from_quaternion
from surefoot.mechanics.robot.robot import Robot
from surefoot.mechanics.stance import Stance

SLIDES = ("JointModelPX", "JointModelPY", "JointModelPZ")
HINGES = ("JointModelRX", "JointModelRY", "JointModelRZ")
"""Pinocchio's joints along and about the axes, in their order."""


@dataclass(frozen=True)
class Momentum:
    """Momentum of a robot about its centre of mass, world axes.

    Attributes
    ----------
    linear, angular
        (3,) [kg m/s] and (3,) [kg m^2/s].
    com
        (3,) centre of mass [m].
    inertia
        (3, 3) rotational inertia about the centre of mass, all joints locked [kg m^2].
    mass
        [kg].
    """

    linear: FloatArray
    angular: FloatArray
    com: FloatArray
    inertia: FloatArray
    mass: float

    @property
    def vector(self) -> FloatArray:
        """(6,) [linear; angular] [N s, N m s]."""
        return np.concatenate([self.linear, self.angular])

    @property
    def com_velocity(self) -> FloatArray:
        """(3,) velocity of the centre of mass [m/s]."""
        return self.linear / self.mass


def momentum_matrix(robot: Robot, q: ArrayLike) -> FloatArray:
    """Return A_G with h = A_G v: (6, nv) [kg, kg m for a rate in m/s]."""
    import pinocchio

    return np.array(pinocchio.computeCentroidalMap(robot.model, robot.data, robot.configuration(q)))


def centroidal_inertia(robot: Robot, q: ArrayLike) -> FloatArray:
    """Return the (6, 6) inertia of the robot with locked joints about its centre of mass, world axes.

    Block diagonal: m 1 and the rotational inertia [kg, kg m^2].
    """
    import pinocchio

    pinocchio.ccrba(robot.model, robot.data, robot.configuration(q), np.zeros(robot.model.nv))
    return np.array(robot.data.Ig.matrix())


def composite_inertia(robot: Robot, q: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return inertia and centre of mass of a robot whose joints are locked at (nq,) q, base axes.

    Returns
    -------
    (3, 3), (3,), (3, 3)
        Inertia about the centre of mass [kg m²], that centre from the base's origin [m], and the rotation
        rotation_world_base.
    """
    import pinocchio

    data = robot.data
    pinocchio.ccrba(robot.model, data, q, np.zeros(robot.model.nv))
    base = data.oMi[1]
    axes = np.array(base.rotation)
    return (
        axes.T @ np.array(data.Ig.inertia) @ axes,
        axes.T @ (np.array(data.com[0]) - base.translation),
        axes,
    )


def momentum(robot: Robot, q: ArrayLike, v: ArrayLike) -> Momentum:
    """Return the momentum at a configuration (nq,) and velocity (nv,) [m/s, rad/s]."""
    import pinocchio

    velocity = finite_array("v", v, (robot.model.nv,))
    pinocchio.ccrba(robot.model, robot.data, robot.configuration(q), velocity)
    data = robot.data
    return Momentum(
        np.array(data.hg.linear),
        np.array(data.hg.angular),
        np.array(data.com[0]),
        np.array(data.Ig.inertia),
        float(data.Ig.mass),
    )


def momentum_bias(robot: Robot, q: ArrayLike, v: ArrayLike) -> FloatArray:
    """Return Ȧ_G v, the part of ḣ that v̇ = 0 leaves: (6,) [N, N m]."""
    import pinocchio

    velocity = finite_array("v", v, (robot.model.nv,))
    rate = pinocchio.computeCentroidalMapTimeVariation(
        robot.model, robot.data, robot.configuration(q), velocity
    )
    return np.array(rate @ velocity)


def momentum_rate(robot: Robot, q: ArrayLike, v: ArrayLike, acceleration: ArrayLike) -> FloatArray:
    """Return ḣ = A_G v̇ + Ȧ_G v of a motion: (6,) [N, N m]."""
    change = finite_array("acceleration", acceleration, (robot.model.nv,))
    return np.asarray(momentum_matrix(robot, q) @ change + momentum_bias(robot, q, v))


def external_wrench(robot: Robot, q: ArrayLike, stance: Stance, forces: ArrayLike) -> FloatArray:
    """Return the wrench of contact forces and gravity about the centre of mass: (6,) [N, N m].

    Equal to `momentum_rate` of the motion they cause.

    Parameters
    ----------
    stance
        Where the contacts are, world axes.
    forces
        (stance.dim,) forces on the robot in contact axes.
    """
    f = finite_array("forces", forces, (stance.dim,))
    out = stance.grasp_map(about=robot.com(q)) @ f
    out[2] -= robot.mass * GRAVITY
    return np.asarray(out)


def base_velocity_for(
    robot: Robot, q: ArrayLike, joint_velocity: ArrayLike, wanted: ArrayLike | None = None
) -> FloatArray:
    """Return the base velocity that gives the robot a momentum while its joints move.

    Parameters
    ----------
    joint_velocity
        (joints,) [rad/s].
    wanted
        (6,) momentum [linear; angular]; None for zero, the falling cat's.

    Returns
    -------
    FloatArray
        (6,) base velocity in base axes.

    Raises
    ------
    ProblemError
        If the base is fixed.
    """
    if not robot.floating:
        raise ProblemError(f"{robot.name} has a fixed base: its joints alone set its momentum")
    A = momentum_matrix(robot, q)
    h = np.zeros(6) if wanted is None else finite_array("wanted", wanted, (6,))
    rates = finite_array("joint_velocity", joint_velocity, (robot.joints,))
    return np.asarray(np.linalg.solve(A[:, :6], h - A[:, 6:] @ rates))


def base_velocity_to_world_axes(robot: Robot, q: ArrayLike) -> FloatArray:
    """Return the (nv, nv) rotation T that takes v to one whose base velocity has world axes.

    A_G T⁻¹ then has the mass block m 1 (and lever block -m [c - p]x) of the textbooks.
    """
    configuration = robot.configuration(q)
    T = np.eye(robot.model.nv)
    if robot.floating:
        T[:3, :3] = T[3:6, 3:6] = rotation_from_quaternion(configuration[3:7])
    return T


def free_momentum_rows(model: Any) -> tuple[int, ...]:
    """Return the entries of [linear; angular] momentum that the first joints move freely, one each.

    Those of a free flyer: all six. Of slides along the world's axes that carry the whole robot: the linear
    ones, and where two slides without mass carry a hinge across them the angular one. None for a robot that
    is bolted to the world, or for several that share it.

    Parameters
    ----------
    model
        Pinocchio's Model.
    """
    if sum(parent == 0 for parent in list(model.parents)[1:]) != 1:
        return ()
    if model.joints[1].shortname() == "JointModelFreeFlyer":
        return tuple(range(6))
    out = list[int]()
    for joint in range(1, model.njoints):
        kind = str(model.joints[joint].shortname())
        alone = not any(i.mass for i in list(model.inertias)[:joint])
        aligned = alone and model.parents[joint] == joint - 1 and model.jointPlacements[joint].isIdentity()
        slide = aligned and kind in SLIDES
        if not slide:
            if aligned and len(out) == 2 and kind in HINGES and HINGES.index(kind) not in out:
                out.append(3 + HINGES.index(kind))
            break
        out.append(SLIDES.index(kind))
    return tuple(out)
