"""The standing controller: a wrench from a PD law, shared by the feet on their exact cones.

Each step: the wrench that holds the base where the plan wants it, the ground forces that give it, and
the joint torques that make the feet push so (the contact Jacobian's transpose and the legs' own
dynamics). Gains scale with the robot's mass, inertia and height; their multiples were tuned in simulation, on
robots of Go2's size.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from surefoot.base.arrays import FloatArray, IntArray, of_kind
from surefoot.base.errors import ProblemError
from surefoot.base.memory import Remade
from surefoot.base.numerics.points import contact_jacobian
from surefoot.base.spatial import GRAVITY
from surefoot.contact import Status
from surefoot.mechanics import ExactAllocation, Robot, Terrain, composite_inertia
from surefoot.motion.control.controller import Command, Controller, RobotState
from surefoot.motion.control.damping import FALLEN, computable_pose, damping_torques
from surefoot.motion.control.model_views import ModelViews
from surefoot.motion.standing.stand_state import StandState
from surefoot.motion.standing.standing_kernels import (
    foot_impedance,
    grasp_map_of_points,
    pd_wrench,
    within_limits,
)
from surefoot.motion.standing.standing_plan import StandingPlan, StandingTarget
from surefoot.records import CHANNELS

NORMAL_MIN = 10.0
"""Least normal force of a standing foot [N], unless that is too much for a light robot."""
LIGHT_SHARE = 0.3
"""A foot's least normal force never exceeds this share of m g / n."""
NORMAL_MAX_SHARE = 1.5
"""Largest normal force of a foot, as a share of m g: one foot can carry the robot and a push."""
POSITION_STIFFNESS, ORIENTATION_STIFFNESS, JOINT_STIFFNESS, SWING_STIFFNESS = 2.5, 3.0, 3.0, 8.0
"""Natural frequencies, in units of the pendulum frequency sqrt(g / height)."""
INTEGRAL_TIME = 1.5
"""Time constant of the integral term that takes up unknown loads [s]."""
INTEGRAL_LIMIT = 0.6
"""Largest integral force, as a share of m g (and moment, times the base's height)."""
FORCE_WEIGHT = 1e-3
"""Weight of the forces' square against the wrench error's."""
WRENCH_TOLERANCE = 0.02
"""A wrench is attained when its error is below this share of m g (moments over the base's height)."""


@dataclass(frozen=True, kw_only=True)
class StandCommand(Command):
    """What the standing controller asks for at one step.

    Attributes
    ----------
    wrench_desired, wrench_error
        (6,) wanted wrench about the centre of mass, and what the forces miss of it [N, N m]; it is attained
        to `WRENCH_TOLERANCE`.
    grasp_map
        (6, 3p) from forces to wrench; the controller's own array, overwritten by the next step.
    """

    wrench_desired: FloatArray
    wrench_error: FloatArray
    grasp_map: FloatArray

    def rows(self) -> dict[str, Any]:
        """Return the wrench, what is missed of it and the grasp map."""
        return {
            "wrench_desired": self.wrench_desired,
            "wrench_error": self.wrench_error,
            "grasp_map": self.grasp_map,
        }


class StandingController(Remade, Controller):
    """Holds a robot up on its feet; call `step` at a fixed rate.

    Parameters
    ----------
    robot
        Who stands; point feet push at their one sphere, flat ones at their corners.
    plan
        Where the base should be and which feet are lifted.
    terrain
        The ground that the feet are believed to touch.
    q
        (nq,) configuration to hold [m, -, rad]: base orientation and the joints outside the legs.
    mu
        Friction [-] that the controller believes in.
    dt
        Time between steps [s].
    normal_min, normal_max
        Bounds on each foot's normal force [N]; None for the defaults that suit the robot.
    """

    channels = tuple(CHANNELS[name] for name in ("wrench_desired", "wrench_error", "grasp_map"))

    def __init__(
        self,
        robot: Robot,
        plan: StandingPlan,
        terrain: Terrain,
        q: FloatArray,
        mu: float = 0.6,
        dt: float = 1e-3,
        normal_min: float | None = None,
        normal_max: float | None = None,
    ) -> None:
        of_kind("robot", robot, Robot)
        of_kind("terrain", terrain, Terrain)
        import pinocchio

        self.robot, self.plan, self.terrain, self.dt = robot, plan, terrain, dt
        self._pin, self._model = pinocchio, robot.model
        self._views = ModelViews(robot.model, robot.model.createData())
        self._q = q.copy()
        self._inertia_base, _, self._rotation = composite_inertia(robot, q)
        self._set_points(q)
        weight = robot.mass * GRAVITY
        self.normal_min, self.normal_max = default_normal_bounds(robot, normal_min, normal_max)
        self._share = np.array([1.0 / len(robot.feet[f].centres) for f in self.point_foot])
        self._set_gains(weight)
        self.mu = float(mu)
        self.facts = {
            "kind": "stand", "normal_min": self.normal_min, "normal_max": self.normal_max,
            "mu_controller": self.mu,
        }  # fmt: skip
        frictions = np.full(len(self.point_foot), self.mu)
        self._allocation = ExactAllocation(frictions, wrench_weights(robot, q), FORCE_WEIGHT)
        self._stand = StandState(np.zeros(6))
        self._bounds_of: tuple[bytes, tuple[FloatArray, FloatArray]] = (b"", (np.zeros(0), np.zeros(0)))
        self._grasp = np.zeros((6, 3 * len(self.point_foot)))
        self._contact_rows = np.zeros((3 * len(self.point_foot), robot.model.nv))
        self._limits = np.ascontiguousarray(robot.effort_limits, dtype=np.float64)

    def _set_points(self, q: FloatArray) -> None:
        """Collect the contact points, the joints that carry each, and the feet's places on the ground."""
        points = self.robot.contact_points
        self.point_foot: IntArray = points.foot
        self._centres, self._radii = points.centres, points.radii
        self._support = points.foot_support
        self._all_held = bool(self._support.any(axis=0).all())
        self._frame_ids = points.frames
        self._point_frame = np.array(points.frames, dtype=np.int64)[points.foot]
        self._anchors = self.robot.foot_positions(q)
        normals = self.terrain.normal(self._anchors[:, :2])
        self._normals = normals
        frames = np.array([self.terrain.frame(a[:2]) for a in self._anchors])
        self._frames = np.ascontiguousarray(frames[self.point_foot])

    def _set_gains(self, weight: float) -> None:
        height = standing_height(self.robot, self._q)
        pendulum = math.sqrt(GRAVITY / height)
        self._height, self._weight = height, weight
        self._omega = POSITION_STIFFNESS * pendulum
        self._omega_turn = ORIENTATION_STIFFNESS * pendulum
        self._omega_joint = JOINT_STIFFNESS * pendulum
        self._omega_swing = SWING_STIFFNESS * pendulum
        limit = INTEGRAL_LIMIT * weight
        self._integral_limit = np.array([limit] * 3 + [limit * height] * 3)
        self._tolerance = WRENCH_TOLERANCE * weight

    def reset(self) -> None:
        """Forget the integral term and the forces of the step before."""
        self._allocation.reset()
        self._stand = StandState(np.zeros(6))

    @property
    def state(self) -> StandState:
        """A copy of all that lasts from one step to the next, for `resume`."""
        return StandState(self._stand.integral.copy(), {"allocation": self._allocation.remembered()})

    def resume(self, state: StandState | None) -> None:
        """Go on from a state of a controller that was made in the same way; None is the beginning.

        Raises
        ------
        ProblemError
            For a state of a robot with another number of contact points, or without what `state` gives.
        """
        if state is None:
            self.reset()
            return
        parts = state.parts or {}
        points = len(parts["allocation"]["_last"]) if "allocation" in parts else 0
        if points != len(self.point_foot):  # compiled code would read and write beyond the smaller arrays
            raise ProblemError(
                f"a state to resume must be of {len(self.point_foot)} contact points, got one of {points}"
            )
        self._allocation.resume(parts["allocation"])
        self._stand = StandState(state.integral.copy())

    def warm_up(self, state: RobotState) -> None:
        """Step once on all feet and once in the middle of every lift, and forget it."""
        for time in (0.0, *(0.5 * (lift.start + lift.end) for lift in self.plan.lifts)):
            self.step(RobotState(state.q, state.v, time))
        self.reset()

    def step(self, state: RobotState) -> StandCommand:
        """Return the command for a state.

        Never raises on a hard instance: the forces stay inside every cone and bound, and `attained`
        and `status` tell the rest. A state that is not finite, or too large to compute with, gets a command
        that slows the joints, with no forces and the status INVALID; it changes nothing else.
        """
        state = state.fitting(self.robot)
        q, v = state.q, state.v
        if not computable_pose(q, v):
            return self._blind(v)
        s, target = self._stand, self.plan.at(state.time)
        points = self._kinematics(q, v)
        wrench, pull = self._wrench(s, target, q, v)
        low, high = self._bounds(target)
        forces = self._allocation.share(self._grasp, wrench, low, high)
        status = self._allocation.status
        if status is Status.INVALID:
            return self._blind(v)
        error = self._grasp @ forces.ravel() - wrench
        attained = self._attained(error)
        torques, finite = within_limits(self._torques(target, forces, points, q, v), self._limits)
        if not finite:
            return self._blind(v)
        if attained:
            self._stand = StandState(self._accumulate(s.integral, pull))
        return StandCommand(
            torques, forces, high > 0.0, attained, status,
            wrench_desired=wrench, wrench_error=error, grasp_map=self._grasp,
        )  # fmt: skip

    def _blind(self, v: FloatArray) -> StandCommand:
        """Return the command when nothing can be computed: the weight is wanted, and no force given."""
        count = len(self.point_foot)
        weight = np.array([0.0, 0.0, self._weight, 0.0, 0.0, 0.0])
        torques = damping_torques(self.robot, v, self._limits)
        off = np.zeros(count, dtype=bool)
        return StandCommand(
            torques, np.zeros((count, 3)), off, False, Status.INVALID,
            wrench_desired=weight, wrench_error=-weight, grasp_map=np.zeros_like(self._grasp),
        )  # fmt: skip

    def _kinematics(self, q: FloatArray, v: FloatArray) -> FloatArray:
        """Update Pinocchio's terms and the grasp map about the centre of mass; return the contact points.

        They are (p, 3), in world axes [m].
        """
        pin, model, views = self._pin, self._model, self._views
        pin.computeJointJacobians(model, views.data, q)
        pin.nonLinearEffects(model, views.data, q, v)
        pin.centerOfMass(model, views.data, q, False)
        pin.updateFramePlacements(model, views.data)
        return grasp_map_of_points(
            views.frame_rotations,
            views.frame_places,
            self._point_frame,
            self._centres,
            self._radii,
            self._frames,
            views.com,
            self._grasp,
        )

    def _wrench(
        self, s: StandState, target: StandingTarget, q: FloatArray, v: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Return the wrench about the centre of mass that is wanted, and what the integral term takes up.

        Both are (6,) [N, N m]; the second is the stiffness of the PD law times the error.
        """
        return pd_wrench(
            self._views.rotation, self._rotation, q, v, target.position, target.velocity, target.acceleration,
            self._inertia_base, self.robot.mass, self._omega, self._omega_turn, GRAVITY, s.integral,
        )  # fmt: skip

    def _bounds(self, target: StandingTarget) -> tuple[FloatArray, FloatArray]:
        """Return the bounds on the normal force of every contact point; zero for feet in the air.

        While nothing changes the same arrays come back, so that an allocation can see that.
        """
        key = target.stance.tobytes() + target.load.tobytes()
        if key == self._bounds_of[0]:
            return self._bounds_of[1]
        foot = self.point_foot
        on = target.stance[foot]
        high = np.where(on, self.normal_max * np.maximum(target.load[foot], 1e-3), 0.0)
        low = np.where(on, self.normal_min * self._share, 0.0)
        bounds = (np.minimum(low, high), high)
        self._bounds_of = (key, bounds)
        return bounds

    def _attained(self, error: FloatArray) -> bool:
        """Return whether the forces give the wanted wrench, on a robot that is over its feet."""
        if self._views.rotation[2, 2] < FALLEN:
            return False
        x, y, z, a, b, c = error.tolist()
        return max(math.hypot(x, y, z), math.hypot(a, b, c) / self._height) <= self._tolerance

    def _accumulate(self, integral: FloatArray, pull: FloatArray) -> FloatArray:
        """Return the integral term (6,) after it has taken up a step of what the PD law leaves [N, N m]."""
        limit = self._integral_limit
        grown = integral + (self.dt / INTEGRAL_TIME) * pull
        return np.asarray(np.minimum(np.maximum(grown, -limit), limit))

    def _torques(
        self, target: StandingTarget, forces: FloatArray, points: FloatArray, q: FloatArray, v: FloatArray
    ) -> FloatArray:
        """Return the torques with which feet push at (p, 3) points [m], before limits: (joints,) [N m]."""
        torques = np.asarray(self._views.bias[6:] - self._carried(forces, points))
        if self._all_held and target.stance.all():
            return torques
        held = np.asarray(self._support[target.stance].any(axis=0))[6:]
        self._pin.crba(self._model, self._views.data, q)
        M = self._views.mass_matrix
        free = ~held
        for foot in np.flatnonzero(~target.stance):
            legs = self._support[foot][6:]
            free &= ~legs
            torques += self._swing(int(foot), target, M, v)
        diagonal = np.diag(M)[6:]
        hold = self._omega_joint**2 * (self._q[7:] - q[7:]) - 2.0 * self._omega_joint * v[6:]
        return np.asarray(np.where(free, torques + diagonal * hold, torques))

    def _carried(self, forces: FloatArray, points: FloatArray) -> FloatArray:
        """Return the joints' part of Jᵀ f for (p, 3) forces in contact frames at points: (joints,) [N m]."""
        rows = self._contact_rows
        contact_jacobian(self._views.twists, self._support, self.point_foot, points, self._frames, rows)
        return np.asarray(forces.ravel() @ rows[:, 6:])

    def _swing(self, foot: int, target: StandingTarget, M: FloatArray, v: FloatArray) -> FloatArray:
        """Return the torques that hold a lifted foot over its place: (joints,) [N m]."""
        pose = self._views.data.oMf[self._frame_ids[foot]]
        place = pose.act(self.robot.feet[foot].centre)
        normal = self._normals[foot]
        wanted = self._anchors[foot] + target.height[foot] * normal
        return foot_impedance(
            self._views.twists, self._support[foot], M, v, np.asarray(place), wanted - place,
            target.climb[foot] * normal, self._omega_swing,
        )  # fmt: skip


def default_normal_bounds(
    robot: Robot, normal_min: float | None = None, normal_max: float | None = None
) -> tuple[float, float]:
    """Return the bounds on a foot's normal force that suit a robot [N]; given ones are kept."""
    weight = robot.mass * GRAVITY
    low = min(NORMAL_MIN, LIGHT_SHARE * weight / len(robot.feet)) if normal_min is None else normal_min
    high = NORMAL_MAX_SHARE * weight if normal_max is None else normal_max
    return low, high


def standing_height(robot: Robot, q: FloatArray) -> float:
    """Return the height of the base over the feet at a configuration (nq,) [m], at least 5 cm."""
    return max(float(q[2] - robot.foot_positions(q)[:, 2].mean()), 0.05)


def wrench_weights(robot: Robot, q: FloatArray) -> FloatArray:
    """Return the (6,) weights of the wrench error: 1 for forces [-], 1 / height² for moments [1/m²]."""
    return np.array([1.0, 1.0, 1.0, *([standing_height(robot, q) ** -2] * 3)])
