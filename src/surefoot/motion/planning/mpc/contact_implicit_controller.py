"""Contact-implicit model predictive control: walking from a velocity command, no gait given.

Every `interval` the last plan is moved on in time and begins where the robot is, which leaves a gap behind
its first knot; one iteration of the shooting solver (exact contact forward, smoothed backward) makes the next
plan. Between these ticks the plan's torques and the gains of its Riccati recursion go on at the rate of
`step`. Which foot touches when, nobody says: see `cost`.

Source: G. Kim, D. Kang, J.-H. Kim, S. Hong, H.-W. Park, "Contact-implicit model predictive control:
controlling diverse quadruped motions without pre-planned contact modes or trajectories", IJRR 2024, arXiv
2312.08961.
"""

from __future__ import annotations

import math
import time as clock
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray, real_number, whole_number
from surefoot.base.discrete_damping import SPRUNG
from surefoot.base.errors import SurefootError
from surefoot.base.spatial import heading_of, quaternion_about
from surefoot.contact import Status
from surefoot.mechanics import FlatTerrain, Robot, Terrain, place
from surefoot.motion.control.controller import Command, Controller, RobotState
from surefoot.motion.control.damping import computable_pose, damping_torques
from surefoot.motion.planning.mpc.cost import WalkWeights, walking_costs
from surefoot.motion.planning.mpc.receding import move_on, torques_between
from surefoot.motion.planning.shooting.horizon import FeedbackPolicy
from surefoot.motion.planning.shooting.iteration import ShootingIteration
from surefoot.motion.planning.shooting.shooting_problem import ShootingProblem
from surefoot.motion.walking.walking_body import VelocityCommand
from surefoot.records import CHANNELS

RAMP = 1.5
"""Largest change of the wanted velocity [m/s²], [rad/s²]."""
LEAD = 0.3
"""The wanted heading is never further from the body's than this [rad]."""
ENOUGH = 1.1
"""A motion that costs no more, in units of the last plan, is taken at once."""
SMALL = 0.05
"""Cost that does not matter."""
MOST = 1e4
"""Largest damping, relative to the torques' mean weight."""
STIFFNESS, DAMPING = 30.0, 1.0
"""Of joints where there is no plan [N m/rad], [N m s/rad]."""


@dataclass(frozen=True)
class MpcSettings:
    """How the controller plans.

    Attributes
    ----------
    knots, dt
        N, and the length of a knot [s].
    interval
        Time between plans [s].
    iterations
        Of the solver at each.
    first_iterations
        Of the first plan.
    smoothing
        κ of the derivatives [N s m/s].
    shares
        Shares of a step that the line search tries.
    damping
        Least weight of ½ ||du||², relative to the torques' mean weight: with less the gains of feet on the
        ground are too stiff for a leg that leaves it.
    mu
        Friction that the controller believes in.
    weights
        See `WalkWeights`.
    seed, noise
        Of the random torques that the first plan starts from [N m]: a robot that stands in a symmetric
        pose has no reason to lift one foot before the other.
    """

    knots: int = 25
    dt: float = 0.02
    interval: float = 0.02
    iterations: int = 1
    first_iterations: int = 30
    smoothing: float = 0.33
    shares: tuple[float, ...] = (1.0, 0.3)
    damping: float = 0.35
    mu: float = 0.6
    weights: WalkWeights = field(default_factory=WalkWeights)
    seed: int = 0
    noise: float = 0.5

    def __post_init__(self) -> None:
        whole_number("knots", self.knots, low=2)
        real_number("dt", self.dt, low=1e-4, high=0.2)
        real_number("interval", self.interval, low=1e-4, high=self.dt)
        whole_number("iterations", self.iterations, low=1)
        real_number("smoothing", self.smoothing, low=0.0)
        real_number("mu", self.mu, low=0.0)


@dataclass(frozen=True, kw_only=True)
class MpcCommand(Command):
    """What the controller asks for at one step.

    Attributes
    ----------
    planned
        (n,) which feet the plan wants on the ground now.
    wanted
        (3,) velocity command after the ramp: forward, left, yaw rate.
    tick
        Processor time of the plan that was made in this step [s]; 0 where none was.
    """

    planned: BoolArray
    wanted: FloatArray
    tick: float

    def rows(self) -> dict[str, Any]:
        """Return which feet are planned on the ground, and the wanted velocity."""
        return {"planned": self.planned, "command": self.wanted}


class ContactImplicitMpc(Controller):
    """Walks a four-legged robot without a gait; call `step` at a fixed rate.

    Parameters
    ----------
    robot
        Four legs of three joints, with point feet.
    command
        Wanted velocity over time.
    terrain
        The ground that the controller believes in; None for flat.
    settings
        See `MpcSettings`.
    dt
        Time between steps [s].

    Attributes
    ----------
    notes
        How it plans, in one line.
    iteration
        The solver, with the current plan.

    Raises
    ------
    ModelError
        For another robot.
    """

    channels = tuple(CHANNELS[name] for name in ("planned", "command"))

    def __init__(
        self,
        robot: Robot,
        command: VelocityCommand,
        terrain: Terrain | None = None,
        settings: MpcSettings | None = None,
        dt: float = 1e-3,
    ) -> None:
        self.robot, self.command, self.dt = robot, command, real_number("dt", dt, low=1e-6)
        self.settings = s = settings or MpcSettings()
        self._pose = place(robot)
        costs = walking_costs(robot, self._pose, s.weights)
        problem = ShootingProblem(robot, costs, s.knots, s.dt, s.mu, terrain, momentum=False)
        self.iteration = ShootingIteration(problem)
        self._terrain = FlatTerrain() if terrain is None else terrain
        self._limits = np.array([-robot.effort_limits, robot.effort_limits])
        self._hold = self.iteration.tables.torque[1][0].copy()
        self._springs, self._still = self._fallbacks()
        self.notes = [
            f"contact-implicit MPC: {s.knots} knots of {1e3 * s.dt:g} ms, {s.iterations} iteration(s) every "
            f"{1e3 * s.interval:g} ms; no gait is given, the cost decides it"
        ]
        self.facts = {
            "kind": "walk", "normal_min": 0.0, "normal_max": math.inf, "mu_controller": s.mu,
            "gait": "contact-implicit", "notes": list(self.notes), "knots": s.knots, "knot_length": s.dt,
            "interval": s.interval,
        }  # fmt: skip
        self.reset()

    def _fallbacks(self) -> tuple[FloatArray, FeedbackPolicy]:
        """Return gains that stand by `step`, and the policy that stands in rollouts.

        Springs and dampers of rollouts are as stiff as a step of a knot's length takes with a leg in the air.
        """
        import pinocchio

        N, m, n, dt = self.settings.knots, self.robot.joints, int(self.robot.model.nv), self.settings.dt
        inertia = pinocchio.crba(self.robot.model, self.robot.model.createData(), self._pose)
        legs = np.diag(inertia)[n - m :]
        soft = _springs(N, n, SPRUNG * legs / dt**2, 2.0 * SPRUNG * legs / dt)
        q, hold = np.tile(self._pose, (N + 1, 1)), np.tile(self._hold, (N, 1))
        standing = FeedbackPolicy(q, np.zeros((N + 1, n)), hold, soft, np.zeros((N, m)))
        return _springs(N, n, np.full(m, STIFFNESS), np.full(m, DAMPING)), standing

    def reset(self) -> None:
        """Forget the past: the next step is the first of a run."""
        self.planned_at = -math.inf
        self._velocity, self._yaw, self._last = np.zeros(3), math.nan, 0.0
        self._well = False
        self.iteration.gains[:], self.iteration.steps[:] = self._springs, 0.0
        self.iteration.damping = self.settings.damping

    def step(self, state: RobotState) -> MpcCommand:
        """Return the command for a state; a tick plans anew.

        Never raises on a hard instance: where no plan can be made the last one goes on, flagged. A state that
        is not finite, or too large to compute with, gets a command that slows the joints, and changes
        nothing else.
        """
        if not computable_pose(state.q, state.v):
            return self._blind(state.v)
        tick = 0.0
        if state.time - self.planned_at >= self.settings.interval - 0.5 * self.dt:
            start = clock.process_time()
            self._well = self._plan_again(state)
            tick = clock.process_time() - start
        return self._act(state, tick)

    def _act(self, state: RobotState, tick: float) -> MpcCommand:
        """Return the plan's torques and the feedback of its gains."""
        now, dt = self.iteration.now, self.settings.dt
        late = max(state.time - self.planned_at, 0.0) / dt if math.isfinite(self.planned_at) else 0.0
        knot = min(int(late), len(now) - 1)
        here, share = (state.q, state.v), min(late - knot, 1.0)
        torques = torques_between(self.robot, here, self.iteration.policy, knot, share, self._limits)
        if not np.isfinite(torques).all():
            return self._blind(state.v)
        forces = now.impulses[knot] / dt
        active = forces[:, 2] > 0.0
        status = Status.SOLVED if self._well else Status.STALLED
        return MpcCommand(
            torques, forces, active, self._well, status,
            planned=self._feet(active), wanted=self._velocity.copy(), tick=tick,
        )  # fmt: skip

    def _feet(self, active: BoolArray) -> BoolArray:
        """Return which feet have an active contact point: (n,)."""
        out = np.zeros(len(self.robot.feet), dtype=bool)
        out[self.robot.contact_points.foot[active]] = True
        return out

    def _blind(self, v: FloatArray) -> MpcCommand:
        """Return the command for a state that nothing can be computed for."""
        torques = damping_torques(self.robot, v, self.robot.effort_limits)
        p, n = len(self.robot.contact_points), len(self.robot.feet)
        return MpcCommand(
            torques, np.zeros((p, 3)), np.ones(p, dtype=bool), False, Status.INVALID,
            planned=np.ones(n, dtype=bool), wanted=self._velocity.copy(), tick=0.0,
        )  # fmt: skip

    def _plan_again(self, state: RobotState) -> bool:
        """Make the next plan from a state; return whether one was found, else stand by springs."""
        never = not math.isfinite(self.planned_at)
        passed = 0.0 if never else state.time - self.planned_at
        self.planned_at = state.time
        self._aim(state, passed)
        count = self.settings.first_iterations if never else self.settings.iterations
        try:
            begun = self._go_on(state, passed) if self._well else self._begin(state)
            if begun and all(self._iterate() for _ in range(count)):
                return True
        except SurefootError:  # a state that no step can be taken from
            pass
        self._stand_by()
        return False

    def _stand_by(self) -> None:
        """Take the nominal pose for a plan, followed by springs."""
        now, still = self.iteration.now, self._standing()
        now.q[:], now.v[:], now.torques[:], now.impulses[:] = still.q, still.v, still.torques, 0.0
        self.iteration.gains[:] = self._springs

    def _aim(self, state: RobotState, passed: float) -> None:
        """Write the wanted motion into the cost: heading and velocities over the horizon."""
        level = heading_of(state.q[3:7])
        heading = math.atan2(level[1], level[0])
        if not math.isfinite(self._yaw):
            self._yaw = heading
        # The command is approached at a bounded acceleration: the horizon is asked for no jump of velocity.
        most = RAMP * passed
        wanted = self.command.at(state.time)
        self._velocity += np.clip(wanted - self._velocity, -most, most)
        # The wanted heading integrates the wanted turn, so that what a disturbance turned is turned back; it
        # leads the robot's by LEAD at most, so that a body that is held is not asked for all the turn it
        # missed.
        ahead = self._yaw + passed * self._velocity[2] - heading
        self._yaw = heading + min(max((ahead + math.pi) % (2.0 * math.pi) - math.pi, -LEAD), LEAD)
        yaw = self._yaw + self.settings.dt * self._velocity[2] * np.arange(self.settings.knots + 1)
        c, s = np.cos(yaw), np.sin(yaw)
        _, q, v = self.iteration.tables.state
        q[:, :2] = state.q[:2]
        q[:, 2] = self._pose[2] + float(self._terrain.height(state.q[:2]))
        q[:, 3:7] = quaternion_about([0.0, 0.0, 1.0], yaw)
        v[:, 0] = c * self._velocity[0] - s * self._velocity[1]
        v[:, 1] = s * self._velocity[0] + c * self._velocity[1]
        v[:, 5] = self._velocity[2]

    def _begin(self, state: RobotState) -> bool:
        """Start a plan from scratch: torques that hold the robot, and a little noise."""
        s, still, iteration = self.settings, self._standing(), self.iteration
        noise = np.random.default_rng(s.seed).normal(size=still.torques.shape)
        iteration.now.q[0], iteration.now.v[0] = state.q, state.v
        return iteration.choose([(still._replace(steps=s.noise * noise), 1.0), (still, 0.0)], -math.inf) >= 0

    def _go_on(self, state: RobotState, passed: float) -> bool:
        """Move the last plan on in time, and let it begin where the robot is."""
        iteration, dt = self.iteration, self.settings.dt
        now, left = iteration.now, passed / dt
        if left > len(now):  # nothing is left of the plan
            return self._begin(state)
        while left > 0.0:
            move_on(self.robot, now.q, now.v, now.torques, min(left, 1.0), dt)
            left -= 1.0
        now.q[0], now.v[0] = state.q, state.v
        return iteration.take(now.q, now.v, now.torques)

    def _iterate(self) -> bool:
        """Take one step of the solver from the last plan, gaps and all; return whether there is a new one."""
        iteration, s = self.iteration, self.settings
        enough, policy = ENOUGH * iteration.now.cost + SMALL, iteration.policy
        candidates = [self._track(policy), (self._standing(), 0.0)]
        if iteration.differentiate(s.smoothing) and iteration.backward():
            candidates = [*((policy, share) for share in s.shares), *candidates]
        best = iteration.choose(candidates, enough)
        if best < 0:
            return False
        if candidates[best][0] is policy and candidates[best][1] >= 0.5:
            iteration.damping = max(0.3 * iteration.damping, s.damping)
        else:
            iteration.damping = min(3.0 * iteration.damping, MOST)
        return True

    def _track(self, policy: FeedbackPolicy) -> tuple[FeedbackPolicy, float]:
        """Return the policy that follows a motion by springs and dampers at the joints."""
        return policy._replace(gains=self._still.gains), 0.0

    def _standing(self) -> FeedbackPolicy:
        """Return the policy that holds the nominal pose where the robot is."""
        now, still = self.iteration.now, self._still
        still.q[:, :7] = now.q[0, :7]
        return still


def _springs(knots: int, nv: int, stiffness: FloatArray, damping: FloatArray) -> FloatArray:
    """Return gains (N, m, 2nv) of springs and dampers (m,) at the joints."""
    m = len(stiffness)
    gains = np.zeros((knots, m, 2 * nv))
    for i in range(m):
        gains[:, i, nv - m + i], gains[:, i, 2 * nv - m + i] = -stiffness[i], -damping[i]
    return gains
