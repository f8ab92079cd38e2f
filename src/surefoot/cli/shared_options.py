"""Options that several commands have in common, each defined once."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, TypeAlias

import typer

RobotName: TypeAlias = Annotated[
    str | None, typer.Argument(help="A known robot (default go2); see --urdf for others.")
]
Urdf: TypeAlias = Annotated[Path | None, typer.Option(help="A URDF file instead of a known robot.")]
FootFrames: TypeAlias = Annotated[str | None, typer.Option(help="Foot frames, comma-separated.")]
LogRobot: TypeAlias = Annotated[
    str | None, typer.Option(help="Name or URDF of the robot, where the log does not name it.")
]
Facets: TypeAlias = Annotated[str, typer.Option(help="Sides of friction pyramids, or 'exact'.")]
Fit: TypeAlias = Annotated[str, typer.Option(help="Pyramids inside or around the cones: inner or outer.")]
PictureOut: TypeAlias = Annotated[Path, typer.Option(help="Parent of the new folder for the picture.")]
AsJson: TypeAlias = Annotated[bool, typer.Option("--json", help="Print JSON and nothing else.")]
