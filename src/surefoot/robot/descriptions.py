"""Robots of the package robot_descriptions, MuJoCo's menagerie among them: names to files."""

from __future__ import annotations

import importlib
from importlib.util import find_spec
from pathlib import Path

from surefoot.errors import MissingExtra, ModelError, unknown_name

ENDING = "_description"


def is_described(name: str) -> bool:
    """Return whether a name is one of robot_descriptions', by its form: "go2_description"."""
    return name.endswith(ENDING) and "/" not in name


def described(name: str) -> Path:
    """Return the MJCF or URDF file of a description; the package fetches it when it does not have it.

    Raises
    ------
    MissingExtra
        If robot_descriptions is not installed.
    ModelError
        For a name that it does not have, or files that it cannot fetch.
    """
    if find_spec("robot_descriptions") is None:
        raise MissingExtra("robot_descriptions", "models")
    from robot_descriptions._descriptions import DESCRIPTIONS

    if name not in DESCRIPTIONS:
        raise ModelError(unknown_name("robot description", name, DESCRIPTIONS))
    try:
        module = importlib.import_module(f"robot_descriptions.{name}")
    except Exception as error:  # it clones a repository on import: anything may go wrong
        raise ModelError(f"robot_descriptions cannot bring {name}: {error}") from error
    for kind in ("MJCF_PATH", "URDF_PATH"):
        path = getattr(module, kind, None)
        if path is not None:
            return Path(path)
    raise ModelError(f"{name} has neither an MJCF nor a URDF file")
