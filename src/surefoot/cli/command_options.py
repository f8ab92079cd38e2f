"""How a walking controller's commands reach the motors: options, and what they put around the controller."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any, TypeAlias

import typer

from surefoot.errors import ProblemError, unknown_name

if TYPE_CHECKING:
    from surefoot.control.controller import Controller

Commands: TypeAlias = Annotated[
    str, typer.Option(help="torques, or targets: joint angles, speeds, gains and torques for the drives.")
]
ControlRate: TypeAlias = Annotated[
    float, typer.Option(help="Steps of the controller in a second; drives go on at 1000.")
]
Latency: TypeAlias = Annotated[
    str, typer.Option(help="Delay that the controller allows for: auto, which measures it, none, or [s].")
]
Dropouts: TypeAlias = Annotated[
    list[str] | None, typer.Option("--dropout", help="T:DURATION without a fresh state [s]; repeatable.")
]
KINDS = ("torques", "targets")
"""What drives can be told."""
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
        from surefoot.control.joint_targets import Held, JointTargetController, TargetSettings
        from surefoot.control.latency import LatencyCompensation
        from surefoot.control.watchdog import Watchdog

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


def wiring(commands: str, rate: float, latency: str, dropouts: list[str] | None) -> Wiring:
    """Return what the options say, or raise for what they cannot mean."""
    from surefoot.cli import parsing
    from surefoot.control.latency import LONGEST

    if commands not in KINDS:
        raise ProblemError(unknown_name("--commands", commands, KINDS))
    every = round(WORLD_RATE / rate) if rate > 0.0 else 0
    if not (1 <= every <= 50) or abs(every * rate - WORLD_RATE) > 1e-6 * WORLD_RATE:
        raise ProblemError(
            f"--control-rate must be 1000 over a whole number up to 50, as 500 or 250, got {rate:g}"
        )
    allowed = {"auto": None, "none": 0.0}
    delay = allowed[latency] if latency in allowed else parsing.number("--latency", latency)
    if delay is not None and not 0.0 <= delay <= LONGEST:
        raise ProblemError(f"--latency must be auto, none or from 0 to {LONGEST:g} s, got {latency}")
    return Wiring(commands == "targets", every, delay, tuple(_dropout(text) for text in dropouts or ()))


def _dropout(text: str) -> tuple[float, float]:
    """Return start and duration of "T:DURATION" [s]."""
    from surefoot.cli import parsing

    start, colon, duration = text.partition(":")
    if not colon:
        raise ProblemError(f"--dropout is T:DURATION [s], got {text!r}")
    return parsing.number("--dropout", start), parsing.number("--dropout", duration)
