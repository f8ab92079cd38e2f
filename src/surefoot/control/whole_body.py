"""Whole-body control: joint torques for wanted accelerations and contact forces, on exact cones.

One strict level: the equations of motion, rigid contacts (acceleration constraint with drift and
Baumgarte terms), exact friction cones with normal bounds, and torque limits. Below it, weighted tasks:
acceleration of the centre of mass, angular acceleration of the base, feet in the air, joints, and
contact forces near the wanted ones (those of a model-predictive controller, say).

    minimise   Σ w_i ||A_i a - b_i||² + w_force ||(f - f_wanted) / m||²
    subject to M a + h = Sᵀ τ + Jᵀ f,   J_c a = -drift + Baumgarte,   f in K,   |τ| <= limit

With actuators the limits are what motors give at the joints' speeds, less their friction, see `TorqueRange`.

Torques follow from the joints' rows and accelerations from the ground's generalised force on the base, so
that six numbers are left: the problem becomes force distribution in the metric of the tasks, which
`ForceDistributor` solves exactly. Where a joint that carries would exceed its limit, it solves again with
the torques as rows. A joint that no contact loads (a leg in the air, an arm) has no force to trade: its
torque is pinned at the limit and the tasks give way (pinned torques stay pinned within a step, so that the
answer is optimal if none of them would come back). What no forces can meet is clipped and flagged. Flat feet
push at the corners of their soles: sums of corner forces in friction cones are exactly a sole's wrenches.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from surefoot.arrays import BoolArray, FloatArray, IntArray
from surefoot.contact import Status
from surefoot.control import whole_body_kernels as kernels
from surefoot.control.actuators import Actuators
from surefoot.control.damping import computable, damping_torques
from surefoot.control.force_distribution import ForceDistributor
from surefoot.control.torque_kernels import exceeded, recover
from surefoot.control.torque_range import TorqueRange
from surefoot.control.whole_body_tasks import Kinematics as Kinematics
from surefoot.control.whole_body_tasks import Tasks as Tasks
from surefoot.control.whole_body_tasks import Weights as Weights
from surefoot.control.whole_body_tasks import WholeBodyCommand as WholeBodyCommand
from surefoot.errors import ModelError
from surefoot.estimation.wrench_observer import Instant, Load
from surefoot.numerics.points import contact_jacobian
from surefoot.robot import Robot
from surefoot.robot.rotors import with_rotors
from surefoot.spatial import GRAVITY

PINNING_ROUNDS, PINNED_SLACK = 4, 1e-6
"""How often torques may be pinned in a step, and by which share of its limit a torque exceeds it."""
TORQUE_SLACK = 0.01
"""Torques beyond their limit by more than this share of it make a step infeasible."""


class WholeBodyController:
    """Turns tasks into torques at every step of a fast loop: `update`, then `solve`.

    Parameters
    ----------
    robot
        With a floating base and feet.
    mu
        Friction [-] that the controller believes in.
    normal_min, normal_max
        Bounds on the normal force of each contact point [N].
    weights
        Of the tasks; None for the defaults.
    baumgarte
        (stiffness [1/s²], damping [1/s]) of the contact constraint.
    effort_limits
        (joints,) [N m]; None for the robot's own.
    actuators
        Motors whose torques it commands: rotors, limits at the joints' speeds, friction that it makes up for.
    sole_damping
        Rates at which soles that carry stop moving along the normal, and turning [1/s]; None for the damping
        of the contact constraint. A sole that does not lie as flat as is believed tips over the corners that
        touch, and one that does not touch yet falls, with nothing but the leg's inertia against it: high
        rates let it down gently.

    Attributes
    ----------
    outside
        (6,) known wrench on the base beside the ground's, about its origin, base axes [N, N m].

    Raises
    ------
    ModelError
        If the robot has a fixed base or no feet.
    """

    def __init__(
        self,
        robot: Robot,
        mu: float = 0.6,
        normal_min: float = 0.0,
        normal_max: float = math.inf,
        weights: Weights | None = None,
        baumgarte: tuple[float, float] = (0.0, 20.0),
        effort_limits: FloatArray | None = None,
        actuators: Actuators | None = None,
        sole_damping: tuple[float, float] | None = None,
    ) -> None:
        import pinocchio

        if not robot.floating or not robot.feet:
            raise ModelError(f"whole-body control of {robot.name} needs a floating base and feet")
        robot = robot if actuators is None else with_rotors(robot, actuators.armature)
        self.robot, self._pin = robot, pinocchio
        self._model, self._data = robot.model.copy(), robot.model.createData()
        self._base, self._mass = robot.model.inertias[1].copy(), robot.mass
        self.outside = np.zeros(6)
        self.limits = robot.effort_limits if effort_limits is None else np.asarray(effort_limits, np.float64)
        self._range = TorqueRange(self.limits, actuators)
        self.weights = weights or Weights()
        self._baumgarte = (*baumgarte, *(sole_damping or (baumgarte[1], baumgarte[1])))
        self._set_points()
        self._set_sizes(mu, normal_min, normal_max)
        self._failed = WholeBodyCommand(
            np.zeros(robot.joints), np.zeros(self._nv), np.zeros((self._count, 3)), False, 0.0, Status.INVALID
        )

    def _set_points(self) -> None:
        """Collect the contact points and what moves each foot."""
        points = self.robot.contact_points
        self.point_foot: IntArray = points.foot
        self._offsets, self._middles = points.centres, points.middles
        self._radii, self._flat = points.foot_radii, points.flat
        self._support, self._frames = points.foot_support, points.frames

    def _set_sizes(self, mu: float, normal_min: float, normal_max: float) -> None:
        """Make the work space, the weights in their units and the force distribution."""
        robot = self.robot
        nv, count, feet = int(self._model.nv), len(self.point_foot), len(robot.feet)
        self._nv, self._count = nv, count
        height = max(float(robot.nominal[2]), 0.05)
        w = self.weights
        self._base_weights = np.array([w.linear, w.angular * height**2])
        legs = self._support[:, 6:].any(axis=0)
        self._joint_weights = w.joints * height**2 * np.where(legs, 1.0, w.body)
        self._turn_weight = w.swing * height**2
        self._force_weight = w.force / robot.mass**2
        self.mu = np.full(count, float(mu))
        bounds = self.mu, np.full(count, normal_min), np.full(count, normal_max)
        self._distributor = ForceDistributor(*bounds, 1.0, self._force_weight)
        self._limited = ForceDistributor(*bounds, 1.0, self._force_weight, torque_limit=self.limits)
        self._bounds: tuple[list[float], list[float]] | None = None
        self._stance = np.ones(feet, dtype=bool)
        self._loose: BoolArray = np.logical_not(self._support[:, 6:].any(axis=0))
        self._H, self._c = np.zeros((nv, nv)), np.zeros(nv)
        rows = 6 + int(np.where(self._flat, 6, 3).sum()) + robot.joints
        self._E, self._e = np.zeros((rows, nv)), np.zeros(rows)
        self._offset, self._gain = np.zeros(nv), np.zeros((nv, 6))
        self._root, self._target = np.zeros((6, 6)), np.zeros(6)
        self._rows = np.zeros((3 * count, nv))
        self._map = self._rows.T
        self._normals, self._arms = np.zeros((feet, 3)), np.zeros((feet, 3))
        self._point_frames, self._points = np.zeros((count, 3, 3)), np.zeros((count, 3))
        self._rotations, self._places = np.zeros((feet, 3, 3)), np.zeros((feet, 3))

    def set_friction(self, mu: float) -> None:
        """Change the friction [-] that the controller believes in."""
        self.mu[:] = mu
        for distributor in (self._distributor, self._limited):
            distributor.set_friction(self.mu)

    def reset(self) -> None:
        """Forget the forces of the step before, and which feet stood."""
        self._set_stance(np.ones(len(self._stance), dtype=bool))
        for distributor in (self._distributor, self._limited):
            distributor.reset()

    def update(self, q: FloatArray, v: FloatArray) -> Kinematics:
        """Compute what depends on the state alone and return the part that tasks need.

        q is (nq,) [m, -, rad], v is (nv,) [m/s, rad/s], both in Pinocchio's order.
        """
        self._known = computable(q, v)
        if self._known:
            return self._update(q, v)
        with np.errstate(all="ignore"):
            return self._update(q, v)

    def _update(self, q: FloatArray, v: FloatArray) -> Kinematics:
        """See `update`."""
        pin, model, data = self._pin, self._model, self._data
        pin.crba(model, data, q)
        pin.nonLinearEffects(model, data, q, v)
        pin.computeJointJacobiansTimeVariation(model, data, q, v)
        com = pin.centerOfMass(model, data, q, v, False)
        for k, frame in enumerate(self._frames):
            pose = pin.updateFramePlacement(model, data, frame)
            self._rotations[k], self._places[k] = pose.rotation, pose.translation
        self._v = v
        self._mass_matrix, self._nle = np.array(data.M), np.array(data.nle)
        self._jacobian = np.ascontiguousarray(data.J)
        centres, twists, drifts = kernels.feet_motion(
            self._jacobian, np.ascontiguousarray(data.dJ), self._support, v,
            self._rotations, self._places, self._middles,
        )  # fmt: skip
        rotation = np.array(data.oMi[1].rotation)
        self._now = Kinematics(
            np.array(com), np.array(data.vcom[0]), rotation, rotation @ v[3:6], centres, twists, drifts
        )
        return self._now

    @property
    def friction(self) -> FloatArray:
        """(joints,) part of the commanded torques that makes up for the motors' friction [N m]."""
        return self._range.losses

    def carry(self, load: Load | None) -> None:
        """Take a load on the base into the model from the next `update` on, in place of the one before.

        A first moment without a mass moves the centre of mass and leaves the inertia about it as it was, so
        that it stays one that a body can have.
        """
        import pinocchio

        base, self._mass = self._base, self.robot.mass
        self._model.inertias[1] = base
        if load is None:
            return
        mass, arm = base.mass + load.mass, load.place - base.lever
        reduced = max(load.mass, 0.0) * base.mass / mass
        inertia = base.inertia + reduced * (float(arm @ arm) * np.eye(3) - np.outer(arm, arm))
        centre = (base.mass * base.lever + load.moment) / mass
        self._model.inertias[1] = pinocchio.Inertia(mass, centre, inertia)
        self._mass += load.mass

    def instant(self, v: FloatArray) -> Instant:
        """Return the model at the state of the last `solve`, whose velocity is (nv,) v [m/s, rad/s]."""
        now = self._now
        pose = np.empty((3, 4))
        pose[:, :3], pose[:, 3] = now.rotation, self._data.oMi[1].translation
        return Instant(self._mass_matrix, self._nle, v, self._jacobian, self._touching, pose)

    @property
    def foot_rotations(self) -> FloatArray:
        """(n, 3, 3) rotations of the frames of the feet at the last `update` [-]; its own array."""
        return self._rotations

    def bound_normals(self, low: FloatArray, high: FloatArray) -> None:
        """Change the bounds (n,) on every foot's normal forces [N]; a flat foot's hold for each corner."""
        given = low.tolist(), high.tolist()
        if given == self._bounds:
            return  # most of the time: between the ramps of a stance
        self._bounds = given
        at = self.point_foot
        on, least, most = self._stance[at], low[at], high[at]
        for distributor in (self._distributor, self._limited):
            distributor.set_bounds(least, most, on)

    def dynamics(self) -> tuple[FloatArray, FloatArray]:
        """Return mass matrix (nv, nv) [kg, kg m²] and bias forces (nv,) [N, N m] of the last `update`."""
        return self._mass_matrix, self._nle

    def solve(self, tasks: Tasks) -> WholeBodyCommand:
        """Return the command for the state of the last `update`.

        Never raises on a hard instance and never returns NaN: see `WholeBodyCommand.feasible`.
        """
        if not self._known:
            return self.damping(self._v)
        span = self._range
        span.update(self._v[6:])
        rows = self._assemble(tasks)
        self._set_stance(tasks.stance)
        for _ in range(PINNING_ROUNDS):
            if not self._eliminate(rows):
                return self.damping(self._v)
            forces, torques, accelerations = self._share(tasks)
            unloaded, loaded, excess, finite = exceeded(torques, span.middle, span.half, self._loose)
            if not unloaded > 1.0 + PINNED_SLACK:
                break
            over = self._loose & (np.abs(torques - span.middle) > (1.0 + PINNED_SLACK) * span.half)
            rows = self._pin_torques(rows, over, torques)
        if self._status is Status.INVALID or not finite:
            return self.damping(self._v)
        feasible = max(unloaded, loaded) <= 1.0 + TORQUE_SLACK
        clipped = span.command(torques)
        return WholeBodyCommand(clipped, accelerations, forces, feasible, max(excess, 0.0), self._status)

    def step(self, q: FloatArray, v: FloatArray, tasks: Tasks) -> WholeBodyCommand:
        """Return the command for a state (nq,) [m, -, rad], (nv,) [m/s, rad/s]: `update`, then `solve`."""
        self.update(q, v)
        return self.solve(tasks)

    def _assemble(self, tasks: Tasks) -> int:
        """Fill tasks and constraints; return the number of constraint rows."""
        now = self._now
        kernels.base_tasks(
            self._mass_matrix, self._nle, now.rotation, self._mass, GRAVITY,
            tasks.com_acceleration, tasks.turn_acceleration, self._base_weights,
            tasks.joints, self._joint_weights, self._H, self._c,
        )  # fmt: skip
        kernels.swing_tasks(
            self._jacobian, self._support, self._flat, tasks.stance, now.centres, now.drifts, tasks.feet,
            self.weights.swing, self._turn_weight, self._H, self._c,
        )  # fmt: skip
        normals, arms, frames, points = self._normals, self._arms, self._point_frames, self._points
        kernels.place_points(
            tasks.frames, self.point_foot, self._rotations, self._places, self._offsets, self._radii,
            normals, arms, frames, points,
        )  # fmt: skip
        rows = 6 + kernels.contact_rows(
            self._jacobian, self._support, self._flat, tasks.stance, now.centres, now.twists, now.drifts,
            arms, tasks.gaps, normals, self._baumgarte, self._E[6:], self._e[6:],
        )  # fmt: skip
        self._E[:6] = self._mass_matrix[:6]
        self._e[:6] = self.outside - self._nle[:6]
        self._touching = now.centres + arms
        contact_jacobian(self._jacobian, self._support, self.point_foot, points, frames, self._rows)
        return rows

    def _eliminate(self, rows: int) -> bool:
        """Reduce the problem to the ground's force on the base; False for input that is not finite."""
        return bool(
            kernels.eliminate(
                self._H, self._c, self._E[:rows], self._e[:rows],
                self._offset, self._gain, self._root, self._target,
            )
        ) and bool(np.isfinite(self._target).all())  # fmt: skip

    def _share(self, tasks: Tasks) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return forces, torques and accelerations, the torques of loaded joints within their limits."""
        A = self._root.T @ self._map[:6]
        forces = self._distributor.solve(A, self._target, tasks.forces)
        self._status = self._distributor.status
        torques, accelerations = self._recover(forces)
        if exceeded(torques, self._range.middle, self._range.half, self._loose)[1] > 1.0:
            forces = self._within_limits(A, tasks)
            self._status = self._limited.status
            torques, accelerations = self._recover(forces)
        return forces, torques, accelerations

    def _pin_torques(self, rows: int, over: BoolArray, torques: FloatArray) -> int:
        """Add constraints that hold torques at the limits that they exceed; return the number of rows."""
        pinned = self._range.nearest(torques)
        for joint in np.flatnonzero(over):
            if rows == len(self._e):
                break
            self._E[rows] = self._mass_matrix[6 + joint]
            self._e[rows] = pinned[joint] - self._nle[6 + joint]
            rows += 1
        return rows

    def _recover(self, forces: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the torques and accelerations that go with contact forces."""
        return recover(self._rows, forces, self._offset, self._gain, self._mass_matrix, self._nle)

    def _set_stance(self, stance: BoolArray) -> None:
        """Tell the force distribution which points carry."""
        if (stance != self._stance).any():
            self._stance = stance.copy()
            # joints that no contact force loads
            self._loose = np.logical_not(self._support[stance][:, 6:].any(axis=0))
            self._distributor.set_active(stance[self.point_foot])

    def _within_limits(self, A: FloatArray, tasks: Tasks) -> FloatArray:
        """Return the forces that respect the loaded joints' limits, as far as that is possible: (p, 3)."""
        slope = self._mass_matrix[6:] @ (self._gain @ self._map[:6]) - self._map[6:]
        offset = self._mass_matrix[6:] @ self._offset + self._nle[6:]
        slope[self._loose], offset[self._loose] = 0.0, 0.0
        loaded = ~self._loose
        offset[loaded] -= self._range.middle[loaded]
        slope, offset = self._range.scale[:, None] * slope, self._range.scale * offset
        return self._limited.solve(
            A,
            self._target,
            tasks.forces,
            self._stance[self.point_foot],
            jacobian=slope.T,
            torque_offset=offset,
        )

    def damping(self, v: FloatArray) -> WholeBodyCommand:
        """Return the safe command when nothing can be computed: torques that slow the joints, no forces.

        Joints whose speed in (nv,) `v` [m/s, rad/s] is not finite get no torque.
        """
        return replace(self._failed, torques=damping_torques(self.robot, v, self.limits))
