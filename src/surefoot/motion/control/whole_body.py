"""Whole-body control: joint torques for wanted accelerations and contact forces, on exact cones.

One strict level: the equations of motion, rigid contacts (acceleration constraint with drift and
Baumgarte terms), exact friction cones with normal bounds, and torque limits. Below it, weighted tasks:
acceleration of the centre of mass, angular acceleration of the base, feet in the air, joints, and
contact forces near the wanted ones (those of a model-predictive controller, say).

    minimise   Σ w_i ||A_i a - b_i||² + w_force ||(f - f_wanted) / m||²
    subject to M a + h = Sᵀ τ + Jᵀ f,   J_c a = -drift + Baumgarte,   f in K,   |τ| <= limit

With actuators the limits are what motors give at the joints' speeds, less their friction, see
`Actuators.usable`.

Torques follow from the joints' rows and accelerations from the ground's generalised force on the base, so
that six numbers are left: the problem becomes force distribution in the metric of the tasks, which
`ForceDistributor` solves exactly. Where a joint that carries would exceed its limit, it solves again with
the torques as rows. A joint that no contact loads (a leg in the air, an arm) has no force to trade: its
torque is pinned at the limit and the tasks give way; with actuators its acceleration is, too, where it would
pass its speed limit or run into its stop, see `gain_range` (what is pinned stays pinned within a step, by one
of both: the answer is optimal if none of them would come back). What no forces can meet is clipped and
flagged. Flat feet push at the corners of their soles: sums of corner forces in friction cones are exactly a
sole's wrenches.
"""

from __future__ import annotations

import math

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray, IntArray, of_kind, real_array, sized_array
from surefoot.base.errors import ModelError, ProblemError
from surefoot.base.live_arrays import Bound
from surefoot.base.memory import Memory, Remembering
from surefoot.contact import Status
from surefoot.mechanics import Actuators, ForceDistributor, Robot, with_rotors
from surefoot.motion.control import whole_body_step as core
from surefoot.motion.control.damping import computable_pose, damping_torques
from surefoot.motion.control.model_views import ModelViews, pinocchio_module
from surefoot.motion.control.whole_body_outcome import StepNotes
from surefoot.motion.control.whole_body_tasks import ForceLimits as ForceLimits
from surefoot.motion.control.whole_body_tasks import Kinematics as Kinematics
from surefoot.motion.control.whole_body_tasks import Tasks as Tasks
from surefoot.motion.control.whole_body_tasks import TaskWeights as TaskWeights
from surefoot.motion.control.whole_body_tasks import WholeBodyCommand as WholeBodyCommand
from surefoot.motion.control.whole_body_tasks import check_parts, control_numbers
from surefoot.motion.estimation.wrench_kernels import point_inertia
from surefoot.motion.estimation.wrench_observer import Instant, Load

PINNING_ROUNDS = 4
"""How often torques may be pinned in a step [-]: a bound on the time."""
TORQUE_SLACK = 0.01
"""Share of their limits by which torques may exceed them in a feasible step [-]: clipped, it hardly shows."""
FREE, NO_WRENCH = ForceLimits(), np.zeros(6)
"""Limits of a step that has none of its own, and the wrench of nothing [N, N m]."""
_Answer = tuple[FloatArray, FloatArray, FloatArray, tuple[float, float, float, bool]]


class WholeBodyController(Bound, Remembering):
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
    mass
        Of the robot with its load [kg].
    mu
        Friction that is counted on now [-].

    Raises
    ------
    ModelError
        If the robot has a fixed base or no feet.
    ProblemError
        For what is not a number within its range.
    """

    MEMORY = (
        "_load", "_q", "_v", "_known", "_memory", "mu", "_swing_factor", "_bounds", "_stance", "_loose",
        "_normals", "_span", "_distributor", "_limited",
    )  # fmt: skip

    def __init__(
        self,
        robot: Robot,
        mu: float = 0.6,
        normal_min: float = 0.0,
        normal_max: float = math.inf,
        weights: TaskWeights | None = None,
        baumgarte: tuple[float, float] = (0.0, 20.0),
        effort_limits: FloatArray | None = None,
        actuators: Actuators | None = None,
        sole_damping: tuple[float, float] | None = None,
    ) -> None:
        of_kind("robot", robot, Robot)
        if not robot.floating or not robot.feet:
            raise ModelError(f"whole-body control of {robot.name} needs a floating base and feet")
        check_parts(actuators, weights)
        self.robot = robot = robot if actuators is None else with_rotors(robot, actuators.armature)
        self._views = ModelViews(robot.model.copy(), robot.model.createData())
        self.mass = robot.mass
        given = robot.effort_limits if effort_limits is None else effort_limits
        self.limits = real_array("effort_limits", given, (robot.joints,))
        self.actuators = actuators
        self._span = np.zeros((5, robot.joints))  # as for `torques_of`
        self._span[1], self._span[3], self._span[4] = self.limits, -math.inf, math.inf  # of ideal motors
        self._stops = np.array([robot.model.lowerPositionLimit, robot.model.upperPositionLimit])[:, 7:]
        mu, low, high, rates = control_numbers(mu, (normal_min, normal_max), baumgarte, sole_damping)
        self._set_memory(w := weights or TaskWeights(), rates)
        points, weight = len(self.point_foot), w.force / robot.mass**2
        self._normals = np.full(points, low), np.full(points, high)
        bounds = np.full(points, mu), *self._normals
        self._distributor = ForceDistributor(*bounds, 1.0, weight)
        self._limited = ForceDistributor(*bounds, 1.0, weight, torque_limit=self.limits)
        self._bounds: tuple[float, bytes] | None = None
        self.mu, self._given_mu, self._swing_factor = mu, mu, 1.0  # counted on now, and of the construction
        self._load: Load | None = None
        self._q, self._v = robot.nominal, np.zeros(robot.model.nv)
        self._stance: BoolArray = np.ones(len(robot.feet), dtype=bool)
        self._loose = self._unloaded()

    def _set_memory(self, w: TaskWeights, rates: tuple[float, ...]) -> None:
        """Bring the weights into their units and make the memory of a step; rates as for `contact_rows`."""
        points = self.robot.contact_points
        legs, square = points.foot_support[:, 6:].any(axis=0), max(float(self.robot.nominal[2]), 0.05) ** 2
        spare = points.foot_support[:, 6:].sum(axis=1) > np.where(points.flat, 6, 3)
        # joints that a light foot leaves free would be flung about to move the body
        lightness = w.swing if spare.any() and w.swing > 0.0 else 1.0
        self.swing = swing = w.swing / lightness
        weights = np.array([w.linear, w.angular * square, swing, swing * square, *rates])
        joints = w.joints * square * np.where(legs, 1.0 / lightness, w.body)
        self._numbers, self._memory = core.step_memory(int(self.robot.model.nv), points, weights, joints)
        self._bind()

    def _bind(self) -> None:
        """Make what every step reads of its memory, here and in a copy."""
        part = self._part
        self._problem = part(core.MAP, 6, -1), part(core.TARGET, 6)
        self._seen = part(core.TWISTS, 6, -1), part(core.TOUCHING, -1, 3), part(core.POSE, 3, 4)
        feet = part(core.CENTRES, -1, 3), part(core.MOVING, -1, 6), part(core.DRIFTS, -1, 6)
        com, speed, spin = part(core.BODY, 3, 3)
        self._noted = self._memory[slice(*self._numbers[[*core.NOTED]])]
        self._moved = com, speed, part(core.BASE, 3, 3), spin, *feet

    @property
    def point_foot(self) -> IntArray:
        """(p,) the foot of every contact point."""
        return self.robot.contact_points.foot

    @property
    def friction(self) -> FloatArray:
        """(joints,) part of the last commanded torques that makes up for the motors' friction [N m]."""
        return np.asarray(self._span[2])

    def reset(self) -> None:
        """Forget the forces of the step before, its limits, and which feet stood."""
        self._take(FREE)
        self._set_stance(np.ones(len(self._stance), dtype=bool))
        for distributor in (self._distributor, self._limited):
            distributor.reset()

    def update(self, q: FloatArray, v: FloatArray) -> Kinematics:
        """Compute what depends on the state alone and return the part that tasks need.

        q is (nq,) [m, -, rad], v is (nv,) [m/s, rad/s], both in Pinocchio's order. What is returned are this
        controller's own arrays, which the next `update` changes.
        """
        pin = pinocchio_module()
        self._known, views = computable_pose(q, v), self._views
        model, data = views.model, views.data
        pin.crba(model, data, q)
        pin.nonLinearEffects(model, data, q, v)
        pin.computeJointJacobiansTimeVariation(model, data, q, v)
        pin.centerOfMass(model, data, q, v, False)
        pin.updateFramePlacements(model, data)
        self._q, self._v = q, v
        core.kinematics(
            self._numbers, self._memory, v, views.twists, views.twist_rates, views.rotation, views.place,
            views.com, views.com_velocity, views.frame_rotations, views.frame_places,
        )  # fmt: skip
        return Kinematics(*self._moved)

    def resume(self, memory: Memory) -> None:
        """See `Remembering`: what follows from the load and the state is computed again.

        Raises
        ------
        ProblemError
            For the memory of another robot: compiled code would reach beyond its arrays.
        """
        for name in ("_memory", "_stance", "_q", "_v"):
            own, given = np.shape(getattr(self, name)), np.shape(np.asarray(memory.get(name)))
            if own != given:
                raise ProblemError(f"the state is of another robot: {name} has {given} entries, not {own}")
        self.carry(memory["_load"])
        self.update(memory["_q"].copy(), memory["_v"].copy())
        super().resume(memory)
        self._bind()

    def carry(self, load: Load | None) -> None:
        """Take a load on the base into the model from the next `update` on, in place of the one before.

        A first moment without a mass moves the centre of mass and leaves the inertia about it as it was, so
        that it stays one that a body can have.
        """
        import pinocchio

        self._load, self.mass = load, self.robot.mass
        base, inertias = self.robot.model.inertias[1], self._views.model.inertias
        if load is None:
            inertias[1] = base
            return
        mass = base.mass + load.mass
        # load and trunk turn about their common centre: reduced mass times the square of their distance
        reduced = max(load.mass, 0.0) * base.mass / mass
        centre = (base.mass * base.lever + load.moment) / mass
        turned = base.inertia + reduced * point_inertia(load.place - base.lever)
        inertias[1] = pinocchio.Inertia(mass, centre, turned)
        self.mass += load.mass

    def instant(self) -> Instant:
        """Return the model at the state of the last `update`; its points are those of the last `solve`.

        Its arrays are this controller's: they hold until the next `update`.
        """
        return Instant(self._views.mass_matrix, self._views.bias, self._v, *self._seen)

    @property
    def foot_rotations(self) -> FloatArray:
        """(n, 3, 3) rotations of the frames of the feet at the last `update` [-]; its own array."""
        return self._part(core.ROTATIONS, -1, 3, 3)

    def _take(self, limits: ForceLimits) -> None:
        """Bring the distributors up to the limits of a step; most of the time nothing of them has changed."""
        friction = self._given_mu if limits.mu == math.inf else limits.mu
        if friction != self.mu:
            self.mu = friction
            for distributor in (self._distributor, self._limited):
                distributor.set_friction(np.full(len(self.point_foot), friction))
        if limits.swing != self._swing_factor:
            self._swing_factor = limits.swing
            self._part(core.WEIGHTS, -1)[core.SWING] = limits.swing * self.swing
        bounds = None if limits.most is None else (limits.least, limits.most.tobytes())
        if limits.most is None or bounds == self._bounds:
            return
        self._bounds = bounds
        on, most = self._stance[self.point_foot], limits.most[self.point_foot]
        self._normals = np.minimum(limits.least, most), most
        for distributor in (self._distributor, self._limited):
            distributor.set_bounds(*self._normals, on)

    def solve(self, tasks: Tasks, limits: ForceLimits = FREE) -> WholeBodyCommand:
        """Return the command for the state of the last `update`, within the limits of this step.

        Never raises on a hard instance and never returns NaN: see `WholeBodyCommand.status`.
        """
        if not self._known:
            return self.damping(self._v)
        views, numbers, memory = self._views, self._numbers, self._memory
        self._take(limits)
        self._set_span()
        outside = NO_WRENCH if limits.outside is None else limits.outside
        rows, sound = core.force_problem(
            numbers, memory, views.mass_matrix, views.bias, self.mass, outside, tasks.stance,
            tasks.com_acceleration, tasks.turn_acceleration, tasks.feet, tasks.joints, tasks.frames,
            tasks.gaps, tasks.forces,
        )  # fmt: skip
        self._set_stance(tasks.stance)
        pinned: dict[int, int] = {}
        for _ in range(PINNING_ROUNDS):
            if not sound:
                return self.damping(self._v)
            forces, status, (torques, accelerations, command, exceeded) = self._share(tasks)
            unloaded, loaded, excess, finite = exceeded
            if not unloaded > 1.0 + core.PINNED_SLACK:
                break
            rows = self._pin_joints(rows, torques, accelerations[6:], pinned)
            sound = core.reduce(numbers, memory, rows)
        if status is Status.INVALID or not finite:
            return self.damping(self._v)
        feasible = max(unloaded, loaded) <= 1.0 + TORQUE_SLACK
        notes = StepNotes(self.robot, numbers, self._noted.copy(), self.mu, self._normals)
        return WholeBodyCommand(command, accelerations, forces, feasible, max(excess, 0.0), status, notes)

    def warm_up(self) -> None:
        """Compile or load what `solve` calls only where torques meet their limits."""
        p, joints = len(self.point_foot), self.robot.joints
        self._limited.solve(*self._problem, None, None, np.zeros((3 * p, joints)), np.zeros(joints))
        core.reduce(self._numbers, self._memory, 6)
        self.reset()

    def step(
        self, q: FloatArray, v: FloatArray, tasks: Tasks, limits: ForceLimits = FREE
    ) -> WholeBodyCommand:
        """Return the command for a state (nq,) [m, -, rad], (nv,) [m/s, rad/s]: `update`, then `solve`."""
        robot, model = self.robot, self.robot.model
        self.update(sized_array("q", q, (model.nq,)), sized_array("v", v, (model.nv,)))
        return self.solve(tasks.fitting(len(robot.feet), len(self.point_foot), robot.joints), limits)

    def _part(self, which: int, *shape: int) -> FloatArray:
        """Return a view of a part of the memory of a step, see `part`."""
        return core.part(self._numbers, self._memory, which, *shape)

    def _set_span(self) -> None:
        """Find `Actuators.usable` of now, and the accelerations of unloaded joints, see `gain_range`."""
        if self.actuators is not None:
            motors, speed = self.actuators, self._v[6:]
            motors.usable(speed, self.limits, self._span)
            core.gain_range(self._q[7:], speed, self._stops, motors.limits.speed, self._span)

    def _share(self, tasks: Tasks) -> tuple[FloatArray, Status, _Answer]:
        """Return forces and what follows from them, the torques of loaded joints within their limits."""
        distributor = self._distributor
        answer = self._answer(forces := distributor.solve(*self._problem, tasks.forces))
        if answer[3][1] > 1.0:
            distributor = self._limited
            forces = self._within_limits(tasks)
            answer = self._answer(forces)
        return forces, distributor.status, answer

    def _answer(self, forces: FloatArray) -> _Answer:
        """Return torques, accelerations, the command and what is exceeded, see `torques_of`."""
        views = self._views
        return core.torques_of(
            self._numbers, self._memory, forces, views.mass_matrix, views.bias, self._span, self._loose
        )

    def _pin_joints(
        self, rows: int, torques: FloatArray, accelerations: FloatArray, pinned: dict[int, int]
    ) -> int:
        """Hold unloaded joints at limits that they exceed, in `pinned` rows; return the number of rows."""
        views, (middle, half, _, *gains) = self._views, self._span
        wanted = self._part(core.WANTED, -1)
        constraints = self._part(core.E, len(wanted), -1)
        away, kept = torques - middle, np.clip(accelerations, *gains)
        fast = np.abs(accelerations - kept) > core.PINNED_SLACK * (gains[1] - gains[0])
        for joint in np.flatnonzero(self._loose & (fast | (np.abs(away) > (1.0 + core.PINNED_SLACK) * half))):
            row = pinned.setdefault(int(joint), rows)
            rows = max(rows, row + 1)
            if fast[joint]:
                constraints[row], wanted[row] = np.arange(6 + len(away)) == 6 + joint, kept[joint]
                continue
            constraints[row] = views.mass_matrix[6 + joint]
            wanted[row] = middle[joint] + math.copysign(half[joint], away[joint]) - views.bias[6 + joint]
        return rows

    def _unloaded(self) -> BoolArray:
        """Return which joints no contact force loads: (joints,)."""
        return np.logical_not(self.robot.contact_points.foot_support[self._stance][:, 6:].any(axis=0))

    def _set_stance(self, stance: BoolArray) -> None:
        """Let the points of the feet in stance push, and no others."""
        if stance.tobytes() != self._stance.tobytes():
            self._stance = stance.copy()
            self._loose = self._unloaded()
            self._distributor.set_active(stance[self.point_foot])

    def _within_limits(self, tasks: Tasks) -> FloatArray:
        """Return the forces that respect the loaded joints' limits, as far as that is possible: (p, 3)."""
        views, (middle, half, *_) = self._views, self._span
        M, nv = views.mass_matrix[6:], len(views.bias)
        ground = self._part(core.ROWS, -1, nv).T
        # torques = slope f + offset, of a = offset + gain w put into the joints' rows of the dynamics
        slope = M @ (self._part(core.GAIN, nv, 6) @ ground[:6]) - ground[6:]
        offset = M @ self._part(core.OFFSET, nv) + views.bias[6:]
        slope[self._loose], offset[self._loose] = 0.0, 0.0
        offset[~self._loose] -= middle[~self._loose]
        # in units in which the range is as wide as the box of the limits
        scale = np.divide(self.limits, half, out=np.ones_like(half), where=np.isfinite(half) & (half > 0.0))
        return self._limited.solve(
            *self._problem, tasks.forces, self._stance[self.point_foot],
            jacobian=(scale[:, None] * slope).T, torque_offset=scale * offset,
        )  # fmt: skip

    def damping(self, v: FloatArray) -> WholeBodyCommand:
        """Return the safe command at (nv,) v [m/s, rad/s] if all else fails: `damping_torques`, no forces."""
        torques = damping_torques(self.robot, v, self.limits)
        none = np.zeros(len(self._views.bias)), np.zeros((len(self.point_foot), 3))
        return WholeBodyCommand(torques, *none, False, 0.0, Status.INVALID)
