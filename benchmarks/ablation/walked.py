"""One trial of an ablation: a walk in the stacks' world, with a behaviour left out or none."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

from benchmarks.ablation.parts import TASKS
from benchmarks.stacks.stack import Job, Surefoot, Timed, TimedController
from benchmarks.stacks.trial import asked_velocity, carry_out
from surefoot.motion.drive.latency_compensation import LatencyCompensation
from surefoot.motion.ground.terrain_knowledge import controller_ground
from surefoot.motion.ground.touched_ground import TouchedGround as TouchedGround
from surefoot.motion.walking.behaviours import BEHAVIOURS, MakeBehaviour
from surefoot.motion.walking.walking_body import VelocityCommand
from surefoot.motion.walking.walking_controller import WalkingController, WalkSettings


def behaviour_name(make: MakeBehaviour) -> str:
    """Return the name of the behaviour that something makes: its class, or a method of it."""
    return str(getattr(getattr(make, "__self__", make), "name", ""))


@dataclass(frozen=True)
class Walked(Surefoot):
    """Surefoot's walk on four feet without a behaviour, or with all; its own walk of other robots.

    Attributes
    ----------
    without
        The behaviour's name; empty for none.
    watch
        Whether friction is found out.
    gait
        Name of the gait.
    """

    without: str = ""
    watch: bool = False
    gait: str = "trot"

    def controller(self, job: Job) -> TimedController:
        """See `Stack.controller`."""
        if len(job.robot.feet) == 2:
            return super().controller(job)
        kept = tuple(make for make in BEHAVIOURS if behaviour_name(make) != self.without)
        if self.without and len(kept) == len(BEHAVIOURS):
            raise LookupError(f"no behaviour {self.without!r}")
        settings = WalkSettings(mu=job.mu, watch_friction=self.watch, actuators=job.motors, behaviours=kept)
        walker = WalkingController(
            job.robot, VelocityCommand.constant(*job.asked), self.gait,
            controller_ground(job.knowledge, job.terrain), settings, job.dt,
        )  # fmt: skip
        return Timed(walker, LatencyCompensation(walker, job.robot, job.dt))


def carry_out_task(name: str, seed: int, without: str = "", longest: float | None = None) -> dict[str, Any]:
    """Return what became of a task with a seed: whether it was done, and its measures."""
    task = TASKS[name]
    task = replace(task, duration=min(task.duration, longest or task.duration))
    trial = carry_out(Walked(without, task.watch, task.gait), task, seed)
    done = trial.upright if task.stops else trial.survived(asked_velocity(task))
    m = trial.measures
    error = math.nan if task.stops else m.velocity_error  # it should not go on
    return {
        "task": name, "seed": seed, "done": done, "upright": trial.upright, "error": error,
        "cost": m.cost_of_transport, "friction": m.friction_use, "load": m.load, "hits": m.hits,
        "why": trial.why[:200],
    }  # fmt: skip
