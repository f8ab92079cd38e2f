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

import numpy as np

from surefoot.arrays import BoolArray, FloatArray, IntArray
from surefoot.contact import Status
from surefoot.control.actuators import Actuators
from surefoot.control.damping import computable, damping_torques
from surefoot.control.force_distribution import ForceDistributor
from surefoot.control.model_views import ModelViews
from surefoot.control.torque_range import TorqueRange
from surefoot.control.whole_body_step import StepMemory, force_problem, kinematics, reduce, torques_of
from surefoot.control.whole_body_tasks import Kinematics as Kinematics
from surefoot.control.whole_body_tasks import Tasks as Tasks
from surefoot.control.whole_body_tasks import Weights as Weights
from surefoot.control.whole_body_tasks import WholeBodyCommand as WholeBodyCommand
from surefoot.errors import ModelError
from surefoot.estimation.wrench_kernels import point_inertia
from surefoot.estimation.wrench_observer import Instant, Load
from surefoot.robot import Robot
from surefoot.robot.rotors import with_rotors

PINNING_ROUNDS, PINNED_SLACK = 4, 1e-6
"""How often torques may be pinned in a step, and by which share of its limit a torque exceeds it."""
_Answer = tuple[FloatArray, FloatArray, FloatArray, tuple[float, float, float, bool]]
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
        self._model = robot.model.copy()
        self._views = ModelViews(self._model, robot.model.createData())
        base = self._base = robot.model.inertias[1].copy()
        self._trunk = base.mass, np.array(base.lever), np.array(base.inertia)
        self._mass = robot.mass
        self.outside = np.zeros(6)
        self.limits = robot.effort_limits if effort_limits is None else np.asarray(effort_limits, np.float64)
        self._range = TorqueRange(self.limits, actuators)
        self.weights = weights or Weights()
        self._set_memory((*baumgarte, *(sole_damping or (baumgarte[1], baumgarte[1]))))
        self._set_forces(mu, normal_min, normal_max)
        self._failed = WholeBodyCommand(
            np.zeros(robot.joints), np.zeros(self._nv), np.zeros((self._count, 3)), False, 0.0, Status.INVALID
        )

    def _set_memory(self, rates: tuple[float, ...]) -> None:
        """Bring the weights into their units and make the memory of a step; rates as for `contact_rows`."""
        points, w = self.robot.contact_points, self.weights
        self.point_foot: IntArray = points.foot
        self._nv, self._count = int(self._model.nv), len(points.foot)
        self._support = points.foot_support
        legs, square = self._support[:, 6:].any(axis=0), max(float(self.robot.nominal[2]), 0.05) ** 2
        weights = np.array([w.linear, w.angular * square, w.swing, w.swing * square, *rates])
        joints = w.joints * square * np.where(legs, 1.0, w.body)
        self._step = StepMemory(self._nv, points, weights, joints)

    def _set_forces(self, mu: float, normal_min: float, normal_max: float) -> None:
        """Make the force distribution."""
        count, feet = self._count, len(self.robot.feet)
        weight = self.weights.force / self.robot.mass**2
        self.mu = np.full(count, float(mu))
        bounds = self.mu, np.full(count, normal_min), np.full(count, normal_max)
        self._distributor = ForceDistributor(*bounds, 1.0, weight)
        self._limited = ForceDistributor(*bounds, 1.0, weight, torque_limit=self.limits)
        self._bounds: tuple[bytes, bytes] | None = None
        self._stance = np.ones(feet, dtype=bool)
        self._loose: BoolArray = np.logical_not(self._support[:, 6:].any(axis=0))

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
        pin, model, views = self._pin, self._model, self._views
        data = views.data
        pin.crba(model, data, q)
        pin.nonLinearEffects(model, data, q, v)
        pin.computeJointJacobiansTimeVariation(model, data, q, v)
        pin.centerOfMass(model, data, q, v, False)
        pin.updateFramePlacements(model, data)
        self._v = v
        self._now = Kinematics(
            *kinematics(
                self._step.numbers, self._step.memory, v, views.twists, views.twist_rates, views.rotation,
                views.com, views.com_velocity, views.frame_rotations, views.frame_places,
            )
        )  # fmt: skip
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
        self._mass = self.robot.mass
        if load is None:
            self._model.inertias[1] = self._base
            return
        own, lever, inertia = self._trunk
        mass = own + load.mass
        reduced = max(load.mass, 0.0) * own / mass
        centre = (own * lever + load.moment) / mass
        turned = inertia + reduced * point_inertia(load.place - lever)
        self._model.inertias[1] = self._pin.Inertia(mass, centre, turned)
        self._mass += load.mass

    def instant(self, v: FloatArray) -> Instant:
        """Return the model at the state of the last `solve`, whose velocity is (nv,) v [m/s, rad/s].

        Its arrays are this controller's: they hold until the next `update`.
        """
        views = self._views
        pose = np.empty((3, 4))
        pose[:, :3], pose[:, 3] = views.rotation, views.place
        return Instant(views.mass_matrix, views.bias, v, self._step.twists, self._step.touching, pose)

    @property
    def foot_rotations(self) -> FloatArray:
        """(n, 3, 3) rotations of the frames of the feet at the last `update` [-]; its own array."""
        return self._step.rotations

    def bound_normals(self, low: FloatArray, high: FloatArray) -> None:
        """Change the bounds (n,) on every foot's normal forces [N]; a flat foot's hold for each corner."""
        given = low.tobytes(), high.tobytes()
        if given == self._bounds:
            return  # most of the time: between the ramps of a stance
        self._bounds = given
        at = self.point_foot
        on, least, most = self._stance[at], low[at], high[at]
        for distributor in (self._distributor, self._limited):
            distributor.set_bounds(least, most, on)

    def dynamics(self) -> tuple[FloatArray, FloatArray]:
        """Return mass matrix (nv, nv) [kg, kg m²] and bias forces (nv,) [N, N m] of the last `update`.

        They are this controller's own arrays, which the next `update` changes.
        """
        return self._views.mass_matrix, self._views.bias

    def solve(self, tasks: Tasks) -> WholeBodyCommand:
        """Return the command for the state of the last `update`.

        Never raises on a hard instance and never returns NaN: see `WholeBodyCommand.feasible`.
        """
        if not self._known:
            return self.damping(self._v)
        span, views, numbers, memory = self._range, self._views, self._step.numbers, self._step.memory
        span.update(self._v[6:])
        rows, sound = force_problem(
            numbers, memory, views.mass_matrix, views.bias, self._mass, self.outside, tasks.stance,
            tasks.com_acceleration, tasks.turn_acceleration, tasks.feet, tasks.joints, tasks.frames,
            tasks.gaps,
        )  # fmt: skip
        self._set_stance(tasks.stance)
        for _ in range(PINNING_ROUNDS):
            if not sound:
                return self.damping(self._v)
            forces, (torques, accelerations, command, exceeded) = self._share(tasks)
            unloaded, loaded, excess, finite = exceeded
            if not unloaded > 1.0 + PINNED_SLACK:
                break
            over = self._loose & (np.abs(torques - span.middle) > (1.0 + PINNED_SLACK) * span.half)
            rows = self._pin_torques(rows, over, torques)
            sound = reduce(numbers, memory, rows)
        if self._status is Status.INVALID or not finite:
            return self.damping(self._v)
        feasible = max(unloaded, loaded) <= 1.0 + TORQUE_SLACK
        return WholeBodyCommand(command, accelerations, forces, feasible, max(excess, 0.0), self._status)

    def step(self, q: FloatArray, v: FloatArray, tasks: Tasks) -> WholeBodyCommand:
        """Return the command for a state (nq,) [m, -, rad], (nv,) [m/s, rad/s]: `update`, then `solve`."""
        self.update(q, v)
        return self.solve(tasks)

    def _share(self, tasks: Tasks) -> tuple[FloatArray, _Answer]:
        """Return forces and what follows from them, the torques of loaded joints within their limits."""
        step = self._step
        forces = self._distributor.solve(step.map, step.target, tasks.forces)
        self._status = self._distributor.status
        answer = self._answer(forces)
        if answer[3][1] > 1.0:
            forces = self._within_limits(tasks)
            self._status = self._limited.status
            answer = self._answer(forces)
        return forces, answer

    def _answer(self, forces: FloatArray) -> _Answer:
        """Return torques, accelerations, the command and what is exceeded, see `torques_of`."""
        span, views = self._range, self._views
        return torques_of(
            self._step.numbers, self._step.memory, forces, views.mass_matrix, views.bias, span.middle,
            span.half, span.losses, self._loose,
        )  # fmt: skip

    def _pin_torques(self, rows: int, over: BoolArray, torques: FloatArray) -> int:
        """Add constraints that hold torques at the limits that they exceed; return the number of rows."""
        pinned, step, views = self._range.nearest(torques), self._step, self._views
        for joint in np.flatnonzero(over):
            if rows == len(step.wanted):
                break
            step.constraints[rows] = views.mass_matrix[6 + joint]
            step.wanted[rows] = pinned[joint] - views.bias[6 + joint]
            rows += 1
        return rows

    def _set_stance(self, stance: BoolArray) -> None:
        """Tell the force distribution which points carry."""
        if stance.tobytes() != self._stance.tobytes():
            self._stance = stance.copy()
            # joints that no contact force loads
            self._loose = np.logical_not(self._support[stance][:, 6:].any(axis=0))
            self._distributor.set_active(stance[self.point_foot])

    def _within_limits(self, tasks: Tasks) -> FloatArray:
        """Return the forces that respect the loaded joints' limits, as far as that is possible: (p, 3)."""
        step, views = self._step, self._views
        M, ground = views.mass_matrix[6:], step.rows.T
        slope = M @ (step.gain @ ground[:6]) - ground[6:]
        offset = M @ step.offset + views.bias[6:]
        slope[self._loose], offset[self._loose] = 0.0, 0.0
        loaded = ~self._loose
        offset[loaded] -= self._range.middle[loaded]
        slope, offset = self._range.scale[:, None] * slope, self._range.scale * offset
        return self._limited.solve(
            step.map,
            step.target,
            tasks.forces,
            self._stance[self.point_foot],
            jacobian=slope.T,
            torque_offset=offset,
        )

    def damping(self, v: FloatArray) -> WholeBodyCommand:
        """Return the safe command when nothing can be computed: torques that slow the joints, no forces.

        Joints whose speed in (nv,) `v` [m/s, rad/s] is not finite get no torque.
        """
        return self._failed._replace(torques=damping_torques(self.robot, v, self.limits))
