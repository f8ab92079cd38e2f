"""A learned policy as a stack: a network and its description, told what the other stacks are told."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks.stacks.stack import START, Job, TimedController, ramp_time, ramped
from benchmarks.timing import Stopwatch
from surefoot.base.arrays import FloatArray
from surefoot.mechanics.robot.rotors import with_rotors
from surefoot.motion.policy.policy import Policy
from surefoot.motion.policy.publishers import robot_of
from surefoot.motion.walking.walking_body import VelocityCommand

PERIOD = 0.5
"""A gait's period where nobody says one: seeds push at its phases [s]."""


@dataclass(frozen=True)
class LearnedStack:
    """A policy of a file, see `benchmarks.stacks.stack.Stack`.

    Attributes
    ----------
    network
        The file; its description stands beside it.
    """

    network: Path

    @property
    def name(self) -> str:
        """See `Stack.name`."""
        return self.network.stem

    def missing(self) -> str:
        """See `Stack.missing`."""
        return "" if self.network.is_file() else f"{self.network}: no such file"

    def walks(self, robot: str) -> bool:
        """See `Stack.walks`."""
        return robot == (robot_of(self.network) or "go2")

    def version(self) -> str:
        """See `Stack.version`."""
        return f"sha256 {hashlib.sha256(self.network.read_bytes()).hexdigest()[:16]}"

    def controller(self, job: Job) -> TimedController:
        """See `Stack.controller`; its command grows as that of all."""
        height = float(job.robot.nominal[2])
        times = np.arange(0.0, ramp_time(job.asked, height) + 0.02, 0.02)
        command = VelocityCommand(times, np.array([ramped(job.asked, t, height) for t in times]))
        robot = job.robot if job.motors is None else with_rotors(job.robot, job.motors.armature)
        return TimedPolicy(Policy(self.network, None, robot, command, terrain=job.terrain, dt=job.dt))


class TimedPolicy(Stopwatch):
    """A policy, each of its steps timed."""

    apart = False
    starts = gait_start = START
    gait_period = PERIOD

    def __init__(self, policy: Policy) -> None:
        super().__init__(policy)
        self.posture: FloatArray | None = policy.posture

    def close(self) -> None:
        """See `TimedController.close`."""
