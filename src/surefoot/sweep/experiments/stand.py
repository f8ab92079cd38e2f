"""A robot stands."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

from surefoot.sweep.bodies import ground
from surefoot.sweep.experiments.robot_run import RobotRun, known_robot
from surefoot.sweep.space import Sample


@dataclass(frozen=True)
class Stand(RobotRun):
    """A robot stands under the standing controller; it survives if `surefoot stand` would call it "stood"."""

    columns: ClassVar[Mapping[str, str]] = {
        **RobotRun.columns,
        "moved": "float",  # the base, from where it started to where it ended [m]
    }
    chunk: ClassVar[int] = 2

    def run(self, sample: Sample) -> dict[str, Any]:
        """Return how the robot stood."""
        from surefoot.audit import summarise_stand
        from surefoot.control.standing import StandingController
        from surefoot.control.standing_plan import StandingPlan
        from surefoot.robot import place
        from surefoot.simulation.scenario import STANDING_FALL, START_DEPTH

        robot, terrain = known_robot(self.robot), ground(sample)
        q = place(robot, terrain)
        plan = StandingPlan(robot, terrain, q, [])
        believed = sample.number("believed_mu", self.believed_mu)
        controller = StandingController(robot, plan, terrain, q, believed)
        still = {"start": q, "depth": START_DEPTH, "fall": STANDING_FALL}
        log = self.log(sample, robot, terrain, controller, **still)
        summary = summarise_stand(log)
        out = self.measured(log, summary, summary.base.tilt_max_deg)
        return {**out, "moved": summary.base.position_end}
