"""Jump: the feet leave the ground together and land further on, or where they were."""

from __future__ import annotations

import math

import numpy as np

from surefoot.base.arrays import FloatArray, real_number
from surefoot.base.errors import ProblemError
from surefoot.base.spatial import rotation_from_quaternion, rotation_log
from surefoot.mechanics import FlatTerrain, Robot
from surefoot.motion.planning.plan import Plan
from surefoot.motion.planning.tasks.scheduled import PATIENCE, mover, scheduled_plan
from surefoot.motion.planning.tasks.task import PlanRequest, Tell
from surefoot.motion.planning.trajectory import Trajectory

MORE, HIGHER = 0.03, 0.015
"""What is planned beyond what is asked for, along the ground and up [m]: an execution loses a little."""
SHORT = 0.01
"""How much less than asked for still is a jump of that length or height [m]."""
ASIDE = 0.05
"""How far beside its way a jump may end [m]."""
LEAN, SLOW = math.radians(6.0), 0.15
"""Largest tilt [rad] and speed [m/s, rad/s] at the end."""


class Jump:
    """A jump along the ground: the number is how far the feet get."""

    name, amount, default, robots = "jump", "distance [m]", 0.4, True
    takes: tuple[str, ...] = ("start", "payload", "direction", "turn", "terrain", "over", "near")
    up = False

    def plan(self, request: PlanRequest, tell: Tell) -> Plan:
        """Return the plan of a jump, see `Task.plan`."""
        from surefoot.motion.planning.schedule.motions import begun, jump, landing_configuration, time_scale
        from surefoot.motion.planning.stepped_ground import climb_of, gap_before, least_way

        robot, ground = mover(request), request.terrain or FlatTerrain()
        reach = 3.0 * float(robot.nominal[2])
        asked = request.amount
        if asked is None:  # as far as a gap takes
            stood = robot.nominal if request.start is None else request.start
            asked = min(math.ceil(100.0 * least_way(robot, stood, request.over)) / 100.0, reach)
        real_number(self.amount, asked, low=0.0 if self.up else -reach, high=reach)
        if self.up and asked < 0.02:
            raise ProblemError(f"height [m] must be at least 0.02, got {asked:g}")
        more = (HIGHER if self.up else MORE) * time_scale(robot) ** 2
        far = 0.0 if self.up or not asked else asked + math.copysign(more, asked)
        rise = asked + more if self.up else 0.0
        way = request.direction, request.turn
        q = begun(robot, ground, far) if request.start is None else request.start
        there = landing_configuration(robot, q, asked * (not self.up), way, ground)
        if request.over:
            ground = gap_before(robot, q, there, request.over)
        climb = climb_of(ground, robot, q, landing_configuration(robot, q, far, way, ground))
        problem = jump(robot, far, rise, request.mu, request.dt, way, q, ground)

        def goal(motion: Trajectory) -> tuple[bool, str]:
            got, off, words = float(motion.q[:, 2].max() - q[2]), 0.0, "rises by"
            if not self.up:
                got, off = _progress_of(robot, q, there, motion, climb)
                got, words = math.copysign(1.0, asked) * got, "the feet get"
            still, said = at_rest(motion, there)
            flown = bool((motion.impulses[..., 2] <= 0.0).all(axis=1).any())
            enough = abs(got) >= abs(asked) - SHORT and got * asked >= 0.0 and off <= ASIDE
            said = f"{words} {got:.3f} m of {asked:g} asked for, {said}"
            return bool(enough and still and flown), said

        return scheduled_plan(self.name, problem, request, tell, goal, PATIENCE * (1 + self.up))


class JumpUp(Jump):
    """A jump in place: the number is how high the base rises above where it stood."""

    name, amount, default = "jump-up", "height [m]", 0.15
    takes = ("start", "payload", "turn", "terrain", "near")
    up = True


def _progress_of(
    robot: Robot, q: FloatArray, there: FloatArray, motion: Trajectory, climb: float
) -> tuple[float, float]:
    """Return how far the feet's middle got on the way from (nq,) q to (nq,) there, and how far off it [m].

    What they climb on steps is left out. Of a jump that turns on the spot the second is all there is.
    """
    first, last = (robot.foot_positions(at).mean(axis=0) for at in (q, there))
    way = np.asarray((motion.positions[-1] - motion.positions[0]).mean(axis=0)) - [0.0, 0.0, climb]
    length = float(np.linalg.norm(last - first))
    along = float(way @ (last - first)) / length if length > 0.0 else 0.0
    return along, float(np.linalg.norm(way - along * (last - first) / max(length, 1e-9)))


def at_rest(motion: Trajectory, there: FloatArray) -> tuple[bool, str]:
    """Return whether a motion ends as (nq,) there is turned, slow and on all feet, and how, in words."""
    rotation, wanted = (rotation_from_quaternion(q[3:7]) for q in (motion.q[-1], there))
    tilt = float(np.linalg.norm(rotation_log(wanted.T @ rotation)))
    speed, down = float(np.abs(motion.v[-1, :6]).max()), bool((motion.impulses[-1, :, 2] > 0.0).all())
    feet = "on all feet" if down else "not on all feet"
    said = f"ends {math.degrees(tilt):.1f} deg off its attitude at {speed:.2f} m/s, {feet}"
    return tilt <= LEAN and speed <= SLOW and down, said


JUMP, JUMP_UP = Jump(), JumpUp()
