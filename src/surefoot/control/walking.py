"""The walking controller: gait, footholds, convex MPC and whole-body control, tied together.

Each millisecond: which feet carry (plan and touch), where the others should be, the motion that the last
plan predicts for now, and the torques that give it. Each `plan_interval`, and whenever a foot lifts or
lands, the MPC plans the forces of the next steps again. Every gain follows from the robot's mass, inertia,
leg length and foot places; nothing is tuned per robot.
"""

from __future__ import annotations

import math

import numpy as np

from surefoot.arrays import FloatArray, real_number
from surefoot.control.adaptive_gait import AdaptiveGait
from surefoot.control.believed_limits import BelievedLimits
from surefoot.control.controller import RobotState
from surefoot.control.damping import computable
from surefoot.control.foothold import step_place
from surefoot.control.force_planner import ForcePlanner
from surefoot.control.force_ramps import ForceRamps
from surefoot.control.gait import ContactSchedule, Gait
from surefoot.control.gait_choice import Body, choose_gait
from surefoot.control.grip import Grip
from surefoot.control.ground_sense import ground_sense
from surefoot.control.load_adaptation import LoadAdaptation
from surefoot.control.look_ahead import plane_ahead
from surefoot.control.step_phase import StepPhase
from surefoot.control.terrain_knowledge import GroundBelief
from surefoot.control.walker import Walker
from surefoot.control.walking_body import DIP, BodyPlan, VelocityCommand, first_stance
from surefoot.control.walking_feet import DESCENT, Feet
from surefoot.control.walking_kernels import follow
from surefoot.control.walking_settings import WalkCommand as WalkCommand
from surefoot.control.walking_settings import WalkSettings as WalkSettings
from surefoot.control.whole_body import Kinematics, Tasks
from surefoot.errors import ModelError
from surefoot.robot import Robot
from surefoot.spatial import GRAVITY
from surefoot.terrain import FlatTerrain, Terrain

UNREST = 0.1
"""A body that should stand but moves faster than this share of sqrt(g h) takes steps, if its gait may."""

APPROACH = 0.1
"""Share of its speed with which a body comes near to steps, until its gait is in step with them."""
LEAD = 1.15
"""A body goes faster once its gait is fit for this multiple of its speed."""


class WalkingController(Walker):
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

    settings: WalkSettings

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
        mu = self.settings.mu * self.settings.friction_share
        body = Body(robot, self._height, self.settings.clearance * self._height, self.terrain, mu)
        chosen = choose_gait(body, command, gait)
        self.schedule, self.command, self.notes = chosen.schedule, chosen.command, chosen.notes
        self._limit = chosen.limit
        self._set_timing(chosen.shortest)
        self._set_parts(mu)

    def _measure(self) -> None:
        """Read mass, inertia, height and foot places off the robot's nominal pose."""
        import pinocchio

        robot = self.robot
        q, data = robot.nominal, robot.model.createData()
        pinocchio.ccrba(robot.model, data, q, np.zeros(robot.model.nv))
        base = np.array(data.oMi[1].rotation)
        self._inertia = base.T @ np.array(data.Ig.inertia) @ base
        self._radii = np.array([f.radius for f in robot.feet])
        com, centres = robot.com(q), robot.foot_positions(q)
        self._height = float(com[2] - (centres[:, 2] - self._radii).mean())
        offsets = (centres - com) @ base
        self._offsets = offsets - np.array([*offsets[:, :2].mean(axis=0), 0.0])
        self._radius = float(np.linalg.norm(self._offsets[:, :2], axis=1).max())
        self._pendulum = math.sqrt(GRAVITY / self._height)

    def _set_timing(self, shortest: float) -> None:
        """Derive the MPC's step and the stance time from the gait."""
        schedule = self.schedule
        if isinstance(schedule, Gait):
            period = schedule.period
            self._stance_time = schedule.stance_time if schedule.swing_time > 0.0 else period
        elif isinstance(schedule, AdaptiveGait):
            period, self._stance_time = shortest, schedule.stance_time
        else:
            period = 0.4 * math.sqrt(self._height / 0.3)
            self._stance_time = 0.55 * period
        self._mpc_dt = period / self.settings.steps_per_period
        self._interval = min(self.settings.plan_interval, self._mpc_dt)

    def _set_parts(self, mu: float) -> None:
        """Make what gives the forces, and what looks after friction, ground and load."""
        s, weight = self.settings, self.robot.mass * GRAVITY
        rates = 0.0, 2.0 * self._pendulum
        self._normals = self._set_controllers(self._inertia, self._mpc_dt, self._pendulum, rates)
        self._grip = Grip(self._radii, weight, self._height, self.dt, s.mu) if s.watch_friction else None
        clearance = s.clearance * self._height
        self._steps = None
        seen = self.terrain.highest_step > 0.0 or self.terrain.learns
        if isinstance(self.schedule, (Gait, AdaptiveGait)) and seen:
            margin = 2.0 * float(self._radii.mean())
            self._steps = StepPhase(self.terrain, self.schedule, self._offsets, margin)
        self._sense = ground_sense(self.terrain, weight, self._height, clearance, self.dt, self.notes)
        self._believed = (
            None
            if self._sense is None
            else BelievedLimits(self._sense.belief, mu, self._height, self._radius, self.schedule, self.dt)
        )
        self._load = LoadAdaptation(self.robot, self.dt, self.mpc, self.whole_body, s.load)
        self.channels = (*type(self).channels, *self._load.channels)
        self._still = np.zeros(self.robot.joints)
        self._level = np.zeros(len(self.robot.feet))
        self._now = np.zeros((3, 3))
        self.planner = ForcePlanner(self.mpc, self._offsets, self._radii, self.dt)
        self.reset()

    def reset(self) -> None:
        """Forget the past: the next step begins a walk from where the robot stands."""
        self.planner.reset()
        self.whole_body.reset()
        gait = self.schedule if isinstance(self.schedule, AdaptiveGait) else None
        for part in (self._grip, self._load, self._steps, self._believed, gait):
            if part is not None:
                part.reset()
        self.feet: Feet | None = None
        self.ramps = ForceRamps(self.schedule, self.settings.ramp / self._pendulum)
        self._aimed_at = -math.inf
        self._held = False  # the gait does not follow the speed fast enough
        self._untold = True  # what has been learned of the load since it was told
        self._aimless = False  # a foot has just lifted, and does not know yet where it goes
        self._last = None

    def step(self, state: RobotState) -> WalkCommand:
        """Return the command for a state; where no foot feels, the gait's plan is taken for the contacts.

        Never raises on a hard instance; see `WholeBodyCommand.feasible`. A state that is not finite, or too
        large to compute with, gets a command that slows the joints, and changes nothing else.
        """
        time = state.time
        if not computable(state.q, state.v):
            return self._blind(state.v, self._load.rows)
        late = self._interval - 0.5 * self.dt
        due = time - self.planner.begun >= late
        self._load.observe(state)
        if self._untold and not (
            due or self.planner.pending
        ):  # in a step without a plan and without footholds
            self._load.tell(None if self.feet is None else self.body)
            self._untold = False
        now = self.whole_body.update(state.q, state.v)
        if self.feet is None:
            self._begin(now, state)
        assert self.feet is not None
        feet, clock = self.feet, time - self.settings.start - self.feet.wait
        sensed = feet.planned.copy() if state.contact is None else state.contact
        if self._sense is not None:
            sensed = self._sense.feel(state, feet, sensed, clock, now.centres, now.twists)
        changed = clock >= 0.0 and feet.update(clock, sensed, now.centres)
        if self._sense is not None:
            self._sense.learn(state, feet, now, clock)
        if self._believed is not None:
            self._believed.learn()
        if self._grip is not None:
            self._mind_friction(self._grip, state, now)
        self.body.advance(self._wanted(clock), now.com, self.dt)
        self._load.pull(now, state.q[:3])
        low, high = self._normals
        top = high * self.ramps.now(clock, feet.carrying, sensed)
        self.whole_body.bound_normals(np.minimum(low, top), top)
        if changed or due:
            self.planner.set_up(time, clock, feet, self.body, self.ramps, self._stance_time)
            self._aimless |= changed
            if self.planner.forces is None:
                self._plan_forces(now, time)
        elif self.planner.pending:
            self._plan_forces(now, time)
        elif self._aimless or time - self._aimed_at >= late:  # never in the step of a plan, which takes long
            self._aim(now, clock, time)
            self._untold = True
        body = self.whole_body.solve(self._tasks(now, clock, time))
        self._load.acted(time, body.torques, feet.carrying)
        return self._commanded(body, feet, self._load.rows)

    def _begin(self, now: Kinematics, state: RobotState) -> None:
        """Start from where the robot stands."""
        if self._sense is not None:
            self._sense.begin(state, now.centres, self._radii)
        clearance = self.settings.clearance * self._height
        descent = DESCENT * math.sqrt(GRAVITY * self._height)
        self.feet = Feet(self.schedule, self.terrain, self._radii, clearance, descent, now.centres.copy())
        yaw = math.atan2(now.rotation[1, 0], now.rotation[0, 0])
        dip = 0.0 if self.terrain.planar else DIP
        self.body = BodyPlan(self._height, now.com.copy(), yaw, dip=dip, stance=first_stance(self.schedule))
        self._follow_ground(math.inf)

    @property
    def _feeling(self) -> GroundBelief | None:
        """The ground while feet feel for steps on it, else None."""
        return self._sense.belief if self._sense is not None and self._sense.belief.unsure else None

    def _follow_ground(self, elapsed: float) -> None:
        """Let the body follow the ground, `elapsed` after the last time [s]."""
        feet, body = self.feet, self.body
        assert feet is not None
        if self.terrain.planar or self._feeling is not None:
            body.fit_ground(feet.ground, elapsed)
            return
        plane = plane_ahead(self.terrain, body.position[:2], body.yaw, body.flow(), self._height)
        body.follow_plane(*plane, elapsed)

    def _asked(self, clock: float) -> FloatArray:
        """Return the velocity of the command, slowed to what the ground allows as it is believed now."""
        command = self.command.at(clock)
        return command if self._believed is None else self._believed.limit(command)

    def _wanted(self, clock: float) -> FloatArray:
        """Return the wanted velocity: none before the gait begins, none higher until it is fit for it."""
        command, now = self._asked(clock) if clock >= 0.0 else np.zeros(3), self.body.velocity
        if self._held and float(command @ command) > float(now @ now):
            command = now.copy()
        waiting = self._steps is not None and self._steps.waiting
        if self._feeling is not None:
            command = self._feeling.pace * command
        elif waiting or (isinstance(self.schedule, AdaptiveGait) and self.schedule.turning):
            command = APPROACH * command
        if self._steps is not None:
            pace = self._steps.pace(math.hypot(command[0], command[1]), self.dt)
            command = command * [pace, pace, 1.0]
        return command if self._grip is None else self._grip.limit(command)

    def _mind_friction(self, grip: Grip, state: RobotState, now: Kinematics) -> None:
        """Believe in the friction that the feet have found."""
        assert self.feet is not None
        mu = grip.update(state.forces, now, self.feet.frames, self.feet.carrying)
        self.whole_body.set_friction(self.settings.friction_share * mu)
        self.body.acceleration = min(self.body.change, grip.acceleration)

    def _aim(self, now: Kinematics, clock: float, time: float) -> None:
        """Follow the ground, and choose the footholds of feet in the air."""
        feet = self.feet
        assert feet is not None
        self._follow_ground(min(time - self._aimed_at, 1.0))
        self._aimed_at, self._aimless = time, False
        if isinstance(self.schedule, AdaptiveGait):
            self._pace(self.schedule, now, clock)
        if self._steps is not None and clock >= 0.0:
            self._steps.look(self.body, clock, self._feeling is not None)
            feet.stride = self._steps.stride
        for k in np.flatnonzero(~(feet.carrying | feet.planned)).tolist():
            _, _, end = self.schedule.phase(k, clock)
            place = step_place(
                now.com, now.com_velocity, self._offsets[k], self.body.yaw, self.body.velocity,
                max(end - clock, 0.0), self._height, self._stance_time,
            )  # fmt: skip
            if self._feeling is not None:
                place = self._feeling.feel_ahead(place, feet.start[k], float(feet.duration[k]))
            feet.aim(k, place)

    def _pace(self, schedule: AdaptiveGait, now: Kinematics, clock: float) -> None:
        """Let the gait follow the speed: the wanted one where that will be higher, else that of now."""
        assert self.feet is not None
        command, own = self._asked(max(clock, 0.0)), self.body.velocity
        if self._steps is not None:
            own = self._steps.unhurried(own, command)
        wanted = max(command, own, key=lambda v: float(v @ v))
        drift = now.com_velocity * [1.0, 1.0, 0.0]
        if not wanted.any() and float(np.linalg.norm(drift)) > UNREST * math.sqrt(GRAVITY * self._height):
            wanted = drift
        schedule.update(max(clock, 0.0), wanted)
        self._stance_time, self.feet.clearance = schedule.stance_time, schedule.pace.clearance
        stride = schedule.wanted  # in step with the ground it is long, and the horizon with it
        step = stride.pace.period / self.settings.steps_per_period if stride.in_step else self._mpc_dt
        if abs(step / self.mpc.dt - 1.0) > 1e-3:
            self.mpc.pace(step)
        self._held = not schedule.fits(LEAD * self.body.velocity)

    def _plan_forces(self, now: Kinematics, time: float) -> None:
        """Run the MPC on what has been set up."""
        assert self.feet is not None
        mu = None if self._grip is None else self.settings.friction_share * self._grip.mu
        self.planner.solve(time, now, self.feet.frames, mu)

    def _tasks(self, now: Kinematics, clock: float, time: float) -> Tasks:
        """Return the whole-body tasks: the plan's motion now, feedback on it, and the feet in the air."""
        feet, planner = self.feet, self.planner
        assert feet is not None
        assert planner.forces is not None
        self._now[0], self._now[1], self._now[2] = now.com, now.com_velocity, now.angular_velocity
        com, turn = follow(
            planner.motion, planner.rotation, time - planner.made, self._now, now.rotation, *self._body_gain
        )
        wanted = feet.accelerations(clock, now.centres, now.twists, self._swing_gain)
        return Tasks(
            feet.carrying, com, turn, wanted, self._still, planner.forces, feet.frames, self._level
        )  # fmt: skip
