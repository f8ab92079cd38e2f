"""Whether a run counts as survived, and whether its task was done within its bounds."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass, field
from typing import Any

from benchmarks.stacks.measures import Measures
from benchmarks.stacks.tasks import Bound, Task
from surefoot.records.log import Ending

SPEED_SHARE, SPEED_FLOOR = 0.2, 0.1
"""A robot is on course whose velocity is off by at most this share, or this much [m/s, rad/s] ..."""
HEADING = 15.0
"""... and whose heading is off by at most this at the end [deg]."""


@dataclass(frozen=True)
class Trial:
    """What became of one stack in one task with one seed.

    Attributes
    ----------
    stack, task, seed
        Which.
    outcome
        "done", or how the run ended: "fell", "lost", "invalid", "refused" by the stack.
    why
        Why it ended, or was refused, or what the stack changed in its command.
    measures
        See there; of a run that ended early, of what there is.
    step_us, step_p99_us
        CPU time of the controller's steps: mean over all steps of the world, and 99th percentile of those in
        which it computed [us].
    real_time
        Simulated time over the CPU time of the whole loop: controller, estimator, world and log.
    duration
        Simulated [s].
    """

    stack: str
    task: str
    seed: int
    outcome: str
    why: str = ""
    measures: Measures = field(default_factory=Measures)
    step_us: float = math.nan
    step_p99_us: float = math.nan
    real_time: float = math.nan
    duration: float = 0.0

    @property
    def upright(self) -> bool:
        """Whether it was on its feet to the end."""
        return self.outcome == Ending.DONE

    @property
    def lawful(self) -> bool:
        """Whether the motion kept the laws of contact."""
        return self.upright and not self.measures.laws

    def on_course(self, asked: tuple[float, float, float]) -> bool:
        """Return whether it went where it was asked to: velocity, yaw rate and heading."""
        m, allowed = self.measures, max(SPEED_SHARE * math.hypot(*asked[:2]), SPEED_FLOOR)
        turning = max(SPEED_SHARE * abs(asked[2]), SPEED_FLOOR)
        heading = HEADING + math.degrees(SPEED_SHARE * abs(asked[2])) * self.duration
        return bool(
            self.upright and m.velocity_error <= allowed and m.turn_error <= turning
            and abs(m.heading) <= heading
        )  # fmt: skip

    def survived(self, asked: tuple[float, float, float]) -> bool:
        """Return whether it was upright, on course and lawful."""
        return self.on_course(asked) and self.lawful

    def missed(self, task: Task) -> tuple[Bound, ...]:
        """Return the bounds of the task that it did not keep."""
        values = asdict(self.measures) | {"real_time": self.real_time}
        return tuple(bound for bound in task.bounds if not bound.kept(values[bound.measure]))

    def held(self, task: Task, asked: tuple[float, float, float]) -> bool:
        """Return whether it survived within the task's bounds."""
        return self.survived(asked) and not self.missed(task)

    def faults(self, task: Task, asked: tuple[float, float, float]) -> tuple[str, ...]:
        """Return what was wrong, in words that can be counted."""
        if not self.upright:
            return (self.outcome if not self.why else f"{self.outcome}: {self.why}",)
        course = () if self.on_course(asked) else ("off course: slowed" if self.why else "off course",)
        laws = tuple(_without_numbers(law) for law in self.measures.laws)
        return (*course, *laws, *(str(bound) for bound in self.missed(task)))

    def as_dict(self) -> dict[str, Any]:
        """Return the fields by name, for JSON."""
        return asdict(self)

    @classmethod
    def from_dict(cls, given: dict[str, Any]) -> Trial:
        """Return the trial of `as_dict`, numbers that JSON does not have as NaN."""
        values: dict[str, Any] = {k: math.nan if v is None else v for k, v in given["measures"].items()}
        rest: dict[str, Any] = {k: math.nan if v is None else v for k, v in given.items() if k != "measures"}
        values["laws"] = tuple(values["laws"])
        return cls(measures=Measures(**values), **rest)


def _without_numbers(law: str) -> str:
    """Return the name of a broken law: its line without figures, which differ from run to run."""
    for word in ("penetration", "pull", "cone", "off the ground", "without friction"):
        if word in law:
            return f"law: {word}"
    return "law: not finite"
