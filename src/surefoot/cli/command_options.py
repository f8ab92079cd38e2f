"""How a walking controller's commands reach the motors, and what is put around the controller for that."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from surefoot.errors import ProblemError, check_name

if TYPE_CHECKING:
    from surefoot.cli.scenario_file import ScenarioFile
    from surefoot.control.controller import Controller

KINDS = ("torques", "targets")
"""What drives can be commanded."""
WORLD_RATE = 1000
"""Steps of the world in a second."""


@dataclass(frozen=True)
class Wiring:
    """How commands reach the motors.

    Attributes
    ----------
    targets
        Whether joints get targets.
    every
        Steps of the world in a step of the controller.
    latency
        Delay that is allowed for [s]; None to measure it.
    dropouts
        (start, duration) of times without a fresh state [s].
    """

    targets: bool = False
    every: int = 1
    latency: float | None = None
    dropouts: tuple[tuple[float, float], ...] = ()

    @property
    def plain(self) -> bool:
        """Whether nothing was asked for."""
        return not self.targets and self.every == 1 and self.latency is None and not self.dropouts

    @property
    def dt(self) -> float:
        """Length of the controller's step [s]."""
        return self.every / WORLD_RATE

    def around(self, controller: Controller, robot: Any) -> Controller:
        """Return what commands the motors, for a controller with steps of `dt`."""
        from surefoot.drive.joint_targets import Held, JointTargetController, TargetSettings
        from surefoot.drive.latency import LatencyCompensation
        from surefoot.drive.watchdog import Watchdog

        step = 1.0 / WORLD_RATE
        if self.targets:
            controller = JointTargetController(controller, robot, step, TargetSettings(every=self.every))
        elif self.every > 1:
            controller = Held(controller, self.every)
        if self.latency is None or self.latency > 0.0:
            controller = LatencyCompensation(controller, robot, step, self.latency)
        if self.dropouts or self.targets:
            controller = Watchdog(controller, robot, step)
        return controller


def wiring(commands: str, dropouts: Sequence[tuple[float, float]], said: ScenarioFile) -> Wiring:
    """Return what options and scenario say, or raise for what they cannot mean."""
    check_name("--commands", commands, KINDS)
    every = round(WORLD_RATE / said.control_rate)
    if abs(every * said.control_rate - WORLD_RATE) > 1e-6 * WORLD_RATE:
        raise ProblemError(
            f"control_rate must be 1000 over a whole number, as 500 or 250, got {said.control_rate:g}"
        )
    latency = None if isinstance(said.latency, str) else said.latency
    return Wiring(commands == "targets", every, latency, tuple(dropouts))
