"""The robot that a command is about: a known one, or a file with its feet."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from surefoot.app.cli import parsing
from surefoot.base.errors import ProblemError

DEFAULT = "go2"
FILES = (".urdf", ".xml")
"""How files of robots end."""
MOST_ENDS = 12
"""How many ends of limbs are named."""


def is_file(name: str | None) -> bool:
    """Tell whether a robot is named by a file."""
    return name is not None and name.lower().endswith(FILES)


def load(name: str | None, feet: str | None = None, *, feet_needed: bool = False) -> Any:
    """Return the robot of a name (None for `DEFAULT`), or of a URDF or MJCF file.

    Raises
    ------
    ProblemError
        For a file without the feet that the command needs.
    ModelError
        For an unknown or broken robot, or unknown feet.
    """
    from surefoot.mechanics import load_robot

    source = DEFAULT if name is None else Path(name).absolute() if is_file(name) else name
    robot = load_robot(source, parsing.names("--feet", feet))
    if feet_needed and robot.floating and not robot.feet:
        from surefoot.mechanics.robot.lint.lint import limb_ends

        ends = ", ".join(limb_ends(robot)[:MOST_ENDS])
        raise ProblemError(f"{name} needs --feet, the frames that touch the ground; its limbs end in {ends}")
    return robot
