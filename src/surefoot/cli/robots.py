"""The robot that a command is about: a known one, or a URDF file with its feet."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from surefoot.errors import ProblemError

DEFAULT = "go2"


def load(
    name: str | None,
    urdf: Path | None,
    feet: str | None,
    *,
    feet_needed: bool = False,
    fixed_base: bool | None = None,
) -> Any:
    """Return the robot of a name (None for `DEFAULT`), or of a URDF file.

    Raises
    ------
    ProblemError
        If both are given, or a file without the feet that the command needs.
    ModelError
        For an unknown or broken robot, or unknown feet.
    """
    from surefoot.cli import parsing
    from surefoot.robot import load_robot

    if urdf is not None and name is not None:
        raise ProblemError(f"give either a robot or --urdf, got both {name!r} and {urdf}")
    if urdf is not None and feet is None and feet_needed:
        raise ProblemError("--urdf needs --feet, the frames that touch the ground, e.g. --feet FL,FR,RL,RR")
    source = urdf.absolute() if urdf is not None else DEFAULT if name is None else name
    return load_robot(source, parsing.names("--feet", feet), fixed_base=fixed_base)
