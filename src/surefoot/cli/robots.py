"""The robot that a command is about: a known one, or a file with its feet."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from surefoot.errors import ProblemError

DEFAULT = "go2"
FILES = (".urdf", ".xml")
"""How files of robots end."""


def is_file(name: str | None) -> bool:
    """Tell whether a robot is named by a file."""
    return name is not None and name.lower().endswith(FILES)


def load(
    name: str | None, feet: str | None = None, *, feet_needed: bool = False, fixed_base: bool | None = None
) -> Any:
    """Return the robot of a name (None for `DEFAULT`), or of a URDF or MJCF file.

    Raises
    ------
    ProblemError
        For a file without the feet that the command needs.
    ModelError
        For an unknown or broken robot, or unknown feet.
    """
    from surefoot.cli import parsing
    from surefoot.robot import load_robot

    if is_file(name) and feet is None and feet_needed:
        raise ProblemError(f"{name} needs --feet, the frames that touch the ground, e.g. --feet FL,FR,RL,RR")
    source = DEFAULT if name is None else Path(name).absolute() if is_file(name) else name
    return load_robot(source, parsing.names("--feet", feet), fixed_base=fixed_base)
