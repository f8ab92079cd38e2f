"""The walking controller: gait, footholds, convex MPC and whole-body control, tied together.

Each millisecond: which feet carry (plan and touch), where the others should be, the motion that the last
plan predicts for now, and the torques that give it. Each `plan_interval`, and whenever a foot lifts or
lands, the MPC plans the forces of the next steps again. Every gain follows from the robot's mass, inertia,
leg length and foot places; nothing is tuned per robot.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from surefoot.arrays import BoolArray, FloatArray, real_number
from surefoot.contact import Status
from surefoot.control.controller import Command, Controller, RobotState
from surefoot.control.damping import computable
from surefoot.control.foothold import raibert
from surefoot.control.gait import ContactSchedule, Gait
from surefoot.control.gait_library import named_gait
from surefoot.control.load_adaptation import LoadAdaptation, LoadSettings
from surefoot.control.mpc import BodyState, ConvexMpc, MpcPlan, MpcWeights
from surefoot.control.walking_body import BodyPlan, VelocityCommand, limit_command
from surefoot.control.walking_feet import DESCENT, Feet
from surefoot.control.whole_body import Kinematics, Tasks, Weights, WholeBodyController
from surefoot.errors import ModelError, ProblemError
from surefoot.log.channels import CHANNELS
from surefoot.robot import Robot
from surefoot.spatial import GRAVITY, rotation_log
from surefoot.terrain import FlatTerrain, Terrain


@dataclass(frozen=True)
class WalkSettings:
    """How a robot walks; the defaults suit every robot.

    Attributes
    ----------
    mu
        Friction that the controller believes in.
    friction_share
        Share of `mu` that commanded forces may use; the rest is for what the model leaves out.
    start
        Time to stand before the gait begins [s].
    clearance
        Height of the swing over the ground, as a share of the height of the centre of mass.
    horizon
        Steps of the MPC.
    steps_per_period
        MPC steps in a cycle of the gait.
    plan_interval
        Longest time between plans [s].
    body_stiffness, swing_stiffness
        Natural frequencies of the feedback on the plan and of feet in the air, in units of sqrt(g / h).
    normal_min, normal_max
        Bounds on a carrying foot's normal force, as shares of m g.
    load
        What is made of an unknown payload and external wrench; None to observe none.
    """

    mu: float = 0.6
    friction_share: float = 0.9
    start: float = 0.3
    clearance: float = 0.22
    horizon: int = 10
    steps_per_period: int = 14
    plan_interval: float = 0.02
    body_stiffness: float = 2.0
    swing_stiffness: float = 8.0
    normal_min: float = 0.02
    normal_max: float = 1.5
    load: LoadSettings | None = field(default_factory=LoadSettings)
    mpc: MpcWeights = field(default_factory=MpcWeights)
    whole_body: Weights = field(default_factory=Weights)


@dataclass(frozen=True)
class WalkCommand(Command):
    """What the walking controller asks for at one step.

    Attributes
    ----------
    planned
        (n,) which feet the gait wants on the ground; `active` are those that push.
    frames
        (n, 3, 3) rotation_world_contact in which the forces are given.
    wanted
        (3,) velocity command after limits and ramp: forward, left, yaw rate.
    targets
        (n, 3) where feet in the air will touch, or last did.
    plan_status
        How the last MPC ended.
    load
        Values of the channels of `LoadAdaptation`.
    """

    planned: BoolArray
    frames: FloatArray
    wanted: FloatArray
    targets: FloatArray
    plan_status: Status
    load: Mapping[str, FloatArray] = field(default_factory=dict)

    def rows(self) -> dict[str, Any]:
        """Return which feet are planned on the ground, the wanted velocity, what is observed of a load."""
        return {"planned": self.planned, "command": self.wanted, **self.load}


class WalkingController(Controller):
    """Walks a robot on point feet; call `step` at a fixed rate.

    Parameters
    ----------
    robot
        With a floating base and two or more point feet.
    command
        Wanted velocity over time; slowed to what is possible, see `notes`.
    gait
        A name, or a schedule for the robot's feet.
    terrain
        The ground that the controller believes in; None for flat.
    settings
        See `WalkSettings`.
    dt
        Time between steps [s].

    Attributes
    ----------
    notes
        What was changed in the command, one line each.

    Raises
    ------
    ModelError
        If the robot cannot walk.
    ProblemError
        If the gait does not fit the robot's feet.
    """

    channels = tuple(CHANNELS[name] for name in ("planned", "command"))

    def __init__(
        self,
        robot: Robot,
        command: VelocityCommand,
        gait: str | ContactSchedule = "trot",
        terrain: Terrain | None = None,
        settings: WalkSettings | None = None,
        dt: float = 1e-3,
    ) -> None:
        if not robot.floating or len(robot.feet) < 2 or any(f.flat for f in robot.feet):
            raise ModelError(
                f"{robot.name} cannot walk here: it needs a free base and two or more point feet"
            )
        self.robot, self.dt = robot, real_number("dt", dt, low=1e-6)
        self.settings = settings or WalkSettings()
        self.terrain = FlatTerrain() if terrain is None else terrain
        self._measure()
        self.schedule = named_gait(gait, len(robot.feet), self._height) if isinstance(gait, str) else gait
        if self.schedule.feet != len(robot.feet):
            raise ProblemError(
                f"the gait is for {self.schedule.feet} feet, {robot.name} has {len(robot.feet)}"
            )
        self._set_timing()
        self.command, self.notes = limit_command(
            command, 0.55 * self._height, self._stance_time, self._height, self._radius
        )
        self._set_controllers()

    def _measure(self) -> None:
        """Read mass, inertia, height and foot places off the robot's nominal pose."""
        import pinocchio

        robot = self.robot
        q, data = robot.nominal, robot.model.createData()
        pinocchio.ccrba(robot.model, data, q, np.zeros(robot.model.nv))
        base = np.array(data.oMi[1].rotation)
        self._inertia = base.T @ np.array(data.Ig.inertia) @ base
        self._mass = robot.mass
        self._radii = np.array([f.radius for f in robot.feet])
        com, centres = robot.com(q), robot.foot_positions(q)
        self._height = float(com[2] - (centres[:, 2] - self._radii).mean())
        offsets = (centres - com) @ base
        self._offsets = offsets - np.array([*offsets[:, :2].mean(axis=0), 0.0])
        self._radius = float(np.linalg.norm(self._offsets[:, :2], axis=1).max())
        self._pendulum = math.sqrt(GRAVITY / self._height)

    def _set_timing(self) -> None:
        """Derive the MPC's step and the stance time from the gait."""
        schedule = self.schedule
        if isinstance(schedule, Gait):
            period = schedule.period
            self._stance_time = schedule.stance_time if schedule.swing_time > 0.0 else period
        else:
            period = 0.4 * math.sqrt(self._height / 0.3)
            self._stance_time = 0.55 * period
        self._mpc_dt = period / self.settings.steps_per_period
        self._interval = min(self.settings.plan_interval, self._mpc_dt)

    def _set_controllers(self) -> None:
        """Make the MPC and the whole-body controller."""
        s, weight = self.settings, self._mass * GRAVITY
        mu = s.mu * s.friction_share
        low, high = s.normal_min * weight, s.normal_max * weight
        self.mpc = ConvexMpc(
            self._mass, self._inertia, len(self.robot.feet), s.horizon, self._mpc_dt, mu, low, high, s.mpc
        )
        self.whole_body = WholeBodyController(
            self.robot, mu, low, high, s.whole_body, baumgarte=(0.0, 2.0 * self._pendulum)
        )
        self._body_gain = (s.body_stiffness * self._pendulum) ** 2, 2.0 * s.body_stiffness * self._pendulum
        self._swing_gain = (s.swing_stiffness * self._pendulum) ** 2, 2.0 * s.swing_stiffness * self._pendulum
        self.facts = {
            "kind": "walk", "normal_min": low, "normal_max": high, "mu_controller": s.mu,
            "gait": getattr(self.schedule, "name", "schedule"), "notes": list(self.notes),
        }  # fmt: skip
        self._load = LoadAdaptation(self.robot, self.dt, self.mpc, self.whole_body, s.load)
        self.channels = (*type(self).channels, *self._load.channels)
        self._still = np.zeros(self.robot.joints)
        self._level = np.zeros(len(self.robot.feet))
        self.reset()

    def reset(self) -> None:
        """Forget the past: the next step begins a walk from where the robot stands."""
        self.mpc.reset()
        self.whole_body.reset()
        self._load.reset()
        self.feet: Feet | None = None
        self._planned_at = -math.inf
        self._plan: MpcPlan | None = None
        self._last: WalkCommand | None = None

    def step(self, state: RobotState) -> WalkCommand:
        """Return the command for a state; where no foot feels, the gait's plan is taken for the contacts.

        Never raises on a hard instance; see `WholeBodyCommand.feasible`. A state that is not finite, or too
        large to compute with, gets a command that slows the joints, and changes nothing else.
        """
        time = state.time
        if not computable(state.q, state.v):
            return self._blind(state.v)
        due = time - self._planned_at >= self._interval - 0.5 * self.dt
        self._load.observe(state)
        if due:
            self._load.tell(None if self.feet is None else self.body)
        now = self.whole_body.update(state.q, state.v)
        if self.feet is None:
            self._begin(now)
        assert self.feet is not None
        feet, clock = self.feet, time - self.settings.start
        felt = feet.planned.copy() if state.contact is None else state.contact
        changed = clock >= 0.0 and feet.update(clock, felt, now.centres)
        self.body.advance(self._wish(clock), now.com, self.dt)
        self._load.pull(now, state.q[:3])
        if due:
            self.body.fit_ground(feet.ground, min(time - self._planned_at, 1.0))
            self._aim(now, clock)
        if due or changed:
            self._replan(now, clock, time)
        body = self.whole_body.solve(self._tasks(now, clock, time))
        self._load.acted(time, state.v, body.torques, feet.carrying)
        assert self._plan is not None
        self._last = WalkCommand(
            body.torques, body.forces, feet.carrying.copy(), body.feasible, body.status, feet.planned.copy(),
            feet.frames.copy(), self.body.velocity.copy(), feet.target.copy(), self._plan.status,
            self._load.rows(),
        )  # fmt: skip
        return self._last

    def _blind(self, v: FloatArray) -> WalkCommand:
        """Return the command for a state that is not finite."""
        body, n = self.whole_body.damping(v), len(self.robot.feet)
        on = np.ones(n, dtype=bool)
        last = self._last or WalkCommand(
            body.torques, body.forces, on, False, body.status, on, np.tile(np.eye(3), (n, 1, 1)), np.zeros(3),
            np.zeros((n, 3)), Status.INVALID, self._load.rows(),
        )  # fmt: skip
        return replace(
            last, torques=body.torques, forces=body.forces, attained=body.feasible, status=body.status
        )

    def _begin(self, now: Kinematics) -> None:
        """Start from where the robot stands."""
        clearance = self.settings.clearance * self._height
        descent = DESCENT * math.sqrt(GRAVITY * self._height)
        self.feet = Feet(self.schedule, self.terrain, self._radii, clearance, descent, now.centres.copy())
        yaw = math.atan2(now.rotation[1, 0], now.rotation[0, 0])
        self.body = BodyPlan(self._height, now.com.copy(), yaw)
        self.body.fit_ground(self.feet.ground, math.inf)

    def _wish(self, clock: float) -> FloatArray:
        """Return the wanted velocity: none before the gait begins."""
        return self.command.at(clock) if clock >= 0.0 else np.zeros(3)

    def _aim(self, now: Kinematics, clock: float) -> None:
        """Choose the footholds of feet in the air."""
        feet = self.feet
        assert feet is not None
        turn = float(self.body.velocity[2])
        for k in np.flatnonzero(~feet.carrying & ~feet.planned):
            _, _, end = self.schedule.phase(int(k), clock)
            left = max(end - clock, 0.0)
            yaw, _, flow = self.body.places(np.array([left]))
            hip = now.com[:2] + left * flow[0, :2] + self._hip(int(k), float(yaw[0]))
            place = raibert(
                hip, now.com_velocity[:2], flow[0, :2], turn, self._height, self._stance_time
            ) + self._turn_lead(int(k), float(yaw[0]), turn)
            feet.aim(int(k), place)

    def _hip(self, k: int, yaw: float) -> FloatArray:
        """Return where a foot belongs around the centre of mass at a heading: (2,)."""
        c, s = math.cos(yaw), math.sin(yaw)
        x, y = self._offsets[k, :2]
        return np.array([c * x - s * y, s * x + c * y])

    def _turn_lead(self, k: int, yaw: float, turn: float) -> FloatArray:
        """Return how far ahead a foot goes because the body turns over it while it carries: (2,)."""
        x, y = self._hip(k, yaw)
        return 0.5 * self._stance_time * turn * np.array([-y, x])

    def _replan(self, now: Kinematics, clock: float, time: float) -> None:
        """Run the MPC for the feet's schedule from now on."""
        feet = self.feet
        assert feet is not None
        N, dt = self.settings.horizon, self._mpc_dt
        contacts = self.schedule.horizon(clock, dt, N)
        if clock < 0.0:
            contacts[clock + dt * (np.arange(N) + 0.5) < 0.0] = True
        contacts[0] = feet.carrying
        for k in np.flatnonzero(feet.carrying & ~feet.planned):  # landed early: carries on
            later = np.flatnonzero(contacts[1:, k])
            contacts[: 1 + (later[0] if len(later) else 0), k] = True
        reference = self.body.reference(N, dt)
        places = self._foot_places(contacts, reference.position)
        state = BodyState(now.rotation, now.com, now.com_velocity, now.angular_velocity)
        self.mpc.shift(max(time - self._planned_at, 0.0) if math.isfinite(self._planned_at) else 0.0)
        self._plan = self.mpc.solve(state, reference, places, contacts, feet.frames)
        self._planned_at = time
        self._from = now

    def _foot_places(self, contacts: BoolArray, com: FloatArray) -> FloatArray:
        """Return where each foot stands in each step of the horizon: (N, n, 3)."""
        feet, dt = self.feet, self._mpc_dt
        assert feet is not None
        N, n = contacts.shape
        places = np.empty((N, n, 3))
        for k in range(n):
            carrying = bool(feet.carrying[k])
            place = feet.ground[k] if carrying else feet.target[k] - self._radii[k] * feet.frames[k, :, 2]
            flown = False
            for i in range(N):
                if contacts[i, k] and i and not contacts[i - 1, k]:
                    if carrying or flown:  # a stance after the coming swing
                        middle = min(i + round(0.5 * self._stance_time / dt), N)
                        yaw = self.body.yaw + self.body.velocity[2] * middle * dt
                        xy = com[middle, :2] + self._hip(k, yaw)
                        place = np.array(
                            [*xy, self.body.ground + (xy - self.body.position[:2]) @ self.body.slope]
                        )
                    flown = True
                places[i, k] = place
        return places

    def _tasks(self, now: Kinematics, clock: float, time: float) -> Tasks:
        """Return the whole-body tasks: the plan's motion now, feedback on it, and the feet in the air."""
        feet, plan, begin = self.feet, self._plan, self._from
        assert feet is not None
        assert plan is not None
        t, dt = time - self._planned_at, self._mpc_dt
        acceleration = (plan.linear_velocity[1] - plan.linear_velocity[0]) / dt
        turning = (plan.angular_velocity[1] - plan.angular_velocity[0]) / dt
        kp, kd = self._body_gain
        miss = begin.com + t * begin.com_velocity + 0.5 * t * t * acceleration - now.com
        com = acceleration + kp * miss + kd * (begin.com_velocity + t * acceleration - now.com_velocity)
        turned = rotation_log(now.rotation @ begin.rotation.T) if t > 0.0 else np.zeros(3)
        spin = begin.angular_velocity
        turn = turning + kp * (t * spin + 0.5 * t * t * turning - turned)
        turn += kd * (spin + t * turning - now.angular_velocity)
        wanted = np.zeros((len(feet.radii), 6))
        ks, ds = self._swing_gain
        for k in np.flatnonzero(~feet.carrying):
            place, speed, rate = feet.motion(int(k), clock)
            wanted[k, :3] = rate + ks * (place - now.centres[k]) + ds * (speed - now.twists[k, :3])
        return Tasks(
            feet.carrying, com, turn, wanted, self._still, plan.first, feet.frames, self._level
        )  # fmt: skip
