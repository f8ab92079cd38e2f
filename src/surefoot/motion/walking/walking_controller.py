"""Walking on point feet: gait, footholds, convex MPC and whole-body control.

Each `plan_interval`, and whenever a foot lifts or lands, the MPC plans the forces of the next steps again.
Every gain follows from the robot's mass, inertia, leg length and foot places; nothing is tuned per robot.
The tick itself is `surefoot.motion.walking.tick.Tick.step`.
"""

from __future__ import annotations

import math

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray, of_kind, real_number
from surefoot.base.errors import ModelError
from surefoot.base.spatial import GRAVITY
from surefoot.mechanics import FlatTerrain, Robot, Terrain, composite_inertia
from surefoot.motion.control.controller import RobotState
from surefoot.motion.control.posture import Posture
from surefoot.motion.control.whole_body_tasks import Kinematics, Tasks
from surefoot.motion.gaits.contact_schedule import ContactSchedule
from surefoot.motion.gaits.gait import Gait
from surefoot.motion.ground.ground_belief import believed
from surefoot.motion.ground.plane_ahead import plane_ahead
from surefoot.motion.walking.behaviours.arbiter import EVERYTHING
from surefoot.motion.walking.behaviours.behaviour import Recovery, Request
from surefoot.motion.walking.command_limits import LeggedBody
from surefoot.motion.walking.foothold import catching_place, step_place
from surefoot.motion.walking.force_planner import ForcePlanner
from surefoot.motion.walking.gait_choice import choose_gait
from surefoot.motion.walking.load_adaptation import LoadAdaptation
from surefoot.motion.walking.stair_phase import StepPhase
from surefoot.motion.walking.touchdown_detection import TouchSense
from surefoot.motion.walking.walker import Walker
from surefoot.motion.walking.walking_body import DIP, BodyPlan, VelocityCommand, first_stance
from surefoot.motion.walking.walking_feet import DESCENT, LEAST_CLEARANCE, Feet
from surefoot.motion.walking.walking_kernels import follow
from surefoot.motion.walking.walking_settings import WalkCommand as WalkCommand
from surefoot.motion.walking.walking_settings import WalkSettings as WalkSettings

LEAD = 1.15
"""A body goes faster once its gait is fit for this multiple of its speed."""
LOW = 0.5
"""Height of the swings over the usual one while a body is caught, for they are quick."""
CALM, UNEASY, UNEASE_TIME = 0.06, 0.15, 1.0
"""Up to the first error of its velocity, as a share of sqrt(g h), a body moves as planned; from the second on
feet are lifted in full, and ever less for so long after it [s]."""
HELD = 3.0
"""Natural frequency of joints outside the legs, which hold the pose that the walk begins in, in units of
sqrt(g / h): a biped's arms have the same."""
LEAP, LAND = 0.5, 0.44
"""Times in the air and on the ground of a body that leaps, in units of sqrt(h / g)."""
FLYING = 10.0
"""Weight of the feet then, in the air, over the usual one: what holds a body level that no foot holds throws
its legs about."""
PERIOD, STANCE = 0.4, 0.55
"""Cycle that the horizon of a schedule without one is measured by, for a body of 0.3 m [s], and its stance as
a share of it: a trot's."""


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
        flat = sum(foot.flat for foot in robot.feet)
        if not robot.floating or len(robot.feet) < 3 or flat:
            raise ModelError(
                f"{robot.name} cannot walk here: that takes a free base and three or more point feet, "
                f"it has {len(robot.feet)}{f', {flat} of them flat' if flat else ''}"
            )
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
        self._limit = chosen.limit
        period = chosen.shortest or PERIOD * math.sqrt(self.height / 0.3)
        self._stance_time = self.schedule.stance_time or STANCE * period
        self._mpc_dt = period / s.steps_per_period
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
        posture = Posture(self.robot, HELD * self._pendulum, swing=0.0)
        self._posture = posture if posture.free.any() else None
        radius = float(np.linalg.norm(offsets[:, :2], axis=1).max())
        self._set_behaviours(radii, radius, s.watch_friction)
        self._steps = None
        if cyclic and (self.terrain.highest_step > 0.0 or self.terrain.learns):
            margin = 2.0 * float(radii.mean())
            self._steps = StepPhase(self.terrain, self.schedule, offsets, margin)
        belief = believed(self.terrain)
        self._touch = None if belief is None else TouchSense(belief, weight, self.height, self.dt)
        self.load = None
        if s.watch_load:
            self.load = LoadAdaptation(self.robot, self.dt, self.mpc, self.whole_body)
        self.planner = ForcePlanner(self.mpc, self.schedule, offsets, radii, self.dt, s.ramp / self._pendulum)
        self.reset()

    def _honoured(self) -> frozenset[str]:
        """See `Walker`: late feet are looked after where touch is watched, the clock where a gait adapts."""
        deaf = set() if self.terrain.learns else {"search", "hold"}
        return EVERYTHING - deaf - (set() if self.schedule.adapts else {"step_times", "hold"})

    def reset(self) -> None:
        """Forget the past: the next step begins a walk from where the robot stands."""
        for part in (self.planner, self.whole_body, self.load, self._steps, self.schedule, self.arbiter):
            if part is not None:
                part.reset()
        self.feet: Feet | None = None
        self._follow_feet()
        self._outstanding = None
        self._aimed_at = -math.inf
        self._fits = True  # the gait follows the speed fast enough
        self._new_load = True  # what has been learned of the load since the models were brought up
        self._unease = 1.0  # how far the body is from its plan
        self._aimless = False  # a foot has just lifted, and does not know yet where it goes

    @property
    def _waiting(self) -> bool:  # type: ignore[override]
        """Whether the body waits to set off onto steps."""
        return self._steps is not None and self._steps.waiting

    @property
    def _interval(self) -> float:
        """Time between two plans, less half a step [s]."""
        return min(self.settings.plan_interval, self._mpc_dt) - 0.5 * self.dt

    def _due(self, time: float) -> bool:
        """Return whether it is time for another plan."""
        return time - self.planner.begun >= self._interval

    def _adapt(self, state: RobotState) -> None:
        """Learn of the load; bring the models up in a step without a plan and without footholds."""
        if self.load is None:
            return
        self.load.observe(state)
        if self._new_load and not (self._due(state.time) or self.planner.pending):
            self.load.update_models(None if self.feet is None else self.body)
            self._new_load = False

    def _begin(self, now: Kinematics, state: RobotState) -> Feet:
        """Start from where the robot stands."""
        clearance = self.settings.clearance * self.height
        descent = DESCENT * math.sqrt(GRAVITY * self.height)
        centres = now.centres.copy()
        if self._touch is not None:
            self._touch.begin(state, centres, self.planner.radii)
        self.feet = Feet(self.schedule, self.terrain, self.planner.radii, clearance, descent, centres)
        yaw = math.atan2(now.rotation[1, 0], now.rotation[0, 0])
        dip = 0.0 if self.terrain.planar else DIP
        self.body = BodyPlan(self.height, now.com.copy(), yaw, dip=dip, stance=first_stance(self.schedule))
        self.body.swerve = self._swerve(now, state, yaw)
        if self._posture is not None:
            self._posture.hold(state.q)
        self._follow_ground(math.inf)
        return self.feet

    def _sort_touches(self, state: RobotState, now: Kinematics, sensed: BoolArray, clock: float) -> BoolArray:
        """Return which feet stand; on ground that is only believed a touch may be none."""
        if self._touch is None or self.feet is None:
            return sensed
        return self._touch.sort(state, self.feet, sensed, clock, now)

    def _move_feet(self, now: Kinematics, standing: BoolArray, clock: float) -> bool:
        """Bring the feet up to the clock; return whether one has lifted or landed."""
        assert self.feet is not None
        return self.feet.update(clock, standing, now.centres)

    def _learn(self, state: RobotState, now: Kinematics, clock: float) -> None:
        """Learn what the feet have found of the ground."""
        if self._touch is not None and self.feet is not None:
            self._touch.learn(state, self.feet, now, clock)

    def _move_body(self, request: Request, now: Kinematics, clock: float) -> None:
        """Move the wanted body by one step, and let the models know of friction and load."""
        velocity, body = self.arbiter.velocity, self.body
        if self._steps is not None:
            pace = self._steps.pace(math.hypot(velocity[0], velocity[1]), self.dt)
            velocity = velocity * [pace, pace, 1.0]
        if self._touch is not None:
            self._touch.asked = request
        self.whole_body.set_friction(request.mu)
        body.acceleration, body.ceiling = min(body.change, request.acceleration), request.height
        self._recover(request.recovery, now, clock)
        body.advance(velocity, now.com, self.dt)

    def _recover(self, recovery: Recovery | None, now: Kinematics, clock: float) -> None:
        """Let clock, body and feet do what a recovery asks for, and as ever without one."""
        assert self.feet is not None
        if recovery is not None or self._leaping:
            self._leap(recovery is not None and recovery.leaps, now, clock)
        self.feet.hurry(1.0 if recovery is None or self._leaping else recovery.rate, self.dt)
        self.planner.rate = self.feet.rate
        if recovery is not None:
            self.body.velocity[:], self.body.acceleration = recovery.velocity, recovery.acceleration

    def _leap(self, wanted: bool, now: Kinematics, clock: float) -> None:
        """Let all feet leave the ground and meet it together if wanted; end late in a stance if not."""
        feet, unit = self.feet, 1.0 / self._pendulum
        assert feet is not None
        if self._leaping:
            landed, begin, end = feet.schedule.phase(0, clock)
            if not wanted and landed and clock > 0.5 * (begin + end):
                feet.follow(self.schedule, clock)
                self._follow_feet()
        elif wanted:
            period, air = (LEAP + LAND) * unit, LEAP * unit
            begun = [(clock + air) / period] * len(feet.radii)
            feet.leap(Gait.from_phases("leap", period, LAND * unit / period, begun), clock, air, now.centres)
            self._follow_feet()

    @property
    def _leaping(self) -> bool:
        """Whether all feet leave the ground and meet it together."""
        return self.planner.schedule is not self.schedule

    def _follow_feet(self) -> None:
        """Let plans follow the feet's schedule, from a new one on."""
        self.planner.schedule = self.schedule if self.feet is None else self.feet.schedule
        self.planner.begun = -math.inf
        self.whole_body.weigh_swing(1.0)

    def _bound_forces(self, state: RobotState, now: Kinematics, clock: float, standing: BoolArray) -> None:
        """Bound the forces by the ramps of the feet, and tell the torques of the load."""
        assert self.feet is not None
        if self.load is not None:
            self.load.pull(now, state.q[:3])
        low, high = self._normals
        top = high * self.planner.shares(clock, self.feet.stance, standing)
        self.whole_body.bound_normals(low, top)

    def _plan(self, now: Kinematics, request: Request, clock: float, time: float, changed: bool) -> None:
        """Set up a plan, solve one that is set up, or choose footholds: one a step."""
        assert self.feet is not None
        if changed or self._due(time):
            self.planner.set_up(time, clock, self.feet, self.body, self._stand(self.feet))
            self._aimless |= changed
            if self.planner.forces is None:
                self.planner.solve(time, now, self.feet.frames, request.mu)
        elif self.planner.pending:
            self.planner.solve(time, now, self.feet.frames, request.mu)
        elif self._aimless or time - self._aimed_at >= self._interval:
            self._aim(now, request, clock, time)
            self._new_load = True

    def _follow_ground(self, elapsed: float) -> None:
        """Let the body follow the ground, `elapsed` after the last time [s]."""
        feet, body = self.feet, self.body
        assert feet is not None
        if self.terrain.planar or self.terrain.unsure:
            body.fit_ground(feet.ground, elapsed)
            return
        plane = plane_ahead(self.terrain, body.position[:2], body.yaw, body.flow(), self.height)
        body.follow_plane(*plane, elapsed)

    def _aim(self, now: Kinematics, request: Request, clock: float, time: float) -> None:
        """Follow the ground, time the steps, and choose the footholds of feet in the air."""
        feet, schedule = self.feet, self.schedule
        assert feet is not None
        self._follow_ground(min(time - self._aimed_at, 1.0))
        self._aimed_at, self._aimless = time, False
        if schedule.adapts:
            self._time_steps(request, max(clock, 0.0))
        own = schedule.clearance
        usual = self._eased(now) * (self.settings.clearance * self.height if own is None else own)
        lifted = max(usual + float(self.body.posture[2]), LEAST_CLEARANCE * usual)
        feet.clearance = lifted + request.clearance
        if request.recovery is not None and not self._leaping:
            feet.clearance *= LOW
        if self._steps is not None and clock >= 0.0:
            self._steps.look(self.body, clock, self.terrain.unsure)
            feet.stride = self._steps.stride
        for k in np.flatnonzero(~(feet.stance | feet.planned)).tolist():
            _, _, end = feet.schedule.phase(k, clock)
            caught, left = request.recovery is not None, max(end - clock, 0.0) / feet.rate
            place = (catching_place if caught else step_place)(
                now.com, now.com_velocity, self.planner.offsets[k], self.body.yaw,
                self.arbiter.asked if caught else self.body.velocity, left, self.height,
                self._stand(feet) / feet.rate,
            )  # fmt: skip
            if request.foot_goals is not None:
                place = request.foot_goals(place, feet.start[k])
            feet.aim(k, place)

    def _stand(self, feet: Feet) -> float:
        """Return the length of the feet's coming stances [s]."""
        return feet.schedule.stance_time if self._leaping else self._stance_time

    def _eased(self, now: Kinematics) -> float:
        """Return the share of the usual clearance that a swing is to have."""
        if not self.terrain.planar:
            return 1.0
        error = now.com_velocity[:2] - self.body.flow()
        size = math.hypot(error[0], error[1]) / math.sqrt(GRAVITY * self.height)
        fresh = min(max((size - CALM) / (UNEASY - CALM), 0.0), 1.0)
        self._unease = max(fresh, self._unease - self._interval / UNEASE_TIME)
        return self.settings.ease + (1.0 - self.settings.ease) * self._unease

    def _time_steps(self, request: Request, clock: float) -> None:
        """Let the gait follow the speed: the wanted one where that will be higher, else that of now."""
        schedule, command, own = self.schedule, self.arbiter.asked, self.body.velocity
        if self._steps is not None:
            own = self._steps.unhurried(own, command)
        wanted = max(command, own, key=lambda v: float(v @ v))
        if not wanted.any() and request.step_times is not None:
            wanted = request.step_times
        schedule.follow(clock, wanted)
        self._stance_time = schedule.stance_time
        # in step with the ground a stride is long, and the horizon with it
        step = schedule.coming_period / self.settings.steps_per_period if schedule.in_step else self._mpc_dt
        if abs(step / self.mpc.dt - 1.0) > 1e-3:
            self.mpc.pace(step)
        self._fits = schedule.fits(LEAD * self.body.velocity)

    def _tasks(self, state: RobotState, now: Kinematics, clock: float) -> Tasks:
        """Return the whole-body tasks: the plan's motion now, feedback on it, and the feet in the air."""
        feet, planner = self.feet, self.planner
        assert feet is not None
        assert planner.forces is not None
        if self._leaping:
            self.whole_body.weigh_swing(1.0 if feet.stance.any() else FLYING)
        gain = self._gain(self.settings.body_stiffness)
        body = follow(planner.motion, planner.rotation, state.time - planner.made, *now[:4], *gain)
        wanted = feet.accelerations(clock, now.centres, now.twists, self._gain(self.settings.swing_stiffness))
        joints = np.zeros(self.robot.joints)
        if self._posture is not None:
            joints = self._posture.accelerations(state.q, state.v)
        return Tasks(
            feet.stance, body[0], body[1], wanted, joints, planner.forces, feet.frames,
            np.zeros(len(feet.radii)),
        )  # fmt: skip
