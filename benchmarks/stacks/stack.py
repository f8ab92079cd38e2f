"""What the bench needs of a walking stack: a controller for a job, and when it cannot make one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from benchmarks.stacks.setting import Motors
from benchmarks.timing import Stopwatch
from surefoot.base.arrays import FloatArray
from surefoot.base.spatial import GRAVITY
from surefoot.mechanics.robot import Robot
from surefoot.mechanics.terrain import Terrain
from surefoot.motion.control.controller import Controller
from surefoot.motion.drive.latency_compensation import LatencyCompensation
from surefoot.motion.ground.terrain_knowledge import controller_ground
from surefoot.motion.walking.body_settings import BODY_MOTION
from surefoot.motion.walking.walkers import walking_controller
from surefoot.motion.walking.walking_body import VelocityCommand
from surefoot.motion.walking.walking_controller import WalkSettings

START = WalkSettings().start
"""Time that a robot stands before it is asked to walk [s]."""


@dataclass(frozen=True)
class Job:
    """What a stack is asked to do, and all that it is told beforehand.

    Attributes
    ----------
    robot
        As its documents have it: the true one differs in mass.
    asked
        (forward, left, yaw rate) [m/s, rad/s]; the bench lets peers stand for `START` and ramps the
        command as Surefoot's own, see `ramped`.
    terrain
        The true ground; a stack plans on it as far as `knowledge` goes.
    knowledge
        "exact" or "map", see `Task`.
    mu
        Friction that it may count on.
    motors
        The robot's motors, None for ideal ones.
    dt
        Time between steps [s].
    """

    robot: Robot
    asked: tuple[float, float, float]
    terrain: Terrain
    mu: float
    motors: Motors = None
    knowledge: str = "exact"
    dt: float = 1e-3


class TimedController(Controller, Protocol):
    """A controller whose steps are timed.

    Attributes
    ----------
    cpu
        CPU time of every step so far [s]: of all threads, of its own process.
    apart
        Whether that is a process of its own.
    starts
        When it begins to follow its command, having stood so far [s].
    gait_start
        When a cycle of the gait began [s].
    posture
        (nq,) pose whose joints it starts from [m, -, rad]; None for the robot's nominal one.
    """

    cpu: list[float]
    apart: bool
    starts: float
    gait_start: float
    posture: FloatArray | None

    @property
    def gait_period(self) -> float:
        """How long a cycle of the gait takes [s]."""

    def close(self) -> None:
        """Let go of what the controller holds, as a process."""


class Stack(Protocol):
    """A walking stack."""

    @property
    def name(self) -> str:
        """On the command line, and in tables."""

    def missing(self) -> str:
        """Return why it cannot run here, in one line; empty where it can."""

    def walks(self, robot: str) -> bool:
        """Return whether it is made for a robot."""

    def version(self) -> str:
        """Return what was measured, so that it can be measured again."""

    def controller(self, job: Job) -> TimedController:
        """Return a controller for a job.

        Raises
        ------
        SurefootError
            Where the stack refuses the job; the message is the reason.
        """


def ramped(asked: Sequence[float], time: float, height: float, start: float = START) -> FloatArray:
    """Return the (3,) command at a time [s] for a constant velocity that is asked for from `start` on.

    It grows by 0.12 g, and by 0.12 g over the height [m] for turning.

    >>> ramped((0.5, 0.0, 0.0), 0.3, 0.3).tolist(), ramped((0.5, 0.0, 0.0), 2.0, 0.3).tolist()
    ([0.0, 0.0, 0.0], [0.5, 0.0, 0.0])
    """
    most = BODY_MOTION.acceleration * GRAVITY * max(time - start, 0.0) * np.array([1.0, 1.0, 1.0 / height])
    return np.asarray(np.clip(np.asarray(asked, dtype=np.float64), -most, most))


def ramp_time(asked: Sequence[float], height: float, start: float = START) -> float:
    """Return when the command of `ramped` is the asked one [s]."""
    rates = BODY_MOTION.acceleration * GRAVITY * np.array([1.0, 1.0, 1.0 / height])
    return start + float((np.abs(np.asarray(asked, dtype=np.float64)) / rates).max())


class Surefoot:
    """Surefoot's own walking controller, with the defaults of `surefoot walk`."""

    name = "surefoot"

    def missing(self) -> str:
        """See `Stack.missing`."""
        return ""

    def walks(self, robot: str) -> bool:
        """See `Stack.walks`."""
        return True

    def version(self) -> str:
        """See `Stack.version`."""
        import surefoot
        from benchmarks.stacks.pins import commit_of

        return f"surefoot {surefoot.__version__} {commit_of()}".strip()

    def controller(self, job: Job) -> TimedController:
        """See `Stack.controller`."""
        command = VelocityCommand.constant(*job.asked)
        ground = controller_ground(job.knowledge, job.terrain)
        walker = walking_controller(job.robot, command, None, ground, job.mu, job.motors, job.dt)
        return Timed(walker, LatencyCompensation(walker, job.robot, job.dt))


class Timed(Stopwatch):
    """A controller of this process, each of its steps timed.

    Parameters
    ----------
    walker
        Whose gait it is.
    outermost
        The same, or what is around it.
    """

    apart = False
    posture: FloatArray | None = None

    def __init__(self, walker: Any, outermost: Controller) -> None:
        super().__init__(outermost)
        self.starts = self.gait_start = walker.settings.start
        self._schedule = walker.schedule

    @property
    def gait_period(self) -> float:
        """Length of a cycle of the gait now [s]."""
        return float(self._schedule.period)

    def close(self) -> None:
        """See `TimedController.close`."""
