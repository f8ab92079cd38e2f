"""The walking controller of bipeds on flat feet: footsteps, pendulum preview, convex MPC, whole-body control.

Each millisecond: which soles stand, where the other one should be, the motion that the last plan predicts for
now, and the torques that give it. Each `plan_interval`, and whenever a foot lifts or lands, the MPC plans the
forces at the corners of the soles again. Its reference is the pendulum over the footsteps ahead; where the
coming foot lands follows the divergent motion that the MPC predicts for the touchdown, or, of a robot that
was pushed, the one of now (`catching`).
"""

from __future__ import annotations

import math
from functools import partial

import numpy as np

from surefoot.base.arrays import of_kind, real_number
from surefoot.base.errors import ModelError, ProblemError
from surefoot.base.memory import Remembering
from surefoot.base.spatial import GRAVITY, rotation_exp, rotation_log
from surefoot.mechanics import FlatTerrain, Robot, Terrain, composite_inertia
from surefoot.motion.control.controller import RobotState
from surefoot.motion.control.mpc import BodyReference, BodyState
from surefoot.motion.control.posture import Posture, leg_share, stretching
from surefoot.motion.control.whole_body import ForceLimits, Kinematics, Tasks
from surefoot.motion.gaits.contact_schedule import ContactSchedule
from surefoot.motion.gaits.library import named_gait
from surefoot.motion.walking.behaviours.behaviour import Request
from surefoot.motion.walking.biped.biped_settings import BIPED_WALK
from surefoot.motion.walking.biped.catching import Catching
from surefoot.motion.walking.biped.footstep_planner import (
    Footstep,
    StepGeometry,
    StepPlanner,
    foot_speeds,
    landing_offsets,
    pressure_path,
)
from surefoot.motion.walking.biped.leg_momentum import LegMomentum
from surefoot.motion.walking.biped.pendulum import PendulumPreview
from surefoot.motion.walking.biped.settings import BipedSettings
from surefoot.motion.walking.biped.sole_inertia import check_rotors, sole_inertias, turning_share
from surefoot.motion.walking.biped.soles import Soles, sole_damping
from surefoot.motion.walking.feet_settings import FEET
from surefoot.motion.walking.foot_phases import FeetContact, FootPhase
from surefoot.motion.walking.force_planner import ForcePlan, Ramps
from surefoot.motion.walking.gait_clock import GaitClock
from surefoot.motion.walking.load_adaptation import LoadAdaptation
from surefoot.motion.walking.walk_state import BipedState, GaitState, PlanTimes, StepInput, WalkState
from surefoot.motion.walking.walkable import check_soles
from surefoot.motion.walking.walker import Walker, check_walk
from surefoot.motion.walking.walking_body import BodyPlan, VelocityCommand, granted_share, limit_command
from surefoot.motion.walking.walking_feet import Feet, SwingRequest
from surefoot.motion.walking.walking_kernels import follow, slope_frames

HONOURED = frozenset(
    ("speed_cap", "velocity", "at_most", "pace", "clearance", "mu", "acceleration", "height")
)
"""What behaviours may ask for of a biped. Its gait keeps its own time, its soles do not search for ground,
and `catching` chooses their places after a push: the rest is refused."""


class BipedController(Walker):
    """Walks a robot on two flat feet; call `step` at a fixed rate.

    Parameters
    ----------
    robot
        With a floating base and two flat feet, which are level and point ahead in its nominal pose.
    command
        Wanted velocity over time; slowed to what is possible, see `notes`.
    gait
        A name, or a gait for two feet.
    terrain
        The ground that the controller believes in; None for flat.
    settings
        See `BipedSettings`.
    dt
        Time between steps [s].

    Attributes
    ----------
    notes
        What was changed in the command, one line each.

    Raises
    ------
    ModelError
        If the robot has no two flat feet, or a fixed base.
    ProblemError
        If the gait does not fit its feet.
    """

    settings: BipedSettings
    soles: Soles
    load: LoadAdaptation
    catching: Catching

    def __init__(
        self,
        robot: Robot,
        command: VelocityCommand,
        gait: str | ContactSchedule = "walk",
        terrain: Terrain | None = None,
        settings: BipedSettings | None = None,
        dt: float = 1e-3,
    ) -> None:
        of_kind("robot", robot, Robot)
        check_walk(command, terrain, settings, BipedSettings)
        check_soles(robot)
        if (share := leg_share(robot)) > BIPED_WALK.heavy_legs:
            raise ModelError(
                f"{robot.name} cannot walk here: its legs have {share:.0%} of its mass, and steps are "
                f"planned for {BIPED_WALK.heavy_legs:.0%} at most; give it its trunk"
            )
        self.robot, self.dt = robot, real_number("dt", dt, low=1e-6)
        self.settings = settings or BipedSettings()
        self._inertias = sole_inertias(robot, self.settings.actuators)
        check_rotors(robot, self._inertias)
        self.terrain = FlatTerrain() if terrain is None else terrain
        self._measure()
        if isinstance(gait, str):
            gait = named_gait(gait, 2, period=BIPED_WALK.period * math.sqrt(self.height / GRAVITY))
        of_kind("gait", gait, ContactSchedule)
        if gait.feet != 2:
            raise ProblemError(f"the gait is for {gait.feet} feet, {robot.name} has 2")
        self.schedule = gait
        sides = np.sign(robot.foot_positions(robot.nominal)[:, 1])
        self.steps = StepPlanner(gait, self._geometry, sides, self.settings.capture)
        self._mpc_dt = gait.period / self.settings.mpc_steps
        self._interval = min(self.settings.plan_interval, self._mpc_dt)
        self.command, self.notes = self._slowed(command)
        self.granted = granted_share(command, self.command)
        self._set_parts()

    def _limit(self, wanted: VelocityCommand) -> VelocityCommand:
        """See `Walker`."""
        return self._slowed(wanted)[0]

    def _slowed(self, command: VelocityCommand) -> tuple[VelocityCommand, list[str]]:
        """Return a command slowed to what the robot can do, and a line for everything that was slowed."""
        reach, radius = BIPED_WALK.reach * self.height, 0.5 * self._geometry.width
        return limit_command(command, reach, self.steps.step_time, self.height, radius)

    def _measure(self) -> None:
        """Read mass, inertia, height and foot places off the robot's nominal pose."""
        robot, q = self.robot, self.robot.nominal
        inertia, _, self._upright = composite_inertia(robot, q)
        self._inertia = self._upright @ inertia @ self._upright.T
        com, centres = robot.com(q), robot.foot_positions(q)
        radii = robot.contact_points.foot_radii
        self._rise = stretching(robot, self.settings.stretch)
        self.height = float(com[2] - (centres[:, 2] - radii).mean()) + self._rise
        width = float(abs(centres[0, 1] - centres[1, 1]))
        sole = max(foot.size[1] for foot in robot.feet)
        self._geometry = StepGeometry(
            width, min(1.5 * sole, 0.9 * width), width + 0.45 * self.height, 0.65 * self.height
        )
        self.start = self.settings.start / self._pendulum

    def _set_parts(self) -> None:
        """Make what gives the forces, and what looks ahead and keeps the posture."""
        s, rates = self.settings, (self._pendulum**2, 2.0 * self._pendulum)
        along, turning = s.sole_damping
        slowed = along, turning * turning_share(self.robot, self._inertias)
        damping = sole_damping(slowed, self._pendulum, self.dt)
        self._set_controllers(self._inertia, self._mpc_dt, rates, damping)
        fine = self._mpc_dt / 2
        self._preview = PendulumPreview(
            self._pendulum, fine, max(2 * round(0.5 * s.preview / fine), 2 * s.horizon + 2)
        )
        self.catching = Catching(self._preview, self.steps, self.height)
        most = s.arm_swing / self.height
        share = LegMomentum(self.robot, Posture(self.robot, 1.0, most).swing).balancing()
        self._posture = Posture(self.robot, s.joint_stiffness * self._pendulum, min(share, 1.0) * most)
        self._legs = LegMomentum(self.robot, self._posture.swing)
        self._pressed = np.full(2, s.sole_press * self.height)
        self._set_behaviours(self.robot.contact_points.foot_radii, 0.5 * self._geometry.width, False)
        clearance, descent = s.clearance * self.height, BIPED_WALK.descent * math.sqrt(GRAVITY * self.height)
        self.soles = Soles(self.robot, self.terrain, clearance, descent)
        self._feet_model = self.soles.model
        # what is left of the wrench changes with every step of a biped: no plan beyond it may count on it
        self.load = LoadAdaptation(
            self.robot, self.dt, self.mpc, self.whole_body, self._upright, fading=math.inf
        )
        self.reset()

    def _honoured(self) -> frozenset[str]:
        """See `Walker`."""
        return HONOURED

    def reset(self) -> None:
        """Forget the past: the next step begins a walk from where the robot stands."""
        for part in (self.mpc, self.whole_body, self.arbiter, self.load, self.catching):
            part.reset()
        self._walk = self._outstanding = None

    def _parts(self) -> dict[str, Remembering | None]:
        """See `Tick`."""
        return {
            "schedule": self.schedule, "mpc": self.mpc, "whole_body": self.whole_body, "load": self.load,
            "catching": self.catching, "arbiter": self.arbiter,
        }  # fmt: skip

    def _observe_load(self, measured: RobotState) -> None:
        """Learn of the load; one that is found before the first step goes into all models."""
        load, time = self.load, measured.time
        begun = -math.inf if self._walk is None else self._walk.times.begun
        load.observe(measured)
        if not self._due(begun, time):
            return
        if BIPED_WALK.noticed_time < time < self.start:
            load.notice(BIPED_WALK.laden)
        if load.laden:
            load.update_models(None if self._walk is None else self._walk.body)

    def _due(self, begun: float, time: float) -> bool:
        """Return whether it is time for another plan after one that was begun at a time [s]."""
        return time - begun >= self._interval - 0.5 * self.dt

    def _begin(self, now: Kinematics, measured: RobotState) -> WalkState:
        """Return the state of a walk that begins where the robot stands."""
        feet, corners = self.soles.standing(now.centres, self.whole_body.foot_rotations)
        ahead = now.rotation @ self._upright.T[:, 0]
        yaw, place = math.atan2(ahead[1], ahead[0]), now.com.copy()
        place[:2] = now.centres[:, :2].mean(axis=0)
        body = BodyPlan(self.height - self._rise, place, yaw, swerve=self._swerve(now, measured, yaw))
        body.fit_ground(corners, math.inf)
        gait = GaitState(self.schedule.stance_time)
        return WalkState(
            GaitClock(-self.start), gait, feet, body, Ramps.of(2), biped=BipedState(corners),
            swing=SwingRequest(self.settings.clearance * self.height),
        )  # fmt: skip

    def _advance_feet(
        self, s: WalkState, feet: Feet, contact: FeetContact, now: Kinematics, clock: GaitClock
    ) -> tuple[Feet, BipedState | None, bool]:
        """See `Tick`; before the gait begins both feet stand."""
        kept = _kept(s)
        if clock.time < 0.0:
            return feet, kept, False
        feet, corners, changed = self.soles.advance(
            feet, kept.corners, self.schedule, clock, contact, now.centres, self.whole_body.foot_rotations
        )
        return feet, kept._replace(corners=corners), changed

    def _move(
        self, s: WalkState, feet: Feet, request: Request, now: Kinematics, clock: GaitClock, waits: bool
    ) -> tuple[GaitClock, GaitState, Feet, PlanTimes]:
        """See `Tick`; the body rises before it walks."""
        body, pace = s.body, self.catching.pace
        feet = self.soles.model.hurried(feet, clock.rate, pace)
        body.rise(self._rise * self.dt / self.start, self.height + float(self.load.shift[2]))
        change = min(body.change, request.acceleration)
        body.advance(self.arbiter.velocity, now.com, self.dt, change, request.height)
        return clock.advanced(self.dt, pace, waits), s.gait, feet, s.times

    def _limit_forces(
        self, ramps: Ramps, gait: GaitState, clock: GaitClock, feet: Feet, request: Request,
        measured: RobotState, now: Kinematics, contact: FeetContact,
    ) -> tuple[Ramps, ForceLimits]:  # fmt: skip
        """Return this step's friction, and the external wrench of a robot that carries a load."""
        outside = self.load.pull(now, measured.q[:3]) if self.load.laden else None
        return ramps, ForceLimits(request.mu, outside=outside)

    def _plan(self, s: WalkState, given: StepInput) -> WalkState:
        """Choose the landings of feet in the air, and plan the forces of the steps ahead, if it is time."""
        time = given.time
        if not (given.changed or self._due(s.times.begun, time)):
            return s
        s.body.fit_ground(_kept(s).corners, min(time - s.times.begun, 1.0))
        if s.plan is not None and not self.catching.active:
            s = self._aim(s, given.request, time)
        return self._replan(s, given)

    def _aim(self, s: WalkState, request: Request, time: float) -> WalkState:
        """Choose where feet in the air land."""
        feet, usual, clock = s.feet, self.settings.clearance * self.height, s.clock
        lifted = max(usual + float(s.body.posture[2]), FEET.least_clearance * usual)
        swing = SwingRequest(lifted + request.clearance)
        for k in np.flatnonzero(~feet.stance & ~feet.planned).tolist():
            left = max(self.schedule.phase(k, clock.time)[2] - clock.time, 0.0)
            after = (time + left - s.times.begun) / self._mpc_dt
            place = _kept(s).divergence(after, self._pendulum) - _kept(s).offsets[k]
            place, yaw = self.steps.foothold(k, s.body, left, place, feet.ground[1 - k, :2])
            feet = self.soles.aimed(feet, k, place, yaw, swing)
        return s._replace(feet=feet, swing=swing)

    def _replan(self, s: WalkState, given: StepInput) -> WalkState:
        """Run the MPC for the footsteps from now on, with a friction, or its own if that is infinite."""
        soles, clock, (now, request, time, _) = self.soles, s.clock.time, given
        N, dt, kept = self.settings.horizon, self._mpc_dt, _kept(s)
        toes = [soles.heading(r, k) for k, r in enumerate(self.whole_body.foot_rotations)]
        ahead = partial(self.steps.ahead, s.feet, toes, s.body, clock, self.settings.preview)
        steps = ahead(self.catching.pace)
        reference, kept = self._reference(s, kept, now, steps)
        miss = (now.com_velocity - reference.linear_velocity[0])[:2] / self._pendulum
        if clock > 0.0 and self.catching.notice(miss):
            divergent = (now.com + now.com_velocity / self._pendulum)[:2]
            steps = self.catching.steps(ahead, miss, divergent, clock)
            s = s._replace(feet=self._send_feet(s, steps))
            reference, kept = self._reference(s, kept, now, steps)
        middles = clock + dt * (np.arange(N, dtype=np.float64) + 0.5)
        contacts, places = self.steps.corners(soles, s.feet, kept.corners, steps, middles)
        spin = now.angular_velocity + kept.leg_spin[0]
        state = BodyState(now.rotation @ self._upright.T, now.com, now.com_velocity, spin)
        before, mu, points = s.times.begun, request.mu, soles.point_foot
        self.mpc.shift(max(time - before, 0.0) if math.isfinite(before) else 0.0)
        plan = self.mpc.solve(
            state, reference, places, contacts, s.feet.frames[points],
            mu=None if mu == math.inf else np.full(len(points), mu),
        )  # fmt: skip
        linear, angular, legs = (np.diff(v[:2], axis=0)[0] / dt for v in
                                 (plan.linear_velocity, plan.angular_velocity, kept.leg_spin))  # fmt: skip
        motion = np.array([now.com, now.com_velocity, now.angular_velocity, linear, angular - legs])
        predicted = np.array([plan.position, plan.linear_velocity])
        return s._replace(
            plan=ForcePlan(time, plan.first, motion, now.rotation.copy()),
            times=s.times._replace(begun=time), biped=kept._replace(predicted=predicted),
        )  # fmt: skip

    def _send_feet(self, s: WalkState, steps: list[Footstep]) -> Feet:
        """Return the feet with one in the air sent to the coming one of the steps, also late in its swing."""
        coming = next((one for one in steps if one.begin > s.clock.time), None)
        if coming is None or s.feet.stance[coming.foot] or s.swing is None:
            return s.feet
        return self.soles.aimed(
            s.feet, coming.foot, coming.place, coming.yaw, s.swing, BIPED_WALK.catch_until
        )

    def _reference(
        self, s: WalkState, kept: BipedState, now: Kinematics, steps: list[Footstep]
    ) -> tuple[BodyReference, BipedState]:
        """Return the reference: the pendulum over the footsteps, upright along the heading; and what is kept.

        The legs' angular momentum is put down to the body as if it turned by itself: the spin and the turn
        that it would have with that momentum are added to its reference (and the spin to its state), and
        the pressure that gives the momentum to the pendulum's.
        """
        N, dt, body, clock = self.settings.horizon, self._mpc_dt, s.body, s.clock.time
        pressure = pressure_path(steps, clock + self._preview.middles)
        flow = self._preview.motion(now.com[:2], pressure)[1][::2]
        times = dt * np.arange(len(flow), dtype=np.float64)
        yaw = body.yaw + body.velocity[2] * times
        lifted = self.settings.clearance * self.height
        speeds = foot_speeds(s.feet, self.soles.model.descent, steps, clock + times, lifted)
        momentum = self._legs.momentum(speeds, np.column_stack([flow, flow @ body.slope]), yaw)
        gained = np.repeat(np.diff(momentum, axis=0), 2, axis=0)[:, :2] / (dt * self.mpc.mass * GRAVITY)
        pressure += np.column_stack([gained[:, 1], -gained[:, 0]])
        xy, flow = self._preview.motion(now.com[:2], pressure)
        offsets = landing_offsets(self._preview, steps, clock, pressure)
        place, speed = np.empty((N + 1, 3)), np.zeros((N + 1, 3))
        place[:, :2], speed[:, :2] = xy[: 2 * N + 1 : 2], flow[: 2 * N + 1 : 2]
        place[:, 2] = body.position[2] + (place[:, :2] - body.position[:2]) @ body.slope
        speed[:, 2] = speed[:, :2] @ body.slope
        rotation = slope_frames(yaw[: N + 1], np.zeros(2))
        mobility = np.linalg.inv(np.asarray(self.mpc.inertia, dtype=np.float64))
        inverse = rotation @ mobility @ rotation.transpose(0, 2, 1)
        leg_spin = np.einsum("tij,tj->ti", inverse, momentum[: N + 1])
        turned = np.zeros((N + 1, 3))
        turned[1:] = np.cumsum(0.5 * dt * (leg_spin[1:] + leg_spin[:-1]), axis=0)
        spin = leg_spin + np.array([0.0, 0.0, body.velocity[2]])
        turned_frames = np.array([rotation_exp(t) for t in turned]) @ rotation
        reference = BodyReference(turned_frames, place, speed, spin)
        return reference, kept._replace(offsets=offsets, leg_spin=leg_spin)

    def _tasks(self, s: WalkState, measured: RobotState, now: Kinematics) -> Tasks:
        """Return the whole-body tasks: the plan's motion now, feedback on it, feet in the air, posture."""
        feet, plan, stance = s.feet, s.plan, s.feet.stance
        assert plan is not None, "the first step makes a plan"
        gain, (ks, ds) = self._gains
        com, turn = follow(plan.motion, plan.rotation, measured.time - plan.made, *now[:4], *gain)
        wanted = self.soles.model.accelerations(feet, s.clock, None, now.centres, now.twists, (ks, ds))
        for k in np.flatnonzero(~stance).tolist():
            foot = feet.foot[k]
            goal, spin, change = self.soles.turning(feet, k)
            off = rotation_log(goal @ self.whole_body.foot_rotations[k].T)
            wanted[k, 3:] = change + ks * off + ds * (spin - now.twists[k, 3:])
            if self.catching.active and foot["phase"] != FootPhase.SEARCHING:
                # the least squared acceleration to be there at rest in time, from wherever the foot is
                left = max((1.0 - foot["share"]) * foot["duration"], BIPED_WALK.catch_time)
                way, speed = foot["target"][:2] - now.centres[k, :2], now.twists[k, :2]
                wanted[k, :2] = (6.0 * way / left - 4.0 * speed) / left
        c, sine = math.cos(s.body.yaw), math.sin(s.body.yaw)
        apart = (now.centres[0] - now.centres[1], now.twists[0] - now.twists[1])
        lead, rate_of_lead = (c * float(a[0]) + sine * float(a[1]) for a in apart)
        joints = self._posture.accelerations(measured.q, measured.v, lead, rate_of_lead)
        return Tasks(stance, com, turn, wanted, joints, plan.forces, feet.frames, self._pressed)


def _kept(s: WalkState) -> BipedState:
    """Return what a walk on two flat feet keeps beside."""
    assert s.biped is not None, "the state of a biped"
    return s.biped
