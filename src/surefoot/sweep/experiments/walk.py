"""A robot walks."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

from surefoot.errors import ProblemError, unknown_name
from surefoot.sweep.bodies import ground
from surefoot.sweep.experiments.robot_run import RobotRun, known_robot
from surefoot.sweep.space import Sample, Space


@dataclass(frozen=True)
class Walk(RobotRun):
    """A robot walks under the walking controller; it survives if `surefoot walk` would call it "walked".

    Unlike there, its controller is told the true state.

    Attributes
    ----------
    gait
        A name of `surefoot.gait_names()`.
    speed
        Commanded forward velocity where the sweep does not draw it [m/s].
    """

    parameters: ClassVar[tuple[str, ...]] = (*RobotRun.parameters, "speed")
    columns: ClassVar[Mapping[str, str]] = {
        **RobotRun.columns,
        "velocity": "float",  # mean forward velocity after 2 s, or of all if it ended before [m/s]
    }

    limits: ClassVar[Mapping[str, tuple[float, float]]] = {**RobotRun.limits, "speed": (-10.0, 10.0)}

    gait: str = "trot"
    speed: float = 0.5
    duration: float = 4.0

    def __post_init__(self) -> None:
        from surefoot.control.gait_library import gait_names

        super().__post_init__()
        if self.gait not in gait_names() or self.gait == "stand":
            walks = [name for name in gait_names() if name != "stand"]
            raise ProblemError(unknown_name("gait", self.gait, walks))

    def check(self, space: Space) -> None:
        """Refuse robots that cannot walk, too."""
        super().check(space)
        self._controller(Sample(0, 0, {}))

    def run(self, sample: Sample) -> dict[str, Any]:
        """Return how the robot walked."""
        from surefoot.audit import summarise_walk
        from surefoot.simulation.walk_terrain import start_pose

        controller = self._controller(sample)
        robot, terrain = controller.robot, controller.terrain
        log = self.log(sample, robot, terrain, controller, start=start_pose(robot, terrain))
        summary = summarise_walk(log)
        out = self.measured(log, summary, summary.tilt_max_deg)
        return {**out, "velocity": summary.velocity.forward.measured}

    def _controller(self, sample: Sample) -> Any:
        from surefoot.control.walking import WalkingController, WalkSettings
        from surefoot.control.walking_body import VelocityCommand

        command = VelocityCommand.constant(sample.number("speed", self.speed))
        settings = WalkSettings(mu=sample.number("believed_mu", self.believed_mu))
        return WalkingController(known_robot(self.robot), command, self.gait, ground(sample), settings)
