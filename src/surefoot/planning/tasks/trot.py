"""Trot: walking at a speed whose gait nobody gives; the contact-implicit controller finds it, step by step.

The plan is what the controller does in exact steps from standing: a receding horizon, not one optimum. Which
feet touch when comes out of its cost, see `surefoot.planning.mpc.cost`.
"""

from __future__ import annotations

import math
import time as clock

import numpy as np

from surefoot.arrays import BoolArray, FloatArray, real_number
from surefoot.contact import Status
from surefoot.planning.plan import Plan, Search, plan_from
from surefoot.planning.tasks.jump import lean
from surefoot.planning.tasks.task import Iteration, PlanRequest, Tell
from surefoot.planning.trajectory import Trajectory, rollout
from surefoot.robot import Robot, load_robot, place

ROAD = "contact-implicit"
STEP, LENGTH = 2e-3, 3.0
"""Length of a knot and of the motion [s]."""
JUDGED = 1.0
"""Time at the end over which speed and gait are judged [s]."""
OFF, MOST_LEAN = 0.25, math.radians(15.0)
"""Largest share by which the speed may be off, and largest tilt [rad]."""
PAIRED = 0.6
"""Least correlation of diagonal legs' contacts, above that of any other pairs, that is called a trot."""


class Trot:
    """Walk at a speed, the gait found: the number is the speed forward."""

    name, meaning = "trot", "walk at a speed; the gait is found, not given"
    amount, default, robots = "speed [m/s]", 0.5, True
    roads: tuple[str, ...] = (ROAD,)

    def plan(self, request: PlanRequest, tell: Tell) -> Plan:
        """Return what the contact-implicit controller does, see `Task.plan`."""
        from surefoot.control.controller import RobotState
        from surefoot.control.walking_body import VelocityCommand
        from surefoot.planning.mpc.controller import ContactImplicitMpc, MpcSettings

        robot = request.robot or load_robot("go2")
        speed = real_number(self.amount, self.default if request.amount is None else request.amount)
        dt = request.dt or STEP
        steps = request.knots or round(LENGTH / dt)
        settings = MpcSettings(mu=request.mu, seed=request.seed)
        mpc = ContactImplicitMpc(robot, VelocityCommand.constant(speed, 0.0, 0.0), None, settings, dt)
        start, every = clock.perf_counter(), max(1, round(settings.interval / dt))
        interrupted = False

        def policy(k: int, q: FloatArray, v: FloatArray) -> FloatArray:
            nonlocal interrupted
            if interrupted:
                return np.zeros(robot.joints)
            try:
                torques = mpc.step(RobotState(q, v, k * dt)).torques
                if k % every == 0:
                    tell(Iteration(k // every + 1, float(mpc.engine.now.cost), 0.0, f"{k * dt:.2f} s"))
            except KeyboardInterrupt:
                interrupted = True
                return np.zeros(robot.joints)
            return torques

        q = place(robot)
        motion = rollout(robot, q, np.zeros(int(robot.model.nv)), policy, dt=dt, mu=request.mu, steps=steps)
        done, said = judge(robot, motion, speed)
        spent, cost = clock.perf_counter() - start, float(mpc.engine.now.cost)
        search = Search(self.name, ROAD, cost, done, steps // every, spent, said, Status.STALLED)
        made = plan_from(motion, robot, search)
        if interrupted:
            made.facts["interrupted"] = True
        return made


def judge(robot: Robot, motion: Trajectory, speed: float) -> tuple[bool, str]:
    """Return whether a motion walks at a speed [m/s] with its diagonal legs together, and what it does."""
    if not np.isfinite(motion.q).all():
        return False, "the motion is lost"
    rows = slice(max(0, len(motion) - round(JUDGED / motion.dt)), len(motion))
    have = float((motion.q[rows.stop, 0] - motion.q[rows.start, 0]) / (motion.dt * (rows.stop - rows.start)))
    tilt = max(lean(q) for q in motion.q[:: max(1, len(motion) // 200)])
    point = motion.impulses[rows, :, 2] > 0.0
    foot = robot.contact_points.foot
    down = np.stack([point[:, foot == k].any(axis=1) for k in range(len(robot.feet))], axis=1)
    gait = gait_of(robot, down)
    said = f"walks at {have:.2f} of {speed:g} m/s, leans at most {math.degrees(tilt):.0f} deg, {gait}"
    good = abs(have - speed) <= OFF * abs(speed) and tilt <= MOST_LEAN and gait == "trots"
    return bool(good), said


def gait_of(robot: Robot, down: BoolArray) -> str:
    """Return which legs of (T, 4) contacts move together, in a word; feet in the robot's own order."""
    from surefoot.planning.schedule.symmetry import quadruped_order

    order = quadruped_order(robot)
    pairs = {"trots": ((0, 3), (1, 2)), "paces": ((0, 2), (1, 3)), "bounds": ((0, 1), (2, 3))}
    moving = down[:, order].astype(np.float64)
    if (moving.std(axis=0) < 1e-9).any():
        return "keeps a foot on the ground, or in the air, all the time"
    like = np.asarray(np.corrcoef(moving.T)).reshape(4, 4)
    share = {name: float(np.mean([like[a, b] for a, b in two])) for name, two in pairs.items()}
    best = max(share, key=lambda name: share[name])
    return best if share[best] >= PAIRED else "has no regular gait"


TROT = Trot()
