"""Walking on point feet: gait, footholds, convex MPC and whole-body control.

Each `plan_interval`, and whenever a foot lifts or lands, the MPC plans the forces of the next steps again.
Every gain scales with the robot's mass, inertia, leg length and foot places. No number is for one robot
alone, but most were chosen on Go2 (docs/settings.md).
The tick itself is `surefoot.motion.walking.tick.Tick.step`.
"""

from __future__ import annotations

import math

import numpy as np

from surefoot.base.arrays import FloatArray, of_kind, real_number
from surefoot.base.memory import Remembering
from surefoot.base.spatial import GRAVITY
from surefoot.mechanics import FlatTerrain, Robot, Terrain, composite_inertia
from surefoot.motion.control.controller import RobotState
from surefoot.motion.control.posture import Posture
from surefoot.motion.control.whole_body_tasks import ForceLimits, Kinematics, Tasks
from surefoot.motion.gaits.contact_schedule import ContactSchedule
from surefoot.motion.ground.ground_belief import believed
from surefoot.motion.ground.plane_ahead import plane_ahead
from surefoot.motion.walking.behaviours.arbiter import EVERYTHING
from surefoot.motion.walking.behaviours.behaviour import Request
from surefoot.motion.walking.body_settings import BODY_MOTION
from surefoot.motion.walking.command_limits import LeggedBody
from surefoot.motion.walking.feet_settings import FEET
from surefoot.motion.walking.foot_phases import FeetContact
from surefoot.motion.walking.foothold import catching_place, step_place
from surefoot.motion.walking.force_planner import ForcePlanner, Ramps
from surefoot.motion.walking.gait_choice import choose_gait
from surefoot.motion.walking.gait_clock import GaitClock
from surefoot.motion.walking.leaping import leap, unease
from surefoot.motion.walking.load_adaptation import LoadAdaptation
from surefoot.motion.walking.pace_settings import STAIR_GAIT, STAIR_PHASE
from surefoot.motion.walking.stair_phase import StepPhase
from surefoot.motion.walking.touchdown_detection import TouchMemory, TouchSense
from surefoot.motion.walking.walk_state import BipedState, GaitState, PlanTimes, StepInput, WalkState
from surefoot.motion.walking.walkable import check_point_feet
from surefoot.motion.walking.walker import Walker, check_walk
from surefoot.motion.walking.walking_body import BodyPlan, VelocityCommand, first_stance, granted_share
from surefoot.motion.walking.walking_feet import Feet, FeetModel, SwingRequest
from surefoot.motion.walking.walking_kernels import follow
from surefoot.motion.walking.walking_settings import WalkCommand as WalkCommand
from surefoot.motion.walking.walking_settings import WalkSettings as WalkSettings


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
        of_kind("robot", robot, Robot)
        check_walk(command, terrain, settings, WalkSettings)
        check_point_feet(robot)
        self.robot, self.dt = robot, real_number("dt", dt, low=1e-6)
        self.settings = s = settings or WalkSettings()
        self.terrain = FlatTerrain() if terrain is None else terrain
        self.start = s.start
        inertia, offsets, radii = self._measure()
        body = LeggedBody(
            robot, self.height, s.clearance * self.height, self.terrain, s.mu * s.friction_share
        )
        chosen = choose_gait(body, command, gait)
        self.schedule, self.command, self.notes = chosen.schedule, chosen.command, chosen.notes
        self.granted = granted_share(command, self.command)
        self._limits = chosen.limits
        period = chosen.shortest or self.settings.horizon_period * math.sqrt(self.height / 0.3)
        self._stance_time = self.schedule.stance_time or self.settings.horizon_stance * period
        self._mpc_dt = period / s.steps_per_period
        self._interval = min(s.plan_interval, self._mpc_dt) - 0.5 * self.dt
        self._set_parts(inertia, offsets, radii, chosen.shortest > 0.0)

    def _measure(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return inertia (3, 3) [kg m²], places (n, 3) and radii (n,) of feet [m] in the nominal pose."""
        robot, q = self.robot, self.robot.nominal
        inertia, _, base = composite_inertia(robot, q)
        radii = np.array([f.radius for f in robot.feet])
        com, centres = robot.com(q), robot.foot_positions(q)
        self.height = float(com[2] - (centres[:, 2] - radii).mean())
        offsets = (centres - com) @ base
        return inertia, offsets - np.array([*offsets[:, :2].mean(axis=0), 0.0]), radii

    def _set_parts(self, inertia: FloatArray, offsets: FloatArray, radii: FloatArray, cyclic: bool) -> None:
        """Make what gives the forces, and what looks after ground, steps and load."""
        s, weight = self.settings, self.robot.mass * GRAVITY
        self._set_controllers(inertia, self._mpc_dt, (0.0, 2.0 * self._pendulum))
        posture = Posture(self.robot, self.settings.held_stiffness * self._pendulum, swing=0.0)
        self._posture = posture if posture.free.any() else None
        radius = float(np.linalg.norm(offsets[:, :2], axis=1).max())
        self._set_behaviours(radii, radius, s.watch_friction)
        self._steps = None
        in_step = cyclic and STAIR_GAIT.used and STAIR_PHASE.used
        if in_step and (self.terrain.highest_step > 0.0 or self.terrain.learns):
            margin = 2.0 * float(radii.mean())
            self._steps = StepPhase(self.terrain, self.schedule, offsets, margin)
        clearance, descent = s.clearance * self.height, FEET.descent * math.sqrt(GRAVITY * self.height)
        self._feet_model = FeetModel(self.terrain, radii, clearance, descent)
        belief = believed(self.terrain)
        self._still, self._no_gaps = np.zeros(self.robot.joints), np.zeros(len(radii))
        self._touch = None
        if belief is not None:
            self._touch = TouchSense(belief, weight, self.height, self._feet_model, self.dt)
        self.load = None
        if s.watch_load:
            self.load = LoadAdaptation(self.robot, self.dt, self.mpc, self.whole_body)
        self.planner = ForcePlanner(self.mpc, offsets, radii, self.dt, s.ramp / self._pendulum)
        self.reset()

    def _honoured(self) -> frozenset[str]:
        """See `Walker`: late feet are looked after where touch is watched, the clock where a gait adapts."""
        deaf = set() if self.terrain.learns else {"search", "hold"}
        return EVERYTHING - deaf - (set() if self.schedule.adapts else {"step_times", "hold"})

    def _limit(self, wanted: VelocityCommand) -> VelocityCommand:
        """See `Walker`."""
        return wanted if self._limits is None else self._limits.slowed(wanted)

    def reset(self) -> None:
        """Forget the past: the next step begins a walk from where the robot stands."""
        for part in (self.mpc, self.whole_body, self.load, self._steps, self.schedule, self.arbiter):
            if part is not None:
                part.reset()
        if self.mpc.dt != self._mpc_dt:  # in step with stairs its steps are longer
            self.mpc.pace(self._mpc_dt)
        self._walk = self._outstanding = None

    def _followed(self, gait: GaitState) -> ContactSchedule:
        """Return the schedule that the feet follow now."""
        return self.schedule if gait.leap is None else gait.leap

    def _parts(self) -> dict[str, Remembering | None]:
        """See `Tick`; the ground comes first, for a behaviour may refer to what it remembers."""
        belief = believed(self.terrain)
        return {
            "ground": belief, "limits": self._limits, "schedule": self.schedule, "mpc": self.mpc,
            "whole_body": self.whole_body, "load": self.load, "steps": self._steps, "posture": self._posture,
            "arbiter": self.arbiter,
        }  # fmt: skip

    @property
    def _waiting(self) -> bool:  # type: ignore[override]
        """Whether the body waits to set off onto steps."""
        return self._steps is not None and self._steps.waiting

    def _observe_load(self, measured: RobotState) -> None:
        """Learn of the load; bring the models up in a step without a plan and without footholds."""
        if self.load is None:
            return
        self.load.observe(measured)
        s = self._walk
        if s is None:
            return
        due = measured.time - s.times.begun >= self._interval or s.horizon is not None
        if s.times.load_waits and not due:
            self.load.update_models(s.body)
            self._walk = s._replace(times=s.times._replace(load_waits=False))

    def _begin(self, now: Kinematics, measured: RobotState) -> WalkState:
        """Return the state of a walk that begins where the robot stands."""
        touch = None if self._touch is None else self._touch.begin(measured, now.centres)
        feet = self._feet_model.standing(now.centres)
        yaw = math.atan2(now.rotation[1, 0], now.rotation[0, 0])
        dip = 0.0 if self.terrain.planar else BODY_MOTION.dip
        body = BodyPlan(
            self.height, now.com.copy(), yaw, swerve=self._swerve(now, measured, yaw), dip=dip,
            stance=first_stance(self.schedule),
        )  # fmt: skip
        if self._posture is not None:
            self._posture.hold(measured.q)
        self._follow_ground(body, feet, math.inf)
        gait = GaitState(self._stance_time)
        return WalkState(GaitClock(-self.start), gait, feet, body, Ramps.of(len(feet.foot)), touch)

    def _classify_contact(
        self, s: WalkState, measured: RobotState, now: Kinematics, clock: GaitClock
    ) -> tuple[TouchMemory | None, Feet, FeetContact]:
        """See `Tick`; on estimated terrain a detected contact may be false."""
        if self._touch is None or s.touch is None:
            return super()._classify_contact(s, measured, now, clock)
        touch, feet = self._touch.seek(s.touch, measured, s.feet, clock)
        if not touch.hold:
            self._followed(s.gait).release()
        elif clock.time >= 0.0:
            self._followed(s.gait).hold(clock.time)
        sensed = feet.planned if measured.contact is None else measured.contact
        touch, contact = self._touch.classify(touch, measured, feet, sensed, clock, now)
        return touch, feet, contact

    def _advance_feet(
        self, s: WalkState, feet: Feet, contact: FeetContact, now: Kinematics, clock: GaitClock
    ) -> tuple[Feet, BipedState | None, bool]:
        """See `Tick`; before the gait begins all feet stand."""
        if clock.time < 0.0:
            return feet, None, False
        careful = s.touch is not None and s.touch.search.careful
        schedule = self._followed(s.gait)
        feet, changed = self._feet_model.advance(feet, schedule, clock, contact, now.centres, careful)
        return feet, None, changed

    def _learn_ground(
        self, s: WalkState, touch: TouchMemory | None, feet: Feet, measured: RobotState, now: Kinematics,
        clock: GaitClock,
    ) -> tuple[TouchMemory | None, Feet, bool]:  # fmt: skip
        """See `Tick`."""
        if self._touch is None or touch is None:
            return touch, feet, False
        return self._touch.learn(touch, measured, feet, self._followed(s.gait), clock, now)

    def _move(
        self, s: WalkState, feet: Feet, request: Request, now: Kinematics, clock: GaitClock, waits: bool
    ) -> tuple[GaitClock, GaitState, Feet, PlanTimes]:
        """See `Tick`."""
        velocity, recovery, body, times = self.arbiter.velocity, request.recovery, s.body, s.times
        if self._steps is not None:
            pace = self._steps.pace(math.hypot(velocity[0], velocity[1]), self.dt)
            velocity = velocity * [pace, pace, 1.0]
        gait = s.gait
        if recovery is not None or gait.leap is not None:
            wanted, unit = recovery is not None and recovery.leaps, 1.0 / self._pendulum
            gait, feet = leap(gait, feet, wanted, self._feet_model, self.schedule, clock, now.centres, unit)
            if gait is not s.gait:
                times = times._replace(begun=-math.inf)
        rate = 1.0 if recovery is None or gait.leap is not None else recovery.rate
        feet = self._feet_model.hurried(feet, clock.rate, rate)
        clock = clock.advanced(self.dt, rate, waits)
        if recovery is None:
            change = min(body.change, request.acceleration)
            body.advance(velocity, now.com, self.dt, change, request.height)
        else:
            body.advance(velocity, now.com, self.dt, recovery.acceleration, request.height, recovery.velocity)
        return clock, gait, feet, times

    def _limit_forces(
        self, ramps: Ramps, gait: GaitState, clock: GaitClock, feet: Feet, request: Request,
        measured: RobotState, now: Kinematics, contact: FeetContact,
    ) -> tuple[Ramps, ForceLimits]:  # fmt: skip
        """Return this step's friction, normal-force bounds by the ramps of the feet, and external wrench."""
        outside = None if self.load is None else self.load.pull(now, measured.q[:3])
        low, high = self._normals
        schedule, stance = self._followed(gait), feet.stance
        ramps, shares = self.planner.shares(ramps, schedule, clock, stance, contact.touching)
        swing = 1.0 if gait.leap is None or stance.any() else self.settings.flying_weight
        return ramps, ForceLimits(request.mu, low, high * shares, outside, swing)

    def _plan(self, s: WalkState, given: StepInput) -> WalkState:
        """Set up a plan, solve one that is set up, or choose footholds: one a step."""
        now, request, time, changed = given
        times, plan, horizon = s.times, s.plan, s.horizon
        if changed or time - times.begun >= self._interval:
            horizon = self.planner.set_up(
                time, self._followed(s.gait), s.clock, s.feet, s.body, s.gait.coming_stance, plan,
                horizon is not None,
            )  # fmt: skip
            times = times._replace(begun=time, aimless=times.aimless or changed)
            if plan is None:
                plan, horizon = self.planner.solve(horizon, time, now, s.feet.frames, request.mu), None
            return s._replace(plan=plan, horizon=horizon, times=times)
        if horizon is not None:
            plan = self.planner.solve(horizon, time, now, s.feet.frames, request.mu)
            return s._replace(plan=plan, horizon=None)
        if times.aimless or time - times.aimed_at >= self._interval:
            gait, feet, swing = self._aim(s, now, request, time)
            times = times._replace(aimed_at=time, aimless=False, load_waits=True)
            return s._replace(gait=gait, feet=feet, swing=swing, times=times)
        return s

    def _follow_ground(self, body: BodyPlan, feet: Feet, elapsed: float) -> None:
        """Let the body follow the ground, `elapsed` after the last time [s]."""
        if self.terrain.planar or self.terrain.unsure:
            body.fit_ground(feet.ground, elapsed)
            return
        plane = plane_ahead(self.terrain, body.position[:2], body.yaw, body.flow(), self.height)
        body.follow_plane(*plane, elapsed)

    def _aim(
        self, s: WalkState, now: Kinematics, request: Request, time: float
    ) -> tuple[GaitState, Feet, SwingRequest]:
        """Follow the ground, time the steps, and choose the footholds of feet in the air."""
        feet, gait, body, clock = s.feet, s.gait, s.body, s.clock
        self._follow_ground(body, feet, min(time - s.times.aimed_at, 1.0))
        if self.schedule.adapts:
            gait = self._time_steps(gait, body, request, max(clock.time, 0.0))
        gait, swing = self._swing_request(s, gait, request, now)
        caught, schedule = request.recovery is not None, self._followed(gait)
        for k in np.flatnonzero(~(feet.stance | feet.planned)).tolist():
            _, _, end = schedule.phase(k, clock.time)
            left = max(end - clock.time, 0.0) / clock.rate
            place = (catching_place if caught else step_place)(
                now.com, now.com_velocity, self.planner.offsets[k], body.yaw,
                self.arbiter.asked if caught else body.velocity, left, self.height,
                gait.coming_stance / clock.rate,
            )  # fmt: skip
            if request.foot_goals is not None:
                place = request.foot_goals(place, feet.foot[k]["start"])
            feet = self._feet_model.aimed(feet, k, place, swing)
        return gait, feet, swing

    def _swing_request(
        self, s: WalkState, gait: GaitState, request: Request, now: Kinematics
    ) -> tuple[GaitState, SwingRequest]:
        """Return the gait, and how high feet are lifted, along which way, and over which stride."""
        body, clock = s.body, s.clock
        own, stride = self.schedule.clearance, None
        share = 1.0
        if self.terrain.planar:
            gait = gait._replace(unease=unease(gait.unease, body, now, self.height, self._interval))
            share = self.settings.ease + (1.0 - self.settings.ease) * gait.unease
        usual = share * (self.settings.clearance * self.height if own is None else own)
        lifted = max(usual + float(body.posture[2]), FEET.least_clearance * usual) + request.clearance
        if request.recovery is not None and gait.leap is None:
            lifted *= self.settings.catch_clearance
        if self._steps is not None and clock.time >= 0.0:
            self._steps.look(body, clock.time, self.terrain.unsure)
            stride = self._steps.stride
        heading = None if s.touch is None else s.touch.heading
        return gait, SwingRequest(lifted, heading, stride)

    def _time_steps(self, gait: GaitState, body: BodyPlan, request: Request, time: float) -> GaitState:
        """Let the gait follow the speed: the wanted one where that will be higher, else that of now."""
        schedule, command, own = self.schedule, self.arbiter.asked, body.velocity
        if self._steps is not None:
            own = self._steps.unhurried(own, command)
        wanted = max(command, own, key=lambda v: float(v @ v))
        if not wanted.any() and request.step_times is not None:
            wanted = request.step_times
        schedule.follow(time, wanted)
        # in step with the ground a stride is long, and the horizon with it
        step = schedule.coming_period / self.settings.steps_per_period if schedule.in_step else self._mpc_dt
        if abs(step / self.mpc.dt - 1.0) > 1e-3:
            self.mpc.pace(step)
        return gait._replace(
            stance_time=schedule.stance_time, fits=schedule.fits(self.settings.gait_lead * body.velocity)
        )

    def _tasks(self, s: WalkState, measured: RobotState, now: Kinematics) -> Tasks:
        """Return the whole-body tasks: the plan's motion now, feedback on it, and the feet in the air."""
        feet, plan = s.feet, s.plan
        assert plan is not None, "the first step makes a plan"
        gain, swing_gain = self._gains
        body = follow(plan.motion, plan.rotation, measured.time - plan.made, *now[:4], *gain)
        wanted = self._feet_model.accelerations(
            feet, s.clock, None if s.touch is None else s.touch.fastest, now.centres, now.twists,
            swing_gain,
        )  # fmt: skip
        joints = self._still
        if self._posture is not None:
            joints = self._posture.accelerations(measured.q, measured.v)
        return Tasks(feet.stance, body[0], body[1], wanted, joints, plan.forces, feet.frames, self._no_gaps)
