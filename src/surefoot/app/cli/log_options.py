"""What a command is given of a log: which field is what, whose it is, on which ground it walked."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from surefoot.app.cli import options, parsing
from surefoot.base.arrays import real_number
from surefoot.base.errors import ModelError

if TYPE_CHECKING:
    from surefoot.mechanics import Robot, Terrain
    from surefoot.records import Log


@dataclass(frozen=True)
class LogOptions:
    """What the log does not tell itself."""

    robot: options.LogRobot = None
    mapping: Annotated[
        Path | None, typer.Option(help="YAML file that says which of its fields is which channel.")
    ] = None
    terrain: Annotated[
        str | None,
        typer.Option(help="Ground, of the log or of its replay: flat, slope:DEG, stairs:HEIGHT,DEPTH, ..."),
    ] = None
    mu: Annotated[float | None, typer.Option(help="Friction where the log tells none, or of the replay.")] = (
        None
    )
    mass: Annotated[
        float | None, typer.Option(help="Of all that moves, where the log does not tell it [kg].")
    ] = None
    columns: Annotated[
        str | None,
        typer.Option(help="Names of a table's columns, with commas, where its first line has none."),
    ] = None

    rate: Annotated[
        float | None, typer.Option(help="Rows a second of a table that has no column of time [Hz].")
    ] = None

    def names(self) -> list[str] | None:
        """Return the names of the columns."""
        return None if self.columns is None else [name.strip() for name in self.columns.split(",")]

    def ground(self) -> Terrain | None:
        """Return the terrain."""
        from surefoot.mechanics import read_terrain

        return None if self.terrain is None else read_terrain(self.terrain, "--terrain")

    def read(self, path: Path) -> tuple[Log, Robot | None]:
        """Return the log of a file and the robot, whose feet are those that the log names if it is a file."""
        from surefoot.app.cli.robots import is_file
        from surefoot.mechanics import load_robot
        from surefoot.records import read_log

        if self.mu is not None:
            parsing.friction("--mu", self.mu)
        if self.mass is not None:
            real_number("--mass", self.mass, low=1e-6, high=1e9)
        if self.rate is not None:
            real_number("--rate", self.rate, low=1e-6, high=1e9)
        log = read_log(path, self.mapping, self.names(), self.rate)
        if self.robot is None:
            return log, None
        feet = _feet_of(log) if is_file(self.robot) else []
        try:
            return log, load_robot(self.robot, feet or None)
        except ModelError:
            if not feet or "contact_is_foot" not in log.facts:
                raise
            # a recording names shapes, and the file may have no frames of such names
            return log, load_robot(self.robot)

    def complete_log(self, log: Log, robot: Robot | None, *, replayed: bool) -> Log:
        """Return a log with what follows from it and the options; a replay's contradict nothing."""
        from surefoot.records.log.log_completion import complete

        ground, mu = self.ground(), self.mu
        if replayed:
            ground = None if "gaps" in log or "terrain" in log.facts else ground
            mu = None if "mu" in log or "contact_friction" in log else mu
        if "mapping" not in log.facts and ground is None and mu is None and self.mass is None:
            return log
        return complete(log, robot, ground, mu, self.mass)


def _feet_of(log: Log) -> list[str]:
    """Return the feet that a log names, of a recording those that are by its model: links touch in falls."""
    names, owner = [*map(str, log.facts.get("feet", ()))], log.facts.get("contact_foot", ())
    is_foot = log.facts.get("contact_is_foot")
    if is_foot is None:
        return names
    feet = {k for k, foot in zip(owner, is_foot, strict=True) if foot}
    return [name for k, name in enumerate(names) if k in feet]
