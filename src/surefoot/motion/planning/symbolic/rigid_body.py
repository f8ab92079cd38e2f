"""Rigid-body dynamics as CasADi expressions: what Pinocchio computes in numbers, for an optimiser.

Reads joints, placements and inertias of a Pinocchio model and writes out the recursive Newton-Euler algorithm
(Featherstone, Rigid Body Dynamics Algorithms, 2008, section 5.3) in body axes, with forces at contact points,
the points' motion, and q ⊕ step as Pinocchio integrates. Configurations and velocities are in Pinocchio's
order.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.base.errors import ModelError
from surefoot.base.libraries import import_casadi
from surefoot.base.spatial import skew
from surefoot.mechanics import ContactPoints
from surefoot.motion.planning.symbolic.rotations import even_series, turn_matrix

Expression = Any
"""A CasADi SX matrix."""
TINY = 1e-15
"""Entries of placements below this are zero: they would only make expressions longer."""
HINGES = ("JointModelRX", "JointModelRY", "JointModelRZ", "JointModelRevoluteUnaligned")
SLIDES = ("JointModelPX", "JointModelPY", "JointModelPZ", "JointModelPrismaticUnaligned")
FREE = "JointModelFreeFlyer"


@dataclass(frozen=True)
class _Joint:
    """A joint in numbers: its kind, where its entries begin, what it moves and how it is placed."""

    kind: str
    q: int
    v: int
    nv: int
    parent: int
    rotation: FloatArray
    translation: FloatArray
    axes: FloatArray  # (6, nv) motion subspace, linear first, in the joint's own axes
    mass: float
    lever: FloatArray
    inertia: FloatArray  # (3, 3) about the body's centre of mass


@dataclass(frozen=True)
class _Pose:
    """Where a body is: to its parent, and in the world."""

    rotation: Expression
    translation: Expression
    rotation_world: Expression
    translation_world: Expression


class SymbolicBody:
    """A robot's dynamics as CasADi SX expressions of its configuration and velocity.

    Parameters
    ----------
    model
        Pinocchio's Model, of revolute, prismatic and free-flyer joints.
    points
        Contact points that forces may act on.

    Attributes
    ----------
    nq, nv, points
        Sizes of the model, and how many contact points there are.

    Raises
    ------
    MissingExtra
        If CasADi is not installed.
    ModelError
        For a joint of another kind.

    Examples
    --------
    >>> from surefoot.mechanics.robot import load_robot
    >>> robot = load_robot("go2")
    >>> body = SymbolicBody(robot.model, robot.contact_points)
    >>> import casadi
    >>> q, v, a = casadi.SX.sym("q", 19), casadi.SX.sym("v", 18), casadi.SX.sym("a", 18)
    >>> casadi.Function("id", [q, v, a], [body.inverse_dynamics(q, v, a)]).size_out(0)
    (18, 1)
    """

    def __init__(self, model: Any, points: ContactPoints) -> None:
        self._ca = import_casadi()
        self.nq, self.nv, self.points = int(model.nq), int(model.nv), len(points)
        self._gravity = np.array(model.gravity.linear)
        data = model.createData()
        self._joints = [_read_joint(model, data, k) for k in range(1, model.njoints)]
        self._carriers = [int(j) for j in points.joints]
        self._places, self._radii = points.places, points.radii

    def inverse_dynamics(
        self, q: Expression, v: Expression, a: Expression, forces: Expression = None, normal: Any = (0, 0, 1)
    ) -> Expression:
        """Return the generalised forces (nv,) that cause an acceleration.

        Parameters
        ----------
        q, v, a
            (nq,), (nv,), (nv,).
        forces
            (3, p) of the ground on the contact points [N], world axes; None for none.
        normal
            (3,) of the ground: a sphere is touched at its lowest point along it.
        """
        ca, poses = self._ca, self._poses(q)
        # Outwards: what each body needs. Less what the ground gives. Inwards: a joint's row is its part of
        # all forces beyond it, which are handed to the parent.
        bodies = self._body_forces(poses, v, a)
        for k, j in enumerate(self._carriers if forces is not None else ()):  # what the ground does
            pose, (force, moment) = poses[j - 1], bodies[j - 1]
            own = ca.mtimes(pose.rotation_world.T, forces[:, k])
            bodies[j - 1] = force - own, moment - ca.cross(self._arm(pose, k, normal), own)
        effort = ca.SX.zeros(self.nv)
        for k in reversed(range(len(self._joints))):
            joint, pose = self._joints[k], poses[k]
            force, moment = bodies[k]
            both = ca.vertcat(force, moment)
            effort[joint.v : joint.v + joint.nv] = ca.mtimes(self._constant(joint.axes.T), both)
            if joint.parent:
                above, about = bodies[joint.parent - 1]
                turned = ca.mtimes(pose.rotation, force)
                about = about + ca.mtimes(pose.rotation, moment) + ca.cross(pose.translation, turned)
                bodies[joint.parent - 1] = above + turned, about
        return effort

    def sphere_centres(self, q: Expression) -> Expression:
        """Return the contact spheres' centres (3, p) in world axes [m]."""
        return self.body_points(q, self._carriers, self._places)

    def body_points(self, q: Expression, joints: Any, places: FloatArray) -> Expression:
        """Return points of bodies (3, m) in world axes [m].

        Parameters
        ----------
        q
            (nq,).
        joints
            (m,) Pinocchio's indices of the joints that carry the bodies.
        places
            (m, 3) in the joints' axes [m].
        """
        poses = self._poses(q)
        return self._ca.horzcat(
            *(
                poses[int(j) - 1].translation_world
                + self._ca.mtimes(poses[int(j) - 1].rotation_world, self._constant(place))
                for j, place in zip(joints, places, strict=True)
            )
        )

    def point_velocities(self, q: Expression, v: Expression, normal: Any = (0, 0, 1)) -> Expression:
        """Return the velocities (3, p) of the spheres' points nearest to the ground, world axes [m/s]."""
        poses = self._poses(q)
        spins, speeds = self._twists(poses, v)
        columns = []
        for k, j in enumerate(self._carriers):
            arm = self._arm(poses[j - 1], k, normal)
            own = speeds[j - 1] + self._ca.cross(spins[j - 1], arm)
            columns.append(self._ca.mtimes(poses[j - 1].rotation_world, own))
        return self._ca.horzcat(*columns)

    def momentum(self, q: Expression, v: Expression) -> tuple[Expression, Expression, Expression]:
        """Return the centre of mass [m], and linear and angular momentum about it [N s, N m s]: (3, 1) each.

        World axes; `at_origin` those of the base.
        """
        ca, poses = self._ca, self._poses(q)
        own = list[tuple[float, Expression, Expression, Expression]]()
        for joint, pose, spin, speed in zip(self._joints, poses, *self._twists(poses, v), strict=True):
            lever, turn = self._constant(joint.lever), pose.rotation_world
            place = pose.translation_world + ca.mtimes(turn, lever)
            push = joint.mass * ca.mtimes(turn, speed + ca.cross(spin, lever))
            whirl = ca.mtimes(turn, ca.mtimes(self._constant(joint.inertia), spin))
            own.append((joint.mass, place, push, whirl))
        com = sum(mass * place for mass, place, _, _ in own) / sum(mass for mass, *_ in own)
        angular = sum(whirl + ca.cross(place - com, push) for _, place, push, whirl in own)
        return com, sum(push for _, _, push, _ in own), angular

    def at_origin(self, q: Expression) -> Expression:
        """Return (nq,) q with the base at the world's origin, that of a free flyer upright."""
        ca, first = self._ca, self._joints[0]
        fixed = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0] if first.kind == FREE else []
        while (
            len(fixed) < len(self._joints) and self._joints[len(fixed)].kind in SLIDES[:3] and not fixed[6:]
        ):
            fixed.append(0.0)
        return ca.vertcat(ca.DM(fixed), q[len(fixed) :])

    def base_turn(self, q: Expression) -> Expression:
        """Return rotation_world_base (3, 3) of a free flyer; the world's axes for others."""
        return turn_matrix(q[3:7]) if self._joints[0].kind == FREE else self._ca.DM.eye(3)

    def integrate(self, q: Expression, step: Expression) -> Expression:
        """Return the configuration (nq,) that lies a (nv,) step from q, as `pinocchio.integrate`.

        Rotations by power series, which have no branch at rest: for less than half a turn a step.
        """
        ca, out = self._ca, []
        for joint in self._joints:
            way = step[joint.v : joint.v + joint.nv]
            if joint.kind == FREE:
                out.append(self._moved_free(q[joint.q : joint.q + 7], way))
            else:
                out.append(q[joint.q] + way)
        return ca.vertcat(*out)

    def _moved_free(self, q: Expression, way: Expression) -> Expression:
        """Return a free flyer's pose after a twist: the exponential of SE(3), then that of quaternions."""
        ca, (linear, angular) = self._ca, (way[:3], way[3:])
        square = ca.dot(angular, angular)
        arc, swing = even_series(square, 2), even_series(square, 3)  # (1 - cos t) / t², (t - sin t) / t³
        once = ca.cross(angular, linear)
        shift = linear + arc * once + swing * ca.cross(angular, once)
        place = q[:3] + ca.mtimes(turn_matrix(q[3:]), shift)
        half = 0.5 * angular
        sine, cosine = even_series(0.25 * square, 1), even_series(0.25 * square, 0)
        x, w = q[3:6], q[6]
        turned = w * sine * half + cosine * x + sine * ca.cross(x, half)
        return ca.vertcat(place, turned, w * cosine - sine * ca.dot(x, half))

    def _constant(self, value: FloatArray) -> Expression:
        """Return an array as a sparse constant."""
        return self._ca.sparsify(self._ca.DM(np.where(np.abs(value) < TINY, 0.0, value)))

    def _own_motion(self, joint: _Joint, q: Expression) -> tuple[Expression, Expression]:
        """Return rotation and translation of a joint by its entries of q."""
        ca = self._ca
        if joint.kind == FREE:
            return turn_matrix(q[joint.q + 3 : joint.q + 7]), q[joint.q : joint.q + 3]
        if joint.kind in SLIDES:
            return ca.DM.eye(3), self._constant(joint.axes[:3, 0]) * q[joint.q]
        angle = q[joint.q]
        axis = joint.axes[3:, 0]
        across = np.outer(axis, axis)
        # Rodrigues' formula, by its three constant parts
        flat = self._constant(np.eye(3) - across)
        turning = ca.cos(angle) * flat + ca.sin(angle) * self._constant(skew(axis))
        return self._constant(across) + turning, ca.DM.zeros(3)

    def _poses(self, q: Expression) -> list[_Pose]:
        """Return where every body is."""
        ca, out = self._ca, list[_Pose]()
        for joint in self._joints:
            turn, shift = self._own_motion(joint, q)
            placed = self._constant(joint.rotation)
            rotation = ca.mtimes(placed, turn)
            translation = self._constant(joint.translation) + ca.mtimes(placed, shift)
            if joint.parent:
                above = out[joint.parent - 1]
                world = ca.mtimes(above.rotation_world, rotation)
                place = above.translation_world + ca.mtimes(above.rotation_world, translation)
            else:
                world, place = rotation, translation
            out.append(_Pose(rotation, translation, world, place))
        return out

    def _twists(self, poses: list[_Pose], v: Expression) -> tuple[list[Expression], list[Expression]]:
        """Return every body's angular velocity and that of its origin, in body axes."""
        ca = self._ca
        spins, speeds = list[Expression](), list[Expression]()
        for joint, pose in zip(self._joints, poses, strict=True):
            linear, angular = self._split(joint, v)
            if joint.parent:
                back, spin = pose.rotation.T, spins[joint.parent - 1]
                angular += ca.mtimes(back, spin)
                linear += ca.mtimes(back, speeds[joint.parent - 1] + ca.cross(spin, pose.translation))
            spins.append(angular)
            speeds.append(linear)
        return spins, speeds

    def _split(self, joint: _Joint, v: Expression) -> tuple[Expression, Expression]:
        """Return the linear and angular part of a joint's own motion."""
        own = self._ca.mtimes(self._constant(joint.axes), v[joint.v : joint.v + joint.nv])
        return own[:3], own[3:]

    def _body_forces(
        self, poses: list[_Pose], v: Expression, a: Expression
    ) -> list[tuple[Expression, Expression]]:
        """Return the force and the moment about its origin that move every body, in body axes."""
        ca, out = self._ca, []
        spins, speeds = self._twists(poses, v)
        pulls, turns = list[Expression](), list[Expression]()  # spatial accelerations, less gravity's
        for k, (joint, pose) in enumerate(zip(self._joints, poses, strict=True)):
            linear, angular = self._split(joint, v)
            pull, turn = self._split(joint, a)
            spin, speed, back = spins[k], speeds[k], pose.rotation.T
            if joint.parent:
                above, about = pulls[joint.parent - 1], turns[joint.parent - 1]
            else:
                above, about = ca.DM(-self._gravity), ca.DM.zeros(3)
            pull += ca.mtimes(back, above + ca.cross(about, pose.translation))
            # v x S q̇ (spatial cross product): S is constant in the body's axes, which move.
            pull += ca.cross(spin, linear) + ca.cross(speed, angular)
            turn += ca.mtimes(back, about) + ca.cross(spin, angular)
            pulls.append(pull)
            turns.append(turn)
            mass, lever, inertia = joint.mass, self._constant(joint.lever), self._constant(joint.inertia)
            momentum = mass * (speed + ca.cross(spin, lever))
            own = mass * (pull + ca.cross(turn, lever))
            whirl = ca.mtimes(inertia, spin) + ca.cross(lever, momentum)
            moment = ca.mtimes(inertia, turn) + ca.cross(lever, own)
            moment += ca.cross(spin, whirl) + ca.cross(speed, momentum)
            out.append((own + ca.cross(spin, momentum), moment))
        return out

    def _arm(self, pose: _Pose, point: int, normal: Any) -> Expression:
        """Return the place of a sphere's lowest point, from its body's origin in body axes."""
        below = self._ca.mtimes(pose.rotation_world.T, self._ca.DM(np.asarray(normal, dtype=np.float64)))
        return self._constant(self._places[point]) - float(self._radii[point]) * below


def _read_joint(model: Any, data: Any, index: int) -> _Joint:
    """Return one joint of a Pinocchio model and the body that it carries."""
    joint = model.joints[index]
    kind = str(joint.shortname())
    if kind not in (*HINGES, *SLIDES, FREE):
        raise ModelError(
            f"joint {model.names[index]} is a {kind}; planning takes revolute, prismatic, free-flyer joints"
        )
    placement, body = model.jointPlacements[index], model.inertias[index]
    return _Joint(
        kind,
        int(joint.idx_q),
        int(joint.idx_v),
        int(joint.nv),
        int(model.parents[index]),
        np.array(placement.rotation),
        np.array(placement.translation),
        np.array(data.joints[index].S, dtype=np.float64).reshape(6, -1),
        float(body.mass),
        np.array(body.lever),
        np.array(body.inertia),
    )
