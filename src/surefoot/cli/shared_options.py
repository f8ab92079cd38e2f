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
StanceFile: TypeAlias = Annotated[
    Path | None, typer.Argument(help="A stance file (YAML); see docs/stance-files.md.")
]
RobotInstead: TypeAlias = Annotated[str | None, typer.Option(help="A known robot instead of a file.")]
RobotFeet: TypeAlias = Annotated[str | None, typer.Option(help="Foot frames of the robot, comma-separated.")]
SlopeUnder: TypeAlias = Annotated[
    float, typer.Option(help="Slope under the robot that rises along +x [deg].")
]
EveryFriction: TypeAlias = Annotated[
    float | None, typer.Option(help="Friction of every contact (robot: 0.6).")
]
Lifted: TypeAlias = Annotated[str | None, typer.Option(help="Contacts that are in the air, comma-separated.")]
Facets: TypeAlias = Annotated[str, typer.Option(help="Sides of friction pyramids, or 'exact'.")]
Fit: TypeAlias = Annotated[str, typer.Option(help="Pyramids inside or around the cones: inner or outer.")]
PictureOut: TypeAlias = Annotated[Path, typer.Option(help="Parent of the new folder for the picture.")]
AsJson: TypeAlias = Annotated[bool, typer.Option("--json", help="Print JSON and nothing else.")]
